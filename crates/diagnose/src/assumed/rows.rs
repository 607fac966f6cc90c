//! The rows of parts: which are whose, how far they reach, and what they share.

use std::collections::HashMap;
use std::ops::Range;

use isolux_model::{DirectionError, KnownError, Model};
use isolux_record::ReadingKind;
use isolux_record::observation::{MapSet, ReadingCoordinates, SpectraSet};
use nalgebra::DVector;

use crate::calibration::APART_DEG;
use crate::known::Known;

/// Where the rows of one observation file come from.
#[derive(Debug, Clone)]
pub enum Part {
    /// Goniometer readings.
    Readings(Vec<ReadingCoordinates>),
    /// Bins of sensor maps.
    Maps(MapSet),
    /// Samples of spectra, and which rows of the file they are.
    Spectra(SpectraSet, Vec<usize>),
}

impl Part {
    /// What a model expects of every row; none where it has no spectrum to expect one of.
    pub fn predict(&self, model: &Model) -> Option<Vec<f64>> {
        match self {
            Self::Readings(readings) => Some(model.predict_readings(readings)),
            Self::Maps(maps) => Some(model.predict_maps(maps)),
            Self::Spectra(spectra, rows) => {
                let all = model.predict_spectra(spectra).ok()?;
                Some(rows.iter().map(|&row| all[row]).collect())
            }
        }
    }
}

/// The largest |γ| of the readings, at least 1°.
pub(super) fn reach(parts: &[Part]) -> f64 {
    let mut largest: f64 = 1.0;
    for part in parts {
        if let Part::Readings(readings) = part {
            largest = readings.iter().fold(largest, |most, at| most.max(at.gamma_deg.abs()));
        }
    }
    largest.min(180.0)
}

/// How many |γ| of lit readings are apart from each other: a shape of more terms than that would wiggle between them as
/// it likes, and through the parallax of an extended emitter such a wiggle looks like a distance.
pub(super) fn distinct_gammas(parts: &[Part]) -> usize {
    let mut gammas: Vec<f64> = parts
        .iter()
        .flat_map(|part| match part {
            Part::Readings(readings) => readings.as_slice(),
            _ => &[],
        })
        .filter(|at| at.kind == ReadingKind::Lit)
        .map(|at| at.gamma_deg.abs())
        .collect();
    gammas.sort_by(f64::total_cmp);
    let (mut count, mut last) = (0, f64::NEG_INFINITY);
    for gamma in gammas {
        if gamma > last + APART_DEG {
            (count, last) = (count + 1, gamma);
        }
    }
    count
}

/// What the noise of each direction of the model's distribution does to the rows of a part.
pub fn direction_errors(model: &Model, part: &Part) -> Vec<DirectionError> {
    match part {
        Part::Readings(readings) => model.direction_errors_of_readings(readings),
        Part::Maps(maps) => model.direction_errors_of_maps(maps),
        Part::Spectra(spectra, rows) => {
            let here: HashMap<usize, usize> = rows.iter().enumerate().map(|(here, row)| (*row, here)).collect();
            let mut errors = model.noise_errors_of_spectra(spectra);
            for error in &mut errors {
                let of_part = error
                    .errors
                    .iter()
                    .filter_map(|(row, value)| Some((*here.get(row)?, *value)));
                error.errors = of_part.collect();
            }
            errors
        }
    }
}

/// The photometer heads of the readings but that of the model, in ascending order.
pub(super) fn heads(parts: &[Part]) -> Vec<u32> {
    let mut heads: Vec<u32> = parts
        .iter()
        .flat_map(|part| match part {
            Part::Readings(readings) => readings.as_slice(),
            _ => &[],
        })
        .map(|at| at.head)
        .filter(|head| *head > 0)
        .collect();
    heads.sort_unstable();
    heads.dedup();
    heads
}

/// Whether the level of these spectra is known: that of others is refitted.
pub(super) fn level_is_known(spectra: &SpectraSet) -> bool {
    spectra.shared.gain_rel.is_some() && spectra.is_irradiance()
}

/// What a model and the files of spectra know of themselves, on the rows of all parts.
pub fn known(model: &Model, parts: &[Part]) -> Vec<Known> {
    use rayon::prelude::*;
    let predicted = |model: &Model| -> Option<DVector<f64>> {
        let mut values = Vec::new();
        for part in parts {
            values.extend(match part {
                // Relative to a gain of their own.
                Part::Spectra(spectra, rows) if !level_is_known(spectra) => vec![0.0; rows.len()],
                part => part.predict(model)?,
            });
        }
        Some(DVector::from_vec(values))
    };
    let known = model.known_errors();
    let on_rows = |one: &KnownError| {
        let column = one.change_of(predicted)?;
        column.iter().all(|value| value.is_finite()).then(|| Known {
            what: one.what.clone(),
            u: one.u,
            unit: one.unit,
            assumed: one.assumed,
            column,
        })
    };
    let mut known: Vec<Known> = known.par_iter().filter_map(on_rows).collect();
    known.extend(known_of_spectra(model, parts));
    known
}

/// What the spectra of each instrument share.
fn known_of_spectra(model: &Model, parts: &[Part]) -> Vec<Known> {
    let ranges = row_ranges(parts);
    let rows = ranges.last().map_or(0, |range| range.end);
    let mut known: Vec<(Option<&String>, Known)> = Vec::new();
    for (part, range) in parts.iter().zip(ranges) {
        let Part::Spectra(spectra, of_file) = part else {
            continue;
        };
        for error in model.errors_of_spectra(spectra).unwrap_or_default() {
            let instrument = spectra.instrument.as_ref();
            let same = |(of, one): &(Option<&String>, Known)| {
                instrument.is_some() && *of == instrument && one.what == error.what
            };
            let at = known.iter().position(same).unwrap_or_else(|| {
                let one = Known {
                    what: error.what.to_owned(),
                    u: error.u,
                    unit: error.unit,
                    assumed: false,
                    column: DVector::zeros(rows),
                };
                known.push((instrument, one));
                known.len() - 1
            });
            for (row, number) in range.clone().zip(of_file) {
                known[at].1.column[row] = error.change[*number];
            }
        }
    }
    known.into_iter().map(|(_, one)| one).collect()
}

/// The range of rows of each part.
pub fn row_ranges(parts: &[Part]) -> Vec<Range<usize>> {
    let mut start = 0;
    parts
        .iter()
        .map(|part| {
            let length = match part {
                Part::Readings(readings) => readings.len(),
                Part::Maps(maps) => maps.cells().len(),
                Part::Spectra(_, rows) => rows.len(),
            };
            start += length;
            start - length..start
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_shape_has_no_more_terms_than_angles_that_hold_it() {
        let at = |gamma_deg: f64, kind: ReadingKind| ReadingCoordinates {
            kind,
            time_s: None,
            lamp_s: None,
            c_deg: 0.0,
            gamma_deg,
            distance_mm: 2000.0,
            travel: 0,
            range: None,
            ambient_c: None,
            head: 0,
        };
        // Four angles, both signs, read back with an encoder's dust; darks hold no shape.
        let mut readings: Vec<ReadingCoordinates> = (-3..=3)
            .map(|k| at(8.0 * f64::from(k) + 0.01 * f64::from(k % 2), ReadingKind::Lit))
            .collect();
        readings.extend((0..9).map(|k| at(10.0 * f64::from(k), ReadingKind::Baffled)));
        assert_eq!(distinct_gammas(&[Part::Readings(readings)]), 4);
        let fine = (0..400).map(|k| at(0.2 * f64::from(k), ReadingKind::Lit)).collect();
        assert!(distinct_gammas(&[Part::Readings(fine)]) > 100);
    }
}
