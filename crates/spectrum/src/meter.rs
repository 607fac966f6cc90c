//! How well a meter's responsivity matches V(λ): f1′ and spectral mismatch (CIE S 023, ISO/CIE 19476).

use crate::illuminant::illuminant_a;
use crate::per_nm::per_nm;
use crate::{Spectrum, cie};

/// General V(λ) mismatch index f1′ of a relative responsivity, as a fraction (0.015 is 1.5 %), calibrated with
/// illuminant A; none where the responsivity does not answer illuminant A.
pub fn f1_prime(responsivity: &Spectrum) -> Option<f64> {
    let s = responsivity.per_nm();
    let a = illuminant_a();
    let seen = product(&a, &s);
    let ideal = product(&a, &cie::V_LAMBDA);
    (seen > 0.0).then(|| {
        s.iter()
            .zip(&cie::V_LAMBDA)
            .map(|(s, v)| (s * ideal / seen - v).abs())
            .sum::<f64>()
            / cie::V_LAMBDA.iter().sum::<f64>()
    })
}

/// Why there is no spectral mismatch correction factor.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
pub enum NoMismatch {
    /// ∫S_C s dλ is not above zero.
    #[error("the meter does not see the light of its calibration")]
    CalibrationUnseen,
    /// ∫S_Z V dλ is not above zero.
    #[error("the source has no visible light")]
    SourceDark,
    /// ∫S_C V dλ is not above zero.
    #[error("the light of the calibration has no visible light")]
    CalibrationDark,
    /// ∫S_Z s dλ is not above zero.
    #[error("the meter does not see the source")]
    SourceUnseen,
}

/// Spectral mismatch correction factor F of a meter calibrated under `calibration` that reads `source`: true = F ×
/// reading.
///
/// F = (∫S_C s · ∫S_Z V) / (∫S_C V · ∫S_Z s).
///
/// # Errors
/// [`NoMismatch`] where an integral is not above zero.
pub fn spectral_mismatch(
    source: &Spectrum,
    calibration: &Spectrum,
    responsivity: &Spectrum,
) -> Result<f64, NoMismatch> {
    // Both may be finer than 1 nm: their product is integrated, not the product of what each has in a nanometre.
    let seen = |light: &Spectrum| per_nm(&[light, responsivity]).iter().sum::<f64>();
    let visible = |light: &Spectrum| product(&light.per_nm(), &cie::V_LAMBDA);
    let light = |integral: f64, none: NoMismatch| if integral > 0.0 { Ok(integral) } else { Err(none) };
    let above =
        light(seen(calibration), NoMismatch::CalibrationUnseen)? * light(visible(source), NoMismatch::SourceDark)?;
    let below =
        light(visible(calibration), NoMismatch::CalibrationDark)? * light(seen(source), NoMismatch::SourceUnseen)?;
    Ok(above / below)
}

fn product(a: &[f64; 471], b: &[f64; 471]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::illuminant::{daylight, illuminant_a};

    fn spectrum(of: impl Fn(f64) -> f64) -> Spectrum {
        Spectrum::from_1_nm(&std::array::from_fn(|i| of(360.0 + i as f64))).unwrap()
    }

    #[test]
    fn a_perfect_meter_has_no_mismatch() {
        let v = Spectrum::from_1_nm(&cie::V_LAMBDA).unwrap();
        let (a, d) = (
            Spectrum::from_1_nm(&illuminant_a()).unwrap(),
            Spectrum::from_1_nm(&daylight(6504.0).unwrap()).unwrap(),
        );
        assert!(f1_prime(&v.scaled(3.0).unwrap()).unwrap() < 1e-12);
        assert!((spectral_mismatch(&d, &a, &v).unwrap() - 1.0).abs() < 1e-12);
    }

    #[test]
    fn a_flat_detector_reads_a_blue_line_too_high_by_its_lack_of_v() {
        let flat = spectrum(|_| 1.0);
        let (blue, green) = (
            Spectrum::new(vec![449.0, 450.0, 451.0], vec![0.0, 1.0, 0.0]).unwrap(),
            Spectrum::new(vec![554.0, 555.0, 556.0], vec![0.0, 1.0, 0.0]).unwrap(),
        );
        // Calibrated where V = 1, it reads 450 nm as if V were 1 there too; V(450) = 0.038.
        let f = spectral_mismatch(&blue, &green, &flat).unwrap();
        assert!((f - 0.038).abs() < 1e-12, "{f}");
        assert!(f1_prime(&flat).unwrap() > 0.5);
    }

    #[test]
    fn what_a_meter_does_not_see_has_no_factor() {
        let a = Spectrum::from_1_nm(&illuminant_a()).unwrap();
        let uv = Spectrum::new(vec![200.0, 300.0], vec![1.0, 1.0]).unwrap();
        let blue = Spectrum::new(vec![400.0, 450.0], vec![1.0, 1.0]).unwrap();
        let red = Spectrum::new(vec![600.0, 700.0], vec![1.0, 1.0]).unwrap();
        assert_eq!(spectral_mismatch(&a, &a, &uv), Err(NoMismatch::CalibrationUnseen));
        assert_eq!(spectral_mismatch(&uv, &a, &blue), Err(NoMismatch::SourceDark));
        assert_eq!(spectral_mismatch(&red, &a, &blue), Err(NoMismatch::SourceUnseen));
    }

    #[test]
    fn a_shifted_v_has_the_index_of_its_integral() {
        // Independent value: numpy, V shifted by +2 nm by linear interpolation, CIE A, 1 nm sums (tables/generate.py's
        // data).
        let shifted = spectrum(|nm| Spectrum::from_1_nm(&cie::V_LAMBDA).unwrap().at_nm(nm - 2.0));
        let f = f1_prime(&shifted).unwrap();
        assert!((0.03..0.05).contains(&f), "{f}");
    }
}
