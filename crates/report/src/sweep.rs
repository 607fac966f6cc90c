//! What a varied key does to the light.

use crate::axes::{Frame, Scale};
use crate::svg::{Anchor, HEIGHT, Stroke, Svg, WIDTH};

/// Results that differ in one key alone.
#[derive(Debug, Clone, PartialEq)]
pub struct Line {
    /// The other keys and their values.
    pub name: String,
    /// Value of the key, mean and maximum, in its order.
    pub points: Vec<[f64; 3]>,
}

/// Lines that are named below the picture, at most, and the height of a name in pixels.
const MOST_NAMES: usize = 18;
const LINE: f64 = 18.0;

/// Mean and maximum in `unit` against `key`.
pub fn sweep(key: &str, unit: &str, lines: &[Line]) -> String {
    let all = || lines.iter().flat_map(|line| line.points.iter());
    let names = if lines.len() > 1 {
        lines.len().min(MOST_NAMES)
    } else {
        0
    };
    let mut svg = Svg::new(WIDTH, HEIGHT + LINE * names as f64, key);
    let frame = Frame::of_figure(
        Scale::around(all().map(|point| point[0]), false),
        Scale::around(all().flat_map(|point| [point[1], point[2]]), true),
    );
    frame.draw(&mut svg, key, &format!("mean (solid), maximum (dashed) / {unit}"));
    let colours = ["#c22f2f", "#2f5fc2", "#2f8f4f", "#a05fb0", "#c28a2f", "#3f9fa8"];
    for (k, Line { name, points }) in lines.iter().enumerate() {
        let colour = colours[k % colours.len()];
        svg.polyline(points.iter().map(|p| frame.at(p[0], p[1])), Stroke::solid(colour, 1.8));
        svg.polyline(
            points.iter().map(|p| frame.at(p[0], p[2])),
            Stroke {
                colour,
                width: 1.2,
                dash: "5 3",
            },
        );
        for p in points {
            svg.circle(frame.at(p[0], p[1]), 2.5, colour, None);
        }
        if k < names {
            svg.text((frame.left, HEIGHT + LINE * k as f64), Anchor::Start, colour, name);
        }
    }
    svg.finish()
}
