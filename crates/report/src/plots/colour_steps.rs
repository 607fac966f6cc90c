//! Chromaticities of the directions about their average, with steps of u′v′.

use super::colour_directions::{ColourDirections, STEP};
use crate::axes::{Frame, Scale};
use crate::svg::{Anchor, HEIGHT, Stroke, Svg, colour};

/// The least number of steps that is shown.
const LEAST_STEPS: f64 = 3.0;
/// How much farther than the farthest direction that counts the picture goes.
const BEYOND: f64 = 1.6;

/// u′ and v′ of every direction as differences from the average, in steps of 0.0011, with circles of 1, 2, 3 …
/// steps (CIE TN 001). C0–C180 is red, C90–C270 blue, other half-planes grey; directions that are too dim to count
/// for Δu′v′ are hollow.
pub fn colour_steps(colours: &ColourDirections) -> String {
    let mut svg = Svg::figure("Chromaticity of every direction about the average");
    let at: Vec<(f64, f64)> = (colours.directions().iter())
        .map(|direction| {
            let (u, v) = colours.difference(direction.chromaticity);
            (u / STEP, v / STEP)
        })
        .collect();
    let reach = (BEYOND * colours.farthest_steps()).max(LEAST_STEPS).ceil();
    // Ticks that have room for their numbers, and circles that stay apart.
    let tick = if reach > 24.0 {
        10.0
    } else if reach > 6.0 {
        2.0
    } else {
        1.0
    };
    let every = if reach > 24.0 {
        10.0
    } else if reach > 12.0 {
        2.0
    } else {
        1.0
    };
    let mut frame = Frame::of_figure(
        Scale::linear(-reach, reach).every(tick),
        Scale::linear(-reach, reach).every(tick),
    );
    // One scale along both axes.
    frame.left += 0.5 * (frame.width - frame.height);
    frame.width = frame.height;
    frame.draw(&mut svg, "Δu′ in steps of 0.0011", "Δv′ in steps of 0.0011");
    let step = frame.width / (2.0 * reach);
    let centre = frame.at(0.0, 0.0);
    let circles = (1..)
        .map(|n| every * f64::from(n))
        .take_while(|radius| *radius <= reach);
    for radius in circles {
        svg.circle(centre, radius * step, "none", Some(Stroke::solid(colour::MUTED, 0.9)));
    }
    svg.circle(centre, 3.0, colour::INK, None);
    let mut outside = 0;
    for (direction, (u, v)) in colours.directions().iter().zip(at) {
        if u.abs().max(v.abs()) > reach {
            outside += 1;
            continue;
        }
        let of = colour_of(direction.at_deg);
        let fill = if direction.counts { of } else { "none" };
        svg.circle(frame.at(u, v), 3.6, fill, Some(Stroke::solid(of, 1.4)));
    }
    let y = HEIGHT - 10.0;
    for (x, of, name) in [
        (frame.left - 40.0, colour::C0, "C0–C180"),
        (frame.left + 60.0, colour::C90, "C90–C270"),
    ] {
        svg.circle((x, y - 4.5), 3.6, of, None);
        svg.text((x + 9.0, y), Anchor::Start, colour::INK, name);
    }
    svg.circle(
        (frame.left + 168.0, y - 4.5),
        3.6,
        "none",
        Some(Stroke::solid(colour::INK, 1.4)),
    );
    let farther = match outside {
        0 => String::new(),
        count => format!("; {count} farther away"),
    };
    let text = format!("dim{farther}");
    svg.text((frame.left + 177.0, y), Anchor::Start, colour::INK, &text);
    svg.finish()
}

/// By the half-plane; on the axis both meet.
fn colour_of((c_deg, gamma_deg): (f64, f64)) -> &'static str {
    if gamma_deg == 0.0 || gamma_deg == 180.0 {
        return colour::INK;
    }
    match c_deg.rem_euclid(180.0) {
        0.0 => colour::C0,
        90.0 => colour::C90,
        _ => colour::MUTED,
    }
}

#[cfg(test)]
mod tests {
    use super::super::colour_directions::tests::yellow_at_the_rim;
    use super::*;

    #[test]
    fn every_direction_has_its_dot_and_the_dim_ones_are_hollow() {
        let out = colour_steps(&yellow_at_the_rim());
        let dots = |fill: &str| out.matches(&format!("r=\"3.6\" fill=\"{fill}\"")).count();
        // 2 half-planes of 5 bright directions each, and a sign for each in the legend.
        assert_eq!((dots(colour::C0), dots(colour::C90), dots("none")), (11, 11, 9));
        assert!(out.contains("dim; 4 farther away"));
        assert!(!out.contains("NaN"));
    }
}
