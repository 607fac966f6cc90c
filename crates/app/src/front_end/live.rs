//! The events of a scan, typed: the command line prints them, the page draws them, and a record gives the same ones
//! again.

use isolux_record::plan::Instrument;
use isolux_record::run::RunHeader;
use isolux_record::{Quality, Reading, ReadingKind};
use isolux_scan::itinerary::{Visit, visits};
use isolux_scan::warmup::Criterion;
use serde::Serialize;

pub use isolux_record::Role;

use crate::instruments::roles;

/// One thing that happened in a scan. `at_utc` is the bench's own clock, which is virtual where the bench is.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[serde(tag = "event", rename_all = "snake_case")]
pub enum Live {
    /// A scan begins, or is shown from its record.
    Began(Box<Outline>),
    /// What the bench does from now on.
    State {
        /// It.
        state: State,
        /// In a sentence, with who asked for it or why.
        sentence: String,
        /// When.
        at_utc: String,
    },
    /// A look at the lamp during warm-up.
    WarmUp(WarmUp),
    /// A reading of the lux meter.
    Reading(Box<LiveReading>),
    /// A spectrum.
    Spectrum(Box<LiveSpectrum>),
    /// How much is left.
    Left(Left),
    /// A line of the journal.
    Journal {
        /// The line.
        sentence: String,
        /// When.
        at_utc: String,
    },
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
    /// A gate stayed shut or an instrument failed.
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
    /// Target C in degrees.
    pub c_deg: f64,
    /// Target γ in degrees.
    pub gamma_deg: f64,
}

/// A look at the lamp.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct WarmUp {
    /// Seconds since the lamp was switched on.
    pub elapsed_s: f64,
    /// Illuminance at the reference point in lx.
    pub illuminance_lx: f64,
    /// (max − min)/mean over the window, once it is full.
    pub spread_rel: Option<f64>,
    /// What is allowed.
    pub allowed_rel: f64,
    /// The window in s.
    pub window_s: f64,
    /// Power in W; none without a power meter.
    pub power_w: Option<f64>,
    /// Its (max − min)/mean over the window.
    pub power_spread_rel: Option<f64>,
}

/// A reading of the lux meter.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct LiveReading {
    /// Number of the row.
    pub index: u64,
    /// A point, or the reference point.
    pub role: Role,
    /// Number of the point in the plan.
    pub point: u64,
    /// What the detector saw.
    pub kind: ReadingKind,
    /// Name of the block.
    pub block: String,
    /// Target C in degrees.
    pub c_deg: f64,
    /// Target γ in degrees.
    pub gamma_deg: f64,
    /// C as read back, in degrees.
    pub axis_c_deg: f64,
    /// γ as read back, in degrees.
    pub axis_gamma_deg: f64,
    /// Illuminance; none where there is no number.
    pub illuminance_lx: Option<f64>,
    /// Its standard uncertainty by scatter and rounding, in lx.
    pub u_lx: Option<f64>,
    /// What is to be thought of it.
    pub quality: Quality,
    /// Against the first visit to the reference point, for such a visit.
    pub drift_rel: Option<f64>,
    /// Distance of the detector in mm.
    pub distance_mm: f64,
    /// Temperature of the room in °C.
    pub ambient_c: Option<f64>,
    /// Electrical power in W.
    pub power_w: Option<f64>,
    /// Voltage in V.
    pub voltage_v: Option<f64>,
    /// Current in A.
    pub current_a: Option<f64>,
    /// Seconds since the run began.
    pub time_s: Option<f64>,
    /// Seconds since the lamp was switched on.
    pub lamp_s: Option<f64>,
    /// Points done.
    pub done: u64,
}

impl LiveReading {
    /// A row of the record; `first_lx` is the first visit to the reference point at its distance since the lamp was
    /// switched on.
    pub fn of(reading: &Reading, first_lx: Option<f64>, done: u64) -> Self {
        let drift = reading
            .illuminance_lx
            .zip(first_lx)
            .map(|(now, first)| now / first - 1.0);
        Self {
            index: reading.index,
            role: reading.role,
            point: reading.point,
            kind: reading.kind,
            block: reading.block.clone(),
            c_deg: reading.c_target_deg,
            gamma_deg: reading.gamma_target_deg,
            axis_c_deg: reading.c_deg,
            axis_gamma_deg: reading.gamma_deg,
            illuminance_lx: reading.illuminance_lx,
            u_lx: reading.u_lx,
            quality: reading.quality,
            drift_rel: drift.filter(|drift| reading.role == Role::Reference && drift.is_finite()),
            distance_mm: reading.distance_mm,
            ambient_c: reading.ambient_c,
            power_w: reading.electrical.power_w,
            voltage_v: reading.electrical.voltage_v,
            current_a: reading.electrical.current_a,
            time_s: reading.time_s,
            lamp_s: reading.lamp_s,
            done,
        }
    }
}

/// A spectrum, thinned to what a screen shows.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct LiveSpectrum {
    /// Number in the run.
    pub index: u64,
    /// Wavelengths in nm.
    pub wavelength_nm: Vec<f64>,
    /// Spectral irradiance in W/m²/nm; none where saturated.
    pub irradiance_w_m2_nm: Vec<Option<f64>>,
    /// Seconds since the run began.
    pub time_s: Option<f64>,
}

/// How much is left.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Left {
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

impl Live {
    /// What the bench does from this moment on, by the clock of this machine.
    pub fn state_now(state: State, sentence: &str) -> Self {
        let (sentence, at_utc) = (sentence.to_owned(), jiff::Timestamp::now().to_string());
        Self::State {
            state,
            sentence,
            at_utc,
        }
    }

    /// A line of the journal, at this moment.
    pub fn journal_now(sentence: &str) -> Self {
        let (sentence, at_utc) = (sentence.to_owned(), jiff::Timestamp::now().to_string());
        Self::Journal { sentence, at_utc }
    }
}
