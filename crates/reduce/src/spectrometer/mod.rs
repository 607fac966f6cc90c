//! A run of a procedure → what is found of a spectroradiometer itself: wavelength scale and bandpass, light scattered
//! inside, linearity.

mod error;
mod image;
mod linearity;
mod lines;
mod scale;
mod scatter;

use isolux_record::plan::Instrument;
use isolux_record::run::StopHow;
use isolux_record::spectra::{Made, SpectralCalibration, SpectrumRecord};
use isolux_record::{ReadingKind, Run};

use crate::instrument::{Chain, Linear};

pub use error::InstrumentError;
pub use linearity::linearity;
pub use lines::wavelengths;
pub use scatter::scatter;

/// The spectra of a procedure, two at least and none saturated, in the order of time.
struct Spectra<'a> {
    calibration: &'a SpectralCalibration,
    records: Vec<&'a SpectrumRecord>,
}

impl<'a> Spectra<'a> {
    /// Those of a kind in a finished run; `what` they are of.
    fn of(run: &'a Run, kind: ReadingKind, what: &'static str) -> Result<Self, InstrumentError> {
        if run.header.stopped.as_ref().map(|stopped| stopped.how) != Some(StopHow::Completed) {
            return Err(InstrumentError::Unfinished);
        }
        let calibration = run.header.spectral.as_ref();
        let calibration = calibration.ok_or(InstrumentError::NoSpectroradiometer)?;
        let in_plan = |record: &&SpectrumRecord| {
            let mut blocks = run.header.plan.blocks().iter();
            record.kind == kind
                && blocks.any(|block| block.name == record.block && block.instrument == Instrument::Spectroradiometer)
        };
        let records: Vec<&SpectrumRecord> = run.spectra.iter().filter(in_plan).collect();
        if records.len() < 2 {
            return Err(InstrumentError::NoSpectra(what));
        }
        for record in &records {
            if let Some(pixel) = record.pixels.iter().find(|pixel| pixel.saturated) {
                return Err(InstrumentError::Saturated {
                    file: format!("spectra/{:03}.csv", record.index),
                    wavelength_nm: pixel.wavelength_nm,
                });
            }
        }
        Ok(Self { calibration, records })
    }
}

/// Light of the last spectrum over that of the first, less 1, which is at most `limit_rel`.
fn steady(
    records: &[&SpectrumRecord],
    calibration: &SpectralCalibration,
    limit_rel: f64,
) -> Result<f64, InstrumentError> {
    let total = |record| -> Result<f64, InstrumentError> {
        let linear = Linear::of(record, calibration, Chain::ALL)?;
        Ok(linear.per_s.iter().flatten().sum())
    };
    let [first, .., last] = *records else { return Ok(0.0) };
    let change_rel = total(last)? / total(first)? - 1.0;
    if change_rel.abs() > limit_rel {
        return Err(InstrumentError::Unsteady { change_rel, limit_rel });
    }
    Ok(change_rel)
}

/// Where what a run shows comes from; the hash of its record is for whoever has the file.
fn made(run: &Run, with: &str) -> Made {
    let mut devices = run.header.device.iter();
    let device = devices.find(|device| device.role == "spectroradiometer");
    let instrument = device.map_or_else(String::new, |device| {
        format!("{} {}", device.model, device.serial.as_deref().unwrap_or(""))
    });
    Made {
        instrument: instrument.trim().to_owned(),
        day: run.header.started_utc.chars().take(10).collect(),
        with: with.to_owned(),
        record_sha256: String::new(),
    }
}
