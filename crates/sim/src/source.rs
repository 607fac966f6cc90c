//! What emits: the luminaire's intensity table spread over points and flat areas.

use std::sync::Arc;

use glam::{DMat3, DVec3};

use crate::patch::Patch;
use crate::stop::Stop;
use crate::table::IntensityTable;

/// Where the light of one part leaves from. Lengths in mm, luminaire frame; areas lie in planes z = const and emit
/// evenly.
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
    /// A ring of even areal density between two radii round `centre`.
    Ring {
        /// Its centre.
        centre: DVec3,
        /// Inner radius.
        inner: f64,
        /// Outer radius.
        outer: f64,
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
    /// The lines of sight from the shape to the origin, −e over the shape, as patches and their shares of the area
    /// (the hole of a ring is negative); none for a point.
    pub(crate) fn patches(&self) -> Vec<(Patch, f64)> {
        let disc = |centre: DVec3, radius: f64| Patch::Disc {
            centre: -centre,
            first: radius * DVec3::X,
            second: radius * DVec3::Y,
        };
        match *self {
            Self::Point(_) => Vec::new(),
            Self::Disc { centre, radius } => vec![(disc(centre, radius), 1.0)],
            Self::Ring { centre, inner, outer } => {
                let area = outer * outer - inner * inner;
                let mut patches = vec![(disc(centre, outer), outer * outer / area)];
                if inner > 0.0 {
                    patches.push((disc(centre, inner), -inner * inner / area));
                }
                patches
            }
            Self::Rectangle { centre, half: [x, y] } => {
                let corner = -centre - DVec3::new(x, y, 0.0);
                vec![(
                    Patch::Parallelogram {
                        corner,
                        first: 2.0 * x * DVec3::X,
                        second: 2.0 * y * DVec3::Y,
                    },
                    1.0,
                )]
            }
        }
    }

    /// The point of the shape for two numbers in [0, 1), evenly over its area.
    #[inline]
    pub fn point(&self, u: f64, w: f64) -> DVec3 {
        let polar = |square: f64| {
            let (sin, cos) = (std::f64::consts::TAU * w).sin_cos();
            DVec3::new(cos, sin, 0.0) * square.sqrt()
        };
        match *self {
            Self::Point(centre) => centre,
            Self::Disc { centre, radius } => centre + polar(u) * radius,
            Self::Ring { centre, inner, outer } => centre + polar(inner * inner + u * (outer * outer - inner * inner)),
            Self::Rectangle { centre, half: [x, y] } => {
                centre + DVec3::new((2.0 * u - 1.0) * x, (2.0 * w - 1.0) * y, 0.0)
            }
        }
    }

    /// Its middle.
    pub fn centre(&self) -> DVec3 {
        match *self {
            Self::Point(centre)
            | Self::Disc { centre, .. }
            | Self::Ring { centre, .. }
            | Self::Rectangle { centre, .. } => centre,
        }
    }

    /// Radius round the middle that holds it.
    pub fn radius(&self) -> f64 {
        match *self {
            Self::Point(_) => 0.0,
            Self::Disc { radius, .. } => radius,
            Self::Ring { outer, .. } => outer,
            Self::Rectangle { half: [x, y], .. } => x.hypot(y),
        }
    }
}

/// One part of the emitter: a share of the luminaire's far field that leaves from one shape.
#[derive(Debug, Clone)]
pub struct Part {
    /// Share of the table's intensity; the shares of a luminaire sum to 1.
    pub share: f64,
    /// Where it leaves from.
    pub shape: Shape,
    /// Its intensity distribution.
    pub table: Arc<IntensityTable>,
    /// Rotation from the part's own frame (in which the table stands) to the luminaire's; `None` is the identity.
    pub aim: Option<DMat3>,
}

/// An emitter: parts whose light adds.
#[derive(Debug, Clone)]
pub struct LightSource {
    parts: Vec<Part>,
    extinction_per_mm: f64,
    stop: Stop,
}

impl LightSource {
    /// The emitter of these parts.
    pub fn new(parts: Vec<Part>) -> Self {
        Self {
            parts,
            extinction_per_mm: 0.0,
            stop: Stop::default(),
        }
    }

    /// All of `table` from one point, disc or rectangle.
    pub fn single(table: Arc<IntensityTable>, shape: Shape) -> Self {
        Self::new(vec![Part {
            share: 1.0,
            shape,
            table,
            aim: None,
        }])
    }

    /// The same emitter in a medium that swallows light: exp(−k·ℓ) over a path of ℓ mm (Beer–Lambert).
    #[must_use]
    pub fn in_medium(mut self, extinction_per_mm: f64) -> Self {
        self.extinction_per_mm = extinction_per_mm;
        self
    }

    /// The same emitter for solvers that end when `stop` is requested, with a map that is not whole.
    #[must_use]
    pub fn until(mut self, stop: Stop) -> Self {
        self.stop = stop;
        self
    }

    /// Whether solvers are asked to end.
    pub(crate) fn is_stopped(&self) -> bool {
        self.stop.is_requested()
    }

    /// Extinction of the medium, 1/mm.
    pub fn extinction_per_mm(&self) -> f64 {
        self.extinction_per_mm
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
