//! Values that no room can have, part by part.

use isolux_document as document;

use crate::fault::{Fault, FaultKind, Instrument};
use crate::injected_effects::InjectedEffects;
use crate::parts::{Axis, Camera, Climate, Lamp, LuxMeter, PowerMeter, Spectroradiometer};

/// Collects the first rule that is broken.
#[derive(Default)]
pub(crate) struct Rules {
    pub first: Option<document::Fault>,
}

impl Rules {
    pub fn require(&mut self, key: &str, holds: bool, rule: &str) {
        if !holds && self.first.is_none() {
            self.first = Some(document::Fault::new(key, rule));
        }
    }

    /// Above zero, and below what makes a product of a few of them infinite.
    pub fn positive(&mut self, key: &str, value: f64) {
        self.within(key, value, 1e-9, 1e9);
    }

    pub fn within(&mut self, key: &str, value: f64, low: f64, high: f64) {
        let rule = format!("is {value}; it must lie between {low} and {high}");
        self.require(key, (low..=high).contains(&value), &rule);
    }
}

pub(crate) fn lamp(rules: &mut Rules, lamp: &Lamp) {
    if let Some(diameter_mm) = lamp.luminous_diameter_mm {
        rules.within("lamp.luminous_diameter_mm", diameter_mm, 0.0, 10_000.0);
    }
    rules.require(
        "lamp.luminous_diameter_mm",
        lamp.luminous_diameter_mm.is_none() || lamp.table.is_some(),
        "belongs to a lamp with a `table`; rings of LEDs have `ring_diameter_mm`",
    );
    rules.require(
        "lamp.table",
        lamp.table.is_none() || lamp.luminous_diameter_mm.is_some(),
        "needs `luminous_diameter_mm`, the diameter of what shines; 0 is a point",
    );
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
    rules.within("lamp.phosphor_rise_rel", lamp.phosphor_rise_rel, -0.5, 2.0);
    rules.within("lamp.phosphor_lean_rel", lamp.phosphor_lean_rel, -0.4, 0.4);
    rules.within(
        "lamp.phosphor_lean_azimuth_deg",
        lamp.phosphor_lean_azimuth_deg,
        -360.0,
        360.0,
    );
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
    rules.within("lamp.flicker_rel", lamp.flicker_rel, 0.0, 1.0);
    rules.positive("lamp.voltage_v", lamp.voltage_v);
    rules.positive("lamp.power_w", lamp.power_w);
    rules.within("lamp.power_factor", lamp.power_factor, 0.01, 1.0);
    rules.within("lamp.power_warmup_share", lamp.power_warmup_share, -2.0, 2.0);
}

pub(crate) fn climate(rules: &mut Rules, climate: &Climate) {
    rules.within("room.temperature_c", climate.temperature_c, -20.0, 60.0);
    rules.within("room.drift_c_per_h", climate.drift_c_per_h, -20.0, 20.0);
    rules.within("room.swing_c", climate.swing_c, 0.0, 20.0);
    rules.positive("room.swing_period_s", climate.swing_period_s);
    rules.within("room.thermometer_noise_c", climate.thermometer_noise_c, 0.0, 5.0);
    rules.within("room.mains_hz", climate.mains_hz, 10.0, 500.0);
}

pub(crate) fn axis(rules: &mut Rules, name: &str, axis: &Axis) {
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
    rules.within(&key("wobble_deg"), axis.wobble_deg, 0.0, 1.0);
    rules.within(&key("wobble_period_deg"), axis.wobble_period_deg, 0.01, 360.0);
}

pub(crate) fn luxmeter(rules: &mut Rules, meter: &LuxMeter) {
    rules.within("luxmeter.integration_s", meter.integration_s, 0.001, 60.0);
    rules.within("luxmeter.gain_error_rel", meter.gain_error_rel, -0.5, 0.5);
    rules.within("luxmeter.noise_rel", meter.noise_rel, 0.0, 0.5);
    rules.within("luxmeter.noise_lx", meter.noise_lx, 0.0, 1000.0);
    rules.within("luxmeter.noise_correlation", meter.noise_correlation, 0.0, 0.99);
    rules.within("luxmeter.lag_s", meter.lag_s, 0.0, 10.0);
    rules.within("luxmeter.latency_s", meter.latency_s, 0.0, 10.0);
    rules.within("luxmeter.latency_jitter_s", meter.latency_jitter_s, 0.0, 1.0);
    rules.within("luxmeter.clock_ppm", meter.clock_ppm, -10_000.0, 10_000.0);
}

pub(crate) fn spectroradiometer(rules: &mut Rules, spectro: &Spectroradiometer) {
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
    let rising = (0..2048).map(|pixel| spectro.nm_at(f64::from(pixel)));
    rules.require(
        "spectroradiometer.wavelength_nm",
        rising.clone().zip(rising.skip(1)).all(|(a, b)| a < b),
        "must rise from pixel 0 to pixel 2047",
    );
}

pub(crate) fn powermeter(rules: &mut Rules, power: &PowerMeter) {
    rules.within("powermeter.gain_error_rel", power.gain_error_rel, -0.5, 0.5);
    rules.within("powermeter.noise_rel", power.noise_rel, 0.0, 0.5);
    rules.positive("powermeter.range_a", power.range_a);
}

pub(crate) fn camera(rules: &mut Rules, camera: &Camera) {
    rules.positive("camera.full_scale_lx", camera.full_scale_lx);
    rules.within("camera.noise_abs", camera.noise_abs, 1e-9, 1.0);
    rules.within("camera.noise_rel", camera.noise_rel, 0.0, 1.0);
    rules.within("camera.qe_peak_nm", camera.qe_peak_nm, 0.0, 1500.0);
    rules.within("camera.qe_width_nm", camera.qe_width_nm, 1.0, 1e4);
}

pub(crate) fn injected_effects(rules: &mut Rules, injected_effects: &InjectedEffects) {
    for (effect, key, value) in injected_effects.values() {
        let most = match key {
            _ if key.ends_with("_deg") && !key.ends_with("_per_deg") => 360.0,
            _ if key.ends_with("_mm") => 1e5,
            _ if key.ends_with("_nm") => 1e4,
            _ => 1e6,
        };
        rules.within(&format!("injected_effects.{effect}.{key}"), value, -most, most);
    }
    rules.within(
        "injected_effects.floor_reflection.albedo",
        injected_effects.floor_reflection.albedo,
        0.0,
        1.0,
    );
    rules.positive(
        "injected_effects.floor_reflection.height_mm",
        injected_effects.floor_reflection.height_mm,
    );
    rules.positive(
        "injected_effects.lamp_warmup.time_constant_s",
        injected_effects.lamp_warmup.time_constant_s,
    );
    rules.within(
        "injected_effects.lamp_warmup.second_share",
        injected_effects.lamp_warmup.second_share,
        0.0,
        1.0,
    );
    rules.within(
        "injected_effects.lamp_warmup.amplitude_rel",
        injected_effects.lamp_warmup.amplitude_rel,
        -0.9,
        5.0,
    );
    rules.positive(
        "injected_effects.flicker_alias.period_s",
        injected_effects.flicker_alias.period_s,
    );
    rules.positive(
        "injected_effects.dead_sector.width_deg",
        injected_effects.dead_sector.width_deg,
    );
    rules.within(
        "injected_effects.dead_sector.depth_rel",
        injected_effects.dead_sector.depth_rel,
        -1.0,
        1.0,
    );
    rules.positive(
        "injected_effects.self_absorption.width_deg",
        injected_effects.self_absorption.width_deg,
    );
    rules.within(
        "injected_effects.self_absorption.gamma_deg",
        injected_effects.self_absorption.gamma_deg,
        0.0,
        89.0,
    );
    rules.positive("injected_effects.ler_scale.factor", injected_effects.ler_scale.factor);
    rules.within(
        "injected_effects.cover_glass.index",
        injected_effects.cover_glass.index,
        1.0,
        4.0,
    );
    rules.within(
        "injected_effects.cover_glass.plates",
        injected_effects.cover_glass.plates,
        0.0,
        100.0,
    );
    rules.within(
        "injected_effects.vignetting.coefficient_rel",
        injected_effects.vignetting.coefficient_rel,
        -0.9,
        0.9,
    );
    rules.positive(
        "injected_effects.flicker_banding.period_mm",
        injected_effects.flicker_banding.period_mm,
    );
    rules.positive("injected_effects.ghost.width_mm", injected_effects.ghost.width_mm);
}

pub(crate) fn fault(rules: &mut Rules, fault: &Fault) {
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
