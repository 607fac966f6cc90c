//! Illuminance of one linear count a second in each pixel.

use isolux_scan::spectrum::factors_at;
use isolux_spectrum::cie::{FIRST_NM, K_M_LM_PER_W, V_LAMBDA};

/// Share of ∫V dλ that the calibration must cover.
const COVERED: f64 = 0.999;

/// Illuminance of one linear count a second in each pixel, lx: 683 lm/W · V(λ) · factor · width of the pixel, by
/// trapezia. `wavelength_nm` rises; `factor` is in W/(m²·nm).
///
/// # Errors
/// What of V(λ) the pixels and their factors do not cover.
pub(super) fn of(wavelength_nm: &[f64], factor: &[f64]) -> Result<Vec<f64>, String> {
    let table: Vec<(f64, f64)> = (FIRST_NM..).map(|nm| nm as f64).zip(V_LAMBDA).collect();
    let last = wavelength_nm.len().saturating_sub(1);
    let seen: Vec<f64> = factors_at(wavelength_nm, &table)
        .into_iter()
        .enumerate()
        .map(|(pixel, v)| {
            let width_nm = wavelength_nm[(pixel + 1).min(last)] - wavelength_nm[pixel.saturating_sub(1)];
            0.5 * width_nm * v
        })
        .collect();
    let calibrated = seen.iter().zip(factor).filter(|(_, factor)| **factor > 0.0);
    let covered = calibrated.map(|(seen, _)| seen).sum::<f64>() / V_LAMBDA.iter().sum::<f64>();
    if covered < COVERED {
        return Err(format!(
            "its calibration covers {:.1} % of V(λ): no illuminance follows from it",
            100.0 * covered
        ));
    }
    let weights = seen.iter().zip(factor);
    Ok(weights.map(|(seen, factor)| K_M_LM_PER_W * seen * factor).collect())
}

#[cfg(test)]
mod tests {
    use isolux_spectrum::Spectrum;

    use super::*;

    #[test]
    fn the_weighted_sum_is_the_integral_of_the_spectrum() {
        let wavelength_nm: Vec<f64> = (0..2048)
            .map(f64::from)
            .map(|pixel| 339.26 + pixel * (0.3794 + pixel * (-1.532e-5 - 1.91e-9 * pixel)))
            .collect();
        let factor: Vec<f64> = wavelength_nm
            .iter()
            .map(|nm| 1e-6 * (1.0 + (nm - 560.0) / 900.0))
            .collect();
        let weights = of(&wavelength_nm, &factor).unwrap();
        // A chip and its phosphor, in counts a second.
        let counts =
            |nm: f64| 9000.0 * (-((nm - 457.0) / 14.0).powi(2)).exp() + 5000.0 * (-((nm - 570.0) / 60.0).powi(2)).exp();
        let sum: f64 = wavelength_nm
            .iter()
            .zip(&weights)
            .map(|(nm, weight)| counts(*nm) * weight)
            .sum();
        let irradiance = wavelength_nm
            .iter()
            .zip(&factor)
            .map(|(nm, factor)| counts(*nm) * factor);
        let spectrum = Spectrum::new(wavelength_nm.clone(), irradiance.collect()).unwrap();
        let expected = spectrum.luminous_integral();
        assert!((sum / expected - 1.0).abs() < 1e-4, "{sum} {expected}");
    }

    #[test]
    fn a_calibration_that_ends_in_the_visible_is_refused() {
        let wavelength_nm: Vec<f64> = (350..850).map(f64::from).collect();
        let ends_at = |end_nm: f64| -> Vec<f64> {
            wavelength_nm
                .iter()
                .map(|nm| if *nm < end_nm { 1e-6 } else { 0.0 })
                .collect()
        };
        assert!(of(&wavelength_nm, &ends_at(720.0)).is_ok());
        let refused = of(&wavelength_nm, &ends_at(650.0)).unwrap_err();
        assert!(refused.contains("% of V(λ)"), "{refused}");
    }
}
