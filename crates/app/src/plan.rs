//! `plan`: what a plan asks of a station, before anything moves.

use camino::Utf8Path;
use isolux_record::Plan;
use isolux_record::document::{self, Fault};
use isolux_scan::{DryRun, dry_run};

use crate::Failure;
use crate::bench::Source;

/// The dry run of a plan file on a station file.
///
/// # Errors
/// Bad input (exit 2) with file and line: also for a plan outside the limits of the axes.
pub fn run(station: &Utf8Path, plan: &Utf8Path) -> Result<DryRun, Failure> {
    let source = Source::load(station)?;
    let (parsed, text) = load(plan)?;
    dry_run(&source.station, &parsed).map_err(|fault| located(plan, &text, &fault))
}

/// A plan and its text.
///
/// # Errors
/// Bad input (exit 2) with file and line.
pub(crate) fn load(file: &Utf8Path) -> Result<(Plan, String), Failure> {
    let text = document::read_text(file).map_err(Failure::bad_input)?;
    let plan = Plan::parse(file, &text).map_err(Failure::bad_input)?;
    Ok((plan, text))
}

/// A fault of the dry run, with the plan's line.
pub(crate) fn located(file: &Utf8Path, text: &str, fault: &Fault) -> Failure {
    Failure::bad_input(document::Source { file, text }.locate(fault)).help("nothing was moved and nothing was written")
}
