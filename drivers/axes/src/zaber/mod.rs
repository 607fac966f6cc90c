//! Zaber controllers in the ASCII language: axes, digital outputs as switches, an analogue input as a thermometer.
//!
//! `zaber:LINK?axis=1` is an axis, `zaber:LINK?do=1` a switch, `zaber:LINK?ai=1&c_at_0v=-50&c_at_10v=100` a 0–10 V
//! temperature transmitter. `device=N` chooses the device of a daisy chain (default 1), `baud=9600` firmware 6 lines
//! (default 115200, firmware 7). All of a port share one conversation.

mod axis;
mod controller;
mod io;

use std::sync::Arc;

use async_trait::async_trait;
use isolux_device::{
    AxisSettings, Coordinate, Factories, Kind, OpenError, Switch, SwitchFactory, Target, Thermometer,
    ThermometerFactory,
};
use isolux_protocol_zaber::Host;
use isolux_transport::{Driver, LineSettings, Parity, Place, Ports, Probe, no_display};

use crate::factory::axis_factory;
use crate::polled::PolledAxis;
use axis::ZaberAxis;
use controller::{Controller, NAME};
use io::{ZaberSwitch, ZaberThermometer};

/// Zaber controllers and what hangs on them.
pub const ZABER: Driver = Driver {
    name: NAME,
    speaks_to: "Zaber axes, firmware 6 and 7",
    examples: &[
        (Kind::Axis, "zaber:/dev/ttyUSB0?axis=1"),
        (Kind::Switch, "zaber:/dev/ttyUSB0?do=1"),
        (Kind::Thermometer, "zaber:/dev/ttyUSB0?ai=1&c_at_0v=-50&c_at_10v=100"),
    ],
    seen_with: "🧪 its virtual twin; zaber-motion 10.2.0",
    usb: &[],
    identify: &[identify(115_200), identify(9600)],
    place: |target, kind| Ok(Address::parse(target, kind)?.place),
    display_lx: no_display,
    factories: |ports| {
        let driver = Arc::new(ZaberDriver::new(ports));
        Factories {
            axis: Some(driver.clone()),
            switch: Some(driver.clone()),
            thermometer: Some(driver),
            ..Factories::default()
        }
    },
};

/// `get device.id` of all devices of a chain, at the speed of firmware 7 or 6.
const fn identify(baud: u32) -> Probe {
    Probe {
        line: LineSettings {
            baud,
            data_bits: 8,
            parity: Parity::None,
            stop_bits: 1,
        },
        request: b"\n/get device.id\n",
        read: |bytes| {
            let text = std::str::from_utf8(bytes).ok()?;
            let reply = text
                .lines()
                .find(|line| line.starts_with('@') && line.contains(" OK "))?;
            let device = reply.get(1..3)?;
            let id = reply.split([' ', ':']).nth(5)?;
            Some(format!("Zaber controller, device {device}, id {id}"))
        },
    }
}

/// Opens what hangs on Zaber controllers.
pub struct ZaberDriver {
    ports: Arc<Ports>,
}

/// A target in the words of the language.
struct Address {
    device: u8,
    /// Of the axis, the output or the input.
    number: u8,
    /// °C at 0 V and at 10 V.
    scale: (f64, f64),
    place: Place,
}

impl Address {
    fn parse(target: &Target, kind: Kind) -> Result<Self, OpenError> {
        let (key, default, thing): (&str, u8, &str) = match kind {
            Kind::Axis => ("axis", 1, "axis"),
            Kind::Switch => ("do", 0, "output"),
            _ => ("ai", 0, "input"),
        };
        let own: &[&str] = if key == "ai" { &["c_at_0v", "c_at_10v"] } else { &[] };
        target.only(&[&[key], own, &["device", "baud"]].concat())?;
        let device = target.number("device", 1_u8)?;
        if !(1..=99).contains(&device) {
            return Err(target.wrong(format!("device={device} is not 1 to 99")));
        }
        let number = target.number(key, default)?;
        if kind == Kind::Axis && !(1..=9).contains(&number) {
            return Err(target.wrong(format!("axis={number} is not 1 to 9")));
        }
        let scale = (
            target.number("c_at_0v", f64::NAN)?,
            target.number("c_at_10v", f64::NAN)?,
        );
        if kind == Kind::Switch && number == 0 {
            return Err(target.wrong("a switch needs do=N, the number of a digital output"));
        }
        let scaled = scale.0.is_finite() && scale.1.is_finite() && scale.0 != scale.1;
        if kind == Kind::Thermometer && (number == 0 || !scaled) {
            return Err(target.wrong("a thermometer needs ai=N, and c_at_0v and c_at_10v of its transmitter"));
        }
        let line = LineSettings {
            baud: target.number("baud", 115_200)?,
            data_bits: 8,
            parity: Parity::None,
            stop_bits: 1,
        };
        let channel = format!("{thing} {number} of device {device}");
        Ok(Self {
            device,
            number,
            scale,
            place: Place { channel, line },
        })
    }
}

impl ZaberDriver {
    /// A driver of what is on `ports`.
    pub const fn new(ports: Arc<Ports>) -> Self {
        Self { ports }
    }

    /// The controller that `target` names.
    async fn controller(&self, target: &Target, address: &Address) -> Result<Controller, OpenError> {
        let bus = self.ports.bus(target, address.place.line, Host::default).await?;
        Ok(Controller::open(bus, address.device, target).await?)
    }

    async fn axis<P: Coordinate>(
        &self,
        target: &Target,
        settings: AxisSettings<P>,
    ) -> Result<PolledAxis<P, ZaberAxis<P>>, OpenError> {
        let address = Address::parse(target, Kind::Axis)?;
        let controller = self.controller(target, &address).await?;
        Ok(PolledAxis::new(
            ZaberAxis::open(controller, address.number, settings).await?,
        ))
    }
}

axis_factory!(ZaberDriver);

#[async_trait]
impl SwitchFactory for ZaberDriver {
    async fn open_switch(&self, target: &Target) -> Result<Box<dyn Switch>, OpenError> {
        let address = Address::parse(target, Kind::Switch)?;
        let controller = self.controller(target, &address).await?;
        Ok(Box::new(ZaberSwitch::new(controller, address.number)))
    }
}

#[async_trait]
impl ThermometerFactory for ZaberDriver {
    async fn open_thermometer(&self, target: &Target) -> Result<Box<dyn Thermometer>, OpenError> {
        let address = Address::parse(target, Kind::Thermometer)?;
        let controller = self.controller(target, &address).await?;
        Ok(Box::new(ZaberThermometer::new(
            controller,
            address.number,
            address.scale,
        )))
    }
}
