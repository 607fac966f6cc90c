//! `isolux scan`.

use camino::{Utf8Path, Utf8PathBuf};
use clap::Args;
use isolux_app::Failure;
use isolux_app::front_end::progress::{Event, Progress};
use isolux_app::scan::{self, Operator, Place, ScanJob, ScanSummary, Target, duration};

use super::serve::{self, Address};
use super::takeover::TakeOver;
use crate::screen::{self, Bars};
use crate::terminal::Terminal;

/// Carries out a plan: home, warm up, move, settle, read, record. The axes are stopped and verified on every exit.
#[derive(Debug, Args)]
#[command(after_help = "Example: isolux scan station.toml plan.toml --out run\n\
Broken off: isolux scan station.toml plan.toml --resume run\n\
At a terminal, `p` and Enter pauses after the point that is being read, and goes on; the lamp stays on.")]
pub struct Scan {
    /// The bench, STATION.toml.
    station: Utf8PathBuf,
    /// What to measure, PLAN.toml.
    plan: Utf8PathBuf,
    /// The run directory to write; it must not exist or be empty.
    #[arg(long, conflicts_with = "resume", required_unless_present = "resume")]
    out: Option<Utf8PathBuf>,
    /// Resume a run that broke off: no point twice, none lost.
    #[arg(long)]
    resume: Option<Utf8PathBuf>,
    /// With --resume, for a damaged record: keep what is whole, set damaged files aside, read again what is missing.
    #[arg(long, requires = "resume")]
    reread: bool,
    #[command(flatten)]
    takeover: TakeOver,
    /// Show the scan on the local page, in the browser.
    #[arg(long)]
    open: bool,
    #[command(flatten)]
    address: Address,
    /// Print the facts as JSON.
    #[arg(long)]
    json: bool,
}

/// Runs the command.
pub fn run(arguments: &Scan) -> Result<(), Failure> {
    let (path, target) = match (&arguments.out, &arguments.resume) {
        (_, Some(path)) if arguments.reread => (path, Target::Reread(path)),
        (_, Some(path)) => (path, Target::Resume(path)),
        (Some(path), None) => (path, Target::New(path)),
        (None, None) => return Err(Failure::bad_input("give --out RUN or --resume RUN")),
    };
    let terminal = Terminal::of_stdin();
    let mut control = terminal.control();
    let operator = terminal.operator();
    let operator = operator.as_ref().map(|operator| operator as &dyn Operator);
    if arguments.open {
        control.pace = arguments.address.pace();
    }
    let work = |progress: &dyn Progress| {
        let (source, plan, _) = scan::checked(&arguments.station, &arguments.plan, operator.is_some())?;
        for sentence in scan::plan::not_claimable(&source.station, &plan) {
            progress.event(Event::Note(&format!("not to be claimed of this scan: {sentence}")));
        }
        let force = arguments.takeover.reason();
        ScanJob {
            source: &source,
            plan: &plan,
            place: Place::take(target, force.is_some())?,
            force,
            operator,
            control: &control,
            progress,
        }
        .execute()
    };
    if arguments.open {
        let folder = path.parent().unwrap_or(Utf8Path::new("."));
        let (summary, page) = serve::beside(&arguments.address, folder, &control, work)?;
        say(arguments, &summary, path)?;
        return page.until_nobody_looks();
    }
    say(arguments, &work(&Bars::default())?, path)
}

fn say(arguments: &Scan, summary: &ScanSummary, path: &Utf8Path) -> Result<(), Failure> {
    if arguments.json {
        screen::say(serde_json::to_string(summary).map_err(Failure::instrument)?)?;
        return Ok(());
    }
    screen::say(format_args!(
        "{} points, {} readings, {} spectra in {} → {path}",
        summary.points,
        summary.readings,
        summary.spectra,
        duration(summary.duration_s)
    ))?;
    for (count, what) in [
        (
            summary.without_number,
            "readings have no number (over range, under range, failed)",
        ),
        (summary.unsettled, "points did not settle"),
        (summary.retries, "answers were lost or damaged and asked again"),
        (
            summary.visits_again,
            "visits were made again (an axis or output was not as it was left, or readings did not agree)",
        ),
    ] {
        if count > 0 {
            screen::say(format_args!("{count} {what}"))?;
        }
    }
    Ok(())
}
