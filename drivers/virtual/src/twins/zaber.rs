//! The axes: a Zaber X-MCC controller of firmware 7, three axes, digital outputs and an analogue input, in ASCII.
//!
//! Axis 1 turns C, axis 2 turns γ, axis 3 carries the detector (2000 microsteps a millimetre, position = distance,
//! encoder absolute). Digital output 1 switches the lamp, 2 opens the shutter, 3 puts the baffle in. Analogue input 1
//! is a temperature transmitter, 0–10 V for −50 to 100 °C. Commands and replies after Zaber's ASCII protocol
//! manual.

mod drive;

use std::collections::BTreeSet;

use isolux_darkroom::Instrument;
use isolux_darkroom::noise::{Noise, Stream};
use isolux_transport::{LineSettings, Parity};

use self::drive::{ACCEL_DATA, Drive, Outcome, SPEED_DATA, home, move_to, set, stop};
use crate::twin::{Answer, InMotion, Twin, TwinKind};
use crate::world::{AxisName, Switches, World};

/// In the table of twins.
pub(crate) const TWIN: TwinKind = TwinKind {
    instrument: Instrument::Axes,
    driver: "zaber",
    line: LineSettings {
        baud: 115_200,
        data_bits: 8,
        parity: Parity::None,
        stop_bits: 1,
    },
    opens: &[
        ("axis.c", "?axis=1"),
        ("axis.gamma", "?axis=2"),
        ("lamp", "?do=1"),
        ("shutter", "?do=2"),
        ("baffle", "?do=3"),
        ("rail", "?axis=3"),
        ("ambient", "?ai=1&c_at_0v=-50&c_at_10v=100"),
    ],
    sweeps: Some(InMotion::Moves),
    noise_lx: None,
    calibration: None,
    start: |world| Box::new(Controller::new(world)),
};

/// From the end of a command to the first byte of its reply, s.
const LATENCY_S: f64 = 0.002;
/// Longest line that the controller takes.
const LONGEST_LINE: usize = 256;

/// The controller.
pub struct Controller {
    axes: [Drive; 3],
    checksum: bool,
    seed: u64,
    reads: u64,
}

impl Controller {
    /// The controller at power-up: C and γ not homed.
    pub fn new(world: &World) -> Self {
        let axes = AxisName::ALL.map(|name| {
            let axis = world.axis(name);
            let rail = name == AxisName::Rail;
            Drive {
                offset: if rail { 0.0 } else { axis.motion.position(0.0) },
                homed_from_s: rail.then_some(f64::NEG_INFINITY),
                speed: axis.top_speed,
                acceleration: axis.top_acceleration,
                flags: BTreeSet::new(),
            }
        });
        Self {
            axes,
            checksum: false,
            seed: world.room().document().seed,
            reads: 0,
        }
    }

    fn line(&mut self, line: &str, world: &mut World, now_s: f64) -> Vec<u8> {
        // Everything before the slash is noise on the line.
        let Some((_, body)) = line.split_once('/') else {
            return Vec::new();
        };
        let (body, checked) = match body.rsplit_once(':') {
            Some((text, digits)) => {
                if u8::from_str_radix(digits.trim(), 16) != Ok(lrc(text)) {
                    return Vec::new();
                }
                (text, true)
            }
            None => (body, false),
        };
        let mut words = body.split_ascii_whitespace().peekable();
        let mut number = || {
            let value = words.peek()?.parse::<u32>().ok()?;
            words.next();
            Some(value)
        };
        let device = number().unwrap_or(0);
        let axis = number().unwrap_or(0);
        let id = number();
        if device > 1 {
            return Vec::new();
        }
        let command: Vec<&str> = words.collect();
        let outcome = self.command(axis, &command, world, now_s);
        let (verdict, data) = match outcome {
            Outcome::Ok(data) => ("OK", data),
            Outcome::Rejected(reason) => ("RJ", reason.to_owned()),
        };
        let status = if self.busy(axis, world, now_s) { "BUSY" } else { "IDLE" };
        let flags = self.flags(axis, now_s);
        let flag = flags.first().copied().unwrap_or("--");
        let id = id.map_or(String::new(), |id| format!("{:02} ", id % 100));
        let mut reply = format!("01 {axis} {id}{verdict} {status} {flag} {data}");
        if checked || self.checksum {
            reply = format!("{reply}:{:02X}", lrc(&reply));
        }
        format!("@{reply}\r\n").into_bytes()
    }

    fn command(&mut self, axis: u32, words: &[&str], world: &mut World, now_s: f64) -> Outcome {
        if axis as usize > AxisName::ALL.len() {
            return Outcome::Rejected("BADAXIS");
        }
        match words {
            [] => Outcome::Ok("0".into()),
            ["get", setting] => self.get(axis, setting, world, now_s),
            ["set", "comm.checksum", value] if axis == 0 => match *value {
                "0" | "1" => {
                    self.checksum = *value == "1";
                    Outcome::Ok("0".into())
                }
                _ => Outcome::Rejected("BADDATA"),
            },
            ["set", setting, value] => self.each(axis, |drive, name| set(drive, world.axis(name), setting, value)),
            ["home"] => self.each(axis, |drive, name| home(drive, name, world, now_s)),
            ["move", how, value] => self.each(axis, |drive, name| move_to(drive, name, how, Some(value), world, now_s)),
            ["move", how @ ("min" | "max")] => {
                self.each(axis, |drive, name| move_to(drive, name, how, None, world, now_s))
            }
            ["stop"] => self.each(axis, |drive, name| stop(drive, name, world, now_s, 1.0)),
            ["estop"] => self.each(axis, |drive, name| stop(drive, name, world, now_s, 5.0)),
            ["warnings"] => Outcome::Ok(self.warnings(axis, now_s)),
            ["warnings", "clear"] => {
                let before = self.warnings(axis, now_s);
                self.each(axis, |drive, _| {
                    drive.flags.clear();
                    Outcome::Ok("0".into())
                });
                Outcome::Ok(before)
            }
            ["io", rest @ ..] if axis == 0 => io(rest, world, now_s, Noise::new(self.seed, Stream::Thermometer)),
            _ => Outcome::Rejected("BADCOMMAND"),
        }
    }

    fn get(&mut self, axis: u32, setting: &str, world: &World, now_s: f64) -> Outcome {
        if axis == 0 {
            let whole = match setting {
                "device.id" | "deviceid" => Some("30342".to_owned()),
                "system.serial" => Some(format!("{}", 900_000 + self.seed % 100_000)),
                "version" => Some("7.38".to_owned()),
                "system.axiscount" => Some(AxisName::ALL.len().to_string()),
                "comm.checksum" => Some(u8::from(self.checksum).to_string()),
                "comm.address" => Some("1".to_owned()),
                _ => None,
            };
            if let Some(whole) = whole {
                return Outcome::Ok(whole);
            }
        }
        let noise = Noise::new(self.seed, Stream::Encoder);
        let read = self.reads;
        let values: Option<Vec<String>> = self
            .selected(axis)
            .map(|(drive, name)| {
                let axis = world.axis(name);
                let encoder = match name {
                    AxisName::C => world.room().document().axis.c.encoder_noise_deg,
                    AxisName::Gamma => world.room().document().axis.gamma.encoder_noise_deg,
                    AxisName::Rail => 0.0,
                };
                let value = match setting {
                    "pos" | "encoder.pos" => {
                        let error = encoder * axis.counts_per_unit * noise.normal(read, name as u32);
                        (axis.counts(now_s) - drive.offset + error).round()
                    }
                    "limit.min" => axis.limit[0],
                    "limit.max" => axis.limit[1],
                    "maxspeed" => (drive.speed * SPEED_DATA).round(),
                    "accel" | "motion.accelonly" | "motion.decelonly" => (drive.acceleration * ACCEL_DATA).round(),
                    "vel" => (axis.motion.velocity(now_s) * SPEED_DATA).round(),
                    "resolution" => 64.0,
                    _ => return None,
                };
                Some(format!("{value:.0}"))
            })
            .collect();
        self.reads += 1;
        values.map_or(Outcome::Rejected("BADCOMMAND"), |values| Outcome::Ok(values.join(" ")))
    }

    fn selected(&self, axis: u32) -> impl Iterator<Item = (&Drive, AxisName)> {
        self.axes
            .iter()
            .zip(AxisName::ALL)
            .filter(move |(_, name)| axis == 0 || *name as u32 + 1 == axis)
    }

    fn each(&mut self, axis: u32, mut act: impl FnMut(&mut Drive, AxisName) -> Outcome) -> Outcome {
        let chosen = self
            .axes
            .iter_mut()
            .zip(AxisName::ALL)
            .filter(|(_, name)| axis == 0 || *name as u32 + 1 == axis);
        let mut last = Outcome::Ok("0".into());
        for (drive, name) in chosen {
            last = act(drive, name);
            if matches!(last, Outcome::Rejected(_)) {
                return last;
            }
        }
        last
    }

    fn busy(&self, axis: u32, world: &World, now_s: f64) -> bool {
        self.selected(axis)
            .any(|(_, name)| world.axis(name).motion.moving(now_s))
    }

    /// Warning flags, most severe first.
    fn flags(&self, axis: u32, now_s: f64) -> Vec<&'static str> {
        const SEVERITY: [&str; 5] = ["FD", "FS", "WR", "WH", "NI"];
        let mut set: BTreeSet<&'static str> = BTreeSet::new();
        for (drive, _) in self.selected(axis) {
            set.extend(&drive.flags);
            if drive.homed_from_s.is_none_or(|from| from > now_s) {
                set.extend(["WR", "WH"]);
            }
        }
        SEVERITY.into_iter().filter(|flag| set.contains(flag)).collect()
    }

    fn warnings(&self, axis: u32, now_s: f64) -> String {
        let flags = self.flags(axis, now_s);
        std::iter::once(format!("{:02}", flags.len()))
            .chain(flags.into_iter().map(str::to_owned))
            .collect::<Vec<_>>()
            .join(" ")
    }
}

fn io(words: &[&str], world: &mut World, now_s: f64, thermometer: Noise) -> Outcome {
    let switches = world.switches();
    match words {
        ["get", "do"] => {
            let all = [switches.lamp, switches.shutter_open, switches.baffle_in, false];
            Outcome::Ok(all.map(|on| u8::from(on).to_string()).join(" "))
        }
        ["get", "do", output] => match *output {
            "1" => Outcome::Ok(u8::from(switches.lamp).to_string()),
            "2" => Outcome::Ok(u8::from(switches.shutter_open).to_string()),
            "3" => Outcome::Ok(u8::from(switches.baffle_in).to_string()),
            "4" => Outcome::Ok("0".into()),
            _ => Outcome::Rejected("BADDATA"),
        },
        ["set", "do", output, value @ ("0" | "1")] => {
            let on = *value == "1";
            let next = match *output {
                "1" => Switches { lamp: on, ..switches },
                "2" => Switches {
                    shutter_open: on,
                    ..switches
                },
                "3" => Switches {
                    baffle_in: on,
                    ..switches
                },
                _ => return Outcome::Rejected("BADDATA"),
            };
            world.set_switches(next, now_s);
            Outcome::Ok("0".into())
        }
        ["get", "ai", "1"] => {
            // The transmitter is sampled ten times a second.
            let sample = (now_s * 10.0) as u64;
            let noise_c = world.room().document().room.thermometer_noise_c * thermometer.normal(sample, 0);
            let volt = ((world.temperature_c(now_s) + noise_c + 50.0) / 15.0).clamp(0.0, 10.0);
            Outcome::Ok(format!("{volt:.3}"))
        }
        ["get" | "set", ..] => Outcome::Rejected("BADDATA"),
        _ => Outcome::Rejected("BADCOMMAND"),
    }
}

/// Longitudinal redundancy check of the text between the first character and the colon.
fn lrc(text: &str) -> u8 {
    0u8.wrapping_sub(text.bytes().fold(0u8, u8::wrapping_add))
}

impl Twin for Controller {
    fn receive(&mut self, inbox: &mut Vec<u8>, world: &mut World, now_s: f64) -> Option<Answer> {
        let Some(end) = inbox.iter().position(|byte| matches!(byte, b'\r' | b'\n')) else {
            if inbox.len() > LONGEST_LINE {
                inbox.clear();
            }
            return None;
        };
        let line: Vec<u8> = inbox.drain(..=end).take(end).collect();
        let reply = std::str::from_utf8(&line).map_or(Vec::new(), |line| self.line(line, world, now_s));
        Some(Answer::At(now_s + LATENCY_S, reply))
    }

    /// The drivers of all motors switch themselves off: FD, "driver disabled".
    fn alarm(&mut self, world: &mut World, now_s: f64) {
        for (drive, name) in self.axes.iter_mut().zip(AxisName::ALL) {
            let axis = world.axis_mut(name);
            let frozen = axis.motion.freeze(now_s);
            axis.drive(frozen, now_s);
            drive.homed_from_s = drive.homed_from_s.filter(|from| *from <= now_s);
            drive.flags.insert("FD");
        }
    }

    /// The first axis whose motion lasts past `from_s` stops in the middle of that motion, as at an obstacle.
    fn stall(&mut self, world: &mut World, from_s: f64, now_s: f64) -> bool {
        for (drive, name) in self.axes.iter_mut().zip(AxisName::ALL) {
            let axis = world.axis_mut(name);
            let (start_s, end_s) = (axis.motion.start_s(), axis.motion.end_s());
            let hit_s = from_s.max(0.5 * (start_s + end_s));
            if hit_s < end_s && hit_s <= now_s {
                let frozen = axis.motion.freeze(hit_s);
                axis.drive(frozen, now_s);
                drive.homed_from_s = drive.homed_from_s.filter(|from| *from <= hit_s);
                drive.flags.insert("FS");
                return true;
            }
        }
        false
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use isolux_darkroom::Darkroom;

    fn talk(twin: &mut Controller, world: &mut World, now_s: f64, text: &str) -> String {
        let mut inbox = format!("{text}\n").into_bytes();
        match twin.receive(&mut inbox, world, now_s) {
            Some(Answer::At(_, bytes)) => String::from_utf8(bytes).unwrap(),
            _ => String::new(),
        }
    }

    #[test]
    fn an_axis_homes_moves_and_reports() {
        let mut world =
            World::new(Darkroom::parse("[axis.c]\nstart_deg = 30.0\n[injected_effects]\nonly = true\n").unwrap());
        let mut twin = Controller::new(&world);
        let mut at = |now: f64, text: &str| talk(&mut twin, &mut world, now, text);
        assert_eq!(at(0.0, "/1 1 get pos"), "@01 1 OK IDLE WR 0\r\n");
        assert_eq!(at(0.0, "/1 1 07 move abs 4000"), "@01 1 07 RJ IDLE WR BADDATA\r\n");
        assert_eq!(at(0.0, "/1 1 warnings"), "@01 1 OK IDLE WR 02 WR WH\r\n");
        assert_eq!(at(0.0, "/1 1 home"), "@01 1 OK BUSY WR 0\r\n");
        // 30° at half the top speed of 20 °/s: 3 s and a ramp.
        assert_eq!(at(3.0, "/1 1"), "@01 1 OK BUSY WR 0\r\n");
        assert_eq!(at(4.0, "/1 1"), "@01 1 OK IDLE -- 0\r\n");
        assert_eq!(at(4.0, "/1 1 move abs 128000"), "@01 1 OK BUSY -- 0\r\n");
        assert_eq!(at(9.0, "/1 1 get pos"), "@01 1 OK IDLE -- 128000\r\n");
        assert_eq!(at(9.0, "/1 1 move abs 99999999"), "@01 1 RJ IDLE -- BADDATA\r\n");
        assert_eq!(at(9.0, "/1 3 get pos"), "@01 3 OK IDLE -- 20000000\r\n");
        assert_eq!(at(9.0, "/1 5 get pos"), "@01 5 RJ IDLE -- BADAXIS\r\n");
        assert_eq!(at(9.0, "/1 1 dance"), "@01 1 RJ IDLE -- BADCOMMAND\r\n");
        assert!((world.axis(AxisName::C).position(9.0) - 30.0).abs() < 1e-9);
    }

    #[test]
    fn a_stop_interrupts_and_says_so() {
        let mut world = World::new(Darkroom::default());
        let mut twin = Controller::new(&world);
        let mut at = |now: f64, text: &str| talk(&mut twin, &mut world, now, text);
        at(0.0, "/1 0 home");
        at(1.0, "/1 2 move abs 384000");
        assert_eq!(at(3.0, "/1 0 stop"), "@01 0 OK BUSY NI 0\r\n");
        assert_eq!(at(5.0, "/1 2 warnings clear"), "@01 2 OK IDLE -- 01 NI\r\n");
        let position = at(5.0, "/1 2 get pos");
        assert_eq!(position, at(60.0, "/1 2 get pos"));
    }

    #[test]
    fn checksums_are_verified_and_given_back() {
        let mut world = World::new(Darkroom::default());
        let mut twin = Controller::new(&world);
        let good = format!("1 0 05 get version:{:02X}", lrc("1 0 05 get version"));
        let reply = talk(&mut twin, &mut world, 0.0, &format!("/{good}"));
        assert!(reply.starts_with("@01 0 05 OK IDLE WR 7.38:"), "{reply}");
        // devices.md: ((sum & FF) ^ FF) + 1.
        let body = reply.trim_start_matches('@').split(':').next().unwrap();
        let sum: u32 = body.bytes().map(u32::from).sum();
        assert_eq!(
            reply.trim_end().rsplit(':').next().unwrap(),
            format!("{:02X}", (((sum & 0xFF) ^ 0xFF) + 1) & 0xFF)
        );
        assert_eq!(talk(&mut twin, &mut world, 0.0, "/1 0 05 get version:00"), "");
        assert_eq!(talk(&mut twin, &mut world, 0.0, "/2 0 get version"), "");
    }

    #[test]
    fn outputs_switch_the_room() {
        let mut world = World::new(Darkroom::default());
        let mut twin = Controller::new(&world);
        assert!(talk(&mut twin, &mut world, 1.0, "/1 0 io set do 1 1").contains("OK"));
        talk(&mut twin, &mut world, 1.0, "/1 0 io set do 2 1");
        assert_eq!(
            talk(&mut twin, &mut world, 2.0, "/1 0 io get do 1"),
            "@01 0 OK IDLE WR 1\r\n"
        );
        assert_eq!(
            world.switches(),
            Switches {
                lamp: true,
                shutter_open: true,
                baffle_in: false
            }
        );
        let volt = talk(&mut twin, &mut world, 2.0, "/1 0 io get ai 1");
        let volt: f64 = volt.trim().rsplit(' ').next().unwrap().parse().unwrap();
        assert!((volt * 15.0 - 50.0 - 24.0).abs() < 0.2, "{volt}");
    }
}
