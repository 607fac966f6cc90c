//! Whether a plan can tell a fault from every other effect, for somebody who knows the change that it makes.
//!
//! From the change without noise, added to what the model expects, every other effect of the catalogue is fitted by
//! itself, within twice its plausible range. What the best of them leaves, in σ above noise and the model's own
//! uncertainty, is how far apart truth and look-alike are.

use isolux_diagnose::assumed::AssumedModel;
use isolux_diagnose::basis::inverse_of_normal;
use isolux_diagnose::dictionary::Dictionary;
use isolux_diagnose::fit::{Fit, fit};
use isolux_diagnose::forward::{Forward, Hypothesis, Searchable};
use isolux_diagnose::scan::Who;
use isolux_diagnose::table::Row;
use nalgebra::{DMatrix, DVector};

use crate::strength::Known;

/// A truth this far from every look-alike can be told from it.
pub const SEPARABLE_SIGMA: f64 = 5.0;

/// Shapes of one effect that are fitted in full: the best by their tangents.
const FITTED: usize = 2;

/// The nearest other effect.
#[derive(Debug, Clone)]
pub struct LookAlike {
    /// Its name.
    pub name: &'static str,
    /// What it leaves of the change, in σ.
    pub left: f64,
}

/// A model that stays as it is: nothing but effects is fitted, for what it does not know is in the covariance.
struct Still<'a>(&'a AssumedModel);

impl Forward for Still<'_> {
    fn nuisances(&self) -> usize {
        0
    }

    fn effects(&self) -> &[Searchable] {
        self.0.effects()
    }

    fn predict(&self, _: &[f64], hypotheses: &[Hypothesis]) -> Option<DVector<f64>> {
        self.0.predict(&vec![0.0; self.0.nuisances()], hypotheses)
    }

    fn read_out(&self, effect: usize, amplitude: f64, prediction: &DVector<f64>) -> Option<DVector<f64>> {
        self.0.read_out(effect, amplitude, prediction)
    }
}

/// The effect other than `truth` that comes nearest to `change`; none where no other changes these values at all.
pub fn nearest(known: &Known, rows: &[Row], change: &DVector<f64>, truth: Option<&str>) -> Option<LookAlike> {
    let forward = Still(&known.assumed);
    let whitener = known.whitener();
    let measured = &known.level + change;
    let none = DMatrix::zeros(rows.len(), 0);
    let dictionary = Dictionary::new(
        &forward,
        rows,
        &[],
        (&known.level, &known.level),
        &mut [],
        &whitener.row_scale,
        &none,
    );
    let left = whitener.vector(change);
    // Of each candidate what its tangent explains, in σ², and where a full fit begins.
    let mut proposed: Vec<(f64, Hypothesis)> = Vec::new();
    for candidate in &dictionary.candidates {
        let Who::Named { effect, shape } = candidate.who else {
            continue;
        };
        let searchable = &forward.effects()[effect];
        if Some(searchable.name) == truth {
            continue;
        }
        let mut columns = dictionary.columns(&candidate.columns.clone().collect::<Vec<_>>());
        whitener.apply(&mut columns);
        let along = columns.tr_mul(&left);
        let (linear, explained) = if searchable.one_by_one {
            // Its response does not grow with the amplitude: each shape is one value.
            let value = searchable.step_of(shape, 0);
            let change = columns.column(0) * value;
            (vec![value], left.norm_squared() - (&left - change).norm_squared())
        } else {
            let amplitudes = inverse_of_normal(&columns.tr_mul(&columns), 1e-14) * &along;
            let within = amplitudes.iter().zip(&searchable.limits);
            let mut linear: Vec<f64> = within.map(|(value, (low, high))| value.clamp(*low, *high)).collect();
            if searchable.never_negative {
                linear[0] = linear[0].max(0.05 * searchable.step_of(shape, 0));
            }
            (linear, amplitudes.dot(&along))
        };
        let shape = searchable.shapes[shape].clone();
        proposed.push((explained, Hypothesis { effect, linear, shape }));
    }
    proposed.sort_by(|a, b| b.0.total_cmp(&a.0));
    let mut taken = vec![0; forward.effects().len()];
    proposed.retain(|(_, hypothesis)| {
        taken[hypothesis.effect] += 1;
        taken[hypothesis.effect] <= FITTED
    });
    let possible = |fitted: &Fit| {
        fitted.hypotheses.iter().all(|member| {
            let searchable = &forward.effects()[member.effect];
            (!searchable.one_sided || member.linear[0] >= 0.0) && searchable.implausibility(&member.linear) < 1.0
        })
    };
    proposed
        .into_iter()
        .filter_map(|(_, hypothesis)| fit(&forward, &measured, &whitener, &[], &none, &[hypothesis]))
        .filter(possible)
        .min_by(|a, b| a.chi2.total_cmp(&b.chi2))
        .map(|best| LookAlike {
            name: forward.effects()[best.hypotheses[0].effect].name,
            left: best.chi2.sqrt(),
        })
}
