//! The direct irradiance along a line of sight, and flat sets of such lines.
//!
//! Light from an emitter point e reaches the sensor point p along v = p − e, and both the pixel and the emitter are
//! flat, so v runs over a flat parallelogram or disc while p or e runs over its own.

use std::f64::consts::{PI, TAU};

use glam::DVec3;

use crate::angles::{Lanes, Sights};
use crate::rules;
use crate::table::IntensityTable;

/// The integrand: irradiance in lx on a surface that faces along −`toward`, for a line of sight v in mm.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Light<'a> {
    pub table: &'a IntensityTable,
    /// Unit vector R·(0, 0, 1): the cosine of incidence is its product with the direction of light.
    pub toward: DVec3,
    /// Light that the path swallows, 1/mm.
    pub extinction_per_mm: f64,
}

impl Light<'_> {
    /// I(v)·cos α / |v|² in lx; zero where the surface is lit from behind.
    #[inline]
    pub fn at(&self, v: DVec3) -> f64 {
        let projected = self.toward.dot(v);
        if projected <= 0.0 {
            return 0.0;
        }
        let square = v.length_squared();
        let length = square.sqrt();
        let light = 1e6 * self.table.toward(v) * projected / (square * length);
        if self.extinction_per_mm == 0.0 {
            light
        } else {
            light * (-self.extinction_per_mm * length).exp()
        }
    }

    /// The light of the lines of sight, lx.
    #[inline]
    pub fn along(&self, sights: &Sights) -> Lanes {
        let mut light = self.table.several(&sights.c, &sights.gamma);
        for (light, per_cd) in light.iter_mut().zip(sights.per_cd) {
            *light *= per_cd;
        }
        if self.extinction_per_mm != 0.0 {
            for (light, length) in light.iter_mut().zip(sights.length) {
                *light *= (-self.extinction_per_mm * length).exp();
            }
        }
        light
    }
}

/// A flat set of lines of sight, in mm.
#[derive(Debug, Clone, Copy)]
pub(crate) enum Patch {
    /// v = corner + s·first + t·second, s and t in [0, 1].
    Parallelogram { corner: DVec3, first: DVec3, second: DVec3 },
    /// v = centre + x·first + y·second, x² + y² ≤ 1 (the vectors have the disc's radius as their length).
    Disc { centre: DVec3, first: DVec3, second: DVec3 },
}

impl Patch {
    pub fn centre(&self) -> DVec3 {
        match *self {
            Self::Parallelogram { corner, first, second } => corner + 0.5 * (first + second),
            Self::Disc { centre, .. } => centre,
        }
    }

    /// Radius of a ball round the centre that holds the patch.
    pub fn radius(&self) -> f64 {
        match *self {
            Self::Parallelogram { first, second, .. } => 0.5 * (first + second).length().max((first - second).length()),
            Self::Disc { first, .. } => first.length(),
        }
    }

    pub fn shifted(&self, by: DVec3) -> Self {
        match *self {
            Self::Parallelogram { corner, first, second } => Self::Parallelogram {
                corner: corner + by,
                first,
                second,
            },
            Self::Disc { centre, first, second } => Self::Disc {
                centre: centre + by,
                first,
                second,
            },
        }
    }

    /// The patch with every vector mapped (a rotation).
    pub fn mapped(&self, by: impl Fn(DVec3) -> DVec3) -> Self {
        match *self {
            Self::Parallelogram { corner, first, second } => Self::Parallelogram {
                corner: by(corner),
                first: by(first),
                second: by(second),
            },
            Self::Disc { centre, first, second } => Self::Disc {
                centre: by(centre),
                first: by(first),
                second: by(second),
            },
        }
    }

    /// The corner at s = t = 0 and the sides; of a disc, those of the square round it.
    pub fn corner_and_sides(&self) -> [DVec3; 3] {
        match *self {
            Self::Parallelogram { corner, first, second } => [corner, first, second],
            Self::Disc { centre, first, second } => [centre - first - second, 2.0 * first, 2.0 * second],
        }
    }

    /// Its area.
    pub fn area(&self) -> f64 {
        match *self {
            Self::Parallelogram { first, second, .. } => first.cross(second).length(),
            Self::Disc { first, second, .. } => PI * first.cross(second).length(),
        }
    }

    /// Both sides of a parallelogram, or two radii of a disc.
    pub fn sides(&self) -> (DVec3, DVec3) {
        match *self {
            Self::Parallelogram { first, second, .. } | Self::Disc { first, second, .. } => (first, second),
        }
    }

    /// Nodes (offset from the centre) and weights, sum 1, of a product rule of `n` points a side (disc: n radii, 2n + 2
    /// azimuths), exact for polynomials up to degree 2n − 1 at least.
    pub fn nodes(&self, n: usize, out: &mut Vec<(DVec3, f64)>) {
        out.clear();
        match *self {
            Self::Parallelogram { first, second, .. } => {
                for &(s, ws) in rules::gauss(n) {
                    for &(t, wt) in rules::gauss(n) {
                        out.push(((s - 0.5) * first + (t - 0.5) * second, ws * wt));
                    }
                }
            }
            Self::Disc { first, second, .. } => {
                let azimuths = 2 * n + 2;
                for (ring, &(area, w)) in rules::gauss(n).iter().enumerate() {
                    let radius = area.sqrt();
                    for k in 0..azimuths {
                        let turn = 0.5 * (ring % 2) as f64 + 0.25;
                        let azimuth = TAU * (k as f64 + turn) / azimuths as f64;
                        out.push((
                            radius * (azimuth.cos() * first + azimuth.sin() * second),
                            w / azimuths as f64,
                        ));
                    }
                }
            }
        }
    }
}
