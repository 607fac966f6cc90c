//! `isolux investigate`.

use std::io::IsTerminal;

use camino::Utf8PathBuf;
use clap::Args;
use isolux_app::Failure;
use isolux_app::diagnosis::{diagnose, investigate};
use isolux_app::scan::Operator;

use super::takeover::TakeOver;
use crate::screen::{self, Bars};
use crate::terminal::Terminal;

/// Diagnose, carry out the measurement that would settle the answer, diagnose again. Asks before it moves anything.
#[derive(Debug, Args)]
#[command(after_help = "Example: isolux investigate station.toml luminaire.model.toml run --out investigation")]
pub struct Investigate {
    /// The bench, STATION.toml.
    station: Utf8PathBuf,
    /// The model, MODEL.toml.
    model: Utf8PathBuf,
    /// The run to begin with.
    run: Utf8PathBuf,
    /// The folder for diagnoses and further runs.
    #[arg(long)]
    out: Utf8PathBuf,
    /// At most so many further measurements.
    #[arg(long, default_value_t = 3)]
    rounds: usize,
    /// Seed of the simulated scans.
    #[arg(long, default_value_t = 1)]
    seed: u64,
    /// Move without asking.
    #[arg(long)]
    yes: bool,
    #[command(flatten)]
    takeover: TakeOver,
    /// Print the last diagnosis.json instead of words.
    #[arg(long)]
    json: bool,
}

/// Runs the command.
pub fn run(arguments: &Investigate) -> Result<(), Failure> {
    if !arguments.yes && !std::io::stdin().is_terminal() {
        return Err(
            Failure::bad_input("investigate asks before it moves the axes, and nobody is at the terminal")
                .help("run it at a terminal, or give --yes"),
        );
    }
    let requested = investigate::Investigation {
        station: arguments.station.clone(),
        model: arguments.model.clone(),
        run: arguments.run.clone(),
        out: arguments.out.clone(),
        rounds: arguments.rounds,
        seed: arguments.seed,
        force: arguments.takeover.reason().map(str::to_owned),
    };
    let terminal = Terminal::of_stdin();
    let person = terminal.operator();
    let person = person.as_ref().map(|operator| operator as &dyn Operator);
    let go = |question: &str| arguments.yes || asks(question, &terminal);
    let (answer, runs) = investigate::run(&requested, person, &go, &terminal.control(), &Bars::default())?;
    if arguments.json {
        screen::say(serde_json::to_string_pretty(&answer.document).map_err(Failure::instrument)?)?;
    } else {
        let names: Vec<&str> = runs.iter().map(|run| run.as_str()).collect();
        diagnose::brief(&answer, &arguments.out)
            .into_iter()
            .try_for_each(screen::say)?;
        screen::say(format_args!("from {}", names.join(", ")))?;
    }
    if answer.document.verdict == diagnose::Verdict::Unexplained {
        return Err(Failure::no(&answer.document.sentence));
    }
    Ok(())
}

fn asks(question: &str, terminal: &Terminal) -> bool {
    let answer = terminal.line(&format!("\n{question} [y/N] "));
    answer.is_ok_and(|answer| matches!(answer.trim(), "y" | "Y" | "yes"))
}
