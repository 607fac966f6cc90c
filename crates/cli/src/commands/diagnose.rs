//! `isolux diagnose`.

use camino::Utf8PathBuf;
use clap::Args;
use isolux_app::Failure;
use isolux_app::diagnosis::diagnose;
use isolux_app::files::Overwrite;

use crate::screen;

/// Where a model and a measurement disagree, which physical effect is missing, and the model that has it.
#[derive(Debug, Args)]
#[command(after_help = "Example: isolux diagnose luminaire.model.toml run --out diagnosis\n\
Writes diagnosis.json, report.html, model.baseline.toml and model.after.toml with the files that they name.\n\
Exit code 1: structure is left that no effect in the catalogue makes.")]
pub struct Diagnose {
    /// The model, MODEL.toml.
    model: Utf8PathBuf,
    /// Run directories, readings CSVs, maps.toml or spectra.toml files; several are fitted together.
    #[arg(required = true)]
    observations: Vec<Utf8PathBuf>,
    /// The folder to write.
    #[arg(long)]
    out: Utf8PathBuf,
    /// Observations that are predicted but never fitted; without them whole planes, maps and dark blocks are kept back.
    #[arg(long)]
    held_out: Option<Utf8PathBuf>,
    /// Seed of the simulated scans.
    #[arg(long, default_value_t = 1)]
    seed: u64,
    /// Adopt the effects: write the next version of the model (`.v2` before the extension) beside it.
    #[arg(long)]
    accept: bool,
    /// Print diagnosis.json instead of words.
    #[arg(long)]
    json: bool,
    /// Replace files that exist.
    #[arg(long)]
    force: bool,
}

/// Runs the command.
pub fn run(arguments: &Diagnose) -> Result<(), Failure> {
    let request = diagnose::DiagnoseRequest {
        model: arguments.model.clone(),
        observations: arguments.observations.clone(),
        out: arguments.out.clone(),
        held_out: arguments.held_out.clone(),
        seed: arguments.seed,
        accept: arguments.accept,
        overwrite: Overwrite::requested(arguments.force),
    };
    let answer = diagnose::run(&request, &screen::Bars::default())?;
    if arguments.json {
        screen::say(serde_json::to_string_pretty(&answer.document).map_err(Failure::instrument)?)?;
    } else {
        diagnose::brief(&answer, &arguments.out)
            .into_iter()
            .try_for_each(screen::say)?;
    }
    if answer.document.verdict == diagnose::Verdict::Unexplained {
        return Err(Failure::no(&answer.document.sentence)
            .help("look at the residuals along that coordinate in report.html, and repeat that part of the plan"));
    }
    Ok(())
}
