//! How much of a distribution a picture shows.

use isolux_photometry::IntensityDistribution;

/// Whether light goes above γ = 90°: more than 0.5 % of the largest intensity.
pub fn upper_light(distribution: &IntensityDistribution) -> bool {
    let peak = distribution.peak().intensity_cd;
    distribution.c_deg().iter().enumerate().any(|(plane, _)| {
        distribution
            .gamma_deg()
            .iter()
            .zip(distribution.row(plane))
            .any(|(g, v)| *g > 90.0 && *v > 0.005 * peak)
    })
}

/// The largest γ that a picture needs: the data's own, or 90° where nothing is above.
pub fn shown_gamma(distribution: &IntensityDistribution) -> f64 {
    let last = distribution.gamma_deg().last().copied().unwrap_or(180.0);
    if upper_light(distribution) {
        last
    } else {
        last.min(90.0)
    }
}

/// Whether all planes are alike to a millionth of the largest intensity.
pub fn alike(distribution: &IntensityDistribution) -> bool {
    let near = 1e-6 * distribution.peak().intensity_cd.abs();
    (1..distribution.c_deg().len()).all(|plane| {
        let rows = distribution.row(plane).iter().zip(distribution.row(0));
        rows.into_iter().all(|(a, b)| (a - b).abs() <= near)
    })
}
