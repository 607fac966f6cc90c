//! Parker XLi indexer drives, EASI: `parker-easi:LINK?address=1`.
//!
//! 9600 baud, 8N1; several drives of a daisy chain share a line. `home=+,0,-2,10,1` is what HOME1 takes: edge of the
//! switch, type of the switch (1: normally closed), direction and speed in rev/s, acceleration in rev/s², mode; without
//! it the drive homes as it was set up. `tolerance` is how many steps off its target a move may end (default 0: the
//! drive counts its own pulses and knows of no other).

mod axis;
mod drive;

use std::sync::Arc;

use isolux_device::{AxisSettings, Coordinate, Factories, Kind, OpenError, Target};
use isolux_protocol_ascii::Lines;
use isolux_protocol_easi::Easi;
use isolux_transport::{Driver, LineSettings, Parity, Place, Ports, Probe, no_display, printable};

use crate::factory::axis_factory;
use crate::polled::PolledAxis;
use axis::Xli;
use drive::{Indexer, NAME};

/// User guide, "Specification": the line is fixed.
const LINE: LineSettings = LineSettings {
    baud: 9600,
    data_bits: 8,
    parity: Parity::None,
    stop_bits: 1,
};

/// Parker XLi.
pub const PARKER_EASI: Driver = Driver {
    name: NAME,
    speaks_to: "Parker XLi axes (EASI)",
    examples: &[(Kind::Axis, "parker-easi:/dev/ttyUSB0?address=1")],
    seen_with: "🧪 its virtual twin",
    usb: &[],
    identify: &[Probe {
        line: LINE,
        // Status of the drive with address 1; reading it clears nothing. The first CR ends what others have left there.
        request: b"\r1R(ST)\r",
        read: |bytes| {
            let text = printable(bytes);
            let (_, word) = text.rsplit_once('*')?;
            let bits = word.chars().filter(|bit| matches!(bit, '0' | '1')).count();
            (bits == 32 && word.contains('_')).then(|| "Parker XLi drive in EASI, address 1".to_owned())
        },
    }],
    place: |target, _| Ok(Address::parse(target)?.place),
    display_lx: no_display,
    factories: |ports| Factories {
        axis: Some(Arc::new(ParkerEasiDriver { ports })),
        ..Factories::default()
    },
};

struct ParkerEasiDriver {
    ports: Arc<Ports>,
}

/// A target in the words of the drive.
struct Address {
    address: u8,
    /// The parameters of HOME1.
    home: Option<String>,
    tolerance_steps: u64,
    place: Place,
}

impl Address {
    fn parse(target: &Target) -> Result<Self, OpenError> {
        target.only(&["address", "home", "tolerance"])?;
        let address = target.number("address", 1_u8)?;
        if address == 0 {
            return Err(target.wrong("address=0 is all drives; they have 1 to 255"));
        }
        let home = target.option("home");
        if let Some(home) = home
            && !is_home(home)
        {
            return Err(target.wrong(format!(
                "home={home}: expected edge (+ or -), switch (0 open, 1 closed), speed in rev/s with its sign, acceleration \
                 in rev/s², mode (0 to 2), as in home=+,0,-2,10,1"
            )));
        }
        let channel = format!("drive {address}");
        Ok(Self {
            address,
            home: home.map(str::to_owned),
            tolerance_steps: target.number("tolerance", 0_u32)?.into(),
            place: Place { channel, line: LINE },
        })
    }
}

/// Whether `text` is what HOME1 takes (user guide, page 108).
fn is_home(text: &str) -> bool {
    let fields: Vec<&str> = text.split(',').collect();
    let [edge, switch, speed, acceleration, mode] = fields[..] else {
        return false;
    };
    let within =
        |text: &str, least: f64, most: f64| text.parse().is_ok_and(|value: f64| (least..=most).contains(&value));
    matches!(edge, "+" | "-")
        && matches!(switch, "0" | "1")
        && within(speed.strip_prefix('-').unwrap_or(speed), 0.01, 50.0)
        && within(acceleration, 0.1, 1023.9)
        && matches!(mode, "0" | "1" | "2")
}

impl ParkerEasiDriver {
    async fn axis<P: Coordinate>(
        &self,
        target: &Target,
        settings: AxisSettings<P>,
    ) -> Result<PolledAxis<P, Xli<P>>, OpenError> {
        let address = Address::parse(target)?;
        let bus = self
            .ports
            .bus(target, address.place.line, Lines::<Easi>::default)
            .await?;
        let indexer = Indexer::open(bus, address.address, target).await?;
        let axis = Xli::open(indexer, settings, address.home, address.tolerance_steps).await?;
        Ok(PolledAxis::new(axis))
    }
}

axis_factory!(ParkerEasiDriver);

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn addresses_are_checked_before_anything_is_opened() {
        let parse = |open: &str| Address::parse(&Target::parse(open).unwrap());
        let whole = parse("parker-easi:/dev/x?address=7&home=+,1,-15,100,1").unwrap();
        assert_eq!((whole.address, whole.home.as_deref()), (7, Some("+,1,-15,100,1")));
        assert_eq!(whole.place.channel, "drive 7");
        for open in [
            "parker-easi:/dev/x?address=0",
            "parker-easi:/dev/x?address=256",
            "parker-easi:/dev/x?axis=1",
            "parker-easi:/dev/x?home=+,1,-15,100",
            "parker-easi:/dev/x?home=x,1,-15,100,1",
            "parker-easi:/dev/x?home=+,1,0,100,1",
            "parker-easi:/dev/x?home=+,1,-15,NaN,1",
        ] {
            assert!(parse(open).is_err(), "{open}");
        }
    }
}
