//! What is diagnosed: rows, model, and every candidate that may be added to it. Nothing in it changes afterwards.

use nalgebra::{DMatrix, DVector};

use crate::alternatives::{EmpiricalAlternative, alternatives};
use crate::basis::Basis;
use crate::calibration::{LEAST_SCALE, SMOOTH_COLUMNS};
use crate::dictionary::Dictionary;
use crate::fit::{Fit, fit, nuisance_tangents};
use crate::forward::Forward;
use crate::known::{Known, expected_change};
use crate::reference::{Errors, joined};
use crate::rounding::Rounding;
use crate::table::{ObservationKind, Row};
use crate::whitener::Whitener;
use crate::whitening::Sequence;

use super::outcome::Settings;

pub(super) struct Problem<'a> {
    pub(super) forward: &'a dyn Forward,
    pub(super) rows: &'a [Row],
    pub(super) sequence: &'a Sequence,
    pub(super) settings: &'a Settings,
    pub(super) measured: DVector<f64>,
    pub(super) u: DVector<f64>,
    /// What the noise of the model's own distribution does to the rows, and what the model knows of itself.
    pub(super) errors: Errors,
    /// What the model knows of itself.
    pub(super) known: Vec<Known>,
    pub(super) least_scale: f64,
    pub(super) alternatives: Vec<EmpiricalAlternative>,
    pub(super) dictionary: Dictionary<'a>,
    /// Candidates of the dictionary that are smooth.
    pub(super) smooth: Vec<usize>,
    /// The model without effects, fitted with the stated uncertainties.
    pub(super) plain: Fit,
    /// Derivatives to the nuisance there.
    pub(super) tangents: DMatrix<f64>,
}

/// The model as it came, fitted without effects.
pub(super) struct Plain {
    pub(super) measured: DVector<f64>,
    pub(super) u: DVector<f64>,
    errors: Errors,
    known: Vec<Known>,
    fit: Fit,
    tangents: DMatrix<f64>,
    /// What it expects of every row, and, where a sensor reads it out, the light that is there: moved by all that it
    /// knows of itself to where the readings put it.
    level: DVector<f64>,
    pub(super) light: DVector<f64>,
    /// What a relative pattern multiplies.
    strength: DVector<f64>,
}

impl Plain {
    /// None where the model cannot even predict these rows.
    pub(super) fn of(forward: &dyn Forward, rows: &[Row], sequence: &Sequence) -> Option<Self> {
        let n = rows.len();
        let measured = DVector::from_iterator(n, rows.iter().map(|row| row.measured));
        let u = DVector::from_iterator(n, rows.iter().map(|row| row.u));
        let alone = Rounding::default();
        let stated = Whitener::new(sequence, &alone, u.map(|u| 1.0 / u), 0.0, &Errors::new());
        let start = vec![0.0; forward.nuisances()];
        let first = fit(
            forward,
            &measured,
            &stated,
            &start,
            &nuisance_tangents(forward, &start)?,
            &[],
        )?;
        let tangents = nuisance_tangents(forward, &first.nuisance)?;
        let plain = fit(forward, &measured, &stated, &first.nuisance, &tangents, &[])?;
        let level = forward.predict(&plain.nuisance, &[])?;
        // Short vectors first: each is whitened with those before it.
        let known = forward.known();
        let mut errors = joined(forward.common_errors(), &u.map(|u| 1.0 / u));
        errors.extend(known.iter().map(|one| one.column.iter().copied().enumerate().collect()));
        let (mut light, mut strength) = (level.clone(), level.clone());
        let sample = |row: &Row| row.source == ObservationKind::Sample;
        if (forward.full_scale().is_some() || rows.iter().any(sample)) && !errors.is_empty() {
            let shared = Whitener::new(sequence, &alone, u.map(|u| 1.0 / u), 0.0, &errors);
            let change = expected_change(&errors, &shared, &(&measured - &level));
            // Of a spectrum that is dark the noise alone is left: that of the model is in all that it leaves.
            for (at, _) in rows.iter().enumerate().filter(|(_, row)| sample(row)) {
                strength[at] += change[at];
            }
            if forward.full_scale().is_some() {
                light += change;
            }
        }
        Some(Self {
            measured,
            u,
            errors,
            known,
            fit: plain,
            tangents,
            level,
            light,
            strength,
        })
    }
}

impl<'a> Problem<'a> {
    pub(super) fn new(
        forward: &'a dyn Forward,
        rows: &'a [Row],
        sequence: &'a Sequence,
        settings: &'a Settings,
        plain: Plain,
    ) -> Self {
        let Plain {
            measured,
            u,
            errors,
            known,
            fit: plain,
            tangents,
            level,
            light,
            strength,
        } = plain;
        let least_scale = Rounding::least_scale(rows).max(LEAST_SCALE);
        let mut alternatives = alternatives(rows, strength.as_slice(), sequence.order());
        let dictionary = Dictionary::new(
            forward,
            rows,
            &plain.nuisance,
            (&level, &light),
            &mut alternatives,
            &u.map(|u| 1.0 / u),
            &tangents,
        );
        let smooth = dictionary.smooth(forward.effects(), &alternatives);
        Self {
            forward,
            rows,
            sequence,
            settings,
            measured,
            u,
            errors,
            known,
            least_scale,
            alternatives,
            dictionary,
            smooth,
            plain,
            tangents,
        }
    }

    /// Directions of the parameters and of everything smooth, whitened. Blocks of a few columns until the limit, so
    /// that the effort stays bounded.
    pub(super) fn smooth_directions(&self, whitener: &Whitener<'_>, parameters: &DMatrix<f64>) -> Basis {
        let n = self.measured.len();
        let (most, share) = SMOOTH_COLUMNS;
        let limit = if n > 2000 { most } else { n / share };
        let mut known = parameters.clone();
        whitener.apply(&mut known);
        let mut basis = Basis::spanning(&known, 1e-8);
        for numbers in self.smooth.chunks(16) {
            if basis.rank() >= limit {
                break;
            }
            let mut smooth = self.dictionary.columns(numbers);
            whitener.apply(&mut smooth);
            basis.extend(&smooth, 0.1);
        }
        basis
    }

    /// Unwhitened derivatives to nuisance and amplitudes.
    pub(super) fn parameter_columns(&self, forward: &dyn Forward, fitted: &Fit) -> DMatrix<f64> {
        let base = &fitted.prediction;
        let mut columns: Vec<DVector<f64>> = self.tangents.column_iter().map(nalgebra::Matrix::into_owned).collect();
        for (i, member) in fitted.hypotheses.iter().enumerate() {
            for j in 0..member.linear.len() {
                let mut tried = fitted.hypotheses.clone();
                let step = forward.effects()[member.effect].step_at(j, member.linear[j]);
                tried[i].linear[j] += step;
                if let Some(changed) = forward.predict(&fitted.nuisance, &tried) {
                    columns.push((changed - base) / step);
                }
            }
        }
        if columns.is_empty() {
            DMatrix::zeros(self.measured.len(), 0)
        } else {
            DMatrix::from_columns(&columns)
        }
    }
}
