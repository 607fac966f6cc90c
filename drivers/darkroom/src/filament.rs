//! The light of a hot filament: Planck's law times an emissivity like that of tungsten, and what its current does to
//! it.

/// Second radiation constant hc/k (exact since the SI of 2019), nm·K.
const C2_NM_K: f64 = 1.438_776_877e7;

/// Relative change of the temperature for one of the current: T ∝ I^0.7. Of incandescent lamps T ∝ V^0.37 and I ∝
/// V^0.54 (exponents of the IES Lighting Handbook).
const TEMPERATURE_OVER_CURRENT: f64 = 0.7;

/// Temperature of a filament that has `temperature_k` at its rated current, at a current that is off by
/// `current_error_rel`, K.
pub fn temperature_at(temperature_k: f64, current_error_rel: f64) -> f64 {
    temperature_k * (1.0 + current_error_rel).powf(TEMPERATURE_OVER_CURRENT)
}

/// Spectral radiance of a filament at `temperature_k`, in a unit of its own that does not depend on the temperature.
pub fn radiance(wavelength_nm: f64, temperature_k: f64) -> f64 {
    let planck = (1000.0 / wavelength_nm).powi(5) / (C2_NM_K / (wavelength_nm * temperature_k)).exp_m1();
    emissivity(wavelength_nm) * planck
}

/// Falls from 0.46 in the blue to 0.37 at 1 µm, as that of tungsten does in kind.
fn emissivity(wavelength_nm: f64) -> f64 {
    0.33 + 0.15 * (-(wavelength_nm / 900.0).powi(2)).exp()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_little_more_current_is_much_more_blue_light() {
        let hot = temperature_at(3000.0, 1e-3);
        let more = |nm: f64| radiance(nm, hot) / radiance(nm, 3000.0) - 1.0;
        // dE/E = c₂/(λT)·dT/T where Wien's law holds: 0.07 % of the temperature.
        for (nm, expected) in [(400.0, 0.7e-3 * 11.99), (700.0, 0.7e-3 * 6.85)] {
            assert!(
                (more(nm) / expected - 1.0).abs() < 0.01,
                "{nm}: {} {expected}",
                more(nm)
            );
        }
    }

    #[test]
    fn it_peaks_where_wien_says_as_far_as_the_emissivity_lets_it() {
        let peak = (400..2000)
            .map(f64::from)
            .max_by(|a, b| radiance(*a, 2900.0).total_cmp(&radiance(*b, 2900.0)))
            .unwrap();
        assert!((900.0..1000.0).contains(&peak), "{peak}");
    }
}
