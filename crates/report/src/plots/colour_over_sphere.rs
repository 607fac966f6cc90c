//! Δu′v′ from the average over C and γ.

use super::colour_directions::{ColourDirections, STEP};
use super::contour::Grid;
use super::isocandela::lines;
use super::scale_bar::scale_bar;
use crate::axes::{Frame, Scale};
use crate::svg::{Anchor, HEIGHT, Stroke, Svg, WIDTH, colour};

/// The least number of steps that the scale has.
const LEAST_STEPS: f64 = 3.0;
/// How much farther than the farthest direction that counts it goes.
const BEYOND: f64 = 2.5;

/// Distance in (u′, v′) from the average over C and γ, in steps of 0.0011, with a line for each of them (every
/// second, or tenth, of many) and a dot for each direction that was read; between these colours mix by their lumens.
pub fn colour_over_sphere(colours: &ColourDirections) -> String {
    let last = colours.last_gamma_deg().max(10.0);
    let steps_at = |c_deg: f64, gamma_deg: f64| {
        colours.at(c_deg, gamma_deg).map_or(f64::NAN, |at| {
            let (u, v) = colours.difference(at);
            u.hypot(v) / STEP
        })
    };
    let mut svg = Svg::figure("Colour difference over the sphere");
    let frame = Frame {
        width: WIDTH - 72.0 - 92.0,
        ..Frame::of_figure(
            Scale::linear(0.0, 360.0).every(60.0),
            Scale::linear(0.0, last).every(if last > 90.0 { 30.0 } else { 15.0 }),
        )
    };
    let grid = Grid::sample(181, 121, |x, y| steps_at(360.0 * x, last * (1.0 - y)));
    let largest = grid
        .value
        .iter()
        .filter(|steps| steps.is_finite())
        .fold(1.0, |most: f64, steps| most.max(*steps));
    // Noise of the dim directions would pale all others.
    let largest = largest.min((BEYOND * colours.farthest_steps()).max(LEAST_STEPS));
    if let Some(png) = grid.png(largest) {
        svg.image(frame.left, frame.top, frame.width, frame.height, &png);
    }
    frame.draw(&mut svg, "C in °", "γ in °");
    let every = if largest > 30.0 {
        10.0
    } else if largest > 12.0 {
        2.0
    } else {
        1.0
    };
    let mut labels = Vec::new();
    let mut level = every;
    while level < largest {
        lines(&mut svg, &grid, level, &frame, &format!("{level:.0}"), &mut labels);
        level += every;
    }
    for direction in colours.directions() {
        let (c_deg, gamma_deg) = direction.at_deg;
        // A pole is one direction, the whole edge of the picture.
        if gamma_deg == 0.0 || gamma_deg == 180.0 {
            continue;
        }
        for c_deg in [c_deg, 360.0].into_iter().take(if c_deg == 0.0 { 2 } else { 1 }) {
            let ring = Stroke::solid(colour::OVER, 1.0);
            svg.circle(frame.at(c_deg, gamma_deg), 2.2, "none", Some(ring));
        }
    }
    scale_bar(
        &mut svg,
        (WIDTH - 76.0, frame.top + 18.0, 16.0, frame.height - 18.0),
        largest,
        "steps",
    );
    svg.text(
        (frame.left, HEIGHT - 10.0),
        Anchor::Start,
        colour::INK,
        "Δu′v′ from the average in steps of 0.0011; dots: read",
    );
    svg.finish()
}

#[cfg(test)]
mod tests {
    use super::super::colour_directions::tests::yellow_at_the_rim;
    use super::*;

    #[test]
    fn the_map_has_steps_and_the_directions_that_were_read() {
        let out = colour_over_sphere(&yellow_at_the_rim());
        // Four half-planes of 8 directions, the first at both edges.
        assert_eq!(out.matches("r=\"2.2\"").count(), 40);
        assert!(out.contains(">1</text>") && !out.contains("NaN"));
    }
}
