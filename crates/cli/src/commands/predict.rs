//! `isolux predict`.

use camino::Utf8PathBuf;
use clap::Args;
use isolux_app::Failure;
use isolux_app::files::Overwrite;
use isolux_app::simulation::predict;

use crate::screen;

/// What a model says would be read: at goniometer readings, on sensor maps, of spectra.
#[derive(Debug, Args)]
#[command(
    after_help = "Example: isolux predict luminaire.model.toml run/readings.csv --out predicted.csv\n\
The coordinates are written again, in their order, with predicted_illuminance_lx, predicted_signal or predicted_value."
)]
pub struct Predict {
    /// The model, MODEL.toml.
    model: Utf8PathBuf,
    /// Where to predict: a run directory, a readings CSV, a maps.toml or a spectra.toml.
    observations: Utf8PathBuf,
    /// The CSV file to write.
    #[arg(long)]
    out: Utf8PathBuf,
    /// Print what was predicted as JSON.
    #[arg(long)]
    json: bool,
    /// Replace the file if it exists.
    #[arg(long)]
    force: bool,
}

/// Runs the command.
pub fn run(arguments: &Predict) -> Result<(), Failure> {
    let overwrite = Overwrite::requested(arguments.force);
    let predicted = predict::run(&arguments.model, &arguments.observations, &arguments.out, overwrite)?;
    if arguments.json {
        screen::say(serde_json::to_string(&predicted).map_err(Failure::instrument)?)?;
        return Ok(());
    }
    screen::say(format_args!(
        "{} rows of {} → {}",
        predicted.rows, predicted.kind, arguments.out
    ))?;
    for notice in &predicted.notices {
        screen::say(format_args!("note: {notice}"))?;
    }
    if !predicted.effects_applied.is_empty() {
        screen::say(format_args!(
            "effects applied: {}",
            predicted.effects_applied.join(", ")
        ))?;
    }
    if !predicted.effects_not_applicable.is_empty() {
        screen::say(format_args!(
            "effects that do not act on {}: {}",
            predicted.kind,
            predicted.effects_not_applicable.join(", ")
        ))?;
    }
    Ok(())
}
