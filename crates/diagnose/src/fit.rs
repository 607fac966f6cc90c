//! Weighted Gauss–Newton: nuisance and effects together, with the full non-linear model.

use nalgebra::{DMatrix, DVector};

use crate::basis::inverse_of_normal;
use crate::forward::{Forward, Hypothesis};
use crate::whitening::Sequence;

/// From a difference of predictions to unit residuals.
#[derive(Debug, Clone)]
pub struct Whitener<'a> {
    /// The order of the rows in time.
    pub sequence: &'a Sequence,
    /// √weight / u of each row.
    pub row_scale: DVector<f64>,
    /// Serial correlation.
    pub rho: f64,
}

impl Whitener<'_> {
    /// Whitens columns in place.
    pub fn apply(&self, matrix: &mut DMatrix<f64>) {
        for mut column in matrix.column_iter_mut() {
            column.component_mul_assign(&self.row_scale);
        }
        self.sequence.whiten(self.rho, matrix);
    }

    /// A whitened copy of one vector.
    pub fn vector(&self, vector: &DVector<f64>) -> DVector<f64> {
        let mut matrix = DMatrix::from_column_slice(vector.len(), 1, vector.as_slice());
        self.apply(&mut matrix);
        matrix.column(0).into_owned()
    }
}

/// A fitted model.
#[derive(Debug, Clone)]
pub struct Fit {
    /// Nuisance parameters.
    pub nuisance: Vec<f64>,
    /// The effects, refined.
    pub hypotheses: Vec<Hypothesis>,
    /// Expected value of every row.
    pub prediction: DVector<f64>,
    /// Whitened residual, measured − expected, in stated σ.
    pub residual: DVector<f64>,
    /// Its squared length.
    pub chi2: f64,
    /// Whitened derivative to every parameter: nuisance first, then each effect's linear and free shape parameters.
    pub jacobian: DMatrix<f64>,
}

/// One free parameter.
#[derive(Clone, Copy)]
enum Slot {
    Nuisance(usize),
    Linear(usize, usize),
    Shape(usize, usize),
}

/// Derivative of every row to each nuisance parameter, unwhitened.
pub fn nuisance_tangents<F: Forward + ?Sized>(forward: &F, nuisance: &[f64]) -> Option<DMatrix<f64>> {
    const STEP: f64 = 1e-4;
    let base = forward.predict(nuisance, &[])?;
    let columns = (0..nuisance.len())
        .map(|k| {
            let mut tried = nuisance.to_vec();
            tried[k] += STEP;
            Some((forward.predict(&tried, &[])? - &base) / STEP)
        })
        .collect::<Option<Vec<_>>>()?;
    Some(if columns.is_empty() {
        DMatrix::zeros(base.len(), 0)
    } else {
        DMatrix::from_columns(&columns)
    })
}

/// Fits nuisance and `hypotheses` from their given values. None where the model refuses the combination.
///
/// `tangents` are the [`nuisance_tangents`] near `nuisance`: the nuisance is nearly linear and effects change its
/// derivative by per cents, so they serve every step of every fit.
pub fn fit<F: Forward + ?Sized>(
    forward: &F,
    measured: &DVector<f64>,
    whitener: &Whitener<'_>,
    nuisance: &[f64],
    tangents: &DMatrix<f64>,
    hypotheses: &[Hypothesis],
) -> Option<Fit> {
    let slots = slots(forward, nuisance.len(), hypotheses);
    let mut state = (nuisance.to_vec(), hypotheses.to_vec());
    let mut prediction = forward.predict(&state.0, &state.1)?;
    let mut residual = whitener.vector(&(measured - &prediction));
    let mut objective = residual.norm_squared() + shape_penalty(forward, &state.1);
    if !objective.is_finite() {
        return None;
    }
    let mut known = tangents.clone();
    whitener.apply(&mut known);
    let mut jacobian = DMatrix::zeros(measured.len(), slots.len());
    jacobian.columns_mut(0, nuisance.len()).copy_from(&known);
    let mut damping = 0.0;
    for round in 0..14 {
        derivative(forward, whitener, &state, &prediction, &slots, &mut jacobian)?;
        let mut normal = jacobian.tr_mul(&jacobian);
        let mut gradient = jacobian.tr_mul(&residual);
        for (k, &slot) in slots.iter().enumerate() {
            if let Slot::Shape(i, j) = slot {
                let (low, high) = forward.effects()[state.1[i].effect].bounds[j];
                let weight = 1.0 / (high - low).powi(2);
                normal[(k, k)] += weight;
                gradient[k] -= weight * (state.1[i].shape[j] - 0.5 * (low + high));
            }
        }
        let mut improved = false;
        for _ in 0..6 {
            let step = solve_damped(&normal, &gradient, damping);
            let tried = moved(forward, &state, &slots, &step);
            let candidate = forward.predict(&tried.0, &tried.1)?;
            let left = whitener.vector(&(measured - &candidate));
            let value = left.norm_squared() + shape_penalty(forward, &tried.1);
            if value.is_finite() && value <= objective + 1e-9 {
                let gain = objective - value;
                (state, prediction, residual, objective) = (tried, candidate, left, value);
                damping *= 0.2;
                improved = gain > 1e-3;
                break;
            }
            damping = if damping == 0.0 { 1e-3 } else { damping * 10.0 };
        }
        if !improved && round >= 1 {
            break;
        }
    }
    let chi2 = residual.norm_squared();
    Some(Fit {
        nuisance: state.0,
        hypotheses: state.1,
        prediction,
        residual,
        chi2,
        jacobian,
    })
}

impl Fit {
    /// Covariance of all parameters (order of the Jacobian) for a noise scale `s`: s²·(JᵀJ)⁻¹.
    pub fn covariance(&self, scale: f64) -> DMatrix<f64> {
        let normal = self.jacobian.tr_mul(&self.jacobian);
        scale * scale * inverse_of_normal(&normal, 1e-10)
    }
}

fn slots<F: Forward + ?Sized>(forward: &F, nuisances: usize, hypotheses: &[Hypothesis]) -> Vec<Slot> {
    let mut slots: Vec<Slot> = (0..nuisances).map(Slot::Nuisance).collect();
    for (i, hypothesis) in hypotheses.iter().enumerate() {
        slots.extend((0..hypothesis.linear.len()).map(|j| Slot::Linear(i, j)));
        let fixed = &forward.effects()[hypothesis.effect].fixed;
        slots.extend(
            (0..hypothesis.shape.len())
                .filter(|&j| !fixed[j])
                .map(|j| Slot::Shape(i, j)),
        );
    }
    slots
}

/// A weak pull of every shape towards the middle of its bounds, one σ at each end: what the data do not say stays sane.
fn shape_penalty<F: Forward + ?Sized>(forward: &F, hypotheses: &[Hypothesis]) -> f64 {
    let mut sum = 0.0;
    for hypothesis in hypotheses {
        let searchable = &forward.effects()[hypothesis.effect];
        for ((value, (low, high)), fixed) in hypothesis.shape.iter().zip(&searchable.bounds).zip(&searchable.fixed) {
            if !fixed {
                sum += ((value - 0.5 * (low + high)) / (high - low)).powi(2);
            }
        }
    }
    sum
}

type State = (Vec<f64>, Vec<Hypothesis>);

fn derivative<F: Forward + ?Sized>(
    forward: &F,
    whitener: &Whitener<'_>,
    state: &State,
    prediction: &DVector<f64>,
    slots: &[Slot],
    jacobian: &mut DMatrix<f64>,
) -> Option<()> {
    use rayon::prelude::*;
    let wanted: Vec<usize> = (0..slots.len())
        .filter(|&k| !matches!(slots[k], Slot::Nuisance(_)))
        .collect();
    let columns: Vec<Option<DVector<f64>>> = wanted
        .par_iter()
        .map(|&k| {
            let mut tried = state.clone();
            let step = match slots[k] {
                Slot::Nuisance(_) => return None,
                Slot::Linear(i, j) => {
                    let searchable = &forward.effects()[tried.1[i].effect];
                    let step = 0.1 * searchable.step[j];
                    tried.1[i].linear[j] += step;
                    step
                }
                Slot::Shape(i, j) => {
                    let searchable = &forward.effects()[tried.1[i].effect];
                    let value = &mut tried.1[i].shape[j];
                    let forward_step = searchable.shape_step[j];
                    let step = if *value + forward_step > searchable.bounds[j].1 {
                        -forward_step
                    } else {
                        forward_step
                    };
                    *value += step;
                    step
                }
            };
            Some((forward.predict(&tried.0, &tried.1)? - prediction) / step)
        })
        .collect();
    for (k, column) in wanted.into_iter().zip(columns) {
        let column = whitener.vector(&column?);
        if column.iter().any(|value| !value.is_finite()) {
            return None;
        }
        jacobian.set_column(k, &column);
    }
    Some(())
}

fn solve_damped(normal: &DMatrix<f64>, gradient: &DVector<f64>, damping: f64) -> DVector<f64> {
    let n = normal.nrows();
    if n == 0 {
        return DVector::zeros(0);
    }
    // A parameter that changes nothing stays where it is.
    let size = DVector::from_fn(n, |i, _| {
        let length = normal[(i, i)].max(0.0).sqrt();
        if length.is_normal() { length } else { f64::INFINITY }
    });
    let mut scaled = DMatrix::from_fn(n, n, |i, j| normal[(i, j)] / size[i] / size[j]);
    for i in 0..n {
        scaled[(i, i)] = 1.0 + damping + 1e-10;
    }
    let target = gradient.component_div(&size);
    let solved = match scaled.clone().cholesky() {
        Some(cholesky) => cholesky.solve(&target),
        None => inverse_of_normal(&scaled, 1e-9) * target,
    };
    solved.component_div(&size)
}

fn moved<F: Forward + ?Sized>(forward: &F, state: &State, slots: &[Slot], step: &DVector<f64>) -> State {
    let mut tried = state.clone();
    for (k, &slot) in slots.iter().enumerate() {
        match slot {
            Slot::Nuisance(i) => tried.0[i] += step[k],
            Slot::Linear(i, j) => {
                tried.1[i].linear[j] += step[k];
                let searchable = &forward.effects()[tried.1[i].effect];
                if searchable.never_negative && tried.1[i].linear[j] <= 0.0 {
                    tried.1[i].linear[j] = 1e-3 * searchable.step[j];
                }
            }
            Slot::Shape(i, j) => {
                let (low, high) = forward.effects()[tried.1[i].effect].bounds[j];
                let limit = 0.3 * (high - low);
                let value = &mut tried.1[i].shape[j];
                *value = (*value + step[k].clamp(-limit, limit)).clamp(low, high);
            }
        }
    }
    tried
}
