//! A station file becomes open instruments.

use camino::{Utf8Path, Utf8PathBuf};
use isolux_device::{Axis, AxisScale, AxisSettings, Coordinate, Identity, OpenError, Sense};
use isolux_record::disk::sha256;
use isolux_record::document::{self, Fault};
use isolux_record::responsivity::{MeterCurves, WavelengthCurve};
use isolux_record::run::{BenchCheck, RunHeader};
use isolux_record::spectra::{SpectralCalibration, SpectralCorrections, corrected_by, parse_calibration};
use isolux_record::station::{self, Access};
use isolux_record::{Plan, Station};
use isolux_scan::{CalibratedSpectro, Devices, TwoState, spectrum};
use isolux_spectrum::Spectrum;
use isolux_spectrum::meter::f1_prime;
use isolux_units::Millimetre;

use crate::instruments::catalogue::{Catalogue, open_failure};
use crate::instruments::{corrections, roles};
use crate::{Failure, history};

/// Name and version of this program, as records carry it.
pub const PROGRAM: &str = concat!("isolux ", env!("CARGO_PKG_VERSION"));

/// A station and the calibration that it names.
#[derive(Debug, Clone)]
pub struct StationFiles {
    /// Name of the station file, for messages.
    pub file: Utf8PathBuf,
    /// The station.
    pub station: Station,
    /// Name and text of the spectroradiometer's calibration.
    pub calibration: Option<(Utf8PathBuf, String)>,
    /// What the diary of the bench says of it.
    pub checks: Vec<BenchCheck>,
    /// What the head of the lux meter answers, where the station names it.
    pub luxmeter: Option<MeterCurves>,
    /// What the laboratory has found of the spectroradiometer.
    pub corrections: SpectralCorrections,
}

impl StationFiles {
    /// Reads a station file and the calibration beside it. Nothing is opened.
    ///
    /// # Errors
    /// Bad input (exit 2) with file and line, also for two roles on one instrument and a calibration that is not there.
    pub fn load(file: &Utf8Path) -> Result<Self, Failure> {
        let text = document::read_text(file).map_err(Failure::bad_input)?;
        let station = Station::parse(file, &text).map_err(Failure::bad_input)?;
        let located = |fault: &Fault| Failure::bad_input(document::SourceText { file, text: &text }.locate(fault));
        roles::distinct(&station, file).map_err(|fault| located(&fault).help("nothing was opened"))?;
        let calibration = match station.spectral_calibration(file) {
            Some(path) => {
                let text = document::read_text(&path).map_err(|error| {
                    located(&Fault {
                        path: "spectroradiometer.calibration".to_owned(),
                        message: error.to_string(),
                    })
                    .help("put the file there, or write calibration = \"device\" for the factors that the instrument stores")
                })?;
                parse_calibration(&path, &text).map_err(Failure::bad_input)?;
                Some((path, text))
            }
            // No spectroradiometer, or the calibration that it stores itself.
            None => None,
        };
        let corrections = corrections::load(&station, file).map_err(|error| match error {
            corrections::Unusable::Missing(fault) => located(&fault).help("put the file there, or remove the key"),
            corrections::Unusable::Wrong(error) => Failure::bad_input(error),
        })?;
        Ok(Self {
            file: file.to_owned(),
            luxmeter: curves(file, &station, &located)?,
            station,
            calibration,
            checks: history::checks(file)?,
            corrections,
        })
    }

    /// A station from text, for the virtual darkroom; `calibration` is the text of the file that it names, if it does.
    ///
    /// # Errors
    /// Bad input (exit 2) with the line.
    pub fn from_text(station: &str, calibration: Option<&str>) -> Result<Self, Failure> {
        let file = Utf8Path::new("virtual darkroom");
        let station = Station::parse(file, station).map_err(Failure::bad_input)?;
        let name = station
            .spectroradiometer()
            .map(|spectro| Utf8PathBuf::from(&spectro.calibration));
        let calibration = name.zip(calibration.map(str::to_owned));
        Ok(Self {
            file: file.to_owned(),
            station,
            calibration,
            corrections: SpectralCorrections::default(),
            checks: Vec::new(),
            luxmeter: None,
        })
    }

    /// The same with the text of the responsivity that the station names.
    ///
    /// # Errors
    /// Bad input (exit 2) with the line.
    pub fn with_responsivity(self, text: &str) -> Result<Self, Failure> {
        let file = self.station.responsivity(&self.file).unwrap_or_default();
        let responsivity = responsivity(&file, text)?;
        Ok(Self {
            luxmeter: Some(MeterCurves {
                responsivity,
                calibration_light: None,
            }),
            ..self
        })
    }

    /// Opens every instrument of the station. Nothing moves.
    ///
    /// # Errors
    /// Bad input (exit 2) for an address that is none; exit 3, with the key of the station, for an instrument that does
    /// not open.
    pub async fn open(&self, catalogue: &Catalogue) -> Result<Devices, Failure> {
        let station = &self.station;
        let axis_c = open_axis(catalogue, "axis.c", station.axis_c()).await?;
        let axis_gamma = open_axis(catalogue, "axis.gamma", station.axis_gamma()).await?;
        for (role, axis, settings) in [
            ("axis.c", &axis_c, station.axis_c()),
            ("axis.gamma", &axis_gamma, station.axis_gamma()),
        ] {
            is_the_one(role, settings.serial.as_deref(), axis.identity())?;
        }
        let meter = catalogue
            .lux_meter(&station.luxmeter().open)
            .await
            .map_err(|error| failed("luxmeter", error))?;
        is_the_one("luxmeter", station.luxmeter().serial.as_deref(), meter.identity())?;
        let spectro = self.open_spectro(catalogue).await?;
        let power = match station.powermeter() {
            Some(settings) => {
                let meter = catalogue.power_meter(&settings.open).await;
                let meter = meter.map_err(|error| failed("powermeter", error))?;
                is_the_one("powermeter", settings.serial.as_deref(), meter.identity())?;
                Some(meter)
            }
            None => None,
        };
        let switched_by = if station.supply().is_some() { "supply" } else { "lamp" };
        let lamp = two_state(catalogue, switched_by, station.lamp_switch().as_ref()).await?;
        let ambient = match station.ambient().and_then(|ambient| ambient.open.as_deref()) {
            Some(open) => Some(
                catalogue
                    .thermometer(open)
                    .await
                    .map_err(|error| failed("ambient", error))?,
            ),
            None => None,
        };
        Ok(Devices {
            axis_c,
            axis_gamma,
            meter,
            spectro,
            power,
            lamp,
            shutter: two_state(catalogue, "shutter", station.shutter()).await?,
            baffle: two_state(catalogue, "baffle", station.baffle()).await?,
            rail: open_rail(catalogue, station).await?,
            ambient,
        })
    }

    /// Opens the spectroradiometer and applies its calibration.
    ///
    /// # Errors
    /// As [`open`](Self::open).
    pub async fn open_spectro(&self, catalogue: &Catalogue) -> Result<Option<CalibratedSpectro>, Failure> {
        let Some(settings) = self.station.spectroradiometer() else {
            return Ok(None);
        };
        let device = catalogue
            .spectroradiometer(&settings.open)
            .await
            .map_err(|error| failed("spectroradiometer", error))?;
        is_the_one("spectroradiometer", settings.serial.as_deref(), device.identity())?;
        corrections::of_this_one(&self.corrections, device.identity())?;
        let properties = device.properties();
        let (name, bytes, factor_w_m2_nm) = if let Some((file, text)) = &self.calibration {
            let table = parse_calibration(file, text).map_err(Failure::bad_input)?;
            // By the wavelengths that the instrument states a table knows the pixels, whatever the true ones are.
            let factors = spectrum::factors_at(&properties.wavelength_nm, &table);
            (file.file_name().unwrap_or("calibration"), text.clone(), factors)
        } else {
            let factors = properties.irradiance_factor.clone().ok_or_else(|| {
                Failure::bad_input(
                    "spectroradiometer: calibration = \"device\", but the instrument stores none that can be used",
                )
                .help("name a CSV file of wavelength_nm,factor beside the station")
            })?;
            let text = factors
                .iter()
                .fold(String::new(), |text, factor| text + &format!("{factor:e}\n"));
            ("device", text, factors)
        };
        let sha256 = sha256(bytes.as_bytes());
        let calibration = SpectralCalibration {
            file: name.to_owned(),
            sha256,
            saturation_counts: f64::from(properties.saturation_counts),
            full_scale_counts: f64::from(properties.full_scale_counts),
            nonlinearity: properties.nonlinearity.clone(),
            dark_pixels: [properties.dark_pixels.start, properties.dark_pixels.end],
            corrections: self.corrections.clone(),
            factors_corrected_by: self
                .calibration
                .as_ref()
                .and_then(|(_, text)| Some(corrected_by(text)?.to_owned())),
        };
        Ok(Some(CalibratedSpectro {
            device,
            factor_w_m2_nm,
            calibration,
        }))
    }

    /// run.toml of a run that begins at `started_utc`.
    pub fn header(&self, devices: &Devices, plan: &Plan, started_utc: String) -> RunHeader {
        RunHeader {
            bench_check: self.checks.clone(),
            luxmeter: self.luxmeter.clone(),
            ..RunHeader::new(
                PROGRAM.to_owned(),
                started_utc,
                devices.records(&self.station),
                devices.spectro.as_ref().map(|spectro| spectro.calibration.clone()),
                self.station.clone(),
                plan.clone(),
            )
        }
    }
}

/// A head that is farther from V(λ) is no head of a lux meter, but another column or another file.
const LARGEST_F1_PRIME: f64 = 0.3;

/// The curves that the lux meter of a station names.
///
/// # Errors
/// Bad input (exit 2): the key of a file that cannot be read, the line of one that is no such curve.
fn curves(
    file: &Utf8Path,
    station: &Station,
    located: &impl Fn(&Fault) -> Failure,
) -> Result<Option<MeterCurves>, Failure> {
    let text = |path: &Utf8Path, key: &str| {
        document::read_text(path)
            .map_err(|error| located(&Fault::new(key, error.to_string())).help("put the file there, or remove the key"))
    };
    let Some(path) = station.responsivity(file) else {
        return Ok(None);
    };
    let responsivity = responsivity(&path, &text(&path, "luxmeter.responsivity")?)?;
    let calibration_light = match station.calibration_light(file) {
        Some(path) => {
            let text = text(&path, "luxmeter.calibration_light")?;
            Some(WavelengthCurve::light(&path, &text).map_err(Failure::bad_input)?)
        }
        None => None,
    };
    Ok(Some(MeterCurves {
        responsivity,
        calibration_light,
    }))
}

/// The responsivity of a head.
///
/// # Errors
/// Bad input (exit 2) with the line, also for one that is far from V(λ).
fn responsivity(path: &Utf8Path, text: &str) -> Result<WavelengthCurve, Failure> {
    let curve = WavelengthCurve::responsivity(path, text).map_err(Failure::bad_input)?;
    let spectrum = Spectrum::new(curve.wavelength_nm.clone(), curve.value.clone()).map_err(Failure::bad_input)?;
    match f1_prime(&spectrum) {
        Some(index) if index <= LARGEST_F1_PRIME => Ok(curve),
        index => Err(Failure::bad_input(format!(
            "{path}: is no responsivity of a lux meter: f1′ is {}",
            index.map_or_else(|| "not known".to_owned(), |index| format!("{:.0} %", 100.0 * index))
        ))
        .help("it is relative to the light in W, near V(λ): 1 about 555 nm, 0.1 at 475 nm and 651 nm")),
    }
}

/// That the instrument of `role` has the serial number which its station states, if it states one.
///
/// # Errors
/// Exit 3 with the key, both numbers and what to do.
pub fn is_the_one(role: &str, stated: Option<&str>, found: &Identity) -> Result<(), Failure> {
    let (Some(stated), answer) = (stated, found.serial.as_deref()) else {
        return Ok(());
    };
    match answer {
        Some(serial) if serial == stated => Ok(()),
        Some(serial) => Err(Failure::instrument(format!(
            "{role}.serial: the station states {stated}, {} at {} answers {serial}",
            found.model, found.target
        ))
        .help("put the right instrument on the cable, or state the other number with its own calibration")),
        None => Err(Failure::bad_input(format!(
            "{role}.serial: {} at {} cannot be asked for its number",
            found.model, found.target
        ))
        .help("remove the key: the certificate alone ties this instrument to its calibration")),
    }
}

/// Opens one axis of a station. Nothing moves.
///
/// # Errors
/// Bad input (exit 2) or exit 3, with the key of the station.
pub async fn open_axis(
    catalogue: &Catalogue,
    role: &'static str,
    axis: &station::Axis,
) -> Result<Box<dyn Axis>, Failure> {
    let settings = settings(
        role,
        axis.counts_per_deg,
        axis.zero_deg,
        axis.sense,
        axis.limit_deg,
        (axis.speed_deg_s, axis.accel_deg_s2),
    )?;
    catalogue
        .axis(&axis.open, settings)
        .await
        .map_err(|error| failed(role, error))
}

/// Opens the detector's rail, if it is driven.
///
/// # Errors
/// Bad input (exit 2) or exit 3, with the key of the station.
pub async fn open_rail(catalogue: &Catalogue, station: &Station) -> Result<Option<Box<dyn Axis<Millimetre>>>, Failure> {
    let Some(rail) = station.rail().and_then(station::Rail::driven) else {
        return Ok(None);
    };
    let dynamics = (rail.speed_mm_s, rail.accel_mm_s2);
    let settings = settings(
        "rail",
        rail.counts_per_mm,
        rail.zero_mm,
        rail.sense,
        rail.limit_mm,
        dynamics,
    )?;
    catalogue
        .linear_axis(rail.open, settings)
        .await
        .map(Some)
        .map_err(|error| failed("rail", error))
}

fn settings<P: Coordinate>(
    role: &str,
    ratio: station::Ratio,
    zero: f64,
    sense: i8,
    limit: [f64; 2],
    (speed, acceleration): (f64, f64),
) -> Result<AxisSettings<P>, Failure> {
    let bad = |error: &dyn std::fmt::Display| Failure::bad_input(format!("{role}: {error}"));
    let part = |value: i64| u32::try_from(value).map_err(|_| bad(&format!("counts ratio {ratio} is too large")));
    let place = |value: f64| P::at(value).map_err(|error| bad(&error));
    let sense = if sense < 0 { Sense::Negative } else { Sense::Positive };
    let scale = AxisScale::new(
        part(ratio.numerator())?,
        part(ratio.denominator())?,
        place(zero)?,
        sense,
    )
    .map_err(|error| bad(&error))?;
    AxisSettings::new(scale, (place(limit[0])?, place(limit[1])?), speed, acceleration).map_err(|error| bad(&error))
}

async fn two_state(
    catalogue: &Catalogue,
    role: &'static str,
    access: Option<&Access>,
) -> Result<Option<TwoState>, Failure> {
    match access {
        Some(Access { open: Some(open), .. }) => {
            let switch = catalogue.switch(open).await.map_err(|error| failed(role, error))?;
            Ok(Some(TwoState::Device(switch)))
        }
        Some(Access {
            prompt: Some(prompt), ..
        }) => Ok(Some(TwoState::Person(prompt.clone()))),
        _ => Ok(None),
    }
}

/// The failure of the catalogue, with the key of the station.
fn failed(role: &str, error: OpenError) -> Failure {
    let failure = open_failure(error);
    Failure {
        message: format!("{role}: {}", failure.message),
        ..failure
    }
}
