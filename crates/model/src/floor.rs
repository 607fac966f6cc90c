//! Light that the floor returns to the detector: one diffuse bounce.

use std::sync::LazyLock;

use glam::DVec3;

use crate::bench::Attitude;
use crate::emitter::gauss_legendre;
use crate::luminaire::{FloorKey, FloorLight, Luminaire, angles_deg};

/// Nodes of one panel.
static PANEL: LazyLock<Vec<(f64, f64)>> = LazyLock::new(|| gauss_legendre(12));

/// The lamp and the detector over the floor.
#[derive(Debug, Clone, Copy)]
pub(crate) struct OverFloor {
    pub c_deg: f64,
    pub gamma_deg: f64,
    pub nonperp_deg: f64,
    pub distance_mm: f64,
    pub height_mm: f64,
}

impl OverFloor {
    /// Illuminance in lx at the detector for albedo 1: (1/π) ∫ I(Θ) cosθ₁ cosθ₂ cosθ_det/(r₁² r₂²) dA over Z = −h, with the
    /// intensities of the luminaire's file. Known places are not computed again.
    pub fn light(mut self, luminaire: &Luminaire) -> FloorLight {
        if luminaire.distribution().is_rotational() {
            self.c_deg = 0.0;
        }
        let Self {
            c_deg,
            gamma_deg,
            nonperp_deg,
            distance_mm,
            height_mm,
        } = self;
        let key: FloorKey = [c_deg, gamma_deg, nonperp_deg, distance_mm, height_mm].map(f64::to_bits);
        luminaire.floor.get_or(key, || self.integrate(luminaire))
    }

    /// With dA cosθ₁/r₁² = sinθ dθ dφ the integral runs over directions out of the lamp, θ from straight down; what lies
    /// beyond the detector's plane is behind its back and is left out.
    fn integrate(&self, luminaire: &Luminaire) -> FloorLight {
        use std::f64::consts::{FRAC_PI_2, PI};
        let attitude = Attitude::new(self.c_deg, self.gamma_deg, self.nonperp_deg);
        let detector = DVec3::new(self.distance_mm, 0.0, 0.0);
        let (mut sum, mut whence) = (0.0, DVec3::ZERO);
        // The detector sees its own foot best: over a low floor a narrow band towards it, and there the far end. Panels of
        // their own keep the rule exact for both.
        let band = (2.0 * self.height_mm / self.distance_mm).atan().min(FRAC_PI_2 / 2.0);
        let azimuths = [-PI, -FRAC_PI_2, -band, 0.0, band, FRAC_PI_2, PI];
        for panel in azimuths.windows(2) {
            for (azimuth, weight_azimuth) in over(panel[0], panel[1]) {
                let (sin_azimuth, cos_azimuth) = azimuth.sin_cos();
                // Beyond the detector's plane the floor is behind its back.
                let farthest = if cos_azimuth > 0.0 {
                    (self.distance_mm / (self.height_mm * cos_azimuth)).atan()
                } else {
                    FRAC_PI_2
                };
                let split = (0.5 * self.distance_mm / self.height_mm).atan().min(0.9 * farthest);
                for (theta, weight_polar) in over(0.0, split).chain(over(split, farthest)) {
                    let (sin, cos) = theta.sin_cos();
                    let direction = DVec3::new(sin * cos_azimuth, sin * sin_azimuth, -cos);
                    let onward = detector - direction * (self.height_mm / cos);
                    let square = onward.length_squared();
                    // cosθ₂ · cosθ_det / r₂²
                    let onward_share = self.height_mm * onward.x / (square * square);
                    let out = attitude.luminaire_from_room(direction);
                    let (c_deg, gamma_deg) = angles_deg(out);
                    let measure = sin * weight_polar * weight_azimuth;
                    let part = luminaire.intensity_cd(c_deg, gamma_deg) * onward_share.max(0.0) * measure;
                    sum += part;
                    whence += part * out;
                }
            }
        }
        let (c_deg, gamma_deg) = angles_deg(whence);
        FloorLight {
            illuminance_lx: sum / PI * 1e6,
            c_deg,
            gamma_deg,
        }
    }
}

/// Places and weights of the panel from `low` to `high`.
fn over(low: f64, high: f64) -> impl Iterator<Item = (f64, f64)> {
    let half = 0.5 * (high - low);
    PANEL.iter().map(move |(x, w)| (low + half * (x + 1.0), half * w))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Emitter, Spectral};
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
        let luminaire = Luminaire::new(distribution, Emitter::Point {}, Spectral::None);
        for (gamma_deg, height, distance, step) in [
            (0.0, 1200.0, 2000.0, 25.0),
            (30.0, 1200.0, 2000.0, 25.0),
            (-60.0, 1200.0, 2000.0, 25.0),
            (85.0, 800.0, 1000.0, 25.0),
            (0.0, 1000.0, 10_000.0, 50.0),
            (20.0, 1000.0, 10_000.0, 50.0),
        ] {
            let attitude = Attitude::new(20.0, gamma_deg, 0.0);
            let place = OverFloor {
                c_deg: 20.0,
                gamma_deg,
                nonperp_deg: 0.0,
                distance_mm: distance,
                height_mm: height,
            };
            let found = place.light(&luminaire).illuminance_lx;
            let (reach, mut sum) = ((20_000.0 / step) as i32, 0.0);
            for i in -reach..(distance / step) as i32 {
                for j in -reach..reach {
                    let p = DVec3::new((f64::from(i) + 0.5) * step, (f64::from(j) + 0.5) * step, -height);
                    let r1 = p.length();
                    let onward = DVec3::new(distance, 0.0, 0.0) - p;
                    let r2 = onward.length();
                    let i_cd = luminaire.distribution().toward(attitude.luminaire_from_room(p));
                    sum += i_cd * (height / r1) * (height / r2) * (onward.x / r2) / (r1 * r1 * r2 * r2) * step * step;
                }
            }
            let patches = sum / std::f64::consts::PI * 1e6;
            assert!(
                (found / patches - 1.0).abs() < 2e-3,
                "γ {gamma_deg}: {found} for {patches}"
            );
        }
    }
}
