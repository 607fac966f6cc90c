//! CIE 1931 and 1976 chromaticity diagrams with the Planckian locus and lines of equal correlated colour temperature.

use isolux_spectrum::{Chromaticity, Spectrum, cct, illuminant, spectrum_locus};

use super::contour::encode;
use super::spectral_colour;
use crate::axes::{Frame, Scale};
use crate::svg::{Anchor, HEIGHT, Stroke, Svg, WIDTH, colour};

/// Which diagram.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Diagram {
    /// CIE 1931 (x, y).
    Cie1931,
    /// CIE 1976 UCS (u′, v′).
    Cie1976,
}

impl Diagram {
    fn place(self, c: Chromaticity) -> (f64, f64) {
        match self {
            Self::Cie1931 => (c.x, c.y),
            Self::Cie1976 => c.uv_1976(),
        }
    }

    fn chromaticity(self, (a, b): (f64, f64)) -> Chromaticity {
        match self {
            Self::Cie1931 => Chromaticity { x: a, y: b },
            Self::Cie1976 => {
                let d = 6.0 * a - 16.0 * b + 12.0;
                Chromaticity {
                    x: 9.0 * a / d,
                    y: 4.0 * b / d,
                }
            }
        }
    }
}

/// How far the axes go below zero.
const MARGIN: f64 = 0.1;

/// The source's place in the diagram, with its correlated colour temperature and Duv where they exist.
pub fn chromaticity(source: &Spectrum, diagram: Diagram, title: &str) -> String {
    // A margin on every side for the wavelengths along the locus.
    let (year, axes, end) = match diagram {
        Diagram::Cie1931 => ("1931", ("x", "y"), (0.8, 0.9)),
        Diagram::Cie1976 => ("1976", ("u′", "v′"), (0.67, 0.65)),
    };
    let mut svg = Svg::figure(&format!("CIE {year} chromaticity {title}"));
    svg.text((0.5 * WIDTH, 20.0), Anchor::Middle, colour::INK, title);
    let mut frame = Frame::of_figure(
        Scale::linear(-MARGIN, end.0).every(0.1),
        Scale::linear(-MARGIN, end.1).every(0.1),
    );
    // One scale along both axes.
    frame.width = frame.height * (end.0 + MARGIN) / (end.1 + MARGIN);
    frame.left = 0.5 * (WIDTH - frame.width) + 20.0;
    let place = |c: Chromaticity| {
        let (a, b) = diagram.place(c);
        frame.at(a, b)
    };
    let border: Vec<String> = spectrum_locus()
        .map(|(_, c)| {
            let (x, y) = place(c);
            format!("{x:.2},{y:.2}")
        })
        .collect();
    svg.raw(&format!(
        r#"<defs><clipPath id="locus-{year}"><polygon points="{}"/></clipPath></defs><g clip-path="url(#locus-{year})">"#,
        border.join(" ")
    ));
    if let Some(png) = colours(diagram, end) {
        svg.image(frame.left, frame.top, frame.width, frame.height, &png);
    }
    svg.raw("</g>");
    frame.draw(&mut svg, axes.0, axes.1);
    let mut outline: Vec<_> = spectrum_locus().map(|(_, c)| place(c)).collect();
    outline.push(outline[0]);
    svg.polyline(outline, Stroke::solid(colour::INK, 1.4));
    for (nm, c) in spectrum_locus()
        .filter(|(nm, _)| [380.0, 700.0].contains(nm) || (*nm >= 460.0 && *nm <= 620.0 && nm.rem_euclid(20.0) == 0.0))
    {
        let (x, y) = place(c);
        let (dx, dy) = outward(nm, &place);
        svg.line((x, y), (x + 5.0 * dx, y + 5.0 * dy), Stroke::solid(colour::INK, 1.0));
        let anchor = if dx > 0.3 {
            Anchor::Start
        } else if dx < -0.3 {
            Anchor::End
        } else {
            Anchor::Middle
        };
        svg.text(
            (x + 9.0 * dx, y + 11.0 * dy + 3.5),
            anchor,
            colour::MUTED,
            &format!("{nm:.0}"),
        );
    }

    planckian_locus(&mut svg, year, &place);
    if let Some(c) = source.chromaticity() {
        let at = place(c);
        svg.circle(at, 5.5, "none", Some(Stroke::solid("#ffffff", 4.0)));
        svg.circle(at, 5.5, "none", Some(Stroke::solid(colour::C0, 2.2)));
        let (a, b) = diagram.place(c);
        let temperature = source.cct().map_or("no correlated colour temperature".to_owned(), |t| {
            format!("CCT {:.0} K, Duv {:+.4}", t.cct_k, t.duv)
        });
        let text = format!("{} {a:.4}, {} {b:.4}, {temperature}", axes.0, axes.1);
        let y = HEIGHT - 8.0;
        svg.circle((22.0, y - 4.5), 5.5, "none", Some(Stroke::solid(colour::C0, 2.2)));
        svg.text((36.0, y), Anchor::Start, colour::INK, &text);
    }
    svg.finish()
}

/// The Planckian locus, with lines of equal correlated colour temperature across it.
fn planckian_locus(svg: &mut Svg, year: &str, place: &impl Fn(Chromaticity) -> (f64, f64)) {
    let mired = |from: f64, to: f64, n: usize| (0..=n).map(move |i| 1e6 / (from + (to - from) * i as f64 / n as f64));
    svg.polyline(
        mired(10.0, 1000.0, 160)
            .filter_map(illuminant::planckian_chromaticity)
            .map(place),
        Stroke::solid(colour::OVER, 1.3),
    );
    for t in [1500.0, 2000.0, 3000.0, 4000.0, 5000.0, 6500.0, 10_000.0] {
        let ends = [-0.03, 0.03].map(|duv| cct::beside_locus(t, duv).map(place));
        if let [Some(below), Some(above)] = ends {
            svg.raw(&format!(r#"<g clip-path="url(#locus-{year})">"#));
            svg.line(below, above, Stroke::solid(colour::OVER, 0.8));
            svg.raw("</g>");
            let (dx, dy) = ((above.0 - below.0), (above.1 - below.1));
            let length = dx.hypot(dy).max(1.0);
            // Others would lie on these.
            if ![2000.0, 10_000.0].contains(&t) {
                continue;
            }
            svg.text(
                (below.0 - 13.0 * dx / length, below.1 - 13.0 * dy / length + 3.0),
                Anchor::Middle,
                colour::OVER,
                &format!("{t:.0} K"),
            );
        }
    }
}

/// Unit vector on the picture, square to the locus at a wavelength, away from its inside.
fn outward(nm: f64, place: &impl Fn(Chromaticity) -> (f64, f64)) -> (f64, f64) {
    let near: Vec<(f64, f64)> = spectrum_locus()
        .filter(|(w, _)| (w - nm).abs() <= 6.0)
        .map(|(_, c)| place(c))
        .collect();
    let (Some(first), Some(last)) = (near.first(), near.last()) else {
        return (0.0, -1.0);
    };
    let length = (last.0 - first.0).hypot(last.1 - first.1);
    // At either end of the locus the points nearly coincide: away from white there.
    if length < 3.0 || nm <= 400.0 || nm >= 690.0 {
        let ((x, y), (wx, wy)) = (near[near.len() / 2], place(isolux_spectrum::EQUAL_ENERGY));
        let length = (x - wx).hypot(y - wy).max(1.0);
        return ((x - wx) / length, (y - wy) / length);
    }
    // The locus runs clockwise on the picture, so that its outside lies to the left.
    ((last.1 - first.1) / length, -(last.0 - first.0) / length)
}

/// The colours of the diagram's plane, `end` at the upper right corner.
fn colours(diagram: Diagram, end: (f64, f64)) -> Option<Vec<u8>> {
    const SIDE: usize = 160;
    let rgb: Vec<u8> = (0..SIDE * SIDE)
        .flat_map(|i| {
            let a = ((i % SIDE) as f64 + 0.5) / SIDE as f64 * (end.0 + MARGIN) - MARGIN;
            let b = (1.0 - ((i / SIDE) as f64 + 0.5) / SIDE as f64) * (end.1 + MARGIN) - MARGIN;
            spectral_colour::bytes_of(diagram.chromaticity((a, b)))
        })
        .collect();
    encode(&rgb, SIDE, SIDE, png::ColorType::Rgb)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn both_diagrams_place_the_same_colour() {
        let c = Chromaticity { x: 0.31, y: 0.33 };
        for diagram in [Diagram::Cie1931, Diagram::Cie1976] {
            let back = diagram.chromaticity(diagram.place(c));
            assert!((back.x - c.x).abs() < 1e-12 && (back.y - c.y).abs() < 1e-12);
        }
        let daylight = illuminant::daylight(6504.0)
            .and_then(|d| Spectrum::from_1_nm(&d))
            .unwrap();
        let out = chromaticity(&daylight, Diagram::Cie1931, "D65");
        assert!(out.contains("CCT 6504 K") && out.contains("x 0.3127") && !out.contains("NaN"));
        let green = Spectrum::new(vec![530.0, 531.0], vec![1.0, 1.0]).unwrap();
        assert!(chromaticity(&green, Diagram::Cie1976, "").contains("no correlated"));
    }
}
