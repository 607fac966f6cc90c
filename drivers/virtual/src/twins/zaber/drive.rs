//! One axis of the controller: what it knows of it, and the commands that set and move it.

use std::collections::BTreeSet;

use crate::world::{AxisName, AxisState, World};

/// Data of `set maxspeed` are microsteps per second times this.
pub(super) const SPEED_DATA: f64 = 1.6384;
/// Data of `set accel` are microsteps per second squared times this.
pub(super) const ACCEL_DATA: f64 = 1.6384e-4;
/// What the controller knows of one axis.
#[derive(Default)]
pub(super) struct Drive {
    /// Counter = true microsteps − this.
    pub offset: f64,
    /// When homing ends; counts as homed from then on.
    pub homed_from_s: Option<f64>,
    pub speed: f64,
    pub acceleration: f64,
    pub flags: BTreeSet<&'static str>,
}

/// A reply's content.
pub(super) enum Outcome {
    Ok(String),
    Rejected(&'static str),
}

pub(super) fn set(drive: &mut Drive, axis: &AxisState, setting: &str, value: &str) -> Outcome {
    let (target, top, unit) = match setting {
        "maxspeed" => (&mut drive.speed, axis.top_speed, SPEED_DATA),
        "accel" => (&mut drive.acceleration, axis.top_acceleration, ACCEL_DATA),
        "limit.min" | "limit.max" | "pos" | "resolution" => return Outcome::Rejected("BADDATA"),
        _ => return Outcome::Rejected("BADCOMMAND"),
    };
    match value.parse::<f64>() {
        // One data step over the top is still the top.
        Ok(data) if data >= 1.0 && data.fract() == 0.0 && data <= top * unit + 1.0 => {
            *target = (data / unit).min(top);
            Outcome::Ok("0".into())
        }
        _ => Outcome::Rejected("BADDATA"),
    }
}

pub(super) fn home(drive: &mut Drive, name: AxisName, world: &mut World, now_s: f64) -> Outcome {
    if name == AxisName::Rail {
        // The encoder is absolute: there is nothing to look for.
        return Outcome::Ok("0".into());
    }
    let axis = world.axis_mut(name);
    let motion = axis.motion.move_to(0.0, now_s, 0.5 * drive.speed, drive.acceleration);
    drive.flags.remove("NI");
    drive.homed_from_s = Some(motion.end_s().max(now_s));
    drive.offset = 0.0;
    axis.drive(motion, now_s);
    Outcome::Ok("0".into())
}

pub(super) fn move_to(
    drive: &mut Drive,
    name: AxisName,
    how: &str,
    value: Option<&str>,
    world: &mut World,
    now_s: f64,
) -> Outcome {
    let axis = world.axis_mut(name);
    let value = match value.map(str::parse::<i64>) {
        Some(Ok(value)) => value as f64,
        None => 0.0,
        Some(Err(_)) => return Outcome::Rejected("BADDATA"),
    };
    let referenced = drive.homed_from_s.is_some_and(|from| from <= now_s);
    let target = match how {
        "abs" | "min" | "max" if !referenced => return Outcome::Rejected("BADDATA"),
        "abs" => value,
        "rel" => (axis.motion.position(now_s) - drive.offset).round() + value,
        "min" => axis.limit[0],
        "max" => axis.limit[1],
        _ => return Outcome::Rejected("BADCOMMAND"),
    };
    if !(axis.limit[0]..=axis.limit[1]).contains(&target) {
        return Outcome::Rejected("BADDATA");
    }
    drive.flags.remove("NI");
    let motion = axis
        .motion
        .move_to(target + drive.offset, now_s, drive.speed, drive.acceleration);
    axis.drive(motion, now_s);
    Outcome::Ok("0".into())
}

pub(super) fn stop(drive: &mut Drive, name: AxisName, world: &mut World, now_s: f64, hardness: f64) -> Outcome {
    let axis = world.axis_mut(name);
    if axis.motion.moving(now_s) {
        // A stop ends on a whole microstep.
        let braked = axis.motion.stop(now_s, hardness * drive.acceleration);
        axis.drive(braked, now_s);
        drive.homed_from_s = drive.homed_from_s.filter(|from| *from <= now_s);
        drive.flags.insert("NI");
    }
    Outcome::Ok("0".into())
}
