//! The steps of a reduction, one after the other.

use isolux_record::Run;
use isolux_record::{Quality, Reading, ReadingKind, Station};

use crate::acceptance;
use crate::apparent;
use crate::background::{Background, Subtract};
use crate::bench::Bench;
use crate::between::Between;
use crate::blocks;
use crate::budget::Common;
use crate::circle;
use crate::closing::Closing;
use crate::correction::Correction;
use crate::drift::{Drift, Stability};
use crate::electrical::Electrical;
use crate::error::ReduceError;
use crate::finding::{self, Accepted, Finding};
use crate::grid::Grid;
use crate::headline::Headline;
use crate::intensity::Conversion;
use crate::meter::{Meter, Response};
use crate::notes;
use crate::partial::Partial;
use crate::reference::Reference;
use crate::samples::{self, Corrected, Sample};
use crate::smooth;
use crate::spectral::SpectralResult;
use crate::sweeps::{Checked, InMotion};
use crate::unmeasured::{Done, Unmeasured};
use crate::{Options, Reduction};

/// Reduces a run with readings for its sweeps, `response` applied, judged by the directions read at rest, with the
/// effects of `bench` taken out of its lit readings; `spectral` gives its spectrum on the axis. Colour over angle comes
/// after it.
///
/// # Errors
/// [`ReduceError`]; nothing half-made is returned. The effect without inverse of `bench` comes back as text in
/// [`ReduceError::Format`].
pub fn reduce(
    run: &Run,
    in_motion: &InMotion,
    options: &Options,
    bench: Option<&Bench>,
    response: &Response,
    spectral: impl FnOnce() -> Result<Option<SpectralResult>, ReduceError>,
) -> Result<Reduction, ReduceError> {
    let on = |correction| !options.without.contains(&correction);
    let all = &run.readings.rows;
    let blocks::Chosen {
        rows,
        distance_mm,
        partial,
        notes: left_out,
    } = blocks::Chosen::of(run)?;
    let station = &run.header.station;
    let background = Background::of(all, distance_mm);
    let meter = Meter::of(run, options, bench, response)?;
    let conversion = Conversion::new(run, options, bench, &background, &meter)?;
    let Conversion {
        corrected, subtract, ..
    } = conversion;
    let Levelled {
        reference,
        drift,
        mut samples,
        accepted,
        checked,
    } = Levelled::new(run, in_motion, options, &rows, distance_mm, &conversion)?;
    if let Some(partial) = &partial {
        partial.fill(&mut samples);
    }
    let half_planes = in_motion.half_planes.as_ref().filter(|_| partial.is_none());
    let between = half_planes.and_then(|half_planes| half_planes.fill(&mut samples));
    let mut grid = Grid::new(&samples)?;
    // What is interpolated is no reading that could be smoothed.
    let smoothing = on(Correction::Smoothing) && partial.is_none() && between.is_none();
    let not_smoothed = smoothing.then(|| smooth::apply(&mut grid).err()).flatten();
    let unmeasured = Unmeasured::of(
        station,
        &Done {
            background: &background,
            corrected,
            subtract,
            distribution: &grid.distribution,
            distance_mm,
        },
    );
    // What a model takes out was learnt from such readings too: their noise and digit stay in the budget.
    let common = common(run, &background, corrected, &drift, &grid, distance_mm, &unmeasured);
    let common = meter.shared(common);
    let not_known = NotKnown {
        partial: partial.as_ref(),
        unmeasured: &unmeasured,
        meter: &meter,
        accepted: accepted.is_some(),
        own_distance: conversion.counted_at_mm.is_none_or(|own_mm| own_mm == distance_mm),
        reference: reference.missing(on(Correction::Drift)),
        bench,
    };
    let missing = not_known.of(station);
    let u_between_rel = between.as_ref().map(|between| between.u_flux_rel);
    let headline = Headline::of(&grid, &common, station, distance_mm, u_between_rel, &missing)?;
    let spectral = spectral()?;
    let sensor_irradiance = spectral
        .as_ref()
        .map(|spectral| headline.sensor_illuminance.over(&spectral.ler, "W/m²", "efficacy"));
    let used = rows.iter().filter(|row| row.quality == Quality::Ok).count();
    let mut notes: Vec<String> = partial.iter().map(Partial::note).collect();
    notes.extend(between.iter().map(Between::note));
    notes.extend(checked);
    notes.extend(background.notes.clone());
    notes.extend(meter.notes());
    notes.extend(accepted.iter().map(finding::note));
    notes.extend(left_out);
    notes.extend(circle::note(grid.assumed));
    notes.extend(notes::zone_note(&grid));
    notes.extend(not_smoothed.map(|error| error.to_string()));
    notes.extend(notes::burning_notes(all, &rows, &drift, on(Correction::Drift)));
    notes.extend(notes::spectrometer_note(run));
    notes.extend(notes::factors_note(run));
    notes.extend(notes::run_notes(run, &options.without, &background, used, rows.len()));
    Ok(Reduction {
        other_distances: apparent::other_distances(all, distance_mm, subtract, |mm| meter.factor(0.0, 0.0, mm)),
        spectral,
        over_angle: None,
        subtract,
        drift,
        luxmeter: meter.facts(),
        common,
        distance_mm,
        electrical: Electrical::of(&rows, station, &headline.flux),
        flux: headline.flux,
        i_max: headline.i_max,
        i_max_deg: headline.i_max_deg,
        angles: headline.angles,
        sensor_illuminance: headline.sensor_illuminance,
        sensor_irradiance,
        closing: Closing::of(&samples),
        partial,
        between,
        accepted,
        made_of: samples::made_of(&rows),
        readings: (used, all.len()),
        notes,
        without: options.without.clone(),
        removed_effects: bench.map_or_else(Vec::new, Bench::effects),
        bench_effects: meter.effects(),
        grid,
        background,
    })
}

/// The readings of the distribution at one level of the lamp.
struct Levelled {
    reference: Reference,
    drift: Drift,
    samples: Vec<Sample>,
    /// What does not agree, and was accepted.
    accepted: Option<Accepted>,
    /// What readings at rest after sweeps say.
    checked: Option<String>,
}

impl Levelled {
    /// # Errors
    /// [`ReduceError::Unsteady`] for a drift or a disagreement that is not accepted.
    fn new(
        run: &Run,
        in_motion: &InMotion,
        options: &Options,
        rows: &[&Reading],
        distance_mm: f64,
        conversion: &Conversion<'_>,
    ) -> Result<Self, ReduceError> {
        let all = &run.readings.rows;
        let stability = Stability::of(&run.header.station);
        let light = |row: &Reading, lux: f64| conversion.intensity(row, lux);
        let limits = run.header.plan.limits();
        let reference = Reference::of(all, rows, distance_mm, stability, &light);
        let mut findings = acceptance::of_reference(&reference, limits, all);
        refuse(&findings, options)?;
        let drift = if options.without.contains(&Correction::Drift) {
            reference.uncorrected()
        } else {
            reference.drift(distance_mm)?
        };
        let samples = samples::samples(rows, &in_motion.of_curves, |row, lux| {
            let corrected = light(row, lux);
            let factor = row.lamp_age_s().map_or(1.0, |lamp_s| drift.factor(row.index, lamp_s));
            Corrected {
                intensity_cd: corrected.intensity_cd / factor,
                ..corrected
            }
        })?;
        findings.extend(acceptance::of_closing(&samples, limits, rows));
        // The burning in which they were read need not have a reading of the distribution.
        let checked = Checked::of(&in_motion.checks, all, |distance_mm| {
            let of_distance = |row: &&Reading| row.kind == ReadingKind::Lit && row.distance_mm == distance_mm;
            let there: Vec<&Reading> = all.iter().filter(of_distance).collect();
            let reference = Reference::of(all, &there, distance_mm, stability, &light);
            if options.without.contains(&Correction::Drift) {
                Ok(reference.uncorrected())
            } else {
                reference.drift(distance_mm)
            }
        })?;
        findings.extend(checked.finding);
        refuse(&findings, options)?;
        let accepted = (!findings.is_empty()).then(|| Accepted {
            reason: options.accept_drift.clone().unwrap_or_default(),
            findings,
        });
        Ok(Self {
            reference,
            drift,
            samples,
            accepted,
            checked: checked.note,
        })
    }
}

/// What none of the headline numbers knows.
struct NotKnown<'a> {
    partial: Option<&'a Partial>,
    unmeasured: &'a Unmeasured,
    meter: &'a Meter<'a>,
    /// A drift or a disagreement was accepted.
    accepted: bool,
    /// The readings count as taken at the station's distance, and were.
    own_distance: bool,
    reference: Option<String>,
    bench: Option<&'a Bench>,
}

impl NotKnown<'_> {
    /// One entry each, in the order in which results name them.
    fn of(self, station: &Station) -> Vec<String> {
        let mut missing: Vec<String> = self.partial.iter().map(|partial| partial.words()).collect();
        missing.extend(self.unmeasured.missing.iter().cloned());
        missing.extend(self.meter.missing());
        missing.extend(self.accepted.then(|| finding::ACCEPTED.to_owned()));
        missing.extend(station.bench().u_distance_mm.is_none().then(|| NO_DISTANCE.to_owned()));
        missing.extend(station.bench().u_gamma_deg.is_none().then(|| NO_GAMMA.to_owned()));
        missing.extend((!self.own_distance).then(|| "not corrected for the distance of the readings".to_owned()));
        missing.extend(self.reference);
        missing.extend(
            self.bench
                .and_then(|bench| unknown_effects(&bench.without_uncertainty())),
        );
        missing
    }
}

/// What a budget without `bench.u_distance_mm` lacks.
const NO_DISTANCE: &str = "the station states no bench.u_distance_mm: uncertainty of the distance";

/// What a budget without `bench.u_gamma_deg` lacks.
const NO_GAMMA: &str = "the station states no bench.u_gamma_deg: uncertainty of the angle";

/// Refuses what does not agree, unless it is accepted.
fn refuse(findings: &[Finding], options: &Options) -> Result<(), ReduceError> {
    if findings.is_empty() || options.accept_drift.is_some() {
        return Ok(());
    }
    Err(ReduceError::Unsteady {
        findings: findings.to_vec(),
    })
}

/// What a budget lacks where a model takes out effects of unknown uncertainty.
fn unknown_effects(effects: &[String]) -> Option<String> {
    (!effects.is_empty()).then(|| {
        format!(
            "no uncertainty is known of what the model takes out: {}",
            effects.join(", ")
        )
    })
}

fn common(
    run: &Run,
    background: &Background,
    subtract: Subtract,
    drift: &Drift,
    grid: &Grid,
    distance_mm: f64,
    unmeasured: &Unmeasured,
) -> Common {
    let station = &run.header.station;
    let per_lx = (distance_mm * 1e-3).powi(2);
    let (mut noise, mut digit) = (0.0_f64, 0.0_f64);
    for &gamma in grid.distribution.gamma_deg() {
        let (noise_lx, digit_lx) = background.u_lx(gamma, subtract);
        noise = noise.max(noise_lx);
        digit = digit.max(digit_lx);
    }
    Common {
        dark_noise_cd: noise * per_lx,
        dark_digit_cd: digit * per_lx,
        offset_cd: unmeasured.offset_lx * per_lx,
        ambient_cd: unmeasured.ambient_lx * per_lx,
        stray_cd: unmeasured.stray_lx * per_lx,
        distance_rel: station.bench().u_distance_mm.map_or(0.0, |u| 2.0 * u / distance_mm),
        calibration_rel: station.luxmeter().u_rel,
        drift_rel: drift.u_rel(),
        gamma_deg: station.bench().u_gamma_deg.unwrap_or(0.0),
        ..Common::default()
    }
}
