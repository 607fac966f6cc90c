//! The `isolux` command line: parses, calls one use case of `isolux-app`, prints, and exits with a documented code. The
//! program and the Python package both run it.

mod commands;
mod screen;
mod terminal;

use std::ffi::OsString;

use clap::{CommandFactory, FromArgMatches, Parser};
use isolux_app::system::{log, signals};
use isolux_app::{Failure, FailureKind};

use crate::commands::Command;

/// Drives a goniophotometer, writes photometric files, lights a sensor with them, finds where the two disagree.
#[derive(Debug, Parser)]
#[command(name = "isolux", version, propagate_version = true)]
#[command(
    after_help = "Exit codes: 0 done, 1 the answer is no, 2 bad usage or input (nothing written), \
3 an instrument or the system failed, 130 interrupted (axes stopped first), 141 the reader of standard output closed it."
)]
struct Arguments {
    /// Log to standard error what drivers do; twice: the bytes of every link too. ISOLUX_LOG chooses more finely.
    #[arg(short, long, global = true, action = clap::ArgAction::Count)]
    verbose: u8,
    /// Let the computer go to sleep while axes move or a scan runs; without this it is kept awake.
    #[arg(long, global = true)]
    let_sleep: bool,
    #[command(subcommand)]
    command: Command,
}

/// Runs the command line `words`, the name of the program first, and gives the exit code of `--help`.
pub fn run(words: impl IntoIterator<Item = OsString>) -> u8 {
    // `--rays -5` is a number that is refused by what it means, not an unknown option.
    let command = Arguments::command().mut_subcommands(|command| command.allow_negative_numbers(true));
    let parsed = command
        .try_get_matches_from(words)
        .and_then(|matches| Arguments::from_arg_matches(&matches));
    let arguments = match parsed {
        Ok(arguments) => arguments,
        Err(described) => return explained(&described),
    };
    signals::otherwise(|name| {
        let message = format!("interrupted ({name}); every file that was written is complete");
        let failure = Failure {
            kind: FailureKind::Interrupted,
            message,
            help: None,
        };
        screen::report_failure(&failure);
        std::process::exit(i32::from(failure.kind.exit_code()));
    });
    if arguments.let_sleep {
        isolux_app::system::keep_awake::let_sleep();
    }
    let directives = std::env::var(log::VARIABLE).ok();
    let began = log::begin(arguments.verbose, directives.as_deref());
    match began.and_then(|()| commands::run(arguments.command)) {
        Ok(()) => 0,
        Err(failure) => {
            screen::report_failure(&failure);
            failure.kind.exit_code()
        }
    }
}

/// Help, version, or what is wrong with the command line.
fn explained(described: &clap::Error) -> u8 {
    // The codes of clap are 0 and 2.
    let code = u8::try_from(described.exit_code()).unwrap_or(2);
    match described.print() {
        Err(error) if !described.use_stderr() => {
            let failure = screen::unwritten(&error);
            screen::report_failure(&failure);
            failure.kind.exit_code()
        }
        _ => code,
    }
}
