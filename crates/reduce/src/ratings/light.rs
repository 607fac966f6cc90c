//! What the spectrum says beside the colour: distance from a rated colour, photons, blue-light hazard.

use std::borrow::Cow;
use std::collections::BTreeSet;

use isolux_record::Run;
use isolux_spectrum::Chromaticity;
use isolux_spectrum::action::{E_B_LIMIT_W_M2, threshold_illuminance_lx};
use isolux_spectrum::steps::{STEP_UV, target};

use crate::colour::Colour;
use crate::{Quantity, Reduction};

/// What a flux of photons lacks where one direction was measured.
const ONE_DIRECTION: &str = "the spectrum of the axis is taken for that of all directions";

/// Colour of all the light where it was measured over angle, or of the axis; and whether it is of all.
fn colour_of(reduction: &Reduction) -> Option<(&Colour, bool)> {
    let whole = reduction.over_angle.as_ref().map(|of| (&of.facts.total.colour, true));
    whole.or_else(|| reduction.spectral.as_ref().map(|of| (&of.colour, false)))
}

/// How far the light is from its rated colour.
#[derive(Debug, Clone, PartialEq)]
pub struct RatedColour {
    /// Distance in (u′, v′) in steps of 0.0011 (CIE TN 001).
    pub steps: Quantity,
    /// What it is compared with.
    pub with: String,
    /// Whether it is the colour of all the light, not of the axis.
    pub of_all: bool,
}

/// The distance from the rated colour; none where the job rates none, or no spectrum was taken.
pub fn rated_colour(reduction: &Reduction, run: &Run) -> Option<RatedColour> {
    let ratings = &run.header.ratings;
    let (with, rated) = match (ratings.rated_cct_k, ratings.rated_xy) {
        (Some(cct_k), _) => {
            let target = target(cct_k)?;
            (format!("the {} of {cct_k} K", target.name), target.chromaticity)
        }
        (None, Some([x, y])) => (format!("x {x}, y {y}"), Chromaticity { x, y }),
        (None, None) => return None,
    };
    let (colour, of_all) = colour_of(reduction)?;
    let steps = steps_from(colour.u_prime.as_ref()?, colour.v_prime.as_ref()?, rated.uv_1976());
    Some(RatedColour { steps, with, of_all })
}

/// Distance of a measured chromaticity from (u′, v′) in steps of 0.0011 (CIE TN 001). u′ and v′ share their causes, and
/// whether these move both to or from the rated colour is not kept: of every cause both are taken to move it the same
/// way, which is never too little.
pub fn steps_from(u_prime: &Quantity, v_prime: &Quantity, (u, v): (f64, f64)) -> Quantity {
    let (du, dv) = (u_prime.value - u, v_prime.value - v);
    let distance = du.hypot(dv);
    // At the rated colour itself a move in any direction leads away from it.
    let (along_u, along_v) = if distance > 0.0 {
        (du.abs() / distance, dv.abs() / distance)
    } else {
        (1.0, 1.0)
    };
    let names: BTreeSet<Cow<'static, str>> = u_prime.parts.keys().chain(v_prime.parts.keys()).cloned().collect();
    let part = |of: &Quantity, name: &str| of.parts.get(name).copied().unwrap_or(0.0);
    let parts = names.into_iter().map(|name| {
        let moved = along_u * part(u_prime, &name) + along_v * part(v_prime, &name);
        (name, moved / STEP_UV)
    });
    let missing = u_prime.missing.iter().chain(&v_prime.missing).cloned();
    Quantity::new(distance / STEP_UV, "steps", parts).lacking(missing)
}

/// Photons of 400–700 nm in all directions, µmol/s; none without a spectrum.
pub fn photon_flux(reduction: &Reduction) -> Option<Quantity> {
    let (colour, of_all) = colour_of(reduction)?;
    let per_klm = colour.photons.as_ref()?.times(1e-3, "µmol/s/lm");
    let lacking = (!of_all).then(|| ONE_DIRECTION.to_owned());
    Some(reduction.flux.by(&per_klm, "µmol/s", "spectrum").lacking(lacking))
}

/// From where on the light is of no higher risk group than 1 for its blue light.
#[derive(Debug, Clone, PartialEq)]
pub struct HazardDistance {
    /// K_B,v in mW/lm.
    pub k_bv: Quantity,
    /// E_thr in lx.
    pub threshold: Quantity,
    /// Where the largest intensity makes that illuminance, in m.
    pub distance: Quantity,
    /// Whether K_B,v is that of all the light, not of the axis.
    pub of_all: bool,
}

/// The distance at which the largest intensity makes the threshold illuminance (IEC TR 62778); none without a spectrum,
/// or without light in the blue.
pub fn hazard_distance(reduction: &Reduction) -> Option<HazardDistance> {
    let (colour, of_all) = colour_of(reduction)?;
    let k_bv = colour.k_bv.clone().filter(|k_bv| k_bv.value > 0.0)?;
    let threshold_lx = threshold_illuminance_lx(1e-3 * k_bv.value);
    let relative = k_bv.parts.iter().map(|(name, part)| (name.clone(), part / k_bv.value));
    let relative: Vec<_> = relative.collect();
    let of_threshold = relative.iter().map(|(name, part)| (name.clone(), part * threshold_lx));
    let threshold = Quantity::new(threshold_lx, "lx", of_threshold).lacking(k_bv.missing.iter().cloned());
    // d = √(I·K_B,v/E_B): half of the relative uncertainties.
    let i_max = &reduction.i_max;
    let distance_m = (i_max.value.max(0.0) * 1e-3 * k_bv.value / E_B_LIMIT_W_M2).sqrt();
    let spectrum = 0.5 * distance_m * k_bv.u_of_parts_rel();
    let of_intensity = i_max
        .parts
        .iter()
        .map(|(name, part)| (name.clone(), 0.5 * distance_m * part / i_max.value));
    let distance = Quantity::new(distance_m, "m", of_intensity)
        .with_part("spectrum", spectrum)
        .lacking(i_max.missing.iter().chain(&k_bv.missing).cloned());
    Some(HazardDistance {
        k_bv,
        threshold,
        distance,
        of_all,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn steps_and_their_uncertainty_are_along_the_way_to_the_rated_colour() {
        let rated = Chromaticity { x: 0.4369, y: 0.4041 };
        let (u, v) = rated.uv_1976();
        let away = |du: f64, dv: f64| {
            let u_prime = Quantity::new(u + du, "", [("noise", 1e-4), ("wavelength", 2e-4)]);
            let v_prime = Quantity::new(v + dv, "", [("noise", 3e-4)]);
            steps_from(&u_prime, &v_prime, (u, v))
        };
        // 2.2 · 10⁻³ along u′ alone: two steps, of which v′ moves none.
        let along_u = away(0.0022, 0.0);
        assert!((along_u.value - 2.0).abs() < 1e-9, "{along_u:?}");
        assert!((along_u.parts["noise"] - 1e-4 / 0.0011).abs() < 1e-9, "{along_u:?}");
        let both = away(0.0033, 0.0044);
        assert!((both.value - 5.0).abs() < 1e-9);
        assert!(
            (both.parts["noise"] - (0.6e-4 + 2.4e-4) / 0.0011).abs() < 1e-9,
            "{both:?}"
        );
        assert!((both.parts["wavelength"] - 1.2e-4 / 0.0011).abs() < 1e-9);
        let at = away(0.0, 0.0);
        assert!(at.value == 0.0 && at.u_of_parts > 0.3, "{at:?}");
        let lacking = steps_from(
            &Quantity::new(u, "", [("noise", 1e-4)]).lacking(["x".to_owned()]),
            &along_u,
            (u, v),
        );
        assert_eq!(lacking.u, None);
    }
}
