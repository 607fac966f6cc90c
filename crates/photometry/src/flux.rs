//! Luminous flux: the exact integral of the bilinear interpolant over solid angle.
//!
//! Φ = ∫∫ I(C, γ) sin γ dγ dC. The interpolant is linear in C, so the integral over C is the sum of the half-planes
//! times the angle each stands for; it is piecewise linear in γ, and linear × sine integrates in closed form.

use crate::IntensityDistribution;

impl IntensityDistribution {
    /// Luminous flux over the sphere, in lumen.
    pub fn flux_lm(&self) -> f64 {
        self.flux_between_lm(0.0, 180.0)
    }

    /// Luminous flux of the zone `from_deg` ≤ γ ≤ `to_deg` over all C, in lumen; angles outside 0…180 are cut.
    pub fn flux_between_lm(&self, from_deg: f64, to_deg: f64) -> f64 {
        // The integral over C first: what is left is one curve over γ.
        let mut around = vec![0.0; self.gamma_deg().len()];
        for (plane, width_deg) in self.plane_widths_deg().iter().enumerate() {
            let width = width_deg.to_radians();
            for (sum, value) in around.iter_mut().zip(self.row(plane)) {
                *sum += width * value;
            }
        }
        let sum = zone(self.gamma_deg(), &around, from_deg, to_deg);
        // Finite intensities over a finite sphere; only an overflow at 1e308 could make it infinite.
        if sum.is_finite() { sum } else { f64::MAX }
    }

    /// Flux in zones of `step_deg` from γ = 0, in lumen; the last zone ends at 180°.
    ///
    /// # Panics
    /// When `step_deg` is not above zero.
    pub fn zonal_flux_lm(&self, step_deg: f64) -> Vec<f64> {
        assert!(step_deg > 0.0, "a zone has a width");
        let zones = (180.0 / step_deg).ceil() as usize;
        (0..zones)
            .map(|zone| {
                let from = zone as f64 * step_deg;
                self.flux_between_lm(from, (from + step_deg).min(180.0))
            })
            .collect()
    }

    /// What one candela at each point of the grid adds to the flux over the sphere, in lumen: Φ = Σ wᵢ·Iᵢ, in the order
    /// of [`intensity_cd`](Self::intensity_cd). The weights of a grid over the whole sphere add up to 4π sr.
    pub fn flux_weights_sr(&self) -> Vec<f64> {
        let mut along_gamma = vec![0.0; self.gamma_deg().len()];
        for (index, edge) in self.gamma_deg().windows(2).enumerate() {
            along_gamma[index] += linear_times_sine(edge[0], edge[1], 1.0, 0.0);
            along_gamma[index + 1] += linear_times_sine(edge[0], edge[1], 0.0, 1.0);
        }
        self.plane_widths_deg()
            .iter()
            .flat_map(|width| along_gamma.iter().map(|weight| width.to_radians() * weight))
            .collect()
    }
}

/// ∫ f sin γ dγ over a zone, f linear between its values at `gamma_deg`.
fn zone(gamma_deg: &[f64], values: &[f64], from_deg: f64, to_deg: f64) -> f64 {
    let mut sum = 0.0;
    for (edge, value) in gamma_deg.windows(2).zip(values.windows(2)) {
        let (a, b) = (edge[0].max(from_deg), edge[1].min(to_deg));
        if b <= a {
            continue;
        }
        let slope = (value[1] - value[0]) / (edge[1] - edge[0]);
        sum += linear_times_sine(a, b, value[0] + slope * (a - edge[0]), value[0] + slope * (b - edge[0]));
    }
    sum
}

/// ∫ f sin γ dγ from `a_deg` to `b_deg` for f linear from `fa` to `fb`; γ in radians inside.
///
/// Written around the middle of the interval, f̄·2 sin m sin h + f'·2 cos m·(sin h − h cos h), so that narrow intervals
/// lose no digits to cancellation.
pub fn linear_times_sine(a_deg: f64, b_deg: f64, fa: f64, fb: f64) -> f64 {
    let half = (0.5 * (b_deg - a_deg)).to_radians();
    let (sin_middle, cos_middle) = (0.5 * (a_deg + b_deg)).to_radians().sin_cos();
    let mean = 0.5 * (fa + fb);
    // sin h − h cos h, by its series where the difference would cancel
    let moment = if half < 0.05 {
        let h2 = half * half;
        half * h2 * (1.0 / 3.0 - h2 * (1.0 / 30.0 - h2 * (1.0 / 840.0 - h2 / 45360.0)))
    } else {
        half.sin() - half * half.cos()
    };
    2.0 * mean * sin_middle * half.sin() + (fb - fa) / half * cos_middle * moment
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::direction;
    use proptest::prelude::*;
    use std::f64::consts::PI;

    fn rotational(step: f64, f: impl Fn(f64) -> f64) -> IntensityDistribution {
        let gamma: Vec<f64> = (0..=(180.0 / step).round() as usize).map(|i| i as f64 * step).collect();
        let values = gamma.iter().map(|g| f(g.to_radians())).collect();
        IntensityDistribution::new(vec![0.0], gamma, values).unwrap()
    }

    #[test]
    fn isotropic_is_exact_on_any_grid() {
        let d = IntensityDistribution::new(vec![0.0, 7.0, 200.0], vec![0.0, 1.0, 50.0, 180.0], vec![2.5; 12]).unwrap();
        assert!((d.flux_lm() - 10.0 * PI).abs() < 1e-12);
        assert!((d.flux_between_lm(0.0, 60.0) - 2.0 * PI * 2.5 * 0.5).abs() < 1e-12);
        let zones = d.zonal_flux_lm(10.0);
        assert_eq!(zones.len(), 18);
        assert!((zones.iter().sum::<f64>() - 10.0 * PI).abs() < 1e-11);
    }

    #[test]
    fn linear_ramp_has_its_closed_form() {
        // I = γ over the whole sphere: 2π ∫ γ sin γ dγ = 2π·π
        let d = IntensityDistribution::new(vec![0.0], vec![0.0, 180.0], vec![0.0, PI]).unwrap();
        assert!((d.flux_lm() - 2.0 * PI * PI).abs() < 1e-12);
    }

    #[test]
    fn lambertian_and_cosine_powers_converge_with_the_square_of_the_step() {
        for n in [1.0, 5.3, 40.0] {
            let exact = 2.0 * PI / (n + 1.0);
            let error = |step: f64| rotational(step, |g| g.cos().max(0.0).powf(n)).flux_lm() / exact - 1.0;
            let (coarse, fine) = (error(2.0), error(1.0));
            assert!(fine.abs() < 1e-4 * n, "n = {n}: {fine}");
            assert!((coarse / fine - 4.0).abs() < 0.2, "n = {n}: {coarse} {fine}");
        }
    }

    #[test]
    fn a_tilted_lobe_keeps_its_flux() {
        // cosine lobe about an axis tilted by 30° towards C40: flux π whatever the tilt
        let axis = direction(40.0, 30.0);
        let c: Vec<f64> = (0..360).map(f64::from).collect();
        let g: Vec<f64> = (0..=180).map(f64::from).collect();
        let mut values = Vec::new();
        for c in &c {
            for g in &g {
                values.push(axis.dot(direction(*c, *g)).max(0.0));
            }
        }
        let flux = IntensityDistribution::new(c, g, values).unwrap().flux_lm();
        assert!((flux / PI - 1.0).abs() < 1e-4, "{flux}");
    }

    proptest! {
        /// Against Simpson's rule on a fine mesh of the same interpolant, cell by cell.
        #[test]
        fn agrees_with_numerical_quadrature(values in prop::collection::vec(0.0..100.0f64, 12)) {
            let d = IntensityDistribution::new(vec![10.0, 100.0, 190.0], vec![0.0, 20.0, 90.0, 170.0], values).unwrap();
            let mut sum = 0.0;
            for (c0, c1) in [(10.0, 100.0), (100.0, 190.0), (190.0, 370.0)] {
                for (g0, g1) in [(0.0, 20.0), (20.0, 90.0), (90.0, 170.0)] {
                    let n = 200;
                    let h = (g1 - g0) / f64::from(n);
                    let column = |c: f64| -> f64 {
                        (0..=n).map(|i| {
                            let weight = if i == 0 || i == n { 1.0 } else if i % 2 == 1 { 4.0 } else { 2.0 };
                            let g = (g0 + f64::from(i) * h).min(g1 - 1e-13);
                            weight * d.intensity_cd_at(c, g) * g.to_radians().sin()
                        }).sum::<f64>() * h.to_radians() / 3.0
                    };
                    // linear in C: the midpoint is exact
                    sum += column(0.5 * (c0 + c1)) * f64::to_radians(c1 - c0);
                }
            }
            prop_assert!((d.flux_lm() - sum).abs() < 1e-8 * sum.max(1.0), "{} {}", d.flux_lm(), sum);
        }

        #[test]
        fn weights_add_up_to_the_flux(values in prop::collection::vec(-1.0..100.0f64, 12)) {
            let d = IntensityDistribution::new(vec![10.0, 100.0, 190.0], vec![0.0, 20.0, 90.0, 180.0], values).unwrap();
            let weights = d.flux_weights_sr();
            prop_assert!((weights.iter().sum::<f64>() - 4.0 * PI).abs() < 1e-12);
            let sum: f64 = weights.iter().zip(d.intensity_cd()).map(|(w, i)| w * i).sum();
            prop_assert!((sum - d.flux_lm()).abs() < 1e-10);
        }

        #[test]
        fn narrow_intervals_lose_no_digits(a in 0.0..179.0f64, width in 1e-9..1e-3f64) {
            let got = linear_times_sine(a, a + width, 3.0, 3.0);
            let exact = 3.0 * 2.0 * (a + 0.5 * width).to_radians().sin() * (0.5 * ((a + width) - a)).to_radians().sin();
            prop_assert!((got - exact).abs() <= 1e-13 * exact.abs());
        }
    }
}
