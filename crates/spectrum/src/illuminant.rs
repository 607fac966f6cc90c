//! Reference illuminants at 1 nm over 360–830 nm: Planckian radiators, CIE daylight, CIE A.

use crate::tables::{DAYLIGHT_S0, DAYLIGHT_S1, DAYLIGHT_S2};
use crate::{Chromaticity, Spectrum, Tristimulus, cie};

/// Second radiation constant in m·K as ITS-90 and CIE 15 have it.
pub(crate) const C2_M_K: f64 = 1.4388e-2;

/// 360, 361, … 830 nm.
pub(crate) fn wavelengths_nm() -> impl Iterator<Item = f64> {
    (cie::FIRST_NM..=cie::LAST_NM).map(|nm| nm as f64)
}

/// Planckian radiator at `temperature_k`, 1 at 560 nm.
pub fn planck(temperature_k: f64) -> [f64; 471] {
    let mut out = [0.0; 471];
    let radiance = |nm: f64| nm.powi(-5) / (C2_M_K / (nm * 1e-9 * temperature_k)).exp_m1();
    let norm = radiance(560.0);
    for (o, nm) in out.iter_mut().zip(wavelengths_nm()) {
        *o = radiance(nm) / norm;
    }
    out
}

/// CIE daylight of a correlated colour temperature of 4000–25 000 K (CIE 15:2018, 4.1.2), the components linear between
/// their tabulated points; none outside that range.
pub fn daylight(temperature_k: f64) -> Option<[f64; 471]> {
    let t = 1e3 / temperature_k;
    let x = match temperature_k {
        4000.0..=7000.0 => -4.6070 * t.powi(3) + 2.9678 * t.powi(2) + 0.09911 * t + 0.244063,
        7000.0..=25000.0 => -2.0064 * t.powi(3) + 1.9018 * t.powi(2) + 0.24748 * t + 0.237040,
        _ => return None,
    };
    let y = -3.0 * x * x + 2.87 * x - 0.275;
    let m = 0.0241 + 0.2562 * x - 0.7341 * y;
    let (m1, m2) = (
        (-1.3515 - 1.7703 * x + 5.9114 * y) / m,
        (0.0300 - 31.4424 * x + 30.0717 * y) / m,
    );
    let mut out = [0.0; 471];
    for (o, nm) in out.iter_mut().zip(wavelengths_nm()) {
        let at = |s: &[f64; 107]| {
            let (i, part) = (((nm - 300.0) / 5.0) as usize, ((nm - 300.0) % 5.0) / 5.0);
            let after = s.get(i + 1).unwrap_or(&s[i]);
            s[i] + part * (after - s[i])
        };
        *o = at(&DAYLIGHT_S0) + m1 * at(&DAYLIGHT_S1) + m2 * at(&DAYLIGHT_S2);
    }
    Some(out)
}

/// CIE standard illuminant A (ISO/CIE 11664-2), 1 at 560 nm.
pub fn illuminant_a() -> [f64; 471] {
    let mut out = [0.0; 471];
    for (o, nm) in out.iter_mut().zip(wavelengths_nm()) {
        *o = (560.0 / nm).powi(5) * (1.435e7_f64 / (2848.0 * 560.0)).exp_m1() / (1.435e7 / (2848.0 * nm)).exp_m1();
    }
    out
}

/// Chromaticity of the Planckian radiator at `temperature_k`.
pub fn planckian_chromaticity(temperature_k: f64) -> Option<Chromaticity> {
    Tristimulus::of_1_nm(&planck(temperature_k)).chromaticity()
}

impl Spectrum {
    /// A spectrum from values at 360, 361, … 830 nm; none where a value is not finite.
    pub fn from_1_nm(value: &[f64; 471]) -> Option<Self> {
        Self::new(wavelengths_nm().collect(), value.to_vec()).ok()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn illuminant_a_is_a_planckian_of_2856_k() {
        let (a, p) = (illuminant_a(), planck(2848.0 * 1.4388 / 1.4350));
        for (a, p) in a.iter().zip(&p) {
            assert!((a / p - 1.0).abs() < 1e-9);
        }
    }

    #[test]
    fn daylight_is_the_table_of_d65() {
        // CIE 15:2018 table T.1: D65 at 450, 560, 700 nm, T = 6500·1.4388/1.4380 K.
        let d65 = daylight(6500.0 * 1.4388 / 1.4380).unwrap();
        let at = |nm: usize| 100.0 * d65[nm - 360] / d65[200];
        assert!((at(450) - 117.008).abs() < 0.02, "{}", at(450));
        assert!((at(700) - 71.6091).abs() < 0.02, "{}", at(700));
        assert_eq!(daylight(3999.0), None);
    }
}
