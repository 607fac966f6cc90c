//! The desk: what can be asked of the bench, and what is shown.

use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::mpsc::{Sender, channel};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use camino::{Utf8Path, Utf8PathBuf};
use isolux_app::control::{Control, Pace};
use isolux_app::live::Live;
use isolux_app::operator::ByFunction;
use isolux_app::replay::{self, Replay};
use isolux_app::{Failure, folder};
use serde::Deserialize;

use crate::hub::{Hub, Question, Status};
use crate::sensor::Sensor;

/// The name under which the built-in virtual darkroom is offered.
pub const BUILT_IN: &str = "virtual darkroom";
/// How commands of the page are signed in the record.
const BY: &str = "the page";

/// A command of the page.
#[derive(Debug, Clone, PartialEq, Eq, Deserialize)]
#[serde(tag = "command", rename_all = "snake_case", deny_unknown_fields)]
pub enum Asked {
    /// Begins a day with a job of the folder, or with the built-in virtual darkroom.
    Start {
        /// Its file.
        job: String,
    },
    /// Finishes the point, stops the axes, keeps the lamp on.
    Pause {},
    /// Goes on.
    Resume {},
    /// Ends the scan; what was read stays.
    Abort {},
    /// Ends the scan, wherever it was started.
    Stop {},
    /// Shows another run of the folder.
    Show {
        /// Its name.
        run: String,
    },
    /// What the person at the bench answers.
    Answer {
        /// Number of the question.
        number: u64,
        /// Who did it; empty: not done.
        who: String,
    },
}

/// A day that is to be begun.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Order {
    /// The job; none: the built-in virtual darkroom.
    pub job: Option<Utf8PathBuf>,
    /// The folder of the day.
    pub out: Utf8PathBuf,
}

/// The question that is open.
type Open = Mutex<Option<(u64, Sender<String>)>>;

/// What can be asked of the bench, and what is shown.
pub struct Desk {
    hub: Arc<Hub>,
    folder: Utf8PathBuf,
    pace: Pace,
    /// Of the scan that is on in this process.
    control: Mutex<Option<Control>>,
    /// To whoever begins days; none where the command line has begun the one that is on.
    orders: Option<Mutex<Sender<Order>>>,
    question: Arc<Open>,
    questions: Arc<AtomicU64>,
    /// The run that is shown from its record.
    replay: Mutex<Option<(Utf8PathBuf, Replay)>>,
    sensor: Sensor,
}

fn locked<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}

impl Desk {
    /// A desk for the runs in `folder`. Without `orders` it begins nothing.
    pub fn new(folder: &Utf8Path, pace: Pace, orders: Option<Sender<Order>>) -> Self {
        let times = match pace {
            Pace::Times(times) => Some(times),
            _ => None,
        };
        let hub = Arc::new(Hub::new(Status {
            folder: folder.to_string(),
            times,
            ..Status::default()
        }));
        Self {
            sensor: Sensor::new(hub.clone()),
            hub,
            folder: folder.to_owned(),
            pace,
            control: Mutex::new(None),
            orders: orders.map(Mutex::new),
            question: Arc::default(),
            questions: Arc::default(),
            replay: Mutex::new(None),
        }
    }

    /// What the tabs are told.
    pub const fn hub(&self) -> &Arc<Hub> {
        &self.hub
    }

    /// The last map of the sensor, JSON.
    pub fn sensor(&self) -> Option<String> {
        self.sensor.last()
    }

    /// Keeps the map of the sensor in step with the scan that is shown.
    pub fn follow_sensor(&self) {
        self.sensor.follow();
    }

    /// The report of the run that is shown.
    pub fn report(&self) -> Option<Vec<u8>> {
        let run = self.hub.status_now().run?;
        std::fs::read(Utf8Path::new(&run).join("results/report.html")).ok()
    }

    /// A file of the results of the run that is shown.
    pub fn result(&self, name: &str) -> Option<Vec<u8>> {
        let status = self.hub.status_now();
        let known = status.results.iter().any(|one| one == name);
        known.then(|| std::fs::read(Utf8Path::new(&status.run?).join("results").join(name)).ok())?
    }

    /// A scan of this process is on, under `control`, until [`ended`](Self::ended).
    pub fn began(&self, control: &Control) {
        *locked(&self.control) = Some(control.clone());
        *locked(&self.replay) = None;
        // What was shown before is not of this scan.
        self.hub.begin();
        self.hub.status(|status| {
            status.running = true;
            status.run = None;
            status.sensor = 0;
            status.elsewhere = None;
            status.notice = None;
            status.report = false;
        });
    }

    /// It ended; with what went wrong.
    pub fn ended(&self, failure: Option<&Failure>) {
        *locked(&self.control) = None;
        *locked(&self.question) = None;
        self.hub.status(|status| {
            status.running = false;
            status.question = None;
            status.pause_asked = None;
            status.notice = failure.map(told);
        });
    }

    /// A control at the pace of this desk.
    pub fn fresh_control(&self) -> Control {
        Control {
            pace: self.pace,
            ..Control::default()
        }
    }

    /// The person who answers on the page.
    pub fn operator(&self) -> ByFunction {
        let (hub, open, numbers) = (self.hub.clone(), self.question.clone(), self.questions.clone());
        ByFunction::new(move |words| {
            let (answer, wait) = channel();
            let number = numbers.fetch_add(1, Ordering::Relaxed) + 1;
            *locked(&open) = Some((number, answer));
            let words = words.to_owned();
            hub.status(|status| status.question = Some(Question { number, words }));
            let who = wait.recv().map_err(|_| "the scan ended before the answer".to_owned());
            hub.status(|status| status.question = None);
            match who?.trim() {
                "" => Err("the answer was empty".to_owned()),
                who => Ok(who.to_owned()),
            }
        })
    }

    /// Does what a tab asks; a sentence.
    ///
    /// # Errors
    /// Why it cannot be done now.
    pub fn command(&self, asked: &Asked) -> Result<String, Failure> {
        match asked {
            Asked::Start { job } => self.start(job),
            Asked::Show { run } => self.show(run),
            Asked::Stop {} => self.stop(),
            Asked::Answer { number, who } => self.answer(*number, who),
            Asked::Pause {} => {
                self.running()?.pause.ask(BY);
                self.tick();
                Ok("pauses after the point that is being read; the lamp stays on".to_owned())
            }
            Asked::Resume {} => {
                self.running()?.pause.end(BY);
                self.tick();
                Ok("goes on: first the reference point".to_owned())
            }
            Asked::Abort {} => {
                self.running()?.cancel.cancel("abort from the page");
                Ok("ends: the axes are stopped, what was read stays".to_owned())
            }
        }
    }

    fn running(&self) -> Result<Control, Failure> {
        locked(&self.control).clone().ok_or_else(|| {
            let status = self.hub.status_now();
            match status.elsewhere {
                Some(who) => {
                    Failure::instrument(format!("this scan is made by {who}: from here it can only be stopped"))
                }
                None => Failure::instrument("no scan is on"),
            }
        })
    }

    fn start(&self, job: &str) -> Result<String, Failure> {
        let Some(orders) = &self.orders else {
            return Err(Failure::instrument(
                "this page belongs to one scan; start another one by `isolux serve`",
            ));
        };
        if locked(&self.control).is_some() {
            return Err(Failure::instrument("a scan is on already"));
        }
        let known = self.hub.status_now().jobs;
        if !known.iter().any(|name| name == job) {
            return Err(Failure::bad_input(format!("`{job}` is no job in {}", self.folder)));
        }
        let out = self.folder.join(folder::fresh(&self.folder));
        let order = Order {
            job: (job != BUILT_IN).then(|| self.folder.join(job)),
            out: out.clone(),
        };
        // From now on a second start is refused, although the scan itself has not begun.
        self.began(&self.fresh_control());
        if locked(orders).send(order).is_err() {
            self.ended(None);
            return Err(Failure::instrument("the program is ending"));
        }
        Ok(format!("begins in {out}"))
    }

    /// The control that was made when the start was accepted.
    pub fn accepted(&self) -> Control {
        locked(&self.control).clone().unwrap_or_else(|| self.fresh_control())
    }

    fn stop(&self) -> Result<String, Failure> {
        if let Some(control) = locked(&self.control).clone() {
            control.cancel.cancel("stop from the page");
            return Ok("the axes are being stopped".to_owned());
        }
        let run = self.hub.status_now().run;
        let run = run.ok_or_else(|| Failure::instrument("no scan is on"))?;
        replay::ask_writer_to_end(Utf8Path::new(&run))
    }

    fn answer(&self, number: u64, who: &str) -> Result<String, Failure> {
        let mut open = locked(&self.question);
        match open.take() {
            Some((asked, answer)) if asked == number => {
                let _ = answer.send(who.to_owned());
                Ok("thank you".to_owned())
            }
            other => {
                *open = other;
                Err(Failure::instrument("this was answered already"))
            }
        }
    }

    fn show(&self, run: &str) -> Result<String, Failure> {
        if locked(&self.control).is_some() {
            return Err(Failure::instrument("a scan is on; it is shown"));
        }
        if !(run == "." || folder::is_name(run)) {
            return Err(Failure::bad_input(format!("`{run}` is no run of {}", self.folder)));
        }
        self.show_quietly(run)?;
        self.hub.status(|status| status.notice = None);
        self.look();
        Ok(format!("{run} is shown"))
    }

    /// What changes often: cheap.
    pub fn tick(&self) {
        let control = locked(&self.control).clone();
        let asked = control.and_then(|control| control.pause.asked());
        self.hub.status(|status| status.pause_asked = asked);
    }

    /// What lies on the disk: jobs, runs, a scan that another process makes.
    pub fn look(&self) {
        let mut jobs = Vec::new();
        if self.orders.is_some() {
            jobs = folder::jobs(&self.folder);
            jobs.push(BUILT_IN.to_owned());
        }
        let runs = folder::runs(&self.folder);
        self.hub
            .status(|status| (status.jobs, status.runs) = (jobs, runs.clone()));
        if locked(&self.control).is_some() {
            self.refresh_report();
            return;
        }
        self.follow(&runs);
        let mut elsewhere = None;
        if let Some((path, replay)) = locked(&self.replay).as_mut() {
            elsewhere = replay::writer(path).map(|writer| writer.words);
            // A record that is being written may be between two files.
            if let Ok(told) = replay.further() {
                for live in &told {
                    self.hub.tell(live);
                }
            }
        }
        self.hub.status(|status| status.elsewhere = elsewhere);
        self.refresh_report();
    }

    fn refresh_report(&self) {
        let status = self.hub.status_now();
        let results = status
            .run
            .map_or_else(Vec::new, |run| folder::files(&Utf8Path::new(&run).join("results")));
        let report = results.iter().any(|name| name == "report.html");
        self.hub
            .status(|status| (status.report, status.results) = (report, results));
    }

    /// A scan that another process has begun is shown as soon as it is seen; at first the newest run.
    fn follow(&self, runs: &[String]) {
        let status = self.hub.status_now();
        if status.elsewhere.is_some() || self.orders.is_none() {
            return;
        }
        let path = |run: &str| {
            if run == "." {
                self.folder.clone()
            } else {
                self.folder.join(run)
            }
        };
        let made = runs.iter().find(|run| replay::writer(&path(run)).is_some());
        let shown = status.run.as_deref();
        match made {
            Some(run) if shown != Some(path(run).as_str()) => drop(self.show_quietly(run)),
            // A start that failed before its scan began stays to be read.
            None if shown.is_none() && status.notice.is_none() => drop(runs.first().map(|run| self.show_quietly(run))),
            _ => {}
        }
    }

    fn show_quietly(&self, run: &str) -> Result<(), Failure> {
        let path = if run == "." {
            self.folder.clone()
        } else {
            self.folder.join(run)
        };
        let mut replay = Replay::of(&path);
        let told = replay.further()?;
        self.hub.begin();
        self.hub.status(|status| status.run = Some(path.to_string()));
        for live in &told {
            self.hub.tell(live);
        }
        *locked(&self.replay) = Some((path, replay));
        Ok(())
    }

    /// Says on the page what a step after the scan does.
    pub fn say(&self, live: &Live) {
        self.hub.tell(live);
    }
}

/// A failure as one text.
fn told(failure: &Failure) -> String {
    match &failure.help {
        Some(help) => format!("{}. {help}", failure.message),
        None => failure.message.clone(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn desk() -> (tempfile::TempDir, Desk, std::sync::mpsc::Receiver<Order>) {
        let folder = tempfile::tempdir().unwrap();
        let path = Utf8Path::from_path(folder.path()).unwrap().to_owned();
        let (sender, orders) = channel();
        let desk = Desk::new(&path, Pace::Times(100.0), Some(sender));
        desk.look();
        (folder, desk, orders)
    }

    fn asked(text: &str) -> Asked {
        serde_json::from_str(text).unwrap()
    }

    #[test]
    fn commands_have_one_form() {
        assert_eq!(asked(r#"{"command":"pause"}"#), Asked::Pause {});
        assert_eq!(
            asked(r#"{"command":"show","run":"day"}"#),
            Asked::Show { run: "day".to_owned() }
        );
        for wrong in [
            r#"{"command":"pause","force":true}"#,
            r#"{"command":"start"}"#,
            "{}",
            "[]",
            r#"{"command":"move"}"#,
        ] {
            assert!(serde_json::from_str::<Asked>(wrong).is_err(), "{wrong}");
        }
    }

    #[test]
    fn one_scan_at_a_time_and_only_of_a_job_that_is_offered() {
        let (_folder, desk, orders) = desk();
        for command in [
            r#"{"command":"pause"}"#,
            r#"{"command":"abort"}"#,
            r#"{"command":"stop"}"#,
        ] {
            assert!(desk.command(&asked(command)).is_err(), "no scan is on: {command}");
        }
        for job in ["../job.toml", "job.toml", ""] {
            let start = Asked::Start { job: job.to_owned() };
            assert!(desk.command(&start).is_err() && orders.try_recv().is_err(), "{job}");
        }
        let start = Asked::Start {
            job: BUILT_IN.to_owned(),
        };
        desk.command(&start).unwrap();
        assert!(desk.command(&start).is_err(), "a second click");
        let order = orders.try_recv().unwrap();
        assert_eq!((order.job, order.out.file_name()), (None, Some("day")));
        assert!(orders.try_recv().is_err());
        let control = desk.accepted();
        desk.command(&asked(r#"{"command":"pause"}"#)).unwrap();
        assert_eq!(desk.hub().status_now().pause_asked.as_deref(), Some("the page"));
        assert_eq!(control.pause.asked().as_deref(), Some("the page"));
        desk.command(&asked(r#"{"command":"resume"}"#)).unwrap();
        assert_eq!(
            (control.pause.asked(), desk.hub().status_now().pause_asked),
            (None, None)
        );
        desk.command(&asked(r#"{"command":"abort"}"#)).unwrap();
        assert!(control.cancel.reason().unwrap().contains("the page"));
        desk.ended(None);
        assert!(!desk.hub().status_now().running);
    }

    #[test]
    fn no_run_outside_of_the_folder_is_shown() {
        let (_folder, desk, _orders) = desk();
        for run in ["..", "../other", "/etc", "a/b", ""] {
            let shown = desk.command(&Asked::Show { run: run.to_owned() });
            assert!(shown.unwrap_err().message.contains("is no run of"), "{run}");
        }
    }

    #[test]
    fn a_question_is_answered_once() {
        let (_folder, desk, _orders) = desk();
        let (answer, wait) = channel();
        *locked(&desk.question) = Some((3, answer));
        let say = |number| {
            desk.command(&Asked::Answer {
                number,
                who: "Ada".to_owned(),
            })
        };
        assert!(say(2).is_err(), "of another question");
        say(3).unwrap();
        assert_eq!(wait.try_recv().unwrap(), "Ada");
        assert!(say(3).is_err());
    }
}
