//! A spectrum over wavelength, filled with the colours of its wavelengths.

use isolux_spectrum::Spectrum;

use super::spectral_colour;
use crate::axes::{Frame, Scale};
use crate::svg::{Anchor, HEIGHT, Stroke, Svg, WIDTH, colour};

/// What a spectrum's picture says.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct SpectrumOptions {
    /// Text above the picture.
    pub title: String,
    /// What the values are, with their unit: "spectral irradiance in W/(m²·nm)". Empty: "relative".
    pub value_label: String,
}

/// Values over wavelength, the area under them in the colours of the wavelengths (grey where the eye is blind).
pub fn spectrum(spectrum: &Spectrum, options: &SpectrumOptions) -> String {
    filled(spectrum, options, spectrum.value()).0.finish()
}

/// The same with another spectrum beside it, of the same lumens, as a dashed line; `names` of both.
pub fn spectrum_beside(spectrum: &Spectrum, other: &Spectrum, options: &SpectrumOptions, names: [&str; 2]) -> String {
    let scale = spectrum.luminous_integral() / other.luminous_integral();
    let values: Vec<f64> = other.value().iter().map(|value| scale * value).collect();
    let all: Vec<f64> = spectrum.value().iter().chain(&values).copied().collect();
    let (mut svg, frame) = filled(spectrum, options, &all);
    let (first, last) = frame.x.range();
    let within = other.wavelength_nm().iter().zip(&values);
    let within = within.filter(|(nm, _)| (first..=last).contains(*nm));
    let beside = Stroke::dashed(colour::C0, 1.6);
    svg.polyline(within.map(|(nm, value)| frame.at(*nm, *value)), beside);
    for (k, (stroke, name)) in [Stroke::solid(colour::INK, 1.6), beside]
        .into_iter()
        .zip(names)
        .enumerate()
    {
        let (x, y) = (frame.left + 190.0 * k as f64, HEIGHT - 10.0);
        svg.line((x, y - 4.5), (x + 34.0, y - 4.5), stroke);
        svg.text((x + 42.0, y), Anchor::Start, colour::INK, name);
    }
    svg.finish()
}

/// The picture of a spectrum with a vertical axis for `all` values, and its frame.
fn filled(spectrum: &Spectrum, options: &SpectrumOptions, all: &[f64]) -> (Svg, Frame) {
    let (nm, value) = (spectrum.wavelength_nm(), spectrum.value());
    let (first, last) = (nm[0], nm[nm.len() - 1]);
    let mut svg = Svg::figure(&format!("Spectrum {}", options.title));
    svg.text((0.5 * WIDTH, 20.0), Anchor::Middle, colour::INK, &options.title);
    let frame = Frame::of_figure(Scale::linear(first, last), Scale::around(all.iter().copied(), true));
    let (from, to) = frame.x.range();
    svg.raw(r#"<defs><linearGradient id="wavelengths" x1="0" y1="0" x2="1" y2="0">"#);
    let stops = 160;
    for i in 0..=stops {
        let share = f64::from(i) / f64::from(stops);
        svg.raw(&format!(
            r#"<stop offset="{share:.5}" stop-color="{}"/>"#,
            spectral_colour::of_wavelength(from + share * (to - from))
        ));
    }
    // The gradient follows the box of the shape, which spans the whole frame.
    svg.raw("</linearGradient></defs>");
    let base = frame.at(first, 0.0).1;
    let (left, right) = (frame.at(first, 0.0).0, frame.at(last, 0.0).0);
    let curve: Vec<_> = nm.iter().zip(value).map(|(&w, &v)| frame.at(w, v)).collect();
    let area = [(left, base)]
        .into_iter()
        .chain(curve.iter().copied())
        .chain([(right, base)]);
    svg.polygon(area, "url(#wavelengths)", 0.85);
    let label = if options.value_label.is_empty() {
        "relative"
    } else {
        &options.value_label
    };
    frame.draw(&mut svg, "wavelength in nm", label);
    svg.polyline(curve, Stroke::solid(colour::INK, 1.2));
    (svg, frame)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn one_point_and_negative_values_still_draw() {
        for s in [
            Spectrum::new(vec![555.0], vec![1.0]).unwrap(),
            Spectrum::new(vec![400.0, 500.0, 700.0], vec![-0.1, 1.0, 0.0]).unwrap(),
        ] {
            let out = spectrum(&s, &SpectrumOptions::default());
            assert!(out.contains("wavelength in nm") && !out.contains("NaN") && !out.contains("inf"));
        }
    }
}
