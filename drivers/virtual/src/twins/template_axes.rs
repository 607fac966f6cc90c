//! The axes that the template of `ascii-axis` describes: two drives on a line, address 1 turns C, address 2 turns γ.
//! No real instrument.
//!
//! A command is an address, a blank, a word and perhaps a number, ended by CR; answers end with CR LF. One step of a
//! drive is one microstep of the room.

use isolux_darkroom::Instrument;
use isolux_transport::{LineSettings, Parity};

use crate::twin::{Answer, Twin, TwinKind};
use crate::world::{AxisName, AxisState, World};

/// In the table of twins.
pub(crate) const TWIN: TwinKind = TwinKind {
    instrument: Instrument::Axes,
    driver: "ascii-axis",
    line: LineSettings {
        baud: 19_200,
        data_bits: 8,
        parity: Parity::None,
        stop_bits: 1,
    },
    opens: &[
        ("axis.c", "?profile=template&address=1"),
        ("axis.gamma", "?profile=template&address=2"),
    ],
    sweeps: None,
    noise_lx: None,
    calibration: None,
    start: |world| Box::new(TemplateDrives::new(world)),
};

/// Ten bits a byte at 19200 baud, s.
const BYTE_S: f64 = 10.0 / 19_200.0;

/// The drives of a line.
pub(crate) struct TemplateDrives {
    drives: [Drive; 2],
}

struct Drive {
    /// Steps = true microsteps − this.
    offset: f64,
    speed: f64,
    acceleration: f64,
    /// When the reference was, or will be, found.
    homed_from_s: Option<f64>,
    homing_until_s: f64,
    stalled: bool,
}

impl TemplateDrives {
    fn new(world: &World) -> Self {
        let drive = |name| {
            let axis = world.axis(name);
            Drive {
                offset: axis.motion.position(0.0),
                speed: 1000.0,
                acceleration: 10_000.0,
                homed_from_s: None,
                homing_until_s: f64::NEG_INFINITY,
                stalled: false,
            }
        };
        Self {
            drives: [drive(AxisName::C), drive(AxisName::Gamma)],
        }
    }
}

impl Drive {
    fn answer(&mut self, command: &str, axis: &mut AxisState, now_s: f64) -> String {
        let moving = axis.motion.moving(now_s);
        let (word, number) = command.split_once(' ').unwrap_or((command, ""));
        let at = axis.motion.position(now_s) - self.offset;
        match (word, number) {
            ("ID?", "") => "ID TURN-1,0042,1.0".to_owned(),
            ("MODE", "ABS") => "OK".to_owned(),
            ("POS?", "") => format!("POS {}", at.round() as i64),
            ("STATE?", "") if self.stalled => "STATE STALL".to_owned(),
            ("STATE?", "") if now_s < self.homing_until_s => "STATE HOMING".to_owned(),
            ("STATE?", "") if moving => "STATE MOVING".to_owned(),
            ("STATE?", "") => "STATE READY".to_owned(),
            ("REF?", "") if self.homed_from_s.is_some_and(|from_s| from_s <= now_s) => "REF YES".to_owned(),
            ("REF?", "") => "REF NO".to_owned(),
            ("SPEED?", "") => format!("SPEED {:.0}", self.speed),
            ("ACCEL?", "") => format!("ACCEL {:.0}", self.acceleration),
            ("SPEED" | "ACCEL", _) => match number.parse::<u32>() {
                Ok(value @ 1..) if word == "SPEED" => {
                    self.speed = value.into();
                    "OK".to_owned()
                }
                Ok(value @ 1..) => {
                    self.acceleration = value.into();
                    "OK".to_owned()
                }
                _ => "ERR 1".to_owned(),
            },
            ("GO" | "HOME", _) if moving || (self.stalled && word == "GO") => "ERR 3".to_owned(),
            ("GO", _) => match number.parse::<i32>() {
                Ok(steps) => self.go(f64::from(steps) + self.offset, axis, now_s),
                Err(_) => "ERR 1".to_owned(),
            },
            ("HOME", "") => {
                let motion = axis.motion.move_to(0.0, now_s, 0.5 * self.speed, self.acceleration);
                (self.homing_until_s, self.stalled) = (motion.end_s().max(now_s), false);
                (self.homed_from_s, self.offset) = (Some(self.homing_until_s), 0.0);
                axis.drive(motion, now_s);
                "OK".to_owned()
            }
            ("STOP" | "KILL", "") => {
                if moving {
                    let rest = if word == "STOP" {
                        axis.motion.stop(now_s, self.acceleration)
                    } else {
                        axis.motion.freeze(now_s)
                    };
                    axis.drive(rest, now_s);
                    self.homed_from_s = self.homed_from_s.filter(|from_s| *from_s <= now_s);
                    self.homing_until_s = now_s;
                }
                "OK".to_owned()
            }
            _ => "ERR 1".to_owned(),
        }
    }

    fn go(&self, target: f64, axis: &mut AxisState, now_s: f64) -> String {
        if !(axis.limit[0]..=axis.limit[1]).contains(&target) {
            return "ERR 2".to_owned();
        }
        let motion = axis.motion.move_to(target, now_s, self.speed, self.acceleration);
        axis.drive(motion, now_s);
        "OK".to_owned()
    }
}

impl Twin for TemplateDrives {
    fn receive(&mut self, inbox: &mut Vec<u8>, world: &mut World, now_s: f64) -> Option<Answer> {
        let end = inbox.iter().position(|byte| *byte == b'\r')?;
        let line: Vec<u8> = inbox.drain(..=end).collect();
        let text = String::from_utf8_lossy(&line[..end]).into_owned();
        let (address, command) = text.split_once(' ').unwrap_or_default();
        // Everybody else is silent.
        let (at, name) = match address {
            "1" => (0, AxisName::C),
            "2" => (1, AxisName::Gamma),
            _ => return Some(Answer::At(now_s, Vec::new())),
        };
        let stated = self.drives[at].answer(command, world.axis_mut(name), now_s);
        let bytes = format!("{address} {stated}\r\n").into_bytes();
        Some(Answer::At(now_s + (line.len() + bytes.len()) as f64 * BYTE_S, bytes))
    }

    /// An obstacle blocks the motor.
    fn stall(&mut self, world: &mut World, from_s: f64, now_s: f64) -> bool {
        for (drive, name) in self.drives.iter_mut().zip([AxisName::C, AxisName::Gamma]) {
            let axis = world.axis_mut(name);
            let (start_s, end_s) = (axis.motion.start_s(), axis.motion.end_s());
            let hit_s = from_s.max(0.5 * (start_s + end_s));
            if hit_s < end_s && hit_s <= now_s {
                let frozen = axis.motion.freeze(hit_s);
                axis.drive(frozen, now_s);
                drive.stalled = true;
                return true;
            }
        }
        false
    }
}
