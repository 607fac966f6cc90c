//! The drive's registers: what they hold, and asking for them.

use isolux_device::{DeviceError, Identity, Target};
use isolux_modbus::{Registers as Answer, Table, Unit};
use tokio::time::Instant;

use super::alarm;

/// Name of the driver in `open = "oriental-az:…"`.
pub(super) const NAME: &str = "oriental-az";

/// Direct data operation, sixteen registers: data number, type, position, speed, two rates, current, trigger.
const DIRECT: u16 = 0x0058;
/// Its speed in Hz (steps/s), its starting and its stopping rate.
const DIRECT_SPEED: u16 = 0x005E;
/// Its rates, in Hz/s where the drive's unit of acceleration is the default one, 0.001 kHz/s.
const DIRECT_RATES: u16 = 0x0060;
/// Its trigger.
const DIRECT_TRIGGER: u16 = 0x0066;
/// Inputs R-IN0 to 15, in the lower word.
const INPUTS: u16 = 0x007C;
/// Present alarm.
const ALARM: u16 = 0x0080;
/// Command position, two speeds, detected position: one look at all of them.
const POSITIONS: u16 = 0x00C6;
/// Internal output signals 144 to 159 and 128 to 143, whatever the outputs are assigned to.
const OUTPUTS: u16 = 0x0178;
/// Maintenance command that resets the alarm when it goes from 0 to 1.
const ALARM_RESET: u16 = 0x0180;
/// Action at software limits (−1: none), forward limit, reverse limit.
const LIMITS: u16 = 0x0386;

/// R-IN4 and R-IN5 as the maker assigns them.
pub(crate) const ZHOME: u16 = 1 << 4;
pub(crate) const STOP: u16 = 1 << 5;

/// Absolute positioning.
const ABSOLUTE: i32 = 1;
/// Operating current, 0.1 %.
const CURRENT: i32 = 1000;
/// Rates at power-on. A drive that has them again, after others were written, has been without power.
const RATE_AT_POWER_ON: i32 = 1_000_000;

/// Answers to one question within which two in a row must be the same.
const MOST_ANSWERS: usize = 6;

/// Internal output signals.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct Outputs(u32);

impl Outputs {
    const fn has(self, bit: u32) -> bool {
        self.0 >> bit & 1 == 1
    }

    pub const fn home_end(self) -> bool {
        self.has(16)
    }

    /// The coordinates are true (ABSPEN).
    pub const fn coordinates_set(self) -> bool {
        self.has(17)
    }

    pub const fn software_limit(self) -> bool {
        self.has(16 + 9) || self.has(16 + 10)
    }

    pub const fn alarm(self) -> bool {
        self.has(1)
    }

    pub const fn ready(self) -> bool {
        self.has(4)
    }

    pub const fn moving(self) -> bool {
        self.has(6)
    }

    pub const fn in_position(self) -> bool {
        self.has(10)
    }
}

/// Speed and rates in the drive's units.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct Dynamics {
    pub speed_hz: i32,
    pub rate_hz_s: i32,
}

impl Dynamics {
    /// Rounded down to whole units, the rate never being that at power-on; which of the station's `keys` is out of
    /// range.
    pub fn new(keys: [&'static str; 4], speed: f64, rate: f64) -> Result<Self, (&'static str, i32, i32)> {
        let whole = |key, value: f64, most: i32| {
            let value = value.floor();
            if (1.0..=f64::from(most)).contains(&value) {
                Ok(value as i32)
            } else {
                Err((key, 1, most))
            }
        };
        let rate_hz_s = whole(keys[3], rate, 1_000_000_000)?;
        Ok(Self {
            speed_hz: whole(keys[2], speed, 4_000_000)?,
            rate_hz_s: if rate_hz_s == RATE_AT_POWER_ON {
                rate_hz_s - 1
            } else {
                rate_hz_s
            },
        })
    }
}

/// What the registers hold at one moment.
pub(crate) struct Registers {
    pub outputs: Outputs,
    pub alarm: Option<u32>,
    /// Where the drive wants to be.
    pub command_steps: i32,
    /// Where the shaft is.
    pub detected_steps: i32,
    pub at: Instant,
    /// The answer with the positions.
    pub frame: Vec<u8>,
}

impl Registers {
    /// The alarm in words.
    pub fn alarm(&self) -> Option<String> {
        let code = self.alarm?;
        Some(format!("alarm {code:02X}h ({})", alarm::meaning(code)))
    }

    /// That the shaft rests where nothing has sent it, if it does: pushed by hand, or slipped without current.
    pub fn displaced(&self, tolerance_steps: u64) -> Option<String> {
        let (is, wanted) = (self.detected_steps, self.command_steps);
        let off = u64::from(is.abs_diff(wanted)) > tolerance_steps;
        let displaced = !self.outputs.moving() && !self.outputs.in_position() && off;
        displaced.then(|| format!("displaced while stationary: it is at {is}, the drive holds {wanted}"))
    }
}

/// A drive on a line.
pub(crate) struct Drive {
    unit: Unit,
    identity: Identity,
}

impl Drive {
    pub fn new(unit: Unit, target: &Target) -> Self {
        let identity = Identity {
            driver: NAME,
            target: target.to_string(),
            model: "Oriental Motor AZ".to_owned(),
            // The register map that is public has neither.
            serial: None,
            firmware: None,
        };
        Self { unit, identity }
    }

    pub const fn identity(&self) -> &Identity {
        &self.identity
    }

    pub fn name(&self) -> &str {
        self.unit.name()
    }

    pub const fn unit(&self) -> &Unit {
        &self.unit
    }

    /// The inputs, all sixteen at once.
    pub async fn set_inputs(&self, inputs: u16, action: &str) -> Result<(), DeviceError> {
        self.unit.write(INPUTS, vec![0, inputs], action).await
    }

    /// Resets the alarm.
    pub async fn reset_alarm(&self) -> Result<(), DeviceError> {
        for step in [0, 1, 0] {
            self.unit.write(ALARM_RESET, vec![0, step], "reset the alarm").await?;
        }
        Ok(())
    }

    /// Lower and upper limit of the drive's own, if it minds any.
    pub async fn limits(&self) -> Result<Option<(i64, i64)>, DeviceError> {
        let read = self.read_twice(LIMITS, 6, "read the software limits").await?;
        let [action, forward, reverse] = [0, 2, 4].map(|at| long(&read.words, at));
        Ok((action >= 0).then_some((reverse.into(), forward.into())))
    }

    /// Writes speed and rates without starting anything, and reads them back.
    pub async fn set_dynamics(&self, dynamics: Dynamics) -> Result<(), DeviceError> {
        const ACTION: &str = "set speed and rates";
        self.unit.write(DIRECT_TRIGGER, vec![0, 0], ACTION).await?;
        let wanted = words([dynamics.speed_hz, dynamics.rate_hz_s, dynamics.rate_hz_s]);
        self.unit.write(DIRECT_SPEED, wanted.clone(), ACTION).await?;
        let read = self.read_twice(DIRECT_SPEED, 6, ACTION).await?;
        if read.words == wanted {
            Ok(())
        } else {
            Err(self.unit.fault(ACTION, "they read back otherwise", read.frame))
        }
    }

    /// Starts a move to `steps` at once.
    pub async fn go(&self, steps: i32, speed_hz: i32, rate_hz_s: i32, action: &str) -> Result<(), DeviceError> {
        let data = words([0, ABSOLUTE, steps, speed_hz, rate_hz_s, rate_hz_s, CURRENT, 1]);
        self.unit.write(DIRECT, data, action).await
    }

    /// Outputs first, then positions: an axis that had come to rest is where the second answer says.
    pub async fn registers(&self) -> Result<Registers, DeviceError> {
        let read = |from, count, action| self.unit.read(Table::Holding, from, count, action);
        let outputs = read(OUTPUTS, 2, "read the outputs").await?;
        let outputs = Outputs(long(&outputs.words, 0) as u32);
        let alarm = if outputs.alarm() {
            Some(long(&read(ALARM, 2, "read the alarm").await?.words, 0) as u32)
        } else {
            None
        };
        let positions = read(POSITIONS, 8, "read the position").await?;
        Ok(Registers {
            outputs,
            alarm,
            command_steps: long(&positions.words, 0),
            detected_steps: long(&positions.words, 6),
            at: Instant::now(),
            frame: positions.frame,
        })
    }

    /// Starting and stopping rate.
    pub async fn rates(&self) -> Result<[i32; 2], DeviceError> {
        let read = self
            .unit
            .read(Table::Holding, DIRECT_RATES, 4, "read the rates")
            .await?;
        Ok([0, 2].map(|at| long(&read.words, at)))
    }

    /// Reads what does not change until two answers in a row are the same: RTU has no request numbers.
    async fn read_twice(&self, from: u16, count: u16, action: &str) -> Result<Answer, DeviceError> {
        let mut unsolicited = self.unit.unsolicited();
        let mut before = self.unit.read(Table::Holding, from, count, action).await?;
        for _ in 1..MOST_ANSWERS {
            let now = self.unit.read(Table::Holding, from, count, action).await?;
            let in_step = std::mem::replace(&mut unsolicited, self.unit.unsolicited()) == unsolicited;
            if in_step && now.words == before.words {
                return Ok(now);
            }
            before = now;
        }
        let reason = format!("of {MOST_ANSWERS} answers no two in a row agree");
        Err(self.unit.malformed(action, &reason, before.frame))
    }
}

/// The 32-bit number at `at`, upper word first.
fn long(words: &[u16], at: usize) -> i32 {
    let [high, low] = [at, at + 1].map(|at| words.get(at).copied().unwrap_or_default());
    (u32::from(high) << 16 | u32::from(low)) as i32
}

/// Upper word first.
fn words<const N: usize>(longs: [i32; N]) -> Vec<u16> {
    longs
        .iter()
        .flat_map(|long| [(*long >> 16) as u16, *long as u16])
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use isolux_device::Coordinate;

    const KEYS: [&str; 4] = <isolux_units::AxisAngle as Coordinate>::KEYS;

    #[test]
    fn dynamics_are_whole_and_never_those_of_power_on() {
        let whole = Dynamics::new(KEYS, 1280.9, 12_800.7).unwrap();
        assert_eq!((whole.speed_hz, whole.rate_hz_s), (1280, 12_800));
        assert_eq!(Dynamics::new(KEYS, 1.0, 1_000_000.5).unwrap().rate_hz_s, 999_999);
        assert_eq!(Dynamics::new(KEYS, 0.9, 1.0), Err(("speed_deg_s", 1, 4_000_000)));
        assert_eq!(Dynamics::new(KEYS, 1.0, 2e9), Err(("accel_deg_s2", 1, 1_000_000_000)));
    }

    #[test]
    fn numbers_are_upper_word_first() {
        assert_eq!(long(&[0xFFFF, 0xFC18], 0), -1000);
        assert_eq!(words([-1000, 9000]), [0xFFFF, 0xFC18, 0, 0x2328]);
    }
}
