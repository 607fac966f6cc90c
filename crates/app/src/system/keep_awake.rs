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

/// Asks the system, on a thread of its own that keeps the request for as long as its sender lives: on Windows the
/// request is that of a thread.
fn ask() -> Result<mpsc::Sender<()>, String> {
    let (until, ended) = mpsc::channel::<()>();
    let (answer, answered) = mpsc::channel();
    std::thread::spawn(move || {
        let mut request = keepawake::Builder::default();
        request.idle(true).sleep(true);
        request.app_name("isolux").app_reverse_domain("org.isolux.isolux");
        match request.reason("a measurement drives axes and a lamp").create() {
            Ok(_kept) => {
                let _ = answer.send(Ok(()));
                // The other end says nothing: it goes away.
                let _ = ended.recv();
            }
            Err(error) => {
                let _ = answer.send(Err(error.to_string()));
            }
        }
    });
    match answered.recv_timeout(ANSWER_WITHIN) {
        Ok(Ok(())) => Ok(until),
        Ok(Err(reason)) => Err(reason),
        Err(_) => Err(format!("the system gave no answer within {ANSWER_WITHIN:?}")),
    }
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
