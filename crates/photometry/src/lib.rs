#![doc = include_str!("../README.md")]
//!
//! [`IntensityDistribution`] holds absolute candela over a full circle of C half-planes and a range of γ. Between its
//! points it is bilinear in (C, γ), periodic in C; outside its γ range it is dark. Every integral (flux, zones,
//! divergence) is the exact integral of that interpolant over the sphere, so that no number depends on a rule of
//! summation. [`IntensityDistribution::on_smooth_grid`] is the same light on a grid so fine that its bilinear
//! interpolant is smooth.
//!
//! Frame (CIE 121, EN 13032-1): d(C, γ) = (sin γ cos C, sin γ sin C, cos γ).

mod around;
mod asymmetry;
mod between;
mod circle;
mod curve;
mod direction;
mod distribution;
mod divergence;
mod flux;
mod half_planes;
pub mod ratings;
mod sector;
mod smooth;
mod symmetry;

pub use around::{AroundSpline, BEYOND_RINGS, Missed, Ring, bands};
pub use asymmetry::{Asymmetry, DIP_REL};
pub use between::{MissedOfRing, OF_LEFT_OUT, ReadHalfPlanes, left_out, u_between, u_beyond_rings};
pub use circle::{Circle, NotRound};
pub use direction::{angles_deg, direction, polar_deg};
pub use distribution::{DistributionError, IntensityDistribution, Peak};
pub use divergence::Divergence;
pub use flux::linear_times_sine;
pub use half_planes::{HalfPlanes, HalfPlanesError};
pub use sector::Sector;
pub use symmetry::{Symmetry, SymmetryError};
