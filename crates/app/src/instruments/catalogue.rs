//! The drivers of this program: which name in `open = "driver:target"` stands for what.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use camino::Utf8Path;

use isolux_device::{
    Axis, AxisSettings, ErrorKind, Factories, Kind, LuxMeter, OpenError, PowerMeter, Spectroradiometer, Switch, Target,
    Thermometer, WaveformRecorder,
};
use isolux_transport::{Driver, Links, Place, Ports};
use isolux_units::Millimetre;

use crate::Failure;
use crate::instruments::spectral_lux::{self, SpectralLuxMeter};

/// The drivers, by crate. A new crate is one entry here, a new driver one in the list of its crate.
const DRIVERS: &[&[Driver]] = &[
    isolux_axes::DRIVERS,
    isolux_luxmeter::DRIVERS,
    isolux_spectroradiometer::DRIVERS,
    isolux_electrical::DRIVERS,
];

/// All drivers, in a fixed order.
pub fn drivers() -> impl Iterator<Item = &'static Driver> {
    DRIVERS.iter().copied().flatten()
}

/// The driver of this name.
pub fn driver(name: &str) -> Option<&'static Driver> {
    drivers().find(|driver| driver.name == name)
}

/// The address `open` of the station in `file`: names of files in it begin in the station's folder.
///
/// # Errors
/// [`OpenError::Address`].
pub(crate) fn target(open: &str, file: &Utf8Path) -> Result<Target, OpenError> {
    Ok(Target::parse(open)?.within(folder(file)))
}

fn folder(file: &Utf8Path) -> &Path {
    file.parent().map_or(Path::new(""), Utf8Path::as_std_path)
}

/// Whether `open` is an address of a driver that opens a `kind`, with options that it understands, in the station
/// `file`. Nothing is opened.
///
/// # Errors
/// [`OpenError::Address`].
pub fn place(open: &str, kind: Kind, file: &Utf8Path) -> Result<(), OpenError> {
    placed(&target(open, file)?, kind).map(drop)
}

/// What `target` uses behind its link as a `kind`, by the word of its driver.
///
/// # Errors
/// [`OpenError::Address`].
pub(crate) fn placed(target: &Target, kind: Kind) -> Result<Place, OpenError> {
    match driver(target.driver()) {
        Some(driver) if opens(driver, kind) => (driver.place)(target, kind),
        Some(driver) if reads_light_by_spectra(driver, kind) => {
            let (_, instrument) = spectral_lux::Settings::of(target)?;
            (driver.place)(&instrument, Kind::Spectroradiometer)
        }
        known => {
            let able: Vec<&str> = drivers()
                .filter(|driver| opens(driver, kind) || reads_light_by_spectra(driver, kind))
                .map(|driver| driver.name)
                .collect();
            let (name, kind, able) = (target.driver(), kind.name(), able.join(", "));
            Err(target.wrong(match known {
                Some(_) => format!("driver {name} opens no {kind}; drivers that do: {able}"),
                None => format!("no driver {name}; drivers that open a {kind}: {able}"),
            }))
        }
    }
}

fn opens(driver: &Driver, kind: Kind) -> bool {
    driver.examples.iter().any(|(known, _)| *known == kind)
}

/// Whether the lux meter that is asked for is a spectroradiometer of this driver.
fn reads_light_by_spectra(driver: &Driver, kind: Kind) -> bool {
    kind == Kind::LuxMeter && !opens(driver, kind) && opens(driver, Kind::Spectroradiometer)
}

/// Examples of `open`, one a kind of device that `driver` opens, and for a lux meter that is a spectroradiometer.
pub fn examples(driver: &Driver) -> Vec<(Kind, String)> {
    let own = driver.examples.iter().map(|(kind, open)| (*kind, (*open).to_owned()));
    let mut all: Vec<(Kind, String)> = own.collect();
    let spectral = all.iter().find(|(kind, _)| *kind == Kind::Spectroradiometer);
    if let Some((_, open)) = spectral.filter(|_| reads_light_by_spectra(driver, Kind::LuxMeter)) {
        let open = format!("{open}?{}", spectral_lux::EXAMPLE);
        all.push((Kind::LuxMeter, open));
    }
    all
}

/// Full scale and last digit of every range of the lux meter at `open` of the station in `file`, in lx; empty where
/// they are not known.
pub fn display_lx(open: &str, file: &Utf8Path) -> Vec<(f64, f64)> {
    let Ok(target) = target(open, file) else {
        return Vec::new();
    };
    driver(target.driver()).map_or_else(Vec::new, |driver| (driver.display_lx)(&target))
}

/// Opens devices by `driver:target`. One catalogue a session: devices on the same port share it.
pub struct Catalogue {
    drivers: Vec<(&'static Driver, Factories)>,
    folder: PathBuf,
}

impl Catalogue {
    /// All drivers, with `links` to open their links.
    pub fn new(links: Arc<dyn Links>) -> Self {
        let ports = Ports::new(links);
        let drivers = drivers().map(|driver| (driver, (driver.factories)(Arc::clone(&ports))));
        Self {
            drivers: drivers.collect(),
            folder: PathBuf::new(),
        }
    }

    /// The same, for the station in `file`: names of files in its addresses begin in its folder.
    #[must_use]
    pub fn beside(self, file: &Utf8Path) -> Self {
        let folder = folder(file).to_owned();
        Self { folder, ..self }
    }

    /// Opens an axis.
    ///
    /// # Errors
    /// [`OpenError`]; see [`open_failure`].
    pub async fn axis(&self, open: &str, settings: AxisSettings) -> Result<Box<dyn Axis>, OpenError> {
        let (target, factory) = self.factory(open, Kind::Axis, |opens| opens.axis.as_ref())?;
        factory.open_axis(&target, settings).await
    }

    /// Opens an axis that moves along a line.
    ///
    /// # Errors
    /// [`OpenError`].
    pub async fn linear_axis(
        &self,
        open: &str,
        settings: AxisSettings<Millimetre>,
    ) -> Result<Box<dyn Axis<Millimetre>>, OpenError> {
        let (target, factory) = self.factory(open, Kind::Axis, |opens| opens.axis.as_ref())?;
        factory.open_linear_axis(&target, settings).await
    }

    /// Opens a lux meter.
    ///
    /// # Errors
    /// [`OpenError`].
    pub async fn lux_meter(&self, open: &str) -> Result<Box<dyn LuxMeter>, OpenError> {
        let target = Target::parse(open)?.within(&self.folder);
        if driver(target.driver()).is_some_and(|driver| reads_light_by_spectra(driver, Kind::LuxMeter)) {
            let (settings, instrument) = spectral_lux::Settings::of(&target)?;
            let instrument = self.spectroradiometer_at(&instrument).await?;
            return Ok(Box::new(SpectralLuxMeter::open(instrument, settings).await?));
        }
        let (target, factory) = self.factory(open, Kind::LuxMeter, |opens| opens.lux_meter.as_ref())?;
        factory.open_lux_meter(&target).await
    }

    /// Opens a spectroradiometer.
    ///
    /// # Errors
    /// [`OpenError`].
    pub async fn spectroradiometer(&self, open: &str) -> Result<Box<dyn Spectroradiometer>, OpenError> {
        self.spectroradiometer_at(&Target::parse(open)?.within(&self.folder))
            .await
    }

    async fn spectroradiometer_at(&self, target: &Target) -> Result<Box<dyn Spectroradiometer>, OpenError> {
        let factory = self.factory_of(target, Kind::Spectroradiometer, |opens| {
            opens.spectroradiometer.as_ref()
        })?;
        factory.open_spectroradiometer(target).await
    }

    /// Opens a switch.
    ///
    /// # Errors
    /// [`OpenError`].
    pub async fn switch(&self, open: &str) -> Result<Box<dyn Switch>, OpenError> {
        let (target, factory) = self.factory(open, Kind::Switch, |opens| opens.switch.as_ref())?;
        factory.open_switch(&target).await
    }

    /// Opens a thermometer.
    ///
    /// # Errors
    /// [`OpenError`].
    pub async fn thermometer(&self, open: &str) -> Result<Box<dyn Thermometer>, OpenError> {
        let (target, factory) = self.factory(open, Kind::Thermometer, |opens| opens.thermometer.as_ref())?;
        factory.open_thermometer(&target).await
    }

    /// Opens a power meter.
    ///
    /// # Errors
    /// [`OpenError`].
    pub async fn power_meter(&self, open: &str) -> Result<Box<dyn PowerMeter>, OpenError> {
        let (target, factory) = self.factory(open, Kind::PowerMeter, |opens| opens.power_meter.as_ref())?;
        factory.open_power_meter(&target).await
    }

    /// Opens a recorder of waveforms.
    ///
    /// # Errors
    /// [`OpenError`].
    pub async fn waveform_recorder(&self, open: &str) -> Result<Box<dyn WaveformRecorder>, OpenError> {
        let (target, factory) = self.factory(open, Kind::WaveformRecorder, |opens| opens.waveform_recorder.as_ref())?;
        factory.open_waveform_recorder(&target).await
    }

    fn factory<'a, F: ?Sized>(
        &'a self,
        open: &str,
        kind: Kind,
        select: impl Fn(&'a Factories) -> Option<&'a Arc<F>>,
    ) -> Result<(Target, &'a Arc<F>), OpenError> {
        let target = Target::parse(open)?.within(&self.folder);
        let factory = self.factory_of(&target, kind, select)?;
        Ok((target, factory))
    }

    fn factory_of<'a, F: ?Sized>(
        &'a self,
        target: &Target,
        kind: Kind,
        select: impl Fn(&'a Factories) -> Option<&'a Arc<F>>,
    ) -> Result<&'a Arc<F>, OpenError> {
        placed(target, kind)?;
        let known = self.drivers.iter().find(|(driver, _)| driver.name == target.driver());
        match known.and_then(|(_, factories)| select(factories)) {
            Some(factory) => Ok(factory),
            // Its examples say that it does: `every_driver_has_one_example_a_kind_and_reads_it`.
            None => Err(target.wrong(format!("driver {} opens no {}", target.driver(), kind.name()))),
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
                ErrorKind::TakenOver => "wait until that process ends, or end it",
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

    /// The table of drivers in the book is made from their constants: `WRITE_PAGE=1 cargo test -p isolux-app --lib page`
    /// writes it.
    #[test]
    fn the_page_of_instruments_has_a_row_for_every_driver_as_it_says() {
        const PAGE: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/../../docs/src/devices.md");
        const HEAD: &str = "| driver | instruments | tried with |\n|---|---|---|\n";
        let page = std::fs::read_to_string(PAGE).unwrap();
        let begin = page.find(HEAD).unwrap() + HEAD.len();
        let end = begin + page[begin..].find("\n\n").unwrap() + 1;
        let row = |driver: &Driver| {
            let Driver {
                name,
                speaks_to,
                seen_with,
                ..
            } = driver;
            format!("| `{name}` | {speaks_to} | {seen_with} |\n")
        };
        let made = page[..begin].to_owned() + &drivers().map(row).collect::<String>() + &page[end..];
        if std::env::var_os("WRITE_PAGE").is_some() {
            std::fs::write(PAGE, made).unwrap();
            return;
        }
        for (written, made) in page.lines().zip(made.lines()) {
            assert_eq!(written, made, "write docs/src/devices.md with WRITE_PAGE=1");
        }
        assert_eq!(page.len(), made.len(), "write docs/src/devices.md with WRITE_PAGE=1");
    }

    #[test]
    fn every_driver_has_one_example_a_kind_and_reads_it() {
        let catalogue = Catalogue::new(Arc::new(MemoryLinks::default()));
        for (driver, factories) in &catalogue.drivers {
            let kinds: Vec<Kind> = driver.examples.iter().map(|(kind, _)| *kind).collect();
            assert_eq!(kinds, factories.kinds(), "{}: one example a kind", driver.name);
            for (kind, example) in driver.examples {
                let target = Target::parse(example).unwrap();
                assert_eq!(target.driver(), driver.name);
                (driver.place)(&target, *kind).unwrap();
                let misspelt = Target::parse(&format!("{}?no_such_option=1", example.split('?').next().unwrap()));
                assert!((driver.place)(&misspelt.unwrap(), *kind).is_err(), "{example}");
            }
            for (kind, example) in examples(driver) {
                placed(&Target::parse(&example).unwrap(), kind).unwrap();
            }
            let same = drivers().filter(|other| other.name == driver.name).count();
            assert_eq!(same, 1, "{}: one driver a name", driver.name);
        }
    }

    #[tokio::test(start_paused = true)]
    async fn a_profile_begins_in_the_folder_of_the_station_wherever_the_program_was_started() {
        let folder = tempfile::tempdir().unwrap();
        let station = Utf8Path::from_path(folder.path()).unwrap().join("station.toml");
        let open = "ascii-lux:memory:nowhere?profile=meter.toml";
        let profile = include_str!("../../../../drivers/luxmeter/profiles/template.toml");
        std::fs::write(folder.path().join("meter.toml"), profile).unwrap();
        place(open, Kind::LuxMeter, &station).unwrap();
        let catalogue = || Catalogue::new(Arc::new(MemoryLinks::default()));
        let opened = catalogue().beside(&station).lux_meter(open).await;
        assert!(
            matches!(opened, Err(OpenError::Link { .. })),
            "the profile is read, the link is not there"
        );
        let elsewhere = place(open, Kind::LuxMeter, Utf8Path::new("elsewhere/station.toml")).unwrap_err();
        assert!(elsewhere.to_string().contains("elsewhere/meter.toml"), "{elsewhere}");
        assert!(matches!(
            catalogue().lux_meter(open).await,
            Err(OpenError::Address { .. })
        ));
    }

    #[test]
    fn a_display_is_that_of_the_driver() {
        let here = Utf8Path::new("station.toml");
        assert_eq!(display_lx("konica-t10a:/dev/ttyUSB1?head=0", here)[0], (29.99, 0.01));
        assert_eq!(display_lx("zaber:/dev/ttyUSB1", here), []);
        assert_eq!(display_lx("nobody:/dev/ttyUSB1", here), []);
    }
}
