//! `isolux run`.

use camino::{Utf8Path, Utf8PathBuf};
use clap::Args;
use isolux_app::front_end::progress::Progress;
use isolux_app::init::DayPlan;
use isolux_app::{Failure, day};

use super::serve::{self, Address};
use super::takeover::TakeOver;
use crate::screen;
use crate::terminal::Terminal;

/// The whole day: check, warm up, scan, reduce, simulate, compare, diagnose, report.
#[derive(Debug, Args)]
#[command(after_help = "Example: isolux run --out day\n\
Without a job the built-in virtual darkroom plays the day in virtual time, in under a minute. `isolux init DIR` writes a job \
to start from; `isolux run DIR/job.toml --out day` runs it. A day that was interrupted goes on with `isolux run --resume day`.")]
pub struct Run {
    /// The job: station, plan, scene.
    job: Option<Utf8PathBuf>,
    /// Plan of the built-in virtual darkroom: at the distance that `isolux plan` proposes (default), or the published
    /// one at 10 m.
    #[arg(long, value_parser = ["near", "published-10m"], conflicts_with_all = ["job", "resume"])]
    plan: Option<String>,
    /// Folder of the day; without it a fresh one beside where you are.
    #[arg(long)]
    out: Option<Utf8PathBuf>,
    /// Take up a day that broke off: what its scan lacks is measured, and all results are made anew.
    #[arg(long, value_name = "DIR", conflicts_with = "out")]
    resume: Option<Utf8PathBuf>,
    /// With --resume, for a damaged record: keep what is whole, set damaged files aside, read again what is missing.
    #[arg(long, requires = "resume")]
    reread: bool,
    #[command(flatten)]
    takeover: TakeOver,
    /// Accept a drift, an unstable reference or a closing half-plane beyond the plan's limits; every result says so.
    #[arg(long, value_name = "REASON", num_args = 0..=1, require_equals = true, default_missing_value = "")]
    accept_drift: Option<String>,
    /// With --resume: why a report that was issued is made again; the one before is kept, the new one says what
    /// changed.
    #[arg(long, value_name = "REASON", requires = "resume")]
    amend: Option<String>,
    /// Show the day on the local page, in the browser: the scan while it runs, the report at the end.
    #[arg(long)]
    open: bool,
    #[command(flatten)]
    address: Address,
}

/// Runs the command.
pub fn run(arguments: &Run) -> Result<(), Failure> {
    let requested = day::Options {
        job: arguments.job.clone(),
        plan: arguments.plan.as_deref().and_then(DayPlan::named).unwrap_or_default(),
        out: arguments.resume.clone().or_else(|| arguments.out.clone()),
        resume: arguments.resume.is_some(),
        reread: arguments.reread,
        force: arguments.takeover.reason().map(str::to_owned),
        accept_drift: arguments.accept_drift.clone(),
        amend: arguments.amend.clone(),
    };
    let terminal = Terminal::of_stdin();
    let mut control = terminal.control();
    let operator = terminal.operator();
    let operator = operator
        .as_ref()
        .map(|operator| operator as &dyn isolux_app::scan::Operator);
    if !arguments.open {
        return say(&day::run(&requested, operator, &control, &screen::Bars::default())?);
    }
    control.pace = arguments.address.pace();
    let folder = requested.out.as_deref().and_then(Utf8Path::parent);
    let folder = folder
        .filter(|folder| !folder.as_str().is_empty())
        .unwrap_or(Utf8Path::new("."));
    let work = |progress: &dyn Progress| day::run(&requested, operator, &control, progress);
    let (day, page) = serve::beside(&arguments.address, folder, &control, work)?;
    say(&day)?;
    page.until_nobody_looks()
}

fn say(day: &day::Day) -> Result<(), Failure> {
    for sentence in &day.sentences {
        screen::say(sentence)?;
    }
    screen::say(format_args!("results               {}", day.folder.join("results")))?;
    screen::say(format_args!("report                {}", day.report))
}
