//! One module a command: its arguments, its call, its words on the screen.

mod convert;
mod inspect;
mod predict;
mod reading;
mod twins;

use clap::Subcommand;
use isolux_app::Failure;

/// Everything that `isolux` can be told to do. One line a command here, one arm in [`run`].
#[derive(Debug, Subcommand)]
pub enum Command {
    Convert(convert::Convert),
    Inspect(inspect::Inspect),
    Predict(predict::Predict),
    Virtual(twins::Virtual),
}

/// Runs one command to its end.
///
/// # Errors
/// What the use case answers; its kind is the exit code.
pub fn run(command: Command) -> Result<(), Failure> {
    match command {
        Command::Convert(arguments) => convert::run(&arguments),
        Command::Inspect(arguments) => inspect::run(&arguments),
        Command::Predict(arguments) => predict::run(&arguments),
        Command::Virtual(arguments) => twins::run(&arguments),
    }
}
