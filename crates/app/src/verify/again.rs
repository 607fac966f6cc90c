//! The results of a run made again from its record, in a folder of their own: reduction, light on the sensor, diagnosis
//! and report, as far as they lie in the run.

use std::collections::{BTreeMap, BTreeSet};

use camino::{Utf8Path, Utf8PathBuf};
use isolux_record::Run;
use isolux_record::event::EVENTS_FILE;
use isolux_reduce::{Accepted, Correction, Options, Reduction, ResultFile, file_name, reduce};
use isolux_report::day::{DayResults, amended, document};
use serde::Deserialize;

use super::ledger;
use super::provenance::Provenance;
use crate::Failure;
use crate::day::{self, paper, publish, requested};
use crate::files::{self, Overwrite};
use crate::front_end::progress::{Event, Progress};
use crate::instruments::bench::PROGRAM;
use crate::run::reduce::{REDUCED_WITH, kept_model, run_files};

/// What was made again.
#[derive(Debug, Default)]
pub(super) struct Again {
    /// By name in the results; more than one where a file can have been made in two ways.
    pub made: BTreeMap<String, Vec<Vec<u8>>>,
    /// Beginnings of names of what was not made, and why.
    left_out: Vec<(&'static str, String)>,
    /// The run's folder as the files that were made name it.
    pub folder: Utf8PathBuf,
}

impl Again {
    /// Nothing, for this reason.
    pub fn left_out(why: &str) -> Self {
        Self {
            left_out: vec![("", why.to_owned())],
            ..Self::default()
        }
    }

    /// Why a file was not made.
    pub fn why_not(&self, name: &str) -> &str {
        let found = self.left_out.iter().find(|(start, _)| name.starts_with(start));
        found.map_or("this program does not make it there", |(_, why)| why.as_str())
    }
}

/// How results were made, as two of their files say.
#[derive(Debug, Deserialize)]
struct Inputs {
    without: BTreeSet<Correction>,
    accepted_drift: Option<Accepted>,
}

/// Makes the results in `results` again. What cannot be made is left out with its reason.
///
/// # Errors
/// Exit 3 when the system gives no folder to work in.
pub(super) fn make(
    run: &Run,
    results: &Utf8Path,
    provenance_file: &str,
    provenance: &Provenance,
    progress: &dyn Progress,
) -> Result<Again, Failure> {
    let scratch = tempfile::tempdir().map_err(Failure::instrument)?;
    let at = Utf8Path::from_path(scratch.path())
        .ok_or_else(|| Failure::instrument("the folder for temporary files has a name that is no text"))?
        .join("results");
    let path = run.path.clone();
    // By its whole path, which no other word of a file can be taken for.
    let whole = std::path::absolute(&run.path).map_err(Failure::instrument)?;
    let whole = Utf8PathBuf::try_from(whole).map_err(Failure::instrument)?;
    let mut run = Run::read(&whole).map_err(Failure::bad_input)?;
    // No number is computed from the events; results would only say that they were changed.
    let events = whole.join(EVENTS_FILE);
    let all = run.notices.len();
    run.notices.retain(|notice| !notice.starts_with(events.as_str()));
    let events_differ = run.notices.len() < all;
    let mut again = Again {
        folder: whole,
        ..Again::default()
    };
    progress.event(Event::Began {
        step: "reduce",
        total: None,
    });
    let (run, reduction, made) = match reduced(&run, results, provenance_file, provenance) {
        Ok(reduced) => reduced,
        Err(failure) => {
            again.left_out.push(("", failure.message));
            return Ok(again);
        }
    };
    for file in &made {
        files::write(&at.join(&file.name), &file.bytes, Overwrite::Force)?;
    }
    progress.event(Event::Ended(&format!("flux {}", reduction.flux.stated())));
    // Only there does a day leave more.
    if events_differ {
        again.left_out.push((
            "",
            "events.jsonl, which reports tell from, is not as it was recorded".to_owned(),
        ));
    } else if ["results", "results-partial"]
        .map(|name| path.join(name))
        .contains(&results.to_owned())
    {
        beyond(&run, reduction, results, &at, &mut again, progress);
    }
    for name in ledger::names(&at)? {
        let bytes = files::read(&at.join(&name))?;
        again.made.entry(name).or_default().insert(0, bytes);
    }
    Ok(again)
}

/// The reduction and its files: of the ways in which a run's results can have been made, the one that the fewest of the
/// files there differ from. A changed digit in a file that says how they were made is found by the others.
fn reduced(
    run: &Run,
    results: &Utf8Path,
    provenance_file: &str,
    provenance: &Provenance,
) -> Result<(Run, Reduction, Vec<ResultFile>), Failure> {
    let partial = provenance_file.contains("partial");
    let budget = if partial { "budget.partial.json" } else { "budget.json" };
    let mut options: Vec<Options> = Vec::new();
    for file in [budget, provenance_file] {
        let Ok(Inputs {
            without,
            accepted_drift,
        }) = files::read_json(&results.join(file))
        else {
            continue;
        };
        let accept_drift = accepted_drift.map(|accepted| accepted.reason);
        let found = Options { without, accept_drift };
        if !options.contains(&found) {
            options.push(found);
        }
    }
    let mut runs = vec![run.clone()];
    if let Ok(requested) = requested::of_report(&run.path, None) {
        let mut of_job = run.clone();
        of_job.header.state(&requested.subject);
        if of_job.header != run.header {
            runs.insert(0, of_job);
        }
    }
    let mut inputs = run_files(&run.path, run)?;
    for name in provenance
        .run
        .sha256
        .keys()
        .filter(|name| name.starts_with(REDUCED_WITH[0]))
    {
        inputs.push((name.clone(), files::read(&results.join(name))?));
    }
    let kept = kept_model(results)?;
    let mut best: Option<(usize, Run, Reduction, Vec<ResultFile>)> = None;
    let mut refused = None;
    for options in &options {
        for model in kept.iter().cloned().map(Some).chain([None]) {
            let reduction = match reduce(run, options, model) {
                Ok(reduction) => reduction,
                Err(error) => {
                    refused = Some(Failure::bad_input(error));
                    continue;
                }
            };
            if reduction.partial.is_some() != partial {
                return Err(Failure::bad_input(
                    "the results are of a part of the record, which has grown since",
                ));
            }
            for (run, program) in runs
                .iter()
                .flat_map(|run| [(run, PROGRAM), (run, provenance.program.as_str())])
            {
                let made = isolux_reduce::files(&reduction, run, &inputs, program).map_err(Failure::bad_input)?;
                let other =
                    |file: &&ResultFile| std::fs::read(results.join(&file.name)).ok().as_ref() != Some(&file.bytes);
                let off = made.iter().filter(other).count();
                if best.as_ref().is_none_or(|(least, ..)| off < *least) {
                    best = Some((off, run.clone(), reduction.clone(), made));
                }
                if off == 0 {
                    break;
                }
            }
            if matches!(best, Some((0, ..))) {
                break;
            }
        }
    }
    match best {
        Some((_, run, reduction, made)) => Ok((run, reduction, made)),
        None => Err(refused.unwrap_or_else(|| Failure::bad_input("no file says how the results were made"))),
    }
}

/// What a day makes of the reduction that lies in `at`.
fn beyond(
    run: &Run,
    reduction: Reduction,
    results: &Utf8Path,
    at: &Utf8Path,
    again: &mut Again,
    progress: &dyn Progress,
) {
    let named = |name: &str| file_name(&reduction, name);
    let [page, paper] = ["report.html", "report.pdf"].map(named);
    let has = |name: &str| results.join(name).is_file();
    let is_day = has("result.json");
    if !is_day && !has(&page) && !has(&paper) {
        return;
    }
    let requested = match requested::of_report(&run.path, None) {
        Ok(requested) => requested,
        // That a result of a day without a job says otherwise is what is looked for.
        Err(_)
            if !run.path.join(requested::FOLDER).exists()
                && requested::on_built_in_bench(&run.path).unwrap_or_default() =>
        {
            requested::OfReport {
                wanted: requested::Wanted::built_in().unwrap_or_default(),
                ..requested::OfReport::default()
            }
        }
        Err(failure) => {
            again.left_out.push(("", failure.message));
            return;
        }
    };
    let scene = requested.scene.as_deref();
    let made = if is_day {
        day::simulated(
            at,
            run.clone(),
            reduction,
            scene,
            &requested.wanted,
            Overwrite::Force,
            progress,
        )
        .and_then(|day_results| match diagnosis(run, at, requested.own_model) {
            Ok(request) => day::reported(day_results, &request, None, Overwrite::Force, progress),
            Err(failure) => {
                let why = format!(
                    "the diagnosis of the day reads files outside the run: {}",
                    failure.message
                );
                again
                    .left_out
                    .extend(["diagnosis", "report"].map(|start| (start, why.clone())));
                Ok(day_results)
            }
        })
    } else {
        day::light::light(at, run.clone(), reduction, scene, &requested.wanted, progress)
    };
    let reported = made.and_then(|mut day_results| {
        if again.left_out.iter().any(|(start, _)| *start == "report") {
            return Ok(());
        }
        reports(&day_results, [&page, &paper], results, again, progress)?;
        // `isolux report` shows the answer of the diagnosis without what is behind it.
        if let Some(diagnosed) = &mut day_results.diagnosis
            && !diagnosed.details.is_empty()
        {
            diagnosed.details.clear();
            reports(&day_results, [&page, &paper], results, again, progress)?;
        }
        Ok(())
    });
    if let Err(failure) = reported {
        again.left_out.push(("", failure.message));
    }
}

/// The diagnosis that the day asked for.
fn diagnosis(
    run: &Run,
    at: &Utf8Path,
    own_model: bool,
) -> Result<crate::diagnosis::diagnose::DiagnoseRequest, Failure> {
    let job = if own_model { requested::kept(&run.path)? } else { None };
    let wanted = job.and_then(|job| requested::diagnosis(&job, at, Overwrite::Force));
    let model = at.join("luminaire.model.toml");
    Ok(wanted.unwrap_or_else(|| requested::diagnosis_of(model, vec![run.path.clone()], at, Overwrite::Force)))
}

/// The page and the paper, where the results hold them.
fn reports(
    day_results: &DayResults,
    [page, paper_name]: [&String; 2],
    results: &Utf8Path,
    again: &mut Again,
    progress: &dyn Progress,
) -> Result<(), Failure> {
    let document = document(day_results)?;
    if results.join(publish::STATEMENTS).is_file() {
        let text = serde_json::to_string_pretty(&document.statements()).map_err(Failure::instrument)? + "\n";
        again
            .made
            .entry(publish::STATEMENTS.to_owned())
            .or_default()
            .push(text.into_bytes());
    }
    let document = amended(document, &publish::amendments(results)?);
    if results.join(page).is_file() {
        again
            .made
            .entry(page.clone())
            .or_default()
            .push(document.html().into_bytes());
    }
    if results.join(paper_name).is_file() {
        let bytes = paper::paper(&document, progress)?;
        again.made.entry(paper_name.clone()).or_default().push(bytes);
    }
    Ok(())
}
