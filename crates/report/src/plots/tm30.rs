//! ANSI/IES TM-30: colour vector graphic, local fidelity and chroma shift of the sixteen hue bins.

use isolux_spectrum::Spectrum;
use isolux_spectrum::fidelity::{Fidelity, fidelity};

use crate::axes::{Frame, Scale};
use crate::svg::{Anchor, Stroke, Svg, WIDTH, colour};

/// Colours of the hue bins as TM-30 draws them.
const BINS: [&str; 16] = [
    "#e62828", "#e74b4b", "#fb812e", "#ffb529", "#cbca46", "#7eb94c", "#41c06d", "#009c7c", "#16bcb0", "#00a4bf",
    "#0085c3", "#3b62aa", "#4568ae", "#6a4e85", "#9d69a1", "#a74f81",
];

/// The colour vector graphic; none where the source has no reference (no correlated colour temperature).
pub fn tm30(source: &Spectrum, title: &str) -> Option<String> {
    let fidelity = fidelity(source)?;
    let mut svg = Svg::figure(&format!("TM-30 colour vector graphic {title}"));
    svg.text((0.5 * WIDTH, 20.0), Anchor::Middle, colour::INK, title);
    vectors(&mut svg, &fidelity);
    let cct = source.cct()?;
    let texts = [
        (16.0, 48.0, Anchor::Start, format!("Rf {:.1}", fidelity.rf)),
        (WIDTH - 16.0, 48.0, Anchor::End, format!("Rg {:.1}", fidelity.rg)),
        (16.0, 384.0, Anchor::Start, format!("CCT {:.0} K", cct.cct_k)),
        (WIDTH - 16.0, 384.0, Anchor::End, format!("Duv {:+.4}", cct.duv)),
    ];
    for (x, y, anchor, text) in texts {
        svg.text((x, y), anchor, colour::INK, &text);
    }
    Some(svg.finish())
}

/// Local fidelity and chroma shift of the hue bins as bars; none where [`tm30`] gives none.
pub fn tm30_bins(source: &Spectrum, title: &str) -> Option<String> {
    let fidelity = fidelity(source)?;
    let mut svg = Svg::figure(&format!("TM-30 hue bins {title}"));
    svg.text((0.5 * WIDTH, 20.0), Anchor::Middle, colour::INK, title);
    bars(
        &mut svg,
        (32.0, 126.0),
        Scale::linear(0.0, 100.0).every(20.0),
        "local fidelity Rf,h",
        &fidelity.bins.map(|b| b.rf),
    );
    let shift = fidelity.bins.map(|b| b.chroma_shift_percent);
    let most = shift.iter().fold(10.0, |m: f64, v| m.max(v.abs()));
    // Room for the number at the end of the longest bar.
    let most = (1.12 * most / 10.0).ceil() * 10.0;
    bars(
        &mut svg,
        (216.0, 126.0),
        Scale::linear(-most, most).every(if most > 20.0 { 20.0 } else { 10.0 }),
        "shift Rcs,h in %",
        &shift,
    );
    Some(svg.finish())
}

fn vectors(svg: &mut Svg, fidelity: &Fidelity) {
    let (centre, radius) = ((0.5 * WIDTH, 208.0), 112.0);
    let at = |x: f64, y: f64| (centre.0 + radius * x, centre.1 - radius * y);
    // Rings at 80, 90, 110, 120 % of the reference's chroma.
    for ring in [0.8, 0.9, 1.1, 1.2] {
        svg.circle(centre, radius * ring, "none", Some(Stroke::solid(colour::GRID, 1.0)));
    }
    for k in 0..16 {
        let (sin, cos) = (22.5 * f64::from(k)).to_radians().sin_cos();
        svg.line(
            at(0.0, 0.0),
            at(1.45 * cos, 1.45 * sin),
            Stroke::dashed(colour::GRID, 1.0),
        );
        let (sin, cos) = (22.5 * f64::from(k) + 11.25).to_radians().sin_cos();
        let (x, y) = at(1.42 * cos, 1.42 * sin);
        svg.text((x, y + 4.5), Anchor::Middle, colour::MUTED, &format!("{}", k + 1));
    }
    svg.circle(centre, radius, "none", Some(Stroke::solid(colour::INK, 1.8)));
    let ends: Vec<[(f64, f64); 2]> = fidelity
        .bins
        .iter()
        .enumerate()
        .map(|(k, bin)| {
            let (sin, cos) = (22.5 * k as f64 + 11.25).to_radians().sin_cos();
            let chroma = bin.reference.0.hypot(bin.reference.1);
            let shift = (
                (bin.test.0 - bin.reference.0) / chroma,
                (bin.test.1 - bin.reference.1) / chroma,
            );
            [(cos, sin), (cos + shift.0, sin + shift.1)]
        })
        .collect();
    let closed = ends.iter().chain(&ends[..1]).map(|[_, e]| at(e.0, e.1));
    svg.polyline(closed, Stroke::solid(colour::C0, 2.0));
    for ([from, to], fill) in ends.iter().zip(BINS) {
        let (a, b) = (at(from.0, from.1), at(to.0, to.1));
        svg.line(a, b, Stroke::solid(fill, 2.6));
        let (dx, dy) = (b.0 - a.0, b.1 - a.1);
        let length = dx.hypot(dy);
        if length > 3.0 {
            let (ux, uy) = (dx / length, dy / length);
            let head = [
                (b.0 + 3.0 * ux, b.1 + 3.0 * uy),
                (b.0 - 5.0 * ux + 4.0 * uy, b.1 - 5.0 * uy - 4.0 * ux),
                (b.0 - 5.0 * ux - 4.0 * uy, b.1 - 5.0 * uy + 4.0 * ux),
            ];
            svg.polygon(head, fill, 1.0);
        }
    }
    svg.line(
        (centre.0 - 5.0, centre.1),
        (centre.0 + 5.0, centre.1),
        Stroke::solid(colour::MUTED, 1.2),
    );
    svg.line(
        (centre.0, centre.1 - 5.0),
        (centre.0, centre.1 + 5.0),
        Stroke::solid(colour::MUTED, 1.2),
    );
}

fn bars(svg: &mut Svg, (top, height): (f64, f64), y: Scale, label: &str, value: &[f64; 16]) {
    let frame = Frame {
        top,
        height,
        ..Frame::of_figure(Scale::linear(0.5, 16.5).every(1.0), y)
    };
    frame.draw(svg, "hue bin", label);
    let (low, high) = frame.y.range();
    for (k, v) in value.iter().enumerate() {
        let x = k as f64 + 1.0;
        let (left, end) = frame.at(x - 0.38, v.clamp(low, high));
        let right = frame.at(x + 0.38, 0.0).0;
        let zero = frame.at(x, 0.0).1;
        svg.rectangle(left, end.min(zero), right - left, (end - zero).abs(), BINS[k], None);
        let above = if *v < 0.0 { end + 13.0 } else { end - 3.0 };
        svg.text(
            (0.5 * (left + right), above.clamp(top + 12.0, top + height - 2.0)),
            Anchor::Middle,
            colour::INK,
            &format!("{v:.0}").replace("-0", "0"),
        );
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use isolux_spectrum::illuminant;

    #[test]
    fn a_reference_has_no_vectors_and_darkness_no_graphic() {
        let p = Spectrum::from_1_nm(&illuminant::planck(3000.0)).unwrap();
        let out = tm30(&p, "Planck").unwrap();
        assert!(out.contains("Rf 100.0") && out.contains("Rg 100.0") && !out.contains("NaN"));
        let dark = Spectrum::new(vec![400.0, 700.0], vec![0.0, 0.0]).unwrap();
        assert_eq!(tm30(&dark, ""), None);
    }
}
