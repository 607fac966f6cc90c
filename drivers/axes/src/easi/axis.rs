//! One drive as an axis.

use async_trait::async_trait;
use isolux_device::{AxisPosition, AxisSettings, Coordinate, DeviceError, Identity};
use isolux_protocol_easi::{Bits, status};
use tokio::time::Instant;

use super::drive::Indexer;
use crate::polled::{AxisDriver, AxisStatus, fault, in_use};

/// The drive keeps no word on whether it has a reference. The in-position time is set to this many ms once it has been
/// found, and is another one after power-on: a drive that has it and whose motor never lost its current knows where it
/// is.
const HOMED_IT: &str = "13";

/// Range and unit of V (rev/s), and of AA and AD (rev/s²): user guide, pages 93 and 129.
const SPEED: (f64, f64, f64) = (0.01, 50.0, 0.01);
const ACCELERATION: (f64, f64, f64) = (0.1, 1023.9, 0.1);

pub(crate) struct Xli<P> {
    indexer: Indexer,
    settings: AxisSettings<P>,
    home: Option<String>,
    tolerance_steps: u64,
    /// Speed and acceleration as the drive is told them.
    dynamics: [String; 2],
}

impl<P: Coordinate> Xli<P> {
    /// Sets speed and ramps. Moves nothing, and leaves the current as it is.
    pub async fn open(
        indexer: Indexer,
        settings: AxisSettings<P>,
        home: Option<String>,
        tolerance_steps: u64,
    ) -> Result<Self, DeviceError> {
        let stated = indexer.twice("R(MR)").await?;
        let Some(steps_per_rev) = stated.value.parse().ok().filter(|steps: &u32| *steps > 0) else {
            return Err(indexer.malformed(
                "R(MR)",
                format!("\"{}\" is no number of steps", stated.value),
                stated.frame,
            ));
        };
        let rev_per_unit = settings.scale().steps_per_unit() / f64::from(steps_per_rev);
        let mut dynamics = [String::new(), String::new()];
        let mut actual = [0.0; 2];
        for (at, (key, wanted, (least, most, unit))) in [
            (P::KEYS[2], settings.speed(), SPEED),
            (P::KEYS[3], settings.acceleration(), ACCELERATION),
        ]
        .into_iter()
        .enumerate()
        {
            // Down to a whole number of units, never faster than the station allows; the small part forgives the
            // division.
            let units = (wanted * rev_per_unit / unit + 1e-6).floor();
            if !(least..=most + 1e-9).contains(&(units * unit)) {
                return Err(DeviceError::unsupported(
                    indexer.name(),
                    format!("use {key} = {wanted}"),
                    format!("this drive can do {} to {}", least / rev_per_unit, most / rev_per_unit),
                ));
            }
            dynamics[at] = format!("{:.*}", if unit < 0.05 { 2 } else { 1 }, units * unit);
            actual[at] = units * unit / rev_per_unit;
        }
        let axis = Self {
            settings: in_use(indexer.name(), &settings, actual)?,
            indexer,
            home,
            tolerance_steps,
            dynamics,
        };
        axis.set_dynamics().await?;
        Ok(axis)
    }

    async fn set_dynamics(&self) -> Result<(), DeviceError> {
        let [speed, acceleration] = &self.dynamics;
        for (name, value) in [("VS", "0"), ("V", speed), ("AA", acceleration), ("AD", acceleration)] {
            self.indexer.set(name, value).await?;
        }
        Ok(())
    }

    /// The motor has current; the drive is set up anew where it takes a reset to get there.
    async fn energise(&self) -> Result<(), DeviceError> {
        if self.bits().await?.0.has(status::ENERGISED) {
            return Ok(());
        }
        self.indexer.say("ON").await?;
        if self.bits().await?.0.has(status::ENERGISED) {
            return Ok(());
        }
        tracing::warn!(
            device = self.indexer.name(),
            "the motor gets no current: the drive is reset"
        );
        self.indexer.reset().await?;
        self.set_dynamics().await?;
        self.indexer.say("ON").await?;
        let (status, frame) = self.bits().await?;
        if status.has(status::ENERGISED) {
            return Ok(());
        }
        let faults = self.indexer.drive_faults().await?;
        let reason = faults.unwrap_or_else(|| "the motor gets no current".to_owned());
        Err(fault(self.indexer.name(), "ON", reason, frame))
    }

    async fn bits(&self) -> Result<(Bits, Vec<u8>), DeviceError> {
        self.indexer.bits("R(ST)").await
    }
}

#[async_trait]
impl<P: Coordinate> AxisDriver<P> for Xli<P> {
    fn identity(&self) -> &Identity {
        self.indexer.identity()
    }

    fn settings(&self) -> &AxisSettings<P> {
        &self.settings
    }

    fn tolerance_steps(&self) -> u64 {
        self.tolerance_steps
    }

    /// Status first, then position: an axis that had come to rest is where the second answer says.
    async fn status(&self) -> Result<AxisStatus<P>, DeviceError> {
        let before = self.indexer.unsolicited();
        let (status, mut frame) = self.bits().await?;
        let (steps, position) = self.indexer.steps().await?;
        let at = Instant::now();
        frame.extend(position);
        let energised = status.has(status::ENERGISED);
        let settling = energised && !status.has(status::STATIONARY);
        let moving = status.has(status::MOVING) || status.has(status::HOMING) || settling;
        // On its way an axis has had its power all the time; at rest the mark tells.
        let homed = energised && (moving || self.indexer.report("R(IT)").await?.value == HOMED_IT);
        let program = status.has(status::PROGRAM) || status.has(status::PAUSED);
        let fault = if program {
            Some("a program of the drive's own is running: clear it (K, ARM0, SV)".to_owned())
        } else if energised {
            None
        } else {
            self.indexer.drive_faults().await?
        };
        let limit = |bit, name: &str| status.has(bit).then(|| format!("{name} limit switch"));
        let steps = i64::from(steps);
        let position = AxisPosition {
            place: self.settings.scale().place(steps),
            steps,
            moving,
            homed,
            at,
        };
        Ok(AxisStatus {
            fault,
            obstacle: limit(status::NEGATIVE_LIMIT, "negative").or_else(|| limit(status::POSITIVE_LIMIT, "positive")),
            ..AxisStatus::new((before, self.indexer.unsolicited()), position, frame)
        })
    }

    async fn go(&self, steps: i32) -> Result<(), DeviceError> {
        let (status, frame) = self.bits().await?;
        if status.has(status::MOVING) {
            let reason = "it is still moving, and takes no other target until it rests";
            return Err(fault(self.indexer.name(), "G", reason, frame));
        }
        self.indexer.set("D", &steps.to_string()).await?;
        let (faults, reply) = self.indexer.say("G").await?;
        // Asked again because the first answer was lost, the drive is "still moving" to the target that was read back.
        let still_moving = faults.numbers().eq([14]);
        if (faults.is_empty() || still_moving) && !reply.answer.refused {
            return Ok(());
        }
        Err(self.indexer.refused("G", faults, reply.bytes))
    }

    async fn go_home(&self) -> Result<(), DeviceError> {
        self.energise().await?;
        // Until the switch has been found again there is no reference.
        self.indexer.command("W(IT,10)").await?;
        if let Some(home) = &self.home {
            self.indexer.command(&format!("HOME1({home})")).await?;
        }
        self.indexer.command("ARM1").await?;
        let (faults, reply) = self.indexer.say("GH").await?;
        if faults.numbers().all(|number| number == 14) && !reply.answer.refused {
            return Ok(());
        }
        Err(self.indexer.refused("GH", faults, reply.bytes))
    }

    async fn at_home(&self, _: i64, _: bool) -> Result<(), DeviceError> {
        // Without clearing: bit 6 homing failed; 7, a narrow switch, is a warning.
        let stated = self.indexer.twice("R(UF1)").await?;
        let failed = matches!(stated.value.as_bytes(), [_, _, _, _, _, b'1', ..]);
        if stated.value.len() != 8 || failed {
            let reason = format!("homing failed, user faults {}", stated.value);
            return Err(fault(self.indexer.name(), "GH", reason, stated.frame));
        }
        let (steps, frame) = self.indexer.steps().await?;
        if i64::from(steps).unsigned_abs() > self.tolerance_steps {
            let reason = format!("it came to rest at {steps}; the reference is 0");
            return Err(fault(self.indexer.name(), "GH", reason, frame));
        }
        self.indexer.command(&format!("W(IT,{HOMED_IT})")).await
    }

    async fn brake(&self) -> Result<(), DeviceError> {
        self.indexer.say("S").await.map(|_| ())
    }

    async fn cut(&self) -> Result<(), DeviceError> {
        self.indexer.say("K").await.map(|_| ())
    }
}
