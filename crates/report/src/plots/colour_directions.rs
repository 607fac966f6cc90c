//! Colours of a lamp by direction, as pictures take them.

use isolux_photometry::{HalfPlanes, HalfPlanesError};
use isolux_spectrum::Chromaticity;
use isolux_spectrum::cct::{Cct, nearest_planckian};

/// Radius of one step in (u′, v′) (CIE TN 001).
pub const STEP: f64 = isolux_spectrum::steps::STEP_UV;

/// Colour of one direction.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct DirectionColour {
    /// C and γ in degrees.
    pub at_deg: (f64, f64),
    /// Its chromaticity.
    pub chromaticity: Chromaticity,
    /// Expanded uncertainty (k = 2) of its correlated colour temperature, where it is known.
    pub expanded_cct_k: Option<f64>,
    /// Whether it counts for Δu′v′.
    pub counts: bool,
}

/// Colours of all directions that were read, and their average.
#[derive(Debug, Clone, PartialEq)]
pub struct ColourDirections {
    half_planes: HalfPlanes,
    directions: Vec<DirectionColour>,
    average: Chromaticity,
}

impl ColourDirections {
    /// Colours whose average is `average`.
    ///
    /// # Errors
    /// [`HalfPlanesError`] for directions on no half-planes.
    pub fn new(directions: Vec<DirectionColour>, average: Chromaticity) -> Result<Self, HalfPlanesError> {
        let at: Vec<(f64, f64)> = directions.iter().map(|direction| direction.at_deg).collect();
        Ok(Self {
            half_planes: HalfPlanes::new(&at)?,
            directions,
            average,
        })
    }

    pub(super) fn directions(&self) -> &[DirectionColour] {
        &self.directions
    }

    /// The largest γ that was read.
    pub(super) fn last_gamma_deg(&self) -> f64 {
        self.directions
            .iter()
            .map(|direction| direction.at_deg.1)
            .fold(0.0, f64::max)
    }

    /// Whether a half-plane was read, or stands for one by symmetry.
    pub(super) fn has_plane(&self, c_deg: f64) -> bool {
        self.half_planes.planes().any(|(at, _)| at == c_deg)
    }

    /// Chromaticity at (C, γ): colours mix by their lumens.
    pub(super) fn at(&self, c_deg: f64, gamma_deg: f64) -> Option<Chromaticity> {
        let (mut x, mut z) = (0.0, 0.0);
        self.half_planes.each_weight(c_deg, gamma_deg, |index, weight| {
            let of = self.directions[index].chromaticity;
            x += weight * of.x / of.y;
            z += weight * (1.0 - of.x - of.y) / of.y;
        });
        let sum = x + 1.0 + z;
        (sum.is_finite() && sum > 0.0).then(|| Chromaticity {
            x: x / sum,
            y: 1.0 / sum,
        })
    }

    /// The largest distance from the average of a direction that counts, in steps: what a picture has to hold. A dim
    /// direction may lie anywhere by its noise.
    pub(super) fn farthest_steps(&self) -> f64 {
        let counted = self.directions.iter().filter(|direction| direction.counts);
        let away = counted.map(|direction| {
            let (u, v) = self.difference(direction.chromaticity);
            u.hypot(v) / STEP
        });
        away.fold(0.0, f64::max)
    }

    /// Difference from the average in (u′, v′).
    pub(super) fn difference(&self, of: Chromaticity) -> (f64, f64) {
        let ((u, v), (u0, v0)) = (of.uv_1976(), self.average.uv_1976());
        (u - u0, v - v0)
    }
}

/// Correlated colour temperature where it means something.
pub(super) fn cct_k(of: Chromaticity) -> Option<f64> {
    nearest_planckian(of).and_then(Cct::meaningful).map(|cct| cct.cct_k)
}

#[cfg(test)]
pub(crate) mod tests {
    use super::*;

    /// A lamp that turns yellow to all sides, and more so towards C 0°.
    pub(crate) fn yellow_at_the_rim() -> ColourDirections {
        let mut directions = Vec::new();
        for c in [0.0, 90.0, 180.0, 270.0_f64] {
            for gamma in (0..=8)
                .map(|k| 10.0 * f64::from(k))
                .filter(|gamma| c == 0.0 || *gamma > 0.0)
            {
                let share = (gamma / 80.0).powi(2) + 0.2 * gamma.to_radians().sin() * c.to_radians().cos();
                directions.push(DirectionColour {
                    at_deg: (c, gamma),
                    chromaticity: Chromaticity {
                        x: 0.324 + 0.014 * share,
                        y: 0.334 + 0.022 * share,
                    },
                    expanded_cct_k: Some(30.0),
                    counts: gamma < 55.0,
                });
            }
        }
        ColourDirections::new(directions, Chromaticity { x: 0.328, y: 0.341 }).unwrap()
    }

    #[test]
    fn colours_between_directions_are_between_theirs() {
        let colours = yellow_at_the_rim();
        let at = |c, gamma| colours.at(c, gamma).unwrap();
        let (near, middle, far) = (at(0.0, 40.0), at(0.0, 45.0), at(0.0, 50.0));
        assert!(near.x < middle.x && middle.x < far.x);
        assert!((at(0.0, 40.0).x - colours.directions()[4].chromaticity.x).abs() < 1e-12);
        assert!(colours.has_plane(270.0) && !colours.has_plane(45.0));
    }
}
