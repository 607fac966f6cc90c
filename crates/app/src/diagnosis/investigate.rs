//! `isolux investigate`: diagnose, carry out the measurement that would settle the answer, diagnose again.

use camino::{Utf8Path, Utf8PathBuf};
use isolux_record::Station;
use isolux_scan::Operator;

use crate::Failure;
use crate::diagnosis::diagnose::{self, DiagnoseRequest, DiagnosisResult};
use crate::files::{self, Overwrite};
use crate::front_end::control::Control;
use crate::front_end::progress::{Event, Progress};
use crate::scan::{self, Place, ScanJob, Target};

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
    /// The reason for which instruments may be taken over from a process that does not answer.
    pub force: Option<String>,
}

/// Alternatives that a measurement would leave nearer than this, in σ, it does not distinguish.
const WORTH_A_SCAN_SIGMA: f64 = 3.0;

/// Diagnoses, and while the answer is a set: takes the best next measurement that this station can carry out, asks `go`
/// whether the axes may move, scans it and diagnoses all runs together. The last answer, and the runs that it rests on.
///
/// # Errors
/// As [`diagnose::run`] and [`ScanJob::execute`]; bad input (exit 2) before anything moves when the station cannot be
/// read or the folder is not empty.
pub fn run(
    requested: &Investigation,
    operator: Option<&dyn Operator>,
    go: &dyn Fn(&str) -> bool,
    control: &Control,
    progress: &dyn Progress,
) -> Result<(DiagnosisResult, Vec<Utf8PathBuf>), Failure> {
    Station::load(&requested.station).map_err(Failure::bad_input)?;
    files::refuse_occupied(&requested.out, Overwrite::Never)?;
    let mut runs = vec![requested.run.clone()];
    for round in 1.. {
        let out = requested.out.join(format!("diagnosis-{round}"));
        let answer = diagnosed(requested, &runs, &out, progress)?;
        if round > requested.rounds {
            return Ok((answer, runs));
        }
        let Some((question, plan)) = proposal(requested, &answer, &out, operator.is_some(), progress) else {
            return Ok((answer, runs));
        };
        if !go(&question) {
            progress.event(Event::Note("nothing was moved"));
            return Ok((answer, runs));
        }
        let run = requested.out.join(format!("run-{}", round + 1));
        let force = requested.force.as_deref();
        let (source, plan, _) = scan::checked(&requested.station, &plan, operator.is_some())?;
        ScanJob {
            source: &source,
            plan: &plan,
            place: Place::take(Target::New(&run), force.is_some())?,
            force,
            operator,
            control,
            progress,
        }
        .execute()?;
        runs.push(run);
    }
    unreachable!("the loop ends by returning")
}

/// The question to the operator and the plan of the best suggestion that would tell the alternatives apart and that the
/// station can carry out; says what stands in the way of the others.
fn proposal(
    requested: &Investigation,
    answer: &DiagnosisResult,
    out: &Utf8Path,
    attended: bool,
    progress: &dyn Progress,
) -> Option<(String, Utf8PathBuf)> {
    for next in &answer.document.next_measurement {
        // Poses for a camera are no plan of the axes.
        let Some(plan) = next.plan.as_ref().filter(|plan| plan.ends_with(".plan.toml")) else {
            continue;
        };
        let [one, other] = &next.splits;
        if next.expected_sigma < WORTH_A_SCAN_SIGMA {
            let sentence = format!(
                "{} is not worth a scan: {one} and {other} would lie {:.1} σ apart",
                next.what, next.expected_sigma
            );
            progress.event(Event::Note(&sentence));
            continue;
        }
        let plan = out.join(plan);
        match scan::checked(&requested.station, &plan, attended) {
            Ok((_, _, day)) => {
                let question = format!(
                    "{} ({plan}): {one} and {other} would lie {:.1} σ apart; {} readings, {} with the warm-up. May the axes move?",
                    next.what,
                    next.expected_sigma,
                    day.readings,
                    scan::duration(day.total_s)
                );
                return Some((question, plan));
            }
            Err(failure) => {
                let sentence = format!("{} cannot be carried out on this bench: {failure}", next.what);
                progress.event(Event::Note(&sentence));
            }
        }
    }
    None
}

fn diagnosed(
    requested: &Investigation,
    runs: &[Utf8PathBuf],
    out: &Utf8Path,
    progress: &dyn Progress,
) -> Result<DiagnosisResult, Failure> {
    let request = DiagnoseRequest {
        model: requested.model.clone(),
        observations: runs.to_vec(),
        out: out.to_owned(),
        held_out: None,
        seed: requested.seed,
        accept: false,
        overwrite: Overwrite::Never,
    };
    diagnose::run(&request, progress)
}
