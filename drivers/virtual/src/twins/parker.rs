//! The axes: two Parker XLi indexer drives in a daisy chain, address 1 turns C, address 2 turns γ, in EASI.
//!
//! 4000 steps a revolution of the motor, one step of the drive is one microstep of the room. The home switch is at 0.
//! Commands and reports after the "XL25i, XL50i & XL80i Stepper Drive User Guide", chapter 6; programs (labels,
//! triggers, registration) are left out and refused as not supported.

use isolux_darkroom::Instrument;
use isolux_transport::{LineSettings, Parity};

use crate::twin::{Answer, Twin, TwinKind};
use crate::world::{AxisName, AxisState, World};

/// In the table of twins.
pub(crate) const TWIN: TwinKind = TwinKind {
    instrument: Instrument::Axes,
    driver: "parker-easi",
    line: LineSettings {
        baud: 9600,
        data_bits: 8,
        parity: Parity::None,
        stop_bits: 1,
    },
    opens: &[
        ("axis.c", "?address=1&home=-,0,-10,40,1"),
        ("axis.gamma", "?address=2&home=-,0,-10,40,1"),
    ],
    sweeps: None,
    noise_lx: None,
    calibration: None,
    start: |world| Box::new(Chain::new(world)),
};

/// Motor resolution as delivered, steps a revolution.
const STEPS_PER_REV: f64 = 4000.0;
/// Ten bits a byte.
const BYTE_S: f64 = 10.0 / 9600.0;
/// After Z.
const RESET_S: f64 = 1.0;

/// User faults by number, table 4-5.
const OUT_OF_RANGE: u32 = 1;
const SYNTAX: u32 = 2;
const HOMING_FAILED: u32 = 6;
const DE_ENERGISED: u32 = 8;
const LIMIT: u32 = 13;
const STILL_MOVING: u32 = 14;
const NOT_SUPPORTED: u32 = 23;

/// The drives of a chain.
pub struct Chain {
    drives: [Drive; 2],
}

struct Drive {
    /// Steps = true microsteps − this.
    offset: f64,
    ex: u8,
    queue: bool,
    absolute: bool,
    velocity: f64,
    acceleration: f64,
    deceleration: f64,
    start_stop: f64,
    distance: i64,
    settle_ms: u32,
    energised: bool,
    armed: bool,
    /// Speed in rev/s; none until HOME1 has said it.
    home: Option<f64>,
    homing_until_s: f64,
    limit: Option<u32>,
    user_faults: u32,
    drive_faults: u32,
    deaf_until_s: f64,
}

impl Drive {
    fn at_power_up(position: f64) -> Self {
        Self {
            offset: position,
            ex: 3,
            queue: true,
            absolute: false,
            velocity: 1.0,
            acceleration: 10.0,
            deceleration: 10.0,
            start_stop: 0.0,
            distance: 4000,
            settle_ms: 10,
            energised: false,
            armed: false,
            home: None,
            homing_until_s: f64::NEG_INFINITY,
            limit: None,
            user_faults: 0,
            drive_faults: 0,
            deaf_until_s: f64::NEG_INFINITY,
        }
    }

    fn refuse(&mut self, fault: u32) -> Option<String> {
        self.user_faults |= bit(fault);
        // Spoken only where the drive may speak whenever it likes.
        (self.ex % 2 == 1).then(|| "*E".to_owned())
    }

    fn command(&mut self, text: &str, axis: &mut AxisState, now_s: f64) -> Option<String> {
        let moving = axis.motion.moving(now_s);
        let letters = text.find(|c: char| !c.is_ascii_alphabetic()).unwrap_or(text.len());
        let (name, rest) = text.split_at(letters);
        let inner = rest.strip_prefix('(').and_then(|inner| inner.strip_suffix(')'));
        match (name, rest) {
            ("R", _) => return self.report(inner.unwrap_or_default(), axis, now_s),
            ("W", _) => return self.write(inner.unwrap_or_default(), axis, now_s),
            ("ON", "") => {
                self.user_faults = 0;
                self.energised = self.drive_faults == 0;
            }
            ("OFF", "") => self.energised = false,
            ("MA", "") => self.absolute = true,
            ("MI", "") => self.absolute = false,
            ("M", "") => return Some(format!("*{}", if self.absolute { "MA" } else { "MI" })),
            ("ARM", digits) if digits.starts_with(['0', '1']) => self.armed = digits.starts_with('1'),
            ("HOME", _) => match home_speed(rest) {
                Some(speed) => self.home = Some(speed),
                None => return self.refuse(SYNTAX),
            },
            ("LIMITS", _) if inner.is_some() => {}
            ("G", "") => return self.go(axis, now_s),
            ("GH", "") => return self.go_home(axis, now_s),
            ("S", "") if moving => {
                let braked = axis.motion.stop(now_s, self.deceleration * STEPS_PER_REV);
                axis.drive(braked, now_s);
                self.homing_until_s = now_s;
            }
            ("K", "") => {
                let frozen = axis.motion.freeze(now_s);
                axis.drive(frozen, now_s);
                (self.homing_until_s, self.armed) = (now_s, false);
            }
            ("S", "") => {}
            ("Z", "") => {
                let frozen = axis.motion.freeze(now_s);
                let position = frozen.position(now_s);
                axis.drive(frozen, now_s);
                *self = Self {
                    deaf_until_s: now_s + RESET_S,
                    ..Self::at_power_up(position)
                };
                return None;
            }
            _ => return self.setting(name, rest),
        }
        None
    }

    /// A setting, or what it is set to.
    fn setting(&mut self, name: &str, value: &str) -> Option<String> {
        if name == "D" {
            return match value.parse::<i32>() {
                Ok(steps) => {
                    self.distance = steps.into();
                    None
                }
                Err(_) if value.is_empty() => Some(format!("*{}", self.distance)),
                Err(_) => self.refuse(OUT_OF_RANGE),
            };
        }
        let (place, least, most, digits) = match name {
            "V" => (&mut self.velocity, 0.01, 50.0, 2),
            "AA" => (&mut self.acceleration, 0.1, 1023.9, 1),
            "AD" => (&mut self.deceleration, 0.1, 1023.9, 1),
            "VS" => (&mut self.start_stop, 0.0, 5.0, 2),
            _ => return self.refuse(NOT_SUPPORTED),
        };
        if value.is_empty() {
            return Some(format!("*{place:.digits$}"));
        }
        match value.parse::<f64>() {
            Ok(value) if (least..=most).contains(&value) => {
                *place = value;
                None
            }
            _ => self.refuse(OUT_OF_RANGE),
        }
    }

    fn report(&mut self, variable: &str, axis: &AxisState, now_s: f64) -> Option<String> {
        let moving = axis.motion.moving(now_s);
        let status = [
            (now_s < self.homing_until_s, 5),
            (self.energised, 9),
            (self.limit == Some(13), 13),
            (self.limit == Some(14), 14),
            (moving, 19),
            (!moving, 20),
        ];
        let status = status
            .iter()
            .filter(|(on, _)| *on)
            .fold(0, |word, (_, number)| word | bit(*number));
        let text = match variable {
            "ST" => word(status),
            "DF" => word(self.drive_faults),
            "UF" => word(std::mem::take(&mut self.user_faults)),
            "ST1" | "ST2" | "ST3" | "ST4" => byte(status, variable),
            "DF1" | "DF2" | "DF3" | "DF4" => byte(self.drive_faults, variable),
            "UF1" | "UF2" | "UF3" | "UF4" => byte(self.user_faults, variable),
            "PA" => format!("{:.0}", axis.motion.position(now_s) - self.offset),
            "MV" | "RB" => u8::from(moving).to_string(),
            "IP" => u8::from(!moving).to_string(),
            "MR" => format!("{STEPS_PER_REV:.0}"),
            "EX" => self.ex.to_string(),
            "CQ" => u8::from(self.queue).to_string(),
            "IT" => self.settle_ms.to_string(),
            "RV" => "2.18".to_owned(),
            "SN" => "80042".to_owned(),
            _ => return self.refuse(SYNTAX),
        };
        Some(format!("*{text}"))
    }

    fn write(&mut self, inner: &str, axis: &AxisState, now_s: f64) -> Option<String> {
        let (variable, value) = inner.split_once(',').unwrap_or((inner, ""));
        let Ok(value) = value.parse::<i64>() else {
            return self.refuse(SYNTAX);
        };
        match (variable, value) {
            ("EX", 0..=3) => self.ex = value as u8,
            ("CQ", 0 | 1) => self.queue = value == 1,
            ("IT", 1..=500) => self.settle_ms = value as u32,
            ("PA", _) => self.offset = axis.motion.position(now_s) - value as f64,
            ("EX" | "CQ" | "IT", _) => return self.refuse(OUT_OF_RANGE),
            _ => return self.refuse(SYNTAX),
        }
        None
    }

    fn go(&mut self, axis: &mut AxisState, now_s: f64) -> Option<String> {
        if !self.energised {
            return self.refuse(DE_ENERGISED);
        }
        if axis.motion.moving(now_s) {
            return self.refuse(STILL_MOVING);
        }
        let from = if self.absolute {
            self.offset
        } else {
            axis.motion.position(now_s)
        };
        self.drive_to(self.distance as f64 + from, self.velocity, axis, now_s);
        None
    }

    fn drive_to(&mut self, wanted: f64, rev_s: f64, axis: &mut AxisState, now_s: f64) {
        let target = wanted.clamp(axis.limit[0], axis.limit[1]);
        self.limit = (target != wanted).then_some(if wanted > target { 14 } else { 13 });
        if self.limit.is_some() {
            self.user_faults |= bit(LIMIT);
        }
        let motion = axis
            .motion
            .move_to(target, now_s, rev_s * STEPS_PER_REV, self.acceleration * STEPS_PER_REV);
        axis.drive(motion, now_s);
    }

    fn go_home(&mut self, axis: &mut AxisState, now_s: f64) -> Option<String> {
        if !self.energised {
            return self.refuse(DE_ENERGISED);
        }
        let (true, Some(rev_s)) = (self.armed, self.home) else {
            return self.refuse(HOMING_FAILED);
        };
        self.drive_to(0.0, rev_s, axis, now_s);
        (self.limit, self.offset) = (None, 0.0);
        self.homing_until_s = axis.motion.end_s();
        None
    }
}

/// Speed of HOME1(edge, type, speed with direction, acceleration, mode).
fn home_speed(rest: &str) -> Option<f64> {
    let inner = rest.strip_prefix("1(")?.strip_suffix(')')?;
    let fields: Vec<&str> = inner.split(',').collect();
    let [_, _, speed, _, _] = fields[..] else { return None };
    speed.parse().ok().map(f64::abs).filter(|speed| *speed > 0.0)
}

/// Bit `number`, the leftmost being 1.
const fn bit(number: u32) -> u32 {
    1 << (32 - number)
}

fn word(bits: u32) -> String {
    let digits = format!("{bits:032b}");
    let groups: Vec<&str> = (0..8).map(|group| &digits[4 * group..4 * group + 4]).collect();
    groups.join("_")
}

fn byte(bits: u32, variable: &str) -> String {
    let at = variable.bytes().last().map_or(0, |digit| usize::from(digit - b'1'));
    format!("{bits:032b}")[8 * at..8 * at + 8].to_owned()
}

impl Chain {
    /// Both drives at power-up.
    pub fn new(world: &World) -> Self {
        let drive = |name| Drive::at_power_up(world.axis(name).motion.position(0.0));
        Self {
            drives: [drive(AxisName::C), drive(AxisName::Gamma)],
        }
    }
}

impl Twin for Chain {
    fn receive(&mut self, inbox: &mut Vec<u8>, world: &mut World, now_s: f64) -> Option<Answer> {
        let end = inbox.iter().position(|byte| *byte == b'\r')?;
        let line: Vec<u8> = inbox
            .drain(..=end)
            .filter(|byte| !matches!(byte, b'\r' | b'\n'))
            .collect();
        let text = String::from_utf8_lossy(&line).into_owned();
        let mut bytes = Vec::new();
        let digits = text.find(|c: char| !c.is_ascii_digit()).unwrap_or(text.len());
        let address = text[..digits].parse::<usize>().unwrap_or(usize::MAX);
        for (at, name) in [AxisName::C, AxisName::Gamma].into_iter().enumerate() {
            let drive = &mut self.drives[at];
            // Whoever echoes passes on what it hears, for the next drive of the chain; the last one's comes back.
            if at == 0 && drive.ex >= 2 && drive.deaf_until_s <= now_s {
                bytes.extend(&line);
                bytes.push(b'\r');
            }
            if (address == at + 1 || address == 0)
                && drive.deaf_until_s <= now_s
                && let Some(stated) = drive.command(&text[digits..], world.axis_mut(name), now_s)
            {
                bytes.extend(format!("{stated}\r\n").bytes());
            }
        }
        let line_s = (line.len() + 1).max(bytes.len()) as f64 * BYTE_S;
        Some(Answer::At(now_s + line_s, bytes))
    }

    /// The output stages are too hot and trip.
    fn alarm(&mut self, world: &mut World, now_s: f64) {
        for (drive, name) in self.drives.iter_mut().zip([AxisName::C, AxisName::Gamma]) {
            let axis = world.axis_mut(name);
            let frozen = axis.motion.freeze(now_s);
            axis.drive(frozen, now_s);
            drive.energised = false;
            drive.drive_faults |= bit(1) | bit(5);
        }
    }

    /// An obstacle blocks the motor, and the output stage trips: no current, over current.
    fn stall(&mut self, world: &mut World, from_s: f64, now_s: f64) -> bool {
        for (drive, name) in self.drives.iter_mut().zip([AxisName::C, AxisName::Gamma]) {
            let axis = world.axis_mut(name);
            let (start_s, end_s) = (axis.motion.start_s(), axis.motion.end_s());
            let hit_s = from_s.max(0.5 * (start_s + end_s));
            if hit_s < end_s && hit_s <= now_s {
                let frozen = axis.motion.freeze(hit_s);
                axis.drive(frozen, now_s);
                drive.energised = false;
                drive.drive_faults |= bit(1) | bit(2);
                return true;
            }
        }
        false
    }
}
