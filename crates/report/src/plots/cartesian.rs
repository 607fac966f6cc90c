//! Cartesian intensity diagram: intensity over γ, the far half of each plane at negative γ.

use isolux_photometry::IntensityDistribution;

use super::polar::{DOUBTFUL, PolarOptions, runs};
use super::shown;
use crate::axes::{Frame, Scale};
use crate::svg::{Anchor, HEIGHT, Stroke, Svg, WIDTH, colour};

/// C180–C0 solid red and C270–C90 dashed blue, over γ from −γ_max to γ_max; one curve from 0 where all planes are
/// alike.
pub fn cartesian(distribution: &IntensityDistribution, options: &PolarOptions) -> String {
    let (factor, unit) = options.scale();
    let last = shown::shown_gamma(distribution);
    let rotational = shown::alike(distribution);
    let mut svg = Svg::figure(&format!("Intensity over γ {}", options.title));
    svg.text((0.5 * WIDTH, 20.0), Anchor::Middle, colour::INK, &options.title);
    // What cannot be told from no light asks for no axis below zero.
    let certain = |cd: &f64| {
        if cd.abs() <= options.doubtful_cd.unwrap_or(0.0) {
            0.0
        } else {
            cd * factor
        }
    };
    let frame = Frame::of_figure(
        Scale::linear(if rotational { 0.0 } else { -last }, last).every(if last > 60.0 { 30.0 } else { 10.0 }),
        Scale::around(distribution.intensity_cd().iter().map(certain), true),
    );
    frame.draw(
        &mut svg,
        if rotational {
            "γ in °"
        } else {
            "γ in ° (negative: C180, C270)"
        },
        &format!("intensity in {unit}"),
    );
    if let Some(limit) = options.doubtful_cd {
        let from = if rotational { 0.0 } else { -last };
        let corners = [(from, limit), (last, limit), (last, -limit), (from, -limit)];
        let (low, high) = frame.y.range();
        let inside = |value: f64| value.clamp(low, high);
        svg.polygon(
            corners.map(|(gamma, cd)| frame.at(gamma, inside(factor * cd))),
            colour::MUTED,
            0.3,
        );
    }
    let steps = (2.0 * last).ceil().max(1.0) as i32;
    let planes: &[(f64, f64, &str, Stroke<'_>)] = if rotational {
        &[(0.0, 0.0, "all C planes", Stroke::solid(colour::C0, 2.0))]
    } else {
        &[
            (90.0, 270.0, "C270–C90", Stroke::dashed(colour::C90, 2.0)),
            (0.0, 180.0, "C180–C0", Stroke::solid(colour::C0, 2.0)),
        ]
    };
    for (k, &(near, far, name, stroke)) in planes.iter().enumerate() {
        let from = if rotational { 0 } else { -steps };
        let points: Vec<(f64, (f64, f64))> = (from..=steps)
            .map(|i| {
                let gamma = last * f64::from(i) / f64::from(steps);
                let c = if i < 0 { far } else { near };
                let value = distribution.intensity_cd_at(c, gamma.abs());
                (value, frame.at(gamma, factor * value))
            })
            .collect();
        for (doubtful, run) in runs(&points, options.doubtful_cd) {
            svg.polyline(run, if doubtful { DOUBTFUL } else { stroke });
        }
        let (x, y) = (frame.left + 150.0 * k as f64, HEIGHT - 10.0);
        svg.line((x, y - 4.5), (x + 34.0, y - 4.5), stroke);
        svg.text((x + 42.0, y), Anchor::Start, colour::INK, name);
    }
    svg.finish()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn negative_readings_stay_on_the_picture() {
        let d = IntensityDistribution::new(vec![0.0, 180.0], vec![0.0, 90.0], vec![10.0, -1.0, 10.0, 2.0]).unwrap();
        let out = cartesian(&d, &PolarOptions::default());
        assert!(out.contains("C180–C0") && !out.contains("NaN"));
    }
}
