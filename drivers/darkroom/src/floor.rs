//! Light that the floor sends to the detector: a Lambertian plane added up patch by patch.

use glam::DVec3;

use crate::far_field::FarField;
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
    /// Each patch takes the light of the lamp and sends it on as luminance ρE/π; both paths lose to the air. `far`
    /// is the lamp as it is seen from far away. `response` weights the light of one patch by the detector's response
    /// to its incidence cosine.
    pub fn illuminance_lx(
        &self,
        lamp: &Illuminator,
        far: &FarField,
        mounted: &Mounted,
        detector_mm: DVec3,
        normal: DVec3,
        transmittance_per_mm: f64,
        response: impl Fn(f64) -> f64,
    ) -> f64 {
        let up = mounted.direction_to_luminaire(DVec3::Z);
        let mut sum = 0.0;
        for patch in patches(self.height_mm, detector_mm.x) {
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
            let received: f64 = if in_lamp_frame.length() > lamp.far_mm() {
                far.ray_to(in_lamp_frame, transmittance_per_mm).illuminance_lx(up)
            } else {
                lamp.rays_to(in_lamp_frame).map(|ray| ray.illuminance_lx(up)).sum()
            };
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
fn patches(height_mm: f64, distance_mm: f64) -> impl Iterator<Item = Patch> {
    let [near_lamp, near_detector, across] = PATCHES;
    // A hall: what comes from beyond is a ten-thousandth.
    let reach = 40.0 * height_mm;
    let half = 0.5 * distance_mm;
    let under_detector = stretched(near_detector, height_mm, -half, 0.0);
    let columns: Vec<(f64, f64)> = stretched(near_lamp, height_mm, -reach, half)
        .chain(under_detector.map(|(from_detector, dx)| (distance_mm + from_detector, dx)))
        .collect();
    let rows: Vec<(f64, f64)> = stretched(across, height_mm, -reach, reach).collect();
    columns.into_iter().flat_map(move |(x, dx)| {
        let patch = move |(y, dy)| Patch {
            centre_mm: DVec3::new(x, y, -height_mm),
            area_mm2: dx * dy,
        };
        rows.clone().into_iter().map(patch)
    })
}

/// Places and lengths of the `n` cells of a line that is stretched like h·tan about 0: even steps of the angle seen
/// from height h, which is where the light is.
fn stretched(n: usize, height: f64, low: f64, high: f64) -> impl Iterator<Item = (f64, f64)> {
    let (a, b) = ((low / height).atan(), (high / height).atan());
    let at = move |steps: f64| height * (a + (b - a) * steps / n as f64).tan();
    (0..n).map(move |k| (at(k as f64 + 0.5), at(k as f64 + 1.0) - at(k as f64)))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::document::Darkroom;
    use crate::injected_effects::InjectedEffects;

    /// The same integral by brute force on an even grid of half a million patches.
    #[test]
    fn the_patches_agree_with_a_fine_even_grid() {
        let mut room = Darkroom::default();
        room.lamp.ring_diameter_mm = vec![0.0];
        room.lamp.leds_per_ring = vec![1];
        let lamp = Illuminator::new(&room.lamp, &room.injected_effects, 1);
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
            let mounted = Mounted::at(0.0, gamma_deg, 0.0, &InjectedEffects::default());
            let detector = DVec3::X * distance;
            let got = floor.illuminance_lx(&lamp, &FarField::new(&lamp), &mounted, detector, -DVec3::X, 0.0, |c| c);
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
