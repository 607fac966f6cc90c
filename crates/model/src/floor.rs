//! Light that the floor returns to the detector: one diffuse bounce.

use std::sync::{Arc, LazyLock};

use glam::DVec3;

use crate::attitude::Attitude;
use crate::luminaire::Luminaire;
use crate::memory::{FloorKey, FloorLight, RowKey};
use crate::quadrature::gauss_legendre;

/// Nodes of a panel: as many as its light needs.
static EIGHT: LazyLock<Vec<(f64, f64)>> = LazyLock::new(|| gauss_legendre(8));
static TEN: LazyLock<Vec<(f64, f64)>> = LazyLock::new(|| gauss_legendre(10));
static TWELVE: LazyLock<Vec<(f64, f64)>> = LazyLock::new(|| gauss_legendre(12));

/// The integral varies as slowly as the lamp's light on the floor: it is computed on this lattice of γ, C and height,
/// and a cubic through its points serves all places between. What a fit moves by a tenth of a degree or by a few
/// millimetres costs no new integrals then.
const GAMMA_STEP_DEG: f64 = 4.0;
const C_STEPS: usize = 60;
/// Lean of the axis at which its parabola is taken; a larger one has an integral of its own.
const LEAN_STEP_DEG: f64 = 0.5;

/// Step of the lattice's heights at `height_mm`: 2 to 5 % of it, and a round number, as the height of a bench is.
fn height_step_mm(height_mm: f64) -> f64 {
    let decade_mm = 10.0_f64.powf(height_mm.log10().floor());
    let share = match height_mm / decade_mm {
        ..2.0 => 0.05,
        ..5.0 => 0.1,
        _ => 0.25,
    };
    share * decade_mm
}

/// The lamp and the detector over the floor.
#[derive(Debug, Clone, Copy)]
pub(crate) struct OverFloor {
    pub c_deg: f64,
    pub gamma_deg: f64,
    pub nonperp_deg: f64,
    pub distance_mm: f64,
    /// Distance that the reading states. Effects move the detector from there; the lattice is computed there.
    pub stated_distance_mm: f64,
    pub height_mm: f64,
}

/// A way of light from the lamp over the floor to the detector.
struct Way {
    /// C at which it leaves the luminaire when that stands at C 0°; it leaves at C more when it stands at C.
    c_deg: f64,
    /// γ at which it leaves.
    gamma_deg: f64,
    /// The same as a direction.
    out: DVec3,
    /// What one candela there counts in the integral.
    share: f64,
}

impl OverFloor {
    /// Illuminance in lx at the detector for albedo 1: (1/π) ∫ I(Θ) cosθ₁ cosθ₂ cosθ_det/(r₁² r₂²) dA over Z = −h, with
    /// the intensities of the luminaire's file. Known places are not computed again.
    pub fn light(mut self, luminaire: &Luminaire) -> FloorLight {
        if luminaire.distribution().is_rotational() {
            self.c_deg = 0.0;
        }
        let key = self.key();
        luminaire.memory.floor_or(key, || {
            if self.nonperp_deg.abs() > LEAN_STEP_DEG {
                return self.integrate(luminaire, 1)[0];
            }
            // A room twice as large has a quarter of the light.
            let room = self.stated_distance_mm / self.distance_mm;
            let as_stated = Self {
                distance_mm: self.stated_distance_mm,
                height_mm: room * self.height_mm,
                ..self
            };
            as_stated.between(luminaire).scaled(room * room)
        })
    }

    fn key(&self) -> FloorKey {
        let Self {
            c_deg,
            gamma_deg,
            nonperp_deg,
            distance_mm,
            stated_distance_mm,
            height_mm,
        } = *self;
        [
            c_deg,
            gamma_deg,
            nonperp_deg,
            distance_mm,
            stated_distance_mm,
            height_mm,
        ]
        .map(f64::to_bits)
    }

    /// The parabola over the lean of the axis, where it leans.
    fn between(&self, luminaire: &Luminaire) -> FloorLight {
        let upright = Self {
            nonperp_deg: 0.0,
            ..*self
        };
        let light = upright.on_lattice(luminaire);
        if self.nonperp_deg == 0.0 {
            return light;
        }
        let lean = self.nonperp_deg / LEAN_STEP_DEG;
        let leaning = |nonperp_deg: f64| Self { nonperp_deg, ..*self }.on_lattice(luminaire);
        light
            .scaled(1.0 - lean * lean)
            .plus(leaning(LEAN_STEP_DEG).scaled(0.5 * lean * (lean + 1.0)))
            .plus(leaning(-LEAN_STEP_DEG).scaled(0.5 * lean * (lean - 1.0)))
    }

    /// The cubic through the nearest points of the lattice.
    fn on_lattice(&self, luminaire: &Luminaire) -> FloorLight {
        let (first_gamma, gamma_weights) = cubic(self.gamma_deg / GAMMA_STEP_DEG);
        let mut light = FloorLight::default();
        for (k, of_gamma) in gamma_weights.iter().enumerate().filter(|(_, weight)| **weight != 0.0) {
            let row = Self {
                c_deg: 0.0,
                gamma_deg: (first_gamma + k as f64) * GAMMA_STEP_DEG,
                ..*self
            };
            let around = luminaire.memory.floor_row_or(row.row_key(), || row.around(luminaire));
            let (first_c, c_weights) = cubic(self.c_deg * around.len() as f64 / 360.0);
            for (i, of_c) in c_weights.iter().enumerate().filter(|(_, weight)| **weight != 0.0) {
                let place = (first_c as i64 + i as i64).rem_euclid(around.len() as i64);
                light = light.plus(around[place as usize].scaled(of_c * of_gamma));
            }
        }
        light
    }

    fn row_key(&self) -> RowKey {
        [self.gamma_deg, self.nonperp_deg, self.distance_mm, self.height_mm].map(f64::to_bits)
    }

    /// The light at one γ of the lattice with the luminaire turned to each C of it, from C 0° on; one for all C of a
    /// luminaire that is the same around its axis.
    fn around(&self, luminaire: &Luminaire) -> Arc<[FloorLight]> {
        let steps = if luminaire.distribution().is_rotational() {
            1
        } else {
            C_STEPS
        };
        let mut around = vec![FloorLight::default(); steps];
        let step_mm = height_step_mm(self.height_mm);
        let (first, weights) = cubic(self.height_mm / step_mm);
        for (k, weight) in weights.iter().enumerate().filter(|(_, weight)| **weight != 0.0) {
            let node = Self {
                height_mm: (first + k as f64) * step_mm,
                ..*self
            };
            let memory = &luminaire.memory;
            let integrals = memory.floor_integrals_or(node.row_key(), || node.integrate(luminaire, steps).into());
            for (sum, light) in around.iter_mut().zip(&*integrals) {
                *sum = sum.plus(light.scaled(*weight));
            }
        }
        around.into()
    }

    /// The sum over the ways of the light, with the luminaire turned to its C, C + 360°/n, … for all `n` of `steps`.
    fn integrate(&self, luminaire: &Luminaire, steps: usize) -> Vec<FloorLight> {
        use std::f64::consts::PI;
        let mut sums = vec![FloorLight::default(); steps];
        let mut intensities_cd = vec![0.0; steps];
        for way in self.ways() {
            luminaire.intensities_around_cd(way.c_deg + self.c_deg, way.gamma_deg, &mut intensities_cd);
            for (sum, intensity_cd) in sums.iter_mut().zip(&intensities_cd) {
                let part = intensity_cd * way.share;
                sum.illuminance_lx += part;
                sum.whence += part * way.out;
            }
        }
        let turned = |(k, sum): (usize, FloorLight)| {
            let (sin, cos) = (self.c_deg + 360.0 / steps as f64 * k as f64).to_radians().sin_cos();
            let whence = DVec3::new(
                cos * sum.whence.x - sin * sum.whence.y,
                sin * sum.whence.x + cos * sum.whence.y,
                sum.whence.z,
            );
            FloorLight { whence, ..sum }.scaled(1e6 / PI)
        };
        sums.into_iter().enumerate().map(turned).collect()
    }

    /// The ways by which light goes over the floor to the detector, and what each counts. They depend on C only in that
    /// the luminaire turns about its own axis: those of C 0° serve every C.
    ///
    /// With dA cosθ₁/r₁² = sinθ dθ dφ the integral runs over directions out of the lamp, θ from straight down; what
    /// lies beyond the detector's plane is behind its back and is left out.
    fn ways(&self) -> Vec<Way> {
        use std::f64::consts::{FRAC_PI_2, PI};
        let attitude = Attitude::new(0.0, self.gamma_deg, self.nonperp_deg);
        let detector = DVec3::new(self.distance_mm, 0.0, 0.0);
        let mut ways = Vec::new();
        // The detector sees its own foot best: over a low floor a narrow band towards it, and there the far end. Panels
        // of their own keep the rule exact for both.
        let band = (2.0 * self.height_mm / self.distance_mm).atan().min(FRAC_PI_2 / 2.0);
        let azimuths = [
            (-PI, -FRAC_PI_2, &EIGHT),
            (-FRAC_PI_2, -band, &TEN),
            (-band, 0.0, &EIGHT),
            (0.0, band, &EIGHT),
            (band, FRAC_PI_2, &TEN),
            (FRAC_PI_2, PI, &EIGHT),
        ];
        for (from, to, nodes) in azimuths {
            for (azimuth, weight_azimuth) in over(nodes, from, to) {
                let (sin_azimuth, cos_azimuth) = azimuth.sin_cos();
                // Beyond the detector's plane the floor is behind its back.
                let farthest = if cos_azimuth > 0.0 {
                    (self.distance_mm / (self.height_mm * cos_azimuth)).atan()
                } else {
                    FRAC_PI_2
                };
                let split = (0.5 * self.distance_mm / self.height_mm).atan().min(0.9 * farthest);
                for (theta, weight_polar) in over(&EIGHT, 0.0, split).chain(over(&TWELVE, split, farthest)) {
                    let (sin, cos) = theta.sin_cos();
                    let direction = DVec3::new(sin * cos_azimuth, sin * sin_azimuth, -cos);
                    let onward = detector - direction * (self.height_mm / cos);
                    let square = onward.length_squared();
                    // cosθ₂ · cosθ_det / r₂²
                    let onward_share = self.height_mm * onward.x / (square * square);
                    let out = attitude.luminaire_from_room(direction);
                    let share = onward_share.max(0.0) * sin * weight_polar * weight_azimuth;
                    if share > 0.0 {
                        ways.push(Way {
                            c_deg: out.y.atan2(out.x).to_degrees(),
                            gamma_deg: out.z.clamp(-1.0, 1.0).acos().to_degrees(),
                            out,
                            share,
                        });
                    }
                }
            }
        }
        ways
    }
}

/// Number of the first of four neighbouring points, and Lagrange's weights of the cubic through them; a place on a
/// point takes that point alone.
fn cubic(place: f64) -> (f64, [f64; 4]) {
    let cell = place.floor();
    let t = place - cell;
    let weights = [
        -t * (t - 1.0) * (t - 2.0) / 6.0,
        (t + 1.0) * (t - 1.0) * (t - 2.0) / 2.0,
        -(t + 1.0) * t * (t - 2.0) / 2.0,
        (t + 1.0) * t * (t - 1.0) / 6.0,
    ];
    (cell - 1.0, weights)
}

/// Places and weights of the panel from `low` to `high`.
fn over(nodes: &[(f64, f64)], low: f64, high: f64) -> impl Iterator<Item = (f64, f64)> {
    let half = 0.5 * (high - low);
    nodes.iter().map(move |(x, w)| (low + half * (x + 1.0), half * w))
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
                stated_distance_mm: distance,
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

    /// Between the lattice's points, over floors of many heights, and where an effect moves the detector or leans the
    /// axis: against the integral itself, for a lamp whose beam is narrow and differs over C.
    #[test]
    fn the_lattice_is_the_integral() {
        let gamma: Vec<f64> = (0..=90).map(f64::from).collect();
        let c: Vec<f64> = (0..24).map(|k| 15.0 * f64::from(k)).collect();
        let intensity = c
            .iter()
            .flat_map(|c| {
                gamma.iter().map(move |g| {
                    let ellipse = 1.0 + 0.2 * (2.0 * c.to_radians()).cos() * g.to_radians().sin().powi(2);
                    350.0 * g.to_radians().cos().max(0.0).powi(20) * ellipse
                })
            })
            .collect();
        let distribution = IntensityDistribution::new(c.clone(), gamma.clone(), intensity).unwrap();
        let luminaire = Luminaire::new(distribution, Emitter::Point {}, Spectral::None);
        let place = |c_deg: f64, gamma_deg: f64, moved_mm: f64, height_mm: f64| OverFloor {
            c_deg,
            gamma_deg,
            nonperp_deg: 0.05 * moved_mm,
            distance_mm: 2000.0 + moved_mm,
            stated_distance_mm: 2000.0,
            height_mm,
        };
        let largest = place(270.0, 60.0, 0.0, 1200.0).integrate(&luminaire, 1)[0].illuminance_lx;
        for k in 0..60 {
            let (c_deg, gamma_deg) = (f64::from(k * 37 % 360) + 0.3, 3.1 * f64::from(k) - 92.7);
            let moved_mm = f64::from(k % 5) * 5.0 - 10.0;
            let place = place(c_deg, gamma_deg, moved_mm, 800.0 + f64::from(k * 41 % 1200));
            let (quick, exact) = (place.light(&luminaire), place.integrate(&luminaire, 1)[0]);
            let off = (quick.illuminance_lx - exact.illuminance_lx).abs();
            assert!(
                off < 1e-3 * exact.illuminance_lx + 2e-4 * largest,
                "C {c_deg} γ {gamma_deg}: {} for {}",
                quick.illuminance_lx,
                exact.illuminance_lx
            );
        }
    }

    /// The height of a bench is a round number: one integral for each γ, and nothing between them.
    #[test]
    fn a_round_height_is_a_height_of_the_lattice() {
        let gamma: Vec<f64> = (0..=90).map(f64::from).collect();
        let intensity = gamma.iter().map(|g| 350.0 * g.to_radians().cos().max(0.0)).collect();
        let distribution = IntensityDistribution::new(vec![0.0], gamma, intensity).unwrap();
        let luminaire = Luminaire::new(distribution, Emitter::Point {}, Spectral::None);
        for height_mm in [850.0, 1000.0, 1200.0, 1950.0, 2300.0] {
            let place = OverFloor {
                c_deg: 0.0,
                gamma_deg: 8.0,
                nonperp_deg: 0.0,
                distance_mm: 3700.0,
                stated_distance_mm: 3700.0,
                height_mm,
            };
            let (quick, exact) = (place.light(&luminaire), place.integrate(&luminaire, 1)[0]);
            assert!(
                (quick.illuminance_lx / exact.illuminance_lx - 1.0).abs() < 1e-13,
                "{height_mm}: {quick:?} for {exact:?}"
            );
        }
    }
}
