//! What a suite's answers add up to: who was taken for whom, and whether claimed probabilities are kept.

use std::collections::BTreeMap;
use std::fmt::Write as _;

use crate::case::Order;
use crate::suite::{Answer, share, wilson};

/// Who was hidden and what was said, single effects alone.
#[derive(Debug, Default)]
pub struct Confusion {
    stated: BTreeMap<String, BTreeMap<String, usize>>,
}

impl Confusion {
    /// Counts one answer.
    pub fn add(&mut self, order: &Order, answer: &Answer) {
        let Some((truth, _)) = order.hidden.first() else { return };
        let stated = match answer.verdict.as_str() {
            "consistent" | "unexplained" => answer.verdict.clone(),
            _ => answer.effects[0].0.clone(),
        };
        *self
            .stated
            .entry((*truth).to_owned())
            .or_default()
            .entry(stated)
            .or_default() += 1;
    }

    /// One line a hidden effect: how often it was said itself, and what was said else.
    pub fn markdown(&self) -> String {
        let mut text = String::from("| hidden | cases | said itself | said else |\n|---|---|---|---|\n");
        for (truth, stated) in &self.stated {
            let all: usize = stated.values().sum();
            let mut others: Vec<(&String, &usize)> = stated.iter().filter(|(name, _)| *name != truth).collect();
            others.sort_by(|a, b| b.1.cmp(a.1));
            let others: Vec<String> = others.iter().map(|(name, n)| format!("{name} {n}")).collect();
            let own = stated.get(truth).copied().unwrap_or(0);
            let _ = writeln!(text, "| {truth} | {all} | {own} | {} |", others.join(", "));
        }
        text
    }
}

/// What each test on noise and each pattern without a name is worth.
#[derive(Debug, Default)]
pub struct Worth {
    /// Cases in which it finds something, in which it is the strongest, in which it is the only one; and the last with
    /// nothing hidden.
    finders: BTreeMap<String, [usize; 4]>,
}

impl Worth {
    /// Counts one answer.
    pub fn add(&mut self, order: &Order, answer: &Answer) {
        let clean = order.hidden.is_empty();
        let only = answer.tests.len() == 1;
        for (rank, test) in answer.tests.iter().enumerate() {
            let row = self.finders.entry(format!("test {test}")).or_default();
            if clean {
                row[3] += usize::from(only);
            } else {
                row[0] += 1;
                row[1] += usize::from(rank == 0);
                row[2] += usize::from(only);
            }
        }
        // What a test finds is a place of its own: a pattern counts where no test finds anything.
        if let (Some(place), true) = (&answer.place, answer.tests.is_empty()) {
            let pattern: String = place.chars().filter(|letter| !letter.is_ascii_digit()).collect();
            let row = self.finders.entry(format!("pattern {pattern}")).or_default();
            if clean {
                row[3] += 1;
            } else {
                (row[0], row[1], row[2]) = (row[0] + 1, row[1] + 1, row[2] + 1);
            }
        }
    }

    /// One line a test or a pattern.
    pub fn markdown(&self) -> String {
        let mut text =
            String::from("| what | finds | strongest | alone | alone, nothing hidden |\n|---|---|---|---|---|\n");
        for (name, [finds, strongest, alone, clean]) in &self.finders {
            let _ = writeln!(text, "| {name} | {finds} | {strongest} | {alone} | {clean} |");
        }
        text
    }
}

/// Lower ends of the bins of claimed probability.
const BINS: [f64; 8] = [0.0, 0.2, 0.4, 0.6, 0.8, 0.95, 0.99, 0.999];

/// Claimed probabilities of first names, and how many were right.
#[derive(Debug, Default)]
pub struct Calibration {
    /// Sum of claims, right, claims of each bin.
    bins: [(f64, usize, usize); BINS.len()],
}

impl Calibration {
    /// Counts every named effect of an answer.
    pub fn add(&mut self, order: &Order, answer: &Answer) {
        for (name, _, posterior) in &answer.effects {
            let place = BINS.iter().rposition(|low| posterior >= low).unwrap_or(0);
            let bin = &mut self.bins[place];
            bin.0 += posterior;
            bin.1 += usize::from(order.hidden.iter().any(|(truth, _)| truth == name));
            bin.2 += 1;
        }
    }

    fn rows(&self) -> impl Iterator<Item = (f64, f64, f64, usize, usize)> {
        self.bins
            .iter()
            .enumerate()
            .filter(|(_, bin)| bin.2 > 0)
            .map(|(k, &(sum, right, n))| {
                let high = BINS.get(k + 1).copied().unwrap_or(1.0);
                (BINS[k], high, sum / n as f64, right, n)
            })
    }

    /// One line a bin.
    pub fn markdown(&self) -> String {
        let mut text = String::from("| claimed | mean claim | right |\n|---|---|---|\n");
        for (low, high, mean, right, n) in self.rows() {
            let _ = writeln!(text, "| {low}–{high} | {mean:.3} | {} |", share(right, n).trim());
        }
        text
    }

    /// The reliability diagram: share of right claims over the mean claim, with Wilson's 95 % intervals.
    pub fn svg(&self) -> String {
        let (left, top, size) = (64.0, 24.0, 320.0);
        let x = |p: f64| left + p * size;
        let y = |p: f64| top + (1.0 - p) * size;
        let mut svg = String::from(
            "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 420 400\" font-family=\"sans-serif\" font-size=\"12\">\n\
             <rect width=\"420\" height=\"400\" fill=\"#ffffff\"/>\n",
        );
        for k in 0..=5 {
            let p = 0.2 * f64::from(k);
            let _ = writeln!(
                svg,
                "<path d=\"M{:.1} {:.1}H{:.1}M{:.1} {:.1}V{:.1}\" stroke=\"#dddddd\"/>",
                x(0.0),
                y(p),
                x(1.0),
                x(p),
                y(0.0),
                y(1.0)
            );
            let _ = writeln!(
                svg,
                "<text x=\"{:.1}\" y=\"{:.1}\" text-anchor=\"end\">{p:.1}</text><text x=\"{:.1}\" y=\"{:.1}\" text-anchor=\"middle\">{p:.1}</text>",
                x(0.0) - 8.0,
                y(p) + 4.0,
                x(p),
                y(0.0) + 18.0
            );
        }
        let _ = writeln!(
            svg,
            "<path d=\"M{:.1} {:.1}L{:.1} {:.1}\" stroke=\"#888888\" stroke-dasharray=\"5 4\"/>",
            x(0.0),
            y(0.0),
            x(1.0),
            y(1.0)
        );
        for (_, _, mean, right, n) in self.rows() {
            let [low, high] = wilson(right, n);
            let p = right as f64 / n as f64;
            let _ = writeln!(
                svg,
                "<path d=\"M{0:.1} {1:.1}V{2:.1}\" stroke=\"#1f5fa8\" stroke-width=\"2\"/><circle cx=\"{0:.1}\" cy=\"{3:.1}\" r=\"4\" fill=\"#1f5fa8\"/>",
                x(mean),
                y(low),
                y(high),
                y(p)
            );
            let beside = if mean > 0.9 { (-8.0, "end") } else { (8.0, "start") };
            if !(0.9..=0.9995).contains(&mean) {
                let _ = writeln!(
                    svg,
                    "<text x=\"{:.1}\" y=\"{:.1}\" text-anchor=\"{}\" fill=\"#444444\">{n}</text>",
                    x(mean) + beside.0,
                    // Under its point, but never on the axis' numbers.
                    y(p) + if p < 0.06 { -8.0 } else { 14.0 },
                    beside.1
                );
            }
        }
        let _ = writeln!(
            svg,
            "<text x=\"{:.1}\" y=\"{:.1}\" text-anchor=\"middle\">claimed probability of the name</text>",
            x(0.5),
            y(0.0) + 38.0
        );
        let _ = writeln!(
            svg,
            "<text transform=\"translate(18 {:.1}) rotate(-90)\" text-anchor=\"middle\">share of right names</text>\n</svg>",
            y(0.5)
        );
        svg
    }
}
