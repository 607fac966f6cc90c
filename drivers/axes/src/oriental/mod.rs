//! Oriental Motor AZ drives over Modbus: `oriental-az:LINK?unit=1`.
//!
//! `baud` is that of the drive's switch (default 115200; 8 data bits, even parity). `tolerance` is how many steps off
//! its target an axis may rest (default 2). Several drives share a line. `tcp://host:port` carries RTU through a
//! bridge, `modbus-tcp://host:port` is a gateway.
//!
//! Moves are "direct data operation": type, position, speed and rates in one write that starts at once. Everything is
//! read from registers whose meaning no setting of the drive changes; only the inputs ZHOME and STOP need R-IN4 and
//! R-IN5 as they are set by the maker. Registers after the manual HM-60262E as cited by drivers of others
//! (`docs/src/devices.md` names them).

mod alarm;
mod axis;
mod drive;

use std::sync::Arc;

use isolux_device::{AxisSettings, Coordinate, Factories, Kind, OpenError, Target};
use isolux_modbus::Unit;
use isolux_transport::{Driver, LineSettings, Parity, Place, Ports, Probe, no_display};

use crate::factory::axis_factory;
use crate::polled::PolledAxis;
use axis::AzAxis;
use drive::{Drive, NAME};

/// Oriental Motor AZ.
pub const ORIENTAL_AZ: Driver = Driver {
    name: NAME,
    speaks_to: "Oriental Motor AZ axes, Modbus RTU",
    examples: &[(Kind::Axis, "oriental-az:/dev/ttyUSB0?unit=1")],
    seen_with: "🧪 its virtual twin; pymodbus 3.16.1, RTU and TCP",
    usb: &[],
    identify: &[Probe {
        line: LineSettings {
            baud: 115_200,
            data_bits: 8,
            parity: Parity::Even,
            stop_bits: 1,
        },
        // Holding registers 00CCh and 00CDh of unit 1: the detected position.
        request: &[0x01, 0x03, 0x00, 0xCC, 0x00, 0x02, 0x04, 0x34],
        read: isolux_modbus::unit_of,
    }],
    place: |target, _| Ok(Address::parse(target)?.place),
    display_lx: no_display,
    factories: |ports| Factories {
        axis: Some(Arc::new(OrientalAzDriver::new(ports))),
        ..Factories::default()
    },
};

/// Speeds that the drive's switch offers.
const BAUDS: [u32; 6] = [9600, 19_200, 38_400, 57_600, 115_200, 230_400];

/// Opens AZ drives; those on one line share it.
pub struct OrientalAzDriver {
    ports: Arc<Ports>,
}

/// A target in words of the drive.
struct Address {
    tolerance_steps: u32,
    place: Place,
}

impl Address {
    fn parse(target: &Target) -> Result<Self, OpenError> {
        target.only(&["unit", "baud", "tolerance"])?;
        let baud = target.number("baud", 115_200)?;
        if !BAUDS.contains(&baud) {
            let known: Vec<_> = BAUDS.iter().map(ToString::to_string).collect();
            return Err(target.wrong(format!("baud={baud}: the drive has {}", known.join(", "))));
        }
        let line = LineSettings {
            baud,
            data_bits: 8,
            parity: Parity::Even,
            stop_bits: 1,
        };
        Ok(Self {
            tolerance_steps: target.number("tolerance", 2)?,
            place: isolux_modbus::place(target, line)?,
        })
    }
}

impl OrientalAzDriver {
    /// A driver of what is on `ports`.
    pub const fn new(ports: Arc<Ports>) -> Self {
        Self { ports }
    }

    async fn axis<P: Coordinate>(
        &self,
        target: &Target,
        settings: AxisSettings<P>,
    ) -> Result<PolledAxis<P, AzAxis<P>>, OpenError> {
        let address = Address::parse(target)?;
        let unit = Unit::open(&self.ports, target, address.place.line).await?;
        let drive = Drive::new(unit, target);
        let axis = AzAxis::open(drive, settings, address.tolerance_steps.into()).await?;
        Ok(PolledAxis::new(axis))
    }
}

axis_factory!(OrientalAzDriver);
