//! Candela over a C-γ grid: construction, interpolation, scaling.

use glam::DVec3;

use crate::direction::angles_deg;

/// Why numbers are no intensity distribution. Indices count from 0.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum DistributionError {
    /// No C plane, or fewer than two γ.
    #[error("a distribution needs at least one C plane and two γ, not {c_planes} and {gammas}")]
    TooSmall {
        /// Number of C planes.
        c_planes: usize,
        /// Number of γ.
        gammas: usize,
    },
    /// The intensities are not one for each (C, γ).
    #[error("{c_planes} C planes × {gammas} γ need {} intensities, not {found}", c_planes * gammas)]
    Count {
        /// Number of C planes.
        c_planes: usize,
        /// Number of γ.
        gammas: usize,
        /// Number of intensities given.
        found: usize,
    },
    /// C angles that do not rise within [0°, 360°).
    #[error("C plane {index} is {c_deg}°: planes must rise within 0° ≤ C < 360°")]
    CNotRising {
        /// Index of the plane.
        index: usize,
        /// Its angle.
        c_deg: f64,
    },
    /// γ angles that do not rise within [0°, 180°].
    #[error("γ {index} is {gamma_deg}°: γ must rise within 0°…180°")]
    GammaNotRising {
        /// Index of the angle.
        index: usize,
        /// The angle.
        gamma_deg: f64,
    },
    /// An intensity that is NaN or infinite.
    #[error("intensity at C{c_deg} γ{gamma_deg} is {value}")]
    NotFinite {
        /// C of the value.
        c_deg: f64,
        /// γ of the value.
        gamma_deg: f64,
        /// The value.
        value: f64,
    },
    /// The integral over the sphere is not above zero, so it cannot be scaled to a flux.
    #[error("the distribution integrates to {flux_lm} lm and cannot be scaled to {wanted_lm} lm")]
    NoFlux {
        /// Flux of the distribution.
        flux_lm: f64,
        /// Flux asked for.
        wanted_lm: f64,
    },
}

/// Where a distribution is strongest.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Peak {
    /// The largest intensity of the grid.
    pub intensity_cd: f64,
    /// Its half-plane (the first one, where several are equal).
    pub c_deg: f64,
    /// Its γ (the smallest one).
    pub gamma_deg: f64,
}

/// Luminous intensity in candela over the full circle of C and the file's range of γ.
#[derive(Debug, Clone, PartialEq)]
pub struct IntensityDistribution {
    c_deg: Vec<f64>,
    gamma_deg: Vec<f64>,
    intensity_cd: Vec<f64>,
}

impl IntensityDistribution {
    /// A distribution from its grid.
    ///
    /// `c_deg`: n half-planes rising within [0, 360); a single one means rotational symmetry. `gamma_deg`: m angles
    /// rising within [0, 180]. `intensity_cd`: n × m values, plane by plane. Negative values are data.
    ///
    /// # Errors
    /// [`DistributionError`] names the first angle or intensity that is wrong.
    pub fn new(c_deg: Vec<f64>, gamma_deg: Vec<f64>, intensity_cd: Vec<f64>) -> Result<Self, DistributionError> {
        let (c_planes, gammas) = (c_deg.len(), gamma_deg.len());
        if c_planes == 0 || gammas < 2 {
            return Err(DistributionError::TooSmall { c_planes, gammas });
        }
        if intensity_cd.len() != c_planes * gammas {
            return Err(DistributionError::Count {
                c_planes,
                gammas,
                found: intensity_cd.len(),
            });
        }
        for (index, &angle) in c_deg.iter().enumerate() {
            let rises = index == 0 || angle > c_deg[index - 1];
            if !(rises && (0.0..360.0).contains(&angle)) {
                return Err(DistributionError::CNotRising { index, c_deg: angle });
            }
        }
        for (index, &angle) in gamma_deg.iter().enumerate() {
            let rises = index == 0 || angle > gamma_deg[index - 1];
            if !(rises && (0.0..=180.0).contains(&angle)) {
                return Err(DistributionError::GammaNotRising {
                    index,
                    gamma_deg: angle,
                });
            }
        }
        if let Some(at) = intensity_cd.iter().position(|v| !v.is_finite()) {
            return Err(DistributionError::NotFinite {
                c_deg: c_deg[at / gammas],
                gamma_deg: gamma_deg[at % gammas],
                value: intensity_cd[at],
            });
        }
        Ok(Self {
            c_deg,
            gamma_deg,
            intensity_cd,
        })
    }

    /// C half-planes in degrees, rising within [0, 360).
    pub fn c_deg(&self) -> &[f64] {
        &self.c_deg
    }

    /// γ in degrees, rising within [0, 180].
    pub fn gamma_deg(&self) -> &[f64] {
        &self.gamma_deg
    }

    /// All intensities in candela, plane by plane.
    pub fn intensity_cd(&self) -> &[f64] {
        &self.intensity_cd
    }

    /// Intensities of half-plane number `plane`, in candela, one a γ.
    ///
    /// # Panics
    /// When there is no such plane.
    pub fn row(&self, plane: usize) -> &[f64] {
        let m = self.gamma_deg.len();
        &self.intensity_cd[plane * m..(plane + 1) * m]
    }

    /// Whether one half-plane stands for all.
    pub fn is_rotational(&self) -> bool {
        self.c_deg.len() == 1
    }

    /// The half-plane of the grid at `c_deg`; the only one of a rotational distribution.
    pub fn plane_at(&self, c_deg: f64) -> Option<usize> {
        let at = self.c_deg.iter().position(|c| (c - c_deg).abs() < 1e-9);
        at.or(self.is_rotational().then_some(0))
    }

    /// Intensity in a direction in candela: bilinear in (C, γ), periodic in C, zero outside the γ range; `gamma_deg` ≥
    /// 0.
    pub fn intensity_cd_at(&self, c_deg: f64, gamma_deg: f64) -> f64 {
        let Some((row, v)) = bracket(&self.gamma_deg, gamma_deg) else {
            return 0.0;
        };
        let (from, to, u) = self.planes_around(c_deg);
        let along = |plane: usize| {
            let row_cd = self.row(plane);
            row_cd[row] + v * (row_cd[row + 1] - row_cd[row])
        };
        let first = along(from);
        if from == to {
            first
        } else {
            first + u * (along(to) - first)
        }
    }

    /// Intensities in candela at every γ of the grid in the half-plane C, one a γ.
    pub fn half_plane_cd(&self, c_deg: f64) -> Vec<f64> {
        let (from, to, u) = self.planes_around(c_deg);
        let pairs = self.row(from).iter().zip(self.row(to));
        pairs.map(|(before, after)| before + u * (after - before)).collect()
    }

    /// Intensity in candela towards a point, `direction` in the luminaire's frame and of any length above zero.
    pub fn toward(&self, direction: DVec3) -> f64 {
        let (c_deg, gamma_deg) = angles_deg(direction);
        self.intensity_cd_at(c_deg, gamma_deg)
    }

    /// The half-planes before and after `c_deg` and the fraction of the way between them.
    fn planes_around(&self, c_deg: f64) -> (usize, usize, f64) {
        let n = self.c_deg.len();
        if n == 1 {
            return (0, 0, 0.0);
        }
        let c = c_deg.rem_euclid(360.0);
        let after = self.c_deg.partition_point(|&plane| plane <= c);
        let (from, to) = ((after + n - 1) % n, after % n);
        let start = self.c_deg[from];
        let width = (self.c_deg[to] - start).rem_euclid(360.0);
        (from, to, (c - start).rem_euclid(360.0) / width)
    }

    /// Mean over C at a γ, each half-plane weighted by the angle it stands for.
    pub fn pole_cd(&self, gamma_deg: f64) -> f64 {
        let Some((row, v)) = bracket(&self.gamma_deg, gamma_deg) else {
            return 0.0;
        };
        let weights = self.plane_widths_deg();
        let sum: f64 = (0..self.c_deg.len())
            .map(|plane| {
                let row_cd = self.row(plane);
                weights[plane] * (row_cd[row] + v * (row_cd[row + 1] - row_cd[row]))
            })
            .sum();
        sum / 360.0
    }

    /// Degrees of C that each half-plane stands for when the interpolant is integrated over the circle (sum 360).
    pub fn plane_widths_deg(&self) -> Vec<f64> {
        let n = self.c_deg.len();
        if n == 1 {
            return vec![360.0];
        }
        let gap = |from: usize, to: usize| (self.c_deg[to] - self.c_deg[from]).rem_euclid(360.0);
        (0..n)
            .map(|i| 0.5 * (gap((i + n - 1) % n, i) + gap(i, (i + 1) % n)))
            .collect()
    }

    /// Largest difference between half-planes at γ = 0 and at γ = 180°, where they all show the same direction, in
    /// candela; zero where the grid does not reach a pole.
    pub fn pole_spread_cd(&self) -> [f64; 2] {
        let spread = |column: usize| {
            let values = (0..self.c_deg.len()).map(|plane| self.row(plane)[column]);
            let (low, high) = values.fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), v| (l.min(v), h.max(v)));
            high - low
        };
        let last = self.gamma_deg.len() - 1;
        [
            if self.gamma_deg[0] == 0.0 { spread(0) } else { 0.0 },
            if self.gamma_deg[last] == 180.0 {
                spread(last)
            } else {
                0.0
            },
        ]
    }

    /// The largest intensity on the grid (the interpolant has no larger one) and where it is.
    pub fn peak(&self) -> Peak {
        let m = self.gamma_deg.len();
        let at = (0..self.intensity_cd.len())
            .reduce(|best, i| {
                if self.intensity_cd[i] > self.intensity_cd[best] {
                    i
                } else {
                    best
                }
            })
            .unwrap_or(0);
        Peak {
            intensity_cd: self.intensity_cd[at],
            c_deg: self.c_deg[at / m],
            gamma_deg: self.gamma_deg[at % m],
        }
    }

    /// The distribution with every intensity multiplied by `factor`.
    ///
    /// # Errors
    /// [`DistributionError::NotFinite`] when a product overflows or `factor` is not finite.
    pub fn scaled(&self, factor: f64) -> Result<Self, DistributionError> {
        Self::new(
            self.c_deg.clone(),
            self.gamma_deg.clone(),
            self.intensity_cd.iter().map(|v| v * factor).collect(),
        )
    }

    /// The distribution scaled so that its integral over the sphere is `flux_lm`.
    ///
    /// # Errors
    /// [`DistributionError::NoFlux`] when it integrates to nothing.
    pub fn scaled_to_flux_lm(&self, flux_lm: f64) -> Result<Self, DistributionError> {
        let own = self.flux_lm();
        if own <= 0.0 {
            return Err(DistributionError::NoFlux {
                flux_lm: own,
                wanted_lm: flux_lm,
            });
        }
        self.scaled(flux_lm / own)
    }
}

/// Index of the interval of `grid` that holds `x` and the fraction of the way through it; none outside the grid.
fn bracket(grid: &[f64], x: f64) -> Option<(usize, f64)> {
    let last = grid.len() - 1;
    if !(grid[0]..=grid[last]).contains(&x) {
        return None;
    }
    let index = grid.partition_point(|&g| g <= x).saturating_sub(1).min(last - 1);
    Some((index, (x - grid[index]) / (grid[index + 1] - grid[index])))
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn quadrant() -> IntensityDistribution {
        IntensityDistribution::new(
            vec![0.0, 90.0, 180.0, 270.0],
            vec![0.0, 90.0],
            vec![10.0, 0.0, 10.0, 4.0, 10.0, 8.0, 10.0, 12.0],
        )
        .unwrap()
    }

    #[test]
    fn bilinear_and_periodic() {
        let d = quadrant();
        assert_eq!(d.intensity_cd_at(90.0, 90.0), 4.0);
        assert_eq!(d.intensity_cd_at(45.0, 90.0), 2.0);
        assert_eq!(d.intensity_cd_at(45.0, 45.0), 6.0);
        // between C270 and C0 the circle closes
        assert_eq!(d.intensity_cd_at(315.0, 90.0), 6.0);
        assert_eq!(d.intensity_cd_at(-45.0, 90.0), 6.0);
        assert_eq!(d.intensity_cd_at(0.0, 90.0001), 0.0, "dark beyond the file's γ");
        assert_eq!(d.half_plane_cd(315.0), [10.0, 6.0]);
    }

    #[test]
    fn direction_to_the_right_of_the_lamp_is_c0() {
        let d = quadrant();
        assert!(
            (d.toward(DVec3::new(0.0, 1.0, 1e-12)) - 4.0).abs() < 1e-9,
            "C90 lies along +y"
        );
        assert!((d.toward(DVec3::new(-2.0, 0.0, 2.0)) - 9.0).abs() < 1e-9, "C180 γ45");
    }

    #[test]
    fn a_pole_has_one_value() {
        let d = IntensityDistribution::new(vec![0.0, 90.0], vec![0.0, 180.0], vec![4.0, 0.0, 8.0, 0.0]).unwrap();
        // C90 stands for 135 + 45 = 180 degrees of the circle like C0
        assert_eq!(d.pole_cd(0.0), 6.0);
        assert_eq!(d.pole_spread_cd(), [4.0, 0.0]);
    }

    #[test]
    fn says_what_is_wrong() {
        let new = IntensityDistribution::new;
        assert!(matches!(
            new(vec![0.0], vec![0.0], vec![1.0]),
            Err(DistributionError::TooSmall { .. })
        ));
        assert!(matches!(
            new(vec![0.0], vec![0.0, 9.0], vec![1.0]),
            Err(DistributionError::Count { found: 1, .. })
        ));
        assert!(matches!(
            new(vec![0.0, 360.0], vec![0.0, 9.0], vec![1.0; 4]),
            Err(DistributionError::CNotRising { index: 1, .. })
        ));
        assert!(matches!(
            new(vec![0.0], vec![0.0, 9.0, 9.0], vec![1.0; 3]),
            Err(DistributionError::GammaNotRising { index: 2, .. })
        ));
        let nan = new(vec![0.0, 15.0], vec![0.0, 9.0], vec![1.0, 1.0, f64::NAN, 1.0]).unwrap_err();
        assert_eq!(nan.to_string(), "intensity at C15 γ0 is NaN");
    }

    proptest! {
        #[test]
        fn interpolation_stays_within_the_grid_values(
            values in prop::collection::vec(-5.0..50.0f64, 15), c in -720.0..720.0f64, gamma in 0.0..180.0f64
        ) {
            let d = IntensityDistribution::new(vec![3.0, 40.0, 200.0], vec![0.0, 10.0, 30.0, 110.0, 180.0], values).unwrap();
            let low = d.intensity_cd().iter().copied().fold(f64::INFINITY, f64::min);
            let v = d.intensity_cd_at(c, gamma);
            prop_assert!(v >= low - 1e-12 && v <= d.peak().intensity_cd + 1e-12);
        }
    }
}
