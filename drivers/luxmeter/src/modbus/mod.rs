//! Any lux meter on Modbus, by a profile: `modbus-lux:LINK?profile=rs485-u32&unit=1`.
//!
//! `profile` is the name of one that comes with the program, or the path of a TOML file, from the folder of the station
//! file.
//!
//! The meter converts all the time, and a request gets the latest value: light of the update interval and the
//! integration before the request. What an answer is believed for is said in `confirmed.rs`. On a line in doubt the
//! meter is asked for another number of registers: neither the answer to that nor an exception can be a reading that
//! comes late. A meter that does not answer such a request is left to the silence after a failure alone; opening finds
//! that out.

mod profile;

use std::sync::Arc;
use std::time::Duration;

use async_trait::async_trait;
use isolux_device::{
    DeviceError, ErrorKind, Factories, Identity, Kind, LuxMeter, LuxMeterFactory, LuxMeterProperties, LuxOutcome,
    LuxRange, LuxReading, OpenError, Target,
};
use isolux_modbus::{ANSWER, Modbus, Unit};
use isolux_transport::{Alone, Bus, Driver, LineSettings, Parity, Ports, Probe};
use isolux_units::Lux;
use tokio::time::Instant;

use crate::confirmed::{Confirmed, Meter, Pace, one_range};
use profile::{Meaning, Profile};

const NAME: &str = "modbus-lux";

/// The true answer to a request that an old one seemed to answer has come within this.
const GUARD: Duration = Duration::from_millis(100);

/// For the first proof, silence of the line before included.
const OPENING: Duration = Duration::from_secs(10);

/// Lux meters on Modbus.
pub const MODBUS_LUX: Driver = Driver {
    name: NAME,
    speaks_to: "lux meters on Modbus by a profile",
    examples: &[(Kind::LuxMeter, "modbus-lux:/dev/ttyUSB0?profile=rs485-u32&unit=1")],
    seen_with: "🧪 its virtual twin; pymodbus 3.16.1, mbpoll; a published exchange",
    usb: &[],
    identify: &[Probe {
        line: LineSettings {
            baud: 9600,
            data_bits: 8,
            parity: Parity::None,
            stop_bits: 1,
        },
        // Holding registers 0007h and 0008h of unit 1.
        request: &[0x01, 0x03, 0x00, 0x07, 0x00, 0x02, 0x75, 0xCA],
        read: isolux_modbus::unit_of,
    }],
    place: |target, _| isolux_modbus::place(target, profile(target)?.line),
    display_lx: |target| {
        let known = profile(target).ok();
        known
            .map(|profile| (profile.range_lx.1, profile.resolution_lx))
            .into_iter()
            .collect()
    },
    factories: |ports| Factories {
        lux_meter: Some(Arc::new(ModbusLuxDriver::new(ports))),
        ..Factories::default()
    },
};

fn profile(target: &Target) -> Result<Profile, OpenError> {
    target.only(&["profile", "unit"])?;
    Profile::of(target)
}

/// Opens lux meters on Modbus.
pub struct ModbusLuxDriver {
    ports: Arc<Ports>,
}

impl ModbusLuxDriver {
    /// A driver of what is on `ports`.
    pub const fn new(ports: Arc<Ports>) -> Self {
        Self { ports }
    }
}

#[async_trait]
impl LuxMeterFactory for ModbusLuxDriver {
    async fn open_lux_meter(&self, target: &Target) -> Result<Box<dyn LuxMeter>, OpenError> {
        let profile = profile(target)?;
        let identity = Identity {
            driver: NAME,
            target: target.to_string(),
            model: profile.model.clone(),
            // A profile knows one register.
            serial: None,
            firmware: None,
        };
        let mut meter = ModbusLux {
            unit: Unit::open(&self.ports, target, profile.line).await?,
            identity,
            properties: LuxMeterProperties {
                range_full_scale: Lux::new(profile.range_lx.1).into_iter().collect(),
                update_interval: profile.update_interval,
                integration: profile.integration,
            },
            profile,
            proves: true,
            confirmed: Confirmed::default(),
        };
        // A first reading, of any light, says whether the meter is there and has the register.
        let (from, count) = (meter.profile.register, meter.profile.encoding.number.registers());
        meter.unit.read(meter.profile.table, from, count, "read").await?;
        match meter.put_in_step(Instant::now() + OPENING).await {
            Err(error) if error.kind() == ErrorKind::Timeout => {
                tracing::warn!(%error, "answers of this meter that are late by more than the silence cannot be told apart");
                meter.proves = false;
            }
            proved => proved?,
        }
        meter.confirmed.in_service(&meter).await;
        Ok(Box::new(meter))
    }
}

struct ModbusLux {
    unit: Unit,
    identity: Identity,
    properties: LuxMeterProperties,
    profile: Profile,
    /// It answers a request for another number of registers.
    proves: bool,
    confirmed: Confirmed,
}

#[async_trait]
impl Meter for ModbusLux {
    type Language = Modbus;

    fn bus(&self) -> &Bus<Modbus> {
        self.unit.bus()
    }

    fn name(&self) -> &str {
        self.unit.name()
    }

    fn pace(&self) -> Pace {
        Pace {
            interval: self.profile.update_interval,
            reach: self.profile.update_interval + self.profile.integration,
            patience: ANSWER,
            guard: GUARD,
        }
    }

    async fn exchange(&self, line: &Alone<'_, Modbus>, deadline: Instant) -> Result<LuxReading, DeviceError> {
        const ACTION: &str = "read";
        let profile = &self.profile;
        let ask = profile.table.ask(profile.register, profile.encoding.number.registers());
        let exchanged = self
            .ask(line, self.unit.request(ask, ACTION)?, ACTION, deadline)
            .await?;
        let ended = Instant::now();
        let registers = self.unit.registers(exchanged.answer, ACTION)?;
        let malformed = |reason: &str| self.malformed(ACTION, reason, registers.frame.clone());
        let outcome = match profile.meaning(&registers.words) {
            Some(Meaning::Lux(lux)) => {
                LuxOutcome::Measured(Lux::new(lux).map_err(|error| malformed(&error.to_string()))?)
            }
            Some(Meaning::OverRange) => LuxOutcome::OverRange,
            Some(Meaning::UnderRange) => LuxOutcome::UnderRange,
            Some(Meaning::Error(reason)) => return Err(self.fault(ACTION, reason, registers.frame)),
            None => return Err(malformed("another number of registers than the type takes")),
        };
        Ok(LuxReading {
            outcome,
            range: 0,
            confirmed_by: None,
            digit: Lux::new(profile.resolution_lx).map_err(|error| malformed(&error.to_string()))?,
            began: exchanged.sent - self.pace().reach,
            ended,
            caution: None,
            retries: 0,
            evidence: registers.frame,
        })
    }

    async fn put_in_step(&self, deadline: Instant) -> Result<(), DeviceError> {
        const ACTION: &str = "put the line in step";
        if !self.proves {
            return Ok(());
        }
        let other = 3 - self.profile.encoding.number.registers();
        let request = self
            .unit
            .request(self.profile.table.ask(self.profile.register, other), ACTION)?;
        let answered = self.unit.bus().ask_within(request, ANSWER, deadline).await;
        answered
            .map(|_| ())
            .map_err(|error| error.during(self.unit.name(), ACTION))
    }
}

#[async_trait]
impl LuxMeter for ModbusLux {
    fn identity(&self) -> &Identity {
        &self.identity
    }

    fn properties(&self) -> &LuxMeterProperties {
        &self.properties
    }

    async fn read(&self, not_before: Instant, deadline: Instant) -> Result<LuxReading, DeviceError> {
        self.confirmed.read(self, not_before, deadline).await
    }

    async fn set_range(&self, range: LuxRange) -> Result<(), DeviceError> {
        one_range(self.unit.name(), range)
    }
}
