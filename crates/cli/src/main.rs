//! The `isolux` command line: parses, calls one use case of `isolux-app`, prints, and exits with a documented code.

mod commands;
mod screen;

use std::process::ExitCode;

use clap::Parser;

use crate::commands::Command;

/// Drives a goniophotometer, writes photometric files, lights a sensor with them, finds where the two disagree.
#[derive(Debug, Parser)]
#[command(name = "isolux", version, propagate_version = true)]
#[command(
    after_help = "Exit codes: 0 done, 1 the answer is no, 2 bad usage or input (nothing written), \
3 an instrument or the system failed, 130 interrupted (axes stopped first)."
)]
struct Arguments {
    #[command(subcommand)]
    command: Command,
}

fn main() -> ExitCode {
    match commands::run(Arguments::parse().command) {
        Ok(()) => ExitCode::SUCCESS,
        Err(failure) => {
            screen::complain(&failure);
            ExitCode::from(failure.kind.exit_code())
        }
    }
}
