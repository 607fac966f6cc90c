//! Every effect of the catalogue on its grid of shapes, and every empirical alternative, as columns over the readings.

use std::collections::BTreeMap;
use std::sync::Arc;

use nalgebra::{DMatrix, DVector};
use rayon::prelude::*;

use crate::alternatives::{self, EmpiricalAlternative};
use crate::basis::{Basis, product};
use crate::calibration::{BLIND, MANY_SHAPES, OUTSIDE_CATALOGUE, SAME_PATTERN};
use crate::forward::{Forward, Hypothesis};
use crate::scan::{Candidate, Who};
use crate::table::{Coordinate, Row};

/// Generic patterns that are compared with the names together, and how many of these blocks at a time.
const COMPARED: usize = 16;
const AT_A_TIME: usize = 8;

/// The columns, and who makes them. Of most columns only the law is kept: with many readings their values would not
/// fit.
#[derive(Debug)]
pub struct Dictionary<'a> {
    rows: &'a [Row],
    columns: Vec<Column<'a>>,
    /// The candidates.
    pub candidates: Vec<Candidate>,
}

/// Change of each reading for a unit amplitude.
#[derive(Debug)]
enum Column<'a> {
    /// A difference of predictions.
    Tangent(DVector<f64>),
    /// An oscillation of all light: its change for frequency zero, the times, the frequency, sine or cosine.
    Wave(Arc<DVector<f64>>, &'a [f64], f64, fn(f64) -> f64),
    /// A pattern without a name.
    Generic(alternatives::Column),
}

impl Column<'_> {
    fn write(&self, rows: &[Row], target: &mut [f64]) {
        match self {
            Self::Tangent(values) => target.copy_from_slice(values.as_slice()),
            Self::Wave(light, times, frequency, law) => {
                for ((target, light), time) in target.iter_mut().zip(light.iter()).zip(*times) {
                    let value = light * law(std::f64::consts::TAU * frequency * time);
                    *target = if value.is_finite() { value } else { 0.0 };
                }
            }
            Self::Generic(pattern) => {
                for (target, value) in target.iter_mut().zip(pattern.values(rows)) {
                    *target = value;
                }
            }
        }
    }
}

impl<'a> Dictionary<'a> {
    /// Named tangents around the baseline `prediction`, those of what reads a sensor out around the light that is
    /// there, then the alternatives, whose columns move here. `refitted` are the derivatives to the nuisance: two
    /// patterns are alike where they are alike in what it leaves.
    pub fn new(
        forward: &'a dyn Forward,
        rows: &'a [Row],
        nuisance: &[f64],
        (prediction, light): (&DVector<f64>, &DVector<f64>),
        alternatives: &mut [EmpiricalAlternative],
        row_scale: &DVector<f64>,
        refitted: &DMatrix<f64>,
    ) -> Self {
        let effects = forward.effects();
        let tangents = tangents(forward, nuisance, (prediction, light));
        let share = (1.0 - OUTSIDE_CATALOGUE) / effects.len().max(1) as f64;
        let mut all: Vec<Column<'a>> = Vec::new();
        let mut candidates = Vec::new();
        for (who, columns) in tangents {
            let Who::Named { effect, .. } = who else { continue };
            let searchable = &effects[effect];
            let start = all.len();
            all.extend(columns);
            candidates.push(Candidate {
                who,
                columns: start..all.len(),
                ln_prior: (share / searchable.ways()).ln(),
                one_sided: searchable.one_sided,
                plausible: (searchable.turns || searchable.plausible.len() == 1).then(|| searchable.plausible[0]),
            });
        }
        let names = candidates.clone();
        let many = |who: Who| matches!(who, Who::Named { effect, .. } if effects[effect].shapes.len() > MANY_SHAPES);
        let mut known = refitted.clone();
        for mut column in known.column_iter_mut() {
            column.component_mul_assign(row_scale);
        }
        let known = Basis::spanning(&known, 1e-9);
        let unit = |column: &Column<'_>| {
            let mut pattern = DVector::zeros(rows.len());
            column.write(rows, pattern.as_mut_slice());
            pattern.component_mul_assign(row_scale);
            let whole = pattern.norm();
            known.project_out_vector(&mut pattern);
            let left = pattern.norm();
            (left > BLIND * whole).then(|| pattern / left)
        };
        let single: Vec<&Column<'_>> = names
            .iter()
            .filter(|candidate| candidate.columns.len() == 1 && !many(candidate.who))
            .map(|candidate| &all[candidate.columns.start])
            .collect();
        let mut named = DMatrix::zeros(rows.len(), single.len());
        for (mut target, pattern) in named
            .column_iter_mut()
            .zip(single.iter().filter_map(|column| unit(column)))
        {
            target.copy_from(&pattern);
        }
        let distinct = distinct(alternatives, named, |pattern| unit(&Column::Generic(pattern.clone())));
        let priors = priors(alternatives, &distinct);
        for (number, alternative) in alternatives.iter_mut().enumerate() {
            let columns = std::mem::take(&mut alternative.columns);
            if !distinct[number] {
                continue;
            }
            let start = all.len();
            all.extend(columns.into_iter().map(Column::Generic));
            candidates.push(Candidate {
                who: Who::Unnamed { alternative: number },
                columns: start..all.len(),
                ln_prior: priors[number].ln(),
                one_sided: false,
                plausible: None,
            });
        }
        Self {
            rows,
            columns: all,
            candidates,
        }
    }

    /// Number of columns.
    pub fn width(&self) -> usize {
        self.columns.len()
    }

    /// The columns of these numbers, readings × columns.
    pub fn columns(&self, numbers: &[usize]) -> DMatrix<f64> {
        let mut columns = DMatrix::zeros(self.rows.len(), numbers.len());
        columns
            .as_mut_slice()
            .par_chunks_mut(self.rows.len().max(1))
            .zip(numbers)
            .for_each(|(target, &number)| self.columns[number].write(self.rows, target));
        columns
    }

    /// Numbers of the columns that describe what is smooth: all named effects but searches through frequencies, then
    /// the broad alternatives. What is left after them is noise.
    pub fn smooth(&self, effects: &[crate::forward::Searchable], alternatives: &[EmpiricalAlternative]) -> Vec<usize> {
        let broad = [
            "smooth", "memory", "harmonic", "plane", "one_map", "odd", "even", "slope", "jump", "quadrant",
        ];
        let mut columns = Vec::new();
        for candidate in &self.candidates {
            let take = match candidate.who {
                Who::Named { effect, .. } => effects[effect].shapes.len() <= MANY_SHAPES,
                Who::Unnamed { alternative } => broad.contains(&alternatives[alternative].family),
            };
            if take {
                columns.extend(candidate.columns.clone());
            }
        }
        columns
    }
}

/// The patterns of every effect and shape, linear about the baseline.
fn tangents<'a>(
    forward: &'a dyn Forward,
    nuisance: &[f64],
    (prediction, light): (&DVector<f64>, &DVector<f64>),
) -> Vec<(Who, Vec<Column<'a>>)> {
    let effects = forward.effects();
    let mut tangents: Vec<(Who, Vec<Column<'a>>)> = effects
        .iter()
        .enumerate()
        .filter(|(_, searchable)| searchable.oscillates.is_none())
        .flat_map(|(effect, searchable)| (0..searchable.shapes.len()).map(move |shape| (effect, shape)))
        .collect::<Vec<_>>()
        .into_par_iter()
        .filter_map(|(effect, shape)| {
            let columns = tangent(forward, nuisance, (prediction, light), effect, shape)?;
            let columns = columns.into_iter().map(Column::Tangent).collect();
            Some((Who::Named { effect, shape }, columns))
        })
        .collect();
    for (effect, searchable) in effects.iter().enumerate() {
        if let Some(times) = &searchable.oscillates {
            let all = oscillations(forward, nuisance, prediction, effect, times);
            let named = |(shape, columns)| (Who::Named { effect, shape }, columns);
            tangents.extend(all.into_iter().flatten().enumerate().map(named));
        }
    }
    tangents
}

/// The prior probability of each alternative, 0 where it is not distinct: alike for coordinates, in them for families,
/// in them for patterns.
fn priors(alternatives: &[EmpiricalAlternative], distinct: &[bool]) -> Vec<f64> {
    let mut families: BTreeMap<(Coordinate, &str), usize> = BTreeMap::new();
    for (alternative, _) in alternatives.iter().zip(distinct).filter(|(_, distinct)| **distinct) {
        *families
            .entry((alternative.coordinate, alternative.family))
            .or_default() += 1;
    }
    let of_coordinate = |of: Coordinate| families.keys().filter(move |(coordinate, _)| *coordinate == of).count();
    let mut coordinates: Vec<Coordinate> = families.keys().map(|(coordinate, _)| *coordinate).collect();
    coordinates.dedup();
    let prior = |alternative: &EmpiricalAlternative| {
        let family = families
            .get(&(alternative.coordinate, alternative.family))
            .copied()
            .unwrap_or(1);
        OUTSIDE_CATALOGUE / (coordinates.len() * of_coordinate(alternative.coordinate) * family) as f64
    };
    let distinct = alternatives.iter().zip(distinct);
    distinct
        .map(|(alternative, distinct)| if *distinct { prior(alternative) } else { 0.0 })
        .collect()
}

/// Which alternatives are no likeness of a `named` pattern; those and the alternatives' as `unit` vectors over the
/// readings.
#[expect(clippy::needless_pass_by_value, reason = "the named patterns are large and end here")]
fn distinct(
    alternatives: &[EmpiricalAlternative],
    named: DMatrix<f64>,
    unit: impl Fn(&alternatives::Column) -> Option<DVector<f64>> + Sync,
) -> Vec<bool> {
    let of = |some: &[EmpiricalAlternative]| -> Vec<bool> {
        let mut patterns = DMatrix::zeros(named.nrows(), some.len());
        let mut kept = vec![true; some.len()];
        for ((alternative, kept), mut target) in some.iter().zip(&mut kept).zip(patterns.column_iter_mut()) {
            if let [one] = alternative.columns.as_slice() {
                match unit(one) {
                    Some(pattern) => target.copy_from(&pattern),
                    None => *kept = false,
                }
            }
        }
        let alike = product(&named, &patterns);
        for (kept, alike) in kept.iter_mut().zip(alike.column_iter()) {
            *kept = *kept && alike.iter().all(|alike| alike.powi(2) < SAME_PATTERN);
        }
        kept
    };
    let mut distinct = Vec::with_capacity(alternatives.len());
    for some in alternatives.chunks(COMPARED * AT_A_TIME) {
        distinct.par_extend(some.par_chunks(COMPARED).flat_map_iter(of));
    }
    distinct
}

/// Change of every row for a unit of each linear amplitude, from a difference of predictions at the effect's own step.
fn tangent(
    forward: &dyn Forward,
    nuisance: &[f64],
    (prediction, light): (&DVector<f64>, &DVector<f64>),
    effect: usize,
    shape: usize,
) -> Option<Vec<DVector<f64>>> {
    let searchable = &forward.effects()[effect];
    (0..searchable.step.len())
        .map(|k| {
            let step = searchable.step_of(shape, k);
            if let Some(changed) = forward.read_out(effect, step, light) {
                return finite((changed - light) / step);
            }
            change(
                forward,
                nuisance,
                prediction,
                effect,
                &searchable.shapes[shape],
                k,
                step,
            )
        })
        .collect()
}

/// Change of every row for a unit of one linear amplitude, from a difference of predictions at `step`.
fn change(
    forward: &dyn Forward,
    nuisance: &[f64],
    prediction: &DVector<f64>,
    effect: usize,
    shape: &[f64],
    k: usize,
    step: f64,
) -> Option<DVector<f64>> {
    let mut linear = vec![0.0; forward.effects()[effect].step.len()];
    linear[k] = step;
    let shape = shape.to_vec();
    let changed = forward.predict(nuisance, &[Hypothesis { effect, linear, shape }])?;
    finite((changed - prediction) / step)
}

fn finite(column: DVector<f64>) -> Option<DVector<f64>> {
    column.iter().all(|value| value.is_finite()).then_some(column)
}

/// The [`tangent`]s of all frequencies of an oscillation of the light: what one of frequency zero changes, times sine
/// and cosine.
fn oscillations<'a>(
    forward: &'a dyn Forward,
    nuisance: &[f64],
    prediction: &DVector<f64>,
    effect: usize,
    times: &'a [f64],
) -> Option<Vec<Vec<Column<'a>>>> {
    const STILL: f64 = 1e-15;
    let step = &forward.effects()[effect].step;
    let light = Arc::new(change(
        forward,
        nuisance,
        prediction,
        effect,
        &[STILL],
        step.len() - 1,
        *step.last()?,
    )?);
    let wave = |frequency: f64, law: fn(f64) -> f64| Column::Wave(Arc::clone(&light), times, frequency, law);
    let shapes = &forward.effects()[effect].shapes;
    Some(
        shapes
            .iter()
            .map(|shape| vec![wave(shape[0], f64::sin), wave(shape[0], f64::cos)])
            .collect(),
    )
}
