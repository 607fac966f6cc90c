//! What a sweep asks of a bench: a meter that is fast enough, a fixed range, way enough for run-up and run-out.

use isolux_device::{Conversions, LuxMeterProperties};
use isolux_photometry::Symmetry;
use isolux_record::Station;
use isolux_record::document::Fault;
use isolux_record::plan::{Block, Pass, Plan, Way};
use isolux_record::station::Axis;

use crate::chosen;
use crate::devices::Devices;
use crate::read_distance::distance_mm;

/// Between the end of one conversion and the beginning of the next: both ways on a line of 9600 baud.
const EXCHANGE_S: f64 = 0.03;
/// Conversions for each step of the grid, at least, of a meter that converts on request: there are ways between them.
const PER_STEP: f64 = 1.0;
/// And of one that converts all the time, whose windows leave no way out.
const PER_STEP_ALL_THE_TIME: f64 = 0.66;
/// Share of its range that the largest light expected may fill: an estimate is uncertain.
pub(crate) const FILLED: f64 = 0.7;

/// Directions of a block of sweeps that are read at rest afterwards.
pub(crate) const AT_REST: usize = 10;

/// The speed of a sweep over γ of this finest step at which a meter that converts on request, with this integration
/// time, still follows, °/s.
pub fn most_deg_s(step_deg: f64, integration_s: f64) -> f64 {
    step_deg / (PER_STEP * every_s(integration_s, integration_s))
}

/// How often a meter that converts on request gives a value: its integration and the exchange around it, or what it
/// takes itself from one value to the next where that is longer, s.
fn every_s(integration_s: f64, update_interval_s: f64) -> f64 {
    (integration_s + EXCHANGE_S).max(update_interval_s)
}

/// The same of a meter that converts by a clock of its own, with a new value so often.
pub fn most_by_own_clock_deg_s(step_deg: f64, update_interval_s: f64) -> f64 {
    step_deg / (PER_STEP_ALL_THE_TIME * update_interval_s)
}

/// The finest step of the block's γ, degrees.
pub(crate) fn step_deg(block: &Block) -> f64 {
    block
        .gamma_deg
        .windows(2)
        .map(|pair| pair[1] - pair[0])
        .fold(f64::INFINITY, f64::min)
}

/// That the meter can follow every block of sweeps of `plan`. Nothing has moved yet.
///
/// # Errors
/// A [`Fault`] with the plan's key, and with the speed that would do.
pub(crate) fn check_meter(station: &Station, devices: &Devices, plan: &Plan) -> Result<(), Fault> {
    let properties = devices.meter.properties();
    for (index, block) in plan.blocks().iter().enumerate() {
        let Some(speed) = block.sweep_deg_s else { continue };
        let fault = |key: &str, message: String| Err(Fault::new(format!("block.{index}.{key}"), message));
        let model = &devices.meter.identity().model;
        let step_deg = step_deg(block);
        let (every_s, most) = match properties.converts {
            Conversions::OnRequest => {
                let times = [properties.integration, properties.update_interval].map(|time| time.as_secs_f64());
                let every_s = every_s(times[0], times[1]);
                (every_s, step_deg / (PER_STEP * every_s))
            }
            Conversions::ByOwnClock => {
                let update_s = properties.update_interval.as_secs_f64();
                (update_s, most_by_own_clock_deg_s(step_deg, update_s))
            }
            Conversions::Unknown => {
                return fault(
                    "mode",
                    format!(
                        "{model} does not say when it converts: sweeps need a meter that converts on request (driver \
                         gigahertz-p9710, a spectroradiometer, a profile that says so) or whose clock its answers show \
                         (konica-t10a); leave `mode` out of block `{}`",
                        block.name
                    ),
                );
            }
        };
        if properties.range_full_scale.is_empty() {
            return fault(
                "mode",
                format!(
                    "a sweep holds one range, and the ranges of {model} are not known in lx: state its sensitivity, \
                     a_per_lx, or of a spectroradiometer full_scale_lx, in `open`"
                ),
            );
        }
        if station.lamp().and_then(|lamp| lamp.peak_cd).is_none() {
            return fault(
                "mode",
                "a sweep holds one range, and the station does not say how bright the lamp is: give `peak_cd` in [lamp]".to_owned(),
            );
        }
        if block.dim_digits.is_some() && range(station, properties, distance_mm(station, block), 0) == 1 {
            return fault(
                "dim_digits",
                format!("the largest light is read in the most sensitive range of {model} already: leave it out"),
            );
        }
        if speed > most {
            return fault(
                "speed_deg_s|mode",
                format!(
                    "{model} gives a value every {every_s:.2} s, at {speed} °/s one in {:.1}°, and the grid has {step_deg}°: \
                     {:.1} °/s would do{}",
                    speed * every_s,
                    (10.0 * most).floor() / 10.0,
                    if properties.converts == Conversions::OnRequest {
                        ", or a shorter integration time"
                    } else {
                        ", or a meter that converts on request (driver gigahertz-p9710)"
                    }
                ),
            );
        }
    }
    Ok(())
}

/// That the axes have the way and the speed for a block of sweeps.
///
/// # Errors
/// A [`Fault`] with the plan's key.
pub(crate) fn check_axis(station: &Station, index: usize, block: &Block) -> Result<(), Fault> {
    check_symmetry(index, block)?;
    for pass in block.passes() {
        let is_ring = pass.way.half_plane_deg().is_none();
        let (name, axis) = moving(station, &pass);
        let [low, high] = axis.limit_deg;
        if pass.speed_deg_s > axis.speed_deg_s {
            return Err(Fault::new(
                format!("block.{index}.speed_deg_s|mode"),
                format!(
                    "{} °/s is more than the {name} axis does, {} °/s",
                    pass.speed_deg_s, axis.speed_deg_s
                ),
            ));
        }
        let ends = pass.ends_deg(axis.accel_deg_s2);
        if let Some(end) = ends.iter().find(|end| !(low..=high).contains(*end)) {
            let (key, what) = if is_ring {
                (
                    if block.target.is_some() {
                        "target"
                    } else {
                        "symmetry_max_rel"
                    },
                    "a ring",
                )
            } else {
                ("gamma_deg|gamma_range", "a sweep")
            };
            return Err(Fault::new(
                format!("block.{index}.{key}"),
                format!(
                    "block `{}`: with its run-up {what} begins or ends at {name} = {end:.2}°, outside the axis' \
                     limits {low}°…{high}°; slow it down, shorten it, or correct limit_deg in the station",
                    block.name
                ),
            ));
        }
    }
    Ok(())
}

/// That rings have a symmetry to look at, where they are asked for.
fn check_symmetry(index: usize, block: &Block) -> Result<(), Fault> {
    let key = format!("block.{index}.symmetry_max_rel");
    match block.symmetry_max_rel.map(|_| chosen::assumed(block)) {
        Some(Ok(Symmetry::None)) => Err(Fault::new(
            key,
            format!(
                "the half-planes of block `{}` lie all round and assume no symmetry: leave it out, or take a part \
                 of the circle, C 0° to 90° or to 180° with γ from 0°, or one half-plane",
                block.name
            ),
        )),
        Some(Err(error)) => Err(Fault::new(key, format!("block `{}`: {error}", block.name))),
        _ => Ok(()),
    }
}

/// The axis that moves in a sweep, and its name.
fn moving<'a>(station: &'a Station, pass: &Pass) -> (&'static str, &'a Axis) {
    match pass.way {
        Way::HalfPlane { .. } => ("γ", station.axis_gamma()),
        Way::Ring { .. } => ("C", station.axis_c()),
    }
}

/// The range that a sweep holds: the most sensitive one that the largest light expected fills in part, `up` ranges
/// above it.
pub(crate) fn range(station: &Station, meter: &LuxMeterProperties, distance_mm: f64, up: u8) -> u8 {
    let peak_cd = station.lamp().and_then(|lamp| lamp.peak_cd).unwrap_or(f64::INFINITY);
    let expected_lx = peak_cd / (distance_mm * 1e-3).powi(2);
    let tops = &meter.range_full_scale;
    let fits = tops.iter().position(|top| expected_lx <= FILLED * top.value());
    let last = tops.len().saturating_sub(1);
    let place = (fits.unwrap_or(last) + usize::from(up)).min(last);
    place as u8 + 1
}

/// How long the axis moves in one sweep, s.
pub(crate) fn pass_s(station: &Station, pass: &Pass) -> f64 {
    let accel = moving(station, pass).1.accel_deg_s2;
    let [start, end] = pass.ends_deg(accel);
    (end - start).abs() / pass.speed_deg_s + pass.speed_deg_s / accel
}
