//! Isocandela diagram: lines of equal intensity over C and γ.

use isolux_photometry::IntensityDistribution;

use super::contour::Grid;
use super::polar::PolarOptions;
use super::scale_bar::scale_bar;
use super::shown;
use crate::axes::{Frame, Scale, number};
use crate::svg::{Anchor, HEIGHT, Stroke, Svg, WIDTH, colour};

/// Intensity over C (0–360°) and γ in colour, with lines at 10, 20, 30, 50, 70 and 90 % of the largest.
pub fn isocandela(distribution: &IntensityDistribution, options: &PolarOptions) -> String {
    let (factor, unit) = options.scale();
    let last = shown::shown_gamma(distribution);
    let peak = distribution.peak();
    let high = peak.intensity_cd * factor;
    let mut svg = Svg::figure(&format!("Isocandela diagram {}", options.title));
    svg.text((0.5 * WIDTH, 20.0), Anchor::Middle, colour::INK, &options.title);
    let frame = Frame {
        width: WIDTH - 72.0 - 92.0,
        ..Frame::of_figure(
            Scale::linear(0.0, 360.0).every(60.0),
            Scale::linear(0.0, last).every(if last > 90.0 { 30.0 } else { 15.0 }),
        )
    };
    let grid = Grid::sample(181, 121, |x, y| {
        factor * distribution.intensity_cd_at(360.0 * x, last * (1.0 - y))
    });
    if let Some(png) = grid.png(high) {
        svg.image(frame.left, frame.top, frame.width, frame.height, &png);
    }
    frame.draw(&mut svg, "C in °", "γ in °");
    if high > 0.0 {
        let mut labels = Vec::new();
        for percent in [10.0, 20.0, 30.0, 50.0, 70.0, 90.0] {
            lines(
                &mut svg,
                &grid,
                percent / 100.0 * high,
                &frame,
                &format!("{percent:.0} %"),
                &mut labels,
            );
        }
    }
    scale_bar(
        &mut svg,
        (WIDTH - 76.0, frame.top + 18.0, 16.0, frame.height - 18.0),
        high,
        unit,
    );
    let at = format!(
        "I max {} {unit} at C {}°, γ {}°",
        number((high * 100.0).round() / 100.0),
        number(peak.c_deg),
        number(peak.gamma_deg)
    );
    svg.text((frame.left, HEIGHT - 10.0), Anchor::Start, colour::INK, &at);
    svg.finish()
}

/// One level line with one label, beside the `labels` that stand already.
pub(super) fn lines(svg: &mut Svg, grid: &Grid, level: f64, frame: &Frame, label: &str, labels: &mut Vec<(f64, f64)>) {
    let pieces = grid.level(level);
    let place = |(x, y): (f64, f64)| (frame.left + x * frame.width, frame.top + y * frame.height);
    let points = pieces
        .iter()
        .flat_map(|[a, b]| [place(*a), place(*b), (f64::NAN, f64::NAN)]);
    svg.polyline(points, Stroke::solid(colour::OVER, 0.9));
    // To the upper right of its line, away from the frame and from other labels.
    let free = |(x, y): (f64, f64)| {
        (frame.left + 24.0..frame.left + frame.width - 24.0).contains(&x)
            && (frame.top + 12.0..frame.top + frame.height - 12.0).contains(&y)
            && labels.iter().all(|(a, b)| (a - x).abs() > 46.0 || (b - y).abs() > 17.0)
    };
    let best = pieces
        .iter()
        .map(|[a, _]| place(*a))
        .filter(|at| free(*at))
        .max_by(|a, b| (a.0 - a.1).total_cmp(&(b.0 - b.1)));
    if let Some((x, y)) = best {
        labels.push((x, y));
        let w = 7.4 * label.chars().count() as f64 + 4.0;
        svg.rectangle(x - 0.5 * w, y - 9.5, w, 15.0, "#ffffff", None);
        svg.text((x, y + 2.5), Anchor::Middle, colour::INK, label);
    }
}
