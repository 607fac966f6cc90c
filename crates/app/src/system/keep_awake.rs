//! While axes move or a scan runs in real time, the computer is kept from going to sleep.
//!
//! The request goes to the system: login1 over D-Bus on Linux, IOKit on macOS, the execution state of a thread on
//! Windows. A person who closes the lid or empties the battery may be stronger; the engine notices that.

use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc;
use std::time::Duration;

use crate::front_end::live::Live;
use crate::front_end::progress::{Event, Progress};

/// A system that does not answer must not hold the bench up.
const ANSWER_WITHIN: Duration = Duration::from_secs(2);

static LET_SLEEP: AtomicBool = AtomicBool::new(false);

/// From now on the computer may sleep.
pub fn let_sleep() {
    LET_SLEEP.store(true, Ordering::Relaxed);
}

/// The computer is kept awake until this is dropped, where that is possible.
pub(crate) struct KeptAwake {
    _until: Option<mpsc::Sender<()>>,
}

/// Keeps the computer awake, and says to `progress` where that is not possible. `real_time`: whether there is anything
/// that goes on while the computer sleeps.
pub(crate) fn keep_awake(real_time: bool, progress: &dyn Progress) -> KeptAwake {
    if !real_time || LET_SLEEP.load(Ordering::Relaxed) {
        return KeptAwake { _until: None };
    }
    match ask() {
        Ok(until) => KeptAwake { _until: Some(until) },
        Err(reason) => {
            let sentence = format!(
                "the computer cannot be kept awake from here ({reason}): see to it that it does not go to sleep meanwhile"
            );
            progress.event(Event::Note(&sentence));
            progress.event(Event::Live(&Live::now(None, &sentence)));
            KeptAwake { _until: None }
        }
    }
}

/// Holds a request to the system to stay awake; `Err` says why there is none.
type Request = Result<Box<dyn std::any::Any>, String>;

/// Asks the system, on a thread of its own that keeps the request for as long as its sender lives: on Windows the
/// request is that of a thread.
fn ask() -> Result<mpsc::Sender<()>, String> {
    let (until, ended) = mpsc::channel::<()>();
    let (answer, answered) = mpsc::channel();
    std::thread::spawn(move || match request() {
        Ok(_kept) => {
            let _ = answer.send(Ok(()));
            // The other end says nothing: it goes away.
            let _ = ended.recv();
        }
        Err(reason) => {
            let _ = answer.send(Err(reason));
        }
    });
    match answered.recv_timeout(ANSWER_WITHIN) {
        Ok(Ok(())) => Ok(until),
        Ok(Err(reason)) => Err(reason),
        Err(_) => Err(format!("the system gave no answer within {ANSWER_WITHIN:?}")),
    }
}

/// `systemd-inhibit` holds the request of login1 while its command runs; the command ends with this process, however
/// that ends, because its standard input does. A D-Bus library for one call would be a tenth of the build.
#[cfg(target_os = "linux")]
fn request() -> Request {
    use std::io::{BufRead, BufReader};
    use std::os::unix::process::CommandExt;
    use std::process::{Command, Stdio};

    let mut child = Command::new("systemd-inhibit")
        .args([
            "--what=sleep:idle",
            "--who=isolux",
            "--why=a measurement drives axes and a lamp",
        ])
        .args(["--mode=block", "sh", "-c", "echo kept; exec cat"])
        .stdin(Stdio::piped())
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        // Not in the group of the terminal: Ctrl-C stops the axes first, and the computer is awake meanwhile.
        .process_group(0)
        .spawn()
        .map_err(|error| format!("systemd-inhibit: {error}"))?;
    let mut line = String::new();
    if let Some(out) = child.stdout.take() {
        BufReader::new(out)
            .read_line(&mut line)
            .map_err(|error| error.to_string())?;
    }
    if line.trim_end() == "kept" {
        return Ok(Box::new(Inhibitor(child)));
    }
    let ended = child.wait_with_output().map_err(|error| error.to_string())?;
    let said = String::from_utf8_lossy(&ended.stderr);
    Err(format!(
        "systemd-inhibit: {}",
        said.trim().lines().last().unwrap_or("it ended")
    ))
}

/// Ends `systemd-inhibit` with the request.
#[cfg(target_os = "linux")]
struct Inhibitor(std::process::Child);

#[cfg(target_os = "linux")]
impl Drop for Inhibitor {
    fn drop(&mut self) {
        drop(self.0.stdin.take());
        // It ends with its input; what it ends with says nothing.
        let _ = self.0.wait();
    }
}

#[cfg(not(target_os = "linux"))]
fn request() -> Request {
    let mut request = keepawake::Builder::default();
    request.idle(true).sleep(true);
    request.app_name("isolux").app_reverse_domain("org.isolux.isolux");
    let kept = request.reason("a measurement drives axes and a lamp").create();
    kept.map(|kept| Box::new(kept) as _).map_err(|error| error.to_string())
}

#[cfg(test)]
#[expect(clippy::used_underscore_binding, reason = "what is only held is only looked at here")]
mod tests {
    use std::cell::RefCell;

    use super::*;

    #[derive(Default)]
    struct Notes(RefCell<Vec<String>>);

    impl Progress for Notes {
        fn event(&self, event: Event<'_>) {
            if let Event::Note(sentence) = event {
                self.0.borrow_mut().push(sentence.to_owned());
            }
        }
    }

    #[test]
    fn either_the_computer_is_kept_awake_or_somebody_reads_that_it_is_not() {
        let stated = Notes::default();
        let kept = keep_awake(true, &stated);
        let sentences = stated.0.into_inner();
        match kept._until {
            Some(_) => assert!(sentences.is_empty(), "{sentences:?}"),
            None => assert!(
                sentences.len() == 1 && sentences[0].contains("cannot be kept awake"),
                "{sentences:?}"
            ),
        }
    }

    #[test]
    fn virtual_time_asks_for_nothing() {
        let stated = Notes::default();
        assert!(keep_awake(false, &stated)._until.is_none() && stated.0.into_inner().is_empty());
    }
}
