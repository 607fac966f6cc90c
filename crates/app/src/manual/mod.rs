//! `home`, `move`, `stop`, `read`, `warmup`: one step of the day by hand. Each step is a method of
//! [`open::OpenBench`]; here the station is opened for one of them, and [`held`] keeps it open from step to step.

pub mod held;
pub mod open;
pub mod spectrum;
pub mod stop;

use camino::Utf8Path;
use isolux_device::{LuxMeter, LuxOutcome, PowerMeter};
use isolux_record::Electrical;
use isolux_scan::settle::Photometer;
use isolux_scan::{Cancel, ScanError, electrical};
use serde::Serialize;
use tokio::time::Instant;

use crate::Failure;
use crate::front_end::progress::Progress;
use crate::instruments::bench::StationFiles;
use crate::instruments::{roles, session};
use crate::system::signals::OnSignals;
use open::OpenBench;

/// Where the axes stand, read back.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Position {
    /// C in degrees.
    pub c_deg: f64,
    /// γ in degrees.
    pub gamma_deg: f64,
    /// Distance of the detector in mm, where it was driven.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub distance_mm: Option<f64>,
}

/// An output of the bench.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Output {
    /// On: lit.
    Lamp,
    /// On: open.
    Shutter,
    /// On: in the beam.
    Baffle,
    /// On: it feeds the lamp.
    Supply,
}

impl Output {
    /// Its table in the station file.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Lamp => "lamp",
            Self::Shutter => "shutter",
            Self::Baffle => "baffle",
            Self::Supply => "supply",
        }
    }
}

/// One reading of the lux meter.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Lux {
    /// Illuminance after the station's calibration factor; none out of range or of unsteady light.
    pub illuminance_lx: Option<f64>,
    /// One digit of the display.
    pub digit_lx: f64,
    /// The meter's range.
    pub range: u8,
    /// `ok`, `over_range`, `under_range` or `unsteady`.
    pub quality: &'static str,
    /// The lamp's supply line at that time, where the bench has a power meter.
    #[serde(flatten)]
    pub electrical: Electrical,
}

/// The lamp is stable.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct WarmedUp {
    /// Seconds since it was switched on.
    pub elapsed_s: f64,
    /// (max − min)/mean over the window.
    pub spread_rel: f64,
    /// Illuminance at the reference point.
    pub illuminance_lx: f64,
}

/// Homes both axes. `force` is the reason for which the instruments may be taken over from a process that does not
/// answer.
///
/// # Errors
/// Exit 2 for the station, 3 for an instrument that fails or belongs to another process, or an axis not at rest, 130
/// when interrupted.
pub fn home(station: &Utf8Path, force: Option<&str>, progress: &dyn Progress) -> Result<Position, Failure> {
    let source = StationFiles::load(station)?;
    one_step(source, force, progress, async |bench, cancel| bench.home(cancel).await)
}

/// Switches outputs, one after the other, and reads each back. Nothing moves.
///
/// # Errors
/// As [`home`]; exit 2 for an output that the station does not have or leaves to a person.
pub fn switch(
    station: &Utf8Path,
    outputs: &[(Output, bool)],
    force: Option<&str>,
    progress: &dyn Progress,
) -> Result<Vec<(Output, bool)>, Failure> {
    let source = StationFiles::load(station)?;
    open::driven(&source, outputs)?;
    one_step(source, force, progress, async |bench, cancel| {
        bench.switch(outputs, cancel).await
    })
}

/// Moves both axes to (C, γ) and the detector to a distance; what is not given stays.
///
/// # Errors
/// As [`home`]; exit 2 before anything moves for a position outside the limits, and for a distance without a driven
/// rail.
pub fn move_to(
    station: &Utf8Path,
    c_deg: Option<f64>,
    gamma_deg: Option<f64>,
    distance_mm: Option<f64>,
    force: Option<&str>,
    progress: &dyn Progress,
) -> Result<Position, Failure> {
    let source = StationFiles::load(station)?;
    open::within_limits(&source, c_deg, gamma_deg, distance_mm)?;
    one_step(source, force, progress, async |bench, cancel| {
        bench.move_to(c_deg, gamma_deg, distance_mm, cancel).await
    })
}

impl Lux {
    /// The supply line in words, where there was a power meter that gave a number.
    pub fn electrical(&self) -> Option<String> {
        (self.electrical != Electrical::default()).then(|| in_words(&self.electrical))
    }
}

/// Volts, amperes, watts and power factor; a dash where the meter gave no number.
pub(crate) fn in_words(reading: &Electrical) -> String {
    let shown =
        |value: Option<f64>, unit: &str| value.map_or_else(|| "–".to_owned(), |value| format!("{value:.5}{unit}"));
    [
        shown(reading.voltage_v, " V"),
        shown(reading.current_a, " A"),
        shown(reading.power_w, " W"),
        format!("power factor {}", shown(reading.power_factor, "")),
    ]
    .join(", ")
}

/// Reads the lux meter `count` times, and the power meter with it, with lamp, shutter and baffle as they are.
///
/// # Errors
/// As [`home`].
pub fn read(station: &Utf8Path, count: u32, force: Option<&str>, progress: &dyn Progress) -> Result<Vec<Lux>, Failure> {
    let source = StationFiles::load(station)?;
    one_step(source, force, progress, async |bench, cancel| {
        bench.read(count, cancel).await
    })
}

/// Switches the lamp on, opens the path, goes to the reference point and waits until the lamp is stable.
///
/// # Errors
/// As [`home`]; exit 1 when it does not become stable.
pub fn warm_up(station: &Utf8Path, force: Option<&str>, progress: &dyn Progress) -> Result<WarmedUp, Failure> {
    let source = StationFiles::load(station)?;
    one_step(source, force, progress, async |bench, cancel| {
        bench.warm_up(cancel, progress).await
    })
}

/// `count` new readings.
///
/// # Errors
/// What the meter reports.
pub(crate) async fn readings(
    meter: &dyn LuxMeter,
    power: Option<&dyn PowerMeter>,
    factor: f64,
    count: u32,
) -> Result<Vec<Lux>, ScanError> {
    let mut photometer = Photometer::new(meter);
    let mut list = Vec::new();
    for _ in 0..count {
        let now = Instant::now();
        let reading = photometer.read(now).await?;
        let electrical = match power {
            Some(power) => electrical::recorded(&electrical::read(power, now).await?),
            None => Electrical::default(),
        };
        let quality = match reading.outcome {
            LuxOutcome::Measured(_) => "ok",
            LuxOutcome::OverRange => "over_range",
            LuxOutcome::UnderRange => "under_range",
            LuxOutcome::Unsteady => "unsteady",
        };
        list.push(Lux {
            illuminance_lx: reading.illuminance().map(|lux| lux.value() * factor),
            digit_lx: reading.digit.value() * factor,
            range: reading.range,
            quality,
            electrical,
        });
    }
    Ok(list)
}

/// Opens the station for one `step` under a handle for signals.
pub(crate) fn one_step<T>(
    source: StationFiles,
    force: Option<&str>,
    progress: &dyn Progress,
    step: impl AsyncFnOnce(&OpenBench, &Cancel) -> Result<T, Failure>,
) -> Result<T, Failure> {
    session::run(roles::is_virtual(&source.station), async {
        let cancel = OnSignals::listen()?;
        let outcome = async {
            let bench = OpenBench::open(source, force, progress).await?;
            step(&bench, &cancel).await
        }
        .await;
        cancel.until_reported(outcome)
    })
}

pub(crate) fn device(role: &'static str) -> impl Fn(isolux_device::DeviceError) -> ScanError {
    move |source| ScanError::Device { role, source }
}
