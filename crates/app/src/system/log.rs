//! The log: what drivers and links say while they work, for a person who looks for a fault.
//!
//! Standard error shows what was asked for (`--verbose`, `ISOLUX_LOG`); a run keeps `log.txt` in its folder. No number
//! is computed from it, so a log that cannot be written stops nothing.

use std::fs::File;
use std::io::{self, Write};
use std::sync::{Mutex, PoisonError};

use camino::Utf8Path;
use tracing_subscriber::filter::Targets;
use tracing_subscriber::layer::{Layer, SubscriberExt};
use tracing_subscriber::util::{SubscriberInitExt, TryInitError};

use crate::Failure;

/// Name of the variable that says what is logged.
pub const VARIABLE: &str = "ISOLUX_LOG";

/// The file of the run that is being scanned.
static RUN: Mutex<Option<File>> = Mutex::new(None);

/// Begins to log: to standard error with level `verbosity` (0 nothing, 1 requests and retries, 2 the bytes of every
/// link), or by `directives` (`debug`, `isolux_transport=trace`, …), which take precedence.
///
/// # Errors
/// Bad input (exit 2) for directives that are none.
pub fn begin(verbosity: u8, directives: Option<&str>) -> Result<(), Failure> {
    let level = |level: &str| format!("isolux={level}");
    let wanted = match (directives.filter(|text| !text.trim().is_empty()), verbosity) {
        // A level alone is meant for this program, not for its libraries.
        (Some(text), _) if text.parse::<tracing_subscriber::filter::LevelFilter>().is_ok() => level(text),
        (Some(text), _) => text.to_owned(),
        (None, 0) => "off".to_owned(),
        (None, 1) => level("debug"),
        (None, _) => level("trace"),
    };
    let filter = |text: &str| {
        text.parse::<Targets>().map_err(|error| {
            Failure::bad_input(format!("{VARIABLE}={text}: {error}"))
                .help("for example ISOLUX_LOG=debug, ISOLUX_LOG=trace or ISOLUX_LOG=isolux_transport=trace")
        })
    };
    let screen = tracing_subscriber::fmt::layer()
        .with_writer(io::stderr)
        .with_ansi(false)
        .log_internal_errors(false)
        .with_filter(filter(&wanted)?);
    let in_run = if wanted == "off" {
        level("debug")
    } else {
        format!("isolux=debug,{wanted}")
    };
    let file = tracing_subscriber::fmt::layer()
        .with_writer(|| RunLog)
        .with_ansi(false)
        .log_internal_errors(false)
        .with_filter(filter(&in_run)?);
    let begun: Result<(), TryInitError> = tracing_subscriber::registry().with(screen).with(file).try_init();
    begun.map_err(Failure::instrument)
}

/// From now on `log.txt` in the folder of a run takes the log too, until [`leave_run`].
pub(crate) fn keep_in(run: &Utf8Path) {
    let opened = File::options().create(true).append(true).open(run.join("log.txt"));
    if let Err(error) = &opened {
        tracing::warn!(%run, %error, "the run keeps no log");
    }
    *RUN.lock().unwrap_or_else(PoisonError::into_inner) = opened.ok();
}

/// The run is over.
pub(crate) fn leave_run() {
    *RUN.lock().unwrap_or_else(PoisonError::into_inner) = None;
}

/// Writes to the file of the run, if there is one.
struct RunLog;

impl Write for RunLog {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        if let Some(file) = &mut *RUN.lock().unwrap_or_else(PoisonError::into_inner) {
            file.write_all(bytes)?;
        }
        Ok(bytes.len())
    }

    fn flush(&mut self) -> io::Result<()> {
        Ok(())
    }
}
