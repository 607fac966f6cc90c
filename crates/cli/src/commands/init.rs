//! `isolux init`.

use camino::Utf8PathBuf;
use clap::Args;
use isolux_app::files::Overwrite;
use isolux_app::{Failure, init};

use super::twins::Played;
use crate::screen;

/// A station, plan, scene and job file to start from, commented; they run as they are, in the virtual darkroom.
#[derive(Debug, Args)]
#[command(
    after_help = "Examples:\n  isolux init bench && isolux scan bench/station.toml bench/plan.toml --out bench/run\n  \
isolux init --room room.toml      the whole built-in virtual darkroom, every key of it, to change\n\
A room file may leave keys out: those are the built-in room's, and the commands that read it say which."
)]
pub struct Init {
    /// The folder to write into.
    #[arg(required_unless_present = "room")]
    folder: Option<Utf8PathBuf>,
    /// Write the whole built-in virtual darkroom to FILE (`-` prints it).
    #[arg(long, value_name = "FILE")]
    room: Option<Utf8PathBuf>,
    /// Plan of the day: at the distance that `isolux plan` proposes, or the published one at 10 m.
    #[arg(long, default_value = "published-10m", value_parser = ["near", "published-10m"])]
    plan: String,
    /// Print the names as JSON.
    #[arg(long, conflicts_with = "room")]
    json: bool,
    /// Replace files that exist.
    #[arg(long)]
    force: bool,
    #[command(flatten)]
    played: Played,
}

/// Runs the command.
pub fn run(arguments: &Init) -> Result<(), Failure> {
    let overwrite = Overwrite::asked(arguments.force);
    let room = arguments.room.as_ref().filter(|room| *room != "-");
    if let Some(room) = room {
        // Before the folder's files are written: all of them or none.
        isolux_app::files::refuse_existing(room, overwrite)?;
    }
    let mut written = match &arguments.folder {
        Some(folder) => init::run(
            folder,
            init::DayPlan::named(&arguments.plan).unwrap_or_default(),
            &arguments.played.instruments(),
            overwrite,
        )?,
        None => Vec::new(),
    };
    match (room, &arguments.room) {
        (Some(room), _) => {
            init::room(room, overwrite)?;
            written.push(room.clone());
        }
        (None, Some(_)) => screen::say(init::ROOM.trim_end())?,
        (None, None) => {}
    }
    if arguments.json {
        return screen::say(serde_json::json!({ "written": written }));
    }
    written.iter().try_for_each(screen::say)
}
