//! What every tab is told: the events of one scan from its beginning, and how the controller stands.

use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::{Mutex, MutexGuard, PoisonError};

use isolux_app::front_end::live::{Event as ScanEvent, Live, Outline, Role};
use isolux_app::front_end::progress::{Event, Progress};
use serde::Serialize;
use tokio::sync::watch;

/// Events sent in one message at most.
const EVENTS_A_MESSAGE: usize = 2000;

/// How the controller stands: the same for every tab.
#[derive(Debug, Clone, Default, PartialEq, Serialize)]
pub struct Status {
    /// Folder in which runs are made and looked for.
    pub folder: String,
    /// The run that is shown.
    pub run: Option<String>,
    /// Whether a scan of this process is on, so that it takes commands.
    pub running: bool,
    /// Who makes the run that is shown, where another process does: then only a stop is possible.
    pub elsewhere: Option<String>,
    /// Who asked for a pause, while one is asked for.
    pub pause_asked: Option<String>,
    /// How many times faster than real time the bench runs, where it is virtual; none: as fast as it can.
    pub times: Option<f64>,
    /// Jobs that can be started.
    pub jobs: Vec<String>,
    /// Run directories that can be shown, the newest first.
    pub runs: Vec<String>,
    /// What a person is asked to do.
    pub question: Option<Question>,
    /// What went wrong last outside of a scan, or what was done.
    pub notice: Option<String>,
    /// The report of the run that is shown, once there is one.
    pub report: bool,
    /// Whether the run that is shown has a model, so that its sensor can be lit.
    pub model: bool,
    /// In what state the run that is shown left lamp, shutter and axes, once it ended.
    pub left_behind: Option<String>,
    /// Counted up when effects were added to a model or taken out of it.
    pub changes: u64,
    /// Files of the results of the run that is shown.
    pub results: Vec<String>,
    /// The sensor by the scan so far: another number for each map, 0 without one.
    pub sensor: u64,
    /// What a scan in motion knows so far: another number after each sweep, 0 without one.
    pub in_motion: u64,
}

/// What a person is asked to do.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
pub struct Question {
    /// Number of the question.
    pub number: u64,
    /// The words.
    pub words: String,
}

/// The events of the scan that is shown, and the status.
pub struct Broadcast {
    inner: Mutex<Inner>,
    changed: watch::Sender<u64>,
    readers: AtomicUsize,
}

struct Inner {
    /// Counted up with each scan that is shown: numbers of events begin anew.
    session: u64,
    /// What that scan measures, JSON.
    outline: String,
    events: Vec<String>,
    status: Status,
    /// The half-plane that is being read.
    half_plane: Option<f64>,
    /// Counted up with what the light so far may have changed with: half-planes, sweeps, another scan.
    marks: u64,
}

impl Broadcast {
    /// Nothing to show yet.
    pub fn new(status: Status) -> Self {
        Self {
            inner: Mutex::new(Inner {
                session: 1,
                outline: json(&None::<Outline>),
                events: Vec::new(),
                status,
                half_plane: None,
                marks: 0,
            }),
            changed: watch::Sender::new(0),
            readers: AtomicUsize::new(0),
        }
    }

    fn inner(&self) -> MutexGuard<'_, Inner> {
        self.inner.lock().unwrap_or_else(PoisonError::into_inner)
    }

    fn wake(&self) {
        self.changed.send_modify(|count| *count += 1);
    }

    /// Another scan is shown from now on; none: what it measures is not known yet.
    pub fn begin(&self, outline: Option<&Outline>) {
        {
            let mut inner = self.inner();
            inner.session += 1;
            inner.outline = json(&outline);
            inner.events.clear();
            (inner.half_plane, inner.marks) = (None, inner.marks + 1);
        }
        self.wake();
    }

    /// One event more.
    pub fn publish(&self, live: &Live) {
        // What cannot be written as JSON is no number that a screen could show.
        if let Ok(text) = serde_json::to_string(live) {
            {
                let mut inner = self.inner();
                inner.events.push(text);
                let at = match &live.logged.event {
                    ScanEvent::Reading(reading) if reading.role == Role::Point => Some(reading.c_target_deg),
                    _ if live.state.is_some() => None,
                    _ => inner.half_plane,
                };
                let is_sweep = matches!(live.logged.event, ScanEvent::Sweep { .. });
                if inner.half_plane != at || is_sweep {
                    (inner.half_plane, inner.marks) = (at, inner.marks + 1);
                }
            }
            self.wake();
        }
    }

    /// Counts the half-planes that were begun, what ended one otherwise, sweeps, and scans.
    pub fn marks(&self) -> u64 {
        self.inner().marks
    }

    /// Changes the status; every tab is told if it is another one.
    pub fn status(&self, change: impl FnOnce(&mut Status)) {
        let new = {
            let mut inner = self.inner();
            let before = inner.status.clone();
            change(&mut inner.status);
            before != inner.status
        };
        if new {
            self.wake();
        }
    }

    /// The status now.
    pub fn status_now(&self) -> Status {
        self.inner().status.clone()
    }

    /// The events from number `from` of `session` on, as one JSON object with the status; and where the next one
    /// begins. Of another session: from its beginning. What begins there has the outline of the scan.
    pub fn message(&self, session: u64, from: usize) -> Message {
        let inner = self.inner();
        let same = session == inner.session && from <= inner.events.len();
        let from = if same { from } else { 0 };
        let to = inner.events.len().min(from + EVENTS_A_MESSAGE);
        let status = json(&inner.status);
        let outline = if from == 0 { &inner.outline } else { "null" };
        let events = inner.events[from..to].join(",");
        let session = inner.session;
        Message {
            session,
            next: to,
            more: to < inner.events.len(),
            text: format!(
                "{{\"session\":{session},\"first\":{from},\"status\":{status},\"outline\":{outline},\"events\":[{events}]}}"
            ),
        }
    }

    /// Tells when something is new.
    pub fn changes(&self) -> watch::Receiver<u64> {
        self.changed.subscribe()
    }

    /// A browser reads the stream, until the guard is dropped.
    pub fn reader(self: &std::sync::Arc<Self>) -> Reader {
        self.readers.fetch_add(1, Ordering::Relaxed);
        Reader(self.clone())
    }

    /// Browsers that read the stream now.
    pub fn readers(&self) -> usize {
        self.readers.load(Ordering::Relaxed)
    }
}

fn json(of: &impl Serialize) -> String {
    serde_json::to_string(of).unwrap_or_else(|_| "null".to_owned())
}

/// One part of the events.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Message {
    /// The scan that it belongs to.
    pub session: u64,
    /// Number of the next event.
    pub next: usize,
    /// Whether there are more already.
    pub more: bool,
    /// JSON.
    pub text: String,
}

/// Counts one browser.
pub struct Reader(std::sync::Arc<Broadcast>);

impl Drop for Reader {
    fn drop(&mut self) {
        self.0.readers.fetch_sub(1, Ordering::Relaxed);
    }
}

/// A progress that tells the tabs, and another one that prints.
pub struct TabProgress<'a> {
    /// The tabs.
    pub broadcast: &'a Broadcast,
    /// The terminal.
    pub beside: &'a dyn Progress,
}

impl Progress for TabProgress<'_> {
    fn event(&self, event: Event<'_>) {
        match &event {
            Event::Outline(outline) => {
                self.broadcast.begin(Some(outline));
                self.broadcast.status(|status| {
                    status.run = Some(outline.run.clone());
                    status.notice = None;
                });
            }
            Event::Live(live) => self.broadcast.publish(live),
            _ => {}
        }
        self.beside.event(event);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn journal(sentence: &str) -> Live {
        Live::now(None, sentence)
    }

    #[test]
    fn a_tab_that_was_away_gets_what_it_missed_and_nothing_twice() {
        let broadcast = Broadcast::new(Status::default());
        (0..5).for_each(|number| broadcast.publish(&journal(&format!("line {number}"))));
        let all = broadcast.message(0, 0);
        let parsed: serde_json::Value = serde_json::from_str(&all.text).unwrap();
        assert_eq!(
            (parsed["first"].as_u64(), parsed["events"].as_array().unwrap().len()),
            (Some(0), 5)
        );
        broadcast.publish(&journal("line 5"));
        let further = broadcast.message(all.session, all.next);
        let parsed: serde_json::Value = serde_json::from_str(&further.text).unwrap();
        assert_eq!(parsed["first"], 5);
        assert_eq!(parsed["events"][0]["sentence"], "line 5");
        // Another scan begins: its first event is number 0.
        broadcast.begin(None);
        broadcast.publish(&journal("of the next scan"));
        let next = broadcast.message(further.session, further.next);
        assert_eq!((next.session, next.next), (further.session + 1, 1));
        // A number that the server never gave.
        assert_eq!(broadcast.message(next.session, 1000).next, 1);
    }

    #[test]
    fn each_sweep_and_each_scan_is_worked_out_anew() {
        let broadcast = Broadcast::new(Status::default());
        let mut sweep = journal("sweep 1");
        sweep.logged.event = ScanEvent::Sweep {
            index: 0,
            block: "lit".to_owned(),
            c_deg: [0.0, 0.0],
            gamma_deg: [-180.0, 180.0],
            conversions: 238,
            positions: 1467,
        };
        let mut marks = vec![broadcast.marks()];
        for _ in 0..2 {
            broadcast.publish(&sweep);
            marks.push(broadcast.marks());
        }
        broadcast.publish(&journal("a line that changes no light"));
        assert_eq!(broadcast.marks(), marks[2]);
        broadcast.begin(None);
        marks.push(broadcast.marks());
        assert!(marks.windows(2).all(|pair| pair[0] < pair[1]), "{marks:?}");
    }

    #[test]
    fn a_long_scan_comes_in_parts() {
        let broadcast = Broadcast::new(Status::default());
        for _ in 0..=EVENTS_A_MESSAGE {
            broadcast.publish(&journal("x"));
        }
        let first = broadcast.message(1, 0);
        assert!(first.more && first.next == EVENTS_A_MESSAGE);
        let last = broadcast.message(1, first.next);
        assert!(!last.more && last.next == EVENTS_A_MESSAGE + 1);
    }
}
