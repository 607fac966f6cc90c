//! Isolux diagram: lines of equal illuminance on a plane below the luminaire.

use isolux_photometry::IntensityDistribution;

use super::contour::{Grid, decade_levels};
use super::isocandela::lines;
use super::scale_bar::scale_bar;
use crate::axes::{Frame, Scale, number};
use crate::svg::{Anchor, HEIGHT, Stroke, Svg, WIDTH, colour};

/// The plane.
#[derive(Debug, Clone, PartialEq)]
pub struct IsoluxOptions {
    /// Text above the diagram.
    pub title: String,
    /// Distance of the plane from the light centre along γ = 0, in m.
    pub height_m: f64,
    /// Half the side of the square that is shown, in m.
    pub half_side_m: f64,
}

impl IsoluxOptions {
    /// The plane at 1 m, as wide as the light: to where the illuminance falls under 1 % of its largest value, at most
    /// to γ = 68° along its axes.
    pub fn at_one_metre(distribution: &IntensityDistribution, title: &str) -> Self {
        const SIDES: [f64; 8] = [0.1, 0.2, 0.5, 0.75, 1.0, 1.5, 2.0, 2.5];
        let rings: Vec<f64> = (0..=125)
            .map(|i| {
                let radius = 0.02 * f64::from(i);
                (0..72)
                    .map(|k| illuminance(distribution, 1.0, radius, 5.0 * f64::from(k)))
                    .fold(0.0, f64::max)
            })
            .collect();
        let high = rings.iter().copied().fold(0.0, f64::max);
        let reach = rings.iter().rposition(|e| *e > 0.01 * high).unwrap_or(125) as f64 * 0.02;
        Self {
            title: title.to_owned(),
            height_m: 1.0,
            half_side_m: SIDES.into_iter().find(|side| *side > reach).unwrap_or(2.5),
        }
    }
}

/// E = I cos³γ / h² at a distance from the foot of the luminaire.
fn illuminance(distribution: &IntensityDistribution, h: f64, radius: f64, c_deg: f64) -> f64 {
    let gamma = radius.atan2(h);
    distribution.intensity_cd_at(c_deg, gamma.to_degrees()) * gamma.cos().powi(3) / (h * h)
}

/// Illuminance E = I cos³γ / h² on the plane in colour, with level lines; C0 to the right, C90 up: seen from the lamp.
pub fn isolux(distribution: &IntensityDistribution, options: &IsoluxOptions) -> String {
    let (h, half) = (options.height_m, options.half_side_m);
    let at = |x_m: f64, y_m: f64| {
        let c = y_m.atan2(x_m).to_degrees().rem_euclid(360.0);
        illuminance(distribution, h, x_m.hypot(y_m), c)
    };
    let grid = Grid::sample(161, 161, |x, y| at(half * (2.0 * x - 1.0), half * (1.0 - 2.0 * y)));
    let high = grid.value.iter().copied().fold(0.0, f64::max);
    let mut svg = Svg::figure(&format!("Isolux diagram {}", options.title));
    svg.text((0.5 * WIDTH, 20.0), Anchor::Middle, colour::INK, &options.title);
    let mut frame = Frame::of_figure(Scale::linear(-half, half), Scale::linear(-half, half));
    frame.width = frame.height;
    if let Some(png) = grid.png(high) {
        svg.image(frame.left, frame.top, frame.width, frame.height, &png);
    }
    frame.draw(&mut svg, "x in m (towards C0)", "y in m (towards C90)");
    let mut labels = Vec::new();
    for level in decade_levels(high, 8) {
        lines(&mut svg, &grid, level, &frame, &number(level), &mut labels);
    }
    let (cx, cy) = frame.at(0.0, 0.0);
    svg.line((cx - 6.0, cy), (cx + 6.0, cy), Stroke::solid(colour::OVER, 1.2));
    svg.line((cx, cy - 6.0), (cx, cy + 6.0), Stroke::solid(colour::OVER, 1.2));
    scale_bar(
        &mut svg,
        (
            frame.left + frame.width + 24.0,
            frame.top + 18.0,
            16.0,
            frame.height - 18.0,
        ),
        high,
        "lx",
    );
    let note = format!("plane at {} m, square to γ = 0", number(h));
    svg.text((frame.left, HEIGHT - 10.0), Anchor::Start, colour::INK, &note);
    svg.finish()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_isotropic_source_draws_circles_and_a_dark_one_nothing() {
        let even = IntensityDistribution::new(vec![0.0], vec![0.0, 180.0], vec![100.0, 100.0]).unwrap();
        let out = isolux(&even, &IsoluxOptions::at_one_metre(&even, "x"));
        assert!(out.contains(">50<") && !out.contains("NaN"));
        assert_eq!(IsoluxOptions::at_one_metre(&even, "x").half_side_m, 2.5);
        let spot =
            IntensityDistribution::new(vec![0.0], vec![0.0, 4.0, 5.0, 180.0], vec![100.0, 100.0, 0.0, 0.0]).unwrap();
        assert_eq!(IsoluxOptions::at_one_metre(&spot, "x").half_side_m, 0.1);
        let dark = IntensityDistribution::new(vec![0.0], vec![0.0, 180.0], vec![0.0, 0.0]).unwrap();
        assert!(!isolux(&dark, &IsoluxOptions::at_one_metre(&dark, "x")).contains("NaN"));
    }
}
