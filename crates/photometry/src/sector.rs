//! Luminous flux of a part of the sphere: the exact integral of the bilinear interpolant over some half-planes and γ.

use crate::IntensityDistribution;
use crate::flux::linear_times_sine;

/// A part of the sphere between two half-planes and between two γ.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Sector {
    /// Half-plane at which it begins, in degrees; it goes on with rising C, through C 360° where it must.
    pub c_from_deg: f64,
    /// How far it goes on, in degrees: 0 to 360.
    pub c_width_deg: f64,
    /// First and last γ in degrees; what lies outside the grid is dark.
    pub gamma_deg: [f64; 2],
}

impl Sector {
    /// All half-planes between two γ, in degrees.
    pub const fn zone(from_deg: f64, to_deg: f64) -> Self {
        Self {
            c_from_deg: 0.0,
            c_width_deg: 360.0,
            gamma_deg: [from_deg, to_deg],
        }
    }
}

impl IntensityDistribution {
    /// What one candela at each point of the grid adds to the flux of `sector`, in sr, in the order of
    /// [`intensity_cd`](Self::intensity_cd): Φ = Σ wᵢ·Iᵢ.
    pub fn sector_weights_sr(&self, sector: &Sector) -> Vec<f64> {
        let around = self.shares_of_c_deg(sector.c_from_deg, sector.c_width_deg);
        let [from_deg, to_deg] = sector.gamma_deg;
        let gammas = self.gamma_deg();
        let mut along = vec![0.0; gammas.len()];
        for (index, edge) in gammas.windows(2).enumerate() {
            let (a, b) = (edge[0].max(from_deg), edge[1].min(to_deg));
            if b <= a {
                continue;
            }
            let share = |gamma: f64| (gamma - edge[0]) / (edge[1] - edge[0]);
            along[index] += linear_times_sine(a, b, 1.0 - share(a), 1.0 - share(b));
            along[index + 1] += linear_times_sine(a, b, share(a), share(b));
        }
        around
            .iter()
            .flat_map(|width_deg| along.iter().map(|weight| width_deg.to_radians() * weight))
            .collect()
    }

    /// Luminous flux of `sector`, in lumen.
    pub fn sector_flux_lm(&self, sector: &Sector) -> f64 {
        let weights = self.sector_weights_sr(sector);
        weights.iter().zip(self.intensity_cd()).map(|(sr, cd)| sr * cd).sum()
    }

    /// Degrees of C that each half-plane stands for in the integral from `from_deg` over `width_deg`.
    fn shares_of_c_deg(&self, from_deg: f64, width_deg: f64) -> Vec<f64> {
        let planes = self.c_deg();
        if planes.len() == 1 {
            return vec![width_deg];
        }
        let mut shares = vec![0.0; planes.len()];
        for (plane, &start) in planes.iter().enumerate() {
            let next = (plane + 1) % planes.len();
            let gap = (planes[next] - start).rem_euclid(360.0);
            // The sector as this gap sees it, which begins at 0: once where it lies ahead, once where it began behind.
            let ahead = (from_deg - start).rem_euclid(360.0);
            for a in [ahead, ahead - 360.0] {
                let (t0, t1) = (a.max(0.0), (a + width_deg).min(gap));
                if t1 > t0 {
                    let of_next = (t1 * t1 - t0 * t0) / (2.0 * gap);
                    shares[plane] += t1 - t0 - of_next;
                    shares[next] += of_next;
                }
            }
        }
        shares
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;
    use std::f64::consts::PI;

    #[test]
    fn a_sector_of_a_uniform_sphere_is_its_solid_angle() {
        let light =
            IntensityDistribution::new(vec![0.0, 7.0, 200.0], vec![0.0, 3.0, 77.0, 180.0], vec![2.0; 12]).unwrap();
        for (c_from_deg, c_width_deg, gamma_deg) in [
            (270.0, 180.0, [0.0, 30.0]),
            (5.0, 1.0, [60.0, 80.0]),
            (0.0, 360.0, [0.0, 180.0]),
            (350.0, 360.0, [10.0, 100.0]),
            (-90.0, 180.0, [80.0, 90.0]),
        ] {
            let sector = Sector {
                c_from_deg,
                c_width_deg,
                gamma_deg,
            };
            let cosines = gamma_deg.map(|gamma: f64| gamma.to_radians().cos());
            let exact = 2.0 * c_width_deg.to_radians() * (cosines[0] - cosines[1]);
            assert!((light.sector_flux_lm(&sector) - exact).abs() < 1e-12, "{sector:?}");
        }
    }

    #[test]
    fn one_half_plane_stands_for_all() {
        let light = IntensityDistribution::new(vec![0.0], vec![0.0, 90.0, 180.0], vec![1.0; 3]).unwrap();
        let quarter = Sector {
            c_from_deg: 300.0,
            c_width_deg: 90.0,
            gamma_deg: [0.0, 90.0],
        };
        assert!((light.sector_flux_lm(&quarter) - 0.5 * PI).abs() < 1e-12);
    }

    proptest! {
        /// Against the midpoint rule on a fine mesh of the same interpolant.
        #[test]
        fn agrees_with_numerical_quadrature(
            values in prop::collection::vec(0.0..100.0f64, 12), c in -400.0..400.0f64, width in 1.0..360.0f64,
            low in 0.0..80.0f64, high in 90.0..180.0f64
        ) {
            let planes = vec![10.0, 100.0, 190.0];
            let light = IntensityDistribution::new(planes, vec![0.0, 20.0, 90.0, 170.0], values).unwrap();
            let sector = Sector { c_from_deg: c, c_width_deg: width, gamma_deg: [low, high] };
            let (nc, ng) = (600, 600);
            let (dc, dg) = (width / f64::from(nc), (high - low) / f64::from(ng));
            let mut sum = 0.0;
            for i in 0..nc {
                for k in 0..ng {
                    let gamma = low + (f64::from(k) + 0.5) * dg;
                    sum += light.intensity_cd_at(c + (f64::from(i) + 0.5) * dc, gamma) * gamma.to_radians().sin();
                }
            }
            sum *= dc.to_radians() * dg.to_radians();
            let exact = light.sector_flux_lm(&sector);
            prop_assert!((exact - sum).abs() < 3e-3 * exact.abs() + 0.01, "{exact} {sum}");
        }

        #[test]
        fn sectors_that_make_the_sphere_make_the_flux(
            values in prop::collection::vec(-1.0..100.0f64, 12),
            c in 0.0..360.0f64,
            width in 0.0..360.0f64,
            gamma in 1.0..179.0f64
        ) {
            let planes = vec![10.0, 100.0, 190.0];
            let light = IntensityDistribution::new(planes, vec![0.0, 20.0, 90.0, 180.0], values).unwrap();
            let sum: f64 = [(c, width), (c + width, 360.0 - width)].iter().flat_map(|&(c_from_deg, c_width_deg)| {
                [[0.0, gamma], [gamma, 180.0]].map(|gamma_deg| Sector { c_from_deg, c_width_deg, gamma_deg })
            }).map(|sector| light.sector_flux_lm(&sector)).sum();
            prop_assert!((sum - light.flux_lm()).abs() < 1e-9, "{sum} {}", light.flux_lm());
        }
    }
}
