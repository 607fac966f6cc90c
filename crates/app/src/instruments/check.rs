//! `check`: talk to every instrument, read identity, limits and dark; move nothing.

use camino::Utf8Path;
use isolux_device::{Axis, Coordinate, Identity};
use isolux_record::station::Access;
use isolux_scan::electrical;
use serde::Serialize;
use tokio::time::Instant;

use crate::Failure;
use crate::files::Overwrite;
use crate::front_end::progress::Progress;
use crate::instruments::bench::{self, StationFiles};
use crate::instruments::catalogue::Catalogue;
use crate::instruments::roles;
use crate::instruments::session::{self, Session};
use crate::manual::{self, Lux};

/// What was found at one place of the station.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Found {
    /// Its part: `axis.c`, `luxmeter`, …
    pub role: &'static str,
    /// As the station has it.
    pub open: String,
    /// Whether it answered as it should.
    pub ok: bool,
    /// Model, serial number and firmware, as far as the language can ask for them.
    pub identity: Option<String>,
    /// What it says of itself, in sentences with units.
    pub facts: Vec<String>,
    /// Why it did not answer.
    pub error: Option<String>,
}

/// Everything that was found.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Report {
    /// One entry an instrument, in the order of the station.
    pub instruments: Vec<Found>,
    /// Readings of the capped lux meter, where a shutter could be closed.
    pub dark: Vec<Lux>,
}

impl Report {
    /// Whether every instrument answered.
    pub fn all_well(&self) -> bool {
        self.instruments.iter().all(|found| found.ok)
    }
}

/// Readings of the dark.
const DARK_READINGS: u32 = 5;

/// Checks a station; with `record`, every byte on its links is written to that file.
///
/// # Errors
/// Bad input (exit 2) for the station, exit 3 when the trace cannot be written or an instrument belongs to another
/// process (`force` is the reason for which it may be taken over from one that does not answer). An instrument that
/// fails is no error here but in the report: the others are still checked.
pub fn run(
    station: &Utf8Path,
    record: Option<&Utf8Path>,
    overwrite: Overwrite,
    force: Option<&str>,
    progress: &dyn Progress,
) -> Result<Report, Failure> {
    let source = StationFiles::load(station)?;
    if let Some(path) = record {
        crate::files::refuse_existing(path, overwrite)?;
    }
    let in_memory = roles::is_virtual(&source.station);
    session::run(in_memory, async {
        let session = Session::recording(&source.station, &source.file, record, progress)?;
        session.claim(&source.station, force).await?;
        let catalogue = Catalogue::new(session.links.clone()).beside(&source.file);
        let mut report = Report {
            instruments: Vec::new(),
            dark: Vec::new(),
        };
        let station = &source.station;
        for (role, axis) in [("axis.c", station.axis_c()), ("axis.gamma", station.axis_gamma())] {
            let opened = bench::open_axis(&catalogue, role, axis).await.and_then(|opened| {
                bench::is_the_one(role, axis.serial.as_deref(), opened.identity())?;
                Ok(opened)
            });
            report.instruments.push(of_axis(role, &axis.open, opened).await);
        }
        if let Some(open) = station.rail().and_then(|rail| rail.open.clone())
            && let Some(rail) = bench::open_rail(&catalogue, station).await.transpose()
        {
            report.instruments.push(of_axis("rail", &open, rail).await);
        }
        light(&source, &catalogue, &mut report).await;
        spectro(&source, &catalogue, &mut report).await;
        power(&source, &catalogue, &mut report).await;
        for (role, open) in [
            ("supply", station.supply().map(|supply| supply.open.as_str())),
            ("lamp", station.lamp().and_then(|lamp| lamp.open.as_deref())),
            ("baffle", station.baffle().and_then(|access| access.open.as_deref())),
        ] {
            if let Some(open) = open {
                report.instruments.push(switch(&catalogue, role, open).await);
            }
        }
        if let Some(open) = station.ambient().and_then(|access| access.open.as_deref()) {
            report.instruments.push(thermometer(&catalogue, open).await);
        }
        Ok(report)
    })
}

async fn of_axis<P: Coordinate>(role: &'static str, open: &str, opened: Result<Box<dyn Axis<P>>, Failure>) -> Found {
    let unit = P::UNIT;
    let mut found = blank(role, open);
    match opened {
        Err(error) => found.error = Some(stated(&error)),
        Ok(axis) => {
            found.identity = Some(identity(axis.identity()));
            let (low, high) = axis.settings().limit();
            found
                .facts
                .push(format!("limits {}{unit} to {}{unit}", low.number(), high.number()));
            match axis.position().await {
                Ok(position) => {
                    let homed = if position.homed { "homed" } else { "not homed" };
                    let moving = if position.moving { ", MOVING" } else { ", at rest" };
                    found
                        .facts
                        .push(format!("at {:.4}{unit}, {homed}{moving}", position.place.number()));
                    found.ok = true;
                }
                Err(error) => found.error = Some(error.to_string()),
            }
        }
    }
    found
}

/// The lux meter and, through the shutter, its dark.
async fn light(source: &StationFiles, catalogue: &Catalogue, report: &mut Report) {
    let settings = source.station.luxmeter();
    let mut found = blank("luxmeter", &settings.open);
    let shutter_open = source
        .station
        .shutter()
        .and_then(|access: &Access| access.open.as_deref());
    let shutter = match shutter_open {
        Some(open) => Some((
            switch(catalogue, "shutter", open).await,
            catalogue.switch(open).await.ok(),
        )),
        None => None,
    };
    match catalogue.lux_meter(&settings.open).await {
        Err(error) => found.error = Some(error.to_string()),
        Ok(meter) => {
            found.identity = Some(identity(meter.identity()));
            found
                .facts
                .push(format!("a new value every {:?}", meter.properties().update_interval));
            let device = shutter.as_ref().and_then(|(_, device)| device.as_ref());
            let before = match device {
                Some(device) => device.state().await.ok(),
                None => None,
            };
            let capped = match (device, before) {
                (Some(device), Some(_)) => device.set(false).await.is_ok(),
                _ => false,
            };
            let dark = if capped {
                isolux_scan::dark::take(meter.as_ref()).await
            } else {
                Ok(None)
            };
            if let Ok(Some(said)) = &dark {
                found.facts.push(said.clone());
            }
            let factor = settings.calibration_factor;
            let read = match dark {
                Ok(_) => manual::readings(meter.as_ref(), None, factor, DARK_READINGS).await,
                Err(error) => Err(error),
            };
            match read {
                Ok(readings) => {
                    let state = if capped { "capped" } else { "as it stands" };
                    let shown: Vec<String> = readings
                        .iter()
                        .map(|reading| {
                            reading
                                .illuminance_lx
                                .map_or_else(|| reading.quality.to_owned(), |lux| format!("{lux:.3} lx"))
                        })
                        .collect();
                    found.facts.push(format!("reads {state}: {}", shown.join(", ")));
                    if capped {
                        report.dark = readings;
                    }
                    found.ok = true;
                }
                Err(error) => found.error = Some(error.to_string()),
            }
            if let (Some(device), Some(true)) = (device, before)
                && let Err(error) = device.set(true).await
            {
                found.error = Some(format!("the shutter was open and did not open again: {error}"));
                found.ok = false;
            }
            let number = bench::is_the_one("luxmeter", settings.serial.as_deref(), meter.identity());
            judge(&mut found, number);
        }
    }
    report.instruments.push(found);
    report.instruments.extend(shutter.map(|(found, _)| found));
}

async fn spectro(source: &StationFiles, catalogue: &Catalogue, report: &mut Report) {
    let Some(settings) = source.station.spectroradiometer() else {
        return;
    };
    let mut found = blank("spectroradiometer", &settings.open);
    match source.open_spectro(catalogue).await {
        Err(error) => found.error = Some(stated(&error)),
        Ok(None) => found.error = Some("no calibration".to_owned()),
        Ok(Some(spectro)) => {
            found.identity = Some(identity(spectro.device.identity()));
            let properties = spectro.device.properties();
            if let (Some(first), Some(last)) = (properties.wavelength_nm.first(), properties.wavelength_nm.last()) {
                found.facts.push(format!(
                    "{} pixels, {first:.1} nm to {last:.1} nm",
                    properties.wavelength_nm.len()
                ));
            }
            let (shortest, longest) = properties.integration_limits;
            found.facts.push(format!("integrates {shortest:?} to {longest:?}"));
            found.ok = true;
        }
    }
    report.instruments.push(found);
}

async fn power(source: &StationFiles, catalogue: &Catalogue, report: &mut Report) {
    let Some(settings) = source.station.powermeter() else {
        return;
    };
    let mut found = blank("powermeter", &settings.open);
    match catalogue.power_meter(&settings.open).await {
        Err(error) => found.error = Some(error.to_string()),
        Ok(meter) => {
            found.identity = Some(identity(meter.identity()));
            let interval = meter.update_interval();
            found.facts.push(format!("a new value every {interval:?}"));
            match electrical::read(meter.as_ref(), Instant::now()).await {
                Ok(reading) => {
                    found
                        .facts
                        .push(format!("reads {}", manual::in_words(&electrical::recorded(&reading))));
                    found.ok = true;
                }
                Err(error) => found.error = Some(error.to_string()),
            }
            let number = bench::is_the_one("powermeter", settings.serial.as_deref(), meter.identity());
            judge(&mut found, number);
        }
    }
    report.instruments.push(found);
}

async fn switch(catalogue: &Catalogue, role: &'static str, open: &str) -> Found {
    let mut found = blank(role, open);
    match catalogue.switch(open).await {
        Err(error) => found.error = Some(error.to_string()),
        Ok(switch) => {
            found.identity = Some(identity(switch.identity()));
            match switch.state().await {
                Ok(on) => {
                    let state = match (role, on) {
                        ("shutter", true) => "open",
                        ("shutter", false) => "closed",
                        ("baffle", true) => "in the beam",
                        ("baffle", false) => "out of the beam",
                        (_, true) => "on",
                        (_, false) => "off",
                    };
                    found.facts.push(state.to_owned());
                    found.ok = true;
                }
                Err(error) => found.error = Some(error.to_string()),
            }
        }
    }
    found
}

async fn thermometer(catalogue: &Catalogue, open: &str) -> Found {
    let mut found = blank("ambient", open);
    match catalogue.thermometer(open).await {
        Err(error) => found.error = Some(error.to_string()),
        Ok(thermometer) => {
            found.identity = Some(identity(thermometer.identity()));
            match thermometer.read().await {
                Ok(reading) => {
                    found.facts.push(format!("{:.2} °C", reading.temperature.value()));
                    found.ok = true;
                }
                Err(error) => found.error = Some(error.to_string()),
            }
        }
    }
    found
}

fn blank(role: &'static str, open: &str) -> Found {
    Found {
        role,
        open: open.to_owned(),
        ok: false,
        identity: None,
        facts: Vec::new(),
        error: None,
    }
}

fn identity(identity: &Identity) -> String {
    let mut text = identity.model.clone();
    if let Some(serial) = &identity.serial {
        text.push_str(&format!(", serial {serial}"));
    }
    if let Some(firmware) = &identity.firmware {
        text.push_str(&format!(", firmware {firmware}"));
    }
    text
}

/// What works and is not what the station means is not well.
fn judge(found: &mut Found, judged: Result<(), Failure>) {
    if let Err(failure) = judged {
        found.ok = false;
        found.error = Some(stated(&failure));
    }
}

fn stated(failure: &Failure) -> String {
    match &failure.help {
        Some(help) => format!("{} ({help})", failure.message),
        None => failure.message.clone(),
    }
}
