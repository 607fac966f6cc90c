//! From `driver:target` to an open device, without discovery.

use std::fmt;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use async_trait::async_trait;
use isolux_units::Millimetre;

use crate::{
    Axis, AxisSettings, DeviceError, LuxMeter, PowerMeter, Spectroradiometer, Switch, Thermometer, WaveformRecorder,
};

/// Opens axes of one driver.
#[async_trait]
pub trait AxisFactory: Send + Sync {
    /// Opens the axis at `target`, asks who it is, and sets speed and acceleration. Moves nothing.
    ///
    /// # Errors
    /// [`OpenError`].
    async fn open_axis(&self, target: &Target, settings: AxisSettings) -> Result<Box<dyn Axis>, OpenError>;

    /// The same for an axis that moves along a line.
    ///
    /// # Errors
    /// [`OpenError`].
    async fn open_linear_axis(
        &self,
        target: &Target,
        settings: AxisSettings<Millimetre>,
    ) -> Result<Box<dyn Axis<Millimetre>>, OpenError>;
}

/// Opens lux meters of one driver.
#[async_trait]
pub trait LuxMeterFactory: Send + Sync {
    /// Opens the meter at `target` and brings it into remote control.
    ///
    /// # Errors
    /// [`OpenError`].
    async fn open_lux_meter(&self, target: &Target) -> Result<Box<dyn LuxMeter>, OpenError>;
}

/// Opens spectroradiometers of one driver.
#[async_trait]
pub trait SpectroradiometerFactory: Send + Sync {
    /// Opens the instrument at `target` and reads its calibration.
    ///
    /// # Errors
    /// [`OpenError`].
    async fn open_spectroradiometer(&self, target: &Target) -> Result<Box<dyn Spectroradiometer>, OpenError>;
}

/// Opens switches of one driver.
#[async_trait]
pub trait SwitchFactory: Send + Sync {
    /// Opens the switch at `target`. Switches nothing.
    ///
    /// # Errors
    /// [`OpenError`].
    async fn open_switch(&self, target: &Target) -> Result<Box<dyn Switch>, OpenError>;
}

/// Opens thermometers of one driver.
#[async_trait]
pub trait ThermometerFactory: Send + Sync {
    /// Opens the thermometer at `target`.
    ///
    /// # Errors
    /// [`OpenError`].
    async fn open_thermometer(&self, target: &Target) -> Result<Box<dyn Thermometer>, OpenError>;
}

/// Opens power meters of one driver.
#[async_trait]
pub trait PowerMeterFactory: Send + Sync {
    /// Opens the meter at `target` and sets what it is to measure.
    ///
    /// # Errors
    /// [`OpenError`].
    async fn open_power_meter(&self, target: &Target) -> Result<Box<dyn PowerMeter>, OpenError>;
}

/// Opens recorders of waveforms of one driver.
#[async_trait]
pub trait WaveformRecorderFactory: Send + Sync {
    /// Opens the recorder at `target`.
    ///
    /// # Errors
    /// [`OpenError`].
    async fn open_waveform_recorder(&self, target: &Target) -> Result<Box<dyn WaveformRecorder>, OpenError>;
}

/// Kinds of device that a driver opens.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Kind {
    /// A motor axis.
    Axis,
    /// A lux meter.
    LuxMeter,
    /// A spectroradiometer.
    Spectroradiometer,
    /// A switch.
    Switch,
    /// A thermometer.
    Thermometer,
    /// A power meter.
    PowerMeter,
    /// A recorder of waveforms.
    WaveformRecorder,
}

impl Kind {
    /// All of them.
    pub const ALL: [Self; 7] = [
        Self::Axis,
        Self::LuxMeter,
        Self::Spectroradiometer,
        Self::Switch,
        Self::Thermometer,
        Self::PowerMeter,
        Self::WaveformRecorder,
    ];

    /// Its name, as a station file writes it.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Axis => "axis",
            Self::LuxMeter => "luxmeter",
            Self::Spectroradiometer => "spectroradiometer",
            Self::Switch => "switch",
            Self::Thermometer => "thermometer",
            Self::PowerMeter => "powermeter",
            Self::WaveformRecorder => "oscilloscope",
        }
    }
}

/// What a driver opens, one factory a kind.
#[derive(Clone, Default)]
pub struct Factories {
    /// Axes.
    pub axis: Option<Arc<dyn AxisFactory>>,
    /// Lux meters.
    pub lux_meter: Option<Arc<dyn LuxMeterFactory>>,
    /// Spectroradiometers.
    pub spectroradiometer: Option<Arc<dyn SpectroradiometerFactory>>,
    /// Switches.
    pub switch: Option<Arc<dyn SwitchFactory>>,
    /// Thermometers.
    pub thermometer: Option<Arc<dyn ThermometerFactory>>,
    /// Power meters.
    pub power_meter: Option<Arc<dyn PowerMeterFactory>>,
    /// Recorders of waveforms.
    pub waveform_recorder: Option<Arc<dyn WaveformRecorderFactory>>,
}

impl Factories {
    /// The kinds of device that are opened.
    pub fn kinds(&self) -> Vec<Kind> {
        let opens = |kind: &Kind| match kind {
            Kind::Axis => self.axis.is_some(),
            Kind::LuxMeter => self.lux_meter.is_some(),
            Kind::Spectroradiometer => self.spectroradiometer.is_some(),
            Kind::Switch => self.switch.is_some(),
            Kind::Thermometer => self.thermometer.is_some(),
            Kind::PowerMeter => self.power_meter.is_some(),
            Kind::WaveformRecorder => self.waveform_recorder.is_some(),
        };
        Kind::ALL.into_iter().filter(opens).collect()
    }
}

/// Why a device could not be opened.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum OpenError {
    /// The address is not one: bad input, nothing was touched.
    #[error("\"{address}\": {reason}")]
    Address {
        /// As written.
        address: String,
        /// What is wrong and what is expected.
        reason: String,
    },
    /// The link could not be opened.
    #[error("{target}: cannot open the link: {reason}")]
    Link {
        /// Where.
        target: String,
        /// What the operating system said.
        reason: String,
        /// What to do about it.
        advice: Option<String>,
    },
    /// The link is open but the device did not answer as it should.
    #[error(transparent)]
    Device(#[from] DeviceError),
}

/// The part of `open = "driver:target"` after the driver: a link and its options, `link?key=value&key=value`.
///
/// A link is a path (`/dev/ttyUSB0`, `COM3`), `tcp://host:port`, or `memory:name` inside this process.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Target {
    driver: String,
    link: String,
    options: Vec<(String, String)>,
    /// Where names of files in the options begin; no part of the address.
    folder: PathBuf,
}

impl Target {
    /// Splits `driver:link?key=value&…`.
    ///
    /// # Errors
    /// [`OpenError::Address`] without driver or link, with an option that is not `key=value`, or with one given twice.
    pub fn parse(open: &str) -> Result<Self, OpenError> {
        let wrong = |reason: &str| OpenError::Address {
            address: open.to_owned(),
            reason: reason.to_owned(),
        };
        let (driver, rest) = open.split_once(':').ok_or_else(|| wrong("expected driver:target"))?;
        let (link, query) = rest.split_once('?').unwrap_or((rest, ""));
        if driver.is_empty() || link.is_empty() {
            return Err(wrong("expected driver:target, for example zaber:/dev/ttyUSB0?axis=1"));
        }
        let mut options: Vec<(String, String)> = Vec::new();
        for pair in query.split('&').filter(|pair| !pair.is_empty()) {
            let (key, value) = pair
                .split_once('=')
                .ok_or_else(|| wrong("options are key=value, joined by &"))?;
            if options.iter().any(|(known, _)| known == key) {
                return Err(wrong(&format!("option {key} is given twice")));
            }
            options.push((key.to_owned(), value.to_owned()));
        }
        // What tells one USB device from another belongs to its link, however it is written.
        let mut link = link.to_owned();
        if link.starts_with("usb:") {
            let (own, others): (Vec<_>, Vec<_>) = options
                .into_iter()
                .partition(|(key, _)| key == "serial" || key == "port");
            options = others;
            for (key, value) in own {
                let before = if link.contains('=') { '&' } else { '?' };
                link.push_str(&format!("{before}{key}={value}"));
            }
        }
        Ok(Self {
            driver: driver.to_owned(),
            link,
            options,
            folder: PathBuf::new(),
        })
    }

    /// The same, in a file that stands in `folder`: names of files in its options begin there.
    #[must_use]
    pub fn within(self, folder: &Path) -> Self {
        let folder = folder.to_owned();
        Self { folder, ..self }
    }

    /// Where `file`, named in an option, is.
    pub fn path(&self, file: &str) -> PathBuf {
        self.folder.join(file)
    }

    /// Name of the driver.
    pub fn driver(&self) -> &str {
        &self.driver
    }

    /// The link, without driver and options.
    pub fn link(&self) -> &str {
        &self.link
    }

    /// The value of option `key`.
    pub fn option(&self, key: &str) -> Option<&str> {
        self.options
            .iter()
            .find(|(known, _)| known == key)
            .map(|(_, value)| value.as_str())
    }

    /// The value of option `key` as a number, `default` when it is not given.
    ///
    /// # Errors
    /// [`OpenError::Address`] when it is not a `T`.
    pub fn number<T: std::str::FromStr>(&self, key: &str, default: T) -> Result<T, OpenError> {
        match self.option(key) {
            None => Ok(default),
            Some(value) => value
                .parse()
                .map_err(|_| self.wrong(format!("option {key}={value} is not a number that fits"))),
        }
    }

    /// The same without the options `keys`: for what is wrapped in something that understands those.
    #[must_use]
    pub fn without(mut self, keys: &[&str]) -> Self {
        self.options.retain(|(key, _)| !keys.contains(&key.as_str()));
        self
    }

    /// Refuses options that the driver does not know: a misspelt one must not pass for a default.
    ///
    /// # Errors
    /// [`OpenError::Address`] names the option and the known ones.
    pub fn only(&self, known: &[&str]) -> Result<(), OpenError> {
        match self.options.iter().find(|(key, _)| !known.contains(&key.as_str())) {
            None => Ok(()),
            Some((key, _)) => Err(self.wrong(format!("unknown option {key}; known: {}", known.join(", ")))),
        }
    }

    /// An [`OpenError::Address`] about this target.
    pub fn wrong(&self, reason: impl Into<String>) -> OpenError {
        OpenError::Address {
            address: self.to_string(),
            reason: reason.into(),
        }
    }
}

impl fmt::Display for Target {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}:{}", self.driver, self.link)?;
        for (i, (key, value)) in self.options.iter().enumerate() {
            let first = i == 0 && !self.link.contains('?');
            write!(f, "{}{key}={value}", if first { '?' } else { '&' })?;
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_names_a_usb_device_is_part_of_its_link() {
        for (open, link) in [
            ("ocean-ooi:usb:serial=USB2+H16355", "usb:serial=USB2+H16355"),
            ("ocean-ooi:usb:2457:101e?serial=S1", "usb:2457:101e?serial=S1"),
        ] {
            let target = Target::parse(open).unwrap();
            assert_eq!(target.link(), link);
            assert_eq!(target.only(&[]), Ok(()));
            assert_eq!(target.to_string(), open);
        }
        let both = Target::parse("ocean-ooi:usb:2457:101e?port=1-2&head=3").unwrap();
        assert_eq!(
            (both.link(), both.option("head")),
            ("usb:2457:101e?port=1-2", Some("3"))
        );
        assert_eq!(both.to_string(), "ocean-ooi:usb:2457:101e?port=1-2&head=3");
        assert_eq!(Target::parse("ocean-ooi:usb:").unwrap().link(), "usb:");
    }

    #[test]
    fn addresses_of_the_contract_are_understood() {
        let axis = Target::parse("zaber:/dev/ttyUSB0?axis=1").unwrap();
        assert_eq!(
            (axis.driver(), axis.link(), axis.option("axis")),
            ("zaber", "/dev/ttyUSB0", Some("1"))
        );
        assert_eq!(axis.number("axis", 9_u8), Ok(1));
        assert_eq!(axis.number("device", 1_u8), Ok(1));
        let az = Target::parse("oriental-az:tcp://10.0.0.5:502").unwrap();
        assert_eq!((az.driver(), az.link()), ("oriental-az", "tcp://10.0.0.5:502"));
        assert_eq!(Target::parse("ocean-ooi:usb:serial=X").unwrap().link(), "usb:serial=X");
        assert_eq!(axis.to_string(), "zaber:/dev/ttyUSB0?axis=1");
    }

    #[test]
    fn a_wrong_address_is_refused_with_its_reason() {
        for open in ["zaber", ":x", "zaber:", "zaber:x?axis", "zaber:x?a=1&a=2"] {
            assert!(matches!(Target::parse(open), Err(OpenError::Address { .. })), "{open}");
        }
        let target = Target::parse("zaber:x?axes=1").unwrap();
        assert!(target.only(&["axis"]).unwrap_err().to_string().contains("axes"));
        assert!(Target::parse("zaber:x?axis=one").unwrap().number("axis", 1_u8).is_err());
    }
}
