//! The rows under test, their noise, and every candidate whitened with it.

use std::sync::Arc;

use nalgebra::{DMatrix, DVector};

use crate::basis::{Basis, inverse_of_normal};
use crate::dictionary::Dictionary;
use crate::evidence::ln_sum_exp;
use crate::fit::{Fit, Whitener, derivatives, fit, nuisance_tangents};
use crate::forward::{Forward, Hypothesis};
use crate::noise::{self, Left, NoiseTest};
use crate::reference::{Errors, Reference};
use crate::rivals::{Rival, rivals};
use crate::rounding::Rounding;
use crate::scan::{Candidate, Found, Scan, Who, p_value};
use crate::search::{Noise, Settings};
use crate::shrinkage::Held;
use crate::table::Row;
use crate::whitening::{Correlation, MOST_CORRELATED, Sequence, heavy_tail_weights};

/// A whitened dictionary of up to so many values (a quarter of a gigabyte) is kept; a larger one is computed block by
/// block wherever it is needed.
const KEPT_VALUES: usize = 1 << 25;
/// A stated uncertainty is not ten times too large: readings that agree better were copied, rounded or averaged.
const LEAST_SCALE: f64 = 0.1;

pub(super) struct Bench<'a, F: Forward + ?Sized> {
    pub(super) forward: &'a F,
    rows: &'a [Row],
    pub(super) measured: DVector<f64>,
    pub(super) u: DVector<f64>,
    pub(super) sequence: &'a Sequence,
    pub(super) rounding: Rounding,
    /// What the noise of the model's own distribution does to the rows.
    pub(super) errors: Errors,
    /// The same, prepared for the present noise.
    reference: Arc<Reference>,
    pub(super) least_scale: f64,
    pub(super) settings: &'a Settings,
    pub(super) rivals: Vec<Rival>,
    pub(super) dictionary: Dictionary<'a>,
    pub(super) smooth: Vec<usize>,
    /// Derivatives to the nuisance at the baseline.
    pub(super) tangents: DMatrix<f64>,
    pub(super) noise: Noise,
    pub(super) freedom: f64,
    /// The dictionary, whitened with the present noise, where it is small.
    kept: Option<DMatrix<f64>>,
    pub(super) baseline: Fit,
    pub(super) nulls: Vec<f64>,
}

impl<'a, F: Forward + ?Sized> Bench<'a, F> {
    pub(super) fn new(forward: &'a F, rows: &'a [Row], sequence: &'a Sequence, settings: &'a Settings) -> Option<Self> {
        let n = rows.len();
        let measured = DVector::from_iterator(n, rows.iter().map(|row| row.measured));
        let u = DVector::from_iterator(n, rows.iter().map(|row| row.u));
        let noise = Noise {
            scale: 1.0,
            observed: 1.0,
            rho: 0.0,
            u_rho: 0.0,
            variance_at: [1.0; 2],
            weights: vec![1.0; n],
        };
        let alone = Rounding::default();
        let plain = Whitener::new(sequence, &alone, u.map(|u| 1.0 / u), 0.0, &Errors::new());
        let start = vec![0.0; forward.nuisances()];
        let first = fit(
            forward,
            &measured,
            &plain,
            &start,
            &nuisance_tangents(forward, &start)?,
            &[],
        )?;
        let tangents = nuisance_tangents(forward, &first.nuisance)?;
        let baseline = fit(forward, &measured, &plain, &first.nuisance, &tangents, &[])?;
        let level = forward.predict(&baseline.nuisance, &[])?;
        let rounding = Rounding::new(rows, level.as_slice());
        let least_scale = Rounding::least_scale(rows).max(LEAST_SCALE);
        let mut rivals = rivals(rows, level.as_slice(), sequence.order());
        let dictionary = Dictionary::new(
            forward,
            rows,
            &baseline.nuisance,
            &level,
            &mut rivals,
            &plain.row_scale,
            &tangents,
        );
        let smooth = dictionary.smooth(forward.effects(), &rivals);
        let mut bench = Self {
            forward,
            rows,
            measured,
            u,
            sequence,
            rounding,
            errors: forward.common_errors(),
            reference: Arc::default(),
            least_scale,
            settings,
            rivals,
            dictionary,
            smooth,
            tangents,
            noise,
            freedom: 1.0,
            kept: None,
            baseline,
            nulls: Vec::new(),
        };
        let start = bench.baseline.clone();
        bench.update_noise(&start);
        bench.baseline = bench.fit(&[])?;
        Some(bench)
    }

    pub(super) fn whitener(&self) -> Whitener<'_> {
        Whitener {
            sequence: self.sequence,
            rounding: &self.rounding,
            row_scale: self.row_scale(),
            rho: self.noise.rho,
            reference: Arc::clone(&self.reference),
        }
    }

    /// √weight / u of each row.
    fn row_scale(&self) -> DVector<f64> {
        let weights = DVector::from_column_slice(&self.noise.weights);
        self.u.zip_map(&weights, |u, weight| weight.sqrt() / u)
    }

    pub(super) fn fit(&self, members: &[Hypothesis]) -> Option<Fit> {
        fit(
            self.forward,
            &self.measured,
            &self.whitener(),
            &self.baseline.nuisance,
            &self.tangents,
            members,
        )
    }

    /// Noise from what is left of a fit after everything smooth is projected out: outlier weights, ρ, scale. What is
    /// rounded alike goes by the levels of the fit: dark readings that an effect lifts by different amounts are none of
    /// them alike.
    pub(super) fn update_noise(&mut self, fitted: &Fit) {
        self.rounding = Rounding::new(self.rows, fitted.prediction.as_slice());
        let n = self.measured.len();
        let raw = &self.measured - &fitted.prediction;
        let limit = if n > 2000 { 120 } else { n / 3 };
        let rounding = self.rounding.clone();
        let unweighted = Whitener::new(self.sequence, &rounding, self.u.map(|u| 1.0 / u), 0.0, &self.errors);
        let parameters = self.parameter_columns(fitted);
        let basis_of = |whitener: &Whitener<'_>| {
            let mut known = parameters.clone();
            whitener.apply(&mut known);
            let mut basis = Basis::spanning(&known, 1e-8);
            // Blocks of a few columns until the limit, so that the effort stays bounded.
            for numbers in self.smooth.chunks(16) {
                if basis.rank() >= limit {
                    break;
                }
                let mut smooth = self.dictionary.columns(numbers);
                whitener.apply(&mut smooth);
                basis.extend(&smooth, 0.1);
            }
            basis
        };
        self.kept = None;
        let basis = basis_of(&unweighted);
        let mut residual = unweighted.vector(&raw);
        basis.project_out_vector(&mut residual);
        let freedom = (n as f64 - basis.rank() as f64).max(1.0);
        let rms = (residual.norm_squared() / freedom).sqrt().max(f64::MIN_POSITIVE);
        let correlation = self.sequence.autocorrelation(&residual, basis.directions());
        drop(basis);
        self.noise.weights = heavy_tail_weights(&(&residual / rms));
        // White noise has a correlation of this size by chance.
        let Correlation { rho, u } = correlation;
        (self.noise.rho, self.noise.u_rho) = if rho > 1.5 * u { (rho, u) } else { (0.0, 0.0) };
        let whitener = Whitener::new(self.sequence, &rounding, self.row_scale(), self.noise.rho, &self.errors);
        self.reference = Arc::clone(&whitener.reference);
        let basis = basis_of(&whitener);
        let mut residual = whitener.vector(&raw);
        basis.project_out_vector(&mut residual);
        self.freedom = (n as f64 - basis.rank() as f64).max(1.0);
        let Noise { rho, u_rho, .. } = self.noise;
        let variance = |off: f64| {
            let possible = (rho + off).clamp(0.0, MOST_CORRELATED);
            self.sequence.expected_variance(possible, rho, basis.directions())
        };
        self.noise.variance_at = if u_rho > 0.0 {
            [variance(-u_rho), variance(u_rho)]
        } else {
            [1.0; 2]
        };
        self.noise.observed = (residual.norm_squared() / self.freedom).sqrt().max(self.least_scale);
        self.noise.scale = if self.settings.fit_scale {
            self.noise.observed
        } else {
            1.0
        };
        if n * self.dictionary.width() <= KEPT_VALUES {
            let all: Vec<usize> = (0..self.dictionary.width()).collect();
            self.kept = Some(self.whitened(&all));
        }
    }

    /// A fit whose refitted terms are held.
    pub(super) fn fit_held(&self, members: &[Hypothesis], weights: &[f64]) -> Option<Fit> {
        let forward = Held {
            forward: self.forward,
            weights,
        };
        fit(
            &forward,
            &self.measured,
            &self.whitener(),
            &self.baseline.nuisance,
            &self.tangents,
            members,
        )
    }

    /// Whether what a fit leaves is noise; none where there is too little of it.
    pub(super) fn noise_test(&self, fitted: &Fit) -> Option<NoiseTest> {
        noise::test(&self.left(fitted)?, self.settings.nulls, self.settings.seed)
    }

    /// The members that no single place without a name (a period, a patch, …) explains better. What such a place is,
    /// the test of the noise says of what is left without them.
    pub(super) fn no_places(&self, mut members: Vec<Hypothesis>, fitted: &Fit) -> Option<(Vec<Hypothesis>, Fit)> {
        let mut current = fitted.clone();
        let mut i = 0;
        while i < members.len() {
            let without = self.fit(&all_but(&members, i))?;
            let own = (without.chi2 - current.chi2) / self.noise.scale.powi(2);
            let place = noise::strongest_place(&self.left(&without)?);
            let more = own + self.alias_margin(own) + noise::limits::PLACES;
            if place.is_some_and(|place| place.explained > more) {
                members.remove(i);
                current = without;
            } else {
                i += 1;
            }
        }
        Some((members, current))
    }

    fn left(&self, fitted: &Fit) -> Option<Left<'_>> {
        let rho = noise::noisy_rho(self.noise.rho);
        let row_scale = self.u.map(|u| 1.0 / u);
        let whitener = Whitener::new(self.sequence, &self.rounding, row_scale.clone(), rho, &self.errors);
        let raw = &self.measured - &fitted.prediction;
        let refitted = Basis::spanning(&derivatives(self.forward, &whitener, fitted)?, 1e-9);
        let mut whitened = whitener.vector(&raw);
        refitted.project_out_vector(&mut whitened);
        Some(Left {
            rows: self.rows,
            level: fitted.prediction.as_slice().to_vec(),
            plain: raw.component_mul(&row_scale),
            whitened,
            refitted,
            sequence: self.sequence,
            rho,
            rho_found: self.noise.rho,
            u_rho: self.noise.u_rho,
            scale: self.noise.observed,
            freedom: self.freedom,
            unit: self.noise.scale,
        })
    }

    /// Columns of the dictionary, whitened with the present noise.
    pub(super) fn whitened(&self, numbers: &[usize]) -> DMatrix<f64> {
        if let Some(kept) = &self.kept {
            return kept.select_columns(numbers);
        }
        let mut columns = self.dictionary.columns(numbers);
        self.whitener().apply(&mut columns);
        columns
    }

    /// Unwhitened derivatives to nuisance and amplitudes.
    pub(super) fn parameter_columns(&self, fitted: &Fit) -> DMatrix<f64> {
        let base = &fitted.prediction;
        let mut columns: Vec<DVector<f64>> = self.tangents.column_iter().map(nalgebra::Matrix::into_owned).collect();
        for (i, member) in fitted.hypotheses.iter().enumerate() {
            for j in 0..member.linear.len() {
                let mut tried = fitted.hypotheses.clone();
                let step = self.forward.effects()[member.effect].step_at(j, member.linear[j]);
                tried[i].linear[j] += step;
                if let Some(changed) = self.forward.predict(&fitted.nuisance, &tried) {
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

    /// The scan of what a fit leaves, all candidates against its residual; effects that are in it already and `extra`
    /// directions are projected out.
    pub(super) fn scan(&self, fitted: &Fit, members: &[Hypothesis], extra: Option<usize>) -> Scan {
        let mut out = Basis::spanning(&fitted.jacobian, 1e-9);
        if let Some(candidate) = extra {
            out.extend(&self.pattern(candidate), 1e-6);
        }
        let kept: Vec<_> = self
            .dictionary
            .candidates
            .iter()
            .filter(|candidate| match candidate.who {
                Who::Named { effect, .. } => members.iter().all(|member| member.effect != effect),
                Who::Unnamed { .. } => true,
            })
            .cloned()
            .collect();
        let residual = &fitted.residual / self.noise.scale;
        let whitened = |numbers: &[usize]| self.whitened(numbers);
        Scan::new(&whitened, kept, out, &residual, self.noise.scale, self.freedom)
    }

    /// The whitened columns of one candidate.
    pub(super) fn pattern(&self, candidate: usize) -> DMatrix<f64> {
        self.whitened(
            &self.dictionary.candidates[candidate]
                .columns
                .clone()
                .collect::<Vec<_>>(),
        )
    }

    /// Numbers, in the dictionary, of the candidates that a scan with these members keeps.
    pub(super) fn kept(&self, members: &[Hypothesis]) -> Vec<usize> {
        (0..self.dictionary.candidates.len())
            .filter(|&k| match self.dictionary.candidates[k].who {
                Who::Named { effect, .. } => members.iter().all(|member| member.effect != effect),
                Who::Unnamed { .. } => true,
            })
            .collect()
    }

    pub(super) fn disagrees(&self, found: &[Found]) -> bool {
        self.disagrees_at(found, self.settings.significance)
    }

    /// Whether noise alone makes a scan like this less often than `significance`, or never did.
    pub(super) fn disagrees_at(&self, found: &[Found], significance: f64) -> bool {
        let statistic = ln_sum_exp(&found.iter().map(|one| one.ln_evidence).collect::<Vec<_>>());
        let never = 1.0 / (self.nulls.len() + 1) as f64;
        p_value(statistic, &self.nulls) <= significance.max(never)
    }

    pub(super) fn name_evidence(&self, found: &[Found]) -> Vec<(usize, f64)> {
        let mut terms: Vec<Vec<f64>> = vec![Vec::new(); self.forward.effects().len()];
        for one in found {
            if let Who::Named { effect, .. } = one.who {
                terms[effect].push(one.ln_evidence);
            }
        }
        let mut named: Vec<(usize, f64)> = terms
            .iter()
            .enumerate()
            .filter(|(_, terms)| !terms.is_empty())
            .map(|(effect, terms)| (effect, ln_sum_exp(terms)))
            .collect();
        named.sort_by(|a, b| b.1.total_cmp(&a.1));
        named
    }

    /// The best shape of an effect in a scan, as a starting point for the fit.
    pub(super) fn start(&self, fitted: &Fit, found: &[Found], effect: usize) -> Option<(Hypothesis, f64)> {
        let best = found
            .iter()
            .filter(|one| matches!(one.who, Who::Named { effect: e, .. } if e == effect))
            .max_by(|a, b| a.ln_evidence.total_cmp(&b.ln_evidence))?;
        let Who::Named { shape, .. } = best.who else {
            return None;
        };
        Some((self.hypothesis(fitted, best.who, shape)?, best.explained))
    }

    /// A hypothesis with the amplitudes that the linear model gives.
    pub(super) fn hypothesis(&self, fitted: &Fit, who: Who, shape: usize) -> Option<Hypothesis> {
        let Who::Named { effect, .. } = who else { return None };
        let searchable = &self.forward.effects()[effect];
        let is_it = |candidate: &Candidate| candidate.who == who;
        let candidate = self.dictionary.candidates.iter().position(is_it)?;
        let out = Basis::spanning(&fitted.jacobian, 1e-9);
        let mut columns = self.pattern(candidate);
        out.project_out(&mut columns);
        let mut residual = fitted.residual.clone();
        out.project_out_vector(&mut residual);
        let normal = columns.tr_mul(&columns);
        let inverse = inverse_of_normal(&normal, 1e-14);
        let mut linear: Vec<f64> = (inverse * columns.tr_mul(&residual)).iter().copied().collect();
        for (value, (low, high)) in linear.iter_mut().zip(&searchable.limits) {
            *value = value.clamp(*low, *high);
        }
        if searchable.never_negative {
            linear[0] = linear[0].max(0.05 * searchable.step_of(shape, 0));
        }
        Some(Hypothesis {
            effect,
            linear,
            shape: searchable.shapes[shape].clone(),
        })
    }

    /// Squared significance of member `i` with all others free.
    pub(super) fn explained_by(&self, members: &[Hypothesis], fitted: &Fit, i: usize) -> f64 {
        let others = all_but(members, i);
        self.fit(&others)
            .map_or(0.0, |without| (without.chi2 - fitted.chi2) / self.noise.scale.powi(2))
    }
}

/// The members without the one at `i`.
pub(super) fn all_but(members: &[Hypothesis], i: usize) -> Vec<Hypothesis> {
    [&members[..i], &members[i + 1..]].concat()
}
