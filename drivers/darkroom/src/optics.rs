//! Surfaces before a detector: plates of glass, cosine receivers.

/// Transmittance of `plates` parallel plates of index `index` for unpolarized light at the incidence cosine `cos`, with
/// all reflections between their 2·`plates` faces summed (Stokes 1862; Born & Wolf §1.6.4): T = (1 − R)/(1 + (2m − 1)R)
/// for each polarization, R from Fresnel's equations.
pub fn plates_transmittance(plates: f64, index: f64, cos: f64) -> f64 {
    if plates == 0.0 {
        return 1.0;
    }
    let cos = cos.clamp(1e-9, 1.0);
    let inside = (1.0 - (1.0 - cos * cos) / (index * index)).sqrt();
    let pile = |amplitude: f64| {
        let r = amplitude * amplitude;
        (1.0 - r) / (1.0 + (2.0 * plates - 1.0) * r)
    };
    let s = pile((cos - index * inside) / (cos + index * inside));
    let p = pile((index * cos - inside) / (index * cos + inside));
    0.5 * (s + p)
}

/// Factor of a receiver whose directional response departs from the cosine by `at_60` (relative) at 60° incidence.
pub fn directional_response(at_60: f64, cos: f64) -> f64 {
    1.0 + at_60 * (1.0 - cos) / 0.5
}

/// Share of partly polarized light that a polarization-sensitive receiver takes when the lamp's plane of polarization
/// is rolled by `roll` (rad) before it: Jones vectors through the receiver's two transmittances, normalized to 1 on
/// average.
pub fn polarized_response(amplitude: f64, roll: f64) -> f64 {
    let through = |power: f64, angle: f64| {
        let (along, across) = (angle.cos(), angle.sin());
        power * ((1.0 + amplitude) * along * along + (1.0 - amplitude) * across * across)
    };
    through(1.0, roll)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// One plate of n = 1.52 at normal incidence: R = (0.52/2.52)², T = (1 − R)/(1 + R) = 2n/(n² + 1).
    #[test]
    fn plates_follow_fresnel() {
        assert!((plates_transmittance(1.0, 1.52, 1.0) - 2.0 * 1.52 / (1.52f64.powi(2) + 1.0)).abs() < 1e-12);
        // Brewster's angle: p passes whole, s as published for one plate.
        let brewster = 1.52f64.atan();
        let r_s = (brewster.cos() - 1.52 * (std::f64::consts::FRAC_PI_2 - brewster).cos())
            / (brewster.cos() + 1.52 * (std::f64::consts::FRAC_PI_2 - brewster).cos());
        let s = (1.0 - r_s * r_s) / (1.0 + r_s * r_s);
        assert!((plates_transmittance(1.0, 1.52, brewster.cos()) - 0.5 * (1.0 + s)).abs() < 1e-12);
        assert_eq!(plates_transmittance(0.0, 1.52, 0.3), 1.0);
    }
}
