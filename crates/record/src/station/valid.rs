//! What a station may say: every number in the range that a bench can have, before anything is opened.
//!
//! The ranges are wide. They are no advice but a net: what lies outside was typed wrong, and would move, wait or
//! multiply by what nobody meant.

use std::ops::RangeInclusive;

use super::document::{Axis, Bench, Lamp, Rail, Spectroradiometer, StationDocument, Supply};
use super::parts::{FRACTION, MOST_U_REL, driver_and_target};
use super::traceability;
use crate::document::Fault;
use crate::document::bounds::{above, within};

/// Distances between the axes' crossing and a detector, in mm.
const DISTANCE_MM: RangeInclusive<f64> = 1.0..=1e6;

/// What a bound of stray light is a fraction of.
const STRAY: &str = " (a fraction of the direct light)";

/// Checks a whole station.
pub(super) fn check(station: &StationDocument) -> Result<(), Fault> {
    check_bench(&station.bench)?;
    for (name, axis) in [("axis.c", &station.axis.c), ("axis.gamma", &station.axis.gamma)] {
        check_axis(name, axis)?;
    }
    station.luxmeter.check()?;
    for (part, known) in traceability::stated(station) {
        known.map_or(Ok(()), |known| known.check(part))?;
    }
    if let Some(spectro) = &station.spectroradiometer {
        check_spectroradiometer(spectro)?;
    }
    if let Some(meter) = &station.powermeter {
        driver_and_target("powermeter.open", &meter.open)?;
        for (key, u) in [
            ("powermeter.u_voltage_rel", meter.u_voltage_rel),
            ("powermeter.u_current_rel", meter.u_current_rel),
            ("powermeter.u_power_rel", meter.u_power_rel),
        ] {
            above(key, u, 0.0..=MOST_U_REL, " (a fraction: 0.002 is 0.2 %)")?;
        }
    }
    if let Some(supply) = &station.supply {
        driver_and_target("supply.open", &supply.open)?;
    }
    if let Some(lamp) = &station.lamp {
        check_lamp(lamp, station.supply.as_ref())?;
    }
    for (name, access) in [
        ("shutter", &station.shutter),
        ("baffle", &station.baffle),
        ("ambient", &station.ambient),
    ] {
        if let Some(access) = access {
            one_of(name, access.open.as_deref(), access.prompt.as_deref())?;
        }
    }
    station.rail.as_ref().map_or(Ok(()), check_rail)
}

fn check_bench(bench: &Bench) -> Result<(), Fault> {
    distance("bench", bench.distance_mm, bench.u_distance_mm)?;
    above("bench.u_gamma_deg", bench.u_gamma_deg, 0.0..=5.0, "°")?;
    within("bench.floor_mm", bench.floor_mm, 1.0..=1e5, " mm")?;
    // A bound may be zero: where it is known that there is nothing.
    within("bench.stray_max_rel", bench.stray_max_rel, 0.0..=1.0, STRAY)?;
    within("bench.ambient_max_lx", bench.ambient_max_lx, 0.0..=1e5, " lx")?;
    within("bench.dark_max_lx", bench.dark_max_lx, 0.0..=1e5, " lx")
}

fn check_spectroradiometer(spectro: &Spectroradiometer) -> Result<(), Fault> {
    driver_and_target("spectroradiometer.open", &spectro.open)?;
    distance("spectroradiometer", spectro.distance_mm, spectro.u_distance_mm)?;
    above("spectroradiometer.u_rel", spectro.u_rel, 0.0..=MOST_U_REL, FRACTION)?;
    within(
        "spectroradiometer.u_shape_rel",
        spectro.u_shape_rel,
        0.0..=MOST_U_REL,
        FRACTION,
    )?;
    within(
        "spectroradiometer.u_wavelength_nm",
        spectro.u_wavelength_nm,
        0.0..=50.0,
        " nm",
    )?;
    within(
        "spectroradiometer.stray_max_rel",
        spectro.stray_max_rel,
        0.0..=1.0,
        STRAY,
    )
}

fn check_lamp(lamp: &Lamp, supply: Option<&Supply>) -> Result<(), Fault> {
    match (supply, &lamp.open, &lamp.prompt) {
        (None, open, prompt) => one_of("lamp", open.as_deref(), prompt.as_deref())?,
        (Some(_), None, None) => {}
        (Some(_), open, _) => {
            let key = if open.is_some() { "lamp.open" } else { "lamp.prompt" };
            return Err(Fault::new(
                key,
                "the lamp is switched by its [supply]; remove this key, or that table",
            ));
        }
    }
    within("lamp.diameter_mm", lamp.diameter_mm, 0.01..=1e5, " mm")?;
    above("lamp.flux_lm", lamp.flux_lm, 0.0..=1e9, " lm")?;
    above("lamp.peak_cd", lamp.peak_cd, 0.0..=1e9, " cd")?;
    if let (Some(flux_lm), Some(peak_cd)) = (lamp.flux_lm, lamp.peak_cd) {
        // No intensity is everywhere below the mean over the sphere.
        let mean_cd = flux_lm / (4.0 * std::f64::consts::PI);
        let unit = " cd, as the mean over the sphere is";
        above("lamp.peak_cd", peak_cd, mean_cd..=1e9, unit)?;
    }
    if let Some(stable) = &lamp.stable {
        within("lamp.stable.least_s", stable.least_s, 0.1..=86_400.0, " s")?;
        within("lamp.stable.window_s", stable.window_s, 0.1..=86_400.0, " s")?;
        let unit = " (a fraction: 0.005 is 0.5 %)";
        above("lamp.stable.spread_rel", stable.spread_rel, 0.0..=0.5, unit)?;
    }
    Ok(())
}

/// A distance, and an uncertainty that is smaller than it.
fn distance(table: &str, distance_mm: f64, u_distance_mm: Option<f64>) -> Result<(), Fault> {
    within(&format!("{table}.distance_mm"), distance_mm, DISTANCE_MM, " mm")?;
    let most_mm = distance_mm * MOST_U_REL;
    above(&format!("{table}.u_distance_mm"), u_distance_mm, 0.0..=most_mm, " mm")
}

/// The distance of a plan's block.
pub(crate) fn block_distance(path: &str, distance_mm: f64) -> Result<(), Fault> {
    within(path, distance_mm, DISTANCE_MM, " mm")
}

fn check_axis(name: &str, axis: &Axis) -> Result<(), Fault> {
    let key = |name_of_key: &str| format!("{name}.{name_of_key}");
    driver_and_target(&key("open"), &axis.open)?;
    within(&key("counts_per_deg"), axis.counts_per_deg.as_f64(), 0.1..=1e8, "")?;
    if !matches!(axis.sense, 1 | -1) {
        return Err(Fault::new(key("sense"), "is 1 or -1"));
    }
    within(&key("zero_deg"), axis.zero_deg, -3600.0..=3600.0, "°")?;
    let [low, high] = axis.limit_deg;
    for end in [low, high] {
        within(&key("limit_deg"), end, -3600.0..=3600.0, "°")?;
    }
    if low >= high {
        return Err(Fault::new(
            key("limit_deg"),
            "is [smallest, largest] in degrees, the first below the second",
        ));
    }
    within(&key("speed_deg_s"), axis.speed_deg_s, 1e-3..=1e4, "°/s")?;
    within(&key("accel_deg_s2"), axis.accel_deg_s2, 1e-3..=1e6, "°/s²")?;
    // Wider, and a pose that is verified says nothing.
    within(&key("tolerance_deg"), axis.tolerance_deg, 1e-4..=1.0, "°")
}

fn check_rail(rail: &Rail) -> Result<(), Fault> {
    one_of("rail", rail.open.as_deref(), rail.prompt.as_deref())?;
    if rail.open.is_none() {
        return Ok(());
    }
    let Some(driven) = rail.driven() else {
        return Err(Fault::new(
            "rail",
            "a driven rail needs counts_per_mm, zero_mm, limit_mm, speed_mm_s and accel_mm_s2",
        ));
    };
    within("rail.counts_per_mm", driven.counts_per_mm.as_f64(), 1e-3..=1e8, "")?;
    if !matches!(driven.sense, 1 | -1) {
        return Err(Fault::new("rail.sense", "is 1 or -1"));
    }
    within("rail.zero_mm", driven.zero_mm, -1e6..=1e6, " mm")?;
    let [low, high] = driven.limit_mm;
    for end in [low, high] {
        within("rail.limit_mm", end, DISTANCE_MM, " mm")?;
    }
    if low >= high {
        return Err(Fault::new(
            "rail.limit_mm",
            "is [smallest, largest] in mm, above 0, the first below the second",
        ));
    }
    within("rail.speed_mm_s", driven.speed_mm_s, 1e-3..=1e5, " mm/s")?;
    within("rail.accel_mm_s2", driven.accel_mm_s2, 1e-3..=1e7, " mm/s²")
}

fn one_of(name: &str, open: Option<&str>, prompt: Option<&str>) -> Result<(), Fault> {
    match (open, prompt) {
        (Some(open), None) => driver_and_target(&format!("{name}.open"), open),
        (None, Some(prompt)) if !prompt.trim().is_empty() => Ok(()),
        (None, Some(_)) => Err(Fault::new(
            format!("{name}.prompt"),
            "is empty; write what the person is to do",
        )),
        _ => Err(Fault::new(
            name,
            "needs either `open = \"driver:target\"` or `prompt = \"…\"`, one of the two",
        )),
    }
}
