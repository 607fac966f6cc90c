//! What rings say of the symmetry that the half-planes of a block assume.

use isolux_photometry::{Asymmetry, Circle, Ring};
use isolux_record::plan::Block;

use super::swept::Swept;

/// The sentence; none where no ring was asked for, or none has light all round.
pub fn note(block: &Block, around: &[Swept<'_>]) -> Option<String> {
    let most_rel = block.symmetry_max_rel?;
    let symmetry = Circle::of(&block.half_planes_deg(&block.c_deg)).ok()?.assumed;
    let rings: Vec<(Ring, f64)> = around
        .iter()
        .filter_map(|swept| Some((swept.ring()?, swept.sign())))
        .collect();
    let rings: Vec<(&Ring, f64)> = rings.iter().map(|(ring, sign)| (ring, *sign)).collect();
    let found = Asymmetry::of(&rings, symmetry)?;
    let gammas: Vec<String> = rings.iter().map(|(ring, _)| format!("{}°", ring.gamma_deg)).collect();
    let seen = Asymmetry::narrowest_deg(most_rel).map_or_else(String::new, |deg| {
        format!("; a dip of 5 % would have been seen from {deg:.1}° of C on")
    });
    Some(format!(
        "symmetry {} was looked at by rings at γ {}: they differ from it by at most {:.2} % of the largest light, \
         at C {}°, γ {}°; the plan allows {:.2} %{seen}",
        symmetry.words(),
        gammas.join(", "),
        100.0 * found.largest_rel,
        found.c_deg,
        found.gamma_deg,
        100.0 * most_rel
    ))
}
