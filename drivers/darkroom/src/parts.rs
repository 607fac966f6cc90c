//! Lamp, air, axes and instruments of a room, as its file describes them.

use std::ops::RangeInclusive;
use std::sync::Arc;

use isolux_document::Fault;
use isolux_document::bounds::within;
use serde::{Deserialize, Serialize};

use crate::table::LampTable;

/// A part of a room: each key with its type, its value in a room without injected effects, and the numbers that it may
/// have.
macro_rules! part {
    ($(#[$doc:meta])* $name:ident {
        $($(#[$key_doc:meta])* $key:ident: $type:ty = $default:expr $(, $range:expr)?;)*
    }) => {
        $(#[$doc])*
        #[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
        #[serde(default, deny_unknown_fields)]
        pub struct $name { $($(#[$key_doc])* pub $key: $type,)* }

        impl Default for $name {
            fn default() -> Self { Self { $($key: $default,)* } }
        }

        impl $name {
            /// Whether every number of the table at `path` is one that a room can have.
            pub(crate) fn check(&self, path: &str) -> Result<(), Fault> {
                $($(within(&format!("{path}.{}", stringify!($key)), self.$key, $range, "")?;)?)*
                Ok(())
            }
        }
    };
}

/// Above zero, and below what makes a product of a few of them infinite.
const POSITIVE: RangeInclusive<f64> = 1e-9..=1e9;

part! {
    /// A ring illuminator of individual LEDs, or a lamp by its table of intensities.
    Lamp {
        /// File of the table of intensities beside the room's: [`LampTable`]. With it the keys of [`RING_KEYS`] have no
        /// meaning and may not be given.
        #[serde(skip_serializing_if = "Option::is_none")]
        table: Option<String> = None;
        /// Diameter of the disc that shines with that table from every point, mm; 0 is a point. It stands in the plane
        /// of the light centre, across the lamp's axis.
        #[serde(skip_serializing_if = "Option::is_none")]
        luminous_diameter_mm: Option<f64> = None, 0.0..=10_000.0;
        /// What `table` holds.
        #[serde(skip)]
        intensities: Option<Arc<LampTable>> = None;
        /// Luminous flux of the warm lamp, lm; that of the table where there is one.
        flux_lm: f64 = 337.0, POSITIVE;
        /// Diameters of the rings of LEDs, mm; 0 is a single point.
        ring_diameter_mm: Vec<f64> = vec![44.0, 56.0, 68.0];
        /// LEDs on each ring.
        leds_per_ring: Vec<u32> = vec![20, 20, 20];
        /// Exponent n of one LED's lobe cosⁿθ.
        exponent: f64 = 5.3, POSITIVE;
        /// Inward aim of every LED, degrees; negative is outward.
        aim_deg: f64 = 0.0, -60.0..=60.0;
        /// Ellipticity of the lenses: the lobe times 1 + ellipticity · sin²θ · cos 2(φ − azimuth).
        ellipticity_rel: f64 = 0.02, -0.9..=0.9;
        /// Azimuth of the wide side, degrees.
        ellipticity_azimuth_deg: f64 = 0.0, -360.0..=360.0;
        /// Standard deviation of the flux from LED to LED, relative.
        flux_spread_rel: f64 = 0.03, 0.0..=0.3;
        /// Standard deviation of the aim from LED to LED, degrees (their mean is zero).
        aim_spread_deg: f64 = 0.2, 0.0..=10.0;
        /// Seed of both spreads; 0: that of the room. With a seed of its own the same lamp stands in rooms of other
        /// seeds.
        seed: u64 = 0;
        /// By how much the phosphor's light grows against the chip's, towards 90° from an LED's axis: times
        /// 1 + rise · sin²θ + lean · sin θ · cos(C − azimuth), θ from that axis.
        phosphor_rise_rel: f64 = 0.0, -0.5..=2.0;
        /// What of that has one side: a phosphor that lies thicker towards the azimuth.
        phosphor_lean_rel: f64 = 0.0, -0.4..=0.4;
        /// C of that side, degrees.
        phosphor_lean_azimuth_deg: f64 = 0.0, -360.0..=360.0;
        /// Temperature of a filament whose spectrum its light has in place of that of LEDs, K; 0: LEDs. The phosphor
        /// has no part in it then.
        temperature_k: f64 = 0.0, 0.0..=4000.0;
        /// The current off its rated value, relative: of a filament the temperature follows.
        current_error_rel: f64 = 0.0, -0.2..=0.2;
        /// Time from switching on to light, and from off to dark, s.
        switch_s: f64 = 0.05, 0.0..=3600.0;
        /// Rated supply voltage, V (RMS).
        voltage_v: f64 = 24.0, POSITIVE;
        /// Active power of the warm lamp, W.
        power_w: f64 = 4.2, POSITIVE;
        /// Active power ÷ (voltage · current), above 0 up to 1.
        power_factor: f64 = 1.0, 0.01..=1.0;
        /// Relative excess of the cold lamp's power over that of its light (`injected_effects.lamp_warmup`).
        power_warmup_share: f64 = 0.4, -2.0..=2.0;
        /// Modulation of its light at twice the frequency of the mains, relative amplitude.
        flicker_rel: f64 = 0.0, 0.0..=1.0;
        /// Frequency at which its light is switched on and off around the same mean, Hz; 0: it is not.
        pwm_hz: f64 = 0.0, 0.0..=1e5;
        /// Share of the time in which it is on then.
        pwm_duty: f64 = 1.0, 0.01..=1.0;
        /// The lamp was already on when the room was opened.
        on_at_start: bool = false;
    }
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

part! {
    /// Temperature of the room over the day.
    Climate {
        /// At the start, °C.
        temperature_c: f64 = 24.0, -20.0..=60.0;
        /// Drift, K/h, until the room is 5 K away from where it began.
        drift_c_per_h: f64 = 0.15, -20.0..=20.0;
        /// Amplitude of the air conditioning's cycle, K.
        swing_c: f64 = 0.25, 0.0..=20.0;
        /// Period of that cycle, s.
        swing_period_s: f64 = 1500.0, POSITIVE;
        /// Noise of the thermometer, K.
        thermometer_noise_c: f64 = 0.02, 0.0..=5.0;
        /// Frequency of the mains, Hz.
        mains_hz: f64 = 50.0, 10.0..=500.0;
    }
}

part! {
    /// The goniophotometer's bench.
    Bench {
        /// From the intersection of the axes to the meter's reference plane when the room is opened, mm.
        distance_mm: f64 = 10_000.0, 50.0..=100_000.0;
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

part! {
    /// One axis of rotation.
    Axis {
        /// Microsteps per degree, "n/d".
        counts_per_deg: Ratio = Ratio { numerator: 12_800, denominator: 3 };
        /// Lowest and highest position, degrees from the home switch's zero.
        limit_deg: [f64; 2] = [-185.0, 365.0];
        /// Fastest speed, degrees per second.
        speed_deg_s: f64 = 20.0, POSITIVE;
        /// Acceleration, degrees per second squared.
        accel_deg_s2: f64 = 40.0, POSITIVE;
        /// Noise of the encoder, degrees.
        encoder_noise_deg: f64 = 0.0, 0.0..=1.0;
        /// Position when the room is opened, degrees.
        start_deg: f64 = 0.0;
        /// Wobble of its speed: at the fastest speed the position is off by up to this, periodically; less in
        /// proportion when slower, degrees.
        wobble_deg: f64 = 0.0, 0.0..=1.0;
        /// Way after which the wobble repeats (a turn of the worm), degrees.
        wobble_period_deg: f64 = 4.0, 0.01..=360.0;
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

part! {
    /// A lux meter of the T-10A's kind.
    LuxMeter {
        /// Time between new values, and of each one's integration, s.
        integration_s: f64 = 0.5, 0.001..=60.0;
        /// Error of its calibration, relative.
        gain_error_rel: f64 = 0.003, -0.5..=0.5;
        /// Noise relative to the reading.
        noise_rel: f64 = 0.0008, 0.0..=0.5;
        /// Noise at no light, lx.
        noise_lx: f64 = 0.0008, 0.0..=1000.0;
        /// Correlation of the noise from one value to the next.
        noise_correlation: f64 = 0.0, 0.0..=0.99;
        /// Time constant of its amplifier, a first-order lag of the light before it is integrated, s.
        lag_s: f64 = 0.0, 0.0..=10.0;
        /// From a request to the beginning of its measurement (of a meter that converts all the time: to its answer),
        /// s.
        latency_s: f64 = 0.0, 0.0..=10.0;
        /// Standard deviation of that from one measurement to the next, s; never below zero.
        latency_jitter_s: f64 = 0.0, 0.0..=1.0;
        /// How much slower its clock is than that of the room, parts in a million: integration and conversions last
        /// longer.
        clock_ppm: f64 = 0.0, -10_000.0..=10_000.0;
        /// Where a clock that runs all the time stands when the room is opened: so long after it the first conversion
        /// begins, s.
        clock_phase_s: f64 = 0.0, 0.0..=60.0;
        /// Its head is V(λ) displaced by so much to longer wavelengths, nm.
        head_shift_nm: f64 = 0.0, -20.0..=20.0;
        /// And leaks light about 440 nm by so much of its largest responsivity.
        head_blue_rel: f64 = 0.0, 0.0..=0.2;
    }
}

impl LuxMeter {
    /// `seconds` by the meter's clock, in those of the room.
    pub fn by_its_clock_s(&self, seconds: f64) -> f64 {
        seconds * (1.0 + self.clock_ppm * 1e-6)
    }
}

part! {
    /// A spectroradiometer of the USB2000+'s kind.
    Spectroradiometer {
        /// From the intersection of the axes to its entrance, on the axis, mm.
        distance_mm: f64 = 500.0, 50.0..=100_000.0;
        /// True wavelength of pixel p: Σ c_k pᵏ, nm.
        wavelength_nm: [f64; 4] = [339.26, 0.379_4, -1.532e-5, -1.91e-9];
        /// Counts per second for 1 W/(m² nm) at the responsivity's peak.
        counts_per_s: f64 = 4.0e6, POSITIVE;
        /// Error of its irradiance calibration, relative.
        gain_error_rel: f64 = 0.004, -0.5..=0.5;
        /// Dark signal, counts per second at 25 °C.
        dark_counts_per_s: f64 = 60.0, 0.0..=1e6;
        /// Electronic offset, counts.
        offset_counts: f64 = 1500.0, 0.0..=60_000.0;
        /// Read noise, counts.
        read_noise_counts: f64 = 18.0, 0.0..=10_000.0;
        /// Electrons per count: shot noise.
        electrons_per_count: f64 = 1.6, POSITIVE;
        /// Loss of responsivity at full scale: counts = linear · (1 − loss · linear / saturation).
        nonlinearity: f64 = 0.04, -0.3..=0.3;
        /// A further loss at full scale, in the same form, of which the polynomial that it stores knows nothing.
        nonlinearity_error: f64 = 0.0, -0.2..=0.2;
        /// By how much the wavelengths that it states are too long: Σ e_k·tᵏ with t = (stated − 550 nm)/300 nm, nm.
        wavelength_error_nm: [f64; 3] = [0.0; 3];
        /// Share of all its counts that its inside scatters evenly over all pixels.
        scatter_rel: f64 = 0.0, 0.0..=0.5;
        /// Illuminance of a mercury-argon lamp close before its entrance, lx; 0: none is there.
        line_lamp_lx: f64 = 0.0, 0.0..=1e6;
        /// Wavelength at which a long-pass filter on its entrance transmits half of the most, nm; 0: none is there.
        filter_cut_on_nm: f64 = 0.0, 0.0..=2000.0;
        /// Counts at which the converter ends.
        saturation_counts: u16 = 65_535;
    }
}

impl Spectroradiometer {
    /// True wavelength at a pixel, or between two, nm.
    pub fn nm_at(&self, pixel: f64) -> f64 {
        self.wavelength_nm.iter().rev().fold(0.0, |sum, c| sum * pixel + c)
    }

    /// True wavelength where it states `stated_nm`, nm.
    pub fn true_nm(&self, stated_nm: f64) -> f64 {
        let t = (stated_nm - 550.0) / 300.0;
        stated_nm - self.wavelength_error_nm.iter().rev().fold(0.0, |sum, e| sum * t + e)
    }

    /// Transmittance of the filter on its entrance: the edge of a coloured glass.
    pub fn filter(&self, wavelength_nm: f64) -> f64 {
        if self.filter_cut_on_nm == 0.0 {
            return 1.0;
        }
        0.91 / (1.0 + ((self.filter_cut_on_nm - wavelength_nm) / 3.0).exp())
    }
}

part! {
    /// A power meter in the supply line of the lamp.
    PowerMeter {
        /// Error of its power, relative; voltage and current have half of it each.
        gain_error_rel: f64 = 0.0008, -0.5..=0.5;
        /// Noise of each quantity, relative to it.
        noise_rel: f64 = 0.0001, 0.0..=0.5;
        /// End of the range of the current, A.
        range_a: f64 = 2.0, POSITIVE;
    }
}

part! {
    /// A camera sensor without a lens.
    Camera {
        /// Illuminance × relative exposure that gives the signal 1 (full scale is 1).
        full_scale_lx: f64 = 1350.0, POSITIVE;
        /// Standard deviation of a bin without light, relative to full scale.
        noise_abs: f64 = 1.0e-4, 1e-9..=1.0;
        /// Standard deviation of a bin relative to its signal.
        noise_rel: f64 = 0.0015, 0.0..=1.0;
        /// Wavelength of its largest quantum efficiency, a Gaussian over the wavelength, nm; 0: it sees as V(λ) does.
        /// `full_scale_lx` is of the light along an LED's axis.
        qe_peak_nm: f64 = 0.0, 0.0..=1500.0;
        /// Standard deviation of that Gaussian, nm.
        qe_width_nm: f64 = 100.0, 1.0..=1e4;
    }
}
