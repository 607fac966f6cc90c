//! Light of the whole emitter at a point: the sum that every prediction needs.

use std::sync::Arc;

use glam::DVec3;
use isolux_photometry::{angles_deg, polar_deg};

use crate::effects::{Act, DirectionFactor, Ray, Values};
use crate::emitter::{Emitter, Node};
use crate::lobe::Lobe;
use crate::luminaire::Luminaire;
use crate::memory::{NodeLight, SeenLight};
use crate::model::Model;
use crate::sector::Sectors;

/// An area of this radius over distance, squared, counts as a point: its second-order term, about 1.2 times that for
/// common lobes, is then below 6·10⁻⁶.
const POINT_LIKE: f64 = 5e-6;

type PathLaw = fn(&Values, f64) -> f64;

/// A model made ready to be asked for illuminance many times.
pub(crate) struct PreparedModel<'m> {
    model: &'m Model,
    luminaire: &'m Luminaire,
    directions: Vec<DirectionFactor>,
    paths: Vec<(PathLaw, &'m Values)>,
    nodes: Vec<Node>,
    centre: Node,
    extent_mm: f64,
    lobe: Option<Arc<Lobe>>,
    sectors: Option<Sectors>,
    plain: bool,
    /// Something depends on C.
    around: bool,
}

impl<'m> PreparedModel<'m> {
    pub fn new(model: &'m Model) -> Self {
        let emitter = model.emitter();
        let nodes = emitter.nodes(match emitter {
            Emitter::Disc { .. } | Emitter::Ring { .. } => 2,
            _ => 4,
        });
        let lobe = model.lobe();
        let position_mm: DVec3 = nodes.iter().map(|node| node.weight * node.position_mm).sum();
        let extent_mm = nodes
            .iter()
            .map(|node| (node.position_mm - position_mm).length())
            .fold(emitter_radius(&emitter), f64::max);
        let paths = model
            .acts()
            .filter_map(|(act, values)| match act {
                Act::Path(law) => Some((*law, values)),
                _ => None,
            })
            .collect();
        let directions = model.direction_factors();
        let plain = directions.is_empty() && model.refined().is_unity();
        let harmonic = model.refined().c_harmonics.iter().any(|h| h.amplitude_rel != 0.0);
        let around = !model.luminaire().distribution().is_rotational() || harmonic || !directions.is_empty();
        let centre = Node {
            position_mm,
            weight: 1.0,
            axis: DVec3::Z,
        };
        Self {
            model,
            luminaire: model.luminaire(),
            directions,
            paths,
            nodes,
            centre,
            extent_mm,
            lobe,
            sectors: model.sectors(),
            plain,
            around,
        }
    }

    /// Whether the light has no edges at the directions of the file.
    pub fn is_smooth(&self) -> bool {
        self.luminaire.is_smooth()
    }

    /// C, where anything depends on it, and γ.
    fn angles_deg(&self, direction: DVec3) -> (f64, f64) {
        if self.around {
            angles_deg(direction)
        } else {
            (0.0, polar_deg(direction))
        }
    }

    /// Factor on the far field towards `direction`, of any length, at these angles.
    fn factor_at(&self, c_deg: f64, gamma_deg: f64, direction: DVec3) -> f64 {
        let mut factor = self.model.refined().factor_towards(gamma_deg, direction);
        if !self.directions.is_empty() {
            let ray = Ray {
                c_deg,
                gamma_deg,
                direction: direction.normalize_or(DVec3::Z),
                mean_cosine: self.model.luminaire().mean_cosine(),
            };
            for of_effect in &self.directions {
                factor *= of_effect(&ray);
            }
        }
        factor
    }

    /// Illuminance in lx at `point_mm` on a plane whose normal reversed is `facing`: light along `facing` is normal.
    /// Light on the back of the plane does not count.
    pub fn illuminance_lx(&self, point_mm: DVec3, facing: DVec3) -> f64 {
        let whole = self.whole_lx(point_mm, facing);
        self.sectors
            .as_ref()
            .map_or(whole, |sectors| whole * sectors.left_at(point_mm, facing))
    }

    fn whole_lx(&self, point_mm: DVec3, facing: DVec3) -> f64 {
        self.nodes_at(point_mm)
            .iter()
            .map(|node| node.weight * self.of_node(node, point_mm, facing))
            .sum()
    }

    /// The parts of the emitter that a point tells apart.
    fn nodes_at(&self, point_mm: DVec3) -> &[Node] {
        let reach = self.extent_mm / point_mm.length();
        if self.lobe.is_none() && reach * reach < POINT_LIKE {
            std::slice::from_ref(&self.centre)
        } else {
            &self.nodes
        }
    }

    /// What of the light at `points_mm` of a plane neither effects nor refitted parameters change, kept for the next
    /// model of the same luminaire: a diagnosis asks for the same places hundreds of times.
    pub fn seen(&self, points_mm: &[DVec3], facing: DVec3) -> Arc<SeenLight> {
        let place = |place: DVec3| place.to_array().map(f64::to_bits);
        let mut key = vec![u64::from(self.around)];
        key.extend(place(facing));
        key.extend(self.nodes.iter().flat_map(Node::bits));
        key.push(u64::from(self.lobe.is_some()));
        key.extend(points_mm.iter().flat_map(|point| place(*point)));
        self.luminaire.memory.seen_or(key, || {
            let mut seen = Vec::with_capacity(points_mm.len());
            for &point_mm in points_mm {
                let nodes = self.nodes_at(point_mm).iter();
                seen.extend(nodes.map(|node| self.bare(node, point_mm, facing)));
            }
            seen
        })
    }

    /// [`illuminance_lx`](Self::illuminance_lx) at every point, from what was [`seen`](Self::seen) there.
    pub fn illuminances_lx(&self, points_mm: &[DVec3], facing: DVec3, seen: &SeenLight) -> Vec<f64> {
        let mut seen = seen.iter();
        let at = |point: &DVec3| {
            let nodes = self.nodes_at(*point).iter().zip(&mut seen);
            let whole: f64 = nodes
                .map(|(node, light)| node.weight * self.changed_lx(node, light, *point))
                .sum();
            self.sectors
                .as_ref()
                .map_or(whole, |sectors| whole * sectors.left_at(*point, facing))
        };
        points_mm.iter().map(at).collect()
    }

    /// What each direction of the distribution has to do with [`illuminance_lx`](Self::illuminance_lx): its number
    /// (`[ic * ng + ig]`) and the derivative in lx/cd, added up by `sink`.
    pub fn shares(&self, point_mm: DVec3, facing: DVec3, mut sink: impl FnMut(usize, f64)) {
        let left = self
            .sectors
            .as_ref()
            .map_or(1.0, |sectors| sectors.left_at(point_mm, facing));
        for node in self.nodes_at(point_mm) {
            let path = point_mm - node.position_mm;
            let (c_deg, gamma_deg) = angles_deg(path);
            let bare_cd = self.luminaire.intensity_cd(c_deg, gamma_deg);
            if bare_cd > 0.0 {
                let lx_per_cd = left * node.weight * self.of_node(node, point_mm, facing) / bare_cd;
                for (direction, weight) in self.luminaire.corners(c_deg, gamma_deg) {
                    if weight > 0.0 {
                        sink(direction, weight * lx_per_cd);
                    }
                }
            }
        }
    }

    fn of_node(&self, node: &Node, point_mm: DVec3, facing: DVec3) -> f64 {
        self.changed_lx(node, &self.bare(node, point_mm, facing), point_mm)
    }

    fn bare(&self, node: &Node, point_mm: DVec3, facing: DVec3) -> NodeLight {
        let path = point_mm - node.position_mm;
        let square = path.length_squared();
        let along = path.dot(facing);
        if along <= 0.0 {
            return NodeLight::default();
        }
        let length_mm = square.sqrt();
        let (c_deg, gamma_deg) = self.angles_deg(path);
        let mut bare_lx = self.luminaire.intensity_cd(c_deg, gamma_deg) * along / (square * length_mm) * 1e6;
        if let Some(lobe) = &self.lobe {
            bare_lx *= lobe.share_at(node.axis, path / length_mm, gamma_deg);
        }
        NodeLight {
            c_deg,
            gamma_deg,
            length_mm,
            bare_lx,
        }
    }

    /// The light of a node with what is refitted and the effects on its direction and path.
    fn changed_lx(&self, node: &Node, light: &NodeLight, point_mm: DVec3) -> f64 {
        if light.bare_lx == 0.0 {
            return 0.0;
        }
        let mut illuminance_lx = light.bare_lx;
        if !self.plain {
            illuminance_lx *= self.factor_at(light.c_deg, light.gamma_deg, point_mm - node.position_mm);
        }
        for (law, values) in &self.paths {
            illuminance_lx *= law(values, light.length_mm);
        }
        illuminance_lx
    }
}

/// The radius of an area, which its quadrature nodes do not reach.
fn emitter_radius(emitter: &Emitter) -> f64 {
    match emitter {
        Emitter::Leds { .. } => 0.0,
        area => area.extent_mm(),
    }
}
