//! `isolux history`.

use camino::Utf8PathBuf;
use clap::Args;
use isolux_app::files::Overwrite;
use isolux_app::{Failure, history};

use crate::screen;

/// Control charts of what calibrations and days found at a bench: what has drifted, and since when.
#[derive(Debug, Args)]
#[command(after_help = "Example: isolux history station.toml --out charts\n\
`isolux calibrate` and `isolux run` add lines to history.jsonl beside the station. Limits (mean ± 2 s \
warning, ± 3 s action) come from the first five values. Exit 1: a value is beyond the limits of action, or eight in \
a row lie on one side of the mean.")]
pub struct History {
    /// The bench, STATION.toml.
    station: Utf8PathBuf,
    /// Folder for the charts as pictures.
    #[arg(long)]
    out: Option<Utf8PathBuf>,
    /// Print the charts as JSON.
    #[arg(long)]
    json: bool,
    /// Replace pictures that exist.
    #[arg(long)]
    force: bool,
}

/// Runs the command.
pub fn run(arguments: &History) -> Result<(), Failure> {
    let overwrite = Overwrite::requested(arguments.force);
    let (charts, written) = history::charts(&arguments.station, arguments.out.as_deref(), overwrite)?;
    if arguments.json {
        screen::say(serde_json::to_string_pretty(&charts).map_err(Failure::instrument)?)?;
    } else {
        charts.iter().try_for_each(|chart| screen::say(&chart.sentence))?;
        written.iter().try_for_each(screen::say)?;
    }
    let out: Vec<&str> = (charts.iter().filter(|chart| chart.out_of_control))
        .map(|chart| chart.quantity.as_str())
        .collect();
    if out.is_empty() {
        return Ok(());
    }
    Err(Failure::no(format!("not in control: {}", out.join(", ")))
        .help("look at instrument and lamp, calibrate again; results since then need another look"))
}
