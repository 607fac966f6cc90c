//! `isolux report`.

use camino::Utf8PathBuf;
use clap::Args;
use isolux_app::files::Overwrite;
use isolux_app::{Failure, day};

use crate::screen;

/// Writes the report of a reduced run as one HTML file.
#[derive(Debug, Args)]
#[command(after_help = "Example: isolux report run --out run.html")]
pub struct Report {
    /// The run directory.
    run: Utf8PathBuf,
    /// The HTML file to write.
    #[arg(long)]
    out: Utf8PathBuf,
    /// The job of a day that does not hold its own.
    #[arg(long)]
    job: Option<Utf8PathBuf>,
    /// Replace the file if it exists.
    #[arg(long)]
    force: bool,
}

/// Runs the command.
pub fn run(arguments: &Report) -> Result<(), Failure> {
    let overwrite = Overwrite::asked(arguments.force);
    let job = arguments.job.as_deref();
    day::report(&arguments.run, job, &arguments.out, overwrite, &screen::Bars::default())?;
    screen::say(&arguments.out)?;
    Ok(())
}
