//! Two Oriental Motor AZ drives on one RS-485 line: unit 1 turns C, unit 2 turns γ. Registers after the manual
//! HM-60262E as public drivers cite it.
//!
//! A drive's steps are the room's microsteps. The inputs R-IN0 to 15 are assigned as the maker does, except that ZHOME
//! searches the home sensor: at power-up no home position is set. A command that the drive cannot follow is
//! acknowledged and ignored, without an alarm.

use std::collections::BTreeMap;

use isolux_darkroom::Instrument;
use isolux_darkroom::noise::{Noise, Stream};
use isolux_transport::{LineSettings, Parity};

use crate::modbus::{Exception, Query, Wanted, take};
use crate::twin::{Answer, Twin, TwinKind};
use crate::world::{AxisName, World};

/// In the table of twins.
pub(crate) const TWIN: TwinKind = TwinKind {
    instrument: Instrument::Axes,
    driver: "oriental-az",
    line: LineSettings {
        baud: 115_200,
        data_bits: 8,
        parity: Parity::Even,
        stop_bits: 1,
    },
    opens: &[("axis.c", "?unit=1"), ("axis.gamma", "?unit=2")],
    sweeps: None,
    noise_lx: None,
    calibration: None,
    start: |world| Box::new(AzLine::new(world)),
};

/// Eleven bits a byte (8E1) at 115200 baud, s.
const BYTE_S: f64 = 11.0 / 115_200.0;
/// From the end of a request to the first byte of its answer, s.
const LATENCY_S: f64 = 0.003;

const DIRECT: u16 = 0x0058;
const TRIGGER: u16 = 0x0066;
const INPUTS: u16 = 0x007C;
const ALARM: u16 = 0x0080;
const OUTPUTS: u16 = 0x0178;
const ALARM_RESET: u16 = 0x0180;
const LIMITS: u16 = 0x0386;

/// Alarm codes.
const DEVIATION: u16 = 0x10;
const OVERHEAT: u16 = 0x21;
const SOFTWARE_LIMIT: u16 = 0x67;
const OPERATION_DATA: u16 = 0x70;

/// The line.
pub(crate) struct AzLine {
    drives: [Drive; 2],
    seed: u64,
    reads: u64,
}

/// One drive.
struct Drive {
    axis: AxisName,
    /// Registers that can be written.
    registers: BTreeMap<u16, u16>,
    /// Counter = true microsteps − this.
    offset: f64,
    /// When homing ends; the coordinates are set from then on.
    referenced_from_s: Option<f64>,
    /// Nothing has moved it since it was homed.
    at_home: bool,
    /// A code, and from when on.
    alarm: Option<(u16, f64)>,
}

impl AzLine {
    /// The drives at power-up: no home position.
    pub fn new(world: &World) -> Self {
        Self {
            drives: [AxisName::C, AxisName::Gamma].map(|name| Drive::new(name, world)),
            seed: world.room().document().seed,
            reads: 0,
        }
    }

    fn answer(&mut self, query: &Query, world: &mut World, now_s: f64) -> Vec<u8> {
        let Some(drive) = self.drives.get_mut(usize::from(query.unit).wrapping_sub(1)) else {
            return Vec::new();
        };
        match query.wanted() {
            _ if query.function == 4 => query.refused(Exception::Function),
            Err(exception) => query.refused(exception),
            Ok(Wanted::Read { from, count }) => {
                self.reads += 1;
                let noise = Noise::new(self.seed, Stream::Encoder).normal(self.reads, drive.axis as u32);
                let words: Option<Vec<u16>> = (0..count)
                    .map(|n| drive.word(from.checked_add(n)?, noise, world, now_s))
                    .collect();
                words.map_or_else(|| query.refused(Exception::Address), |words| query.registers(&words))
            }
            Ok(Wanted::Write { from, values }) => match drive.write(from, &values, world, now_s) {
                Ok(()) => query.written(),
                Err(exception) => query.refused(exception),
            },
        }
    }
}

impl Drive {
    fn new(name: AxisName, world: &World) -> Self {
        let axis = world.axis(name);
        let mut drive = Self {
            axis: name,
            registers: BTreeMap::new(),
            offset: axis.motion.position(0.0),
            referenced_from_s: None,
            at_home: false,
            alarm: None,
        };
        for at in (DIRECT..0x6A)
            .chain(INPUTS..INPUTS + 2)
            .chain(ALARM_RESET..ALARM_RESET + 2)
        {
            drive.registers.insert(at, 0);
        }
        // Direct data as they are at power-on; at a software limit the drive stops with an alarm (3).
        for (at, value) in [
            (0x5A, 2),
            (0x5E, 1000),
            (0x60, 1_000_000),
            (0x62, 1_000_000),
            (0x64, 1000),
            (LIMITS, 3),
            (LIMITS + 2, axis.limit[1] as i32),
            (LIMITS + 4, axis.limit[0] as i32),
        ] {
            drive.set_long(at, value);
        }
        drive
    }

    fn set_long(&mut self, at: u16, value: i32) {
        self.registers.insert(at, (value >> 16) as u16);
        self.registers.insert(at + 1, value as u16);
    }

    fn long(&self, at: u16) -> i32 {
        let word = |at: u16| u32::from(self.registers.get(&at).copied().unwrap_or_default());
        (word(at) << 16 | word(at + 1)) as i32
    }

    fn alarm(&self, now_s: f64) -> u16 {
        self.alarm
            .filter(|(_, from_s)| *from_s <= now_s)
            .map_or(0, |(code, _)| code)
    }

    fn referenced(&self, now_s: f64) -> bool {
        self.referenced_from_s.is_some_and(|from_s| from_s <= now_s)
    }

    fn input(&self, bit: u16) -> bool {
        self.long(INPUTS) >> bit & 1 == 1
    }

    /// Internal output signals: 144 to 159 in the upper word, 128 to 143 in the lower.
    fn outputs(&self, world: &World, now_s: f64) -> u32 {
        let moving = world.axis(self.axis).motion.moving(now_s);
        let alarm = self.alarm(now_s) != 0;
        let referenced = self.referenced(now_s);
        let signals = [
            (129, alarm),
            (130, !alarm),
            (131, true),
            (132, !moving && !alarm && !self.input(5) && !self.input(6)),
            (134, moving),
            (138, !moving),
            (144, referenced && self.at_home),
            (145, referenced),
        ];
        let bit = |code: u32| if code < 144 { code - 128 } else { code - 144 + 16 };
        signals
            .iter()
            .fold(0, |bits, (code, on)| bits | u32::from(*on) << bit(*code))
    }

    /// One register; none where there is none.
    fn word(&self, at: u16, noise: f64, world: &World, now_s: f64) -> Option<u16> {
        if let Some(value) = self.registers.get(&at) {
            return Some(*value);
        }
        let axis = world.axis(self.axis);
        let command = axis.motion.position(now_s) - self.offset;
        let document = &world.room().document().axis;
        let encoder_deg = match self.axis {
            AxisName::C => document.c.encoder_noise_deg,
            _ => document.gamma.encoder_noise_deg,
        };
        let detected = command + encoder_deg * axis.counts_per_unit * noise;
        let value = match at & !1 {
            ALARM => self.alarm(now_s).into(),
            0xC6 | 0x122 => command.round() as i32,
            0xC8 | 0xCA | 0xCE | 0xD0 => axis.motion.velocity(now_s).round() as i32,
            0xCC | 0x120 => detected.round() as i32,
            OUTPUTS => self.outputs(world, now_s) as i32,
            _ => return None,
        };
        Some(if at.is_multiple_of(2) {
            (value >> 16) as u16
        } else {
            value as u16
        })
    }

    fn write(&mut self, from: u16, values: &[u16], world: &mut World, now_s: f64) -> Result<(), Exception> {
        let to = from.checked_add(values.len() as u16).ok_or(Exception::Address)?;
        if (from..to).any(|at| !self.registers.contains_key(&at)) {
            return Err(Exception::Address);
        }
        let (zhome, reset) = (self.input(4), self.long(ALARM_RESET));
        for (at, value) in (from..to).zip(values) {
            self.registers.insert(at, *value);
        }
        if self.input(5) && world.axis(self.axis).motion.moving(now_s) {
            self.brake(world, now_s);
        }
        if self.input(4) && !zhome {
            self.home(world, now_s);
        }
        if (reset, self.long(ALARM_RESET)) == (0, 1) {
            self.alarm = None;
        }
        // Trigger 1 starts with the write that holds the trigger itself.
        if (from..to).contains(&(TRIGGER + 1)) && self.long(TRIGGER) == 1 {
            self.start(world, now_s);
        }
        Ok(())
    }

    fn able(&self, now_s: f64) -> bool {
        self.alarm(now_s) == 0 && !self.input(5) && !self.input(6)
    }

    fn brake(&mut self, world: &mut World, now_s: f64) {
        let axis = world.axis_mut(self.axis);
        let braked = axis.motion.stop(now_s, axis.top_acceleration);
        axis.drive(braked, now_s);
        self.referenced_from_s = self.referenced_from_s.filter(|from_s| *from_s <= now_s);
        self.alarm = self.alarm.filter(|(_, from_s)| *from_s <= now_s);
    }

    fn home(&mut self, world: &mut World, now_s: f64) {
        if !self.able(now_s) {
            return;
        }
        let axis = world.axis_mut(self.axis);
        let motion = axis
            .motion
            .move_to(0.0, now_s, 0.5 * axis.top_speed, axis.top_acceleration);
        self.referenced_from_s = Some(motion.end_s().max(now_s));
        (self.offset, self.at_home) = (0.0, true);
        axis.drive(motion, now_s);
    }

    /// Direct data operation.
    fn start(&mut self, world: &mut World, now_s: f64) {
        if !self.able(now_s) {
            return;
        }
        let [kind, position, speed, rate] = [0x5A, 0x5C, 0x5E, 0x60].map(|at| f64::from(self.long(at)));
        if speed == 0.0 {
            self.brake(world, now_s);
            return;
        }
        let axis = world.axis_mut(self.axis);
        let here = axis.motion.position(now_s) - self.offset;
        let wanted = match kind as i32 {
            1 => position,
            2 | 3 => here.round() + position,
            _ => {
                self.alarm = Some((OPERATION_DATA, now_s));
                return;
            }
        };
        if speed < 0.0 || rate < 1.0 {
            self.alarm = Some((OPERATION_DATA, now_s));
            return;
        }
        let limited = self.referenced(now_s) && self.long(LIMITS) >= 0;
        let [reverse, forward] = [LIMITS + 4, LIMITS + 2].map(|at| f64::from(self.long(at)));
        let axis = world.axis_mut(self.axis);
        let target = if limited {
            wanted.clamp(reverse, forward)
        } else {
            wanted
        };
        let (speed, rate) = (speed.min(axis.top_speed), rate.min(axis.top_acceleration));
        let motion = axis.motion.move_to(target + self.offset, now_s, speed, rate);
        if target != wanted {
            self.alarm = Some((SOFTWARE_LIMIT, motion.end_s().max(now_s)));
        }
        axis.drive(motion, now_s);
        self.at_home = false;
    }

    /// Stops short in the middle of a motion that lasts past `from_s`, as an obstacle does.
    fn stall(&mut self, world: &mut World, from_s: f64, now_s: f64) -> bool {
        let axis = world.axis_mut(self.axis);
        let (start_s, end_s) = (axis.motion.start_s(), axis.motion.end_s());
        let hit_s = from_s.max(0.5 * (start_s + end_s));
        if !(hit_s < end_s && hit_s <= now_s) {
            return false;
        }
        let frozen = axis.motion.freeze(hit_s);
        axis.drive(frozen, now_s);
        self.alarm = Some((DEVIATION, hit_s));
        self.referenced_from_s = self.referenced_from_s.filter(|from_s| *from_s <= hit_s);
        true
    }
}

impl Drive {
    /// The main circuit is too hot: the drive stops and lets go of the shaft.
    fn overheat(&mut self, world: &mut World, now_s: f64) {
        let axis = world.axis_mut(self.axis);
        let frozen = axis.motion.freeze(now_s);
        axis.drive(frozen, now_s);
        self.alarm = Some((OVERHEAT, now_s));
        self.referenced_from_s = self.referenced_from_s.filter(|from_s| *from_s <= now_s);
    }
}

impl Twin for AzLine {
    fn receive(&mut self, inbox: &mut Vec<u8>, world: &mut World, now_s: f64) -> Option<Answer> {
        let query = take(inbox)?;
        let bytes = self.answer(&query, world, now_s);
        let line_s = (query.length() + bytes.len()) as f64 * BYTE_S;
        Some(Answer::At(now_s + line_s + LATENCY_S, bytes))
    }

    fn alarm(&mut self, world: &mut World, now_s: f64) {
        for drive in &mut self.drives {
            drive.overheat(world, now_s);
        }
    }

    fn stall(&mut self, world: &mut World, from_s: f64, now_s: f64) -> bool {
        self.drives.iter_mut().any(|drive| drive.stall(world, from_s, now_s))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use isolux_darkroom::Darkroom;

    struct Bench(AzLine, World);

    impl Bench {
        fn new(document: &str) -> Self {
            let world = World::new(Darkroom::parse(document).unwrap());
            Self(AzLine::new(&world), world)
        }

        /// Words of an answer; none for a refusal. MBAP frames: the CRC has its own test.
        fn pdu(&mut self, now_s: f64, unit: u8, pdu: &[u8]) -> Vec<u8> {
            let mut inbox = vec![0, 1, 0, 0, 0, pdu.len() as u8 + 1, unit];
            inbox.extend(pdu);
            match self.0.receive(&mut inbox, &mut self.1, now_s) {
                Some(Answer::At(_, bytes)) => bytes.get(7..).unwrap_or_default().to_vec(),
                _ => panic!(),
            }
        }

        fn long(&mut self, now_s: f64, unit: u8, at: u16) -> i32 {
            let [high, low] = at.to_be_bytes();
            let answer = self.pdu(now_s, unit, &[3, high, low, 0, 2]);
            i32::from_be_bytes([answer[2], answer[3], answer[4], answer[5]])
        }

        fn write(&mut self, now_s: f64, unit: u8, at: u16, longs: &[i32]) {
            let mut pdu = vec![0x10];
            pdu.extend(at.to_be_bytes());
            pdu.extend([0, longs.len() as u8 * 2, longs.len() as u8 * 4]);
            pdu.extend(longs.iter().flat_map(|long| long.to_be_bytes()));
            let answer = self.pdu(now_s, unit, &pdu);
            assert_eq!(answer, pdu[..5], "acknowledged");
        }

        fn has(&mut self, now_s: f64, unit: u8, code: u32) -> bool {
            let bit = if code < 144 { code - 128 } else { code - 144 + 16 };
            self.long(now_s, unit, OUTPUTS) >> bit & 1 == 1
        }
    }

    const MOVE: u32 = 134;
    const QUIET: &str = "[axis.c]\nstart_deg = 30.0\nencoder_noise_deg = 0.0\n[injected_effects]\nonly = true\n";

    #[test]
    fn a_drive_homes_moves_and_reports() {
        let mut bench = Bench::new(QUIET);
        assert_eq!(bench.long(0.0, 1, 0xCC), 0, "the counter begins at power-up");
        assert!(!bench.has(0.0, 1, 145) && bench.has(0.0, 1, 132));
        // Software limits are those of the axis.
        let steps = bench.1.axis(AxisName::C).counts_per_unit;
        assert_eq!(
            f64::from(bench.long(0.0, 1, LIMITS + 2)),
            bench.1.axis(AxisName::C).limit[1]
        );
        bench.write(0.0, 1, INPUTS, &[1 << 4]);
        assert!(bench.has(1.0, 1, MOVE) && !bench.has(1.0, 1, 145));
        assert!(!bench.has(60.0, 1, MOVE) && bench.has(60.0, 1, 144) && bench.has(60.0, 1, 145));
        assert_eq!(bench.long(60.0, 1, 0xCC), 0);
        let target = (10.0 * steps) as i32;
        bench.write(60.0, 1, DIRECT, &[0, 1, target, 100_000, 100_000, 100_000, 1000, 1]);
        assert!(bench.has(60.5, 1, MOVE) && !bench.has(60.5, 1, 144));
        assert_eq!(bench.long(200.0, 1, 0xCC), target);
        assert!((bench.1.axis(AxisName::C).position(200.0) - f64::from(target) / steps).abs() < 1e-9);
        // The other unit has not moved, and a third is not there.
        assert!(!bench.has(60.5, 2, MOVE));
        assert_eq!(bench.pdu(60.5, 3, &[3, 0, 0xCC, 0, 2]), []);
        assert_eq!(bench.pdu(60.5, 1, &[3, 0x30, 0, 0, 2]), [0x83, 2]);
    }

    #[test]
    fn what_it_cannot_do_is_acknowledged_and_ignored() {
        let mut bench = Bench::new(QUIET);
        bench.write(0.0, 1, INPUTS, &[1 << 5]);
        bench.write(1.0, 1, DIRECT, &[0, 1, 5000, 1000, 1000, 1000, 1000, 1]);
        assert!(!bench.has(1.1, 1, MOVE) && bench.long(1.1, 1, ALARM) == 0 && !bench.has(1.1, 1, 132));
        bench.write(2.0, 1, INPUTS, &[0]);
        assert!(bench.has(2.1, 1, 132));
    }

    #[test]
    fn stop_speed_0_and_the_software_limit_end_a_motion() {
        for stop in [&[1 << 5][..], &[]] {
            let mut bench = Bench::new(QUIET);
            bench.write(0.0, 1, DIRECT, &[0, 1, 500_000, 50_000, 100_000, 100_000, 1000, 1]);
            assert!(bench.has(1.0, 1, MOVE));
            if stop.is_empty() {
                bench.write(1.0, 1, DIRECT, &[0, 1, 0, 0, 100_000, 100_000, 1000, 1]);
            } else {
                bench.write(1.0, 1, INPUTS, stop);
            }
            assert!(!bench.has(3.0, 1, MOVE));
            assert_eq!(bench.long(3.0, 1, 0xCC), bench.long(90.0, 1, 0xCC));
        }
        let mut bench = Bench::new(QUIET);
        bench.write(0.0, 1, INPUTS, &[1 << 4]);
        bench.write(60.0, 1, INPUTS, &[0]);
        let end = bench.long(60.0, 1, LIMITS + 2);
        bench.write(
            60.0,
            1,
            DIRECT,
            &[0, 1, end + 1000, 4_000_000, 1_000_000, 1_000_000, 1000, 1],
        );
        assert_eq!(bench.long(60.1, 1, ALARM), 0);
        assert_eq!((bench.long(2000.0, 1, ALARM), bench.long(2000.0, 1, 0xCC)), (0x67, end));
        bench.write(2000.0, 1, ALARM_RESET, &[1]);
        assert_eq!(bench.long(2000.0, 1, ALARM), 0);
    }
}
