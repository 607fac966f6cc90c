//! Correlated colour temperature along γ.

use super::colour_directions::{ColourDirections, cct_k};
use crate::axes::{Frame, Scale};
use crate::svg::{Anchor, HEIGHT, Stroke, Svg, colour};

/// Steps of the curve.
const STEPS: i32 = 240;

/// Correlated colour temperature over γ in the planes C180–C0 (solid red) and C270–C90 (dashed blue), each
/// direction that was read with its expanded uncertainty; none where no direction has one.
pub fn cct_over_gamma(colours: &ColourDirections) -> Option<String> {
    let read: Vec<(f64, f64, f64, f64)> = (colours.directions().iter())
        .filter_map(|direction| {
            let expanded = direction.expanded_cct_k.unwrap_or(0.0);
            Some((
                direction.at_deg.0,
                direction.at_deg.1,
                cct_k(direction.chromaticity)?,
                expanded,
            ))
        })
        .collect();
    if read.is_empty() {
        return None;
    }
    let last = colours.last_gamma_deg().max(10.0);
    let both = colours.has_plane(180.0) || colours.has_plane(270.0);
    let mut svg = Svg::figure("Correlated colour temperature over γ");
    // The uncertainty of a dim direction may be larger than all that there is to see: its bar ends at the frame.
    let ends = colours.directions().iter().filter_map(|direction| {
        let expanded = direction.expanded_cct_k.filter(|_| direction.counts).unwrap_or(0.0);
        let cct = cct_k(direction.chromaticity)?;
        Some([cct - expanded, cct + expanded])
    });
    let ends: Vec<f64> = ends.flatten().collect();
    let frame = Frame::of_figure(
        Scale::linear(if both { -last } else { 0.0 }, last).every(if last > 60.0 { 30.0 } else { 10.0 }),
        Scale::around(ends, false),
    );
    let label = if both {
        "γ in ° (negative: C180, C270)"
    } else {
        "γ in °"
    };
    frame.draw(&mut svg, label, "CCT in K");
    let planes = [
        (90.0, 270.0, "C270–C90", Stroke::dashed(colour::C90, 1.6)),
        (0.0, 180.0, "C180–C0", Stroke::solid(colour::C0, 1.6)),
    ];
    let shown = planes
        .into_iter()
        .filter(|(near, far, ..)| colours.has_plane(*near) || colours.has_plane(*far));
    for (k, (near, far, name, stroke)) in shown.enumerate() {
        let curve = (if both { -STEPS } else { 0 }..=STEPS).map(|i| {
            let gamma = last * f64::from(i) / f64::from(STEPS);
            let c = if i < 0 { far } else { near };
            let there = colours.at(c, gamma.abs()).and_then(cct_k);
            frame.at(gamma, there.unwrap_or(f64::NAN))
        });
        svg.polyline(curve, stroke);
        for &(c_deg, gamma_deg, cct, expanded) in &read {
            let pole = gamma_deg == 0.0;
            let signed = match c_deg {
                _ if pole => 0.0,
                c_deg if c_deg == near => gamma_deg,
                c_deg if c_deg == far && both => -gamma_deg,
                _ => continue,
            };
            let bar = Stroke::solid(stroke.colour, 1.2);
            let (low, high) = frame.y.range();
            let end = |cct: f64| frame.at(signed, cct.clamp(low, high));
            svg.line(end(cct - expanded), end(cct + expanded), bar);
            svg.circle(frame.at(signed, cct), 2.6, stroke.colour, None);
        }
        let (x, y) = (frame.left + 150.0 * k as f64, HEIGHT - 10.0);
        svg.line((x, y - 4.5), (x + 34.0, y - 4.5), stroke);
        svg.text((x + 42.0, y), Anchor::Start, colour::INK, name);
    }
    Some(svg.finish())
}

#[cfg(test)]
mod tests {
    use isolux_spectrum::Chromaticity;

    use super::super::colour_directions::DirectionColour;
    use super::super::colour_directions::tests::yellow_at_the_rim;
    use super::*;

    #[test]
    fn both_planes_have_their_curve_and_green_light_has_none() {
        let out = cct_over_gamma(&yellow_at_the_rim()).unwrap();
        // 16 directions and the axis in each plane.
        assert_eq!(out.matches("r=\"2.6\"").count(), 34);
        assert!(out.contains("C270–C90") && !out.contains("NaN"));
        let green = |gamma| DirectionColour {
            at_deg: (0.0, gamma),
            chromaticity: Chromaticity { x: 0.2, y: 0.7 },
            expanded_cct_k: None,
            counts: true,
        };
        let green = ColourDirections::new(vec![green(0.0), green(30.0)], Chromaticity { x: 0.2, y: 0.7 }).unwrap();
        assert_eq!(cct_over_gamma(&green), None);
    }
}
