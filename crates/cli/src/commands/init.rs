//! `isolux init`.

use camino::Utf8PathBuf;
use clap::Args;
use isolux_app::files::Overwrite;
use isolux_app::{Failure, init};

use crate::screen;

/// A station, plan, scene and job file to start from, commented; they run as they are, in the virtual darkroom.
#[derive(Debug, Args)]
#[command(after_help = "Example: isolux init bench && isolux scan bench/station.toml bench/plan.toml --out bench/run")]
pub struct Init {
    /// The folder to write into.
    folder: Utf8PathBuf,
    /// Print the names as JSON.
    #[arg(long)]
    json: bool,
    /// Replace files that exist.
    #[arg(long)]
    force: bool,
}

/// Runs the command.
pub fn run(arguments: &Init) -> Result<(), Failure> {
    let overwrite = Overwrite::asked(arguments.force);
    let written = init::run(&arguments.folder, overwrite)?;
    if arguments.json {
        screen::say(serde_json::json!({ "written": written }));
    } else {
        written.iter().for_each(screen::say);
    }
    Ok(())
}
