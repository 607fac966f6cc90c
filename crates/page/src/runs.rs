//! Which run is shown, and what lies in the folder: jobs, runs, results, a scan that another process makes.

use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::SystemTime;

use camino::{Utf8Path, Utf8PathBuf};
use isolux_app::Failure;
use isolux_app::run::replay::{self, Replay};
use isolux_app::run::{folder, rest};

use crate::broadcast::Broadcast;

/// The name under which the built-in virtual darkroom is offered.
pub const BUILT_IN: &str = "virtual darkroom";

/// The run that is shown from its record.
struct Shown {
    path: Utf8PathBuf,
    replay: Replay,
    /// Length and time of the record's files when it was read last.
    read: Vec<(u64, Option<SystemTime>)>,
}

/// The runs of a folder.
pub struct Runs {
    broadcast: Arc<Broadcast>,
    folder: Utf8PathBuf,
    /// Whether days can be begun here.
    offers: bool,
    shown: Mutex<Option<Shown>>,
}

impl Runs {
    /// Those of `folder`; nothing is looked at yet.
    pub fn new(broadcast: Arc<Broadcast>, folder: &Utf8Path, offers: bool) -> Self {
        Self {
            broadcast,
            folder: folder.to_owned(),
            offers,
            shown: Mutex::new(None),
        }
    }

    fn shown(&self) -> MutexGuard<'_, Option<Shown>> {
        self.shown.lock().unwrap_or_else(PoisonError::into_inner)
    }

    fn path(&self, run: &str) -> Utf8PathBuf {
        if run == "." {
            self.folder.clone()
        } else {
            self.folder.join(run)
        }
    }

    /// The folder for a new run.
    pub fn fresh(&self) -> Utf8PathBuf {
        self.folder.join(folder::fresh(&self.folder))
    }

    /// The file of a job of this folder; none for the built-in virtual darkroom.
    ///
    /// # Errors
    /// Bad input (exit 2) for what is not offered.
    pub fn job(&self, name: &str) -> Result<Option<Utf8PathBuf>, Failure> {
        if !self.broadcast.status_now().jobs.iter().any(|job| job == name) {
            return Err(Failure::bad_input(format!("`{name}` is no job in {}", self.folder)));
        }
        Ok((name != BUILT_IN).then(|| self.folder.join(name)))
    }

    /// Nothing is shown from a record any more: a scan of this process begins.
    pub fn leave(&self) {
        *self.shown() = None;
    }

    /// The run of the folder with this name.
    ///
    /// # Errors
    /// Bad input (exit 2) for a name that leads out of it.
    pub fn named(&self, run: &str) -> Result<Utf8PathBuf, Failure> {
        if !(run == "." || folder::is_name(run)) {
            return Err(Failure::bad_input(format!("`{run}` is no run of {}", self.folder)));
        }
        Ok(self.path(run))
    }

    /// Shows another run of the folder.
    ///
    /// # Errors
    /// Bad input (exit 2) for what is no run of it.
    pub fn show(&self, run: &str) -> Result<(), Failure> {
        self.show_quietly(&self.named(run)?)
    }

    /// Shows the run directory `path`.
    ///
    /// # Errors
    /// Bad input (exit 2) for what is no run directory.
    pub fn show_quietly(&self, path: &Utf8Path) -> Result<(), Failure> {
        let read = state(path);
        let mut replay = Replay::of(path);
        let (outline, events) = replay.further()?;
        self.broadcast.begin(outline.as_ref());
        self.broadcast.status(|status| {
            status.run = Some(path.to_string());
            // What was worked out is of the run before.
            (status.sensor, status.in_motion) = (0, 0);
        });
        for live in &events {
            self.broadcast.publish(live);
        }
        *self.shown() = Some(Shown {
            path: path.to_owned(),
            replay,
            read,
        });
        Ok(())
    }

    /// What lies on the disk now; `running`: a scan of this process is shown, no record.
    pub fn look(&self, running: bool) {
        let mut jobs = Vec::new();
        if self.offers {
            jobs = folder::jobs(&self.folder);
            jobs.push(BUILT_IN.to_owned());
        }
        let runs = folder::runs(&self.folder);
        self.broadcast
            .status(|status| (status.jobs, status.runs) = (jobs, runs.clone()));
        if !running {
            self.follow(&runs);
            self.further();
        }
        self.results(running);
    }

    /// What has come to the record that is shown.
    fn further(&self) {
        let mut elsewhere = None;
        if let Some(shown) = self.shown().as_mut() {
            elsewhere = replay::writer(&shown.path).map(|writer| writer.words);
            let now = state(&shown.path);
            // A record that is being written may be between two files.
            if now != shown.read
                && let Ok((_, events)) = shown.replay.further()
            {
                shown.read = now;
                for live in &events {
                    self.broadcast.publish(live);
                }
            }
        }
        self.broadcast.status(|status| status.elsewhere = elsewhere);
    }

    /// The results of the run that is shown, and how it left the bench.
    fn results(&self, running: bool) {
        let status = self.broadcast.status_now();
        let Some(run) = status.run.map(Utf8PathBuf::from) else {
            return;
        };
        let results = folder::files(&run.join("results"));
        let has = |name: &str| results.iter().any(|file| file == name);
        let (report, model) = (has("report.html"), has("luminaire.model.toml"));
        let idle = !running && status.elsewhere.is_none();
        let left_behind = idle.then(|| rest::left_behind(&run)).flatten();
        self.broadcast.status(|status| {
            (status.report, status.model, status.results) = (report, model, results);
            status.left_behind = left_behind;
        });
    }

    /// A scan that another process has begun is shown as soon as it is seen; at first the newest run.
    fn follow(&self, runs: &[String]) {
        let status = self.broadcast.status_now();
        if status.elsewhere.is_some() || !self.offers {
            return;
        }
        let made = runs.iter().find(|run| replay::writer(&self.path(run)).is_some());
        let shown = status.run.as_deref();
        let next = match made {
            Some(run) if shown != Some(self.path(run).as_str()) => Some(run),
            // A start that failed before its scan began stays to be read.
            None if shown.is_none() && status.notice.is_none() => runs.first(),
            _ => None,
        };
        // What cannot be read now is tried again at the next look.
        if let Some(run) = next {
            drop(self.show_quietly(&self.path(run)));
        }
    }
}

/// Length and time of the files of a record.
fn state(run: &Utf8Path) -> Vec<(u64, Option<SystemTime>)> {
    ["run.toml", "readings.csv", "events.jsonl", "spectra"]
        .into_iter()
        .filter_map(|name| std::fs::metadata(run.join(name)).ok())
        .map(|file| (file.len(), file.modified().ok()))
        .collect()
}
