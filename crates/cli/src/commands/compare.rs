//! `isolux compare`.

use camino::Utf8PathBuf;
use clap::Args;
use isolux_app::files::Overwrite;
use isolux_app::{Failure, compare};

use crate::screen;

/// Two or more distributions or runs: how they differ, and whether they agree within their uncertainties.
#[derive(Debug, Args)]
#[command(after_help = "Example: isolux compare day day-2 --out comparison\n\
         isolux compare catalogue.ldt measured.ldt --tolerance 5 --shape\n\
Runs are judged by their own uncertainties (En, U with k = 2), files by --tolerance; without either nothing is judged. \
Exit 1 where something that is judged does not agree.")]
pub struct Compare {
    /// Photometric files, model.toml or run directories; the first is what the others are compared with.
    #[arg(required = true, num_args = 2..)]
    items: Vec<Utf8PathBuf>,
    /// Difference in per cent that is allowed where an uncertainty is not known.
    #[arg(long, value_name = "PERCENT")]
    tolerance: Option<f64>,
    /// Compare shapes alone: each distribution is scaled to the flux of the first.
    #[arg(long)]
    shape: bool,
    /// Folder for comparison.json and figures.
    #[arg(long, value_name = "DIR")]
    out: Option<Utf8PathBuf>,
    /// Print comparison.json.
    #[arg(long)]
    json: bool,
    /// Replace files that exist.
    #[arg(long, requires = "out")]
    force: bool,
}

/// Runs the command.
pub fn run(arguments: &Compare) -> Result<(), Failure> {
    let request = compare::Request {
        items: &arguments.items,
        tolerance_rel: arguments.tolerance.map(|percent| 0.01 * percent),
        shape: arguments.shape,
        out: arguments.out.as_deref(),
        overwrite: Overwrite::requested(arguments.force),
    };
    let (compared, written) = compare::run(&request)?;
    if arguments.json {
        screen::say(serde_json::to_string_pretty(&compared).map_err(Failure::instrument)?)?;
    } else {
        compared.stated().iter().try_for_each(screen::say)?;
        written.iter().try_for_each(screen::say)?;
    }
    match compared.agree {
        Some(false) => Err(Failure::no("they do not agree")),
        _ => Ok(()),
    }
}
