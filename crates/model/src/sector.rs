//! What is missing of the light of a luminaire whose parts give unequally.

use std::sync::Arc;

use glam::DVec3;
use isolux_photometry::{IntensityDistribution, angles_deg};

use crate::angle_table::AngleTable;
use crate::emitter::{Emitter, Node};
use crate::lobe::mean_over_c;

/// The radius of the ring that stands for the LEDs of a luminaire whose emitter is a point.
const RADIUS_MM: f64 = 28.0;
/// The same of an area, relative to its largest extent from the middle. Between 2/3, the mean of an even disc, and 1: LEDs
/// sit nearer to the edge than to the middle, and what is stated is the edge.
const RADIUS_REL: f64 = 0.84;
const LEDS: usize = 18;
const LOBE_STEPS: usize = 360;

/// The parts of an emitter with what each still gives.
pub struct Sectors {
    parts: Vec<(Node, f64)>,
    /// The lobe of a part, mean over C.
    lobe: Arc<AngleTable>,
}

impl Sectors {
    /// The parts of `emitter`, of which one at an azimuth in degrees gives the share `given`. An emitter without LEDs
    /// has a ring of them in its place, which lean inwards by `aim_deg`. Each part has the same `lobe`.
    pub(crate) fn of(lobe: Arc<AngleTable>, emitter: &Emitter, aim_deg: f64, given: impl Fn(f64) -> f64) -> Self {
        let emitter = match emitter {
            leds @ Emitter::Leds { .. } => leds.clone(),
            area => Emitter::Leds {
                position_mm: Vec::new(),
                weight: Vec::new(),
                radius_mm: vec![ring_radius_mm(area)],
                count: vec![LEDS],
                aim_deg,
            },
        };
        let parts = emitter
            .nodes(1)
            .into_iter()
            .map(|node| {
                let (azimuth_deg, _) = angles_deg(node.position_mm);
                (node, given(azimuth_deg))
            })
            .collect();
        Self { parts, lobe }
    }

    /// The lobe of a part of a luminaire that gives `base`.
    pub(crate) fn lobe(base: &IntensityDistribution) -> AngleTable {
        AngleTable::of(LOBE_STEPS, |gamma_deg| mean_over_c(base, gamma_deg))
    }

    /// Mean distance of the parts from the middle, mm.
    pub fn radius_mm(&self) -> f64 {
        let distance = |(node, _): &(Node, f64)| node.weight * node.position_mm.truncate().length();
        self.parts.iter().map(distance).sum()
    }

    /// Share of the light at `point_mm` that is left on a plane whose normal reversed is `facing`. What is lost changes
    /// from where light comes, which a tilted plane sees as another level.
    pub fn left_at(&self, point_mm: DVec3, facing: DVec3) -> f64 {
        self.left(|node| {
            let path = point_mm - node.position_mm;
            let length_mm = path.length();
            let cosine = path.dot(facing).max(0.0) / length_mm;
            (path, cosine / (length_mm * length_mm))
        })
    }

    /// Share of the far field towards `direction`, of any length, that is left.
    pub fn left_towards(&self, direction: DVec3) -> f64 {
        self.left(|_| (direction, 1.0))
    }

    fn left(&self, path: impl Fn(&Node) -> (DVec3, f64)) -> f64 {
        let (mut left, mut whole) = (0.0, 0.0);
        for (node, given) in &self.parts {
            let (path, share) = path(node);
            let cosine = path.dot(node.axis) / path.length();
            let light = node.weight * self.lobe.at_cosine(cosine).max(0.0) * share;
            left += given * light;
            whole += light;
        }
        if whole > 0.0 { left / whole } else { 1.0 }
    }
}

fn ring_radius_mm(emitter: &Emitter) -> f64 {
    match emitter {
        Emitter::Ring {
            inner_diameter_mm,
            outer_diameter_mm,
        } => 0.25 * (inner_diameter_mm + outer_diameter_mm),
        point_or_area => match point_or_area.extent_mm() {
            0.0 => RADIUS_MM,
            extent_mm => RADIUS_REL * extent_mm,
        },
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Effect, Luminaire, Model, Spectral};

    /// LEDs of cos⁵ lobes, a third of the ring dimmed: a sum of its own, with the LEDs' own lobes.
    #[test]
    fn a_dimmed_third_takes_what_it_gave() {
        let nodes = Emitter::Leds {
            position_mm: vec![],
            weight: vec![],
            radius_mm: vec![28.0],
            count: vec![36],
            aim_deg: 6.0,
        }
        .nodes(1);
        let light = |point: DVec3, facing: DVec3, dimmed: bool| -> f64 {
            let of_node = |node: &Node| {
                let path = point - node.position_mm;
                let azimuth = node.position_mm.y.atan2(node.position_mm.x).to_degrees();
                let apart: f64 = (azimuth - 70.0 + 180.0).rem_euclid(360.0) - 180.0;
                let depth = if dimmed && apart.abs() < 120.0 {
                    0.1 * (1.0 + (apart * 1.5).to_radians().cos())
                } else {
                    0.0
                };
                let cosine = facing.dot(path.normalize());
                (1.0 - depth) * node.axis.dot(path.normalize()).max(0.0).powi(5) * cosine / path.length_squared()
            };
            nodes.iter().map(of_node).sum()
        };
        let gamma_deg: Vec<f64> = (0..=90).map(f64::from).collect();
        let far = gamma_deg
            .iter()
            .map(|gamma| {
                let (sin, cos) = gamma.to_radians().sin_cos();
                let direction = DVec3::new(sin, 0.0, cos);
                light(direction * 1e7, direction, false)
            })
            .collect();
        let distribution = IntensityDistribution::new(vec![0.0], gamma_deg, far).unwrap();
        let keys = [("depth_rel", 0.2), ("azimuth_deg", 70.0), ("width_deg", 120.0)];
        let model = Model::of(Luminaire::new(distribution, Emitter::Point {}, Spectral::None))
            .with_effects(vec![Effect::from_keys("dead_sector", keys).unwrap()]);
        let sectors = model.sectors().unwrap();
        for (c, gamma, distance, turned_deg) in [
            (70f64, 50f64, 2000.0, 0.0),
            (250.0, 50.0, 2000.0, 0.0),
            (160.0, 30.0, 1000.0, 0.0),
            (0.0, 0.0, 1000.0, 0.0),
            (70.0, 10.0, 300.0, 30.0),
            (70.0, 10.0, 300.0, -30.0),
        ] {
            let direction = |gamma: f64| isolux_photometry::direction(c, gamma);
            let (point, facing) = (direction(gamma) * distance, direction(gamma + turned_deg));
            let truth = light(point, facing, true) / light(point, facing, false);
            let found = sectors.left_at(point, facing);
            assert!(
                (found - truth).abs() < 0.05 * (1.0 - truth),
                "C {c}, γ {gamma}: {found} for {truth}"
            );
        }
        // What a tilted plane sees of the shift of the light is not lost in the tolerance.
        let point = DVec3::new(0.0, 0.0, 300.0);
        let towards = |sign: f64| isolux_photometry::direction(70.0, sign * 30.0);
        let [more, less] = [1.0, -1.0].map(|sign| sectors.left_at(point, towards(sign)));
        let seen = |facing| light(point, facing, true) / light(point, facing, false);
        let truth = seen(towards(1.0)) - seen(towards(-1.0));
        assert!(
            truth > 2e-3 && ((more - less) / truth - 1.0).abs() < 0.05,
            "{more} {less} {truth}"
        );
    }
}
