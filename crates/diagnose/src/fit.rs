//! Weighted Gauss–Newton: nuisance and effects together, with the full non-linear model.

use nalgebra::{DMatrix, DVector};

use crate::basis::{inverse_of_normal, solve_damped};
use crate::forward::{Forward, Hypothesis, Searchable};
use crate::whitener::Whitener;

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
    /// Where what the model knows of itself was left when it was read out, as a change of every row; empty where
    /// nothing is read out.
    pub change: DVector<f64>,
}

/// One free parameter.
#[derive(Clone, Copy)]
enum Slot {
    Nuisance(usize),
    Linear(usize, usize),
    Shape(usize, usize),
}

/// Difference at which derivatives to nuisance parameters are taken.
const NUISANCE_STEP: f64 = 1e-4;

/// Derivative of every row to each nuisance parameter, unwhitened.
pub fn nuisance_tangents(forward: &dyn Forward, nuisance: &[f64]) -> Option<DMatrix<f64>> {
    let base = forward.predict(nuisance, &[])?;
    let columns = (0..nuisance.len())
        .map(|k| {
            let mut tried = nuisance.to_vec();
            tried[k] += NUISANCE_STEP;
            Some((forward.predict(&tried, &[])? - &base) / NUISANCE_STEP)
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
/// `tangents` are the [`nuisance_tangents`] near `nuisance`: the nuisance is nearly linear and most effects change its
/// derivative by per cents, so they serve every step of most fits. Where steps end with them and true derivatives would
/// go on (stray light that outshines the lamp at some γ), derivatives are taken anew.
pub fn fit(
    forward: &dyn Forward,
    measured: &DVector<f64>,
    whitener: &Whitener<'_>,
    nuisance: &[f64],
    tangents: &DMatrix<f64>,
    hypotheses: &[Hypothesis],
) -> Option<Fit> {
    let slots = slots(forward, nuisance.len(), hypotheses);
    let weights = forward.nuisance_weights();
    let held = |values: &[f64]| -> f64 { values.iter().zip(&weights).map(|(value, w)| w * value * value).sum() };
    let mut state = (nuisance.to_vec(), hypotheses.to_vec());
    let mut prediction = forward.predict(&state.0, &state.1)?;
    let mut residual = whitener.vector(&(measured - &prediction));
    let mut objective = residual.norm_squared() + penalty(forward, &state.1) + held(&state.0);
    if !objective.is_finite() {
        return None;
    }
    let mut known = tangents.clone();
    whitener.apply(&mut known);
    let mut jacobian = DMatrix::zeros(measured.len(), slots.len());
    jacobian.columns_mut(0, nuisance.len()).copy_from(&known);
    let mut damping = 0.0;
    let mut anew = false;
    let mut since = 0;
    for _ in 0..40 {
        if anew {
            let fresh = nuisance_derivatives(forward, &state, &prediction)?;
            jacobian
                .columns_mut(0, nuisance.len())
                .copy_from(&whitened(whitener, fresh));
        }
        derivative(forward, whitener, &state, &prediction, &slots, &mut jacobian)?;
        let mut normal = jacobian.tr_mul(&jacobian);
        let mut gradient = jacobian.tr_mul(&residual);
        for (k, &slot) in slots.iter().enumerate() {
            if let Slot::Shape(i, j) = slot {
                let (low, high) = forward.effects()[state.1[i].effect].bounds[j];
                let weight = 1.0 / (high - low).powi(2);
                normal[(k, k)] += weight;
                gradient[k] -= weight * (state.1[i].shape[j] - 0.5 * (low + high));
                let spread = forward.effects()[state.1[i].effect].assumed[j];
                let beyond = spread.beyond(state.1[i].shape[j]);
                if beyond != 0.0 {
                    normal[(k, k)] += spread.sigma().powi(-2);
                    gradient[k] -= beyond / spread.sigma();
                }
            }
        }
        for (k, weight) in weights.iter().enumerate() {
            normal[(k, k)] += weight;
            gradient[k] -= weight * state.0[k];
        }
        hold_plausible(forward, &state.1, &slots, &mut normal, &mut gradient);
        let mut improved = false;
        for _ in 0..8 {
            let step = step_inside(forward, &state, &slots, &normal, &gradient, damping);
            let tried = moved(forward, &state, &slots, &step);
            let candidate = forward.predict(&tried.0, &tried.1)?;
            let left = whitener.vector(&(measured - &candidate));
            let value = left.norm_squared() + penalty(forward, &tried.1) + held(&tried.0);
            if value.is_finite() && value <= objective + 1e-9 {
                let gain = objective - value;
                (state, prediction, residual, objective) = (tried, candidate, left, value);
                damping *= 0.2;
                improved = gain > 1e-3;
                break;
            }
            damping = if damping == 0.0 { 1e-3 } else { damping * 10.0 };
        }
        since += 1;
        if !improved && since >= 2 || since >= 14 {
            if anew || hypotheses.is_empty() || nuisance.is_empty() {
                break;
            }
            // Would true derivatives of the nuisance go on?
            let fresh = whitened(whitener, nuisance_derivatives(forward, &state, &prediction)?);
            let normal = fresh.tr_mul(&fresh) + DMatrix::from_diagonal(&DVector::from_column_slice(&weights));
            let pull = DVector::from_fn(weights.len(), |k, _| weights[k] * state.0[k]);
            let gradient = fresh.tr_mul(&residual) - pull;
            let expected = gradient.dot(&solve_damped(&normal, &gradient, 0.0));
            if expected.is_nan() || expected < 0.05 {
                break;
            }
            (anew, since, damping) = (true, 0, 0.0);
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
        change: DVector::zeros(0),
    })
}

/// Derivatives of every row to the parameters of a fit, in units of other weights than it was made with.
pub fn derivatives(forward: &dyn Forward, whitener: &Whitener<'_>, fitted: &Fit) -> Option<DMatrix<f64>> {
    let state = (fitted.nuisance.clone(), fitted.hypotheses.clone());
    let slots = slots(forward, state.0.len(), &state.1);
    let mut jacobian = DMatrix::zeros(fitted.prediction.len(), slots.len());
    if !state.0.is_empty() {
        let nuisance = whitened(whitener, nuisance_derivatives(forward, &state, &fitted.prediction)?);
        jacobian.columns_mut(0, state.0.len()).copy_from(&nuisance);
    }
    derivative(forward, whitener, &state, &fitted.prediction, &slots, &mut jacobian)?;
    Some(jacobian)
}

impl Fit {
    /// Covariance of all parameters (order of the Jacobian) for a noise scale `s`: s²·(JᵀJ)⁻¹.
    pub fn covariance(&self, scale: f64) -> DMatrix<f64> {
        let normal = self.jacobian.tr_mul(&self.jacobian);
        scale * scale * inverse_of_normal(&normal, 1e-10)
    }
}

/// Derivatives to the nuisance where the effects act.
fn nuisance_derivatives(forward: &dyn Forward, state: &State, prediction: &DVector<f64>) -> Option<DMatrix<f64>> {
    use rayon::prelude::*;
    let columns = (0..state.0.len())
        .into_par_iter()
        .map(|k| {
            let mut tried = state.0.clone();
            tried[k] += NUISANCE_STEP;
            Some((forward.predict(&tried, &state.1)? - prediction) / NUISANCE_STEP)
        })
        .collect::<Option<Vec<_>>>()?;
    Some(DMatrix::from_columns(&columns))
}

fn whitened(whitener: &Whitener<'_>, mut columns: DMatrix<f64>) -> DMatrix<f64> {
    whitener.apply(&mut columns);
    columns
}

fn slots(forward: &dyn Forward, nuisances: usize, hypotheses: &[Hypothesis]) -> Vec<Slot> {
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

/// A weak pull of every shape towards the middle of its bounds, one σ at each end, and of every shape and amplitude
/// back to what is plausible: what the data do not say stays sane.
fn penalty(forward: &dyn Forward, hypotheses: &[Hypothesis]) -> f64 {
    let mut sum = 0.0;
    for hypothesis in hypotheses {
        let searchable = &forward.effects()[hypothesis.effect];
        for (j, value) in hypothesis
            .shape
            .iter()
            .enumerate()
            .filter(|(j, _)| !searchable.fixed[*j])
        {
            let (low, high) = searchable.bounds[j];
            sum += ((value - 0.5 * (low + high)) / (high - low)).powi(2);
            sum += searchable.assumed[j].beyond(*value).powi(2);
        }
        sum += searchable.implausibility(&hypothesis.linear);
    }
    sum
}

/// The pull of implausible amplitudes in the normal equations.
fn hold_plausible(
    forward: &dyn Forward,
    hypotheses: &[Hypothesis],
    slots: &[Slot],
    normal: &mut DMatrix<f64>,
    gradient: &mut DVector<f64>,
) {
    for (i, hypothesis) in hypotheses.iter().enumerate() {
        let Some(first) = slots
            .iter()
            .position(|slot| matches!(slot, Slot::Linear(k, 0) if *k == i))
        else {
            continue;
        };
        for (share, slope) in forward.effects()[hypothesis.effect].beyond(&hypothesis.linear) {
            if share > 0.0 {
                for (j, slope) in slope.iter().enumerate() {
                    normal[(first + j, first + j)] += slope * slope;
                    gradient[first + j] -= share * slope;
                }
            }
        }
    }
}

/// The range of a parameter.
fn range(searchable: &Searchable, slot: Slot) -> (f64, f64) {
    match slot {
        Slot::Nuisance(_) => (f64::NEG_INFINITY, f64::INFINITY),
        Slot::Linear(_, j) => searchable.limits[j],
        Slot::Shape(_, j) => searchable.bounds[j],
    }
}

/// The damped step; a parameter that would leave its range goes to the end of it, and the others follow that.
fn step_inside(
    forward: &dyn Forward,
    state: &State,
    slots: &[Slot],
    normal: &DMatrix<f64>,
    gradient: &DVector<f64>,
    damping: f64,
) -> DVector<f64> {
    let mut step = DVector::zeros(slots.len());
    let mut free: Vec<usize> = (0..slots.len()).collect();
    for _ in 0..4 {
        let target = gradient - normal * &step;
        let inner = normal.select_rows(&free).select_columns(&free);
        let part = solve_damped(&inner, &target.select_rows(&free), damping);
        let mut held = Vec::new();
        for (place, &k) in free.iter().enumerate() {
            let (value, effect) = match slots[k] {
                Slot::Nuisance(_) => continue,
                Slot::Linear(i, j) => (state.1[i].linear[j], state.1[i].effect),
                Slot::Shape(i, j) => (state.1[i].shape[j], state.1[i].effect),
            };
            let (low, high) = range(&forward.effects()[effect], slots[k]);
            let wanted = value + part[place];
            if !(low..=high).contains(&wanted) {
                step[k] = wanted.clamp(low, high) - value;
                held.push(k);
            }
        }
        if held.is_empty() {
            for (place, &k) in free.iter().enumerate() {
                step[k] = part[place];
            }
            break;
        }
        free.retain(|k| !held.contains(k));
    }
    step
}

type State = (Vec<f64>, Vec<Hypothesis>);

fn derivative(
    forward: &dyn Forward,
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
                    let step = searchable.step_at(j, tried.1[i].linear[j]);
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

fn moved(forward: &dyn Forward, state: &State, slots: &[Slot], step: &DVector<f64>) -> State {
    let mut tried = state.clone();
    for (k, &slot) in slots.iter().enumerate() {
        match slot {
            Slot::Nuisance(i) => tried.0[i] += step[k],
            Slot::Linear(i, j) => {
                tried.1[i].linear[j] += step[k];
                let searchable = &forward.effects()[tried.1[i].effect];
                let (low, high) = searchable.limits[j];
                tried.1[i].linear[j] = tried.1[i].linear[j].clamp(low, high);
                if searchable.never_negative && tried.1[i].linear[j] <= 0.0 {
                    tried.1[i].linear[j] = 1e-4 * searchable.step[j];
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
