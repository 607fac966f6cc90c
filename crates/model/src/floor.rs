//! Light that the floor returns to the detector: one diffuse bounce.

use glam::DVec3;

use crate::bench::Attitude;
use crate::emitter::gauss_legendre;
use crate::shine::Shine;

/// Nodes in the polar angle and in each half of the azimuth.
const POLAR: usize = 20;
const AZIMUTHS: usize = 16;

/// Points of the floor as seen from the lamp, for one rule of quadrature.
pub(crate) struct Floor {
    polar: Vec<(f64, f64)>,
    azimuths: Vec<(f64, f64)>,
}

impl Floor {
    pub fn new() -> Self {
        Self {
            polar: gauss_legendre(POLAR),
            azimuths: gauss_legendre(AZIMUTHS),
        }
    }

    /// Illuminance in lx at the detector for albedo 1: (1/π) ∫ I(Θ) cosθ₁ cosθ₂ cosθ_det/(r₁² r₂²) dA over Z = −h.
    ///
    /// With dA cosθ₁/r₁² = sinθ dθ dφ the integral runs over directions out of the lamp, θ from straight down; what lies
    /// beyond the detector's plane is behind its back and is left out.
    pub fn illuminance_lx(&self, shine: &Shine<'_>, attitude: &Attitude, distance_mm: f64, height_mm: f64) -> f64 {
        use std::f64::consts::{FRAC_PI_2, PI};
        let detector = DVec3::new(distance_mm, 0.0, 0.0);
        let mut sum = 0.0;
        // Azimuths towards the detector and away from it.
        for (middle, ahead) in [(0.0, true), (PI, false)] {
            for (u, weight_azimuth) in &self.azimuths {
                let azimuth = middle + FRAC_PI_2 * u;
                let (sin_azimuth, cos_azimuth) = azimuth.sin_cos();
                let farthest = if ahead {
                    (distance_mm / (height_mm * cos_azimuth)).atan()
                } else {
                    FRAC_PI_2
                };
                for (v, weight_polar) in &self.polar {
                    let theta = 0.5 * farthest * (v + 1.0);
                    let (sin, cos) = theta.sin_cos();
                    if cos < 1e-9 {
                        continue;
                    }
                    let direction = DVec3::new(sin * cos_azimuth, sin * sin_azimuth, -cos);
                    let point = direction * (height_mm / cos);
                    let onward = detector - point;
                    let square = onward.length_squared();
                    let length = square.sqrt();
                    let cos_out = height_mm / length;
                    let cos_detector = onward.x / length;
                    if cos_detector <= 0.0 {
                        continue;
                    }
                    let intensity_cd = shine.intensity_cd(attitude.luminaire_from_room(direction));
                    let measure = sin * 0.5 * farthest * weight_polar * FRAC_PI_2 * weight_azimuth;
                    sum += intensity_cd * cos_out * cos_detector / square * measure;
                }
            }
        }
        sum / PI * 1e6
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Emitter, Luminaire, Model, Spectral};
    use isolux_photometry::IntensityDistribution;

    /// Against a sum over square patches of the floor.
    #[test]
    fn agrees_with_patches() {
        let gamma: Vec<f64> = (0..=90).map(f64::from).collect();
        let intensity = gamma
            .iter()
            .map(|g| 350.0 * g.to_radians().cos().max(0.0).powi(5))
            .collect();
        let distribution = IntensityDistribution::new(vec![0.0], gamma, intensity).unwrap();
        let model = Model::of(Luminaire::new(distribution, Emitter::Point {}, Spectral::None));
        let shine = Shine::new(&model);
        let (height, distance) = (1200.0, 2000.0);
        for gamma_deg in [0.0, 30.0, -60.0, 85.0] {
            let attitude = Attitude::new(20.0, gamma_deg, 0.0);
            let found = Floor::new().illuminance_lx(&shine, &attitude, distance, height);
            let (step, mut sum) = (25.0, 0.0);
            for i in -800..80 {
                for j in -800..800 {
                    let p = DVec3::new((i as f64 + 0.5) * step, (j as f64 + 0.5) * step, -height);
                    if p.x >= distance {
                        continue;
                    }
                    let r1 = p.length();
                    let onward = DVec3::new(distance, 0.0, 0.0) - p;
                    let r2 = onward.length();
                    let i_cd = shine.intensity_cd(attitude.luminaire_from_room(p));
                    sum += i_cd * (height / r1) * (height / r2) * (onward.x / r2) / (r1 * r1 * r2 * r2) * step * step;
                }
            }
            let patches = sum / std::f64::consts::PI * 1e6;
            assert!(
                (found / patches - 1.0).abs() < 3e-3,
                "γ {gamma_deg}: {found} for {patches}"
            );
        }
    }
}
