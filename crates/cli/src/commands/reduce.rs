//! `isolux reduce`.

use camino::Utf8PathBuf;
use clap::Args;
use isolux_app::Failure;
use isolux_app::files::Overwrite;
use isolux_app::run::{monte_carlo, reduce};

use crate::screen;

/// Turns the record of a scan into distribution, spectrum, files and uncertainty budget.
#[derive(Debug, Args)]
#[command(after_help = "Example: isolux reduce run --without drift --out run/without-drift\n\
Corrections: dark, ambient, stray, spectral_mismatch, linearity, temperature, cosine, fatigue, inverse_square, drift, \
spectral_dark, wavelengths, bandpass, scatter, spectral_linearity, smoothing. A number carries ± only where every \
part of its uncertainty was measured or is stated by the station; else it says what is missing. Exit 1: lamp or bench \
did not stay as they were (limits of the plan), and nothing was written.")]
pub struct Reduce {
    /// The run directory.
    run: Utf8PathBuf,
    /// Folder for the results; without it RUN/results, or RUN/results-partial where the scan is not finished.
    #[arg(long)]
    out: Option<Utf8PathBuf>,
    /// A correction to leave out; may be given several times.
    #[arg(long, value_name = "CORRECTION", num_args = 1..)]
    without: Vec<String>,
    /// A model whose bench effects are taken out of the readings.
    #[arg(long, value_name = "MODEL.toml")]
    with: Option<Utf8PathBuf>,
    /// Accept a drift, an unstable reference or a closing half-plane beyond the plan's limits; every result says so.
    #[arg(long, value_name = "REASON", num_args = 0..=1, require_equals = true, default_missing_value = "")]
    accept_drift: Option<String>,
    /// Draw the inputs of the record so many times, reduce each record, and print the budget beside the draws; nothing
    /// is written.
    #[arg(long, value_name = "DRAWS", conflicts_with_all = ["out", "with", "accept_drift", "force"])]
    monte_carlo: Option<u64>,
    /// Print the budget as JSON.
    #[arg(long)]
    json: bool,
    /// Replace results that exist.
    #[arg(long)]
    force: bool,
}

/// Runs the command.
pub fn run(arguments: &Reduce) -> Result<(), Failure> {
    if let Some(draws) = arguments.monte_carlo {
        let drawn = monte_carlo::run(&arguments.run, &arguments.without, draws, &screen::Bars::default())?;
        if arguments.json {
            return screen::say(serde_json::to_string_pretty(&drawn).map_err(Failure::instrument)?);
        }
        return drawn.sentences().iter().try_for_each(screen::say);
    }
    let overwrite = Overwrite::requested(arguments.force);
    let reduced = reduce::run(
        &arguments.run,
        &reduce::ReduceRequest {
            out: arguments.out.as_deref(),
            without: &arguments.without,
            with: arguments.with.as_deref(),
            accept_drift: arguments.accept_drift.as_deref(),
            subject: None,
        },
        overwrite,
    )?;
    if arguments.json {
        screen::say(
            String::from_utf8_lossy(&isolux_app::files::read(&reduced.folder.join("budget.json"))?).trim_end(),
        )?;
        return Ok(());
    }
    for line in reduced.sentences() {
        screen::say(line)?;
    }
    Ok(())
}
