//! What a varied key does to the light.

use crate::axes::{Frame, Scale};
use crate::svg::{Anchor, Stroke, Svg};

/// Results that differ in one key alone.
#[derive(Debug, Clone, PartialEq)]
pub struct Line {
    /// The other keys and their values.
    pub name: String,
    /// Value of the key, mean and maximum, in its order.
    pub points: Vec<[f64; 3]>,
}

/// Mean and maximum in `unit` against `key`.
pub fn sweep(key: &str, unit: &str, lines: &[Line]) -> String {
    let all = || lines.iter().flat_map(|line| line.points.iter());
    let mut svg = Svg::new(760.0, 440.0, key);
    let frame = Frame {
        left: 80.0,
        top: 24.0,
        width: 460.0,
        height: 350.0,
        x: Scale::around(all().map(|point| point[0]), false),
        y: Scale::around(all().flat_map(|point| [point[1], point[2]]), true),
    };
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
        if lines.len() > 1 && k < 18 {
            svg.text((556.0, 40.0 + 18.0 * k as f64), 11.0, Anchor::Start, colour, name);
        }
    }
    svg.finish()
}
