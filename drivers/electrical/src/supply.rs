//! Supplies in SCPI that switch a lamp: `scpi-supply:LINK?profile=dp800&channel=1&voltage_v=24&current_a=0.35`.
//!
//! On: the levels are set and read back, then the output is switched on and read back. A protection that has tripped is
//! a fault: it switches the output off and keeps the levels.

use std::sync::Arc;

use async_trait::async_trait;
use isolux_device::{DeviceError, Factories, Identity, Kind, OpenError, Switch, SwitchFactory, Target};
use isolux_protocol_scpi::Reading;
use isolux_transport::{Driver, Place, Ports, no_display};

use crate::instrument::Instrument;
use crate::profile::{Level, Supply};

const NAME: &str = "scpi-supply";

/// A level reads back within this share of what was set: the supply's digits.
const READ_BACK: f64 = 1e-3;

/// Supplies in SCPI.
pub const SCPI_SUPPLY: Driver = Driver {
    name: NAME,
    speaks_to: "supplies in SCPI by a profile: Rigol DP800",
    examples: &[(
        Kind::Switch,
        "scpi-supply:tcp://192.168.1.5:5555?profile=dp800&channel=1&voltage_v=24&current_a=0.35",
    )],
    seen_with: "🧪 its virtual twin; pyvisa-py 0.8.1",
    usb: &[],
    // A power meter asks the same.
    identify: &[],
    place: |target, _| Ok(Address::parse(target)?.place),
    display_lx: no_display,
    factories: |ports| Factories {
        switch: Some(Arc::new(ScpiSupplyDriver { ports })),
        ..Factories::default()
    },
};

/// A target in the words of the supply.
struct Address {
    profile: Supply,
    channel: u8,
    voltage_v: f64,
    current_a: f64,
    place: Place,
}

impl Address {
    fn parse(target: &Target) -> Result<Self, OpenError> {
        target.only(&["profile", "channel", "voltage_v", "current_a"])?;
        let profile = Supply::of(target)?;
        let channel = target.number("channel", 1_u8)?;
        if !(1..=profile.channels).contains(&channel) {
            return Err(target.wrong(format!("channel={channel}: this supply has 1 to {}", profile.channels)));
        }
        let level = |key: &str| match target.number(key, f64::NAN) {
            Ok(value) if value.is_finite() && value > 0.0 => Ok(value),
            Ok(_) => Err(target.wrong(format!(
                "a supply needs {key}, above zero: nothing is switched on without its level"
            ))),
            Err(error) => Err(error),
        };
        let place = Place {
            channel: format!("output {channel}"),
            line: profile.manners.line,
        };
        Ok(Self {
            channel,
            voltage_v: level("voltage_v")?,
            current_a: level("current_a")?,
            place,
            profile,
        })
    }
}

struct ScpiSupplyDriver {
    ports: Arc<Ports>,
}

#[async_trait]
impl SwitchFactory for ScpiSupplyDriver {
    async fn open_switch(&self, target: &Target) -> Result<Box<dyn Switch>, OpenError> {
        let address = Address::parse(target)?;
        let instrument = Instrument::open(&self.ports, target, NAME, &address.profile.manners).await?;
        Ok(Box::new(ScpiSupply { instrument, address }))
    }
}

struct ScpiSupply {
    instrument: Instrument,
    address: Address,
}

impl ScpiSupply {
    fn of_channel(&self, message: &str) -> String {
        message.replace("{channel}", &self.address.channel.to_string())
    }

    async fn level(&self, level: &Level, value: f64) -> Result<(), DeviceError> {
        let command = self.of_channel(&level.set).replace("{value}", &value.to_string());
        self.instrument.command(&command).await?;
        let query = self.of_channel(&level.query);
        let found = self.instrument.twice(&query).await?;
        match Reading::parse(&found, "") {
            Reading::Value(number) if (number.value - value).abs() <= READ_BACK * value => Ok(()),
            _ => Err(self
                .instrument
                .fault(&command, format!("it reads back {found}"), Vec::new())),
        }
    }

    /// Refuses a supply one of whose protections has switched the output off.
    async fn tripped(&self) -> Result<(), DeviceError> {
        for query in &self.address.profile.trips {
            let query = self.of_channel(query);
            if self
                .instrument
                .twice(&query)
                .await?
                .eq_ignore_ascii_case(&self.address.profile.tripped)
            {
                let reason = "a protection has tripped and switched the output off: lower the level, then clear it";
                return Err(self.instrument.fault(&query, reason.to_owned(), Vec::new()));
            }
        }
        Ok(())
    }
}

#[async_trait]
impl Switch for ScpiSupply {
    fn identity(&self) -> &Identity {
        self.instrument.identity()
    }

    async fn set(&self, on: bool) -> Result<(), DeviceError> {
        let profile = &self.address.profile;
        if on {
            self.tripped().await?;
            // The limit first: whatever the voltage is, the lamp never gets more current than it may.
            self.level(&profile.current, self.address.current_a).await?;
            self.level(&profile.voltage, self.address.voltage_v).await?;
        }
        let command = self.of_channel(if on { &profile.on } else { &profile.off });
        self.instrument.command(&command).await?;
        if self.state().await? == on {
            return Ok(());
        }
        let reason = format!("the output is still {}", if on { "off" } else { "on" });
        Err(self.instrument.fault(&command, reason, Vec::new()))
    }

    async fn state(&self) -> Result<bool, DeviceError> {
        let profile = &self.address.profile;
        let query = self.of_channel(&profile.state);
        let found = self.instrument.twice(&query).await?;
        if found.eq_ignore_ascii_case(&profile.is_on) {
            Ok(true)
        } else if found.eq_ignore_ascii_case(&profile.is_off) {
            self.tripped().await.map(|()| false)
        } else {
            let reason = format!("\"{found}\" is neither {} nor {}", profile.is_on, profile.is_off);
            Err(self.instrument.malformed(&query, &reason, found.into_bytes()))
        }
    }
}
