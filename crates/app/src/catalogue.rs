//! The drivers of this program: which name in `open = "driver:target"` stands for what.

use std::sync::Arc;

use isolux_axes::ZaberDriver;
use isolux_device::{
    Axis, AxisFactory, AxisSettings, ErrorKind, LuxMeter, LuxMeterFactory, OpenError, Spectroradiometer,
    SpectroradiometerFactory, Switch, SwitchFactory, Target, Thermometer, ThermometerFactory,
};
use isolux_luxmeter::T10aDriver;
use isolux_spectroradiometer::OceanOoiDriver;
use isolux_transport::Links;

use crate::Failure;

/// A driver: its name, what it speaks to, and what it can open.
pub struct Driver {
    /// Name in `open = "name:target"`.
    pub name: &'static str,
    /// The instruments, for people.
    pub speaks_to: &'static str,
    /// Examples of `open`, one a kind of device.
    pub examples: &'static [&'static str],
    /// What it has been seen to work with.
    pub seen_with: &'static str,
    axis: Option<Arc<dyn AxisFactory>>,
    lux_meter: Option<Arc<dyn LuxMeterFactory>>,
    spectroradiometer: Option<Arc<dyn SpectroradiometerFactory>>,
    switch: Option<Arc<dyn SwitchFactory>>,
    thermometer: Option<Arc<dyn ThermometerFactory>>,
}

impl Driver {
    /// The kinds of device that it opens.
    pub fn kinds(&self) -> Vec<&'static str> {
        let all = [
            ("axis", self.axis.is_some()),
            ("luxmeter", self.lux_meter.is_some()),
            ("spectroradiometer", self.spectroradiometer.is_some()),
            ("switch", self.switch.is_some()),
            ("thermometer", self.thermometer.is_some()),
        ];
        all.into_iter()
            .filter(|(_, opens)| *opens)
            .map(|(kind, _)| kind)
            .collect()
    }
}

/// Opens devices by `driver:target`. One catalogue a session: devices on the same link share it.
pub struct Catalogue {
    drivers: Vec<Driver>,
}

const VIRTUAL_ONLY: &str = "🧪 its virtual twin and scripted bytes; not yet real hardware";

impl Catalogue {
    /// All drivers, with `links` to open their links. A new driver is one entry here.
    pub fn new(links: Arc<dyn Links>) -> Self {
        let zaber = Arc::new(ZaberDriver::new(Arc::clone(&links)));
        let none = |name, speaks_to, examples| Driver {
            name,
            speaks_to,
            examples,
            seen_with: VIRTUAL_ONLY,
            axis: None,
            lux_meter: None,
            spectroradiometer: None,
            switch: None,
            thermometer: None,
        };
        let drivers = vec![
            Driver {
                axis: Some(zaber.clone()),
                switch: Some(zaber.clone()),
                thermometer: Some(zaber),
                ..none(
                    "zaber",
                    "Zaber controllers and stages in the ASCII language, firmware 6 and 7",
                    &[
                        "zaber:/dev/ttyUSB0?axis=1",
                        "zaber:/dev/ttyUSB0?do=1",
                        "zaber:/dev/ttyUSB0?ai=1&c_at_0v=-50&c_at_10v=100",
                    ],
                )
            },
            Driver {
                lux_meter: Some(Arc::new(T10aDriver::new(Arc::clone(&links)))),
                ..none(
                    "konica-t10a",
                    "Konica Minolta T-10A illuminance meter",
                    &["konica-t10a:/dev/ttyUSB1?head=0"],
                )
            },
            Driver {
                spectroradiometer: Some(Arc::new(OceanOoiDriver::new(links))),
                ..none(
                    "ocean-ooi",
                    "Ocean Optics USB2000+ and Flame-S over a byte link (USB itself: not built yet)",
                    &["ocean-ooi:tcp://127.0.0.1:7000"],
                )
            },
        ];
        Self { drivers }
    }

    /// All drivers, in a fixed order.
    pub fn drivers(&self) -> &[Driver] {
        &self.drivers
    }

    /// Opens an axis.
    ///
    /// # Errors
    /// [`OpenError`]; see [`open_failure`].
    pub async fn axis(&self, open: &str, settings: AxisSettings) -> Result<Box<dyn Axis>, OpenError> {
        let (target, factory) = self.factory(open, "axis", |driver| driver.axis.as_ref())?;
        factory.open_axis(&target, settings).await
    }

    /// Opens a lux meter.
    ///
    /// # Errors
    /// [`OpenError`].
    pub async fn lux_meter(&self, open: &str) -> Result<Box<dyn LuxMeter>, OpenError> {
        let (target, factory) = self.factory(open, "luxmeter", |driver| driver.lux_meter.as_ref())?;
        factory.open_lux_meter(&target).await
    }

    /// Opens a spectroradiometer.
    ///
    /// # Errors
    /// [`OpenError`].
    pub async fn spectroradiometer(&self, open: &str) -> Result<Box<dyn Spectroradiometer>, OpenError> {
        let (target, factory) = self.factory(open, "spectroradiometer", |driver| driver.spectroradiometer.as_ref())?;
        factory.open_spectroradiometer(&target).await
    }

    /// Opens a switch.
    ///
    /// # Errors
    /// [`OpenError`].
    pub async fn switch(&self, open: &str) -> Result<Box<dyn Switch>, OpenError> {
        let (target, factory) = self.factory(open, "switch", |driver| driver.switch.as_ref())?;
        factory.open_switch(&target).await
    }

    /// Opens a thermometer.
    ///
    /// # Errors
    /// [`OpenError`].
    pub async fn thermometer(&self, open: &str) -> Result<Box<dyn Thermometer>, OpenError> {
        let (target, factory) = self.factory(open, "thermometer", |driver| driver.thermometer.as_ref())?;
        factory.open_thermometer(&target).await
    }

    fn factory<'a, F: ?Sized>(
        &'a self,
        open: &str,
        kind: &str,
        select: impl Fn(&'a Driver) -> Option<&'a Arc<F>>,
    ) -> Result<(Target, &'a Arc<F>), OpenError> {
        let target = Target::parse(open)?;
        let able = || {
            let names = self
                .drivers
                .iter()
                .filter(|driver| select(driver).is_some())
                .map(|driver| driver.name);
            names.collect::<Vec<_>>().join(", ")
        };
        let Some(driver) = self.drivers.iter().find(|driver| driver.name == target.driver()) else {
            return Err(target.wrong(format!(
                "no driver {}; drivers that open a {kind}: {}",
                target.driver(),
                able()
            )));
        };
        match select(driver) {
            Some(factory) => Ok((target, factory)),
            None => Err(target.wrong(format!(
                "driver {} opens no {kind}; drivers that do: {}",
                driver.name,
                able()
            ))),
        }
    }
}

/// The failure of a use case that could not open an instrument: a wrong address is bad input, all else the instrument.
pub fn open_failure(error: OpenError) -> Failure {
    match error {
        OpenError::Address { .. } => {
            Failure::bad_input(error).help("`isolux devices` lists drivers, ports and examples")
        }
        OpenError::Link { ref advice, .. } => {
            let help = advice
                .clone()
                .unwrap_or_else(|| "`isolux devices` lists the ports found".to_owned());
            Failure::instrument(&error).help(help)
        }
        OpenError::Device(ref device) => {
            let help = match device.kind() {
                ErrorKind::Timeout => "check power and cable, and that the address belongs to this instrument",
                ErrorKind::Disconnected => "check the cable, then start again",
                ErrorKind::Malformed => "check that the driver is the right one for this instrument, and the line",
                ErrorKind::OutOfTravel => "narrow the limits in the station file to the axis' own",
                ErrorKind::Refused | ErrorKind::Unsupported => "check the address and the settings in the station file",
                ErrorKind::Fault => "see the instrument's manual for this fault",
            };
            Failure::instrument(&error).help(help)
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::FailureKind;
    use isolux_transport::MemoryLinks;

    #[tokio::test(start_paused = true)]
    async fn wrong_names_are_bad_input_and_name_the_right_ones() {
        let catalogue = Catalogue::new(Arc::new(MemoryLinks::default()));
        for (open, word) in [
            ("zeber:x?do=1", "zaber"),
            ("konica-t10a:x", "zaber"),
            ("zaber", "driver:target"),
            ("zaber:memory:x", "do=N"),
        ] {
            let error = catalogue.switch(open).await.err().unwrap();
            let failure = open_failure(error);
            assert_eq!(failure.kind, FailureKind::BadInput, "{open}");
            assert!(failure.message.contains(word), "{open}: {}", failure.message);
        }
        let failure = open_failure(catalogue.switch("zaber:memory:nowhere?do=1").await.err().unwrap());
        assert_eq!(failure.kind, FailureKind::Instrument);
    }

    #[test]
    fn every_example_is_an_address_of_its_driver() {
        let catalogue = Catalogue::new(Arc::new(MemoryLinks::default()));
        for driver in catalogue.drivers() {
            assert_eq!(
                driver.examples.len(),
                driver.kinds().len(),
                "{}: one example a kind",
                driver.name
            );
            for example in driver.examples {
                assert_eq!(Target::parse(example).unwrap().driver(), driver.name);
            }
        }
    }
}
