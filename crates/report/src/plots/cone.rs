//! Cone diagram: how wide the beam is, and how bright its middle, at distances along γ = 0.

use isolux_photometry::IntensityDistribution;

use crate::axes::number;
use crate::svg::{Anchor, HEIGHT, Stroke, Svg, colour};

/// Edges beyond this are no cone: its width at a distance means nothing any more.
const WIDEST_DEG: f64 = 80.0;

/// What the cone of one distance is.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Cone {
    /// Distance from the light centre along γ = 0, in m.
    pub distance_m: f64,
    /// Illuminance on the axis, in lx.
    pub axis_lx: f64,
    /// Width of the beam (50 %) in the planes C0–C180 and C90–C270, in m.
    pub width_m: [f64; 2],
}

/// The cones at 1 m to 5 m; none where half the largest intensity lies further out than γ = 80°, or the beam is above
/// the horizontal.
pub fn cones(distribution: &IntensityDistribution) -> Option<Vec<Cone>> {
    let edges = edges(distribution)?;
    let axis_cd = distribution.intensity_cd_at(0.0, 0.0);
    let cones = (1..=5).map(|metre| {
        let distance_m = f64::from(metre);
        Cone {
            distance_m,
            axis_lx: axis_cd / (distance_m * distance_m),
            width_m: edges.map(|[low, high]| distance_m * (high.to_radians().tan() - low.to_radians().tan())),
        }
    });
    Some(cones.collect())
}

/// Edges of the beam in C0–C180 and C90–C270, signed γ.
fn edges(distribution: &IntensityDistribution) -> Option<[[f64; 2]; 2]> {
    let of = |c_deg: f64| {
        let planes = distribution.c_deg();
        let plane =
            (planes.iter().position(|c| (c - c_deg).abs() < 1e-9)).or(distribution.is_rotational().then_some(0))?;
        let beam = distribution.beam_angle(plane)?;
        let edges = [beam.from_deg, beam.to_deg];
        edges.iter().all(|edge| edge.abs() <= WIDEST_DEG).then_some(edges)
    };
    Some([of(0.0)?, of(90.0)?])
}

/// Both planes side by side, the luminaire above; none where there is no cone.
pub fn cone(distribution: &IntensityDistribution) -> Option<String> {
    let (edges, cones) = (edges(distribution)?, cones(distribution)?);
    let mut svg = Svg::figure("Cone diagram");
    // Both planes on one scale, true to the angle where that fits.
    let widest = edges
        .iter()
        .flatten()
        .fold(0.05_f64, |widest, edge| widest.max(edge.to_radians().tan().abs()));
    let (half, per_m) = (90.0, 62.0);
    let across = (half / (5.0 * widest)).min(per_m);
    for (middle, [low, high], stroke, name) in [
        (102.0, edges[0], Stroke::solid(colour::C0, 2.0), "C0–C180"),
        (398.0, edges[1], Stroke::dashed(colour::C90, 2.0), "C90–C270"),
    ] {
        let top = 44.0;
        svg.text((middle, 22.0), Anchor::Middle, stroke.colour, name);
        let x = |edge: f64, distance: f64| middle + across * distance * edge.to_radians().tan();
        let y = |distance: f64| top + per_m * distance;
        let far = 5.0;
        svg.polygon(
            [(middle, top), (x(low, far), y(far)), (x(high, far), y(far))],
            stroke.colour,
            0.07,
        );
        for edge in [low, high] {
            svg.line((middle, top), (x(edge, far), y(far)), stroke);
        }
        svg.rectangle(middle - 16.0, top - 7.0, 32.0, 7.0, colour::MUTED, None);
        for cone in &cones {
            let at = y(cone.distance_m);
            svg.line(
                (x(low, cone.distance_m), at),
                (x(high, cone.distance_m), at),
                Stroke::solid(colour::MUTED, 1.0),
            );
        }
        for (place, cone) in cones.iter().enumerate() {
            let width = cone.width_m[usize::from(name != "C0–C180")];
            let words = format!("{width:.2} m");
            svg.text((middle, y(cone.distance_m) - 5.0), Anchor::Middle, colour::INK, &words);
            if name == "C0–C180" {
                let words = format!("{} m  {} lx", place + 1, number(round(cone.axis_lx)));
                svg.text((250.0, y(cone.distance_m) + 4.5), Anchor::Middle, colour::INK, &words);
            }
        }
        let angle = format!("beam angle {:.1}°", high - low);
        svg.text((middle, HEIGHT - 12.0), Anchor::Middle, colour::INK, &angle);
    }
    Some(svg.finish())
}

/// Three significant digits: a diagram is read, not computed with.
fn round(value: f64) -> f64 {
    if value == 0.0 {
        return 0.0;
    }
    let step = 10f64.powf(value.abs().log10().floor() - 2.0);
    (value / step).round() * step
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_lambertian_source_has_the_cone_of_its_half_angle() {
        let gamma: Vec<f64> = (0..=90).map(f64::from).collect();
        let row: Vec<f64> = gamma.iter().map(|g| 100.0 * g.to_radians().cos()).collect();
        let c = vec![0.0, 90.0, 180.0, 270.0];
        let values = row.iter().copied().cycle().take(4 * row.len()).collect();
        let light = IntensityDistribution::new(c, gamma.clone(), values).unwrap();
        let cones = cones(&light).unwrap();
        // cos 60° = ½: a cone 2·d·tan 60° wide; 100 cd give 25 lx at 2 m.
        assert!((cones[1].width_m[0] - 4.0 * 3f64.sqrt()).abs() < 1e-6, "{cones:?}");
        assert!((cones[1].axis_lx - 25.0).abs() < 1e-12 && cones.len() == 5);
        assert!(cone(&light).unwrap().contains("beam angle 120.0°"));
        let even = IntensityDistribution::new(vec![0.0], gamma.clone(), vec![1.0; gamma.len()]).unwrap();
        assert_eq!(cone(&even), None);
    }
}
