//! What to measure next: the block of readings or maps in which two alternatives of one set differ most (T-optimality).

mod block;
mod maps;
mod noise;
mod readings;
mod separation;

use crate::assumed::{AssumedModel, Part};
use crate::calibration::{DECISIVE_SIGMA, MOST_REPEATS, MOST_SUGGESTIONS, SET, WORTH_NAMING_SIGMA};
use crate::document::NextEntry;
use crate::forward::Hypothesis;
use crate::search::{Label, Outcome};
use crate::table::{ObservationKind, Row};

pub use block::Next;

use block::Block;
use maps::map_blocks;
use readings::reading_blocks;
use separation::{refitted_separation, separation};

/// Where what is left is no noise, the measurement that would show its cause; and for the first effect whose set holds
/// more than one name those that would tell its two most probable apart.
pub fn suggest(assumed: &AssumedModel, outcome: &Outcome, rows: &[Row]) -> Next {
    let mut next = Next::default();
    if let Some(test) = outcome.noise_test.as_ref().filter(|test| test.disagrees()) {
        noise::suggest(&mut next, test, rows);
    }
    let Some((number, pair)) = alternatives_of(outcome) else {
        return next;
    };
    let name = |hypothesis: &Hypothesis| assumed.spec(hypothesis.effect).name.to_owned();
    let splits = [name(&pair[0]), name(&pair[1])];
    let others: Vec<Hypothesis> = outcome
        .after
        .hypotheses
        .iter()
        .enumerate()
        .filter(|(i, _)| *i != number)
        .map(|(_, member)| member.clone())
        .collect();
    let of_readings = rows.iter().all(|row| row.source == ObservationKind::Reading);
    let with_repeats = |repeats: usize| {
        let mut entries: Vec<(NextEntry, Block)> = blocks(assumed, outcome, rows, repeats)
            .into_iter()
            .filter_map(|block| {
                let expected_sigma = separation(assumed, outcome, rows, &block, &others, &pair)?;
                let entry = NextEntry {
                    what: block.what.into(),
                    splits: splits.clone(),
                    plan: None,
                    expected_sigma,
                    minutes: block.minutes,
                };
                Some((entry, block))
            })
            .collect();
        entries.sort_by(|a, b| b.0.expected_sigma.total_cmp(&a.0.expected_sigma));
        entries.truncate(MOST_SUGGESTIONS);
        // A shape may go far from where its tangent leads: what counts is how far apart the two stay when refitted in
        // full. Refits of maps take too long for that.
        for (entry, block) in entries.iter_mut().filter(|_| of_readings) {
            let refitted = refitted_separation(assumed, outcome, rows, block, &others, &pair);
            entry.expected_sigma = refitted.unwrap_or(0.0).min(entry.expected_sigma);
        }
        entries.sort_by(|a, b| b.0.expected_sigma.total_cmp(&a.0.expected_sigma));
        entries
    };
    let mut entries = with_repeats(1);
    // Names that one scan hardly parts want as many readings of it as will, while that is an evening's work.
    let best = entries.first().map_or(0.0, |(entry, _)| entry.expected_sigma);
    if of_readings && best > 0.0 && best < DECISIVE_SIGMA {
        let wanted = (DECISIVE_SIGMA / best).powi(2).ceil() as usize;
        entries = with_repeats(wanted.min(MOST_REPEATS));
    }
    let (worth, vain): (Vec<_>, Vec<_>) = entries
        .into_iter()
        .partition(|(entry, _)| entry.expected_sigma >= WORTH_NAMING_SIGMA);
    if let (true, Some((best, _))) = (worth.is_empty(), vain.first()) {
        let [one, other] = &splits;
        next.note = Some(format!(
            "no block of measurements known here would tell {one} and {other} apart: the best, {}, would set them {:.1} σ apart",
            best.what, best.expected_sigma
        ));
    }
    for (place, (mut entry, Block { plan, .. })) in worth.into_iter().enumerate() {
        let kind = if plan.contains("isolux-plan/1") { "plan" } else { "maps" };
        let file = if place == 0 {
            format!("next.{kind}.toml")
        } else {
            format!("next-{}.{kind}.toml", place + 1)
        };
        entry.plan = Some(file.clone());
        next.plans.push((file, plan));
        next.entries.push(entry);
    }
    next
}

/// The first member with a named alternative in its set, and the refitted values of both.
fn alternatives_of(outcome: &Outcome) -> Option<(usize, [Hypothesis; 2])> {
    for (number, comparison) in outcome.comparisons.iter().enumerate() {
        let mut sum = 0.0;
        let mut set: Vec<Hypothesis> = Vec::new();
        for ranked in &comparison.ranked {
            if sum >= SET {
                break;
            }
            sum += ranked.posterior;
            if let (Label::Named(_), Some(hypothesis)) = (ranked.label, &ranked.hypothesis) {
                set.push(hypothesis.clone());
            }
        }
        if let [one, two, ..] = set.as_slice() {
            return Some((number, [one.clone(), two.clone()]));
        }
    }
    None
}

/// The blocks that a bench or a camera could measure and these data lack.
fn blocks(assumed: &AssumedModel, outcome: &Outcome, rows: &[Row], repeats: usize) -> Vec<Block> {
    let mut blocks = Vec::new();
    if rows.iter().any(|row| row.source == ObservationKind::Reading) {
        reading_blocks(outcome, rows, repeats, &mut blocks);
    }
    for part in assumed.parts() {
        if let Part::Maps(maps) = part {
            map_blocks(outcome, rows, maps, &mut blocks);
            break;
        }
    }
    blocks
}
