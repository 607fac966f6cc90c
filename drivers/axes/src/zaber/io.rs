//! Digital outputs as switches, an analogue input as a thermometer.

use async_trait::async_trait;
use isolux_device::{DeviceError, Identity, Switch, TemperatureReading, Thermometer};
use isolux_units::Celsius;
use tokio::time::Instant;

use super::controller::{Controller, Reported};

/// Two readings of an input in a row may differ by so much: two steps of a converter of 12 bits, and noise.
const AGREEMENT_V: f64 = 0.01;

/// A digital output: on when it conducts.
pub(crate) struct ZaberSwitch {
    controller: Controller,
    output: u8,
}

impl ZaberSwitch {
    pub const fn new(controller: Controller, output: u8) -> Self {
        Self { controller, output }
    }
}

#[async_trait]
impl Switch for ZaberSwitch {
    fn identity(&self) -> &Identity {
        self.controller.identity()
    }

    async fn set(&self, on: bool) -> Result<(), DeviceError> {
        let action = format!("io set do {} {}", self.output, u8::from(on));
        let stated = self.controller.ask(0, &action).await?;
        if self.state().await? == on {
            Ok(())
        } else {
            Err(self
                .controller
                .fault(&action, "the output did not follow", stated.frame))
        }
    }

    async fn state(&self) -> Result<bool, DeviceError> {
        let action = format!("io get do {}", self.output);
        let stated = self.controller.ask_twice(0, &action).await?;
        match stated.data.as_str() {
            "0" => Ok(false),
            "1" => Ok(true),
            _ => Err(self.controller.malformed(&action, "neither 0 nor 1", stated.frame)),
        }
    }
}

/// A temperature transmitter with a 0–10 V output on an analogue input.
pub(crate) struct ZaberThermometer {
    controller: Controller,
    input: u8,
    /// °C at 0 V and at 10 V.
    scale: (f64, f64),
}

impl ZaberThermometer {
    pub const fn new(controller: Controller, input: u8, scale: (f64, f64)) -> Self {
        Self {
            controller,
            input,
            scale,
        }
    }
}

#[async_trait]
impl Thermometer for ZaberThermometer {
    fn identity(&self) -> &Identity {
        self.controller.identity()
    }

    async fn read(&self) -> Result<TemperatureReading, DeviceError> {
        let action = format!("io get ai {}", self.input);
        let agree = |before: &Reported, now: &Reported| match (before.data.parse::<f64>(), now.data.parse::<f64>()) {
            (Ok(before), Ok(now)) => (before - now).abs() <= AGREEMENT_V,
            // What is no number is said below.
            _ => before.data == now.data,
        };
        let stated = self.controller.ask_until(0, &action, agree).await?;
        let (volts, stated) = self.controller.parsed::<f64>(&action, stated)?;
        // A broken wire reads as 0 V or the supply; the ends of the range are therefore no temperature.
        if !(0.01..=9.99).contains(&volts) {
            return Err(self.controller.fault(
                &action,
                format!("{volts} V: transmitter missing or out of range"),
                stated.frame,
            ));
        }
        let celsius = self.scale.0 + (self.scale.1 - self.scale.0) * volts / 10.0;
        match Celsius::new(celsius) {
            Ok(temperature) => Ok(TemperatureReading {
                temperature,
                at: Instant::now(),
            }),
            Err(error) => Err(self.controller.malformed(&action, &error.to_string(), stated.frame)),
        }
    }
}
