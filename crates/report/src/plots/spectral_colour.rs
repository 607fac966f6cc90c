//! How a wavelength looks on a screen: an sRGB colour for fills, not for measuring.

use isolux_spectrum::{Chromaticity, cie};

/// CSS colour of a wavelength in nm; grey outside 380–780 nm.
pub(super) fn of_wavelength(nm: f64) -> String {
    const INVISIBLE: f64 = 0.62;
    let i = ((nm - cie::FIRST_NM as f64).max(0.0) as usize).min(cie::X_BAR.len() - 1);
    let (x, y, z) = (cie::X_BAR[i], cie::V_LAMBDA[i], cie::Z_BAR[i]);
    let sum = x + y + z;
    // Fades into grey where the eye fades out.
    let visible = if (380.0..=780.0).contains(&nm) {
        (0.25 * (sum / 0.002).ln()).clamp(0.0, 1.0)
    } else {
        0.0
    };
    let rgb = if sum > 0.0 {
        linear_rgb(x / sum, y / sum)
    } else {
        [1.0; 3]
    };
    css(rgb.map(|c| visible * c + (1.0 - visible) * INVISIBLE))
}

/// sRGB bytes of a chromaticity at the greatest brightness that the screen has.
pub(super) fn bytes_of(c: Chromaticity) -> [u8; 3] {
    encoded(linear_rgb(c.x, c.y))
}

/// Linear sRGB, outside its triangle drawn in to the border, brightest channel 1.
fn linear_rgb(x: f64, y: f64) -> [f64; 3] {
    let (x, y, z) = (x, y.max(1e-6), 1.0 - x - y);
    let rgb = [
        3.2406 * x - 1.5372 * y - 0.4986 * z,
        -0.9689 * x + 1.8758 * y + 0.0415 * z,
        0.0557 * x - 0.2040 * y + 1.0570 * z,
    ];
    let low = rgb.iter().copied().fold(0.0, f64::min);
    let rgb = rgb.map(|c| c - 0.2 * low).map(|c| c.max(0.0));
    let high = rgb.iter().copied().fold(1e-9, f64::max);
    rgb.map(|c| c / high)
}

fn css(linear: [f64; 3]) -> String {
    let [r, g, b] = encoded(linear);
    format!("#{r:02x}{g:02x}{b:02x}")
}

fn encoded(linear: [f64; 3]) -> [u8; 3] {
    linear.map(|c| {
        let c = c.clamp(0.0, 1.0);
        let encoded = if c <= 0.003_130_8 {
            12.92 * c
        } else {
            1.055 * c.powf(1.0 / 2.4) - 0.055
        };
        (255.0 * encoded).round() as u8
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn red_is_red_and_ultraviolet_is_grey() {
        let channel = |s: &str, k: usize| u8::from_str_radix(&s[1 + 2 * k..3 + 2 * k], 16).unwrap();
        let red = of_wavelength(640.0);
        assert!(channel(&red, 0) > 200 && channel(&red, 1) < 120, "{red}");
        let blue = of_wavelength(455.0);
        assert!(channel(&blue, 2) > 200 && channel(&blue, 1) < 120, "{blue}");
        let uv = of_wavelength(250.0);
        assert_eq!((channel(&uv, 0), channel(&uv, 1)), (channel(&uv, 2), channel(&uv, 2)));
        assert_eq!(bytes_of(Chromaticity { x: 0.3127, y: 0.3290 }), [255; 3]);
    }
}
