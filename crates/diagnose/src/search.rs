//! From residuals to a set of effects: baseline, scan, forward steps, pairs, swaps, and the rivals of each.

use nalgebra::DVector;

use crate::evidence::ln_sum_exp;
use crate::forward::{Forward, Hypothesis};
use crate::noise::{NoiseTest, noisy_rho};
use crate::rivals::Rival;
use crate::rounding::hides_noise;
use crate::scan::{Found, p_value};
use crate::shrinkage::weights;
use crate::table::{Row, Source};
use crate::whitening::Sequence;

mod bench;
mod grow;
mod nameless;
mod outcome;
mod places;
mod rivalry;

pub use outcome::{Label, Noise, Outcome, Place, Ranked, Rivalry, Unexplained};

use bench::Bench;
use rivalry::Change;

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

/// Searches. None where the model cannot even predict these rows.
pub fn search<F: Forward + ?Sized>(forward: &F, rows: &[Row], settings: &Settings) -> Option<Outcome> {
    let sequence = in_time(rows);
    let mut bench = Bench::new(forward, rows, &sequence, settings)?;
    let baseline = bench.baseline.clone();
    let scan = bench.scan(&baseline, &[], None);
    let first = scan.look();
    let whitened = |numbers: &[usize]| bench.whitened(numbers);
    let nulls = scan.nulls(&whitened, settings.nulls, settings.seed, &sequence, &bench.noise);
    bench.nulls = nulls;
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
    let mut noise_test = bench.noise_test(&current);
    // A name that leaves nothing but noise stays: a period or a patch of the same readings could always explain a
    // little more.
    if noise_test.as_ref().is_some_and(NoiseTest::disagrees) {
        let (fewer, without) = bench.no_places(members.clone(), &current)?;
        if fewer.len() < members.len() {
            (members, current) = (fewer, without);
            noise_test = bench.noise_test(&current);
        }
    }
    if let Some(left) = noise_test
        .as_ref()
        .filter(|test| test.disagrees())
        .map(NoiseTest::explained)
        && !members.is_empty()
    {
        let explained: Vec<f64> = (0..members.len())
            .map(|i| bench.explained_by(&members, &current, i))
            .collect();
        let strongest = explained.iter().copied().fold(0.0, f64::max);
        if left <= settings.second_share.powi(2) * strongest {
            // As small as what the formula of a name may leave.
            noise_test = noise_test.map(NoiseTest::without_findings);
        } else if explained.iter().any(|own| *own <= BESIDE_SHARE * left) {
            // What is no noise and has no name may be all there is, too.
            let mut explained = explained.into_iter();
            members.retain(|_| explained.next().is_none_or(|own| own > BESIDE_SHARE * left));
            current = bench.fit(&members)?;
            noise_test = bench.noise_test(&current);
            if unexplained.is_some() {
                unexplained = bench.strongest_rival(&current, &members);
            }
        }
    }
    let all = |members: &[Hypothesis]| {
        let of = |i: usize| bench.rivalry(members, i, unexplained);
        (0..members.len()).map(of).collect::<Option<Vec<_>>>()
    };
    let mut rivalries = all(&members)?;
    // Of two names that are hardly apart the last refit may have put the other first, and left a weak one nothing to
    // make.
    let before = members.clone();
    for (i, rivalry) in rivalries.iter().enumerate() {
        if let Some(better) = better_name(&members, i, rivalry) {
            members[i] = better;
        }
    }
    if !rivalries.iter().all(nothing_is_likelier) {
        let mut nothing = rivalries.iter().map(nothing_is_likelier);
        members.retain(|_| !nothing.next().unwrap_or(false));
    }
    if members != before {
        current = bench.fit(&members)?;
        members.clone_from(&current.hypotheses);
        rivalries = all(&members)?;
    }
    let unexplained = unexplained
        .map(|(candidate, explained)| bench.unexplained(&current, candidate, explained))
        .or_else(|| noise_test.as_ref().and_then(|test| no_noise(test, rows.len())));
    let mut noise = bench.noise.clone();
    if let Some(test) = noise_test.as_ref().filter(|test| test.disagrees()) {
        // What is no noise makes none larger.
        noise.scale = noise.scale.min(test.limit);
        noise.rho = noisy_rho(noise.rho);
    }
    let held = weights(forward, &current, noise.scale);
    let baseline = bench.fit_held(&[], &held)?;
    let current = bench.fit_held(&members, &held)?;
    Some(Outcome {
        baseline,
        after: current,
        noise,
        rounding: bench.rounding,
        errors: bench.errors,
        p_global,
        rivalries,
        unexplained,
        places,
        visibility,
        noise_test,
        held,
        nulls: settings.nulls,
        sequence: sequence.clone(),
    })
}

/// The rows in time. Those that show no noise say nothing of its serial correlation: twenty dark readings of one digit
/// are one rounding.
fn in_time(rows: &[Row]) -> Sequence {
    let run: Vec<usize> = rows.iter().map(|row| row.file).collect();
    let ordered = |row: &Row| match row.source {
        Source::Reading if !hides_noise(row) => row.time_s,
        _ => f64::NAN,
    };
    let time: Vec<f64> = rows.iter().map(ordered).collect();
    Sequence::by_time(&run, &time)
}

/// What a test of the noise found, as structure without a name.
fn no_noise(test: &NoiseTest, rows: usize) -> Option<Unexplained> {
    let first = test.findings.first()?;
    Some(Unexplained {
        rival: Rival {
            coordinate: first.coordinate,
            family: "noise",
            range: first.range,
            note: test.note(),
            columns: Vec::new(),
        },
        sigma: test.explained().sqrt(),
        pattern: DVector::zeros(rows),
    })
}

/// The hypothesis of another name that is more probable than member `i`'s, and no member itself.
fn better_name(members: &[Hypothesis], i: usize, rivalry: &Rivalry) -> Option<Hypothesis> {
    let top = rivalry.ranked.first()?;
    let is_new = |effect: usize| members.iter().all(|member| member.effect != effect);
    match top.label {
        Label::Named(effect) if effect != members[i].effect && is_new(effect) => top.hypothesis.clone(),
        _ => None,
    }
}

/// Whether nothing at all is more probable than any name or pattern.
fn nothing_is_likelier(rivalry: &Rivalry) -> bool {
    let all: f64 = rivalry.ranked.iter().map(|ranked| ranked.posterior).sum();
    rivalry.ranked.first().is_none_or(|top| 1.0 - all > top.posterior)
}

/// A name beside a pattern without one must explain this many times what the pattern explains: a generic pattern is but
/// a likeness of the unknown, and what it misses looks like anything.
const BESIDE_SHARE: f64 = 2.0;

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn readings_that_show_their_digit_alone_are_no_neighbours_in_time() {
        let neighbours = |digit: f64| {
            let row = |i: i32| Row {
                digit,
                time_s: f64::from(i),
                ..Row::bare(Source::Reading, 0.01, 0.003)
            };
            in_time(&(0..20).map(row).collect::<Vec<_>>()).has_neighbours()
        };
        // u = 0.003: digit/√12 = 0.0029 and a scatter of 0.0008, or digit/√12 = 0.0014 and a scatter of 0.0026.
        assert!(!neighbours(0.01) && neighbours(0.005) && neighbours(0.0));
    }
}
