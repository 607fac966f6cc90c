//! What anybody could say of an effect without a name: `cargo bench -p isolux-hidden-effects --bench decidable -- KINDS
//! [cases a class] [seed]`, KINDS a class of the benchmark of the diagnosis without its significance (Second).
//!
//! Nothing here is the diagnosis' own search. From readings without noise the refitted terms are fitted, then the
//! catalogue's best name, and the best pair where the second name pays; what is left, in true standard deviations, is
//! what a matched filter would see that knew the pattern to the last draw. Below 4 σ no diagnosis can call it
//! unexplained without calling noise so. Beside it stands how often two observers who know the law of the kind, but
//! none of its draws, would see that rest in noise at 1.5 % of false alarms: one compares with further draws, the other
//! with their covariance. The truth lies between: laws of many draws need more than a few hundred of them.

use std::io::Write as _;

use camino::Utf8PathBuf;
use isolux_diagnose::assumed::AssumedModel;
use isolux_diagnose::basis::{Basis, inverse_of_normal};
use isolux_diagnose::dictionary::Dictionary;
use isolux_diagnose::fit::{Fit, fit, nuisance_tangents};
use isolux_diagnose::forward::{Forward as _, Hypothesis};
use isolux_diagnose::observe::observed;
use isolux_diagnose::reference::Errors;
use isolux_diagnose::rounding::Rounding;
use isolux_diagnose::scan::Who;
use isolux_diagnose::whitener::Whitener;
use isolux_diagnose::whitening::Sequence;
use isolux_hidden_effects::case::{self, Case, Order};
use isolux_hidden_effects::random::Draws;
use isolux_hidden_effects::suite::{self, Class};
use isolux_model::Model;
use isolux_record::observation::{Need, open};
use nalgebra::{DMatrix, DVector, SymmetricEigen};
use rayon::prelude::*;

/// Below this rest nobody can tell the unknown from the names, in σ.
const DECIDABLE_SIGMA: f64 = 4.0;
/// What a second name must explain more than the first alone, in σ²: the search's own 8 + 2 ln 22.
const PAIR_GAIN: f64 = 14.0;
/// Names and shapes whose full fits are made: the best of the tangents.
const FITTED: usize = 8;
const FURTHER_DRAWS: u64 = 1500;
const NULLS: u64 = 1000;
const TRIALS: u64 = 200;
const FALSE_ALARMS: f64 = 0.015;

/// What names leave of a case without noise.
struct Rest {
    names: Vec<&'static str>,
    residual: DVector<f64>,
    /// The refitted terms alone.
    refitted: Basis,
    /// Directions that are free beside it: refitted terms, amplitudes and shapes of the names.
    free: Basis,
}

fn main() {
    let words: Vec<String> = std::env::args()
        .skip(1)
        .filter(|word| !word.starts_with("--"))
        .collect();
    let kinds = words.first().map_or("Second", String::as_str);
    let count: u64 = words.get(1).and_then(|word| word.parse().ok()).unwrap_or(24);
    let seed: u64 = words.get(2).and_then(|word| word.parse().ok()).unwrap_or(20_261);
    let class = |sigma: u32| match kinds {
        "Outside" => Class::Outside(sigma),
        "Fresh" => Class::Fresh(sigma),
        "Later" => Class::Later(sigma),
        "Third" => Class::Third(sigma),
        "Fourth" => Class::Fourth(sigma),
        "Unforeseen" => Class::Unforeseen(sigma),
        _ => Class::Second(sigma),
    };
    for class in [10, 30].map(class) {
        let lines: Vec<(f64, f64)> = suite::orders(class, false, count, seed)
            .par_iter()
            .filter_map(|order| {
                let case = case::make(order)?;
                let rest = rest(&case)?;
                let left = rest.residual.norm();
                let [drawn, alike] = seen_by_law(order, &rest)?;
                say(&format!(
                    "{class:?} seed {} {:<22} left {left:5.1} σ beside {:?}; seen from its law {:.0} %, from its covariance {:.0} %",
                    order.seed, order.hidden[0].0, rest.names, 100.0 * drawn, 100.0 * alike
                ));
                Some((left, drawn.max(alike)))
            })
            .collect();
        let decidable = lines.iter().filter(|(left, _)| *left >= DECIDABLE_SIGMA).count();
        let seen: f64 = lines.iter().map(|(_, seen)| seen).sum();
        say(&format!(
            "{class:?}: {decidable} of {} are decidable; who knows the law sees {seen:.1}",
            lines.len()
        ));
    }
}

fn say(text: &str) {
    let _ = writeln!(std::io::stdout().lock(), "{text}");
}

/// What the refitted terms and the best name or pair of names leave of a case without noise.
fn rest(case: &Case) -> Option<Rest> {
    let folder = tempfile::tempdir().ok()?;
    let path = Utf8PathBuf::try_from(folder.path().to_owned()).ok()?;
    case.write(folder.path()).ok()?;
    std::fs::write(path.join("readings.csv"), &case.noise_free).ok()?;
    let model = Model::load(&path.join("model.toml")).ok()?;
    let (of_file, _) = observed(&open(&path.join("readings.csv"), Need::Values).ok()?, 0);
    let rows = of_file.rows;
    let forward = AssumedModel::new(model, vec![of_file.part]);
    let measured = DVector::from_iterator(rows.len(), rows.iter().map(|row| row.measured));
    let sequence = Sequence::by_time(
        &vec![0; rows.len()],
        &rows.iter().map(|row| row.time_s).collect::<Vec<_>>(),
    );
    let alone = Rounding::default();
    let row_scale = DVector::from_iterator(rows.len(), rows.iter().map(|row| 1.0 / row.u));
    let whitener = Whitener::new(&sequence, &alone, row_scale, 0.0, &Errors::new());
    let start = vec![0.0; forward.nuisances()];
    let first = fit(
        &forward,
        &measured,
        &whitener,
        &start,
        &nuisance_tangents(&forward, &start)?,
        &[],
    )?;
    let tangents = nuisance_tangents(&forward, &first.nuisance)?;
    let plain = fit(&forward, &measured, &whitener, &first.nuisance, &tangents, &[])?;
    let level = forward.predict(&plain.nuisance, &[])?;
    let dictionary = Dictionary::new(
        &forward,
        &rows,
        &plain.nuisance,
        (&level, &level),
        &mut [],
        &whitener.row_scale,
        &tangents,
    );

    // One more name beside those of a fit: the best full fits of what the tangents propose.
    let more = |base: &Fit, most: usize| -> Vec<Fit> {
        let free = Basis::spanning(&base.jacobian, 1e-9);
        let mut proposed: Vec<(f64, Hypothesis)> = Vec::new();
        for candidate in &dictionary.candidates {
            let Who::Named { effect, shape } = candidate.who else {
                continue;
            };
            if base.hypotheses.iter().any(|member| member.effect == effect) {
                continue;
            }
            let mut columns = dictionary.columns(&candidate.columns.clone().collect::<Vec<_>>());
            whitener.apply(&mut columns);
            free.project_out(&mut columns);
            let along = columns.tr_mul(&base.residual);
            let amplitudes = inverse_of_normal(&columns.tr_mul(&columns), 1e-14) * &along;
            let searchable = &forward.effects()[effect];
            let mut linear: Vec<f64> = amplitudes
                .iter()
                .zip(&searchable.limits)
                .map(|(a, (low, high))| a.clamp(*low, *high))
                .collect();
            if searchable.never_negative {
                linear[0] = linear[0].max(0.05 * searchable.step_of(shape, 0));
            }
            let shape = searchable.shapes[shape].clone();
            proposed.push((amplitudes.dot(&along), Hypothesis { effect, linear, shape }));
        }
        proposed.sort_by(|a, b| b.0.total_cmp(&a.0));
        // Of each effect the best three shapes, so that one of many shapes does not fill the list.
        let mut taken = vec![0; forward.effects().len()];
        proposed.retain(|(_, hypothesis)| {
            taken[hypothesis.effect] += 1;
            taken[hypothesis.effect] <= 3
        });
        proposed.truncate(most);
        let fitted = |(_, hypothesis): &(f64, Hypothesis)| {
            let members = [base.hypotheses.as_slice(), std::slice::from_ref(hypothesis)].concat();
            fit(&forward, &measured, &whitener, &base.nuisance, &tangents, &members)
        };
        let possible = |fitted: &Fit| {
            fitted.hypotheses.iter().all(|member| {
                let searchable = &forward.effects()[member.effect];
                (!searchable.one_sided || member.linear[0] >= 0.0) && searchable.implausibility(&member.linear) < 1.0
            })
        };
        let mut fits: Vec<Fit> = proposed.iter().filter_map(fitted).filter(possible).collect();
        fits.sort_by(|a, b| a.chi2.total_cmp(&b.chi2));
        fits
    };
    let mut best = plain.clone();
    let singles = more(&plain, 2 * FITTED);
    if let Some(one) = singles.first() {
        best = one.clone();
    }
    let pairs = singles.iter().take(FITTED / 2).flat_map(|one| more(one, FITTED));
    if let Some(two) = pairs.min_by(|a, b| a.chi2.total_cmp(&b.chi2))
        && two.chi2 + PAIR_GAIN < best.chi2
    {
        best = two;
    }
    let free = Basis::spanning(&best.jacobian, 1e-9);
    let mut residual = best.residual.clone();
    free.project_out_vector(&mut residual);
    let names = best.hypotheses.iter().map(|member| forward.spec(member.effect).name);
    Some(Rest {
        names: names.collect(),
        residual,
        refitted: Basis::spanning(&plain.jacobian, 1e-9),
        free,
    })
}

/// How often the rest is seen in white noise of unknown scale: by comparison with further draws, and with their
/// covariance.
fn seen_by_law(order: &Order, rest: &Rest) -> Option<[f64; 2]> {
    let size = order.hidden[0].1;
    let n = rest.residual.len();
    let draws = case::further_draws(order, FURTHER_DRAWS)?;
    let mut patterns = DMatrix::from_fn(n, draws.len(), |i, k| draws[k][i]);
    // As strong as what is hidden, before the names take their part.
    let mut whole = patterns.clone();
    rest.refitted.project_out(&mut whole);
    rest.free.project_out(&mut patterns);
    for (mut pattern, whole) in patterns.column_iter_mut().zip(whole.column_iter()) {
        let length = whole.norm();
        pattern.scale_mut(if length > 0.0 { size / length } else { 0.0 });
    }
    let squares: Vec<f64> = patterns.column_iter().map(|pattern| pattern.norm_squared()).collect();
    let covariance = &patterns * patterns.transpose() / draws.len() as f64;
    let eigen = SymmetricEigen::new(covariance);
    let shares = eigen.eigenvalues.map(|value| value.max(0.0) / (1.0 + value.max(0.0)));
    let look = |stream: u64, rest_of: Option<&DVector<f64>>| -> [f64; 2] {
        let mut draws = Draws::new(order.seed, stream);
        let mut values = DVector::from_fn(n, |_, _| draws.normal());
        rest.free.project_out_vector(&mut values);
        if let Some(residual) = rest_of {
            values += residual;
        }
        values *= ((n - rest.free.rank()) as f64).sqrt() / values.norm();
        let along = patterns.tr_mul(&values);
        let terms: Vec<f64> = along
            .iter()
            .zip(&squares)
            .map(|(along, square)| along.abs() - 0.5 * square)
            .collect();
        let most = terms.iter().copied().fold(f64::NEG_INFINITY, f64::max);
        let drawn = most + terms.iter().map(|term| (term - most).exp()).sum::<f64>().ln();
        let parts = eigen.eigenvectors.tr_mul(&values);
        let alike = parts
            .iter()
            .zip(shares.iter())
            .map(|(part, share)| part * part * share)
            .sum();
        [drawn, alike]
    };
    let nulls: Vec<[f64; 2]> = (0..NULLS).map(|k| look(10_000 + k, None)).collect();
    let trials: Vec<[f64; 2]> = (0..TRIALS).map(|k| look(50_000 + k, Some(&rest.residual))).collect();
    Some([0, 1].map(|way| {
        let mut of_noise: Vec<f64> = nulls.iter().map(|look| look[way]).collect();
        of_noise.sort_by(|a, b| b.total_cmp(a));
        let limit = of_noise[(FALSE_ALARMS * NULLS as f64) as usize];
        trials.iter().filter(|look| look[way] > limit).count() as f64 / TRIALS as f64
    }))
}
