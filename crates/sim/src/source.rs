//! What emits: the luminaire's intensity table spread over points and flat areas.

use std::sync::Arc;

use glam::{DMat3, DVec3};

use crate::patch::Patch;
use crate::table::Table;

/// Where the light of one part leaves from. Lengths in mm, luminaire frame; areas lie in planes z = const and emit evenly.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Shape {
    /// One point.
    Point(DVec3),
    /// A disc of `radius` round `centre`.
    Disc {
        /// Its centre.
        centre: DVec3,
        /// Its radius.
        radius: f64,
    },
    /// A rectangle of `half` sides along x and y round `centre`.
    Rectangle {
        /// Its centre.
        centre: DVec3,
        /// Half its sides.
        half: [f64; 2],
    },
}

impl Shape {
    /// The lines of sight from the shape to the point p, before p is added: −e over the shape. `None` for a point.
    pub(crate) fn patch(&self) -> Option<Patch> {
        match *self {
            Self::Point(_) => None,
            Self::Disc { centre, radius } => Some(Patch::Disc {
                centre: -centre,
                first: radius * DVec3::X,
                second: radius * DVec3::Y,
            }),
            Self::Rectangle { centre, half: [x, y] } => Some(Patch::Parallelogram {
                corner: -centre - DVec3::new(x, y, 0.0),
                first: 2.0 * x * DVec3::X,
                second: 2.0 * y * DVec3::Y,
            }),
        }
    }

    /// Its middle.
    pub fn centre(&self) -> DVec3 {
        match *self {
            Self::Point(centre) | Self::Disc { centre, .. } | Self::Rectangle { centre, .. } => centre,
        }
    }

    /// Radius round the middle that holds it.
    pub fn radius(&self) -> f64 {
        match *self {
            Self::Point(_) => 0.0,
            Self::Disc { radius, .. } => radius,
            Self::Rectangle { half: [x, y], .. } => x.hypot(y),
        }
    }
}

/// One part of the emitter: a share of the luminaire's far field that leaves from one shape.
#[derive(Debug, Clone)]
pub struct Part {
    /// Share of the table's intensity; the shares of a luminaire sum to 1. Negative for the hole of a ring.
    pub share: f64,
    /// Where it leaves from.
    pub shape: Shape,
    /// Its intensity distribution.
    pub table: Arc<Table>,
    /// Rotation from the part's own frame (in which the table stands) to the luminaire's; `None` is the identity.
    pub aim: Option<DMat3>,
}

/// An emitter: parts whose light adds.
#[derive(Debug, Clone)]
pub struct Source {
    parts: Vec<Part>,
}

impl Source {
    /// The emitter of these parts.
    pub fn new(parts: Vec<Part>) -> Self {
        Self { parts }
    }

    /// All of `table` from one point, disc or rectangle.
    pub fn single(table: Arc<Table>, shape: Shape) -> Self {
        Self::new(vec![Part {
            share: 1.0,
            shape,
            table,
            aim: None,
        }])
    }

    /// A ring of even areal density between two radii in mm: the outer disc less the inner one.
    pub fn ring(table: &Arc<Table>, centre: DVec3, inner: f64, outer: f64) -> Self {
        let area = outer * outer - inner * inner;
        let part = |share, radius| Part {
            share,
            shape: Shape::Disc { centre, radius },
            table: Arc::clone(table),
            aim: None,
        };
        let mut parts = vec![part(outer * outer / area, outer)];
        if inner > 0.0 {
            parts.push(part(-inner * inner / area, inner));
        }
        Self::new(parts)
    }

    /// Its parts.
    pub fn parts(&self) -> &[Part] {
        &self.parts
    }

    /// Radius of a ball round the light centre that holds the emitter, mm.
    pub fn radius(&self) -> f64 {
        self.parts
            .iter()
            .map(|part| part.shape.centre().length() + part.shape.radius())
            .fold(0.0, f64::max)
    }
}
