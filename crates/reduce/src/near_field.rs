//! The limited photometric distance: what the inverse square law leaves out for a luminous area of a known diameter.

use isolux_photometry::IntensityDistribution;
use isolux_record::Station;

/// Why an intensity has no near field in its budget.
pub const NO_DIAMETER: &str = "the station states no lamp.diameter_mm: limited photometric distance";

/// Largest relative error of I = E·d² on the axis at `distance_mm`: that of a ring of the luminous diameter whose every
/// point radiates as the distribution does, (1 + R²/d²)^(−(n + 3)/2), n being the exponent of the cosⁿ lobe of the same
/// beam angle. None where the station states no diameter.
///
/// The flux has no such part: what crosses a closed surface around the lamp does not depend on its size.
pub fn largest_rel(station: &Station, distribution: &IntensityDistribution, distance_mm: f64) -> Option<f64> {
    let diameter_mm = station.lamp()?.diameter_mm?;
    let radius2 = (0.5 * diameter_mm / distance_mm).powi(2);
    Some(-(-0.5 * (distribution.lobe_exponent() + 3.0) * radius2.ln_1p()).exp_m1())
}

/// Standard uncertainty of a relative error that lies anywhere up to `largest_rel`.
pub fn standard(largest_rel: f64) -> f64 {
    largest_rel / 3.0_f64.sqrt()
}
