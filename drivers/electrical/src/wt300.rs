//! Yokogawa WT310 to WT333 over Modbus/TCP: `yokogawa-wt300:modbus-tcp://192.168.1.6:502`.
//!
//! The communication output items are read, single precision, high word first: U, I, P, S, Q and λ of element 1, which
//! are the first six as the meter is delivered (IM WT310-17EN, page 9-7). Were they changed, the values contradict each
//! other (|P| above U·I, λ not P ÷ U·I) and are refused.

use std::sync::Arc;
use std::time::Duration;

use async_trait::async_trait;
use isolux_device::{
    DeviceError, Factories, Identity, Kind, OpenError, PowerMeter, PowerMeterFactory, PowerReading, Target,
};
use isolux_modbus::{ANSWER, Table, Unit};
use isolux_protocol_scpi::Reading;
use isolux_transport::{BusError, Driver, LineSettings, Parity, Ports, no_display};
use tokio::sync::Mutex;
use tokio::time::{Instant, sleep};

use crate::exchange::{Exchange, GUARD, Source, confirmed};

const NAME: &str = "yokogawa-wt300";

/// Input register 2001 by its number on the wire.
const FIRST: u16 = 0x07D0;

/// Two registers an item.
const REGISTERS: u16 = 12;

const ACTION: &str = "read items 1 to 6";

/// Of a serial bridge; the meter itself has no Modbus on its serial line.
const LINE: LineSettings = LineSettings {
    baud: 9600,
    data_bits: 8,
    parity: Parity::None,
    stop_bits: 1,
};

/// WT300 and WT300E over Modbus/TCP.
pub const YOKOGAWA_WT300: Driver = Driver {
    name: NAME,
    speaks_to: "Yokogawa WT310–WT333, WT310E–WT333E, Modbus/TCP",
    examples: &[(Kind::PowerMeter, "yokogawa-wt300:modbus-tcp://192.168.1.6:502")],
    seen_with: "🧪 its virtual twin",
    usb: &[],
    // The register map has no identity.
    identify: &[],
    place: |target, _| {
        update(target)?;
        isolux_modbus::place(target, LINE)
    },
    display_lx: no_display,
    factories: |ports| Factories {
        power_meter: Some(Arc::new(Wt300Driver { ports })),
        ..Factories::default()
    },
};

/// The meter's update interval, 0.1 s to 20 s: what its display is set to.
fn update(target: &Target) -> Result<Duration, OpenError> {
    target.only(&["unit", "update_s"])?;
    match target.number("update_s", 0.25) {
        Ok(seconds) if (0.1..=20.0).contains(&seconds) => Ok(Duration::from_secs_f64(seconds)),
        Ok(seconds) => Err(target.wrong(format!("update_s={seconds} is not 0.1 to 20"))),
        Err(error) => Err(error),
    }
}

struct Wt300Driver {
    ports: Arc<Ports>,
}

#[async_trait]
impl PowerMeterFactory for Wt300Driver {
    async fn open_power_meter(&self, target: &Target) -> Result<Box<dyn PowerMeter>, OpenError> {
        let meter = Wt300 {
            update: update(target)?,
            unit: Unit::open(&self.ports, target, LINE).await?,
            identity: Identity {
                driver: NAME,
                target: target.to_string(),
                model: "Yokogawa WT300".to_owned(),
                // The register map has none of them.
                serial: None,
                firmware: None,
            },
            requested: Mutex::default(),
        };
        // Whether it is there and has the registers.
        meter.put_in_step().await?;
        Ok(Box::new(meter))
    }
}

struct Wt300 {
    unit: Unit,
    identity: Identity,
    update: Duration,
    /// When the last reading was asked for.
    requested: Mutex<Option<Instant>>,
}

#[async_trait]
impl Source for Wt300 {
    fn name(&self) -> &str {
        self.unit.name()
    }

    fn query(&self) -> &str {
        ACTION
    }

    fn update(&self) -> Duration {
        self.update
    }

    async fn exchange(&self, deadline: Instant) -> Result<Exchange, DeviceError> {
        let during = |error: BusError| error.during(self.name(), ACTION);
        let request = self.unit.request(Table::Input.ask(FIRST, REGISTERS), ACTION)?;
        let line = self.unit.bus().exclusive(deadline).await.map_err(during)?;
        let unsolicited = self.unit.unsolicited();
        let exchanged = line.exchange(request, ANSWER, deadline).await.map_err(during)?;
        let times = (exchanged.sent, Instant::now());
        // A bridge to RTU numbers nothing: a second answer would be to this request, the first to an earlier one.
        sleep(GUARD).await;
        let registers = self.unit.registers(exchanged.answer, ACTION)?;
        let malformed = |reason: String| {
            let frame = registers.frame.clone();
            during(BusError::Malformed { reason, frame })
        };
        if self.unit.unsolicited() != unsolicited {
            return Err(malformed(
                "more bytes arrived than the answer to one request".to_owned(),
            ));
        }
        let item = |number: usize| match registers.words.get(2 * number..2 * number + 2) {
            Some([high, low]) => Reading::of_single(u32::from(*high) << 16 | u32::from(*low)),
            _ => Reading::NoData,
        };
        let values = [item(0), item(1), item(2), item(5)];
        Exchange::of(values, times, self.update, registers.frame.clone()).map_err(malformed)
    }

    async fn put_in_step(&self) -> Result<(), DeviceError> {
        // Another number of registers: no late answer to a reading looks like it.
        self.unit.read(Table::Input, FIRST, 2, "read item 1").await.map(drop)
    }
}

#[async_trait]
impl PowerMeter for Wt300 {
    fn identity(&self) -> &Identity {
        &self.identity
    }

    fn update_interval(&self) -> Duration {
        self.update
    }

    async fn read(&self, not_before: Instant, deadline: Instant) -> Result<PowerReading, DeviceError> {
        confirmed(self, &self.requested, not_before, deadline).await
    }
}
