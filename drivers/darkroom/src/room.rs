//! The room: lamp, bench, floor, meter, put together. What is asked here is the truth.

use std::sync::OnceLock;

use glam::DVec3;
use isolux_document::DocumentError;

use crate::document::Darkroom;
use crate::far_field::FarField;
use crate::floor::Floor;
use crate::head::Head;
use crate::illuminator::{Illuminator, Ray};
use crate::meter;
use crate::mount::Mounted;
use crate::noise::{Noise, Stream};
use crate::optics;
use crate::output::relative_output;
use crate::pixel::Pixel;
use crate::spectrum::LampSpectrum;

/// What stands between lamp and meter.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Kind {
    /// Lamp on, path open.
    Lit,
    /// Lamp on, direct path blocked: lamp-made stray light, ambient light and offset are left.
    Baffled,
    /// Lamp off: ambient light and offset.
    LampOff,
    /// Meter capped: offset.
    Capped,
}

/// Coordinates of one reading of the lux meter, as `readings.csv` has them.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Observation {
    /// What was open.
    pub kind: Kind,
    /// Middle of the integration, s since the lamp was switched on.
    pub time_s: f64,
    /// Read-back C, degrees.
    pub c_deg: f64,
    /// Read-back γ, degrees, may be signed.
    pub gamma_deg: f64,
    /// From the intersection of the axes to the meter's reference plane, mm.
    pub distance_mm: f64,
    /// Sign of the last γ motion, 0 if none; between −1 and 1 while play is being taken up.
    pub travel: f64,
    /// Range of the meter, 0 if not known.
    pub range: u8,
    /// Room temperature, °C.
    pub ambient_c: f64,
}

/// One virtual darkroom.
#[derive(Debug, Clone)]
pub struct Room {
    document: Darkroom,
    lamp: Illuminator,
    floor: Option<(Floor, FarField)>,
    spectrum: LampSpectrum,
    /// None where it is V(λ).
    head: Option<Head>,
    pub(crate) pixels: OnceLock<Vec<Pixel>>,
}

/// Seven-point rule on the unit disc, exact to fifth order (Abramowitz & Stegun 25.4.61): (y, z, weight).
fn disc_rule() -> [(f64, f64, f64); 7] {
    let radius = (2.0f64 / 3.0).sqrt();
    std::array::from_fn(|k| {
        if k == 0 {
            (0.0, 0.0, 0.25)
        } else {
            let (sin, cos) = (std::f64::consts::TAU * (k - 1) as f64 / 6.0).sin_cos();
            (radius * cos, radius * sin, 0.125)
        }
    })
}

impl Room {
    /// Builds the room that the document describes.
    pub fn new(document: Darkroom) -> Self {
        let floor = &document.injected_effects.floor_reflection;
        let lamp = Illuminator::new(&document.lamp, &document.injected_effects, document.seed);
        let spectrum = LampSpectrum::new(&document.lamp);
        Self {
            floor: Floor::new(floor.albedo, floor.height_mm).map(|floor| (floor, FarField::new(&lamp))),
            lamp,
            head: Head::new(&document.luxmeter, &spectrum),
            spectrum,
            document,
            pixels: OnceLock::new(),
        }
    }

    /// Builds the room of a `darkroom.toml`.
    ///
    /// # Errors
    /// As [`Darkroom::parse`].
    pub fn parse(text: &str) -> Result<Self, DocumentError> {
        Darkroom::parse(text).map(Self::new)
    }

    /// The document.
    pub fn document(&self) -> &Darkroom {
        &self.document
    }

    /// The lamp.
    pub fn lamp(&self) -> &Illuminator {
        &self.lamp
    }

    /// The lamp's spectrum.
    pub fn spectrum(&self) -> &LampSpectrum {
        &self.spectrum
    }

    /// Luminous intensity of the warm lamp towards (C, γ) of its own frame, infinitely far away, cd: the truth that a
    /// faultless goniophotometer approaches.
    pub fn intensity_cd(&self, c_deg: f64, gamma_deg: f64) -> f64 {
        let (sin_c, cos_c) = c_deg.to_radians().sin_cos();
        let (sin_g, cos_g) = gamma_deg.to_radians().sin_cos();
        self.lamp.far_field_cd(DVec3::new(sin_g * cos_c, sin_g * sin_c, cos_g))
    }

    /// Phosphor light against the chip's in the light towards (C, γ), infinitely far away: its colour, as the spectrum
    /// [`LampSpectrum`] has it.
    pub fn phosphor(&self, c_deg: f64, gamma_deg: f64) -> f64 {
        let (sin_c, cos_c) = c_deg.to_radians().sin_cos();
        let (sin_g, cos_g) = gamma_deg.to_radians().sin_cos();
        let direction = DVec3::new(sin_g * cos_c, sin_g * sin_c, cos_g);
        self.spectrum.mixed(self.lamp.far_field_parts(direction))
    }

    /// Illuminance of the lamp's light that the meter weighs on its aperture: direct path only, warm lamp, lx.
    pub fn direct_lx(&self, o: &Observation) -> f64 {
        let injected_effects = &self.document.injected_effects;
        let mounted = Mounted::at(o.c_deg, o.gamma_deg, o.travel, injected_effects);
        let towards_lamp = mounted.direction_to_luminaire(-DVec3::X);
        let radius_mm = 0.5 * injected_effects.detector_aperture.diameter_mm;
        let centre = DVec3::X * self.true_distance_mm(o);
        let at = |place: DVec3| -> f64 {
            self.lamp
                .rays_to(mounted.to_luminaire(place))
                .map(|ray| ray.illuminance_lx(towards_lamp) * self.response(&ray, towards_lamp))
                .sum()
        };
        let direct = if radius_mm == 0.0 {
            at(centre)
        } else {
            disc_rule()
                .iter()
                .map(|(y, z, w)| w * at(centre + radius_mm * DVec3::new(0.0, *y, *z)))
                .sum()
        };
        let polarization = &injected_effects.polarization;
        let roll = (o.c_deg + injected_effects.c_zero.offset_deg - polarization.azimuth_deg).to_radians();
        direct * optics::polarized_response(polarization.amplitude_rel, roll)
    }

    /// Illuminance that the floor returns to the meter, warm lamp, lx.
    pub fn floor_lx(&self, o: &Observation) -> f64 {
        let Some((floor, far)) = &self.floor else { return 0.0 };
        let injected_effects = &self.document.injected_effects;
        let mounted = Mounted::at(o.c_deg, o.gamma_deg, o.travel, injected_effects);
        let detector = DVec3::X * self.true_distance_mm(o);
        let air = injected_effects.air_absorption.coefficient_per_m / 1000.0;
        let f2 = injected_effects.cosine_f2.coefficient_rel;
        let light = floor.illuminance_lx(&self.lamp, far, &mounted, detector, -DVec3::X, air, |cos| {
            cos * optics::directional_response(f2, cos)
        });
        // A grey floor returns light of all directions: near the colour of an LED's axis.
        light * self.head.map_or(1.0, |head| head.shown_of_one_lux(1.0))
    }

    /// All the light on the meter, averaged over `window_s` around the observation's time, lx.
    pub fn illuminance_lx(&self, o: &Observation, window_s: f64) -> f64 {
        let floor_lx = if matches!(o.kind, Kind::Lit | Kind::Baffled) {
            self.floor_lx(o)
        } else {
            0.0
        };
        self.illuminance_with_floor_lx(o, window_s, floor_lx)
    }

    /// As [`illuminance_lx`](Self::illuminance_lx), with the floor's light of the warm lamp known already.
    pub fn illuminance_with_floor_lx(&self, o: &Observation, window_s: f64, floor_lx: f64) -> f64 {
        let output = || self.output(o.time_s, window_s);
        let ambient = self.document.injected_effects.ambient_stray.illuminance_lx;
        match o.kind {
            Kind::Lit => output() * (self.direct_lx(o) + floor_lx) + ambient,
            Kind::Baffled => output() * floor_lx + ambient,
            Kind::LampOff => ambient,
            Kind::Capped => 0.0,
        }
    }

    /// What the meter would indicate without noise and digits, lx: the held-out truth of a reading.
    pub fn indicated_lx(&self, o: &Observation) -> f64 {
        let light = self.illuminance_lx(o, self.document.luxmeter.integration_s);
        self.indicated_for_lx(light, o.ambient_c, o.range)
    }

    /// What the meter indicates, without noise and digits, for `illuminance_lx` on its aperture, lx.
    pub fn indicated_for_lx(&self, illuminance_lx: f64, ambient_c: f64, range: u8) -> f64 {
        let gain = self.document.luxmeter.gain_error_rel;
        meter::indicated_lx(illuminance_lx, ambient_c, range, gain, &self.document.injected_effects)
    }

    /// Standard deviation of the meter's noise at an indication of `indicated_lx`, lx.
    pub fn reading_noise_lx(&self, indicated_lx: f64) -> f64 {
        let meter = &self.document.luxmeter;
        (meter.noise_rel * indicated_lx).hypot(meter.noise_lx)
    }

    /// Standard normal noise of the meter's conversion number `index`; neighbours are correlated as the document says
    /// (a moving average that has the variance 1 and dies out as an AR(1) process does).
    pub fn meter_noise(&self, index: u64) -> f64 {
        let noise = Noise::new(self.document.seed, Stream::LuxMeter);
        let rho = self.document.luxmeter.noise_correlation;
        if rho == 0.0 {
            return noise.normal(index, 0);
        }
        let (mut sum, mut weight, mut square) = (0.0, 1.0, 0.0);
        for back in 0..64.min(index + 1) {
            sum += weight * noise.normal(index - back, 0);
            square += weight * weight;
            weight *= rho;
        }
        sum / square.sqrt()
    }

    /// One reading with noise, digits left out: (illuminance, its standard deviation), lx. `index` is its place in the
    /// day.
    pub fn reading_lx(&self, o: &Observation, index: u64) -> (f64, f64) {
        let indicated = self.indicated_lx(o);
        let u = self.reading_noise_lx(indicated);
        (indicated + u * self.meter_noise(index), u)
    }

    /// Illuminance at the spectroradiometer's entrance with the luminaire at (C, γ), averaged over `window_s` around
    /// `time_s` (since switch-on), lx. Its light path is short and its tube keeps the floor out.
    pub fn spectroradiometer_lx(&self, lamp_on: bool, c_deg: f64, gamma_deg: f64, time_s: f64, window_s: f64) -> f64 {
        let injected_effects = &self.document.injected_effects;
        let ambient = injected_effects.ambient_stray.illuminance_lx;
        if !lamp_on {
            return ambient;
        }
        let mounted = Mounted::at(c_deg, gamma_deg, 0.0, injected_effects);
        let entrance = mounted.to_luminaire(DVec3::X * self.document.spectroradiometer.distance_mm);
        let normal = mounted.direction_to_luminaire(-DVec3::X);
        let warm: f64 = self.lamp.rays_to(entrance).map(|ray| ray.illuminance_lx(normal)).sum();
        warm * self.output(time_s, window_s) + ambient
    }

    /// Phosphor light against the chip's in the light at the spectroradiometer's entrance, the room's own included,
    /// with the luminaire at (C, γ) at `time_s`.
    pub fn spectroradiometer_phosphor(&self, lamp_on: bool, c_deg: f64, gamma_deg: f64, time_s: f64) -> f64 {
        if !lamp_on || !self.lamp.has_colours() {
            return 1.0;
        }
        let injected_effects = &self.document.injected_effects;
        let mounted = Mounted::at(c_deg, gamma_deg, 0.0, injected_effects);
        let entrance = mounted.to_luminaire(DVec3::X * self.document.spectroradiometer.distance_mm);
        let normal = mounted.direction_to_luminaire(-DVec3::X);
        let output = self.output(time_s, 0.0);
        let lamp = self.lamp.rays_to(entrance);
        let lamp = lamp.map(|ray| (output * ray.illuminance_lx(normal), ray.phosphor));
        let ambient = injected_effects.ambient_stray.illuminance_lx;
        self.spectrum.mixed(lamp.chain(std::iter::once((ambient, 1.0))))
    }

    /// Latency of the meter's measurement number `index`, s.
    pub fn meter_latency_s(&self, index: u64) -> f64 {
        let meter = &self.document.luxmeter;
        let noise = Noise::new(self.document.seed, Stream::LuxMeter).normal(index, 1);
        (meter.latency_s + meter.latency_jitter_s * noise).max(0.0)
    }

    /// Output of the lamp relative to the warm one at one moment, `time_s` after it was switched on.
    pub fn lamp_output(&self, time_s: f64) -> f64 {
        self.output(time_s, 0.0)
    }

    /// Light of a lamp that is switched on and off, relative to its mean, averaged over a window around `time_s`.
    fn pulses(&self, time_s: f64, window_s: f64) -> f64 {
        let lamp = &self.document.lamp;
        if lamp.pwm_hz == 0.0 || lamp.pwm_duty == 1.0 {
            return 1.0;
        }
        // Time on since the first pulse began, in periods.
        let on = |periods: f64| periods.floor() * lamp.pwm_duty + (periods - periods.floor()).min(lamp.pwm_duty);
        let at = |time_s: f64| time_s * lamp.pwm_hz;
        if window_s == 0.0 {
            let lit = at(time_s) - at(time_s).floor() < lamp.pwm_duty;
            return if lit { 1.0 / lamp.pwm_duty } else { 0.0 };
        }
        let (from, to) = (at(time_s - 0.5 * window_s), at(time_s + 0.5 * window_s));
        (on(to) - on(from)) / (to - from) / lamp.pwm_duty
    }

    /// Output of the lamp relative to the warm one, averaged over a window around `time_s`, its flicker included.
    fn output(&self, time_s: f64, window_s: f64) -> f64 {
        let flicker = self.document.lamp.flicker_rel;
        let slow = self.spectrum.level() * relative_output(&self.document.injected_effects, time_s, window_s);
        let slow = slow * self.pulses(time_s, window_s);
        if flicker == 0.0 {
            return slow;
        }
        let turn = 2.0 * std::f64::consts::TAU * self.document.room.mains_hz;
        let half = 0.5 * turn * window_s;
        let share = if half == 0.0 { 1.0 } else { half.sin() / half };
        slow * (1.0 + flicker * share * (turn * time_s).sin())
    }

    fn true_distance_mm(&self, o: &Observation) -> f64 {
        o.distance_mm + self.document.injected_effects.distance_offset.offset_mm
    }

    /// Response of the meter to one LED's light, relative to a perfect photometer.
    fn response(&self, ray: &Ray, towards_lamp: DVec3) -> f64 {
        let injected_effects = &self.document.injected_effects;
        let directional = optics::directional_response(
            injected_effects.cosine_f2.coefficient_rel,
            ray.incidence_cos(towards_lamp),
        ) * self.head.map_or(1.0, |head| head.shown_of_one_lux(ray.phosphor));
        let mismatch = &injected_effects.spectral_mismatch;
        if mismatch.slope_per_deg == 0.0 {
            return directional * mismatch.factor;
        }
        // The colour of an LED depends on the angle from which its phosphor is seen.
        let seen_deg = ray.direction.z.clamp(-1.0, 1.0).acos().to_degrees();
        directional * mismatch.factor * (1.0 + mismatch.slope_per_deg * seen_deg)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn observation(kind: Kind) -> Observation {
        Observation {
            kind,
            time_s: 3600.0,
            c_deg: 0.0,
            gamma_deg: 0.0,
            distance_mm: 10_000.0,
            travel: 1.0,
            range: 1,
            ambient_c: 25.0,
        }
    }

    #[test]
    fn the_built_in_lamp_gives_3_4_lx_at_ten_metres() {
        let mut document = Darkroom::default();
        document.luxmeter.gain_error_rel = 0.0;
        let room = Room::new(document);
        let illuminated = room.indicated_lx(&observation(Kind::Lit));
        assert!((illuminated - 3.38).abs() < 0.01, "{illuminated}");
        assert!((illuminated * 100.0 / room.intensity_cd(0.0, 0.0) - 1.0).abs() < 5e-5);
    }

    #[test]
    fn whole_periods_of_the_mains_show_no_flicker() {
        let mut document = Darkroom::default();
        document.lamp.flicker_rel = 0.2;
        let room = Room::new(document);
        let steady = Room::new(Darkroom::default());
        let at = |room: &Room, window_s: f64| {
            let o = Observation {
                time_s: 3600.0025,
                ..observation(Kind::Lit)
            };
            room.illuminance_lx(&o, window_s)
        };
        assert!((at(&room, 0.0) / at(&steady, 0.0) - 1.2).abs() < 1e-6);
        assert!((at(&room, 0.1) / at(&steady, 0.1) - 1.0).abs() < 1e-9);
        assert!((at(&room, 0.015) / at(&steady, 0.015) - 1.0).abs() > 0.02);
    }

    #[test]
    fn each_kind_sees_its_part() {
        let mut document = Darkroom::default();
        document.luxmeter.gain_error_rel = 0.0;
        document.injected_effects.ambient_stray.illuminance_lx = 0.02;
        document.injected_effects.dark_offset.offset_lx = 0.005;
        document.injected_effects.floor_reflection.albedo = 0.2;
        let room = Room::new(document);
        assert_eq!(room.indicated_lx(&observation(Kind::Capped)), 0.005);
        assert!((room.indicated_lx(&observation(Kind::LampOff)) - 0.025).abs() < 1e-12);
        let floor = room.floor_lx(&observation(Kind::Baffled));
        assert!(floor > 0.0);
        assert!((room.indicated_lx(&observation(Kind::Baffled)) - 0.025 - floor).abs() < 1e-12);
        let direct = room.direct_lx(&observation(Kind::Lit));
        assert!((room.indicated_lx(&observation(Kind::Lit)) - 0.025 - floor - direct).abs() < 1e-12);
    }

    #[test]
    fn a_wide_aperture_averages_the_lobe() {
        let mut document = Darkroom::default();
        document.injected_effects.detector_aperture.diameter_mm = 200.0;
        let wide = Room::new(document).direct_lx(&Observation {
            distance_mm: 1000.0,
            ..observation(Kind::Lit)
        });
        let point = Room::new(Darkroom::default()).direct_lx(&Observation {
            distance_mm: 1000.0,
            ..observation(Kind::Lit)
        });
        // ⟨(1 + ρ²/d²)^−(n+3)/2⟩ over the disc of radius a: 1 − (n + 3)/4 · (a/d)² to first order.
        let expected = 1.0 - (5.3 + 3.0) / 4.0 * 0.01;
        assert!((wide / point - expected).abs() < 5e-4, "{}", wide / point);
    }

    #[test]
    fn noise_does_not_depend_on_the_order_of_reading() {
        let room = Room::new(Darkroom::default());
        let late = room.reading_lx(&observation(Kind::Lit), 7);
        let _ = room.reading_lx(&observation(Kind::Lit), 8);
        assert_eq!(room.reading_lx(&observation(Kind::Lit), 7), late);
        let mut document = Darkroom::default();
        document.luxmeter.noise_correlation = 0.6;
        let room = Room::new(document);
        let n = 4000;
        let lag: f64 = (1..n)
            .map(|k| room.meter_noise(k) * room.meter_noise(k - 1))
            .sum::<f64>()
            / n as f64;
        assert!((lag - 0.6).abs() < 0.06, "{lag}");
    }
}
