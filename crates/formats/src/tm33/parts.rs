//! What both editions write alike.

use isolux_photometry::Symmetry;

use crate::distribution::Distribution;
use crate::xml::escaped;

/// An element in a child of the root; none without text.
pub(super) fn element(name: &str, text: &str) -> Option<String> {
    (!text.is_empty()).then(|| format!("    <{name}>{}</{name}>", escaped(text)))
}

/// Planes to write, and whether C0 is repeated at 360°.
pub(super) fn stored(distribution: &Distribution) -> (Vec<usize>, bool) {
    let grid = &distribution.intensity;
    let c_deg = grid.c_deg();
    let has = |angle: f64| c_deg.contains(&angle);
    let within = |from: f64, to: f64| {
        (0..c_deg.len())
            .filter(|&plane| (from..=to).contains(&c_deg[plane]))
            .collect()
    };
    match grid.detect_symmetry(grid.peak().intensity_cd.abs() * 1e-9) {
        Symmetry::Rotational => (vec![0], false),
        Symmetry::Quadrant if has(0.0) && has(90.0) => (within(0.0, 90.0), false),
        Symmetry::C0C180 if has(0.0) && has(180.0) => (within(0.0, 180.0), false),
        Symmetry::C90C270 if has(90.0) && has(270.0) => (within(90.0, 270.0), false),
        _ => ((0..c_deg.len()).collect(), has(0.0)),
    }
}
