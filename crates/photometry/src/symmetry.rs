//! Symmetry about C planes: what a file stores against the full circle that the light fills.

use crate::{DistributionError, IntensityDistribution};

/// Symmetry of a distribution about its C planes.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Symmetry {
    /// None.
    None,
    /// Rotational about the axis.
    Rotational,
    /// About the plane C0–C180: I(C) = I(360° − C).
    C0C180,
    /// About the plane C90–C270: I(C) = I(180° − C).
    C90C270,
    /// About both planes.
    Quadrant,
}

/// Why stored half-planes cannot be expanded to a full circle.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum SymmetryError {
    /// A stored half-plane outside the part of the circle that the symmetry stores.
    #[error("half-plane C{c_deg} lies outside the stored part of a {symmetry:?} distribution")]
    Outside {
        /// The symmetry.
        symmetry: Symmetry,
        /// The offending angle.
        c_deg: f64,
    },
    /// The half-planes that were stored make no valid distribution.
    #[error(transparent)]
    Distribution(#[from] DistributionError),
}

impl Symmetry {
    /// What it is about, as words.
    pub const fn words(self) -> &'static str {
        match self {
            Self::None => "none",
            Self::Rotational => "rotational",
            Self::C0C180 => "about the plane C 0°–C 180°",
            Self::C90C270 => "about the plane C 90°–C 270°",
            Self::Quadrant => "about both planes C 0°–C 180° and C 90°–C 270°",
        }
    }

    /// The images of a half-plane under the symmetry, itself first, in degrees within [0, 360).
    pub fn images_deg(self, c_deg: f64) -> Vec<f64> {
        let mirror_0 = (360.0 - c_deg).rem_euclid(360.0);
        let mirror_90 = (180.0 - c_deg).rem_euclid(360.0);
        let turned = (c_deg + 180.0).rem_euclid(360.0);
        let c_deg = c_deg.rem_euclid(360.0);
        match self {
            Self::None | Self::Rotational => vec![c_deg],
            Self::C0C180 => vec![c_deg, mirror_0],
            Self::C90C270 => vec![c_deg, mirror_90],
            Self::Quadrant => vec![c_deg, mirror_0, mirror_90, turned],
        }
    }

    /// Whether the symmetry stores this half-plane: C0…C180, C90…C270 (or C270 through C0 to C90), C0…C90.
    fn stores(self, c_deg: f64) -> bool {
        match self {
            Self::None | Self::Rotational => true,
            Self::C0C180 => (0.0..=180.0).contains(&c_deg),
            Self::C90C270 => (90.0..=270.0).contains(&c_deg) || c_deg <= 90.0 || c_deg >= 270.0,
            Self::Quadrant => (0.0..=90.0).contains(&c_deg),
        }
    }
}

impl IntensityDistribution {
    /// The full circle from the half-planes that a symmetric file stores.
    ///
    /// `rows`: (C in degrees, intensities in candela, one a γ), in any order; planes that coincide after mirroring must
    /// be the mirror planes themselves and are taken once. [`Symmetry::Rotational`] takes the first row alone.
    ///
    /// # Errors
    /// [`SymmetryError`] for a half-plane that the symmetry does not store and for anything that
    /// [`IntensityDistribution::new`] refuses.
    pub fn expand(symmetry: Symmetry, rows: &[(f64, Vec<f64>)], gamma_deg: Vec<f64>) -> Result<Self, SymmetryError> {
        let mut planes: Vec<(f64, &[f64])> = Vec::new();
        for (c_deg, row) in rows {
            if !symmetry.stores(*c_deg) {
                return Err(SymmetryError::Outside {
                    symmetry,
                    c_deg: *c_deg,
                });
            }
            for image in symmetry.images_deg(*c_deg) {
                if !planes.iter().any(|(c, _)| (*c - image).abs() < 1e-9) {
                    planes.push((image, row));
                }
            }
        }
        if symmetry == Symmetry::Rotational {
            planes.truncate(1);
            if let Some(plane) = planes.first_mut() {
                plane.0 = 0.0;
            }
        }
        planes.sort_by(|a, b| a.0.total_cmp(&b.0));
        let c_deg = planes.iter().map(|plane| plane.0).collect();
        let intensity_cd = planes.iter().flat_map(|plane| plane.1.iter().copied()).collect();
        Ok(Self::new(c_deg, gamma_deg, intensity_cd)?)
    }

    /// The highest symmetry that the intensities really have, within `tolerance_cd`.
    ///
    /// A mirror counts only where every half-plane has its image on the grid.
    pub fn detect_symmetry(&self, tolerance_cd: f64) -> Symmetry {
        if (1..self.c_deg().len()).all(|plane| self.rows_agree(0, plane, tolerance_cd)) {
            return Symmetry::Rotational;
        }
        let has = |symmetry: Symmetry| {
            (0..self.c_deg().len()).all(|plane| {
                symmetry.images_deg(self.c_deg()[plane]).iter().all(|image| {
                    let partner = self.c_deg().iter().position(|c| (c - image).abs() < 1e-9);
                    partner.is_some_and(|partner| self.rows_agree(plane, partner, tolerance_cd))
                })
            })
        };
        match (has(Symmetry::C0C180), has(Symmetry::C90C270)) {
            (true, true) => Symmetry::Quadrant,
            (true, false) => Symmetry::C0C180,
            (false, true) => Symmetry::C90C270,
            (false, false) => Symmetry::None,
        }
    }

    fn rows_agree(&self, a: usize, b: usize, tolerance_cd: f64) -> bool {
        self.row(a)
            .iter()
            .zip(self.row(b))
            .all(|(x, y)| (x - y).abs() <= tolerance_cd)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn gamma() -> Vec<f64> {
        vec![0.0, 90.0]
    }

    #[test]
    fn every_class_fills_the_circle() {
        let row = |v: f64| vec![100.0, v];
        let quadrant = IntensityDistribution::expand(
            Symmetry::Quadrant,
            &[(0.0, row(1.0)), (30.0, row(2.0)), (90.0, row(3.0))],
            gamma(),
        )
        .unwrap();
        assert_eq!(quadrant.c_deg(), [0.0, 30.0, 90.0, 150.0, 180.0, 210.0, 270.0, 330.0]);
        assert_eq!(quadrant.intensity_cd_at(210.0, 90.0), 2.0);
        assert_eq!(quadrant.detect_symmetry(0.0), Symmetry::Quadrant);

        // stored from C270 through C0 to C90, as EULUMDAT class 3 has it
        let half = IntensityDistribution::expand(
            Symmetry::C90C270,
            &[
                (270.0, row(9.0)),
                (315.0, row(8.0)),
                (0.0, row(7.0)),
                (45.0, row(6.0)),
                (90.0, row(5.0)),
            ],
            gamma(),
        )
        .unwrap();
        assert_eq!(half.c_deg(), [0.0, 45.0, 90.0, 135.0, 180.0, 225.0, 270.0, 315.0]);
        assert_eq!(
            [half.intensity_cd_at(225.0, 90.0), half.intensity_cd_at(135.0, 90.0)],
            [8.0, 6.0]
        );
        assert_eq!(half.detect_symmetry(0.0), Symmetry::C90C270);

        let side = IntensityDistribution::expand(
            Symmetry::C0C180,
            &[(0.0, row(1.0)), (90.0, row(2.0)), (180.0, row(3.0))],
            gamma(),
        )
        .unwrap();
        assert_eq!(side.intensity_cd_at(270.0, 90.0), 2.0);
        assert_eq!(side.detect_symmetry(0.0), Symmetry::C0C180);

        let round = IntensityDistribution::expand(Symmetry::Rotational, &[(0.0, row(1.0))], gamma()).unwrap();
        assert!(round.is_rotational());
        assert_eq!(round.detect_symmetry(0.0), Symmetry::Rotational);
    }

    #[test]
    fn a_plane_on_the_wrong_side_is_refused() {
        let refused = IntensityDistribution::expand(
            Symmetry::Quadrant,
            &[(0.0, vec![1.0; 2]), (100.0, vec![1.0; 2])],
            gamma(),
        );
        assert_eq!(
            refused,
            Err(SymmetryError::Outside {
                symmetry: Symmetry::Quadrant,
                c_deg: 100.0
            })
        );
    }

    #[test]
    fn symmetry_that_is_claimed_is_not_symmetry_that_is_there() {
        let d = IntensityDistribution::new(
            vec![0.0, 90.0, 180.0, 270.0],
            gamma(),
            vec![9.0, 1.0, 9.0, 2.0, 9.0, 3.0, 9.0, 2.5],
        )
        .unwrap();
        assert_eq!(d.detect_symmetry(0.1), Symmetry::None);
        assert_eq!(d.detect_symmetry(0.5), Symmetry::C0C180);
    }
}
