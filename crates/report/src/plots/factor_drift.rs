//! What has changed between two calibrations, over wavelength.

use crate::axes::{Frame, Scale};
use crate::svg::{Anchor, HEIGHT, Stroke, Svg, WIDTH, colour};

/// One wavelength.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FactorDrift {
    /// Wavelength.
    pub wavelength_nm: f64,
    /// New factor over the former, less 1.
    pub change_rel: f64,
    /// Expanded uncertainty (k = 2) of that.
    pub expanded_rel: f64,
}

/// The vertical axis ends where this share of the wavelengths is within it: ends of the range without light are no
/// drift.
const SHARE: f64 = 0.95;

/// The change in percent over wavelength, and the band of its expanded uncertainty about no change.
pub fn factor_drift(points: &[FactorDrift], title: &str) -> String {
    let mut svg = Svg::figure(title);
    svg.text((0.5 * WIDTH, 20.0), Anchor::Middle, colour::INK, title);
    let nm = |point: Option<&FactorDrift>| point.map_or(0.0, |point| point.wavelength_nm);
    let mut sizes: Vec<f64> = points
        .iter()
        .map(|point| point.change_rel.abs().max(point.expanded_rel))
        .collect();
    sizes.sort_by(f64::total_cmp);
    let place = (SHARE * sizes.len() as f64) as usize;
    let most = 100.0 * sizes.get(place).or(sizes.last()).copied().unwrap_or(0.01);
    let frame = Frame::of_figure(
        Scale::linear(nm(points.first()), nm(points.last())),
        Scale::around([-most, most], true),
    );
    let (low, high) = frame.y.range();
    let at = |nm: f64, percent: f64| frame.at(nm, percent.clamp(low, high));
    let band = |side: f64| move |point: &FactorDrift| (point.wavelength_nm, side * 100.0 * point.expanded_rel);
    let upper = points.iter().map(band(1.0));
    let lower = points.iter().rev().map(band(-1.0));
    svg.polygon(
        upper.chain(lower).map(|(nm, percent)| at(nm, percent)),
        colour::GRID,
        0.6,
    );
    frame.draw(&mut svg, "wavelength in nm", "change of the factor in %");
    let curve = Stroke::solid(colour::C0, 1.4);
    svg.polyline(
        points
            .iter()
            .map(|point| at(point.wavelength_nm, 100.0 * point.change_rel)),
        curve,
    );
    let y = HEIGHT - 10.0;
    svg.line((frame.left, y - 4.5), (frame.left + 34.0, y - 4.5), curve);
    svg.text((frame.left + 42.0, y), Anchor::Start, colour::INK, "change");
    svg.rectangle(frame.left + 130.0, y - 9.5, 34.0, 10.0, colour::GRID, None);
    svg.text(
        (frame.left + 172.0, y),
        Anchor::Start,
        colour::INK,
        "no change within U (k = 2)",
    );
    svg.finish()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_wild_end_does_not_hide_the_rest() {
        let point = |k: u32| FactorDrift {
            wavelength_nm: 400.0 + f64::from(k),
            change_rel: if k == 300 { 9.0 } else { 0.004 },
            expanded_rel: 0.01,
        };
        let points: Vec<FactorDrift> = (0..=300).map(point).collect();
        let out = factor_drift(&points, "drift");
        assert!(out.contains("change of the factor in %") && !out.contains("NaN"));
        // The axis ends at 1 %, not at 900 %.
        assert!(out.contains(">1<") && !out.contains(">1000<"));
        assert!(!factor_drift(&[], "nothing").contains("NaN"));
    }
}
