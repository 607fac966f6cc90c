//! The controller of a bench: what can be asked of it, and what is shown.

use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::mpsc::{Sender, channel};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use camino::{Utf8Path, Utf8PathBuf};
use isolux_app::Failure;
use isolux_app::front_end::control::{Control, Pace};
use isolux_app::front_end::live::Live;
use isolux_app::front_end::operator::ByFunction;
use isolux_app::run::replay;
use isolux_app::study::{diagnosed, next};

use crate::broadcast::{Broadcast, Question, Status};
use crate::command::{Command, Order};
use crate::runs::Runs;
use crate::so_far::SoFar;

/// How commands of the page are signed in the record.
const BY: &str = "the page";

/// The question that is open.
type Open = Mutex<Option<(u64, Sender<String>)>>;

/// What can be asked of the bench, and what is shown.
pub struct Controller {
    broadcast: Arc<Broadcast>,
    runs: Runs,
    pace: Pace,
    /// Of the scan that is on in this process.
    control: Mutex<Option<Control>>,
    /// To whoever begins days; none where the command line has begun the one that is on.
    orders: Option<Mutex<Sender<Order>>>,
    question: Arc<Open>,
    questions: Arc<AtomicU64>,
    so_far: SoFar,
}

fn locked<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}

impl Controller {
    /// A controller for the runs in `folder`. Without `orders` it begins nothing.
    pub fn new(folder: &Utf8Path, pace: Pace, orders: Option<Sender<Order>>) -> Self {
        let times = match pace {
            Pace::Times(times) => Some(times),
            _ => None,
        };
        let broadcast = Arc::new(Broadcast::new(Status {
            folder: folder.to_string(),
            times,
            ..Status::default()
        }));
        Self {
            so_far: SoFar::new(broadcast.clone()),
            runs: Runs::new(broadcast.clone(), folder, orders.is_some()),
            broadcast,
            pace,
            control: Mutex::new(None),
            orders: orders.map(Mutex::new),
            question: Arc::default(),
            questions: Arc::default(),
        }
    }

    /// What the tabs are told.
    pub const fn broadcast(&self) -> &Arc<Broadcast> {
        &self.broadcast
    }

    /// What is worked out of the scan so far.
    pub const fn so_far(&self) -> &SoFar {
        &self.so_far
    }

    /// The report of the run that is shown.
    pub fn report(&self) -> Option<Vec<u8>> {
        let run = self.broadcast.status_now().run?;
        std::fs::read(Utf8Path::new(&run).join("results/report.html")).ok()
    }

    /// A file of the results of the run that is shown.
    pub fn result(&self, name: &str) -> Option<Vec<u8>> {
        let status = self.broadcast.status_now();
        let known = status.results.iter().any(|one| one == name);
        known.then(|| std::fs::read(Utf8Path::new(&status.run?).join("results").join(name)).ok())?
    }

    /// A scan of this process is on, under `control`, until [`ended`](Self::ended).
    pub fn began(&self, control: &Control) {
        *locked(&self.control) = Some(control.clone());
        self.runs.leave();
        // What was shown before is not of this scan.
        self.broadcast.begin(None);
        self.broadcast.status(|status| {
            status.running = true;
            status.run = None;
            (status.sensor, status.in_motion) = (0, 0);
            status.elsewhere = None;
            status.notice = None;
            (status.report, status.model, status.left_behind) = (false, false, None);
        });
    }

    /// It ended; with what went wrong.
    pub fn ended(&self, failure: Option<&Failure>) {
        *locked(&self.control) = None;
        *locked(&self.question) = None;
        self.broadcast.status(|status| {
            status.running = false;
            status.question = None;
            status.pause_asked = None;
            status.notice = failure.map(as_text);
        });
    }

    /// A control at the pace of this controller.
    pub fn fresh_control(&self) -> Control {
        Control {
            pace: self.pace,
            ..Control::default()
        }
    }

    /// The person who answers on the page.
    pub fn operator(&self) -> ByFunction {
        let (broadcast, open, numbers) = (self.broadcast.clone(), self.question.clone(), self.questions.clone());
        ByFunction::new(move |words| {
            let (answer, wait) = channel();
            let number = numbers.fetch_add(1, Ordering::Relaxed) + 1;
            *locked(&open) = Some((number, answer));
            let words = words.to_owned();
            broadcast.status(|status| status.question = Some(Question { number, words }));
            let who = wait.recv().map_err(|_| "the scan ended before the answer".to_owned());
            broadcast.status(|status| status.question = None);
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
    pub fn command(&self, command: &Command) -> Result<String, Failure> {
        match command {
            Command::Start { job } => self.start(job),
            Command::Show { run } => self.show(run),
            Command::Stop {} => self.stop(),
            Command::Answer { number, who } => self.answer(*number, who),
            Command::AddToModel {} => Ok(self.changed(diagnosed::add_to_model(&self.run()?)?)),
            Command::TakeOutOfModel {} => Ok(self.changed(diagnosed::take_out_of_model(&self.run()?)?)),
            Command::Measure { number, seen } => self.measure(*number, seen),
            Command::Pause {} => {
                self.running()?.pause.ask(BY);
                self.tick();
                Ok("pauses after the point that is being read; the lamp stays on".to_owned())
            }
            Command::Resume {} => {
                self.running()?.pause.end(BY);
                self.tick();
                Ok("goes on: first the reference point".to_owned())
            }
            Command::Abort {} => {
                self.running()?.cancel.cancel("abort from the page");
                Ok("ends: the axes are stopped, what was read stays".to_owned())
            }
        }
    }

    fn running(&self) -> Result<Control, Failure> {
        locked(&self.control).clone().ok_or_else(|| {
            let status = self.broadcast.status_now();
            match status.elsewhere {
                Some(who) => {
                    Failure::instrument(format!("this scan is made by {who}: from here it can only be stopped"))
                }
                None => Failure::instrument("no scan is on"),
            }
        })
    }

    /// The run that is shown.
    ///
    /// # Errors
    /// Exit 3 where none is.
    pub fn run(&self) -> Result<Utf8PathBuf, Failure> {
        let run = self.broadcast.status_now().run.map(Utf8PathBuf::from);
        run.ok_or_else(|| Failure::instrument("no run is shown"))
    }

    /// The run of the folder with this name.
    ///
    /// # Errors
    /// Bad input (exit 2) for a name that leads out of it.
    pub fn named(&self, run: &str) -> Result<Utf8PathBuf, Failure> {
        self.runs.named(run)
    }

    /// The model of the run that is shown became another one: every tab is told.
    fn changed(&self, sentence: String) -> String {
        self.broadcast.status(|status| status.changes += 1);
        sentence
    }

    fn start(&self, job: &str) -> Result<String, Failure> {
        self.idle()?;
        let job = self.runs.job(job)?;
        let out = self.runs.fresh();
        self.order(Order::Day { job, out: out.clone() })?;
        Ok(format!("begins in {out}"))
    }

    fn measure(&self, number: usize, seen: &str) -> Result<String, Failure> {
        self.idle()?;
        let run = self.run()?;
        let shown = next::shown(&run, number)?;
        if shown.fingerprint != seen {
            return Err(Failure::instrument(
                "this is not the plan that was shown; look at it again",
            ));
        }
        let out = self.runs.fresh();
        let sentence = format!("measures into {out}");
        let shown = Box::new(shown);
        self.order(Order::Measurement { run, shown, out })?;
        Ok(sentence)
    }

    /// Nothing may be begun while a scan is on.
    fn idle(&self) -> Result<(), Failure> {
        if locked(&self.control).is_some() {
            return Err(Failure::instrument("a scan is on already"));
        }
        Ok(())
    }

    fn order(&self, order: Order) -> Result<(), Failure> {
        let Some(orders) = &self.orders else {
            return Err(Failure::instrument(
                "this page belongs to one scan; start another one by `isolux serve`",
            ));
        };
        // From now on a second start is refused, although the scan itself has not begun.
        self.began(&self.fresh_control());
        if locked(orders).send(order).is_err() {
            self.ended(None);
            return Err(Failure::instrument("the program is ending"));
        }
        Ok(())
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
        let run = self.broadcast.status_now().run;
        let run = run.ok_or_else(|| Failure::instrument("no scan is on"))?;
        replay::ask_writer_to_end(Utf8Path::new(&run))
    }

    fn answer(&self, number: u64, who: &str) -> Result<String, Failure> {
        let mut open = locked(&self.question);
        match open.take() {
            Some((open_number, answer)) if open_number == number => {
                let _ = answer.send(who.to_owned());
                Ok("thank you".to_owned())
            }
            other => {
                *open = other;
                Err(Failure::instrument("this was answered already"))
            }
        }
    }

    /// What changes often: cheap.
    pub fn tick(&self) {
        let control = locked(&self.control).clone();
        let by = control.and_then(|control| control.pause.requested());
        self.broadcast.status(|status| status.pause_asked = by);
    }

    fn show(&self, run: &str) -> Result<String, Failure> {
        if locked(&self.control).is_some() {
            return Err(Failure::instrument("a scan is on; it is shown"));
        }
        self.runs.show(run)?;
        self.broadcast.status(|status| status.notice = None);
        self.look();
        Ok(format!("{run} is shown"))
    }

    /// Shows the run directory `run` again, after a measurement for it, or why not.
    pub fn back_to(&self, run: &Utf8Path) {
        if let Err(failure) = self.runs.show_quietly(run) {
            self.broadcast.status(|status| status.notice = Some(as_text(&failure)));
        }
        self.look();
    }

    /// What lies on the disk: jobs, runs, a scan that another process makes.
    pub fn look(&self) {
        self.runs.look(locked(&self.control).is_some());
    }

    /// Says on the page what a step after the scan does.
    pub fn say(&self, live: &Live) {
        self.broadcast.publish(live);
    }
}

/// A failure as one text.
fn as_text(failure: &Failure) -> String {
    match &failure.help {
        Some(help) => format!("{}. {help}", failure.message),
        None => failure.message.clone(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::runs::BUILT_IN;

    fn controller() -> (tempfile::TempDir, Controller, std::sync::mpsc::Receiver<Order>) {
        let folder = tempfile::tempdir().unwrap();
        let path = Utf8Path::from_path(folder.path()).unwrap().to_owned();
        let (sender, orders) = channel();
        let controller = Controller::new(&path, Pace::Times(100.0), Some(sender));
        controller.look();
        (folder, controller, orders)
    }

    fn parsed(text: &str) -> Command {
        serde_json::from_str(text).unwrap()
    }

    #[test]
    fn commands_have_one_form() {
        assert_eq!(parsed(r#"{"command":"pause"}"#), Command::Pause {});
        assert_eq!(
            parsed(r#"{"command":"show","run":"day"}"#),
            Command::Show { run: "day".to_owned() }
        );
        for wrong in [
            r#"{"command":"pause","force":true}"#,
            r#"{"command":"start"}"#,
            "{}",
            "[]",
            r#"{"command":"move"}"#,
        ] {
            assert!(serde_json::from_str::<Command>(wrong).is_err(), "{wrong}");
        }
    }

    #[test]
    fn one_scan_at_a_time_and_only_of_a_job_that_is_offered() {
        let (_folder, controller, orders) = controller();
        for command in [
            r#"{"command":"pause"}"#,
            r#"{"command":"abort"}"#,
            r#"{"command":"stop"}"#,
        ] {
            assert!(
                controller.command(&parsed(command)).is_err(),
                "no scan is on: {command}"
            );
        }
        for job in ["../job.toml", "job.toml", ""] {
            let start = Command::Start { job: job.to_owned() };
            assert!(
                controller.command(&start).is_err() && orders.try_recv().is_err(),
                "{job}"
            );
        }
        let start = Command::Start {
            job: BUILT_IN.to_owned(),
        };
        controller.command(&start).unwrap();
        assert!(controller.command(&start).is_err(), "a second click");
        let Order::Day { job, out } = orders.try_recv().unwrap() else {
            panic!("a day was asked for")
        };
        assert_eq!((job, out.file_name()), (None, Some("day")));
        assert!(orders.try_recv().is_err());
        let control = controller.accepted();
        controller.command(&parsed(r#"{"command":"pause"}"#)).unwrap();
        assert_eq!(
            controller.broadcast().status_now().pause_asked.as_deref(),
            Some("the page")
        );
        assert_eq!(control.pause.requested().as_deref(), Some("the page"));
        controller.command(&parsed(r#"{"command":"resume"}"#)).unwrap();
        assert_eq!(
            (
                control.pause.requested(),
                controller.broadcast().status_now().pause_asked
            ),
            (None, None)
        );
        controller.command(&parsed(r#"{"command":"abort"}"#)).unwrap();
        assert!(control.cancel.reason().unwrap().contains("the page"));
        controller.ended(None);
        assert!(!controller.broadcast().status_now().running);
    }

    #[test]
    fn no_run_outside_of_the_folder_is_shown() {
        let (_folder, controller, _orders) = controller();
        for run in ["..", "../other", "/etc", "a/b", ""] {
            let shown = controller.command(&Command::Show { run: run.to_owned() });
            assert!(shown.unwrap_err().message.contains("is no run of"), "{run}");
        }
    }

    #[test]
    fn a_question_is_answered_once() {
        let (_folder, controller, _orders) = controller();
        let (answer, wait) = channel();
        *locked(&controller.question) = Some((3, answer));
        let say = |number| {
            controller.command(&Command::Answer {
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
