//! Record → distribution and spectrum, with uncertainty.
//!
//! Reduction is a pure function of a run: the same run gives the same numbers and the same bytes. Every correction is a
//! switch ([`Correction`]), and every headline number is a [`Quantity`] whose parts say where its uncertainty comes from.

mod blocks;
mod budget;
mod circle;
mod correction;
mod drift;
mod error;
mod grid;
mod levels;
mod results;
mod samples;
mod smooth;
mod spectral;

#[cfg(test)]
mod testing;
#[cfg(test)]
mod tests;

use std::collections::BTreeSet;

use isolux_photometry::IntensityDistribution;
use isolux_record::run::Run;
use isolux_record::spectra::DarkSubtraction;
use isolux_record::{Quality, Reading, ReadingKind, Role};
use serde::Serialize;

pub use budget::{Common, Quantity};
pub use correction::{Correction, UnknownCorrection};
pub use drift::{Burning, Drift};
pub use error::ReduceError;
pub use grid::Grid;
pub use levels::{Level, Levels, Subtract};
pub use results::{ResultFile, files};
pub use samples::{Corrected, Sample};
pub use smooth::{SmoothError, Smoothing};
pub use spectral::SpectralResult;

/// Side of the square sensor and its distance, for which the budget gives the mean irradiance: a full-frame-class sensor
/// at half a metre.
pub const SENSOR_MM: (f64, f64) = (24.576, 500.0);

/// How a run is reduced.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Options {
    /// Corrections that are switched off.
    pub without: BTreeSet<Correction>,
}

/// A model of the bench, turned around: takes the bench's effects out of lit readings.
pub trait BenchInverse {
    /// For each lit reading and its illuminance: intensity, true direction, candela of one lux.
    ///
    /// # Errors
    /// The effect that has no inverse.
    fn correct(&self, readings: &[&Reading], illuminance_lx: &[f64]) -> Result<Vec<Corrected>, String>;

    /// Which of the run's own corrections the model takes over, because it has an effect for them.
    fn takes_over(&self) -> Subtract;

    /// What it takes out, for the provenance.
    fn effects(&self) -> Vec<String>;
}

/// What a run says.
#[derive(Debug, Clone)]
pub struct Reduction {
    /// The distribution and the samples at its nodes.
    pub grid: Grid,
    /// The spectrum on the axis, if one was taken.
    pub spectral: Option<SpectralResult>,
    /// Offset, ambient and stray light.
    pub levels: Levels,
    /// Which of them were subtracted.
    pub subtract: Subtract,
    /// Drift of the reference.
    pub drift: Drift,
    /// Uncertainties that all readings share.
    pub common: Common,
    /// Distance of the readings of the distribution.
    pub distance_mm: f64,
    /// Luminous flux.
    pub flux: Quantity,
    /// Largest intensity.
    pub i_max: Quantity,
    /// Its direction (C, γ) in degrees.
    pub i_max_deg: (f64, f64),
    /// Mean illuminance of a sensor of [`SENSOR_MM`] by the inverse square law, normal to the axis.
    pub sensor_illuminance: Quantity,
    /// Its mean irradiance, where there is a spectrum.
    pub sensor_irradiance: Option<Quantity>,
    /// Closing half-plane C 360° against C 0°, if the plan has one.
    pub closing: Option<Closing>,
    /// Apparent intensity on the axis at other distances.
    pub other_distances: Vec<Apparent>,
    /// Readings that were used, and all of them.
    pub readings: (usize, usize),
    /// What a person should know.
    pub notes: Vec<String>,
    /// Corrections that were switched off.
    pub without: BTreeSet<Correction>,
    /// Effects that a model took out.
    pub removed_effects: Vec<String>,
    /// Further `[[effect]]` tables of the bench for the model file, without their heading: what a model took out, or what was
    /// fitted to the stray light.
    pub bench_effects: Vec<String>,
}

/// Closing half-plane against the first.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Closing {
    /// Directions compared.
    pub directions: usize,
    /// Root mean square of the differences, in candela.
    pub rms_cd: f64,
    /// Largest difference (closing − first), in candela.
    pub max_cd: f64,
    /// At this γ.
    pub max_gamma_deg: f64,
    /// Mean of (difference ÷ its standard uncertainty)²: about 1 where nothing changed in between.
    pub chi2_per_direction: f64,
}

/// Intensity on the axis as it appears from a distance: equal at all of them where the inverse square law holds.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Apparent {
    /// Distance.
    pub distance_mm: f64,
    /// E·d².
    pub intensity_cd: f64,
    /// Its standard uncertainty without the common parts.
    pub u_cd: f64,
}

/// Reduces a run.
///
/// # Errors
/// [`ReduceError`]; nothing half-made is returned. The effect without inverse of `bench` comes back as text in
/// [`ReduceError::Format`].
pub fn reduce(run: &Run, options: &Options, bench: Option<&dyn BenchInverse>) -> Result<Reduction, ReduceError> {
    let on = |correction| !options.without.contains(&correction);
    let all = &run.readings.rows;
    let blocks::Chosen {
        rows,
        distance_mm,
        notes: left_out,
    } = blocks::Chosen::of(run)?;
    let station = &run.header.station;
    let own = if on(Correction::InverseSquare) {
        None
    } else {
        Some(station.bench().distance_mm)
    };
    let levels = Levels::of(all, distance_mm);
    let taken = bench.map(BenchInverse::takes_over);
    let corrected = Subtract {
        dark: on(Correction::Dark),
        ambient: on(Correction::Ambient),
        stray: on(Correction::Stray),
    };
    let subtract = Subtract {
        dark: corrected.dark && !taken.is_some_and(|taken| taken.dark),
        ambient: corrected.ambient && !taken.is_some_and(|taken| taken.ambient),
        stray: corrected.stray && !taken.is_some_and(|taken| taken.stray),
    };
    let by_model = match bench {
        Some(bench) => Some(inverted(bench, all, &levels, subtract)?),
        None => None,
    };
    let light = |row: &Reading, lux: f64| -> Corrected {
        if let Some(corrected) = by_model.as_ref().and_then(|corrected| corrected[row.index as usize]) {
            return corrected;
        }
        let metres = own.unwrap_or(row.distance_mm) * 1e-3;
        let cd_per_lx = metres * metres;
        let intensity_cd = (lux - levels.subtracted_lx(row.gamma_deg, subtract)) * cd_per_lx;
        Corrected {
            intensity_cd,
            cd_per_lx,
            c_deg: row.c_deg,
            gamma_deg: row.gamma_deg,
        }
    };
    let drift = if on(Correction::Drift) {
        drift_of(all, &rows, distance_mm, &light)?
    } else {
        Drift::Unknown
    };
    let samples = samples::samples(&rows, |row, lux| {
        let corrected = light(row, lux);
        let factor = row.time_s.map_or(1.0, |time| drift.factor(row.index, time));
        Corrected {
            intensity_cd: corrected.intensity_cd / factor,
            ..corrected
        }
    })?;
    let mut grid = Grid::new(&samples)?;
    let not_smoothed = on(Correction::Smoothing).then(|| grid.smooth().err()).flatten();
    let closing = closing(&samples);
    // What a model takes out was learnt from such readings too: their noise and digit stay in the budget.
    let common = common(run, &levels, corrected, &drift, &grid, distance_mm);
    let flux = budget::weighted_sum(&grid, &grid.flux_weights_sr(), &common, "lm");
    if flux.value <= 0.0 {
        return Err(ReduceError::NoFlux { flux_lm: flux.value });
    }
    let (i_max, i_max_deg) = i_max(&grid, &common);
    let sensor_weights = grid.sensor_weights_per_m2(SENSOR_MM.0, SENSOR_MM.1);
    let sensor_illuminance = budget::weighted_sum(&grid, &sensor_weights, &common, "lx");
    let dark = if on(Correction::SpectralDark) {
        DarkSubtraction::Spectrum
    } else {
        DarkSubtraction::Off
    };
    let spectral = spectral::on_axis(run, dark)?;
    let sensor_irradiance = spectral
        .as_ref()
        .map(|spectral| sensor_illuminance.times(1.0 / spectral.ler.value, "W/m²", "efficacy", spectral.ler.u_rel()));
    let used = rows.iter().filter(|row| row.quality == Quality::Ok).count();
    let mut notes = levels.notes.clone();
    notes.extend(left_out);
    notes.extend(circle::note(grid.assumed));
    notes.extend(zone_note(&grid));
    notes.extend(not_smoothed.map(|error| error.to_string()));
    notes.extend(burning_notes(all, &rows, &drift, on(Correction::Drift)));
    notes.extend(run_notes(
        run,
        &options.without,
        &levels,
        used,
        rows.len(),
        spectral.as_ref(),
    ));
    Ok(Reduction {
        other_distances: other_distances(all, distance_mm, subtract),
        spectral,
        subtract,
        drift,
        common,
        distance_mm,
        flux,
        i_max,
        i_max_deg,
        sensor_illuminance,
        sensor_irradiance,
        closing,
        readings: (used, all.len()),
        notes,
        without: options.without.clone(),
        removed_effects: bench.map_or_else(Vec::new, BenchInverse::effects),
        bench_effects: Vec::new(),
        grid,
        levels,
    })
}

/// Every lit reading through the model's inverse at once, by row number. What the run itself measured of offset and stray
/// light is taken off first where the model has no effect for it.
fn inverted(
    bench: &dyn BenchInverse,
    all: &[Reading],
    levels: &Levels,
    subtract: Subtract,
) -> Result<Vec<Option<Corrected>>, ReduceError> {
    let lit: Vec<(&Reading, f64)> = all
        .iter()
        .filter(|row| row.kind == ReadingKind::Lit)
        .filter_map(|row| {
            row.illuminance_lx
                .map(|lux| (row, lux - levels.subtracted_lx(row.gamma_deg, subtract)))
        })
        .collect();
    let rows: Vec<&Reading> = lit.iter().map(|(row, _)| *row).collect();
    let lux: Vec<f64> = lit.iter().map(|(_, lux)| *lux).collect();
    let corrected = bench.correct(&rows, &lux).map_err(|message| ReduceError::Format {
        file: "--with model",
        message,
    })?;
    let mut by_row = vec![None; all.len()];
    for (row, corrected) in rows.iter().zip(corrected) {
        if let Some(place) = by_row.get_mut(row.index as usize) {
            *place = Some(corrected);
        }
    }
    Ok(by_row)
}

fn drift_of(
    all: &[Reading],
    rows: &[&Reading],
    distance_mm: f64,
    light: &impl Fn(&Reading, f64) -> Corrected,
) -> Result<Drift, ReduceError> {
    let starts = drift::burnings(all);
    let mut burnings: Vec<(u64, Vec<drift::Visit>)> = starts.iter().map(|start| (*start, Vec::new())).collect();
    for row in all {
        let visit = row.role == Role::Reference && row.kind == ReadingKind::Lit && row.distance_mm == distance_mm;
        if let (true, Some(lux), Some(time_s), Some(u_lx)) = (visit, row.illuminance_lx, row.time_s, row.u_lx) {
            let corrected = light(row, lux);
            let seen = (time_s, corrected.intensity_cd, u_lx * corrected.cd_per_lx);
            burnings[drift::burning_of(&starts, row.index)].1.push(seen);
        }
    }
    // A burning without readings of the distribution says nothing of them.
    let used: BTreeSet<usize> = rows.iter().map(|row| drift::burning_of(&starts, row.index)).collect();
    let burnings: Vec<_> = used.into_iter().map(|at| std::mem::take(&mut burnings[at])).collect();
    let per_lx = (distance_mm * 1e-3).powi(2);
    Drift::of_burnings(&burnings).map_err(|mean_cd| ReduceError::DarkReference {
        illuminance_lx: mean_cd / per_lx,
    })
}

/// That the γ are not those of the whole sphere.
fn zone_note(grid: &Grid) -> Option<String> {
    let gammas = grid.distribution.gamma_deg();
    let (first, last) = (gammas[0], gammas[gammas.len() - 1]);
    (first > 0.0 || last < 180.0).then(|| {
        format!("γ {first}° to {last}° was measured: the flux is that of this zone, and the files are dark outside it")
    })
}

/// What the lamp's switching on more than once during the distribution means for its level.
fn burning_notes(all: &[Reading], rows: &[&Reading], drift: &Drift, corrected: bool) -> Vec<String> {
    let starts = drift::burnings(all);
    let used: BTreeSet<usize> = rows.iter().map(|row| drift::burning_of(&starts, row.index)).collect();
    if used.len() < 2 || !corrected {
        return Vec::new();
    }
    let count = used.len();
    let Drift::ByBurning { burning, .. } = drift else {
        return vec![format!(
            "the lamp was switched on {count} times during the distribution, and no visit to the reference point ties the levels; \
             give the block reference_every"
        )];
    };
    let mut notes = vec![format!(
        "the lamp was switched on {count} times during the distribution: each part is brought to the mean of all visits by its own"
    )];
    notes.extend(burning.iter().filter(|part| part.visits == 0).map(|part| {
        format!(
            "the part from row {} on has no visit to the reference point: its level is not tied to the others'",
            part.first_row
        )
    }));
    notes
}

fn common(run: &Run, levels: &Levels, subtract: Subtract, drift: &Drift, grid: &Grid, distance_mm: f64) -> Common {
    let station = &run.header.station;
    let per_lx = (distance_mm * 1e-3).powi(2);
    let (mut noise, mut digit) = (0.0_f64, 0.0_f64);
    for &gamma in grid.distribution.gamma_deg() {
        let (noise_lx, digit_lx) = levels.u_lx(gamma, subtract);
        noise = noise.max(noise_lx);
        digit = digit.max(digit_lx);
    }
    Common {
        dark_noise_cd: noise * per_lx,
        dark_digit_cd: digit * per_lx,
        distance_rel: station.bench().u_distance_mm.map_or(0.0, |u| 2.0 * u / distance_mm),
        calibration_rel: station.luxmeter().u_rel,
        drift_rel: drift.u_rel(),
    }
}

fn i_max(grid: &Grid, common: &Common) -> (Quantity, (f64, f64)) {
    let distribution: &IntensityDistribution = &grid.distribution;
    let gammas = distribution.gamma_deg().len();
    let place = (0..grid.sample_of.len())
        .max_by(|&a, &b| distribution.intensity_cd()[a].total_cmp(&distribution.intensity_cd()[b]))
        .unwrap_or(0);
    let direction = (
        distribution.c_deg()[place / gammas],
        distribution.gamma_deg()[place % gammas],
    );
    let weights = grid.direction_weights(direction.0, direction.1);
    (budget::weighted_sum(grid, &weights, common, "cd"), direction)
}

fn closing(samples: &[Sample]) -> Option<Closing> {
    let pairs: Vec<(&Sample, &Sample)> = samples
        .iter()
        .filter(|sample| sample.closing)
        .filter_map(|last| {
            let first = samples
                .iter()
                .find(|first| !first.closing && first.c_deg == 0.0 && first.gamma_deg == last.gamma_deg)?;
            Some((first, last))
        })
        .collect();
    let n = pairs.len() as f64;
    let difference = |(first, last): &(&Sample, &Sample)| last.intensity_cd - first.intensity_cd;
    let worst = pairs
        .iter()
        .max_by(|a, b| difference(a).abs().total_cmp(&difference(b).abs()))?;
    let u2 = |sample: &Sample| sample.u_noise_cd.powi(2) + sample.u_digit_cd.powi(2);
    Some(Closing {
        directions: pairs.len(),
        rms_cd: (pairs.iter().map(|pair| difference(pair).powi(2)).sum::<f64>() / n).sqrt(),
        max_cd: difference(worst),
        max_gamma_deg: worst.1.gamma_deg,
        chi2_per_direction: pairs
            .iter()
            .map(|pair| difference(pair).powi(2) / (u2(pair.0) + u2(pair.1)).max(f64::MIN_POSITIVE))
            .sum::<f64>()
            / n,
    })
}

fn other_distances(all: &[Reading], main_mm: f64, subtract: Subtract) -> Vec<Apparent> {
    let mut on_axis: Vec<&Reading> = all
        .iter()
        .filter(|row| row.kind == ReadingKind::Lit && row.distance_mm != main_mm && row.gamma_target_deg == 0.0)
        .filter(|row| row.quality == Quality::Ok)
        .collect();
    on_axis.sort_by(|a, b| a.distance_mm.total_cmp(&b.distance_mm));
    on_axis
        .chunk_by(|a, b| a.distance_mm == b.distance_mm)
        .filter_map(|group| {
            let distance_mm = group[0].distance_mm;
            let levels = Levels::of(all, distance_mm);
            let level = Level::of(group.iter().copied())?;
            let per_lx = (distance_mm * 1e-3).powi(2);
            let (noise, digit) = levels.u_lx(0.0, subtract);
            Some(Apparent {
                distance_mm,
                intensity_cd: (level.mean_lx - levels.subtracted_lx(0.0, subtract)) * per_lx,
                u_cd: level.u_lx().hypot(noise).hypot(digit) * per_lx,
            })
        })
        .collect()
}

fn run_notes(
    run: &Run,
    without: &BTreeSet<Correction>,
    levels: &Levels,
    used: usize,
    lit: usize,
    spectral: Option<&SpectralResult>,
) -> Vec<String> {
    let mut notes: Vec<String> = without
        .iter()
        .map(|correction| format!("correction {correction} is switched off"))
        .collect();
    if levels.capped.is_none() && levels.lamp_off.is_none() && levels.baffled.is_empty() {
        notes.push("no capped, lamp_off or baffled readings: nothing was subtracted".to_owned());
    } else if levels.baffled.is_empty() {
        notes.push("no baffled readings: stray light made by the lamp is still in the distribution".to_owned());
    }
    if used < lit {
        notes.push(format!("{} lit readings have no number and were left out", lit - used));
    }
    if run.header.station.bench().u_distance_mm.is_none() {
        notes.push("the station states no bench.u_distance_mm: the budget lacks the distance".to_owned());
    }
    if let Some(spectro) = run.header.station.spectroradiometer().filter(|_| spectral.is_some()) {
        if spectro.u_rel.is_none() {
            notes.push("the station states no spectroradiometer.u_rel: the budget lacks its calibration".to_owned());
        }
        notes.push(
            "the uncertainty of efficacy and colour holds noise alone, not the calibration's spectral shape".to_owned(),
        );
    }
    notes.extend(run.notices.iter().cloned());
    notes
}
