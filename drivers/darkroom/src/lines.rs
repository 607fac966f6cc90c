//! The light of a mercury-argon lamp: lines far narrower than any pixel.

use std::sync::LazyLock;

use crate::spectrum::v_lambda;

/// Wavelength in air, nm, and power against the strongest. Hg I: Sansonetti, Salit, Reader, Appl. Opt. 35, 74 (1996);
/// Ar I: NIST Atomic Spectra Database. Powers as pencil lamps have them in kind.
const LINES: [(f64, f64); 33] = [
    (365.0158, 0.30),
    (365.4842, 0.10),
    (366.3284, 0.05),
    (404.6565, 0.45),
    (407.7837, 0.03),
    (433.9224, 0.015),
    (434.7506, 0.03),
    (435.8335, 1.00),
    (546.0750, 1.00),
    (576.9610, 0.12),
    (579.0670, 0.14),
    (696.5431, 0.10),
    (706.7218, 0.05),
    (714.7042, 0.005),
    (727.2936, 0.02),
    (738.3980, 0.08),
    (750.3869, 0.12),
    (751.4652, 0.06),
    (763.5106, 0.25),
    (772.3761, 0.08),
    (772.4207, 0.05),
    (794.8176, 0.08),
    (800.6157, 0.06),
    (801.4786, 0.06),
    (810.3693, 0.10),
    (811.5311, 0.20),
    (826.4522, 0.10),
    (840.8210, 0.10),
    (842.4648, 0.12),
    (852.1442, 0.08),
    (866.7944, 0.01),
    (912.2967, 0.15),
    (922.4499, 0.06),
];

/// 683·∫S·V dλ of the lines, in the unit of their power.
static LIGHT: LazyLock<f64> = LazyLock::new(|| LINES.iter().map(|(nm, power)| 683.0 * power * v_lambda(*nm)).sum());

/// Spectral irradiance of one lux of it at a pixel around `true_nm` that is `pixel_nm` wide, behind a slit whose image
/// is a triangle of `fwhm_nm`, W/(m² nm); `filter` is a transmittance. Without a slit a line falls on one pixel.
pub fn per_lux(true_nm: f64, pixel_nm: f64, fwhm_nm: f64, filter: impl Fn(f64) -> f64) -> f64 {
    let near = LINES.iter().filter(|(nm, _)| (nm - true_nm).abs() < fwhm_nm + pixel_nm);
    near.map(|(nm, power)| {
        let below = |edge_nm: f64| share_below(edge_nm - nm, fwhm_nm);
        let share = below(true_nm + 0.5 * pixel_nm) - below(true_nm - 0.5 * pixel_nm);
        power * filter(*nm) * share / (pixel_nm * *LIGHT)
    })
    .sum()
}

/// Share of a triangle of unit area and `fwhm_nm` around 0 that lies below `edge_nm`.
fn share_below(edge_nm: f64, fwhm_nm: f64) -> f64 {
    if fwhm_nm == 0.0 {
        return if edge_nm < 0.0 { 0.0 } else { 1.0 };
    }
    let t = (edge_nm / fwhm_nm).clamp(-1.0, 1.0);
    0.5 + t - 0.5 * t * t.abs()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_pixels_of_a_line_hold_its_power_around_its_wavelength() {
        for fwhm_nm in [0.0, 2.5] {
            let pixels = || (0..2300).map(|pixel| 520.1 + 0.03 * f64::from(pixel));
            let at = |nm: f64| per_lux(nm, 0.03, fwhm_nm, |_| 1.0) * 0.03;
            let power: f64 = pixels().map(at).sum();
            let centre = pixels().map(|nm| nm * at(nm)).sum::<f64>() / power;
            assert!((power * *LIGHT - 1.26).abs() < 1e-9, "{}", power * *LIGHT);
            let expected = (546.075 + 0.12 * 576.961 + 0.14 * 579.067) / 1.26;
            assert!((centre - expected).abs() < 0.02, "{centre} {expected}");
        }
    }
}
