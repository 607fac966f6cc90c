//! The events of a scan as they are shown, from the bench and from a record alike: what each means, in a state and in a
//! sentence.

use isolux_record::ReadingKind;
use isolux_record::plan::Instrument;
use isolux_record::run::RunHeader;
use isolux_record::spectra::{DarkSubtraction, SpectralCalibration, SpectrumRecord};
pub use isolux_record::{Event, Logged, Reading, Role};
use isolux_scan::itinerary::{Visit, visits};
use isolux_scan::warmup::Criterion;
use serde::Serialize;

use crate::instruments::roles;

/// Points of a spectrum that a screen shows.
const SHOWN_PIXELS: usize = 400;

/// An event and what it means. Its time is of the bench's own clock, which is virtual where the bench is.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Live {
    /// The event.
    #[serde(flatten)]
    pub logged: Logged,
    /// What the bench does from now on; none: as before.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub state: Option<State>,
    /// In words, for the journal.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub sentence: Option<String>,
    /// How much is left, where that has changed.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub left: Option<Remaining>,
    /// Of a visit to the reference point: its change against the first since the lamp was switched on.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub drift_rel: Option<f64>,
    /// Of a spectrum: its curve.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub curve: Option<Curve>,
}

/// What the bench does.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum State {
    /// The axes search their reference.
    Homing,
    /// The lamp is watched until it is stable.
    WarmingUp,
    /// Points are read.
    Scanning,
    /// Paused: axes at rest, lamp on.
    Paused,
    /// After a pause: the reference point is visited before the scan goes on.
    Resuming,
    /// Every point was read.
    Completed,
    /// Somebody ended the scan.
    Interrupted,
    /// A check failed or an instrument did.
    Failed,
    /// The record follows: reduction, simulation, diagnosis.
    Evaluating,
}

/// What is going to be measured, and the limits that the readings are held against.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Outline {
    /// The run directory.
    pub run: String,
    /// When the scan began.
    pub started_utc: String,
    /// Name or manufacturer's text of the bench.
    pub bench: String,
    /// Every point of the plan, in order.
    pub points: Vec<PlanPoint>,
    /// `limits.drift_rel` of the plan.
    pub drift_rel: f64,
    /// Least time on, in s.
    pub least_s: f64,
    /// The window in which the lamp is watched, in s.
    pub window_s: f64,
    /// Allowed (max − min)/mean of the light over it.
    pub spread_rel: f64,
    /// Allowed (max − min)/mean of the power over it.
    pub power_spread_rel: f64,
    /// Distance of the lux meter in mm.
    pub distance_mm: f64,
    /// Whether the bench is the virtual darkroom.
    pub in_memory: bool,
}

/// A point of the plan.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct PlanPoint {
    /// Name of its block.
    pub block: String,
    /// What the detector can see.
    pub kind: ReadingKind,
    /// Whether a spectrum is taken there.
    pub spectrum: bool,
    /// Whether a sweep begins there.
    pub in_motion: bool,
    /// Target C in degrees.
    pub c_deg: f64,
    /// Target γ in degrees.
    pub gamma_deg: f64,
}

/// A spectrum, thinned to what a screen shows.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Curve {
    /// Wavelengths in nm.
    pub wavelength_nm: Vec<f64>,
    /// Spectral irradiance in W/m²/nm; none where saturated.
    pub irradiance_w_m2_nm: Vec<Option<f64>>,
}

/// How much is left.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Remaining {
    /// Points done.
    pub done: u64,
    /// Points of the plan.
    pub total: u64,
    /// Estimated time left in s of the bench's clock.
    pub left_s: f64,
    /// When it ends by that.
    pub ends_utc: String,
}

impl Outline {
    /// What the run with this header measures.
    pub fn of(header: &RunHeader, run: &str) -> Self {
        let (station, plan) = (&header.station, &header.plan);
        let criterion = Criterion::of(station, plan.limits());
        let point = |visit: &Visit| {
            let block = &plan.blocks()[visit.block];
            PlanPoint {
                block: block.name.clone(),
                kind: block.kind,
                spectrum: block.instrument == Instrument::Spectroradiometer,
                in_motion: visit.pass.is_some(),
                c_deg: visit.c_deg,
                gamma_deg: visit.gamma_deg,
            }
        };
        let visits = visits(plan);
        let points = visits.iter().filter(|visit| visit.role == Role::Point).map(point);
        Self {
            run: run.to_owned(),
            started_utc: header.started_utc.clone(),
            bench: station
                .document()
                .name
                .clone()
                .unwrap_or_else(|| "bench without a name".to_owned()),
            points: points.collect(),
            drift_rel: plan.limits().drift_rel(),
            least_s: criterion.least_s(),
            window_s: criterion.window_s,
            spread_rel: criterion.spread_rel,
            power_spread_rel: criterion.power_spread_rel,
            distance_mm: station.bench().distance_mm,
            in_memory: roles::is_virtual(station),
        }
    }
}

impl Curve {
    /// Of a record; none where its counts give no irradiance.
    pub(crate) fn of(record: &SpectrumRecord, calibration: &SpectralCalibration) -> Option<Self> {
        let irradiance = record.irradiance(calibration, DarkSubtraction::Spectrum).ok()?;
        let every = record.pixels.len().div_ceil(SHOWN_PIXELS).max(1);
        let wavelengths = record.pixels.iter().map(|pixel| pixel.wavelength_nm);
        Some(Self {
            wavelength_nm: wavelengths.step_by(every).collect(),
            irradiance_w_m2_nm: irradiance.irradiance_w_m2_nm.iter().step_by(every).copied().collect(),
        })
    }
}

impl Live {
    /// An event of which nothing more is to be said.
    pub(crate) const fn of(logged: Logged) -> Self {
        Self {
            logged,
            state: None,
            sentence: None,
            left: None,
            drift_rel: None,
            curve: None,
        }
    }

    /// A line of the journal at `time_utc`.
    pub(crate) fn note(time_utc: String, sentence: &str) -> Self {
        let message = sentence.to_owned();
        Self {
            sentence: Some(message.clone()),
            ..Self::of(Logged {
                time_utc,
                event: Event::Note { message },
            })
        }
    }

    /// A line of the journal at this moment, by the clock of this machine; with `state` for what is done from now on.
    pub fn now(state: Option<State>, sentence: &str) -> Self {
        Self {
            state,
            ..Self::note(jiff::Timestamp::now().to_string(), sentence)
        }
    }
}
