//! `darkroom.toml`: the room, its instruments, their faults and their flaws, in one file.
//!
//! A key that a file leaves out is that of the built-in room. An unknown key, or a value that no room can have, is an
//! error with its line. [`Darkroom::default`] is not the built-in room but one without flaws.

use serde::{Deserialize, Serialize};

use crate::built_in::{self, Completed};
use crate::flaws::Flaws;

/// The format line of the file.
pub const FORMAT: &str = "isolux-darkroom/1";

/// A virtual darkroom as its file describes it; checked by [`Darkroom::parse`].
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Darkroom {
    /// `isolux-darkroom/1`.
    pub format: String,
    /// Seed of every random number in the room.
    pub seed: u64,
    /// The lamp under test.
    pub lamp: Lamp,
    /// The air of the room.
    pub room: Climate,
    /// The goniophotometer.
    pub bench: Bench,
    /// Its axes.
    pub axis: Axes,
    /// The lux meter.
    pub luxmeter: LuxMeter,
    /// The spectroradiometer.
    pub spectroradiometer: Spectroradiometer,
    /// The power meter.
    pub powermeter: PowerMeter,
    /// The camera.
    pub camera: Camera,
    /// What is wrong with the room and its instruments, and is to be found.
    pub flaws: Flaws,
    /// What goes wrong on the links.
    pub fault: Vec<Fault>,
}

impl Default for Darkroom {
    fn default() -> Self {
        Self {
            format: FORMAT.to_owned(),
            seed: 1,
            lamp: Lamp::default(),
            room: Climate::default(),
            bench: Bench::default(),
            axis: Axes::default(),
            luxmeter: LuxMeter::default(),
            spectroradiometer: Spectroradiometer::default(),
            powermeter: PowerMeter::default(),
            camera: Camera::default(),
            flaws: Flaws::default(),
            fault: Vec::new(),
        }
    }
}

/// A ring illuminator of individual LEDs.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Lamp {
    /// Luminous flux of the warm lamp, lm.
    pub flux_lm: f64,
    /// Diameters of the rings of LEDs, mm; 0 is a single point.
    pub ring_diameter_mm: Vec<f64>,
    /// LEDs on each ring.
    pub leds_per_ring: Vec<u32>,
    /// Exponent n of one LED's lobe cosⁿθ.
    pub exponent: f64,
    /// Inward aim of every LED, degrees; negative is outward.
    pub aim_deg: f64,
    /// Ellipticity of the lenses: the lobe times 1 + ellipticity · sin²θ · cos 2(φ − azimuth).
    pub ellipticity_rel: f64,
    /// Azimuth of the wide side, degrees.
    pub ellipticity_azimuth_deg: f64,
    /// Standard deviation of the flux from LED to LED, relative.
    pub flux_spread_rel: f64,
    /// Standard deviation of the aim from LED to LED, degrees (their mean is zero).
    pub aim_spread_deg: f64,
    /// Time from switching on to light, and from off to dark, s.
    pub switch_s: f64,
    /// Rated supply voltage, V (RMS).
    pub voltage_v: f64,
    /// Active power of the warm lamp, W.
    pub power_w: f64,
    /// Active power ÷ (voltage · current), above 0 up to 1.
    pub power_factor: f64,
    /// Relative excess of the cold lamp's power over that of its light (`flaws.lamp_warmup`).
    pub power_warmup_share: f64,
    /// The lamp was already on when the room was opened.
    pub on_at_start: bool,
}

impl Default for Lamp {
    fn default() -> Self {
        Self {
            flux_lm: 337.0,
            ring_diameter_mm: vec![44.0, 56.0, 68.0],
            leds_per_ring: vec![20, 20, 20],
            exponent: 5.3,
            aim_deg: 0.0,
            ellipticity_rel: 0.02,
            ellipticity_azimuth_deg: 0.0,
            flux_spread_rel: 0.03,
            aim_spread_deg: 0.2,
            switch_s: 0.05,
            voltage_v: 24.0,
            power_w: 4.2,
            power_factor: 1.0,
            power_warmup_share: 0.4,
            on_at_start: false,
        }
    }
}

/// Temperature of the room over the day.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Climate {
    /// At the start, °C.
    pub temperature_c: f64,
    /// Drift, K/h.
    pub drift_c_per_h: f64,
    /// Amplitude of the air conditioning's cycle, K.
    pub swing_c: f64,
    /// Period of that cycle, s.
    pub swing_period_s: f64,
    /// Noise of the thermometer, K.
    pub thermometer_noise_c: f64,
}

impl Default for Climate {
    fn default() -> Self {
        Self {
            temperature_c: 24.0,
            drift_c_per_h: 0.15,
            swing_c: 0.25,
            swing_period_s: 1500.0,
            thermometer_noise_c: 0.02,
        }
    }
}

/// The goniophotometer's bench.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Bench {
    /// From the intersection of the axes to the meter's reference plane when the room is opened, mm.
    pub distance_mm: f64,
}

impl Default for Bench {
    fn default() -> Self {
        Self { distance_mm: 10_000.0 }
    }
}

/// The two axes of rotation and the rail of the detector.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Axes {
    /// The C axis.
    pub c: Axis,
    /// The γ axis.
    pub gamma: Axis,
}

/// One axis of rotation.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Axis {
    /// Microsteps per degree, "n/d".
    pub counts_per_deg: Ratio,
    /// Lowest and highest position, degrees from the home switch's zero.
    pub limit_deg: [f64; 2],
    /// Fastest speed, degrees per second.
    pub speed_deg_s: f64,
    /// Acceleration, degrees per second squared.
    pub accel_deg_s2: f64,
    /// Noise of the encoder, degrees.
    pub encoder_noise_deg: f64,
    /// Position when the room is opened, degrees.
    pub start_deg: f64,
}

impl Default for Axis {
    fn default() -> Self {
        Self {
            counts_per_deg: Ratio {
                numerator: 12_800,
                denominator: 3,
            },
            limit_deg: [-185.0, 365.0],
            speed_deg_s: 20.0,
            accel_deg_s2: 40.0,
            encoder_noise_deg: 0.0,
            start_deg: 0.0,
        }
    }
}

/// An exact ratio, written "n/d" or "n".
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(try_from = "String", into = "String")]
pub struct Ratio {
    /// Numerator, positive.
    pub numerator: i64,
    /// Denominator, positive.
    pub denominator: i64,
}

impl TryFrom<String> for Ratio {
    type Error = String;

    fn try_from(text: String) -> Result<Self, String> {
        let (n, d) = text.split_once('/').unwrap_or((text.as_str(), "1"));
        match (n.trim().parse::<i64>(), d.trim().parse::<i64>()) {
            (Ok(numerator @ 1..), Ok(denominator @ 1..)) => Ok(Self { numerator, denominator }),
            _ => Err(format!(
                "`{text}` is not a ratio of two positive whole numbers such as \"12800/3\""
            )),
        }
    }
}

impl From<Ratio> for String {
    fn from(ratio: Ratio) -> Self {
        format!("{}/{}", ratio.numerator, ratio.denominator)
    }
}

impl Ratio {
    /// As a number.
    pub fn value(self) -> f64 {
        self.numerator as f64 / self.denominator as f64
    }
}

/// A lux meter of the T-10A's kind.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct LuxMeter {
    /// Time between new values, and of each one's integration, s.
    pub integration_s: f64,
    /// Error of its calibration, relative.
    pub gain_error_rel: f64,
    /// Noise relative to the reading.
    pub noise_rel: f64,
    /// Noise at no light, lx.
    pub noise_lx: f64,
    /// Correlation of the noise from one value to the next.
    pub noise_correlation: f64,
}

impl Default for LuxMeter {
    fn default() -> Self {
        Self {
            integration_s: 0.5,
            gain_error_rel: 0.003,
            noise_rel: 0.0008,
            noise_lx: 0.0008,
            noise_correlation: 0.0,
        }
    }
}

/// A spectroradiometer of the USB2000+'s kind.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Spectroradiometer {
    /// From the intersection of the axes to its entrance, on the axis, mm.
    pub distance_mm: f64,
    /// True wavelength of pixel p: Σ c_k pᵏ, nm.
    pub wavelength_nm: [f64; 4],
    /// Counts per second for 1 W/(m² nm) at the responsivity's peak.
    pub counts_per_s: f64,
    /// Error of its irradiance calibration, relative.
    pub gain_error_rel: f64,
    /// Dark signal, counts per second at 25 °C.
    pub dark_counts_per_s: f64,
    /// Electronic offset, counts.
    pub offset_counts: f64,
    /// Read noise, counts.
    pub read_noise_counts: f64,
    /// Electrons per count: shot noise.
    pub electrons_per_count: f64,
    /// Loss of responsivity at full scale: counts = linear · (1 − loss · linear / saturation).
    pub nonlinearity: f64,
    /// Counts at which the converter ends.
    pub saturation_counts: u16,
}

impl Default for Spectroradiometer {
    fn default() -> Self {
        Self {
            distance_mm: 500.0,
            wavelength_nm: [339.26, 0.379_4, -1.532e-5, -1.91e-9],
            counts_per_s: 4.0e6,
            gain_error_rel: 0.004,
            dark_counts_per_s: 60.0,
            offset_counts: 1500.0,
            read_noise_counts: 18.0,
            electrons_per_count: 1.6,
            nonlinearity: 0.04,
            saturation_counts: 65_535,
        }
    }
}

/// A power meter in the supply line of the lamp.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct PowerMeter {
    /// Error of its power, relative; voltage and current have half of it each.
    pub gain_error_rel: f64,
    /// Noise of each quantity, relative to it.
    pub noise_rel: f64,
    /// End of the range of the current, A.
    pub range_a: f64,
}

impl Default for PowerMeter {
    fn default() -> Self {
        Self {
            gain_error_rel: 0.0008,
            noise_rel: 0.0001,
            range_a: 2.0,
        }
    }
}

/// A camera sensor without a lens.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Camera {
    /// Illuminance × relative exposure that gives the signal 1 (full scale is 1).
    pub full_scale_lx: f64,
    /// Standard deviation of a bin without light, relative to full scale.
    pub noise_abs: f64,
    /// Standard deviation of a bin relative to its signal.
    pub noise_rel: f64,
}

impl Default for Camera {
    fn default() -> Self {
        Self {
            full_scale_lx: 1350.0,
            noise_abs: 1.0e-4,
            noise_rel: 0.0015,
        }
    }
}

/// One thing that goes wrong on a link.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Fault {
    /// The instrument that it happens to.
    pub instrument: Instrument,
    /// What happens.
    pub kind: FaultKind,
    /// From when, s after the room was opened.
    #[serde(default)]
    pub at_s: f64,
    /// For how long, s; left out: once (`disconnect`, `stall`: for good).
    pub for_s: Option<f64>,
    /// Delay of a late reply, s.
    #[serde(default)]
    pub delay_s: f64,
    /// Probability for each reply inside the window.
    #[serde(default = "one")]
    pub probability: f64,
}

fn one() -> f64 {
    1.0
}

/// An instrument of the room.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Instrument {
    /// The axes and the switches on their controller.
    Axes,
    /// The lux meter.
    Luxmeter,
    /// The spectroradiometer.
    Spectroradiometer,
    /// A second controller, for lamp, shutter, baffle, rail and thermometer, where that of the axes has none of them.
    Outputs,
    /// The power meter in the lamp's supply line.
    Powermeter,
    /// The supply that feeds the lamp and switches it.
    Supply,
}

impl Instrument {
    /// All of them.
    pub const ALL: [Self; 6] = [
        Self::Axes,
        Self::Luxmeter,
        Self::Spectroradiometer,
        Self::Outputs,
        Self::Powermeter,
        Self::Supply,
    ];

    /// Its name, as a darkroom's document writes it.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Axes => "axes",
            Self::Luxmeter => "luxmeter",
            Self::Spectroradiometer => "spectroradiometer",
            Self::Outputs => "outputs",
            Self::Powermeter => "powermeter",
            Self::Supply => "supply",
        }
    }
}

/// What a link can do to a reply.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum FaultKind {
    /// One byte of the reply is lost.
    DropByte,
    /// One bit of the reply is turned.
    FlipBit,
    /// The reply comes after `delay_s`.
    Late,
    /// The reply never comes.
    Silent,
    /// The link ends.
    Disconnect,
    /// The axis stops short and reports a stall.
    Stall,
    /// The axes' drives stop with an alarm of their own, at once.
    Alarm,
    /// More light falls on the meter than any range can show.
    Saturate,
}

/// A `darkroom.toml` that cannot be used.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[error("{}{message}", .line.map_or(String::new(), |line| format!("line {line}: ")))]
pub struct DarkroomError {
    /// One-based line.
    pub line: Option<usize>,
    /// What is wrong and what would be right.
    pub message: String,
}

impl Darkroom {
    /// Reads a `darkroom.toml`; keys that it leaves out are those of the built-in room.
    ///
    /// # Errors
    /// Not TOML, an unknown key, a wrong type, or a value that no room can have.
    pub fn parse(text: &str) -> Result<Self, DarkroomError> {
        Self::complete(text).map(|(room, _)| room)
    }

    /// As [`parse`](Self::parse), and which keys were completed.
    ///
    /// # Errors
    /// As [`parse`](Self::parse).
    pub fn complete(text: &str) -> Result<(Self, Completed), DarkroomError> {
        let in_text = |error: toml::de::Error| DarkroomError {
            line: error.span().map(|span| line_at(text, span.start)),
            message: error.message().to_owned(),
        };
        // What the file itself says is judged with its lines, before it is completed.
        let _: Self = toml::from_str(text).map_err(in_text)?;
        let (whole, completed) = built_in::complete(&text.parse().map_err(in_text)?)?;
        let mut room: Self = whole.try_into().map_err(in_text)?;
        room.flaws.only = false;
        room.check().map_err(|(key, rule)| DarkroomError {
            line: line_of_key(text, &key),
            message: format!("`{key}` {rule}"),
        })?;
        Ok((room, completed))
    }

    /// The first value that no room can have, as (dotted key, rule).
    fn check(&self) -> Result<(), (String, String)> {
        let mut rules = Rules::default();
        rules.require("format", self.format == FORMAT, &format!("must be \"{FORMAT}\""));
        let lamp = &self.lamp;
        rules.positive("lamp.flux_lm", lamp.flux_lm);
        rules.positive("lamp.exponent", lamp.exponent);
        rules.within("lamp.aim_deg", lamp.aim_deg, -60.0, 60.0);
        rules.within("lamp.ellipticity_rel", lamp.ellipticity_rel, -0.9, 0.9);
        rules.within(
            "lamp.ellipticity_azimuth_deg",
            lamp.ellipticity_azimuth_deg,
            -360.0,
            360.0,
        );
        rules.within("lamp.flux_spread_rel", lamp.flux_spread_rel, 0.0, 0.3);
        rules.within("lamp.aim_spread_deg", lamp.aim_spread_deg, 0.0, 10.0);
        rules.within("lamp.switch_s", lamp.switch_s, 0.0, 3600.0);
        rules.require(
            "lamp.ring_diameter_mm",
            (1..=100).contains(&lamp.ring_diameter_mm.len()),
            "needs between 1 and 100 rings",
        );
        for diameter in &lamp.ring_diameter_mm {
            rules.within("lamp.ring_diameter_mm", *diameter, 0.0, 1000.0);
        }
        rules.require(
            "lamp.leds_per_ring",
            lamp.leds_per_ring.len() == lamp.ring_diameter_mm.len(),
            "needs one number for each ring of `ring_diameter_mm`",
        );
        rules.require(
            "lamp.leds_per_ring",
            lamp.leds_per_ring.iter().all(|n| (1..=1000).contains(n)),
            "must lie between 1 and 1000 on each ring",
        );
        rules.positive("lamp.voltage_v", lamp.voltage_v);
        rules.positive("lamp.power_w", lamp.power_w);
        rules.within("lamp.power_factor", lamp.power_factor, 0.01, 1.0);
        rules.within("lamp.power_warmup_share", lamp.power_warmup_share, -2.0, 2.0);
        rules.within("room.temperature_c", self.room.temperature_c, -20.0, 60.0);
        rules.within("room.drift_c_per_h", self.room.drift_c_per_h, -20.0, 20.0);
        rules.within("room.swing_c", self.room.swing_c, 0.0, 20.0);
        rules.positive("room.swing_period_s", self.room.swing_period_s);
        rules.within("room.thermometer_noise_c", self.room.thermometer_noise_c, 0.0, 5.0);
        rules.within("bench.distance_mm", self.bench.distance_mm, 50.0, 100_000.0);
        for (name, axis) in [("c", &self.axis.c), ("gamma", &self.axis.gamma)] {
            let key = |k: &str| format!("axis.{name}.{k}");
            rules.positive(&key("speed_deg_s"), axis.speed_deg_s);
            rules.positive(&key("accel_deg_s2"), axis.accel_deg_s2);
            rules.within(&key("encoder_noise_deg"), axis.encoder_noise_deg, 0.0, 1.0);
            let [low, high] = axis.limit_deg;
            rules.require(
                &key("limit_deg"),
                -3600.0 <= low && low < high && high <= 3600.0,
                "must be [lower, higher], both within -3600 and 3600",
            );
            rules.within(&key("start_deg"), axis.start_deg, low, high);
        }
        let lux = &self.luxmeter;
        rules.within("luxmeter.integration_s", lux.integration_s, 0.001, 60.0);
        rules.within("luxmeter.gain_error_rel", lux.gain_error_rel, -0.5, 0.5);
        rules.within("luxmeter.noise_rel", lux.noise_rel, 0.0, 0.5);
        rules.within("luxmeter.noise_lx", lux.noise_lx, 0.0, 1000.0);
        rules.within("luxmeter.noise_correlation", lux.noise_correlation, 0.0, 0.99);
        let spectro = &self.spectroradiometer;
        rules.within("spectroradiometer.distance_mm", spectro.distance_mm, 50.0, 100_000.0);
        rules.positive("spectroradiometer.counts_per_s", spectro.counts_per_s);
        rules.within("spectroradiometer.gain_error_rel", spectro.gain_error_rel, -0.5, 0.5);
        rules.within(
            "spectroradiometer.dark_counts_per_s",
            spectro.dark_counts_per_s,
            0.0,
            1e6,
        );
        rules.within("spectroradiometer.offset_counts", spectro.offset_counts, 0.0, 60_000.0);
        rules.within(
            "spectroradiometer.read_noise_counts",
            spectro.read_noise_counts,
            0.0,
            10_000.0,
        );
        rules.positive("spectroradiometer.electrons_per_count", spectro.electrons_per_count);
        rules.within("spectroradiometer.nonlinearity", spectro.nonlinearity, -0.3, 0.3);
        let rising = (0..2048).map(|p| crate::spectrograph::wavelength_nm(spectro.wavelength_nm, p as f64));
        rules.require(
            "spectroradiometer.wavelength_nm",
            rising.clone().zip(rising.skip(1)).all(|(a, b)| a < b),
            "must rise from pixel 0 to pixel 2047",
        );
        let power = &self.powermeter;
        rules.within("powermeter.gain_error_rel", power.gain_error_rel, -0.5, 0.5);
        rules.within("powermeter.noise_rel", power.noise_rel, 0.0, 0.5);
        rules.positive("powermeter.range_a", power.range_a);
        rules.positive("camera.full_scale_lx", self.camera.full_scale_lx);
        rules.within("camera.noise_abs", self.camera.noise_abs, 1e-9, 1.0);
        rules.within("camera.noise_rel", self.camera.noise_rel, 0.0, 1.0);
        for (flaw, key, value) in self.flaws.values() {
            let most = match key {
                _ if key.ends_with("_deg") && !key.ends_with("_per_deg") => 360.0,
                _ if key.ends_with("_mm") => 1e5,
                _ if key.ends_with("_nm") => 1e4,
                _ => 1e6,
            };
            rules.within(&format!("flaws.{flaw}.{key}"), value, -most, most);
        }
        let flaws = &self.flaws;
        rules.within("flaws.floor_reflection.albedo", flaws.floor_reflection.albedo, 0.0, 1.0);
        rules.positive("flaws.floor_reflection.height_mm", flaws.floor_reflection.height_mm);
        rules.positive("flaws.lamp_warmup.time_constant_s", flaws.lamp_warmup.time_constant_s);
        rules.within(
            "flaws.lamp_warmup.second_share",
            flaws.lamp_warmup.second_share,
            0.0,
            1.0,
        );
        rules.within(
            "flaws.lamp_warmup.amplitude_rel",
            flaws.lamp_warmup.amplitude_rel,
            -0.9,
            5.0,
        );
        rules.positive("flaws.flicker_alias.period_s", flaws.flicker_alias.period_s);
        rules.positive("flaws.dead_sector.width_deg", flaws.dead_sector.width_deg);
        rules.within("flaws.dead_sector.depth_rel", flaws.dead_sector.depth_rel, -1.0, 1.0);
        rules.positive("flaws.self_absorption.width_deg", flaws.self_absorption.width_deg);
        rules.within(
            "flaws.self_absorption.gamma_deg",
            flaws.self_absorption.gamma_deg,
            0.0,
            89.0,
        );
        rules.positive("flaws.ler_scale.factor", flaws.ler_scale.factor);
        rules.within("flaws.cover_glass.index", flaws.cover_glass.index, 1.0, 4.0);
        rules.within("flaws.cover_glass.plates", flaws.cover_glass.plates, 0.0, 100.0);
        rules.within(
            "flaws.vignetting.coefficient_rel",
            flaws.vignetting.coefficient_rel,
            -0.9,
            0.9,
        );
        rules.positive("flaws.flicker_banding.period_mm", flaws.flicker_banding.period_mm);
        rules.positive("flaws.ghost.width_mm", flaws.ghost.width_mm);
        for fault in &self.fault {
            rules.within("fault.at_s", fault.at_s, 0.0, 1e7);
            rules.within("fault.delay_s", fault.delay_s, 0.0, 1e5);
            rules.within("fault.for_s", fault.for_s.unwrap_or(0.0), 0.0, 1e7);
            rules.within("fault.probability", fault.probability, 0.0, 1.0);
            let (fits, who) = match (fault.kind, fault.instrument) {
                (FaultKind::Alarm | FaultKind::Stall, instrument) => {
                    (matches!(instrument, Instrument::Axes | Instrument::Outputs), "axes")
                }
                (FaultKind::Saturate, instrument) => (
                    matches!(instrument, Instrument::Luxmeter | Instrument::Spectroradiometer),
                    "luxmeter or spectroradiometer",
                ),
                _ => (true, ""),
            };
            let rule = format!("is no fault of the {}: it is one of {who}", fault.instrument.name());
            rules.require("fault.kind", fits, &rule);
        }
        rules.first.map_or(Ok(()), Err)
    }
}

/// Collects the first rule that is broken.
#[derive(Default)]
struct Rules {
    first: Option<(String, String)>,
}

impl Rules {
    fn require(&mut self, key: &str, holds: bool, rule: &str) {
        if !holds && self.first.is_none() {
            self.first = Some((key.to_owned(), rule.to_owned()));
        }
    }

    /// Above zero, and below what makes a product of a few of them infinite.
    fn positive(&mut self, key: &str, value: f64) {
        self.within(key, value, 1e-9, 1e9);
    }

    fn within(&mut self, key: &str, value: f64, low: f64, high: f64) {
        let rule = format!("is {value}; it must lie between {low} and {high}");
        self.require(key, (low..=high).contains(&value), &rule);
    }
}

fn line_at(text: &str, offset: usize) -> usize {
    text.get(..offset).unwrap_or(text).matches('\n').count() + 1
}

/// Line of a dotted key, or of the deepest table on the way to it.
fn line_of_key(text: &str, key: &str) -> Option<usize> {
    let root = toml::de::DeTable::parse(text).ok()?;
    let mut table = root.get_ref();
    let mut line = None;
    for part in key.split('.') {
        let Some((name, value)) = table.iter().find(|(name, _)| name.get_ref().as_ref() == part) else {
            break;
        };
        line = Some(line_at(text, name.span().start));
        match value.get_ref() {
            toml::de::DeValue::Table(inner) => table = inner,
            _ => break,
        }
    }
    line
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_empty_file_is_the_built_in_room() {
        assert_eq!(Darkroom::parse("").unwrap(), Darkroom::built_in().unwrap());
    }

    #[test]
    fn an_unknown_key_is_named_with_its_line() {
        let error = Darkroom::parse("seed = 2\n[lamp]\nflux = 3\n").unwrap_err();
        assert_eq!(error.line, Some(3));
        assert!(error.message.contains("flux"), "{}", error.message);
        let error = Darkroom::parse("[flaws.gamma_zero]\noffset = 0.2\n").unwrap_err();
        assert_eq!(error.line, Some(2));
    }

    #[test]
    fn an_impossible_value_is_named_with_its_line() {
        let error = Darkroom::parse("seed = 2\n[lamp]\n\nflux_lm = -3.0\n").unwrap_err();
        assert_eq!(error.line, Some(4));
        assert!(error.to_string().contains("lamp.flux_lm"), "{error}");
        let error = Darkroom::parse("[flaws]\n\ngamma_zero = { offset_deg = nan }\n").unwrap_err();
        assert_eq!(error.line, Some(3));
        assert!(Darkroom::parse("[axis.c]\ncounts_per_deg = \"12800/0\"\n").is_err());
    }

    #[test]
    fn no_number_passes_that_no_room_can_have() {
        let lines: Vec<&str> = crate::BUILT_IN.lines().collect();
        let mut tried = 0;
        for (index, line) in lines.iter().enumerate() {
            let Some((key, value)) = line.split_once('=') else {
                continue;
            };
            let value = value.split('#').next().unwrap_or("").trim();
            let number = value
                .trim_start_matches('[')
                .starts_with(|c: char| c.is_ascii_digit() || c == '-');
            if line.starts_with('#') || !number || key.trim() == "seed" {
                continue;
            }
            let parts: Vec<&str> = value.trim_matches(['[', ']']).split(", ").collect();
            for place in 0..parts.len() {
                for absurd in ["nan", "inf", "1e308", "-1e308"] {
                    let mut parts = parts.clone();
                    parts[place] = absurd;
                    let parts = parts.join(", ");
                    let changed = if value.starts_with('[') {
                        format!("[{parts}]")
                    } else {
                        parts
                    };
                    let mut text = lines.clone();
                    let changed = format!("{key} = {changed}");
                    text[index] = &changed;
                    let error = Darkroom::parse(&text.join("\n")).expect_err(&format!("line {}: {changed}", index + 1));
                    assert_eq!(error.line, Some(index + 1), "{changed}: {error}");
                    tried += 1;
                }
            }
        }
        assert!(tried > 4 * 120, "{tried}");
    }

    #[test]
    fn flaws_and_faults_are_read() {
        let room = Darkroom::parse(
            "[flaws]\ndark_offset = { offset_lx = 0.02 }\n[[fault]]\ninstrument = \"luxmeter\"\nkind = \"late\"\nat_s = 3.0\ndelay_s = 1.5\n",
        )
        .unwrap();
        assert_eq!(room.flaws.dark_offset.offset_lx, 0.02);
        assert_eq!(room.fault[0].kind, FaultKind::Late);
        assert_eq!(room.fault[0].probability, 1.0);
    }
}
