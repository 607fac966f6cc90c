//! `isolux investigate`: diagnose, carry out the measurement that would settle the answer, diagnose again.

use camino::{Utf8Path, Utf8PathBuf};
use isolux_scan::Operator;

use crate::Failure;
use crate::diagnose::{self, Answer, Request};
use crate::files::Overwrite;
use crate::progress::{Event, Progress};
use crate::scan::{self, Target};

/// What is asked.
#[derive(Debug, Clone)]
pub struct Investigation {
    /// The bench.
    pub station: Utf8PathBuf,
    /// The model.
    pub model: Utf8PathBuf,
    /// The run to begin with.
    pub run: Utf8PathBuf,
    /// Where `diagnosis-1`, `run-2`, `diagnosis-2`, … are written.
    pub out: Utf8PathBuf,
    /// At most so many further measurements.
    pub rounds: usize,
    /// Seed of the simulated scans.
    pub seed: u64,
}

/// Diagnoses, and while the answer is a set: shows the best next measurement, asks `go` whether the axes may move, scans
/// it and diagnoses all runs together. The last answer, and the runs that it rests on.
///
/// # Errors
/// As [`diagnose::run`] and [`scan::run`].
pub fn run(
    asked: &Investigation,
    operator: Option<&dyn Operator>,
    go: &dyn Fn(&str) -> bool,
    progress: &dyn Progress,
) -> Result<(Answer, Vec<Utf8PathBuf>), Failure> {
    let mut runs = vec![asked.run.clone()];
    for round in 1.. {
        let out = asked.out.join(format!("diagnosis-{round}"));
        let answer = diagnosed(asked, &runs, &out, progress)?;
        let next = answer.document.next_measurement.iter().find_map(|next| {
            next.plan
                .as_ref()
                .filter(|plan| plan.ends_with(".plan.toml"))
                .map(|plan| (next, plan))
        });
        let Some((next, plan)) = next.filter(|_| round <= asked.rounds) else {
            return Ok((answer, runs));
        };
        let question = format!(
            "{} ({plan}): {} and {} would lie {:.1} σ apart, {:.0} min. May the axes move?",
            next.what, next.splits[0], next.splits[1], next.expected_sigma, next.minutes
        );
        if !go(&question) {
            progress.event(Event::Note("nothing was moved"));
            return Ok((answer, runs));
        }
        let run = asked.out.join(format!("run-{}", round + 1));
        scan::run(&asked.station, &out.join(plan), Target::New(&run), operator, progress)?;
        runs.push(run);
    }
    unreachable!("the loop ends by returning")
}

fn diagnosed(
    asked: &Investigation,
    runs: &[Utf8PathBuf],
    out: &Utf8Path,
    progress: &dyn Progress,
) -> Result<Answer, Failure> {
    let request = Request {
        model: asked.model.clone(),
        observations: runs.to_vec(),
        out: out.to_owned(),
        held_out: None,
        seed: asked.seed,
        accept: false,
        overwrite: Overwrite::Never,
    };
    diagnose::run(&request, progress)
}
