//! The difference of two distributions, over the sphere and along planes, relative to the largest intensity.

use super::contour::Grid;
use super::scale_bar::scale_bar;
use crate::axes::{Frame, Scale};
use crate::svg::{Anchor, HEIGHT, Stroke, Svg, WIDTH, colour};

/// Colours of the curves, in their order.
const COLOURS: [&str; 4] = [colour::DATA, colour::MODEL, colour::BAD, colour::MUTED];
/// The least end of the scale in per cent.
const LEAST_PERCENT: f64 = 0.1;

/// |difference| over C and γ in per cent of the largest intensity; `of_peak` gives it at (C, γ) in degrees.
pub fn difference_over_sphere(of_peak: &dyn Fn(f64, f64) -> f64, last_gamma_deg: f64, title: &str) -> String {
    let mut svg = Svg::figure(title);
    svg.text((0.5 * WIDTH, 20.0), Anchor::Middle, colour::INK, title);
    let every = if last_gamma_deg > 90.0 { 30.0 } else { 15.0 };
    let frame = Frame {
        width: WIDTH - 72.0 - 92.0,
        ..Frame::of_figure(
            Scale::linear(0.0, 360.0).every(60.0),
            Scale::linear(0.0, last_gamma_deg).every(every),
        )
    };
    let grid = Grid::sample(181, 121, |x, y| {
        100.0 * of_peak(360.0 * x, last_gamma_deg * (1.0 - y)).abs()
    });
    let largest = grid
        .value
        .iter()
        .fold(LEAST_PERCENT, |most: f64, value| most.max(*value));
    if let Some(png) = grid.png(largest) {
        svg.image(frame.left, frame.top, frame.width, frame.height, &png);
    }
    frame.draw(&mut svg, "C in °", "γ in °");
    let bar = (WIDTH - 76.0, frame.top + 18.0, 16.0, frame.height - 18.0);
    scale_bar(&mut svg, bar, largest, "%");
    let words = "size of the difference, % of the largest intensity of the first";
    svg.text((frame.left, HEIGHT - 10.0), Anchor::Start, colour::INK, words);
    svg.finish()
}

/// A difference along a plane: its name and (signed γ in degrees, difference relative to the largest intensity).
#[derive(Debug, Clone, PartialEq)]
pub struct DifferenceCurve {
    /// What it is of.
    pub name: String,
    /// By rising γ.
    pub points: Vec<(f64, f64)>,
}

/// Differences from `first` along planes, in per cent of its largest intensity; from the fifth curve on colours repeat
/// with dashes.
pub fn difference_over_gamma(curves: &[DifferenceCurve], first: &str) -> String {
    let mut svg = Svg::figure("Differences along planes");
    let title = format!("differences from {first}");
    svg.text((0.5 * WIDTH, 20.0), Anchor::Middle, colour::INK, &title);
    let points = || curves.iter().flat_map(|curve| &curve.points);
    let last = points().fold(10.0, |most: f64, point| most.max(point.0.abs()));
    let frame = Frame::of_figure(
        Scale::linear(-last, last).every(if last > 90.0 { 30.0 } else { 15.0 }),
        Scale::around(
            points()
                .map(|point| 100.0 * point.1)
                .chain([-LEAST_PERCENT, LEAST_PERCENT]),
            true,
        ),
    );
    frame.draw(&mut svg, "γ in °", "% of the largest intensity");
    for (number, curve) in curves.iter().enumerate() {
        let ink = COLOURS[number % COLOURS.len()];
        let stroke = if number < COLOURS.len() {
            Stroke::solid(ink, 1.4)
        } else {
            Stroke::dashed(ink, 1.4)
        };
        svg.polyline(curve.points.iter().map(|(x, y)| frame.at(*x, 100.0 * y)), stroke);
        // As many names as the picture has room for.
        let y = frame.top + 14.0 + 14.0 * number as f64;
        if y < frame.top + 0.5 * frame.height {
            svg.text((frame.left + 8.0, y), Anchor::Start, ink, &curve.name);
        }
    }
    svg.finish()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn curves_have_their_names_and_colours() {
        let curve = |name: &str| DifferenceCurve {
            name: name.to_owned(),
            points: vec![(-30.0, 0.0), (0.0, 0.01), (30.0, -0.02)],
        };
        let out = difference_over_gamma(&[curve("one"), curve("two")], "first");
        assert!(out.contains(">one</text>") && out.contains(">two</text>") && !out.contains("NaN"));
        let map = difference_over_sphere(&|_, gamma| 1e-3 * gamma, 60.0, "a against b");
        assert!(map.contains("data:image/png") && map.contains(">6") && !map.contains("NaN"));
    }
}
