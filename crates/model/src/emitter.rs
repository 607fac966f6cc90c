//! What shines: the luminous parts of a luminaire as shapes and as quadrature nodes.

use glam::DVec3;
use serde::{Deserialize, Serialize};

use crate::quadrature::gauss_legendre;

/// The luminous shape, centred on the light centre in the plane z = 0 unless positions say otherwise.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(tag = "shape", rename_all = "snake_case", deny_unknown_fields)]
pub enum Emitter {
    /// The light centre itself.
    Point {},
    /// A disc of even areal density.
    Disc {
        /// Its diameter.
        diameter_mm: f64,
    },
    /// A rectangle of even areal density.
    Rectangle {
        /// Extents along x and y.
        size_mm: [f64; 2],
    },
    /// A ring of even areal density.
    Ring {
        /// Inner diameter.
        inner_diameter_mm: f64,
        /// Outer diameter.
        outer_diameter_mm: f64,
    },
    /// Single LEDs, either at given places or evenly on circles.
    Leds {
        /// [x, y] or [x, y, z] of each LED.
        #[serde(default, skip_serializing_if = "Vec::is_empty")]
        position_mm: Vec<Vec<f64>>,
        /// Relative weight of each LED; all equal when absent. With `radius_mm`: one weight a circle, of each of its
        /// LEDs.
        #[serde(default, skip_serializing_if = "Vec::is_empty")]
        weight: Vec<f64>,
        /// Radius of each circle.
        #[serde(default, skip_serializing_if = "Vec::is_empty")]
        radius_mm: Vec<f64>,
        /// LEDs on each circle, the first at C0.
        #[serde(default, skip_serializing_if = "Vec::is_empty")]
        count: Vec<usize>,
        /// Inward tilt of each LED's axis towards the optical axis.
        #[serde(default)]
        aim_deg: f64,
    },
}

/// Largest extent of a luminaire: 100 m.
const MOST_MM: f64 = 1e5;
/// Most LEDs of an emitter.
const MOST_LEDS: usize = 100_000;

/// Why an emitter is impossible.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum EmitterError {
    /// A length outside what a luminaire can have.
    #[error("{value} is not within {least} to {MOST_MM}")]
    Length {
        /// The key.
        key: &'static str,
        /// Its value.
        value: f64,
        /// The least that is possible: a position may be negative.
        least: f64,
    },
    /// More LEDs than a simulation holds.
    #[error("emitter leds: {0} LEDs; at most {MOST_LEDS} are possible")]
    TooMany(usize),
    /// A ring turned inside out.
    #[error("emitter: inner_diameter_mm = {inner_mm} must be below outer_diameter_mm = {outer_mm}")]
    Ring {
        /// Inner diameter.
        inner_mm: f64,
        /// Outer diameter.
        outer_mm: f64,
    },
    /// Neither or both ways of placing LEDs.
    #[error("emitter leds: give either position_mm or radius_mm with count")]
    Places,
    /// A position that is not [x, y] or [x, y, z].
    #[error("emitter leds: position_mm[{index}] has {length} numbers; [x, y] or [x, y, z] are possible")]
    Position {
        /// Which LED.
        index: usize,
        /// How many numbers it has.
        length: usize,
    },
    /// Lists of different lengths.
    #[error("emitter leds: {weights} weights for {places} {what}")]
    Weights {
        /// Number of weights or counts.
        weights: usize,
        /// Number of LEDs or circles.
        places: usize,
        /// "LEDs" or "circles".
        what: &'static str,
    },
    /// A weight that is negative or not finite, or all are zero.
    #[error("emitter leds: weights must be finite, not negative, and not all zero")]
    WeightValue,
    /// An impossible aim.
    #[error("emitter leds: aim_deg = {0} must be between -45 and 45")]
    Aim(f64),
}

/// A point that stands for a part of the emitter.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Node {
    /// Place in the luminaire frame.
    pub position_mm: DVec3,
    /// Share of the luminaire's light; all nodes together make 1.
    pub weight: f64,
    /// Unit vector of the part's own optical axis.
    pub axis: DVec3,
}

impl Node {
    /// All of it, as the key of a memory.
    pub(crate) fn bits(&self) -> [u64; 7] {
        let [x, y, z] = self.position_mm.to_array();
        let [ax, ay, az] = self.axis.to_array();
        [x, y, z, ax, ay, az, self.weight].map(f64::to_bits)
    }
}

impl EmitterError {
    /// The key that is to blame, where it is one.
    pub fn key(&self) -> Option<&'static str> {
        match self {
            Self::Length { key, .. } => Some(key),
            Self::Ring { .. } => Some("inner_diameter_mm"),
            Self::Position { .. } => Some("position_mm"),
            Self::TooMany(_) => Some("count"),
            Self::WeightValue => Some("weight"),
            Self::Aim(_) => Some("aim_deg"),
            Self::Places | Self::Weights { .. } => None,
        }
    }
}

impl Emitter {
    /// The emitter, if it is possible.
    ///
    /// # Errors
    /// [`EmitterError`] naming the key.
    pub fn checked(self) -> Result<Self, EmitterError> {
        let length = |key: &'static str, value: f64| {
            if (0.0..=MOST_MM).contains(&value) {
                Ok(())
            } else {
                let least = 0.0;
                Err(EmitterError::Length { key, value, least })
            }
        };
        match &self {
            Self::Point {} => {}
            Self::Disc { diameter_mm } => length("diameter_mm", *diameter_mm)?,
            Self::Rectangle { size_mm } => {
                length("size_mm", size_mm[0])?;
                length("size_mm", size_mm[1])?;
            }
            Self::Ring {
                inner_diameter_mm,
                outer_diameter_mm,
            } => {
                length("inner_diameter_mm", *inner_diameter_mm)?;
                length("outer_diameter_mm", *outer_diameter_mm)?;
                if inner_diameter_mm >= outer_diameter_mm {
                    return Err(EmitterError::Ring {
                        inner_mm: *inner_diameter_mm,
                        outer_mm: *outer_diameter_mm,
                    });
                }
            }
            Self::Leds {
                position_mm,
                weight,
                radius_mm,
                count,
                aim_deg,
            } => {
                if position_mm.is_empty() == radius_mm.is_empty() {
                    return Err(EmitterError::Places);
                }
                if let Some(index) = position_mm.iter().position(|place| !matches!(place.len(), 2 | 3)) {
                    return Err(EmitterError::Position {
                        index,
                        length: position_mm[index].len(),
                    });
                }
                let possible = -MOST_MM..=MOST_MM;
                if let Some(value) = position_mm.iter().flatten().find(|value| !possible.contains(value)) {
                    return Err(EmitterError::Length {
                        key: "position_mm",
                        value: *value,
                        least: -MOST_MM,
                    });
                }
                for value in radius_mm {
                    length("radius_mm", *value)?;
                }
                let (places, what) = if radius_mm.is_empty() {
                    (position_mm.len(), "LEDs")
                } else {
                    (radius_mm.len(), "circles")
                };
                let unequal = |weights: usize| Err(EmitterError::Weights { weights, places, what });
                if count.len() != radius_mm.len() {
                    return unequal(count.len());
                }
                if !weight.is_empty() && weight.len() != places {
                    return unequal(weight.len());
                }
                let leds = count
                    .iter()
                    .fold(position_mm.len(), |leds, count| leds.saturating_add(*count));
                if leds > MOST_LEDS {
                    return Err(EmitterError::TooMany(leds));
                }
                let total: f64 = weight.iter().sum();
                if !(total.is_finite() && weight.iter().all(|w| *w >= 0.0)) || (!weight.is_empty() && total <= 0.0) {
                    return Err(EmitterError::WeightValue);
                }
                if !radius_mm.is_empty() && count.iter().sum::<usize>() == 0 {
                    return Err(EmitterError::WeightValue);
                }
                if !(-45.0..=45.0).contains(aim_deg) {
                    return Err(EmitterError::Aim(*aim_deg));
                }
            }
        }
        Ok(self)
    }

    /// Radius of the smallest sphere around the light centre that holds the emitter.
    pub fn extent_mm(&self) -> f64 {
        match self {
            Self::Point {} => 0.0,
            Self::Disc { diameter_mm } => diameter_mm / 2.0,
            Self::Rectangle { size_mm } => size_mm[0].hypot(size_mm[1]) / 2.0,
            Self::Ring { outer_diameter_mm, .. } => outer_diameter_mm / 2.0,
            Self::Leds { .. } => self
                .nodes(1)
                .iter()
                .map(|node| node.position_mm.length())
                .fold(0.0, f64::max),
        }
    }

    /// Inward tilt of the parts' axes.
    pub fn aim_deg(&self) -> f64 {
        match self {
            Self::Leds { aim_deg, .. } => *aim_deg,
            _ => 0.0,
        }
    }

    /// Quadrature nodes of the emitter. LEDs are what they are; areas get a product rule of about `order` nodes in each
    /// direction, exact for polynomials of degree 2·order − 1.
    pub fn nodes(&self, order: usize) -> Vec<Node> {
        let order = order.max(1);
        match self {
            Self::Point {} => vec![node(DVec3::ZERO, 1.0)],
            Self::Disc { diameter_mm } if *diameter_mm == 0.0 => vec![node(DVec3::ZERO, 1.0)],
            Self::Disc { diameter_mm } => annulus(0.0, diameter_mm / 2.0, order),
            Self::Ring {
                inner_diameter_mm,
                outer_diameter_mm,
            } => annulus(inner_diameter_mm / 2.0, outer_diameter_mm / 2.0, order),
            Self::Rectangle { size_mm } => {
                let rule = gauss_legendre(order);
                let mut nodes = Vec::with_capacity(order * order);
                for (y, wy) in &rule {
                    for (x, wx) in &rule {
                        let place = DVec3::new(x * size_mm[0] / 2.0, y * size_mm[1] / 2.0, 0.0);
                        nodes.push(node(place, wx * wy / 4.0));
                    }
                }
                nodes
            }
            Self::Leds {
                position_mm,
                weight,
                radius_mm,
                count,
                aim_deg,
            } => {
                let mut nodes = Vec::new();
                for (index, place) in position_mm.iter().enumerate() {
                    let place = DVec3::new(place[0], place[1], place.get(2).copied().unwrap_or(0.0));
                    nodes.push(node(place, weight.get(index).copied().unwrap_or(1.0)));
                }
                for (index, (radius, count)) in radius_mm.iter().zip(count).enumerate() {
                    for led in 0..*count {
                        let (sin, cos) = (std::f64::consts::TAU * led as f64 / *count as f64).sin_cos();
                        let place = DVec3::new(radius * cos, radius * sin, 0.0);
                        nodes.push(node(place, weight.get(index).copied().unwrap_or(1.0)));
                    }
                }
                let total: f64 = nodes.iter().map(|node| node.weight).sum();
                let (sin, cos) = aim_deg.to_radians().sin_cos();
                for node in &mut nodes {
                    node.weight /= total;
                    let radial = node.position_mm.truncate();
                    if let Some(out) = radial.try_normalize() {
                        node.axis = DVec3::new(-out.x * sin, -out.y * sin, cos);
                    }
                }
                nodes
            }
        }
    }
}

fn node(position_mm: DVec3, weight: f64) -> Node {
    Node {
        position_mm,
        weight,
        axis: DVec3::Z,
    }
}

/// Product rule on an annulus of even areal density: Gauss–Legendre in r², trapezoid in azimuth.
fn annulus(inner_mm: f64, outer_mm: f64, order: usize) -> Vec<Node> {
    let azimuths = (2 * order).max(4);
    let (low, high) = (inner_mm * inner_mm, outer_mm * outer_mm);
    let mut nodes = Vec::with_capacity(order * azimuths);
    for (row, (x, w)) in gauss_legendre(order).into_iter().enumerate() {
        let radius = (0.5 * ((high - low) * x + high + low)).max(0.0).sqrt();
        for k in 0..azimuths {
            // Rows are staggered: equal azimuths on all radii would favour one direction.
            let turn = (k as f64 + 0.5 * (row % 2) as f64) / azimuths as f64;
            let (sin, cos) = (std::f64::consts::TAU * turn).sin_cos();
            nodes.push(node(
                DVec3::new(radius * cos, radius * sin, 0.0),
                w / (2.0 * azimuths as f64),
            ));
        }
    }
    nodes
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn areas_have_their_second_moments() {
        let moment = |emitter: Emitter, order| -> (f64, f64) {
            let nodes = emitter.nodes(order);
            assert!((nodes.iter().map(|n| n.weight).sum::<f64>() - 1.0).abs() < 1e-14);
            (
                nodes.iter().map(|n| n.weight * n.position_mm.x.powi(2)).sum(),
                nodes.iter().map(|n| n.weight * n.position_mm.y.powi(2)).sum(),
            )
        };
        for order in 1..5 {
            let (x, y) = moment(Emitter::Disc { diameter_mm: 2.0 }, order);
            assert!((x - 0.25).abs() < 1e-14 && (y - 0.25).abs() < 1e-14, "{x} {y}");
            let (x, _) = moment(
                Emitter::Ring {
                    inner_diameter_mm: 2.0,
                    outer_diameter_mm: 4.0,
                },
                order,
            );
            assert!((x - (1.0 + 4.0) / 4.0).abs() < 1e-13, "{x}");
        }
        let (x, y) = moment(Emitter::Rectangle { size_mm: [2.0, 4.0] }, 2);
        assert!((x - 1.0 / 3.0).abs() < 1e-14 && (y - 4.0 / 3.0).abs() < 1e-14);
    }

    #[test]
    fn leds_aim_inward_and_weigh_one() {
        let emitter = Emitter::Leds {
            position_mm: vec![],
            weight: vec![1.0, 3.0],
            radius_mm: vec![0.0, 28.0],
            count: vec![1, 4],
            aim_deg: 5.0,
        };
        let nodes = emitter.checked().unwrap().nodes(1);
        assert_eq!(nodes.len(), 5);
        assert!((nodes.iter().map(|n| n.weight).sum::<f64>() - 1.0).abs() < 1e-15);
        assert_eq!(nodes[0].axis, DVec3::Z, "an LED on the axis has nowhere to lean");
        assert!(nodes[1].position_mm.x > 0.0 && nodes[1].axis.x < 0.0);
        assert!((nodes[1].axis.z - 5f64.to_radians().cos()).abs() < 1e-15);
    }

    #[test]
    fn impossible_emitters_are_named() {
        assert!(matches!(
            Emitter::Disc { diameter_mm: f64::NAN }.checked(),
            Err(EmitterError::Length { .. })
        ));
        let both = Emitter::Leds {
            position_mm: vec![],
            weight: vec![],
            radius_mm: vec![],
            count: vec![],
            aim_deg: 0.0,
        };
        assert_eq!(both.checked(), Err(EmitterError::Places));
    }
}
