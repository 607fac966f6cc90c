//! A bare image sensor before the lamp: what each of its bins records.

use glam::{DMat3, DVec2, DVec3};

use crate::meter::saturating;
use crate::mount::lean;
use crate::noise::{Noise, Stream};
use crate::optics;
use crate::output::relative_output;
use crate::room::Room;

/// The sensor's face.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SensorFrame {
    /// Width and height, mm.
    pub size_mm: [f64; 2],
    /// Bins in x and y.
    pub bins: [usize; 2],
}

/// One exposure: where the sensor stands and how it is exposed, as `maps.toml` has it.
#[derive(Debug, Clone, PartialEq)]
pub struct MapPose {
    /// Distance from the light centre to the sensor's centre, mm.
    pub distance_mm: f64,
    /// Rotation Rx(tilt_x)·Ry(tilt_y)·Rz(rot_z), degrees.
    pub tilt_x_deg: f64,
    /// See `tilt_x_deg`.
    pub tilt_y_deg: f64,
    /// See `tilt_x_deg`.
    pub rot_z_deg: f64,
    /// Shift of the sensor in x and y, mm.
    pub offset_mm: [f64; 2],
    /// Relative exposure.
    pub exposure: f64,
    /// The lamp is on.
    pub lamp: bool,
    /// The sensor is capped.
    pub capped: bool,
    /// Since the lamp was switched on, s; `None`: warm and new.
    pub time_s: Option<f64>,
}

impl Default for MapPose {
    fn default() -> Self {
        Self {
            distance_mm: 500.0,
            tilt_x_deg: 0.0,
            tilt_y_deg: 0.0,
            rot_z_deg: 0.0,
            offset_mm: [0.0; 2],
            exposure: 1.0,
            lamp: true,
            capped: false,
            time_s: None,
        }
    }
}

/// Unit of a recorded map.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Unit {
    /// Relative to the camera's full scale; proportional to the exposure.
    Relative,
    /// Illuminance at exposure 1, lx.
    Lux,
    /// Irradiance at exposure 1, W/m².
    WattPerSquareMetre,
}

/// A recorded map, `[iy][ix]`.
#[derive(Debug, Clone, PartialEq)]
pub struct Capture {
    /// Signal of each bin.
    pub signal: Vec<f64>,
    /// Its standard deviation.
    pub u: Vec<f64>,
}

/// Two-point Gauss–Legendre places inside a cell of width 1 about its middle.
const INSIDE: [f64; 2] = [-0.288_675_134_594_813, 0.288_675_134_594_813];

impl Room {
    /// What the sensor records at `pose`, noise-free, in `unit`, `[iy][ix]`.
    ///
    /// Each bin is the mean of Gauss points; at each point every LED is traced through glass and micro-lens.
    pub fn sensor_map(&self, frame: &SensorFrame, pose: &MapPose, unit: Unit) -> Vec<f64> {
        let injected_effects = &self.document().injected_effects;
        let [nx, ny] = frame.bins;
        let full_scale_lx = self.document().camera.full_scale_lx;
        let exposure = pose.exposure + injected_effects.exposure_offset.offset;
        let signal_per_lx = exposure / full_scale_lx;
        let mut map = vec![0.0; nx * ny];
        if !pose.capped {
            let geometry = Geometry::new(self, pose, unit);
            let splits = splits_per_bin(frame, pose);
            for iy in 0..ny {
                for ix in 0..nx {
                    map[iy * nx + ix] = signal_per_lx * self.bin_lx(frame, &geometry, ix, iy, splits);
                }
            }
            if pose.lamp && injected_effects.ghost.amplitude_rel != 0.0 {
                let centre = signal_per_lx * geometry.lamp_lx(self, DVec2::ZERO);
                self.add_ghost(frame, centre, &mut map);
            }
        }
        let spread = smear(&map, nx, ny, injected_effects.crosstalk.width_px);
        let rescale = match unit {
            Unit::Relative => 1.0,
            Unit::Lux => full_scale_lx,
            Unit::WattPerSquareMetre => {
                full_scale_lx * self.spectrum().watt_per_lux(1.0) / injected_effects.ler_scale.factor
            }
        };
        spread
            .into_iter()
            .map(|signal| rescale * self.read_out(signal))
            .collect()
    }

    /// The map at `pose` with its noise; `index` is the map's number in the day.
    pub fn capture(&self, frame: &SensorFrame, pose: &MapPose, unit: Unit, index: u64) -> Capture {
        let camera = &self.document().camera;
        let noise = Noise::new(self.document().seed, Stream::Camera);
        let truth = self.sensor_map(frame, pose, unit);
        let full_scale = match unit {
            Unit::Relative => 1.0,
            Unit::Lux => camera.full_scale_lx,
            Unit::WattPerSquareMetre => camera.full_scale_lx * self.spectrum().watt_per_lux(1.0),
        };
        let u: Vec<f64> = truth
            .iter()
            .map(|s| (camera.noise_abs * full_scale).hypot(camera.noise_rel * s))
            .collect();
        let signal = truth
            .iter()
            .zip(&u)
            .enumerate()
            .map(|(bin, (s, u))| s + u * noise.normal(index, bin as u32))
            .collect();
        Capture { signal, u }
    }

    /// Mean illuminance of one bin weighted by the pixels' responsivity, lx.
    fn bin_lx(&self, frame: &SensorFrame, geometry: &Geometry, ix: usize, iy: usize, splits: usize) -> f64 {
        let pitch = DVec2::new(
            frame.size_mm[0] / frame.bins[0] as f64,
            frame.size_mm[1] / frame.bins[1] as f64,
        );
        let corner = DVec2::new(ix as f64, iy as f64) * pitch - 0.5 * DVec2::from(frame.size_mm);
        let cell = pitch / splits as f64;
        let mut sum = 0.0;
        for sy in 0..splits {
            for sx in 0..splits {
                for gy in INSIDE {
                    for gx in INSIDE {
                        let place = corner + cell * DVec2::new(sx as f64 + 0.5 + gx, sy as f64 + 0.5 + gy);
                        let lamp = geometry.lamp_lx(self, place) * self.stripes(place);
                        let ambient = self.document().injected_effects.ambient_light.illuminance_lx;
                        sum += (lamp + ambient) * self.responsivity(frame, place);
                    }
                }
            }
        }
        sum / (4 * splits * splits) as f64
    }

    /// Responsivity at a place of the sensor (mm), relative to its centre: vignetting and gradient.
    fn responsivity(&self, frame: &SensorFrame, place: DVec2) -> f64 {
        let injected_effects = &self.document().injected_effects;
        let half_mm = 0.5 * frame.size_mm[0];
        let radius_square = place.length_squared() / (half_mm * half_mm);
        // cos⁴ = (1 + r²/f²)^−2, with f such that the loss at r = 1 is as stated.
        let per_radius = 1.0 / (1.0 - injected_effects.vignetting.coefficient_rel).sqrt() - 1.0;
        let cos4 = (1.0 + per_radius * radius_square).powi(-2);
        let rise = &injected_effects.prnu_gradient;
        let along = place.dot(DVec2::from_angle(rise.azimuth_deg.to_radians())) / half_mm;
        cos4 * (1.0 + rise.gradient_rel * along)
    }

    fn stripes(&self, place: DVec2) -> f64 {
        let banding = &self.document().injected_effects.flicker_banding;
        1.0 + banding.amplitude_rel * (std::f64::consts::TAU * place.y / banding.period_mm + banding.phase_rad).sin()
    }

    fn add_ghost(&self, frame: &SensorFrame, centre_signal: f64, map: &mut [f64]) {
        let ghost = &self.document().injected_effects.ghost;
        let [nx, ny] = frame.bins;
        for iy in 0..ny {
            for ix in 0..nx {
                let x = (ix as f64 + 0.5) * frame.size_mm[0] / nx as f64 - 0.5 * frame.size_mm[0] - ghost.x_mm;
                let y = (iy as f64 + 0.5) * frame.size_mm[1] / ny as f64 - 0.5 * frame.size_mm[1] - ghost.y_mm;
                let spot = (-0.5 * (x * x + y * y) / (ghost.width_mm * ghost.width_mm)).exp();
                map[iy * nx + ix] += ghost.amplitude_rel * centre_signal * spot;
            }
        }
    }

    /// From collected charge to the stored signal, relative to full scale.
    fn read_out(&self, signal: f64) -> f64 {
        let injected_effects = &self.document().injected_effects;
        let bent =
            saturating(signal, injected_effects.nonlinearity.inverse_scale) + injected_effects.dark_offset.offset_rel;
        let clipped = if injected_effects.saturation.level_rel > 0.0 {
            bent.min(injected_effects.saturation.level_rel)
        } else {
            bent
        };
        let step = injected_effects.quantization.step_rel;
        if step > 0.0 {
            (clipped / step).round() * step
        } else {
            clipped
        }
    }
}

/// The sensor's pose with every error of the station in it, and the lamp's output.
struct Geometry {
    rotation: DMat3,
    centre_mm: DVec3,
    to_lamp: DMat3,
    output: f64,
    /// What the pixels make of a lux by its phosphor light, relative to that along an LED's axis; none where every
    /// direction has one colour, or they see it as V(λ) does.
    response: Option<Box<dyn Fn(f64) -> f64>>,
}

impl Geometry {
    fn new(room: &Room, pose: &MapPose, unit: Unit) -> Self {
        let injected_effects = &room.document().injected_effects;
        let stated = DMat3::from_rotation_x(pose.tilt_x_deg.to_radians())
            * DMat3::from_rotation_y(pose.tilt_y_deg.to_radians())
            * DMat3::from_rotation_z(pose.rot_z_deg.to_radians());
        let tilt = &injected_effects.sensor_tilt;
        // The chip's −z faces the lamp: leaning +z away from the azimuth lifts that side towards the lamp.
        let in_housing = lean(tilt.angle_deg.to_radians(), tilt.azimuth_deg.to_radians());
        let stage = DVec2::from_angle(injected_effects.stage_lateral.azimuth_deg.to_radians())
            * injected_effects.stage_lateral.offset_mm;
        let source = &injected_effects.source_tilt;
        let source_lean = lean(
            source.angle_deg.to_radians(),
            source.azimuth_deg.to_radians() + std::f64::consts::PI,
        );
        let output = match (pose.lamp, pose.time_s) {
            (false, _) => 0.0,
            (true, Some(time_s)) => relative_output(injected_effects, time_s, 0.0),
            (true, None) => 1.0,
        };
        Self {
            rotation: stated * in_housing,
            centre_mm: DVec3::new(
                pose.offset_mm[0] + stage.x,
                pose.offset_mm[1] + stage.y,
                pose.distance_mm + injected_effects.sensor_axial.offset_mm,
            ),
            to_lamp: source_lean.transpose(),
            output,
            response: response(room, unit),
        }
    }

    /// Illuminance by the lamp at a place on the sensor (mm) behind glass and micro-lens, lx.
    fn lamp_lx(&self, room: &Room, place: DVec2) -> f64 {
        if self.output == 0.0 {
            return 0.0;
        }
        let injected_effects = &room.document().injected_effects;
        let (glass, lens) = (
            &injected_effects.cover_glass,
            injected_effects.pixel_angular.coefficient,
        );
        let point = self.to_lamp * (self.rotation * place.extend(0.0) + self.centre_mm);
        let normal = self.to_lamp * (self.rotation * DVec3::NEG_Z);
        let mut sum = 0.0;
        for ray in room.lamp().rays_to(point) {
            let cos = ray.incidence_cos(normal);
            if cos <= 0.0 {
                continue;
            }
            let mut light = ray.normal_illuminance_lx() * cos;
            if let Some(response) = &self.response {
                light *= response(ray.phosphor);
            }
            if glass.plates != 0.0 {
                light *= optics::plates_transmittance(glass.plates, glass.index, cos);
            }
            if lens != 0.0 {
                light *= (-lens * (1.0 / (cos * cos) - 1.0)).exp();
            }
            sum += light;
        }
        self.output * sum
    }
}

/// A map in W/m² is that of a perfect radiometer; the camera's own signal goes by its quantum efficiency, in electrons
/// a watt in proportion to the wavelength.
fn response(room: &Room, unit: Unit) -> Option<Box<dyn Fn(f64) -> f64>> {
    if !room.lamp().has_colours() {
        return None;
    }
    let camera = &room.document().camera;
    let electrons = |nm: f64| nm * (-0.5 * ((nm - camera.qe_peak_nm) / camera.qe_width_nm).powi(2)).exp();
    match unit {
        Unit::WattPerSquareMetre => Some(Box::new(room.spectrum().response(&|_| 1.0))),
        Unit::Relative | Unit::Lux if camera.qe_peak_nm > 0.0 => Some(Box::new(room.spectrum().response(&electrons))),
        Unit::Relative | Unit::Lux => None,
    }
}

/// Cells per bin and side, so that a cell is small against the distance and against whatever stands on the sensor.
fn splits_per_bin(frame: &SensorFrame, pose: &MapPose) -> usize {
    let pitch = (frame.size_mm[0] / frame.bins[0] as f64).max(frame.size_mm[1] / frame.bins[1] as f64);
    let finest = 0.02 * pose.distance_mm.abs().max(10.0);
    ((pitch / finest).ceil() as usize).clamp(1, 32)
}

/// Gaussian point-spread function of standard deviation `width` bins; the charge of the rim stays on the sensor.
fn smear(map: &[f64], nx: usize, ny: usize, width: f64) -> Vec<f64> {
    if width <= 0.0 {
        return map.to_vec();
    }
    let reach = (4.0 * width).ceil() as isize;
    let kernel: Vec<f64> = (-reach..=reach)
        .map(|k| (-0.5 * (k as f64 / width).powi(2)).exp())
        .collect();
    let total: f64 = kernel.iter().sum();
    let along = |source: &[f64], n: usize, stride: usize, start: usize, into: &mut [f64]| {
        for i in 0..n as isize {
            let mut sum = 0.0;
            for (k, weight) in (-reach..=reach).zip(&kernel) {
                // Mirror at the rim.
                let mut j = i + k;
                let period = 2 * n as isize;
                j = j.rem_euclid(period);
                if j >= n as isize {
                    j = period - 1 - j;
                }
                sum += weight * source[start + j as usize * stride];
            }
            into[start + i as usize * stride] = sum / total;
        }
    };
    let mut rows = vec![0.0; map.len()];
    for iy in 0..ny {
        along(map, nx, 1, iy * nx, &mut rows);
    }
    let mut both = vec![0.0; map.len()];
    for ix in 0..nx {
        along(&rows, ny, nx, ix, &mut both);
    }
    both
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::document::Darkroom;

    const FRAME: SensorFrame = SensorFrame {
        size_mm: [24.576, 24.576],
        bins: [8, 8],
    };

    fn room_with(injected_effects: &[(&str, &str, f64)]) -> Room {
        let mut document = Darkroom::default();
        document.lamp.ring_diameter_mm = vec![0.0];
        document.lamp.leds_per_ring = vec![1];
        document.lamp.ellipticity_rel = 0.0;
        document.lamp.aim_spread_deg = 0.0;
        for (name, key, value) in injected_effects {
            assert!(document.injected_effects.set(name, key, *value), "{name}.{key}");
        }
        Room::new(document)
    }

    fn lux(room: &Room, pose: &MapPose) -> Vec<f64> {
        room.sensor_map(&FRAME, pose, Unit::Lux)
    }

    /// A point lamp cosⁿ before a parallel sensor: E = I₀ cosⁿ⁺³/d² at every point, here with fine midpoint
    /// sums.
    #[test]
    fn a_point_lamp_gives_the_closed_form() {
        let room = room_with(&[]);
        let map = lux(
            &room,
            &MapPose {
                distance_mm: 60.0,
                offset_mm: [5.0, -3.0],
                ..MapPose::default()
            },
        );
        let intensity = room.intensity_cd(0.0, 0.0);
        let n = 40;
        for (iy, ix) in [(0, 0), (3, 6), (7, 1)] {
            let mut expected = 0.0;
            for j in 0..n {
                for i in 0..n {
                    let x = (ix as f64 + (i as f64 + 0.5) / n as f64) * 3.072 - 12.288 + 5.0;
                    let y = (iy as f64 + (j as f64 + 0.5) / n as f64) * 3.072 - 12.288 - 3.0;
                    let r2 = x * x + y * y + 3600.0;
                    let cos = 60.0 / r2.sqrt();
                    expected += intensity * 1e6 * cos.powf(6.3) / r2 / (n * n) as f64;
                }
            }
            let got = map[iy * 8 + ix];
            assert!((got / expected - 1.0).abs() < 2e-5, "{ix} {iy}: {got} {expected}");
        }
    }

    /// One LED before a parallel sensor: its phosphor light at each place by hand, from the angle that the place has.
    #[test]
    fn light_of_another_colour_has_its_own_watts_and_electrons() {
        let mut document = Darkroom::default();
        document.lamp.ring_diameter_mm = vec![0.0];
        document.lamp.leds_per_ring = vec![1];
        document.lamp.ellipticity_rel = 0.0;
        document.lamp.aim_spread_deg = 0.0;
        document.lamp.phosphor_rise_rel = 0.5;
        document.lamp.phosphor_lean_rel = 0.2;
        document.lamp.phosphor_lean_azimuth_deg = 30.0;
        document.camera.qe_peak_nm = 530.0;
        document.camera.qe_width_nm = 60.0;
        let plain = Room::new(Darkroom {
            lamp: crate::parts::Lamp {
                phosphor_rise_rel: 0.0,
                phosphor_lean_rel: 0.0,
                ..document.lamp.clone()
            },
            ..document.clone()
        });
        let room = Room::new(document);
        let fine = SensorFrame {
            size_mm: [24.0, 24.0],
            bins: [25, 25],
        };
        let pose = MapPose {
            distance_mm: 30.0,
            ..MapPose::default()
        };
        let spectrum = room.spectrum();
        let qe = |nm: f64| nm * (-0.5 * ((nm - 530.0) / 60.0f64).powi(2)).exp();
        let sum = |phosphor: f64, of: &dyn Fn(f64) -> f64| -> f64 {
            (360..=830)
                .map(|nm| of(f64::from(nm)) * spectrum.per_lux(f64::from(nm), phosphor))
                .sum()
        };
        for (unit, of) in [
            (Unit::WattPerSquareMetre, &(|_: f64| 1.0) as &dyn Fn(f64) -> f64),
            (Unit::Relative, &qe),
        ] {
            let (seen, grey) = (
                room.sensor_map(&fine, &pose, unit),
                plain.sensor_map(&fine, &pose, unit),
            );
            for (ix, iy) in [(12, 12), (24, 12), (3, 20)] {
                let place = |i: i32| (f64::from(i) + 0.5) * 24.0 / 25.0 - 12.0;
                let direction = DVec3::new(place(ix), place(iy), 30.0).normalize();
                let side = DVec2::from_angle(30f64.to_radians()).extend(0.0);
                let phosphor = 1.0 + 0.5 * (1.0 - direction.z * direction.z) + 0.2 * side.dot(direction);
                assert!(
                    (room.phosphor(
                        direction.y.atan2(direction.x).to_degrees(),
                        direction.z.acos().to_degrees()
                    ) - phosphor)
                        .abs()
                        < 1e-9
                );
                let expected = sum(phosphor, of) / sum(1.0, of);
                let bin = (iy * 25 + ix) as usize;
                let got = seen[bin] / grey[bin];
                assert!(
                    (got / expected - 1.0).abs() < 2e-5,
                    "{unit:?} {ix} {iy}: {got} {expected}"
                );
            }
        }
        assert_eq!(
            room.sensor_map(&fine, &pose, Unit::Lux).len(),
            625,
            "a map in lx is weighed by the quantum efficiency too"
        );
    }

    #[test]
    fn tilts_follow_the_stated_order() {
        // Rx(90°) would turn +y into +z; at 30° the side of +y is farther from the lamp.
        let map = lux(
            &room_with(&[]),
            &MapPose {
                tilt_x_deg: 30.0,
                distance_mm: 100.0,
                ..MapPose::default()
            },
        );
        assert!(map[7 * 8 + 4] < map[4]);
        // Ry turns +x towards −z: nearer.
        let map = lux(
            &room_with(&[]),
            &MapPose {
                tilt_y_deg: 30.0,
                distance_mm: 100.0,
                ..MapPose::default()
            },
        );
        assert!(map[4 * 8 + 7] > map[4 * 8]);
    }

    #[test]
    fn misplacements_equal_the_pose_that_they_make() {
        let pose = MapPose {
            distance_mm: 200.0,
            tilt_x_deg: 10.0,
            ..MapPose::default()
        };
        let moved = lux(
            &room_with(&[
                ("stage_lateral", "offset_mm", 3.0),
                ("stage_lateral", "azimuth_deg", 90.0),
            ]),
            &pose,
        );
        let stated = lux(
            &room_with(&[]),
            &MapPose {
                offset_mm: [0.0, 3.0],
                ..pose.clone()
            },
        );
        assert!(moved.iter().zip(&stated).all(|(a, b)| (a / b - 1.0).abs() < 1e-12));
        let deeper = lux(&room_with(&[("sensor_axial", "offset_mm", 2.0)]), &pose);
        let stated = lux(
            &room_with(&[]),
            &MapPose {
                distance_mm: 202.0,
                ..pose.clone()
            },
        );
        assert!(deeper.iter().zip(&stated).all(|(a, b)| (a / b - 1.0).abs() < 1e-12));
        // A tilt of the chip towards +x alone is Ry.
        let tilted = lux(
            &room_with(&[("sensor_tilt", "angle_deg", 4.0)]),
            &MapPose {
                distance_mm: 200.0,
                ..MapPose::default()
            },
        );
        let stated = lux(
            &room_with(&[]),
            &MapPose {
                distance_mm: 200.0,
                tilt_y_deg: 4.0,
                ..MapPose::default()
            },
        );
        assert!(tilted.iter().zip(&stated).all(|(a, b)| (a / b - 1.0).abs() < 1e-12));
        // A lamp whose γ is larger on the side of +x is darker there.
        let leaning = lux(
            &room_with(&[("source_tilt", "angle_deg", 3.0)]),
            &MapPose {
                distance_mm: 200.0,
                ..MapPose::default()
            },
        );
        assert!(leaning[4 * 8 + 7] < leaning[4 * 8]);
    }

    #[test]
    fn signals_follow_exposure_offset_and_read_out() {
        let room = room_with(&[
            ("exposure_offset", "offset", 0.02),
            ("dark_offset", "offset_rel", 0.01),
            ("ambient_light", "illuminance_lx", 5.0),
        ]);
        let capped = room.sensor_map(
            &FRAME,
            &MapPose {
                capped: true,
                ..MapPose::default()
            },
            Unit::Relative,
        );
        assert!(capped.iter().all(|s| *s == 0.01));
        let off = room.sensor_map(
            &FRAME,
            &MapPose {
                lamp: false,
                exposure: 0.5,
                ..MapPose::default()
            },
            Unit::Relative,
        );
        assert!(off.iter().all(|s| (s - 0.01 - 5.0 * 0.52 / 1350.0).abs() < 1e-12));
        let full = room.sensor_map(&FRAME, &MapPose::default(), Unit::Relative);
        let half = room.sensor_map(
            &FRAME,
            &MapPose {
                exposure: 0.5,
                ..MapPose::default()
            },
            Unit::Relative,
        );
        assert!(((half[20] - 0.01) / (full[20] - 0.01) - 0.52 / 1.02).abs() < 1e-12);
        let clipped = room_with(&[("saturation", "level_rel", 0.9), ("quantization", "step_rel", 0.25)]);
        assert_eq!(clipped.sensor_map(&FRAME, &MapPose::default(), Unit::Relative)[27], 1.0);
        assert_eq!(
            clipped.sensor_map(
                &FRAME,
                &MapPose {
                    exposure: 0.5,
                    ..MapPose::default()
                },
                Unit::Relative
            )[27],
            0.5
        );
    }

    #[test]
    fn patterns_of_the_sensor_have_their_stated_size() {
        let pose = MapPose {
            distance_mm: 5000.0,
            exposure: 100.0,
            ..MapPose::default()
        };
        let fine = SensorFrame {
            size_mm: [24.576, 24.576],
            bins: [65, 65],
        };
        let ratio = |injected_effects: &[(&str, &str, f64)], bin: usize| {
            room_with(injected_effects).sensor_map(&fine, &pose, Unit::Relative)[bin]
                / room_with(&[]).sensor_map(&fine, &pose, Unit::Relative)[bin]
        };
        let middle_row = 32 * 65;
        // The last bin lies at 64/65 of half the width.
        let r = 64.0f64 / 65.0;
        assert!(
            (ratio(&[("vignetting", "coefficient_rel", 0.05)], middle_row + 64) - (1.0 - 0.05 * r * r)).abs() < 5e-4
        );
        assert!((ratio(&[("prnu_gradient", "gradient_rel", 0.02)], middle_row + 64) - (1.0 + 0.02 * r)).abs() < 1e-6);
        assert!((ratio(&[("ghost", "amplitude_rel", 0.02)], middle_row + 32) - 1.02).abs() < 1e-4);
        let smeared = room_with(&[
            ("crosstalk", "width_px", 1.5),
            ("ghost", "amplitude_rel", 0.5),
            ("ghost", "width_mm", 1.0),
        ]);
        let sharp = room_with(&[("ghost", "amplitude_rel", 0.5), ("ghost", "width_mm", 1.0)]);
        let sum = |room: &Room| room.sensor_map(&fine, &pose, Unit::Relative).iter().sum::<f64>();
        assert!((sum(&smeared) / sum(&sharp) - 1.0).abs() < 1e-9);
        assert!(
            smeared.sensor_map(&fine, &pose, Unit::Relative)[middle_row + 32]
                < sharp.sensor_map(&fine, &pose, Unit::Relative)[middle_row + 32]
        );
    }

    #[test]
    fn the_glass_takes_more_from_slanting_light() {
        let pose = MapPose {
            tilt_x_deg: 60.0,
            ..MapPose::default()
        };
        let glass = room_with(&[("cover_glass", "plates", 1.0)]);
        let at = |pose: &MapPose| lux(&glass, pose)[27] / lux(&room_with(&[]), pose)[27];
        assert!((at(&MapPose::default()) - 0.918).abs() < 1e-3);
        assert!(at(&pose) < at(&MapPose::default()) - 0.03);
        let noisy = glass.capture(&FRAME, &pose, Unit::Relative, 4);
        assert_eq!(noisy, glass.capture(&FRAME, &pose, Unit::Relative, 4));
        assert_ne!(noisy.signal, glass.capture(&FRAME, &pose, Unit::Relative, 5).signal);
    }
}
