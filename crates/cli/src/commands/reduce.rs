//! `isolux reduce`.

use camino::Utf8PathBuf;
use clap::Args;
use isolux_app::files::Overwrite;
use isolux_app::{Failure, reduce};

use crate::screen;

/// Turns the record of a scan into distribution, spectrum, files and uncertainty budget.
#[derive(Debug, Args)]
#[command(after_help = "Example: isolux reduce run --without drift --out run/without-drift\n\
Corrections: dark, ambient, stray, inverse_square, drift, spectral_dark, smoothing.")]
pub struct Reduce {
    /// The run directory.
    run: Utf8PathBuf,
    /// Folder for the results; without it RUN/results.
    #[arg(long)]
    out: Option<Utf8PathBuf>,
    /// A correction to leave out; may be given several times.
    #[arg(long, value_name = "CORRECTION", num_args = 1..)]
    without: Vec<String>,
    /// A model whose bench effects are taken out of the readings.
    #[arg(long, value_name = "MODEL.toml")]
    with: Option<Utf8PathBuf>,
    /// Print the budget as JSON.
    #[arg(long)]
    json: bool,
    /// Replace results that exist.
    #[arg(long)]
    force: bool,
}

/// Runs the command.
pub fn run(arguments: &Reduce) -> Result<(), Failure> {
    let overwrite = Overwrite::asked(arguments.force);
    let reduced = reduce::run(
        &arguments.run,
        arguments.out.as_deref(),
        &arguments.without,
        arguments.with.as_deref(),
        overwrite,
    )?;
    if arguments.json {
        screen::say(String::from_utf8_lossy(&isolux_app::files::read(&reduced.folder.join("budget.json"))?).trim_end());
        return Ok(());
    }
    for line in reduced.sentences() {
        screen::say(line);
    }
    Ok(())
}
