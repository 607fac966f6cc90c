//! The suites: which effects, at which significance, in which noise; and how an answer is judged.

use std::fmt::Write as _;

use crate::case::Order;
use crate::plan::Plan;
use crate::random::Draws;
use crate::{no_noise, outside, recipe, unforeseen};

/// A class of cases with a goal of its own.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Class {
    /// Nothing hidden, white noise.
    CleanWhite,
    /// Nothing hidden, AR(1) noise with ρ = 0.5.
    CleanCorrelated,
    /// Nothing hidden, outliers.
    CleanOutliers,
    /// One effect of the catalogue at this significance (σ).
    Single(u32),
    /// Two effects of the catalogue, 20 σ each.
    Pair,
    /// An effect that no catalogue has, at this significance.
    Outside(u32),
    /// An error that looks like noise, at this significance: the kinds with which the test was developed.
    Developed(u32),
    /// The same: kinds that were drawn after the first form of the test was finished.
    Fresh(u32),
    /// The same: kinds that were drawn after its present form was finished.
    Later(u32),
    /// The same: disturbances that were written down after the test was finished.
    Unforeseen(u32),
    /// The same, drawn after those had been measured.
    Second(u32),
    /// The same, drawn after those of both lists had been measured.
    Third(u32),
    /// The same, drawn after those of three lists had been measured.
    Fourth(u32),
    /// One effect at 20 σ on a common plan: the right answer is a set that holds it.
    Common,
}

/// What the answer said, in the few words that the goals need.
#[derive(Debug, Clone, Default)]
pub struct Answer {
    /// "consistent", "named", "ambiguous" or "unexplained".
    pub verdict: String,
    /// Name, equivalents, posterior of every effect.
    pub effects: Vec<(String, Vec<String>, f64)>,
    /// Where something stays unexplained, in words.
    pub place: Option<String>,
    /// Tests on noise that find what is left to be none, each alone, strongest first.
    pub tests: Vec<String>,
    /// Share of the gap on held-out truth that was removed, where an effect was added: 1 is what the refitted terms
    /// alone leave in the same noise with nothing hidden.
    pub removed: Option<f64>,
    /// The same share, 1 being no deviation at all.
    pub removed_of_all: Option<f64>,
    /// The same share that a fit could remove at best: one that knows the form of what is hidden and how the model's
    /// own errors are drawn.
    pub removable: Option<f64>,
    /// Deviation on held-out truth, rms in true σ: of the baseline, and with the effects.
    pub deviation: Option<(f64, f64)>,
    /// What came of the measurement that was suggested, where the answer was ambiguous and one effect hidden.
    pub next: Option<Next>,
    /// Probabilities of the scan and of what is left under noise alone; scale and correlation of the noise. Not a
    /// number where there is none.
    pub noise: [f64; 4],
    /// Seconds.
    pub seconds: f64,
    /// The first rows of each effect's ranked table: name, posterior, σ, ln evidence.
    pub ranked: Vec<Vec<(String, f64, f64, f64)>>,
}

/// What came of a suggested measurement.
#[derive(Debug, Clone)]
pub struct Next {
    /// What was suggested; none where nothing of 3 σ or more was.
    pub suggested: Option<(String, f64)>,
    /// Verdict, first name and its equivalents of old and new data together.
    pub verdict: String,
    /// Whether they single out what was hidden.
    pub settled: bool,
}

/// `count` orders of a class.
pub fn orders(class: Class, sensor: bool, count: u64, seed: u64) -> Vec<Order> {
    let list = if sensor { recipe::SENSOR } else { recipe::GONIO };
    let strange = if sensor { outside::SENSOR } else { outside::GONIO };
    (0..count)
        .map(|k| {
            let mut draws = Draws::new(seed.wrapping_mul(1_000_003).wrapping_add(k), 77);
            let mut order = Order {
                sensor,
                plan: Plan::Designed,
                hidden: Vec::new(),
                rho: 0.0,
                outliers: 0.0,
                seed: seed.wrapping_mul(7919).wrapping_add(k),
            };
            let name = list[(k as usize) % list.len()].name;
            match class {
                Class::CleanWhite => {}
                Class::CleanCorrelated => order.rho = 0.5,
                Class::CleanOutliers => order.outliers = 0.02,
                Class::Single(sigma) => order.hidden = vec![(name, f64::from(sigma))],
                Class::Pair => {
                    let mut other = name;
                    while other == name {
                        other = draws.pick(list).name;
                    }
                    order.hidden = vec![(name, 20.0), (other, 20.0)];
                }
                Class::Outside(sigma) => order.hidden = vec![(strange[(k as usize) % strange.len()], f64::from(sigma))],
                Class::Developed(sigma) => {
                    let kinds = no_noise::DEVELOPED;
                    order.hidden = vec![(kinds[(k as usize) % kinds.len()], f64::from(sigma))];
                }
                Class::Fresh(sigma) => {
                    let kinds = no_noise::FRESH;
                    order.hidden = vec![(kinds[(k as usize) % kinds.len()], f64::from(sigma))];
                }
                Class::Later(sigma) => {
                    let kinds = no_noise::LATER;
                    order.hidden = vec![(kinds[(k as usize) % kinds.len()], f64::from(sigma))];
                }
                Class::Unforeseen(sigma) => {
                    let kinds = unforeseen::FIRST;
                    order.hidden = vec![(kinds[(k as usize) % kinds.len()], f64::from(sigma))];
                }
                Class::Second(sigma) => {
                    let kinds = unforeseen::SECOND;
                    order.hidden = vec![(kinds[(k as usize) % kinds.len()], f64::from(sigma))];
                }
                Class::Third(sigma) => {
                    let kinds = unforeseen::THIRD;
                    order.hidden = vec![(kinds[(k as usize) % kinds.len()], f64::from(sigma))];
                }
                Class::Fourth(sigma) => {
                    let kinds = unforeseen::FOURTH;
                    order.hidden = vec![(kinds[(k as usize) % kinds.len()], f64::from(sigma))];
                }
                Class::Common => {
                    order.plan = Plan::Common;
                    order.hidden = vec![(name, 20.0)];
                }
            }
            order
        })
        .collect()
}

/// Score of one answer: name of the goal and whether it was met.
pub fn judge(class: Class, order: &Order, answer: &Answer) -> Vec<(&'static str, bool)> {
    let truth: Vec<&str> = order.hidden.iter().map(|(name, _)| *name).collect();
    let named: Vec<&str> = answer.effects.iter().map(|(name, ..)| name.as_str()).collect();
    let in_set = |name: &str| {
        answer
            .effects
            .iter()
            .any(|(n, equivalents, _)| n == name || equivalents.iter().any(|e| e == name))
    };
    let sure_and_wrong = answer
        .effects
        .iter()
        .any(|(name, _, posterior)| *posterior > 0.95 && !truth.contains(&name.as_str()));
    let mut scores = Vec::new();
    match class {
        Class::CleanWhite | Class::CleanCorrelated | Class::CleanOutliers => {
            scores.push(("false alarm", answer.verdict != "consistent"));
        }
        Class::Single(sigma) => {
            scores.push(("detected", answer.verdict != "consistent"));
            scores.push((
                "exact name",
                named.first() == truth.first() && answer.verdict != "unexplained",
            ));
            scores.push(("only that name", named == truth && answer.verdict != "unexplained"));
            if sigma >= 5 {
                scores.push(("true effect in the set", in_set(truth[0])));
            }
        }
        Class::Pair => {
            scores.push((
                "both named",
                truth.iter().all(|name| named.contains(name)) && named.len() == 2,
            ));
            scores.push(("both in the sets", truth.iter().all(|name| in_set(name))));
        }
        Class::Outside(_)
        | Class::Developed(_)
        | Class::Fresh(_)
        | Class::Later(_)
        | Class::Unforeseen(_)
        | Class::Second(_)
        | Class::Third(_)
        | Class::Fourth(_) => {
            scores.push(("called unexplained", answer.verdict == "unexplained"));
        }
        Class::Common => scores.push((
            "set holds it, or silence",
            in_set(truth[0]) || answer.verdict == "consistent",
        )),
    }
    if let Some(next) = &answer.next {
        scores.push(("ambiguity has a suggestion of 3 σ", next.suggested.is_some()));
        if next.suggested.is_some() {
            scores.push(("suggestion settles it", next.settled));
        }
    }
    scores.push(("claimed > 95 % sure, but wrong", sure_and_wrong));
    scores
}

/// Wilson's 95 % interval of `hits` among `n`.
pub fn wilson(hits: usize, n: usize) -> [f64; 2] {
    if n == 0 {
        return [0.0, 1.0];
    }
    let (z, n, p) = (1.96_f64, n as f64, hits as f64 / n as f64);
    let centre = (p + z * z / (2.0 * n)) / (1.0 + z * z / n);
    let half = z / (1.0 + z * z / n) * (p * (1.0 - p) / n + z * z / (4.0 * n * n)).sqrt();
    [(centre - half).max(0.0), (centre + half).min(1.0)]
}

/// `hits/n = p % [low, high]`, for a table.
pub fn share(hits: usize, n: usize) -> String {
    let [low, high] = wilson(hits, n);
    let mut text = String::new();
    let _ = write!(
        text,
        "{:5.1} %  [{:.1}, {:.1}]  ({hits}/{n})",
        100.0 * hits as f64 / n.max(1) as f64,
        100.0 * low,
        100.0 * high
    );
    text
}
