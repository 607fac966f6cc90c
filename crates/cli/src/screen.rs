//! Words for people: results on standard output, everything else on standard error.

use std::cell::RefCell;
use std::io::Write;
use std::time::Duration;

use indicatif::{ProgressBar, ProgressStyle};
use isolux_app::front_end::progress::{Event, Progress};
use isolux_app::{Failure, FailureKind};

/// Prints a line of results to standard output.
///
/// # Errors
/// Exit 3 when it takes no more (a full disk); the quiet [`FailureKind::Closed`] when its reader went (`isolux … |
/// head`).
pub fn say(line: impl std::fmt::Display) -> Result<(), Failure> {
    // In one piece: a line of which a part was written passes for a whole one.
    let line = format!("{line}\n");
    let mut stdout = std::io::stdout().lock();
    stdout
        .write_all(line.as_bytes())
        .and_then(|()| stdout.flush())
        .map_err(|error| unwritten(&error))
}

/// The failure that stands for what standard output refuses.
pub fn unwritten(error: &std::io::Error) -> Failure {
    let failure = Failure::instrument(format!("cannot write to standard output: {error}"));
    if error.kind() == std::io::ErrorKind::BrokenPipe {
        return Failure {
            kind: FailureKind::Closed,
            ..failure
        };
    }
    failure
}

/// Prints why a command failed and what to do about it.
pub fn report_failure(failure: &Failure) {
    if failure.kind == FailureKind::Closed {
        return;
    }
    let mut stderr = std::io::stderr().lock();
    let _ = writeln!(stderr, "isolux: {}", failure.message);
    if let Some(help) = &failure.help {
        let _ = writeln!(stderr, "  help: {help}");
    }
}

/// How often a step of unknown length shows that it goes on.
const TICK: Duration = Duration::from_millis(200);

/// Progress on standard error: a moving bar on a terminal, one line a step elsewhere.
#[derive(Default)]
pub struct Bars {
    current: RefCell<Option<(ProgressBar, String)>>,
}

impl Progress for Bars {
    fn event(&self, event: Event<'_>) {
        let mut current = self.current.borrow_mut();
        match event {
            Event::Began { step, total } => {
                let bar = if let Some(total) = total {
                    ProgressBar::new(total).with_style(style("{prefix:>12} [{bar:32}] {pos}/{len} {wide_msg}"))
                } else {
                    let spinner =
                        ProgressBar::new_spinner().with_style(style("{prefix:>12} {spinner} {elapsed} {wide_msg}"));
                    // Work that counts nothing still shows that it goes on.
                    spinner.enable_steady_tick(TICK);
                    spinner
                };
                bar.set_prefix(step.to_owned());
                *current = Some((bar, step.to_owned()));
            }
            Event::At { done, what } => {
                if let Some((bar, _)) = current.as_ref() {
                    bar.set_position(done);
                    bar.set_message(what.to_owned());
                }
            }
            Event::Ended(sentence) => {
                if let Some((bar, step)) = current.take() {
                    bar.finish_and_clear();
                    let _ = writeln!(std::io::stderr().lock(), "{step:>12}  {sentence}");
                }
            }
            // The words that follow say it.
            Event::Outline(_) | Event::Live(_) => {}
            Event::Note(sentence) => {
                let print = || {
                    let _ = writeln!(std::io::stderr().lock(), "{:>12}  {sentence}", "note");
                };
                match current.as_ref() {
                    Some((bar, _)) => bar.suspend(print),
                    None => print(),
                }
            }
        }
    }
}

fn style(template: &str) -> ProgressStyle {
    ProgressStyle::with_template(template).unwrap_or_else(|_| ProgressStyle::default_bar())
}
