//! From residuals to a set of effects: baseline, scan, forward steps, pairs, swaps, and the rivals of each.

use nalgebra::{DMatrix, DVector};
use rayon::prelude::*;

use crate::basis::{Basis, inverse_of_normal};
use crate::dictionary::{Dictionary, OUTSIDE_CATALOGUE};
use crate::evidence::{ln_bayes_factor, ln_sum_exp};
use crate::fit::{Fit, Whitener, fit, nuisance_tangents};
use crate::forward::{Forward, Hypothesis};
use crate::rivals::{Rival, rivals};
use crate::rounding::Rounding;
use crate::scan::{Found, Scan, Who, p_value, sign_evidence};
use crate::table::{Coordinate, Row};
use crate::whitening::{Sequence, heavy_tail_weights};

/// What may be chosen about a search; the defaults are those of the documentation.
#[derive(Debug, Clone, Copy)]
pub struct Settings {
    /// Seed of the simulated scans.
    pub seed: u64,
    /// Number of simulated noise-only scans.
    pub nulls: usize,
    /// A whole scan less probable than this under noise alone is a disagreement.
    pub significance: f64,
    /// Relative error allowed to the formula of an effect.
    pub model_form: f64,
    /// A further effect must reach this share of the first one's significance.
    pub second_share: f64,
    /// Whether one factor on the stated uncertainties is fitted.
    pub fit_scale: bool,
}

impl Default for Settings {
    fn default() -> Self {
        Self {
            seed: 1,
            nulls: 2000,
            significance: 0.01,
            model_form: 0.03,
            second_share: 0.2,
            fit_scale: true,
        }
    }
}

/// The noise of these observations.
#[derive(Debug, Clone)]
pub struct Noise {
    /// Common factor on the stated uncertainties.
    pub scale: f64,
    /// Serial correlation of neighbours in time.
    pub rho: f64,
    /// Outlier weights, one a row.
    pub weights: Vec<f64>,
}

/// Who could make what one member of the set makes.
#[derive(Debug, Clone)]
pub struct Rivalry {
    /// Names and patterns by falling probability; what is left to 1 belongs to "nothing".
    pub ranked: Vec<Ranked>,
    /// ln Bayes factor of the member against nothing.
    pub ln_bayes_factor: f64,
    /// Probability of the whole scan under noise alone, given the other members.
    pub p_value: f64,
}

/// One row of the ranked table.
#[derive(Debug, Clone)]
pub struct Ranked {
    /// Who.
    pub label: Label,
    /// Posterior probability.
    pub posterior: f64,
    /// Significance in σ.
    pub sigma: f64,
    /// The refined fit with it, where one was made.
    pub hypothesis: Option<Hypothesis>,
}

/// A name, or a place without one.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Label {
    /// Number of an effect.
    Named(usize),
    /// No name, along this coordinate.
    Unnamed(Coordinate),
}

/// Structure that no effect in the catalogue makes.
#[derive(Debug, Clone)]
pub struct Unexplained {
    /// The strongest pattern.
    pub rival: Rival,
    /// Its significance in σ.
    pub sigma: f64,
    /// Its fitted change of every row.
    pub pattern: DVector<f64>,
}

/// The strongest generic pattern along one coordinate.
#[derive(Debug, Clone)]
pub struct Place {
    /// Along what.
    pub coordinate: Coordinate,
    /// Where.
    pub range: [f64; 2],
    /// Significance in σ.
    pub sigma: f64,
    /// In words.
    pub note: String,
}

/// Everything that the search found.
#[derive(Debug)]
pub struct Outcome {
    /// The baseline: nuisance alone.
    pub baseline: Fit,
    /// Nuisance and the named effects.
    pub after: Fit,
    /// The noise.
    pub noise: Noise,
    /// Rows that were rounded alike.
    pub rounding: Rounding,
    /// Order of the rows.
    pub sequence: Sequence,
    /// Probability of the first scan under noise alone.
    pub p_global: f64,
    /// One entry for each hypothesis of `after`.
    pub rivalries: Vec<Rivalry>,
    /// What is left without a name.
    pub unexplained: Option<Unexplained>,
    /// Where the baseline disagrees, strongest first.
    pub places: Vec<Place>,
    /// Significance (σ) of every effect at its plausible maximum: what the data could show (effect, component, σ).
    pub visibility: Vec<(usize, usize, f64)>,
    /// Number of simulated scans.
    pub nulls: usize,
}

/// Searches. None where the model cannot even predict these rows.
pub fn search<F: Forward + ?Sized>(forward: &F, rows: &[Row], settings: &Settings) -> Option<Outcome> {
    let run: Vec<usize> = rows.iter().map(|row| row.file).collect();
    let ordered = |row: &Row| match row.source {
        crate::table::Source::Reading => row.time_s,
        _ => f64::NAN,
    };
    let time: Vec<f64> = rows.iter().map(ordered).collect();
    let sequence = Sequence::by_time(&run, &time);
    let mut bench = Bench::new(forward, rows, &sequence, settings)?;
    let baseline = bench.baseline.clone();
    let scan = bench.scan(&baseline, &[], None);
    let first = bench.look(&scan, &baseline);
    bench.nulls = scan.nulls(settings.nulls, settings.seed, &sequence, bench.noise.rho);
    let statistic = |found: &[Found]| ln_sum_exp(&found.iter().map(|f| f.ln_evidence).collect::<Vec<_>>());
    let p_global = p_value(statistic(&first), &bench.nulls);
    let places = bench.places(&first);
    let visibility = bench.visibility(&baseline);

    let mut members: Vec<Hypothesis> = Vec::new();
    let mut current = baseline.clone();
    let mut unexplained: Option<(usize, f64)> = None;
    if p_global <= settings.significance {
        (members, current) = bench.grow(&scan, &first, &baseline);
        for _ in 0..4 {
            unexplained = bench.left_over(&current, &members);
            match bench.replace_or_drop(&mut members, unexplained)? {
                Change::None => break,
                Change::Swapped => {
                    if let Some(fitted) = bench.fit(&members) {
                        current = fitted;
                    }
                    bench.update_noise(&current);
                    // What the better name leaves may hold a second one.
                    (members, current) = bench.extend(members, current);
                }
                Change::Dropped => {
                    current = bench.fit(&members)?;
                    bench.update_noise(&current);
                }
            }
        }
        unexplained = bench.left_over(&current, &members);
        if let Some((alone, explained)) = bench.one_without_a_name(&current, &members, unexplained) {
            members.clear();
            current = bench.fit(&members)?;
            unexplained = Some((alone, explained));
        } else if let Some((_, left)) = unexplained {
            // What has no name may be all there is: only names that are strong beside it stay.
            let before = members.len();
            let strong = |i: usize| bench.explained_by(&members, &current, i) > BESIDE_SHARE * left;
            let keep: Vec<bool> = (0..before).map(strong).collect();
            let mut keep = keep.into_iter();
            members.retain(|_| keep.next().unwrap_or(true));
            if members.len() < before {
                current = bench.fit(&members)?;
                unexplained = bench.strongest_rival(&current, &members);
            }
        } else if members.is_empty() {
            unexplained = bench.strongest_rival(&current, &members);
        }
        // Strongest first.
        let mut strength: Vec<(f64, Hypothesis)> = members
            .iter()
            .enumerate()
            .map(|(i, member)| (bench.explained_by(&members, &current, i), member.clone()))
            .collect();
        strength.sort_by(|a, b| b.0.total_cmp(&a.0));
        members = strength.into_iter().map(|(_, member)| member).collect();
        current = bench.fit(&members)?;
    }
    let rivalries = (0..members.len())
        .map(|i| bench.rivalry(&members, i, unexplained))
        .collect::<Option<Vec<_>>>()?;
    let unexplained = unexplained.map(|(candidate, explained)| bench.unexplained(&current, candidate, explained));
    let noise = bench.noise.clone();
    Some(Outcome {
        baseline,
        after: current,
        noise,
        rounding: bench.rounding,
        p_global,
        rivalries,
        unexplained,
        places,
        visibility,
        nulls: settings.nulls,
        sequence: sequence.clone(),
    })
}

/// A name beside a pattern without one must explain this many times what the pattern explains: a generic pattern is but a
/// likeness of the unknown, and what it misses looks like anything.
const BESIDE_SHARE: f64 = 2.0;

/// A stated uncertainty is not ten times too large: readings that agree better were copied, rounded or averaged.
const LEAST_SCALE: f64 = 0.1;

/// ln of the factor that a generic pattern loses where a name explains as much.
const ALIAS: f64 = 4.0;

/// One row of a comparison before it is a probability.
struct Entry {
    label: Label,
    /// ln(prior · Bayes factor) and explained σ² of every pattern under this label.
    evidence: Vec<(f64, f64)>,
    explained: f64,
    hypothesis: Option<Hypothesis>,
}

/// What a look at one member's rivals changed.
enum Change {
    None,
    Swapped,
    /// A pattern without a name makes it better, or nothing is left for it to make.
    Dropped,
}

struct Bench<'a, F: Forward + ?Sized> {
    forward: &'a F,
    measured: DVector<f64>,
    u: DVector<f64>,
    sequence: &'a Sequence,
    rounding: Rounding,
    least_scale: f64,
    settings: &'a Settings,
    rivals: Vec<Rival>,
    dictionary: Dictionary,
    smooth: Vec<usize>,
    /// Derivatives to the nuisance at the baseline.
    tangents: DMatrix<f64>,
    noise: Noise,
    freedom: f64,
    /// The dictionary, whitened with the present noise.
    whitened: DMatrix<f64>,
    baseline: Fit,
    nulls: Vec<f64>,
}

impl<'a, F: Forward + ?Sized> Bench<'a, F> {
    fn new(forward: &'a F, rows: &'a [Row], sequence: &'a Sequence, settings: &'a Settings) -> Option<Self> {
        let n = rows.len();
        let measured = DVector::from_iterator(n, rows.iter().map(|row| row.measured));
        let u = DVector::from_iterator(n, rows.iter().map(|row| row.u));
        let noise = Noise {
            scale: 1.0,
            rho: 0.0,
            weights: vec![1.0; n],
        };
        let alone = Rounding::default();
        let plain = Whitener {
            sequence,
            rounding: &alone,
            row_scale: u.map(|u| 1.0 / u),
            rho: 0.0,
        };
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
        let rivals = rivals(rows, level.as_slice(), sequence.order());
        let dictionary = Dictionary::new(
            forward,
            &baseline.nuisance,
            &level,
            &rivals,
            &plain.row_scale,
            &tangents,
        );
        let smooth = dictionary.smooth(forward.effects(), &rivals);
        let whitened = DMatrix::zeros(n, 0);
        let mut bench = Self {
            forward,
            measured,
            u,
            sequence,
            rounding,
            least_scale,
            settings,
            rivals,
            dictionary,
            smooth,
            tangents,
            noise,
            freedom: 1.0,
            whitened,
            baseline,
            nulls: Vec::new(),
        };
        let start = bench.baseline.clone();
        bench.update_noise(&start);
        bench.baseline = bench.fit(&[])?;
        Some(bench)
    }

    fn whitener(&self) -> Whitener<'_> {
        self.whitener_with(&self.rounding)
    }

    fn whitener_with<'r>(&self, rounding: &'r Rounding) -> Whitener<'r>
    where
        'a: 'r,
    {
        let scale = self
            .u
            .zip_map(&DVector::from_column_slice(&self.noise.weights), |u, w| w.sqrt() / u);
        Whitener {
            sequence: self.sequence,
            rounding,
            row_scale: scale,
            rho: self.noise.rho,
        }
    }

    fn fit(&self, members: &[Hypothesis]) -> Option<Fit> {
        fit(
            self.forward,
            &self.measured,
            &self.whitener(),
            &self.baseline.nuisance,
            &self.tangents,
            members,
        )
    }

    /// Noise from what is left of a fit after everything smooth is projected out: outlier weights, ρ, scale.
    fn update_noise(&mut self, fitted: &Fit) {
        let n = self.measured.len();
        let raw = &self.measured - &fitted.prediction;
        let limit = if n > 2000 { 120 } else { n / 3 };
        let columns = self.dictionary.columns.select_columns(&self.smooth);
        let unweighted = Whitener {
            sequence: self.sequence,
            rounding: &self.rounding,
            row_scale: self.u.map(|u| 1.0 / u),
            rho: 0.0,
        };
        let parameters = self.parameter_columns(fitted);
        let basis_of = |whitener: &Whitener<'_>| {
            let mut known = parameters.clone();
            whitener.apply(&mut known);
            let mut basis = Basis::spanning(&known, 1e-8);
            // Blocks of a few columns until the limit, so that the effort stays bounded.
            let mut smooth = columns.clone();
            whitener.apply(&mut smooth);
            for start in (0..smooth.ncols()).step_by(16) {
                if basis.rank() >= limit {
                    break;
                }
                let count = 16.min(smooth.ncols() - start);
                basis.extend(&smooth.columns(start, count).into_owned(), 0.1);
            }
            basis
        };
        let basis = basis_of(&unweighted);
        let mut residual = unweighted.vector(&raw);
        basis.project_out_vector(&mut residual);
        let freedom = (n as f64 - basis.rank() as f64).max(1.0);
        let rms = (residual.norm_squared() / freedom).sqrt().max(f64::MIN_POSITIVE);
        self.noise.weights = heavy_tail_weights(&(&residual / rms));
        let rho = self.sequence.autocorrelation(&residual, basis.directions());
        // White noise has a correlation of this size by chance.
        self.noise.rho = if rho > 1.5 / freedom.sqrt() { rho } else { 0.0 };
        let rounding = self.rounding.clone();
        let whitener = self.whitener_with(&rounding);
        let basis = basis_of(&whitener);
        let mut residual = whitener.vector(&raw);
        basis.project_out_vector(&mut residual);
        self.freedom = (n as f64 - basis.rank() as f64).max(1.0);
        self.noise.scale = if self.settings.fit_scale {
            (residual.norm_squared() / self.freedom).sqrt().max(self.least_scale)
        } else {
            1.0
        };
        self.whitened = self.dictionary.columns.clone();
        whitener.apply(&mut self.whitened);
    }

    /// Unwhitened derivatives to nuisance and amplitudes.
    fn parameter_columns(&self, fitted: &Fit) -> DMatrix<f64> {
        let base = &fitted.prediction;
        let mut columns: Vec<DVector<f64>> = self.tangents.column_iter().map(nalgebra::Matrix::into_owned).collect();
        for (i, member) in fitted.hypotheses.iter().enumerate() {
            for j in 0..member.linear.len() {
                let mut tried = fitted.hypotheses.clone();
                let step = 0.1 * self.forward.effects()[member.effect].step[j];
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

    /// The scan of what a fit leaves; effects that are in it already and `extra` directions are projected out.
    fn scan(&self, fitted: &Fit, members: &[Hypothesis], extra: Option<usize>) -> Scan {
        let mut out = Basis::spanning(&fitted.jacobian, 1e-9);
        if let Some(candidate) = extra {
            let columns = self.dictionary.candidates[candidate].columns.clone();
            out.extend(&self.whitened.columns(columns.start, columns.len()).into_owned(), 1e-6);
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
        Scan::new(&self.whitened, &kept, &out, self.noise.scale, self.freedom)
    }

    fn look(&self, scan: &Scan, fitted: &Fit) -> Vec<Found> {
        scan.look(&(&fitted.residual / self.noise.scale))
    }

    fn name_evidence(&self, found: &[Found]) -> Vec<(usize, f64)> {
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
    fn start(&self, scan: &Scan, fitted: &Fit, found: &[Found], effect: usize) -> Option<(Hypothesis, f64)> {
        let best = found
            .iter()
            .filter(|one| matches!(one.who, Who::Named { effect: e, .. } if e == effect))
            .max_by(|a, b| a.ln_evidence.total_cmp(&b.ln_evidence))?;
        let _ = scan;
        let Who::Named { shape, .. } = best.who else {
            return None;
        };
        Some((self.hypothesis(fitted, best.who, shape)?, best.explained))
    }

    /// A hypothesis with the amplitudes that the linear model gives.
    fn hypothesis(&self, fitted: &Fit, who: Who, shape: usize) -> Option<Hypothesis> {
        let Who::Named { effect, .. } = who else { return None };
        let searchable = &self.forward.effects()[effect];
        let candidate = self
            .dictionary
            .candidates
            .iter()
            .find(|candidate| candidate.who == who)?;
        let out = Basis::spanning(&fitted.jacobian, 1e-9);
        let mut columns = self
            .whitened
            .columns(candidate.columns.start, candidate.columns.len())
            .into_owned();
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
            linear[0] = linear[0].max(0.05 * searchable.step[0]);
        }
        Some(Hypothesis {
            effect,
            linear,
            shape: searchable.shapes[shape].clone(),
        })
    }

    /// The first members: the best single effect, or the best pair where two explain what one cannot.
    fn grow(&mut self, scan: &Scan, first: &[Found], baseline: &Fit) -> (Vec<Hypothesis>, Fit) {
        let singles = self.name_evidence(first);
        let Some(&(best, _)) = singles.first() else {
            return (Vec::new(), baseline.clone());
        };
        let mut tried: Vec<(f64, Vec<Hypothesis>, Fit)> = Vec::new();
        // Full fits of the few best: a tangent can mislead where an effect is strong.
        let candidates: Vec<usize> = singles
            .iter()
            .take_while(|(_, e)| *e > singles[0].1 - 12.0)
            .take(4)
            .map(|(e, _)| *e)
            .collect();
        for effect in candidates {
            let Some((start, _)) = self.start(scan, baseline, first, effect) else {
                continue;
            };
            if let Some(fitted) = self.fit(&[start]) {
                tried.push((fitted.chi2, fitted.hypotheses.clone(), fitted));
            }
        }
        let _ = best;
        tried.sort_by(|a, b| a.0.total_cmp(&b.0));
        let Some((single_chi2, members, fitted)) = tried.into_iter().next() else {
            return (Vec::new(), baseline.clone());
        };
        let variance = self.noise.scale.powi(2);
        let single_explained = (baseline.chi2 - single_chi2) / variance;
        if let Some((pair, pair_fit)) = self.best_pair(scan, first, baseline) {
            let pair_explained = (baseline.chi2 - pair_fit.chi2) / variance;
            let gain = pair_explained - single_explained;
            let weaker = (0..2)
                .map(|i| self.explained_by(&pair, &pair_fit, i))
                .fold(f64::INFINITY, f64::min);
            let stronger = (0..2)
                .map(|i| self.explained_by(&pair, &pair_fit, i))
                .fold(0.0, f64::max);
            let needed = (2.0 * (self.forward.effects().len() as f64).ln() + 8.0)
                .max(self.settings.second_share.powi(2) * stronger)
                .max((self.settings.model_form).powi(2) * stronger + 9.0);
            if gain > needed && weaker > needed {
                self.update_noise(&pair_fit);
                if let Some(fitted) = self.fit(&pair) {
                    let pair = fitted.hypotheses.clone();
                    return self.extend(pair, fitted);
                }
            }
        }
        self.update_noise(&fitted);
        match self.fit(&members) {
            Some(fitted) => {
                let members = fitted.hypotheses.clone();
                self.extend(members, fitted)
            }
            None => (members, fitted),
        }
    }

    /// Further named effects while the scan of what is left asks for one and one answers.
    fn extend(&mut self, mut members: Vec<Hypothesis>, mut fitted: Fit) -> (Vec<Hypothesis>, Fit) {
        while members.len() < 4 {
            let scan = self.scan(&fitted, &members, None);
            let found = self.look(&scan, &fitted);
            if !self.disagrees(&found) {
                break;
            }
            let Some(&(effect, evidence)) = self.name_evidence(&found).first() else {
                break;
            };
            let unnamed = ln_sum_exp(
                &found
                    .iter()
                    .filter(|one| matches!(one.who, Who::Unnamed { .. }))
                    .map(|one| one.ln_evidence)
                    .collect::<Vec<_>>(),
            );
            if unnamed > evidence + 1.0 {
                break;
            }
            let Some((start, _)) = self.start(&scan, &fitted, &found, effect) else {
                break;
            };
            let mut grown = members.clone();
            grown.push(start);
            let Some(next) = self.fit(&grown) else { break };
            let strongest = (0..members.len())
                .map(|i| self.explained_by(&members, &fitted, i))
                .fold(0.0, f64::max);
            let gained = (fitted.chi2 - next.chi2) / self.noise.scale.powi(2);
            if gained < self.settings.second_share.powi(2) * strongest || gained < 9.0 {
                break;
            }
            members.clone_from(&next.hypotheses);
            self.update_noise(&next);
            let Some(refitted) = self.fit(&members) else { break };
            fitted = refitted;
            members.clone_from(&fitted.hypotheses);
        }
        (members, fitted)
    }

    fn disagrees(&self, found: &[Found]) -> bool {
        let statistic = ln_sum_exp(&found.iter().map(|one| one.ln_evidence).collect::<Vec<_>>());
        p_value(statistic, &self.nulls) <= self.settings.significance
    }

    /// The pair of named effects that explains most, from the Gram matrix of the scan's directions.
    fn best_pair(&self, scan: &Scan, first: &[Found], baseline: &Fit) -> Option<(Vec<Hypothesis>, Fit)> {
        let residual = &baseline.residual / self.noise.scale;
        // All shapes of every effect; of a search through frequencies only the best few.
        let mut by_effect: Vec<Vec<usize>> = vec![Vec::new(); self.forward.effects().len()];
        for (place, seen) in scan.seen.iter().enumerate() {
            if let Who::Named { effect, .. } = seen.who {
                by_effect[effect].push(place);
            }
        }
        for places in &mut by_effect {
            places.sort_by(|&a, &b| first[b].explained.total_cmp(&first[a].explained));
            places.truncate(12);
        }
        let places: Vec<(usize, usize)> = by_effect
            .iter()
            .enumerate()
            .flat_map(|(effect, places)| places.iter().map(move |&place| (effect, place)))
            .collect();
        let blocks: Vec<DMatrix<f64>> = places
            .iter()
            .map(|&(_, place)| scan.block(&scan.seen[place]).into_owned())
            .collect();
        let z: Vec<DVector<f64>> = blocks.iter().map(|block| block.tr_mul(&residual)).collect();
        let mut best: Vec<(f64, usize, usize)> = (0..places.len())
            .into_par_iter()
            .flat_map_iter(|a| {
                let (blocks, z, places) = (&blocks, &z, &places);
                ((a + 1)..places.len())
                    .filter(move |&b| places[a].0 != places[b].0)
                    .filter_map(move |b| {
                        let cross = blocks[a].tr_mul(&blocks[b]);
                        let left = &z[b] - cross.tr_mul(&z[a]);
                        let inner = DMatrix::identity(left.len(), left.len()) - cross.tr_mul(&cross);
                        // Nearly the same pattern twice is no pair.
                        let inverse = inner.clone().try_inverse()?;
                        if inner.determinant() < 1e-3 {
                            return None;
                        }
                        let gained = left.dot(&(inverse * &left));
                        let explained = z[a].norm_squared() + gained;
                        Some((ln_bayes_factor(explained, z[a].len() + z[b].len()), a, b))
                    })
            })
            .collect();
        best.sort_by(|x, y| y.0.total_cmp(&x.0));
        // Refine the best of several different pairs of names.
        let mut names: Vec<(usize, usize)> = Vec::new();
        let mut fits: Vec<Fit> = Vec::new();
        for &(_, a, b) in best.iter().take(400) {
            let pair = (places[a].0.min(places[b].0), places[a].0.max(places[b].0));
            if names.contains(&pair) {
                continue;
            }
            names.push(pair);
            let start = |place: usize| {
                let who = scan.seen[place].who;
                let Who::Named { shape, .. } = who else { return None };
                self.hypothesis(baseline, who, shape)
            };
            if let (Some(one), Some(two)) = (start(places[a].1), start(places[b].1)) {
                fits.extend(self.fit(&[one, two]));
            }
            if names.len() >= 4 {
                break;
            }
        }
        let fitted = fits.into_iter().min_by(|a, b| a.chi2.total_cmp(&b.chi2))?;
        Some((fitted.hypotheses.clone(), fitted))
    }

    /// Squared significance of member `i` with all others free.
    fn explained_by(&self, members: &[Hypothesis], fitted: &Fit, i: usize) -> f64 {
        let others: Vec<Hypothesis> = members
            .iter()
            .enumerate()
            .filter(|(k, _)| *k != i)
            .map(|(_, member)| member.clone())
            .collect();
        self.fit(&others)
            .map_or(0.0, |without| (without.chi2 - fitted.chi2) / self.noise.scale.powi(2))
    }

    /// What is left after all named effects, if it is significant and not small beside them: the best rival.
    fn left_over(&self, fitted: &Fit, members: &[Hypothesis]) -> Option<(usize, f64)> {
        let scan = self.scan(fitted, members, None);
        let found = self.look(&scan, fitted);
        if !self.disagrees(&found) {
            return None;
        }
        let strongest = (0..members.len())
            .map(|i| self.explained_by(members, fitted, i))
            .fold(0.0, f64::max);
        let best = found
            .iter()
            .filter(|one| matches!(one.who, Who::Unnamed { .. }))
            .max_by(|a, b| a.ln_evidence.total_cmp(&b.ln_evidence))?;
        let kept: Vec<usize> = self.kept(members);
        // The disagreement itself may be a name that was not taken: a pattern counts by its own evidence.
        if p_value(best.ln_evidence, &self.nulls) > self.settings.significance {
            return None;
        }
        (best.explained > self.settings.second_share.powi(2) * strongest)
            .then_some((kept[best.candidate], best.explained))
    }

    /// The best rival in the scan of a fit, significant or not.
    fn strongest_rival(&self, fitted: &Fit, members: &[Hypothesis]) -> Option<(usize, f64)> {
        let scan = self.scan(fitted, members, None);
        let best = self
            .look(&scan, fitted)
            .into_iter()
            .filter(|one| matches!(one.who, Who::Unnamed { .. }))
            .max_by(|a, b| a.ln_evidence.total_cmp(&b.ln_evidence))?;
        Some((self.kept(members)[best.candidate], best.explained))
    }

    /// The pattern without a name that alone makes what the members (and what they leave unexplained) make, and better.
    ///
    /// Two names and a remainder can imitate one unknown thing; one unknown thing is the simpler belief.
    fn one_without_a_name(
        &self,
        fitted: &Fit,
        members: &[Hypothesis],
        extra: Option<(usize, f64)>,
    ) -> Option<(usize, f64)> {
        let base = self.fit(&[])?;
        let scan = self.scan(&base, &[], None);
        let alone = self
            .look(&scan, &base)
            .into_iter()
            .filter(|one| matches!(one.who, Who::Unnamed { .. }))
            .max_by(|a, b| a.ln_evidence.total_cmp(&b.ln_evidence))?;
        let variance = self.noise.scale.powi(2);
        let mut explained = (base.chi2 - fitted.chi2) / variance;
        let mut evidence = 0.5 * explained;
        for (i, member) in members.iter().enumerate() {
            let own = self.explained_by(members, fitted, i);
            evidence += self.refined_evidence(fitted, i, member, own) - 0.5 * own;
        }
        if let Some((candidate, more)) = extra {
            let left = self.scan(fitted, members, None);
            let of = self
                .look(&left, fitted)
                .into_iter()
                .find(|one| matches!(one.who, Who::Unnamed { .. }) && self.kept(members)[one.candidate] == candidate)?;
            evidence += of.ln_evidence;
            explained += more;
        }
        let margin = if members.len() + usize::from(extra.is_some()) > 1 {
            0.0
        } else {
            0.5 * self.alias_margin(explained)
        };
        (alone.ln_evidence > evidence + margin).then(|| (self.kept(&[])[alone.candidate], alone.explained))
    }

    /// What a pattern without a name must explain more than a name, in σ², before it counts as another pattern.
    fn alias_margin(&self, explained: f64) -> f64 {
        6.0 + 4.0 * self.settings.model_form.powi(2) * explained.max(0.0)
    }

    /// ln(prior · Bayes factor) of member `i` of a fit that explains `explained`, its shape averaged over what was believed
    /// of it (Laplace).
    fn refined_evidence(&self, fitted: &Fit, i: usize, member: &Hypothesis, explained: f64) -> f64 {
        let effects = self.forward.effects();
        let searchable = &effects[member.effect];
        let mut evidence = ((1.0 - OUTSIDE_CATALOGUE) / effects.len().max(1) as f64).ln()
            + ln_bayes_factor(explained, member.linear.len());
        if searchable.one_sided {
            evidence += sign_evidence(member.linear[0]);
        }
        evidence -= 0.5 * searchable.implausibility(&member.linear);
        if !searchable.fixed.is_empty() && searchable.fixed.iter().all(|fixed| *fixed) {
            return evidence - (searchable.shapes.len() as f64).ln();
        }
        let free: Vec<usize> = (0..member.shape.len()).filter(|&j| !searchable.fixed[j]).collect();
        if free.is_empty() {
            return evidence;
        }
        // The columns of this member's shapes, everything else projected out.
        let width = |hypothesis: &Hypothesis| {
            let fixed = &effects[hypothesis.effect].fixed;
            hypothesis.linear.len() + fixed.iter().filter(|fixed| !**fixed).count()
        };
        let start =
            fitted.nuisance.len() + fitted.hypotheses[..i].iter().map(width).sum::<usize>() + member.linear.len();
        let own = start..start + free.len();
        let rest: Vec<usize> = (0..fitted.jacobian.ncols()).filter(|k| !own.contains(k)).collect();
        let mut inside = fitted.jacobian.columns(own.start, own.len()).into_owned();
        Basis::spanning(&fitted.jacobian.select_columns(&rest), 1e-9).project_out(&mut inside);
        for (place, &j) in free.iter().enumerate() {
            let spread = searchable.believed[j];
            let sigma = spread.width / 12.0_f64.sqrt();
            inside.column_mut(place).scale_mut(sigma / self.noise.scale);
            if let Some(middle) = spread.middle {
                evidence -= 0.5 * ((member.shape[j] - middle) / sigma).powi(2);
            }
        }
        let information = DMatrix::identity(free.len(), free.len()) + inside.tr_mul(&inside);
        let determinant = information.determinant();
        if determinant.is_finite() {
            evidence - 0.5 * determinant.max(1.0).ln()
        } else {
            evidence
        }
    }

    /// Numbers, in the dictionary, of the candidates that a scan with these members keeps.
    fn kept(&self, members: &[Hypothesis]) -> Vec<usize> {
        (0..self.dictionary.candidates.len())
            .filter(|&k| match self.dictionary.candidates[k].who {
                Who::Named { effect, .. } => members.iter().all(|member| member.effect != effect),
                Who::Unnamed { .. } => true,
            })
            .collect()
    }

    /// Looks at every member's rivals: a better name takes its place, a better pattern without a name removes it.
    fn replace_or_drop(&self, members: &mut Vec<Hypothesis>, extra: Option<(usize, f64)>) -> Option<Change> {
        for i in 0..members.len() {
            let rivalry = self.rivalry(members, i, extra)?;
            let Some(top) = rivalry.ranked.first() else { continue };
            let nothing = 1.0 - rivalry.ranked.iter().map(|ranked| ranked.posterior).sum::<f64>();
            if nothing > top.posterior {
                members.remove(i);
                return Some(Change::Dropped);
            }
            match (&top.label, &top.hypothesis) {
                (Label::Named(effect), Some(hypothesis)) if *effect != members[i].effect => {
                    members[i] = hypothesis.clone();
                    return Some(Change::Swapped);
                }
                (Label::Unnamed(_), _) => {
                    let named: f64 = rivalry
                        .ranked
                        .iter()
                        .filter(|ranked| matches!(ranked.label, Label::Named(_)))
                        .map(|ranked| ranked.posterior)
                        .sum();
                    let unnamed: f64 = rivalry
                        .ranked
                        .iter()
                        .filter(|ranked| matches!(ranked.label, Label::Unnamed(_)))
                        .map(|ranked| ranked.posterior)
                        .sum();
                    if unnamed > named {
                        members.remove(i);
                        return Some(Change::Dropped);
                    }
                }
                _ => {}
            }
        }
        Some(Change::None)
    }

    /// Who else could be member `i`, with all other members free and what is unexplained projected out.
    fn rivalry(&self, members: &[Hypothesis], i: usize, extra: Option<(usize, f64)>) -> Option<Rivalry> {
        let others: Vec<Hypothesis> = members
            .iter()
            .enumerate()
            .filter(|(k, _)| *k != i)
            .map(|(_, member)| member.clone())
            .collect();
        let base = self.fit(&others)?;
        let scan = self.scan(&base, &others, extra.map(|(candidate, _)| candidate));
        let found = self.look(&scan, &base);
        let statistic = ln_sum_exp(&found.iter().map(|one| one.ln_evidence).collect::<Vec<_>>());
        let named = self.name_evidence(&found);
        let top = named.first().map_or(f64::NEG_INFINITY, |(_, evidence)| *evidence);
        let variance = self.noise.scale.powi(2);
        let close: Vec<usize> = named
            .iter()
            .enumerate()
            .filter(|(rank, (effect, evidence))| {
                *effect == members[i].effect || (*rank < 6 && *evidence > top - 14.0 - 0.02 * top.max(0.0))
            })
            .map(|(_, (effect, _))| *effect)
            .collect();
        let refined: Vec<(usize, Hypothesis, f64, f64)> = close
            .par_iter()
            .filter_map(|&effect| {
                let (start, linear) = self.start(&scan, &base, &found, effect)?;
                let start = if effect == members[i].effect {
                    members[i].clone()
                } else {
                    start
                };
                let mut tried = others.clone();
                tried.push(start);
                let fitted = self.fit(&tried)?;
                let hypothesis = fitted.hypotheses.last()?.clone();
                // With a pattern without a name beside it only the scan knows what is left for the name.
                let explained = if extra.is_some() {
                    linear
                } else {
                    (base.chi2 - fitted.chi2) / variance
                };
                let evidence = self.refined_evidence(&fitted, others.len(), &hypothesis, explained);
                Some((effect, hypothesis, explained, evidence))
            })
            .collect();
        let mut entries: Vec<Entry> = Vec::new();
        for &(effect, evidence) in &named {
            let linear = found
                .iter()
                .filter(|one| matches!(one.who, Who::Named { effect: e, .. } if e == effect))
                .map(|one| one.explained)
                .fold(0.0, f64::max);
            let mut entry = Entry {
                label: Label::Named(effect),
                evidence: vec![(evidence, linear)],
                explained: linear,
                hypothesis: None,
            };
            if let Some((_, hypothesis, explained, evidence)) = refined.iter().find(|(e, ..)| *e == effect) {
                entry.evidence = vec![(*evidence, *explained)];
                entry.explained = *explained;
                entry.hypothesis = Some(hypothesis.clone());
            }
            entries.push(entry);
        }
        let best_name = entries.iter().map(|entry| entry.explained).fold(0.0, f64::max);
        for one in &found {
            if let Who::Unnamed { rival } = one.who {
                let label = Label::Unnamed(self.rivals[rival].coordinate);
                // A generic pattern that does no better than a name is that name's likeness, not another cause.
                let alias = one.explained < best_name + self.alias_margin(best_name);
                let evidence = one.ln_evidence - if alias { ALIAS } else { 0.0 };
                match entries.iter_mut().find(|entry| entry.label == label) {
                    Some(entry) => {
                        entry.evidence.push((evidence, one.explained));
                        entry.explained = entry.explained.max(one.explained);
                    }
                    None => entries.push(Entry {
                        label,
                        evidence: vec![(evidence, one.explained)],
                        explained: one.explained,
                        hypothesis: None,
                    }),
                }
            }
        }
        // What the formulas are allowed to be wrong by adds to the noise of every comparison: the likelihood is blunted by
        // that, never what was believed before.
        let strongest = entries.iter().map(|entry| entry.explained).fold(0.0, f64::max);
        let sharpness = 1.0 / (1.0 + self.settings.model_form.powi(2) * strongest);
        let blunted = |entry: &Entry| {
            let terms: Vec<f64> = entry
                .evidence
                .iter()
                .map(|(evidence, explained)| evidence - 0.5 * explained * (1.0 - sharpness))
                .collect();
            ln_sum_exp(&terms)
        };
        let mut entries: Vec<(f64, Entry)> = entries.into_iter().map(|entry| (blunted(&entry), entry)).collect();
        entries.sort_by(|a, b| b.0.total_cmp(&a.0));
        let best = entries.first().map_or(0.0, |entry| entry.0).max(0.0);
        let weights: Vec<f64> = entries.iter().map(|entry| (entry.0 - best).exp()).collect();
        let total = weights.iter().sum::<f64>() + (-best).exp();
        let own = entries
            .iter()
            .find(|(_, entry)| entry.label == Label::Named(members[i].effect))
            .map_or(0.0, |(_, entry)| {
                ln_sum_exp(&entry.evidence.iter().map(|(e, _)| *e).collect::<Vec<_>>())
            });
        let ranked = entries
            .into_iter()
            .zip(weights)
            .map(|((_, entry), weight)| Ranked {
                label: entry.label,
                posterior: weight / total,
                sigma: entry.explained.max(0.0).sqrt(),
                hypothesis: entry.hypothesis,
            })
            .collect();
        Some(Rivalry {
            ranked,
            ln_bayes_factor: own,
            p_value: p_value(statistic, &self.nulls),
        })
    }

    fn places(&self, found: &[Found]) -> Vec<Place> {
        let mut places: Vec<(f64, Place)> = Vec::new();
        for one in found {
            let Who::Unnamed { rival } = one.who else { continue };
            let rival = &self.rivals[rival];
            let place = Place {
                coordinate: rival.coordinate,
                range: rival.range,
                sigma: one.explained.sqrt(),
                note: rival.note.clone(),
            };
            match places
                .iter_mut()
                .find(|(_, known)| known.coordinate == rival.coordinate)
            {
                Some(known) if known.0 >= one.ln_evidence => {}
                Some(known) => *known = (one.ln_evidence, place),
                None => places.push((one.ln_evidence, place)),
            }
        }
        places.sort_by(|a, b| b.0.total_cmp(&a.0));
        places.into_iter().map(|(_, place)| place).collect()
    }

    /// Significance of every effect's plausible maximum, best shape of its grid.
    fn visibility(&self, baseline: &Fit) -> Vec<(usize, usize, f64)> {
        let out = Basis::spanning(&baseline.jacobian, 1e-9);
        let effects = self.forward.effects();
        let mut best: Vec<(usize, usize, f64)> = Vec::new();
        for candidate in &self.dictionary.candidates {
            let Who::Named { effect, shape } = candidate.who else {
                continue;
            };
            if effects[effect].shapes.len() > 60 && shape % 16 != 0 {
                continue;
            }
            for (component, k) in candidate.columns.clone().enumerate() {
                let mut column = self.whitened.column(k).into_owned();
                let before = column.norm();
                out.project_out_vector(&mut column);
                let left = if column.norm() < 1e-9 * before {
                    0.0
                } else {
                    column.norm()
                };
                let sigma = left / self.noise.scale * effects[effect].plausible[component];
                match best.iter_mut().find(|(e, c, _)| (*e, *c) == (effect, component)) {
                    Some(known) => known.2 = known.2.max(sigma),
                    None => best.push((effect, component, sigma)),
                }
            }
        }
        best
    }

    fn unexplained(&self, fitted: &Fit, candidate: usize, explained: f64) -> Unexplained {
        let columns = self.dictionary.candidates[candidate].columns.clone();
        let Who::Unnamed { rival } = self.dictionary.candidates[candidate].who else {
            unreachable!("only rivals are unexplained")
        };
        let out = Basis::spanning(&fitted.jacobian, 1e-9);
        let mut inside = self.whitened.columns(columns.start, columns.len()).into_owned();
        out.project_out(&mut inside);
        let normal = inside.tr_mul(&inside);
        let amplitudes = inverse_of_normal(&normal, 1e-14) * inside.tr_mul(&fitted.residual);
        let pattern = self.dictionary.columns.columns(columns.start, columns.len()) * amplitudes;
        Unexplained {
            rival: self.rivals[rival].clone(),
            sigma: explained.sqrt(),
            pattern,
        }
    }
}
