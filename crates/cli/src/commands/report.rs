//! `isolux report`.

use camino::Utf8PathBuf;
use clap::Args;
use isolux_app::files::Overwrite;
use isolux_app::{Failure, day};

use crate::screen;

/// Writes the report of a reduced run as one HTML file, or as PDF.
#[derive(Debug, Args)]
#[command(
    after_help = "Examples:\n  isolux report run --out run.html\n  isolux report run --pdf\n  isolux report run --pdf --out run.pdf"
)]
pub struct Report {
    /// The run directory.
    run: Utf8PathBuf,
    /// The file to write; without it report.html or report.pdf among the results. The report of a scan that is not
    /// finished has `partial` in its name.
    #[arg(long)]
    out: Option<Utf8PathBuf>,
    /// PDF on A4, with its fonts, in place of HTML.
    #[arg(long)]
    pdf: bool,
    /// The job of a day that does not hold its own.
    #[arg(long)]
    job: Option<Utf8PathBuf>,
    /// The data sheet of one page in place of the report.
    #[arg(long, conflicts_with_all = ["amend", "parts"])]
    data_sheet: bool,
    /// A folder for every figure as SVG and PNG and every table as CSV, in place of the report.
    #[arg(long, value_name = "DIR", conflicts_with_all = ["amend", "out", "pdf"])]
    parts: Option<Utf8PathBuf>,
    /// Replace the file if it exists.
    #[arg(long)]
    force: bool,
    /// Amend the report among the results: the one before is kept, and the new one says what changed and why. What the
    /// job states is changed by `isolux run JOB --resume DAY --amend REASON`.
    #[arg(long, value_name = "REASON", conflicts_with_all = ["out", "pdf", "job"])]
    amend: Option<String>,
}

/// Runs the command.
pub fn run(arguments: &Report) -> Result<(), Failure> {
    let overwrite = Overwrite::requested(arguments.force || arguments.amend.is_some());
    let job = arguments.job.as_deref();
    let progress = screen::Bars::default();
    let out = arguments.out.as_deref();
    if let Some(folder) = &arguments.parts {
        let count = day::parts(&arguments.run, job, folder, overwrite, &progress)?;
        return screen::say(format_args!("{count} files in {folder}"));
    }
    if arguments.data_sheet {
        let out = day::data_sheet(&arguments.run, job, out, arguments.pdf, overwrite, &progress)?;
        return screen::say(out);
    }
    let amend = arguments.amend.as_deref();
    let out = day::report(&arguments.run, job, out, arguments.pdf, amend, overwrite, &progress)?;
    screen::say(out)?;
    Ok(())
}
