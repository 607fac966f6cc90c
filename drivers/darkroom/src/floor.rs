//! Light that the floor sends to the detector: a Lambertian plane added up patch by patch.

use glam::DVec3;

use crate::illuminator::Illuminator;
use crate::mount::Mounted;

/// A floor at Z = −height of the bench frame.
#[derive(Debug, Clone, PartialEq)]
pub struct Floor {
    albedo: f64,
    height_mm: f64,
}

/// Columns of patches gathered under the lamp, columns gathered under the detector, and rows across the bench.
const PATCHES: [usize; 3] = [44, 14, 40];

impl Floor {
    /// A floor, or none if its albedo is zero.
    pub fn new(albedo: f64, height_mm: f64) -> Option<Self> {
        (albedo > 0.0).then_some(Self { albedo, height_mm })
    }

    /// Illuminance on a detector at `detector_mm` with the unit normal `normal` (bench frame), lx.
    ///
    /// Each patch takes the light of the lamp and sends it on as luminance ρE/π; both paths lose to the air.
    /// `along` weights the light of one patch by the detector's response to its incidence cosine.
    pub fn illuminance_lx(
        &self,
        lamp: &Illuminator,
        mounted: &Mounted,
        detector_mm: DVec3,
        normal: DVec3,
        transmittance_per_mm: f64,
        response: impl Fn(f64) -> f64,
    ) -> f64 {
        let up = mounted.direction_to_luminaire(DVec3::Z);
        let mut sum = 0.0;
        for patch in Patches::new(self.height_mm, detector_mm.x) {
            let path = detector_mm - patch.centre_mm;
            let distance_mm = path.length();
            let direction = path / distance_mm;
            let incidence = -direction.dot(normal);
            if incidence <= 0.0 {
                continue;
            }
            let in_lamp_frame = mounted.to_luminaire(patch.centre_mm);
            if !lamp.may_light(in_lamp_frame) {
                continue;
            }
            let received: f64 = lamp.rays_to(in_lamp_frame).map(|ray| ray.illuminance_lx(up)).sum();
            let luminance = self.albedo * received / std::f64::consts::PI;
            let solid_angle = patch.area_mm2 * direction.z / (distance_mm * distance_mm);
            let air = (-transmittance_per_mm * distance_mm).exp();
            sum += luminance * solid_angle * response(incidence) * air;
        }
        sum
    }
}

struct Patch {
    centre_mm: DVec3,
    area_mm2: f64,
}

/// Patches that are small under the lamp and under the detector and grow between and beyond.
struct Patches {
    height_mm: f64,
    distance_mm: f64,
    next: usize,
}

impl Patches {
    fn new(height_mm: f64, distance_mm: f64) -> Self {
        Self {
            height_mm,
            distance_mm,
            next: 0,
        }
    }

    /// Place and length of cell `k` of `n` of a line that is stretched like h·tan about 0: even steps of the angle seen
    /// from height h, which is where the light is.
    fn stretched(k: usize, n: usize, height: f64, low: f64, high: f64) -> (f64, f64) {
        let (a, b) = ((low / height).atan(), (high / height).atan());
        let edge = |i: usize| height * (a + (b - a) * i as f64 / n as f64).tan();
        let (from, to) = (edge(k), edge(k + 1));
        let middle = height * (a + (b - a) * (k as f64 + 0.5) / n as f64).tan();
        (middle, to - from)
    }
}

impl Iterator for Patches {
    type Item = Patch;

    fn next(&mut self) -> Option<Patch> {
        let [near_lamp, near_detector, ny] = PATCHES;
        if self.next >= (near_lamp + near_detector) * ny {
            return None;
        }
        let (ix, iy) = (self.next / ny, self.next % ny);
        self.next += 1;
        // A hall: what comes from beyond is a ten-thousandth.
        let reach = 40.0 * self.height_mm;
        let half = 0.5 * self.distance_mm;
        let (x, dx) = if ix < near_lamp {
            Self::stretched(ix, near_lamp, self.height_mm, -reach, half)
        } else {
            let (from_detector, dx) = Self::stretched(ix - near_lamp, near_detector, self.height_mm, -half, 0.0);
            (self.distance_mm + from_detector, dx)
        };
        let (y, dy) = Self::stretched(iy, ny, self.height_mm, -reach, reach);
        Some(Patch {
            centre_mm: DVec3::new(x, y, -self.height_mm),
            area_mm2: dx * dy,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::document::Darkroom;
    use crate::flaws::Flaws;

    /// The same integral by brute force on an even grid of half a million patches.
    #[test]
    fn the_patches_agree_with_a_fine_even_grid() {
        let mut room = Darkroom::default();
        room.lamp.ring_diameter_mm = vec![0.0];
        room.lamp.leds_per_ring = vec![1];
        let lamp = Illuminator::new(&room.lamp, &room.flaws, 1);
        let height = 1000.0;
        let floor = Floor::new(0.3, height).unwrap();
        for (distance, gamma_deg) in [
            (2000.0, 0.0),
            (2000.0, 60.0),
            (2000.0, 120.0),
            (10_000.0, 0.0),
            (10_000.0, 30.0),
            (700.0, -60.0),
        ] {
            let mounted = Mounted::at(0.0, gamma_deg, 0.0, &Flaws::default());
            let detector = DVec3::X * distance;
            let got = floor.illuminance_lx(&lamp, &mounted, detector, -DVec3::X, 0.0, |c| c);
            let step = 100.0;
            let mut expected = 0.0;
            let mut x = -25_000.0 + step / 2.0;
            while x < distance {
                let mut y = -25_000.0 + step / 2.0;
                while y < 25_000.0 {
                    let p = DVec3::new(x, y, -height);
                    let r1 = p.length();
                    let intensity = lamp.far_field_cd(mounted.direction_to_luminaire(p / r1));
                    let e = intensity * 1e6 * (height / r1) / (r1 * r1);
                    let path = detector - p;
                    let r2 = path.length();
                    expected +=
                        0.3 / std::f64::consts::PI * e * (height / r2) * (path.x / r2) / (r2 * r2) * step * step;
                    y += step;
                }
                x += step;
            }
            assert!(
                (got / expected - 1.0).abs() < 0.01,
                "{distance} {gamma_deg}: {got} against {expected}"
            );
        }
    }

    #[test]
    fn a_black_floor_is_no_floor() {
        assert_eq!(Floor::new(0.0, 1000.0), None);
    }
}
