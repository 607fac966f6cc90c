//! Zaber controllers in the ASCII language: axes, digital outputs as switches, an analogue input as a thermometer.
//!
//! `zaber:LINK?axis=1` is an axis, `zaber:LINK?do=1` a switch, `zaber:LINK?ai=1&c_at_0v=-50&c_at_10v=100` a 0–10 V
//! temperature transmitter. `device=N` chooses the device of a daisy chain (default 1), `baud=9600` firmware 6 lines
//! (default 115200, firmware 7). All of a link share one owner task.

mod axis;
mod controller;
mod io;

use std::collections::HashMap;
use std::sync::Arc;

use async_trait::async_trait;
use isolux_device::{
    Axis, AxisFactory, AxisSettings, OpenError, Switch, SwitchFactory, Target, Thermometer, ThermometerFactory,
};
use isolux_transport::{Bus, LineSettings, Links, Parity};
use tokio::sync::Mutex;

use axis::ZaberAxis;
use controller::{Controller, Talk};
use io::{ZaberSwitch, ZaberThermometer};

/// Name of the driver in `open = "zaber:…"`.
pub(crate) const NAME: &str = "zaber";

/// Opens what hangs on Zaber controllers; devices on one link share it.
pub struct ZaberDriver {
    links: Arc<dyn Links>,
    buses: Mutex<HashMap<String, Bus<Talk>>>,
}

impl ZaberDriver {
    /// A driver that opens its links through `links`.
    pub fn new(links: Arc<dyn Links>) -> Self {
        Self {
            links,
            buses: Mutex::default(),
        }
    }

    /// The controller that `target` names, on the link's one bus; a lost link is opened again.
    async fn controller(&self, target: &Target) -> Result<Controller, OpenError> {
        let device = target.number("device", 1_u8)?;
        if !(1..=99).contains(&device) {
            return Err(target.wrong(format!("device={device} is not 1 to 99")));
        }
        let line = LineSettings {
            baud: target.number("baud", 115_200)?,
            data_bits: 8,
            parity: Parity::None,
            stop_bits: 1,
        };
        let bus = {
            let mut buses = self.buses.lock().await;
            let open = buses.get(target.link()).filter(|bus| !bus.is_closed()).cloned();
            if let Some(bus) = open {
                bus
            } else {
                let link = self
                    .links
                    .open(target.link(), line)
                    .await
                    .map_err(|error| error.opening(target))?;
                let bus = Bus::spawn(link, Talk::default());
                buses.insert(target.link().to_owned(), bus.clone());
                bus
            }
        };
        Ok(Controller::open(bus, device, target).await?)
    }
}

#[async_trait]
impl AxisFactory for ZaberDriver {
    async fn open_axis(&self, target: &Target, settings: AxisSettings) -> Result<Box<dyn Axis>, OpenError> {
        target.only(&["axis", "device", "baud"])?;
        let axis = target.number("axis", 1_u8)?;
        if !(1..=9).contains(&axis) {
            return Err(target.wrong(format!("axis={axis} is not 1 to 9")));
        }
        let controller = self.controller(target).await?;
        Ok(Box::new(ZaberAxis::open(controller, axis, settings).await?))
    }
}

#[async_trait]
impl SwitchFactory for ZaberDriver {
    async fn open_switch(&self, target: &Target) -> Result<Box<dyn Switch>, OpenError> {
        target.only(&["do", "device", "baud"])?;
        let output = target.number("do", 0_u8)?;
        if output == 0 {
            return Err(target.wrong("a switch needs do=N, the number of a digital output"));
        }
        Ok(Box::new(ZaberSwitch::new(self.controller(target).await?, output)))
    }
}

#[async_trait]
impl ThermometerFactory for ZaberDriver {
    async fn open_thermometer(&self, target: &Target) -> Result<Box<dyn Thermometer>, OpenError> {
        target.only(&["ai", "c_at_0v", "c_at_10v", "device", "baud"])?;
        let input = target.number("ai", 0_u8)?;
        let (low, high) = (
            target.number("c_at_0v", f64::NAN)?,
            target.number("c_at_10v", f64::NAN)?,
        );
        if input == 0 || !low.is_finite() || !high.is_finite() || low == high {
            return Err(target.wrong("a thermometer needs ai=N, and c_at_0v and c_at_10v of its transmitter"));
        }
        Ok(Box::new(ZaberThermometer::new(
            self.controller(target).await?,
            input,
            (low, high),
        )))
    }
}
