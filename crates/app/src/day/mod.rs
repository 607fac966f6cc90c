//! The whole day: check, warm up, scan, reduce, simulate, compare, diagnose, report.
//!
//! Without a job it plays in the built-in virtual darkroom, in virtual time. The run directory is the day's folder;
//! what follows from it is in its `results/`, with no wall clock in it, so that the same run gives the same bytes.

mod before;
mod diary;
mod kept;
pub(crate) mod light;
pub(crate) mod paper;
pub(crate) mod publish;
mod report;
pub(crate) mod requested;
pub(crate) mod stored;

use camino::{Utf8Path, Utf8PathBuf};
use isolux_diagnose::document::{Independence, Verdict};
use isolux_record::run::StopHow;
use isolux_record::{Job, LightModulation, Plan, Run, RunError, disk};
use isolux_reduce::Reduction;
use isolux_report::answer::statistics;
use isolux_report::day::{DayResults, Diagnosed, document};
use isolux_virtual::twins::Choice;

pub use self::report::{data_sheet, parts, report, report_document};
use self::requested::Wanted;
use crate::diagnosis::diagnose;
use crate::files::{self, Overwrite};
use crate::front_end::control::Control;
use crate::front_end::progress::{Event, Progress};
use crate::init::DayPlan;
use crate::instruments::bench;
use crate::modulation;
use crate::run::reduce::Reduced;
use crate::run::{record, reduce};
use crate::scan::{self, Operator, Place, ScanJob, Target};
use crate::simulation::simulate;
use crate::{Failure, init};

/// What a day is made of.
#[derive(Debug, Clone, Default)]
pub struct Options {
    /// The job; without one the built-in virtual darkroom with its plan.
    pub job: Option<Utf8PathBuf>,
    /// Plan of the built-in virtual darkroom; a resumed day keeps its own.
    pub plan: DayPlan,
    /// The folder of the day; without one a fresh `day`, `day-2`, ….
    pub out: Option<Utf8PathBuf>,
    /// Whether `out` is a day that broke off, to be resumed.
    pub resume: bool,
    /// Whether what is damaged in its record is set aside and read again.
    pub reread: bool,
    /// The reason for which instruments and folder may be taken over from a process that does not answer.
    pub force: Option<String>,
    /// Why a drift beyond the limits of the plan is accepted; none: it is refused after the scan, and the record stays.
    pub accept_drift: Option<String>,
    /// Why a report that was issued is made again.
    pub amend: Option<String>,
}

/// A finished day.
pub struct Day {
    /// Its folder.
    pub folder: Utf8PathBuf,
    /// The report.
    pub report: Utf8PathBuf,
    /// The numbers that matter, one sentence each.
    pub sentences: Vec<String>,
}

/// Runs the day.
///
/// # Errors
/// Bad input (exit 2) before anything moves; 1 when the lamp does not become stable; 3 when an instrument fails or an
/// axis cannot be verified at rest; 130 when interrupted. What was recorded until then stays readable.
pub fn run(
    options: &Options,
    operator: Option<&dyn Operator>,
    control: &Control,
    progress: &dyn Progress,
) -> Result<Day, Failure> {
    let folder = match &options.out {
        Some(folder) => folder.clone(),
        None => fresh_folder(),
    };
    let job = match &options.job {
        Some(file) => Some(Job::load(file).map_err(Failure::bad_input)?),
        None if options.resume => requested::kept(&folder)?,
        None => None,
    };
    let plan = if options.resume && job.is_none() {
        requested::built_in_plan(&folder)?.unwrap_or(options.plan)
    } else {
        options.plan
    };
    let target = match (options.resume, options.reread) {
        (true, true) => Target::Reread(&folder),
        (true, false) => Target::Resume(&folder),
        (false, _) => Target::New(&folder),
    };
    // Held to the end of the day_results: two that make the results of one day at once would mix them.
    let force = options.force.as_deref();
    let place =
        Place::take(target, force.is_some()).map_err(|failure| go_on(failure, options.job.as_deref(), &folder))?;
    let subject = match &job {
        Some(job) => job.subject().clone(),
        None => init::subject::built_in(),
    };
    let place = place.of(&subject);
    if options.resume {
        disk::remove_unpublished(&folder).map_err(Failure::instrument)?;
    }
    let scanned = options.resume && completed(&folder, options.reread)?;
    // What cannot be is refused before anything moves, not after the scan.
    if let Some(job) = &job {
        before::check(job, scanned.then_some(folder.as_path()), operator.is_some(), progress)?;
    }
    let scan = |source: &bench::StationFiles, plan: &Plan, progress: &dyn Progress| {
        let job = ScanJob {
            source,
            plan,
            place: place.clone(),
            force,
            operator,
            control,
            progress,
        };
        job.execute()
            .map_err(|failure| go_on(failure, options.job.as_deref(), &folder))
    };
    match &job {
        Some(job) if scanned => requested::keep(&folder, job)?,
        None if scanned => {}
        Some(job) => {
            let (source, plan, _) = scan::checked(job.station(), job.plan(), operator.is_some())?;
            let keeping = requested::JobRecorder::new(&folder, job, progress);
            scan(&source, &plan, &keeping)?;
            keeping.end()?;
        }
        None => {
            let (source, plan) = built_in(plan)?;
            scan(&source, &plan, progress)?;
        }
    }
    // What a day that broke off in the day_results had made of its record is made again.
    let overwrite = if options.resume {
        Overwrite::Force
    } else {
        Overwrite::Never
    };
    finish(&folder, job.as_ref(), options, overwrite, progress)
        .map_err(|failure| resume_with_reason(failure, options.job.as_deref(), &folder))
}

/// The failure of the acceptance check with the command that accepts the record.
fn resume_with_reason(mut failure: Failure, job: Option<&Utf8Path>, folder: &Utf8Path) -> Failure {
    let job = job.map_or_else(String::new, |job| format!("{job} "));
    failure.help = failure.help.map(|help| {
        let accept = "--accept-drift=REASON";
        help.replace(accept, &format!("isolux run {job}--resume {folder} {accept}"))
    });
    failure
}

/// The failure with the whole command that goes on with the day.
fn go_on(mut failure: Failure, job: Option<&Utf8Path>, folder: &Utf8Path) -> Failure {
    let job = job.map_or_else(String::new, |job| format!("{job} "));
    let resume = format!("--resume {folder}");
    failure.help = failure.help.map(|help| {
        // Advice that names the command already is left as it is.
        if help.contains("isolux run") {
            help
        } else {
            help.replace(&resume, &format!("isolux run {job}{resume}"))
        }
    });
    failure
}

/// Whether the scan of a day was carried out to its end.
fn completed(folder: &Utf8Path, reread: bool) -> Result<bool, Failure> {
    match Run::read(folder) {
        Err(RunError::Damaged { .. }) if reread => Ok(false),
        _ => Ok(record::read(folder)?
            .header
            .stopped
            .is_some_and(|stopped| stopped.how == StopHow::Completed)),
    }
}

/// The built-in virtual darkroom, and a plan for it.
fn built_in(plan: DayPlan) -> Result<(bench::StationFiles, Plan), Failure> {
    let (station, calibration) = init::virtual_station(&Choice::default())?;
    Ok((
        bench::StationFiles::from_text(&station, calibration.as_deref())?,
        plan.plan()?,
    ))
}

/// From the record to the report.
fn finish(
    folder: &Utf8Path,
    job: Option<&Job>,
    options: &Options,
    overwrite: Overwrite,
    progress: &dyn Progress,
) -> Result<Day, Failure> {
    let results = folder.join("results");
    progress.event(Event::Began {
        step: "reduce",
        total: None,
    });
    let request = reduce::ReduceRequest {
        accept_drift: options.accept_drift.as_deref(),
        subject: job.map(Job::subject),
        ..reduce::ReduceRequest::default()
    };
    let reduced = reduce::run(folder, &request, overwrite)?;
    progress.event(Event::Ended(&format!("flux {}", reduced.reduction.flux.stated())));

    let Reduced { run, reduction, .. } = reduced;
    let scene = job.map(Job::scene);
    let wanted = job.map_or_else(Wanted::built_in, Wanted::of)?;
    let day_results = simulated(&results, run, reduction, scene, &wanted, overwrite, progress)?;
    let model = results.join("luminaire.model.toml");
    let wanted = job.and_then(|job| requested::diagnosis(job, &results, overwrite));
    let request =
        wanted.unwrap_or_else(|| requested::diagnosis_of(model, vec![folder.to_owned()], &results, overwrite));
    let day_results = reported(day_results, &request, options.amend.as_deref(), overwrite, progress)?;
    if let Some(job) = job {
        diary::add(job, folder, &day_results, progress)?;
    }
    Ok(Day {
        sentences: day_results.sentences(),
        folder: folder.to_owned(),
        report: results.join("report.html"),
    })
}

/// The light on the sensor, and the test on the axis, of the reduction in `results`; writes them there.
pub(crate) fn simulated(
    results: &Utf8Path,
    run: Run,
    reduction: Reduction,
    scene: Option<&Utf8Path>,
    wanted: &Wanted,
    overwrite: Overwrite,
    progress: &dyn Progress,
) -> Result<DayResults, Failure> {
    kept::step("simulate", results, || {
        let day_results = light::light(results, run, reduction, scene, wanted, progress)?;
        let u_direction_rel = day_results.u_direction_rel();
        simulate::write(results, &day_results.simulation, u_direction_rel, overwrite)?;
        write_light_modulation(&day_results, wanted.light_modulation.as_ref(), overwrite)?;
        let text = serde_json::to_string_pretty(&day_results.conformity).map_err(Failure::instrument)? + "\n";
        files::write(&results.join("conformity.json"), text.as_bytes(), overwrite)?;
        if let Some(comparison) = &day_results.comparison {
            let text = format!("{:#}\n", serde_json::to_value(comparison).map_err(Failure::instrument)?);
            files::write(&results.join("comparison.json"), text.as_bytes(), overwrite)?;
        }
        Ok(day_results)
    })
}

/// Writes what the record of the light over time says; what lies there of an earlier one goes.
fn write_light_modulation(
    day_results: &DayResults,
    light: Option<&LightModulation>,
    overwrite: Overwrite,
) -> Result<(), Failure> {
    let results = &day_results.folder;
    let (Some(light), Some(found)) = (light, &day_results.light_modulation) else {
        return modulation::FILES
            .iter()
            .try_for_each(|name| files::remove(&results.join(name)));
    };
    // A day keeps its waveform under this name.
    let waveform = modulation::kept_name(&files::read(&light.waveform)?).to_owned();
    let evaluated = modulation::Evaluated {
        waveform,
        modulation: found.clone(),
        verdicts: Vec::new(),
    };
    modulation::write(results, &evaluated, overwrite)?;
    Ok(())
}

/// Diagnoses and writes the report, in the folder of `day_results`.
pub(crate) fn reported(
    mut day_results: DayResults,
    request: &diagnose::DiagnoseRequest,
    amend: Option<&str>,
    overwrite: Overwrite,
    progress: &dyn Progress,
) -> Result<DayResults, Failure> {
    let results = day_results.folder.clone();
    // The report does not wait for a diagnosis that fails: nothing else of it follows from that.
    let diagnosed = kept::step("diagnose", &results, || {
        diagnosed(request, &results, overwrite, progress)
    });
    match diagnosed {
        Ok(diagnosed) => day_results.diagnosis = diagnosed,
        Err(failure) => {
            let sentence = format!("the diagnosis failed, and the report is made without it: {failure}");
            progress.event(Event::Note(&sentence));
            // What an earlier one found is not of these results.
            files::remove(&results.join("diagnosis.json"))?;
            day_results.undiagnosed = Some(sentence);
        }
    }
    kept::step("report", &results, || {
        let document = document(&day_results)?;
        let page = results.join("report.html");
        if day_results.layout.data_sheet {
            let sheet = isolux_report::day::data_sheet(&day_results, &document);
            files::write(&results.join("data-sheet.html"), sheet.html().as_bytes(), overwrite)?;
            files::write(
                &results.join("data-sheet.pdf"),
                &paper::paper(&sheet, progress)?,
                overwrite,
            )?;
        }
        publish::publish(document, &results, &page, amend, overwrite, progress)
    })?;
    Ok(day_results)
}

/// What the diagnosis of the day says; none for a record of which every reading made the distribution, which has none
/// that could check it.
fn diagnosed(
    request: &diagnose::DiagnoseRequest,
    results: &Utf8Path,
    overwrite: Overwrite,
    progress: &dyn Progress,
) -> Result<Option<Diagnosed>, Failure> {
    let Ok(answer) = diagnose::attempt(request, progress)? else {
        return Ok(None);
    };
    let answer_file = files::read(&results.join("diagnosis/diagnosis.json"))?;
    files::write(&results.join("diagnosis.json"), &answer_file, overwrite)?;
    Ok(Some(Diagnosed {
        plain: answer.document.plain.clone(),
        good: answer.document.verdict == Verdict::Consistent,
        details: statistics(&answer),
        same_record: answer.document.independence == Independence::SameRun,
    }))
}

/// `day`, or the first of `day-2`, `day-3`, … that does not exist.
fn fresh_folder() -> Utf8PathBuf {
    let mut folder = Utf8PathBuf::from("day");
    let mut number = 1;
    while folder.exists() {
        number += 1;
        folder = Utf8PathBuf::from(format!("day-{number}"));
    }
    folder
}
