//! What a diagnosis has refitted of the luminaire: `[luminaire.refined]`.

use glam::{DVec2, DVec3};
use serde::{Deserialize, Serialize};

/// Corrections of the intensity that an honest analyst must allow for before any effect is named.
///
/// I′ = I · exp(Σ aₖ T₂ₖ(γ/γ_max)) · (1 + Σ aₘ cos(mC) sinᵐγ) · (1 + a tan²γ + b tan⁴γ). Beyond the γ that the data
/// reached, each factor is held at its last value.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Refined {
    /// Coefficients of T₀, T₂, T₄ … in ln I, the level first.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub ln_shape: Vec<f64>,
    /// The largest γ of the readings.
    #[serde(default = "right_angle")]
    pub gamma_max_deg: f64,
    /// Relative amplitudes of cos(m·C)·sinᵐγ.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub c_harmonics: Vec<Harmonic>,
    /// Signal of a relative map for 1 lx at exposure 1.
    #[serde(default = "one")]
    pub map_gain: f64,
    /// Readings of photometer heads 1, 2, … over those of head 0, that of the model: two calibrations differ.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub head_gains: Vec<f64>,
    /// Coefficient of tan²γ.
    #[serde(default)]
    pub tan2: f64,
    /// Coefficient of tan⁴γ.
    #[serde(default)]
    pub tan4: f64,
    /// The largest γ of the maps.
    #[serde(default = "sixty")]
    pub tan_gamma_max_deg: f64,
    /// Standard uncertainties and covariances, kept as written.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub u: Option<toml::Table>,
}

/// One harmonic of C.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Harmonic {
    /// Its order.
    pub m: u32,
    /// Its amplitude relative to the intensity.
    pub amplitude_rel: f64,
}

fn one() -> f64 {
    1.0
}

fn right_angle() -> f64 {
    90.0
}

fn sixty() -> f64 {
    60.0
}

impl Default for Refined {
    fn default() -> Self {
        Self {
            ln_shape: Vec::new(),
            gamma_max_deg: right_angle(),
            c_harmonics: Vec::new(),
            map_gain: one(),
            head_gains: Vec::new(),
            tan2: 0.0,
            tan4: 0.0,
            tan_gamma_max_deg: sixty(),
            u: None,
        }
    }
}

impl Refined {
    /// Factor on the intensity towards (C, γ), γ ≥ 0.
    pub fn factor(&self, c_deg: f64, gamma_deg: f64) -> f64 {
        if self.is_unity() {
            return 1.0;
        }
        self.factor_towards(gamma_deg, isolux_photometry::direction(c_deg, gamma_deg))
    }

    /// The same towards `direction`, of any length, whose γ is `gamma_deg`: its sines and tangents are there.
    pub(crate) fn factor_towards(&self, gamma_deg: f64, direction: DVec3) -> f64 {
        let mut factor = 1.0;
        if !self.ln_shape.is_empty() {
            factor *= self.ln_shape_at(gamma_deg).exp();
        }
        for harmonic in self.c_harmonics.iter().filter(|harmonic| harmonic.amplitude_rel != 0.0) {
            // cos(mC)·sinᵐγ is the real part of (cos C sin γ + i sin C sin γ)ᵐ.
            factor *= 1.0 + harmonic.amplitude_rel * power(direction.truncate() / direction.length(), harmonic.m).x;
        }
        if self.tan2 != 0.0 || self.tan4 != 0.0 {
            let square = if gamma_deg < self.tan_gamma_max_deg {
                direction.truncate().length_squared() / direction.z.powi(2)
            } else {
                self.tan_gamma_max_deg.to_radians().tan().powi(2)
            };
            factor *= 1.0 + square * (self.tan2 + self.tan4 * square);
        }
        factor
    }

    /// What a photometer head reads over what head 0 reads; 1 where nothing is known of it.
    pub fn head_gain(&self, head: u32) -> f64 {
        let place = (head as usize).checked_sub(1);
        place
            .and_then(|place| self.head_gains.get(place))
            .copied()
            .unwrap_or(1.0)
    }

    /// Whether the factor is 1 everywhere.
    pub fn is_unity(&self) -> bool {
        self.ln_shape.iter().all(|a| *a == 0.0)
            && self.c_harmonics.iter().all(|h| h.amplitude_rel == 0.0)
            && self.tan2 == 0.0
            && self.tan4 == 0.0
    }

    /// Whether the factor depends on C.
    pub fn depends_on_c(&self) -> bool {
        self.c_harmonics.iter().any(|harmonic| harmonic.amplitude_rel != 0.0)
    }

    /// Σ aₖ T₂ₖ(x) = Σ aₖ Tₖ(2x² − 1), by Clenshaw's recurrence.
    fn ln_shape_at(&self, gamma_deg: f64) -> f64 {
        let x = (gamma_deg / self.gamma_max_deg).min(1.0);
        let y = 2.0 * x * x - 1.0;
        let (mut b1, mut b2) = (0.0, 0.0);
        for &a in self.ln_shape.iter().skip(1).rev() {
            (b1, b2) = (a + 2.0 * y * b1 - b2, b1);
        }
        self.ln_shape[0] + y * b1 - b2
    }

    pub(crate) fn is_possible(&self) -> bool {
        let angle = |deg: f64| deg > 0.0 && deg <= 180.0;
        // exp(100) is far beyond what any refit means, and far from infinite.
        self.ln_shape.iter().map(|a| a.abs()).sum::<f64>() <= 100.0
            && self
                .c_harmonics
                .iter()
                .all(|h| h.m <= 1000 && h.amplitude_rel.abs() <= 1e6)
            && [self.map_gain, self.tan2, self.tan4].iter().all(|v| v.abs() <= 1e12)
            && self.head_gains.iter().all(|gain| (1e-6..=1e6).contains(gain))
            && angle(self.gamma_max_deg)
            && self.tan_gamma_max_deg > 0.0
            && self.tan_gamma_max_deg < 90.0
    }
}

/// The power of a complex number.
fn power(mut base: DVec2, mut exponent: u32) -> DVec2 {
    let product = |a: DVec2, b: DVec2| DVec2::new(a.x * b.x - a.y * b.y, a.x * b.y + a.y * b.x);
    let mut power = DVec2::X;
    while exponent > 0 {
        if exponent & 1 == 1 {
            power = product(power, base);
        }
        base = product(base, base);
        exponent /= 2;
    }
    power
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn chebyshev_terms_are_even_ones_in_gamma() {
        let refined = Refined {
            ln_shape: vec![0.1, -0.2, 0.05, 0.3],
            gamma_max_deg: 70.0,
            ..Refined::default()
        };
        for gamma in [0.0, 13.0, 41.5, 70.0, 85.0] {
            let x = (gamma / 70.0f64).min(1.0);
            let t = |n: f64| (n * x.acos()).cos();
            let expected = (0.1 - 0.2 * t(2.0) + 0.05 * t(4.0) + 0.3 * t(6.0)).exp();
            assert!((refined.factor(12.0, gamma) - expected).abs() < 1e-13);
        }
    }

    #[test]
    fn of_angles_and_of_a_direction_the_law_is_the_one_that_is_stated() {
        let harmonic = |m, amplitude_rel| Harmonic { m, amplitude_rel };
        let refined = Refined {
            c_harmonics: vec![harmonic(1, 0.2), harmonic(2, -0.1), harmonic(7, 0.05)],
            tan2: 0.3,
            tan4: -0.02,
            tan_gamma_max_deg: 55.0,
            ..Refined::default()
        };
        for (c, gamma) in [
            (0.0, 0.0),
            (33.0, 12.0),
            (-140.0, 54.9),
            (271.0, 55.1),
            (359.0, 90.0),
            (10.0, 130.0),
        ] {
            let (azimuth, polar) = (f64::to_radians(c), f64::to_radians(gamma));
            let around: f64 = (refined.c_harmonics.iter())
                .map(|h| 1.0 + h.amplitude_rel * (f64::from(h.m) * azimuth).cos() * polar.sin().powi(h.m as i32))
                .product();
            let tan = f64::to_radians(gamma.min(55.0)).tan();
            let expected = around * (1.0 + 0.3 * tan.powi(2) - 0.02 * tan.powi(4));
            let towards = refined.factor_towards(gamma, 730.0 * isolux_photometry::direction(c, gamma));
            for found in [refined.factor(c, gamma), towards] {
                assert!(
                    (found - expected).abs() < 1e-13,
                    "C {c}°, γ {gamma}°: {found} {expected}"
                );
            }
        }
    }

    #[test]
    fn harmonics_vanish_on_the_axis() {
        let refined = Refined {
            c_harmonics: vec![Harmonic {
                m: 2,
                amplitude_rel: 0.1,
            }],
            ..Refined::default()
        };
        assert_eq!(refined.factor(77.0, 0.0), 1.0);
        assert!((refined.factor(90.0, 90.0) - 0.9).abs() < 1e-15);
        assert!(Refined::default().is_unity() && !refined.is_unity());
    }
}
