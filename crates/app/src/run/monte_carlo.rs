//! `isolux reduce --monte-carlo`: the budget of a run beside draws of its inputs.

use std::collections::BTreeSet;
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::mpsc;

use camino::Utf8Path;
use isolux_reduce::{Correction, MonteCarlo, Options, Propagated};
use serde::Serialize;

use isolux_units::digits::K;

use crate::Failure;
use crate::front_end::progress::{Event, Pace, Progress};
use crate::run::record;
use crate::run::reduce::refused;

/// Fewer draws say little of a standard deviation.
const LEAST: u64 = 20;

/// What the draws of a run say.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Drawn {
    /// Draws that were asked for.
    pub draws: u64,
    /// Draws of which the reduction refuses the record, and why the first of them.
    pub refused: Option<Refused>,
    /// The quantities.
    pub quantities: Vec<Propagated>,
}

/// Draws without results.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Refused {
    /// How many.
    pub draws: u64,
    /// Why the first of them.
    pub why: String,
}

impl Drawn {
    /// A line for each quantity, and what was not drawn.
    pub fn sentences(&self) -> Vec<String> {
        let mut lines = Vec::new();
        for one in &self.quantities {
            let unit = if one.unit.is_empty() {
                String::new()
            } else {
                format!(" {}", one.unit)
            };

            lines.push(format!(
                "{}: {:.6}{unit}; U (k = {K}) {:.2e} by the budget, {:.2e} by {} draws; 95 % of them from {:.6} \
                 to {:.6}",
                one.name,
                one.value,
                K * one.u_budget,
                K * one.u,
                one.draws,
                one.interval[0],
                one.interval[1]
            ));
            if !one.not_drawn.is_empty() {
                lines.push(format!("  not drawn, and not in either: {}", one.not_drawn.join(", ")));
            }
        }
        let known_rel = (2.0 * (self.draws as f64 - 1.0)).sqrt().recip();
        lines.push(format!(
            "note: so many draws know a standard deviation to {:.0} % (k = 1)",
            100.0 * known_rel
        ));
        lines.extend(self.refused.iter().map(|refused| {
            format!(
                "note: {} draws give no results, the first: {}",
                refused.draws, refused.why
            )
        }));
        lines
    }
}

/// Draws the inputs of the run in `run` so many times and reduces each record; nothing is written. The same run and
/// number give the same draws, on any number of threads.
///
/// # Errors
/// Bad input (exit 2) for too few draws, an unknown correction, a scan in motion; what the reduction of the record
/// itself is refused for.
pub fn run(run: &Utf8Path, without: &[String], draws: u64, progress: &dyn Progress) -> Result<Drawn, Failure> {
    if draws < LEAST {
        return Err(Failure::bad_input(format!(
            "--monte-carlo {draws}: {LEAST} draws at least; 200 know a standard deviation to 5 %"
        )));
    }
    let words = without.iter().map(|word| word.parse::<Correction>());
    let without = words.collect::<Result<BTreeSet<_>, _>>().map_err(Failure::bad_input)?;
    let record = record::read_at_rest(run)?;
    let options = Options {
        without,
        accept_drift: None,
    };
    let drawing = MonteCarlo::new(&record, &options).map_err(|error| refused(run, &error))?;
    let (next, pace) = (AtomicU64::new(0), Pace::of(draws as usize));
    progress.event(Event::Began {
        step: "draws",
        total: Some(draws),
    });
    let (sender, drawn) = mpsc::channel();
    let mut made = Vec::new();
    std::thread::scope(|scope| {
        for _ in 0..std::thread::available_parallelism().map_or(1, usize::from) {
            let sender = sender.clone();
            let (next, drawing) = (&next, &drawing);
            scope.spawn(move || {
                loop {
                    let number = next.fetch_add(1, Ordering::Relaxed);
                    // The other end lives as long as this scope.
                    if number >= draws || sender.send((number, drawing.draw(number))).is_err() {
                        break;
                    }
                }
            });
        }
        drop(sender);
        for one in drawn {
            made.push(one);
            progress.event(Event::At {
                done: made.len() as u64,
                what: &pace.words("reducing", made.len()),
            });
        }
    });
    made.sort_by_key(|(number, _)| *number);
    let (mut values, mut without_results) = (Vec::new(), None::<Refused>);
    for (_, drawn) in made {
        match drawn {
            Ok(drawn) => values.push(drawn),
            Err(error) => {
                without_results
                    .get_or_insert_with(|| Refused {
                        draws: 0,
                        why: error.to_string(),
                    })
                    .draws += 1;
            }
        }
    }
    progress.event(Event::Ended(&format!("{} records reduced", values.len())));
    Ok(Drawn {
        draws,
        refused: without_results,
        quantities: drawing.propagated(&values),
    })
}
