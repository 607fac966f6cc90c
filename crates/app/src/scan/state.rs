//! What a scan has come to, by its events one after the other: of the engine while it works, or of a record.

use std::collections::HashMap;

use isolux_record::event::WarmUp;
use isolux_record::run::{RunHeader, StopHow};
use isolux_record::spectra::SpectralCalibration;
use isolux_record::{Event, Logged, Reading, ReadingKind, Role};
use isolux_scan::warmup::Criterion;
use jiff::Timestamp;

use super::estimate::Estimate;
use crate::front_end::live::{Curve, Live, Remaining, State};
use crate::front_end::progress::{duration, ends};

/// What a scan has come to.
#[derive(Debug)]
pub(crate) struct ScanState {
    criterion: Criterion,
    calibration: Option<SpectralCalibration>,
    estimate: Estimate,
    state: Option<State>,
    /// First visits to the reference point in lx, by burning of the lamp and distance.
    first_lx: HashMap<(Option<u32>, u64), f64>,
    /// The last time in which the program did not run.
    slept_s: f64,
}

impl ScanState {
    /// Before the first event of the run with this header.
    pub fn of(header: &RunHeader) -> Self {
        Self {
            criterion: Criterion::of(&header.station, header.plan.limits()),
            calibration: header.spectral.clone(),
            estimate: Estimate::of(header),
            state: None,
            first_lx: HashMap::new(),
            slept_s: 0.0,
        }
    }

    /// When the lamp counts as stable.
    pub const fn criterion(&self) -> &Criterion {
        &self.criterion
    }

    /// Points of the plan done, and all of them.
    pub fn points(&self) -> (u64, u64) {
        (self.estimate.done(), self.estimate.total())
    }

    /// What the bench does.
    pub const fn state(&self) -> Option<State> {
        self.state
    }

    /// The next event, with what it means.
    pub fn follow(&mut self, logged: Logged) -> Live {
        let at = logged.time_utc.parse().unwrap_or_default();
        let live = self.meaning(logged, at);
        self.state = live.state.or(self.state);
        live
    }

    fn meaning(&mut self, logged: Logged, at: Timestamp) -> Live {
        let (mut state, mut left_s, mut drift_rel, mut curve) = (None, None, None, None);
        let sentence = match &logged.event {
            Event::Began { .. } => {
                self.estimate.begin_session();
                state = Some(State::Homing);
                Some("the axes search their reference".to_owned())
            }
            Event::Homed {} => Some("axes referenced".to_owned()),
            Event::Lamp { on: true } => {
                state = Some(State::WarmingUp);
                Some("lamp on: it is watched until it is stable".to_owned())
            }
            Event::Lamp { on: false } => Some("lamp off".to_owned()),
            Event::Asked { prompt, .. } => Some(format!("asked: {prompt}")),
            Event::WarmUp(look) => {
                left_s = Some((self.criterion.least_s() - look.lamp_s).max(0.0) + self.estimate.work_left_s());
                let watched = self.state == Some(State::WarmingUp);
                state = (!watched).then_some(State::WarmingUp);
                (!watched).then(|| "the lamp is watched until it is stable".to_owned())
            }
            Event::Stable { lamp_s, spread_rel, .. } => {
                self.estimate.begin_work(at);
                let spread = spread_words(*spread_rel, &self.criterion);
                Some(format!("lamp stable after {}: {spread}", duration(*lamp_s)))
            }
            Event::Block { name } => {
                state = Some(State::Scanning);
                Some(format!("block {name}"))
            }
            Event::Reading(reading) => {
                self.estimate.reached(reading, at);
                left_s = Some(self.estimate.left_s());
                drift_rel = self.drift(reading);
                let waited = matches!(self.state, Some(State::WarmingUp | State::Resuming));
                state = waited.then_some(State::Scanning);
                waited.then(|| "the scan goes on".to_owned())
            }
            Event::Spectrum { index, record, .. } => {
                curve = record
                    .as_ref()
                    .zip(self.calibration.as_ref())
                    .and_then(|(record, calibration)| Curve::of(record, calibration));
                Some(format!("spectrum {index} recorded"))
            }
            Event::Sweep {
                index,
                block,
                c_deg: [from_c, to_c],
                gamma_deg: [from, to],
                conversions,
                positions,
            } => {
                self.estimate.swept(block, at);
                left_s = Some(self.estimate.left_s());
                let along = if from_c == to_c {
                    format!("at C {from_c}°, γ {from}° to {to}°")
                } else {
                    format!("around a ring at γ {from}°, C {from_c}° to {to_c}°")
                };
                let number = index + 1;
                Some(format!(
                    "sweep {number} {along}: {conversions} conversions, {positions} positions"
                ))
            }
            Event::HalfPlanes { c_deg, reason, .. } => {
                let planes: Vec<String> = c_deg.iter().map(|c| format!("{c}°")).collect();
                let (noun, planes) = (
                    if planes.len() == 1 { "half-plane" } else { "half-planes" },
                    planes.join(", "),
                );
                Some(format!("{noun} C {planes} to be swept: {reason}"))
            }
            Event::SecondSweep {
                c_deg,
                gamma_deg: [from, to],
                reason,
                ..
            } => Some(format!("C {c_deg}°, γ {from}° to {to}°: {reason}")),
            Event::Symmetry {
                symmetry,
                largest_rel,
                c_deg,
                gamma_deg,
                most_rel,
                narrowest_deg,
                ..
            } => {
                let seen = narrowest_deg.map_or_else(String::new, |deg| {
                    format!("; a dip of 5 % would have been seen from {deg:.1}° of C on")
                });
                Some(format!(
                    "symmetry {symmetry}: rings differ from it by at most {:.2} % of the largest light, at C \
                     {c_deg}°, γ {gamma_deg}°; the plan allows {:.2} %{seen}",
                    100.0 * largest_rel,
                    100.0 * most_rel
                ))
            }
            Event::Again { reason } => Some(format!("measured again: {reason}")),
            Event::Paused {
                by,
                c_deg,
                gamma_deg,
                lamp_is_on,
                ..
            } => {
                state = Some(State::Paused);
                let lamp = if *lamp_is_on { "on" } else { "off" };
                Some(format!(
                    "paused by {by}: axes at rest at C {c_deg:.2}°, γ {gamma_deg:.2}°, lamp {lamp}"
                ))
            }
            Event::Resumed { by, paused_s } => {
                self.estimate.paused(*paused_s);
                state = Some(State::Resuming);
                Some(format!("goes on after {} by {by}", duration(*paused_s)))
            }
            Event::Slept { slept_s, .. } => {
                self.estimate.paused(*slept_s);
                self.slept_s = *slept_s;
                None
            }
            Event::BenchFound { c_deg, gamma_deg, .. } => Some(format!(
                "this program did not run for {} (it was stopped, or the computer slept): axes at rest at C {c_deg:.2}°, γ \
                 {gamma_deg:.2}°; the reference point and the interrupted visit are read again",
                duration(self.slept_s)
            )),
            Event::Note { message } => Some(message.clone()),
            Event::Stopped {
                how,
                message,
                axes_at_rest,
                ..
            } => {
                left_s = Some(0.0);
                state = Some(match how {
                    StopHow::Completed if *axes_at_rest => State::Completed,
                    StopHow::Interrupted if *axes_at_rest => State::Interrupted,
                    _ => State::Failed,
                });
                let rest = if *axes_at_rest {
                    "the axes are at rest"
                } else {
                    "AXES NOT VERIFIED AT REST"
                };
                Some(format!("{message}; {rest}"))
            }
            Event::Reread { .. }
            | Event::TakenOver { .. }
            | Event::Rail { .. }
            | Event::Shutter { .. }
            | Event::Baffle { .. }
            | Event::LampOutsideBand { .. }
            | Event::LampInsideBand { .. }
            | Event::ClockSet { .. } => None,
        };
        Live {
            state,
            sentence,
            left: left_s.map(|left_s| self.left(left_s, at)),
            drift_rel,
            curve,
            ..Live::of(logged)
        }
    }

    fn left(&self, left_s: f64, at: Timestamp) -> Remaining {
        let (done, total) = self.points();
        Remaining {
            done,
            total,
            left_s,
            ends_utc: ends(at, left_s).to_string(),
        }
    }

    /// Of a visit to the reference point: its change against the first since the lamp was switched on.
    fn drift(&mut self, reading: &Reading) -> Option<f64> {
        let lux = reading.illuminance_lx.filter(|_| reading.role == Role::Reference)?;
        let key = (reading.burning, reading.distance_mm.to_bits());
        if reading.kind == ReadingKind::Lit {
            self.first_lx.entry(key).or_insert(lux);
        }
        let drift = lux / self.first_lx.get(&key)? - 1.0;
        drift.is_finite().then_some(drift)
    }
}

/// `24.512 lx, 0.21 % of 0.50 % over 15 min 00 s`.
pub(super) fn look_words(look: &WarmUp, criterion: &Criterion) -> String {
    let spread = look.spread_rel.map(|spread| spread_words(spread, criterion));
    let spread = spread.map_or_else(String::new, |spread| format!(", {spread}"));
    format!("{:.3} lx{spread}", look.illuminance_lx)
}

/// `0.21 % of 0.50 % over 15 min 00 s`.
pub(crate) fn spread_words(spread_rel: f64, criterion: &Criterion) -> String {
    format!(
        "{:.2} % of {:.2} % over {}",
        spread_rel * 100.0,
        criterion.spread_rel * 100.0,
        duration(criterion.window_s)
    )
}
