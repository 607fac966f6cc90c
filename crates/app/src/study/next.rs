//! The measurement that a diagnosis proposes: shown as a plan, and carried out after a second word.

use camino::{Utf8Path, Utf8PathBuf};
use isolux_record::disk::sha256;
use isolux_record::{RunHeader, Station};
use isolux_virtual::twins::Choice;
use serde::Serialize;

use super::diagnosed::{Case, Proposal, diagnosed, latest};
use super::job;
use crate::front_end::control::Control;
use crate::front_end::progress::Progress;
use crate::run::folder;
use crate::scan::{self, Operator, Place, ScanJob, Target, duration};
use crate::{Failure, init};

/// What would be done.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Shown {
    /// The plan file.
    pub plan: Utf8PathBuf,
    /// The station file.
    pub station: Utf8PathBuf,
    /// What it is, what it moves and how long it takes, one sentence each.
    pub sentences: Vec<String>,
    /// The text of the plan.
    pub text: String,
    /// Of plan and station: who confirms a measurement says by it what was shown.
    pub fingerprint: String,
}

/// The proposal of this number as a plan for the station of the run. Nothing moves.
///
/// # Errors
/// Bad input (exit 2) where there is no such proposal, its station is not known, or the bench cannot carry it out.
pub fn shown(run: &Utf8Path, number: usize) -> Result<Shown, Failure> {
    let found = diagnosed(run)?;
    let next = found.as_ref().and_then(|found| found.next.get(number));
    let Some(Proposal {
        plan: Some(plan),
        what,
        splits: [one, other],
        expected_sigma,
    }) = next
    else {
        return Err(Failure::bad_input(
            "this diagnosis proposes no such measurement for the axes",
        ));
    };
    let plan = latest(run).0.join(plan);
    let station = station(run)?;
    let (_, _, day) = scan::checked(&station, &plan, true)?;
    let blocks = day.blocks.iter().map(|block| {
        format!(
            "{} ({}): {} points at {} mm",
            block.name, block.kind, block.points, block.distance_mm
        )
    });
    let mut sentences = vec![
        format!("{what}: {one} and {other} would lie {expected_sigma:.1} σ apart"),
        format!(
            "{} readings; C turns {:.0}°, γ {:.0}° in all; {} with the warm-up",
            day.readings,
            day.travel_c_deg,
            day.travel_gamma_deg,
            duration(day.total_s)
        ),
    ];
    sentences.extend(blocks);
    sentences.extend(day.notes.iter().cloned());
    let text = std::fs::read_to_string(&plan).map_err(|error| Failure::bad_input(format!("{plan}: {error}")))?;
    let bench = std::fs::read_to_string(&station).map_err(|error| Failure::bad_input(format!("{station}: {error}")))?;
    Ok(Shown {
        fingerprint: sha256(format!("{text}\0{bench}").as_bytes()),
        plan,
        station,
        sentences,
        text,
    })
}

/// The station file of the readings that were diagnosed: that of the job, or the one in the folder of the run that is
/// what the record says.
fn station(run: &Utf8Path) -> Result<Utf8PathBuf, Failure> {
    let observed = Case::of(run).observations.into_iter().find(|path| path.is_dir());
    let observed = observed.as_deref().unwrap_or(run);
    let wanted = RunHeader::read(observed).map_err(Failure::bad_input)?.station;
    let named = job(run).map(|job| job.station().to_owned());
    let beside = observed.parent().map_or(Vec::new(), |folder| {
        let here = folder::files(folder).into_iter().map(|name| folder.join(name));
        here.filter(|file| file.extension() == Some("toml")).collect()
    });
    let mut files = named.into_iter().chain(beside);
    files.find(|file| Station::load(file).is_ok_and(|station| station == wanted)).ok_or_else(|| {
        let built_in = init::virtual_station(&Choice::default())
            .is_ok_and(|(text, _)| Station::parse(Utf8Path::new("built-in"), &text).is_ok_and(|own| own == wanted));
        let help = if built_in {
            "the readings are of the built-in virtual darkroom: make a folder of it with `isolux init` and work there"
        } else {
            "put the station file beside the run"
        };
        Failure::bad_input(format!("no station file of the bench of {observed} is known")).help(help)
    })
}

/// Carries out the plan that [`shown`] gave, into `out`, and diagnoses all readings together; the diagnosis lies in the
/// results of `run`.
///
/// # Errors
/// As [`ScanJob::execute`] and [`crate::diagnosis::diagnose::run`].
pub fn carry_out(
    run: &Utf8Path,
    shown: &Shown,
    out: &Utf8Path,
    operator: Option<&dyn Operator>,
    control: &Control,
    progress: &dyn Progress,
) -> Result<(), Failure> {
    let mut case = Case::of(run);
    let (source, plan, _) = scan::checked(&shown.station, &shown.plan, operator.is_some())?;
    ScanJob {
        source: &source,
        plan: &plan,
        place: Place::take(Target::New(out), false)?,
        force: None,
        operator,
        control,
        progress,
    }
    .execute()?;
    case.observations.push(out.to_owned());
    case.diagnose(run, progress)
}
