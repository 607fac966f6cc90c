//! Lamp, air, axes and instruments of a room, as its file describes them.

use std::sync::Arc;

use serde::{Deserialize, Serialize};

use crate::table::LampTable;

/// A ring illuminator of individual LEDs, or a lamp by its table of intensities.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Lamp {
    /// File of the table of intensities beside the room's: [`LampTable`]. With it the keys of [`RING_KEYS`] have no
    /// meaning and may not be given.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub table: Option<String>,
    /// Diameter of the disc that shines with that table from every point, mm; 0 is a point. It stands in the plane of
    /// the light centre, across the lamp's axis.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub luminous_diameter_mm: Option<f64>,
    /// What `table` holds.
    #[serde(skip)]
    pub intensities: Option<Arc<LampTable>>,
    /// Luminous flux of the warm lamp, lm; that of the table where there is one.
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
    /// Seed of both spreads; 0: that of the room. With a seed of its own the same lamp stands in rooms of other seeds.
    pub seed: u64,
    /// By how much the phosphor's light grows against the chip's, towards 90° from an LED's axis: times 1 + rise ·
    /// sin²θ + lean · sin θ · cos(C − azimuth), θ from that axis.
    pub phosphor_rise_rel: f64,
    /// What of that has one side: a phosphor that lies thicker towards the azimuth.
    pub phosphor_lean_rel: f64,
    /// C of that side, degrees.
    pub phosphor_lean_azimuth_deg: f64,
    /// Time from switching on to light, and from off to dark, s.
    pub switch_s: f64,
    /// Rated supply voltage, V (RMS).
    pub voltage_v: f64,
    /// Active power of the warm lamp, W.
    pub power_w: f64,
    /// Active power ÷ (voltage · current), above 0 up to 1.
    pub power_factor: f64,
    /// Relative excess of the cold lamp's power over that of its light (`injected_effects.lamp_warmup`).
    pub power_warmup_share: f64,
    /// Modulation of its light at twice the frequency of the mains, relative amplitude.
    pub flicker_rel: f64,
    /// The lamp was already on when the room was opened.
    pub on_at_start: bool,
}

/// Keys of [`Lamp`] that describe rings of LEDs.
pub const RING_KEYS: [&str; 10] = [
    "flux_lm",
    "ring_diameter_mm",
    "leds_per_ring",
    "exponent",
    "aim_deg",
    "ellipticity_rel",
    "ellipticity_azimuth_deg",
    "flux_spread_rel",
    "aim_spread_deg",
    "seed",
];

impl Lamp {
    /// Diameter of what shines, mm.
    pub fn diameter_mm(&self) -> f64 {
        match self.luminous_diameter_mm {
            Some(diameter_mm) => diameter_mm,
            // An LED is a few millimetres wide.
            None => self.ring_diameter_mm.iter().copied().fold(0.0, f64::max) + 5.0,
        }
    }
}

impl Default for Lamp {
    fn default() -> Self {
        Self {
            table: None,
            luminous_diameter_mm: None,
            intensities: None,
            flux_lm: 337.0,
            ring_diameter_mm: vec![44.0, 56.0, 68.0],
            leds_per_ring: vec![20, 20, 20],
            exponent: 5.3,
            aim_deg: 0.0,
            ellipticity_rel: 0.02,
            ellipticity_azimuth_deg: 0.0,
            flux_spread_rel: 0.03,
            aim_spread_deg: 0.2,
            seed: 0,
            phosphor_rise_rel: 0.0,
            phosphor_lean_rel: 0.0,
            phosphor_lean_azimuth_deg: 0.0,
            switch_s: 0.05,
            voltage_v: 24.0,
            power_w: 4.2,
            power_factor: 1.0,
            power_warmup_share: 0.4,
            flicker_rel: 0.0,
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
    /// Drift, K/h, until the room is 5 K away from where it began.
    pub drift_c_per_h: f64,
    /// Amplitude of the air conditioning's cycle, K.
    pub swing_c: f64,
    /// Period of that cycle, s.
    pub swing_period_s: f64,
    /// Noise of the thermometer, K.
    pub thermometer_noise_c: f64,
    /// Frequency of the mains, Hz.
    pub mains_hz: f64,
}

impl Default for Climate {
    fn default() -> Self {
        Self {
            temperature_c: 24.0,
            drift_c_per_h: 0.15,
            swing_c: 0.25,
            swing_period_s: 1500.0,
            thermometer_noise_c: 0.02,
            mains_hz: 50.0,
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
    /// Wobble of its speed: at the fastest speed the position is off by up to this, periodically; less in proportion
    /// when slower, degrees.
    pub wobble_deg: f64,
    /// Way after which the wobble repeats (a turn of the worm), degrees.
    pub wobble_period_deg: f64,
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
            wobble_deg: 0.0,
            wobble_period_deg: 4.0,
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
    /// Time constant of its amplifier, a first-order lag of the light before it is integrated, s.
    pub lag_s: f64,
    /// From a request to the beginning of its measurement (of a meter that converts all the time: to its answer), s.
    pub latency_s: f64,
    /// Standard deviation of that from one measurement to the next, s; never below zero.
    pub latency_jitter_s: f64,
    /// How much slower its clock is than that of the room, parts in a million: integration and conversions last longer.
    pub clock_ppm: f64,
}

impl LuxMeter {
    /// `seconds` by the meter's clock, in those of the room.
    pub fn by_its_clock_s(&self, seconds: f64) -> f64 {
        seconds * (1.0 + self.clock_ppm * 1e-6)
    }
}

impl Default for LuxMeter {
    fn default() -> Self {
        Self {
            integration_s: 0.5,
            gain_error_rel: 0.003,
            noise_rel: 0.0008,
            noise_lx: 0.0008,
            noise_correlation: 0.0,
            lag_s: 0.0,
            latency_s: 0.0,
            latency_jitter_s: 0.0,
            clock_ppm: 0.0,
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

impl Spectroradiometer {
    /// True wavelength at a pixel, or between two, nm.
    pub fn nm_at(&self, pixel: f64) -> f64 {
        self.wavelength_nm.iter().rev().fold(0.0, |sum, c| sum * pixel + c)
    }
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
    /// Wavelength of its largest quantum efficiency, a Gaussian over the wavelength, nm; 0: it sees as V(λ) does.
    /// `full_scale_lx` is of the light along an LED's axis.
    pub qe_peak_nm: f64,
    /// Standard deviation of that Gaussian, nm.
    pub qe_width_nm: f64,
}

impl Default for Camera {
    fn default() -> Self {
        Self {
            qe_peak_nm: 0.0,
            qe_width_nm: 100.0,
            full_scale_lx: 1350.0,
            noise_abs: 1.0e-4,
            noise_rel: 0.0015,
        }
    }
}
