//! `isolux check`.

use camino::Utf8PathBuf;
use clap::Args;
use isolux_app::Failure;
use isolux_app::files::Overwrite;
use isolux_app::instruments::check;

use super::takeover::TakeOver;
use crate::screen;

/// Talks to every instrument: identity, limits, dark. Moves no axis.
#[derive(Debug, Args)]
#[command(after_help = "Example: isolux check station.toml --record trace.txt")]
pub struct Check {
    /// The bench, STATION.toml.
    station: Utf8PathBuf,
    /// Write every byte on the links to this file.
    #[arg(long, value_name = "FILE")]
    record: Option<Utf8PathBuf>,
    /// Print the facts as JSON.
    #[arg(long)]
    json: bool,
    /// Replace the file of --record if it exists.
    #[arg(long, requires = "record")]
    overwrite: bool,
    #[command(flatten)]
    takeover: TakeOver,
}

/// Runs the command.
pub fn run(arguments: &Check) -> Result<(), Failure> {
    let overwrite = Overwrite::requested(arguments.overwrite);
    let force = arguments.takeover.reason();
    let report = check::run(
        &arguments.station,
        arguments.record.as_deref(),
        overwrite,
        force,
        &screen::Bars::default(),
    )?;
    if arguments.json {
        screen::say(serde_json::to_string(&report).map_err(Failure::instrument)?)?;
    } else {
        for found in &report.instruments {
            let state = if found.ok { "ok" } else { "FAILED" };
            let identity = found.identity.as_deref().unwrap_or("no answer");
            screen::say(format_args!("{:<18}{state:<8}{identity}", found.role))?;
            found
                .facts
                .iter()
                .try_for_each(|fact| screen::say(format_args!("{:<26}{fact}", "")))?;
            if let Some(error) = &found.error {
                screen::say(format_args!("{:<26}{error}", ""))?;
            }
        }
    }
    if report.all_well() {
        return Ok(());
    }
    let failed: Vec<&str> = report
        .instruments
        .iter()
        .filter(|found| !found.ok)
        .map(|found| found.role)
        .collect();
    Err(Failure::instrument(format!(
        "{} did not answer as it should",
        failed.join(", ")
    )))
}
