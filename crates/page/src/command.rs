//! What a tab can command, and what is ordered by it.

use camino::Utf8PathBuf;
use isolux_app::study::next::Shown;
use serde::Deserialize;

/// A command of the page.
#[derive(Debug, Clone, PartialEq, Eq, Deserialize)]
#[serde(tag = "command", rename_all = "snake_case", deny_unknown_fields)]
pub enum Command {
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
    /// Adds the effects of the diagnosis that is shown to its model.
    AddToModel {},
    /// Takes them out again.
    TakeOutOfModel {},
    /// Carries out the measurement that the diagnosis proposes, after its plan was shown.
    Measure {
        /// Number of the proposal.
        number: usize,
        /// Fingerprint of the plan that was shown: another plan is not carried out.
        seen: String,
    },
    /// What the person at the bench answers.
    Answer {
        /// Number of the question.
        number: u64,
        /// Who did it; empty: not done.
        who: String,
    },
}

/// What is to be carried out.
#[derive(Debug, Clone, PartialEq)]
pub enum Order {
    /// A day.
    Day {
        /// The job; none: the built-in virtual darkroom.
        job: Option<Utf8PathBuf>,
        /// The folder of the day.
        out: Utf8PathBuf,
    },
    /// A further measurement for the diagnosis of a run.
    Measurement {
        /// The run.
        run: Utf8PathBuf,
        /// What was shown and confirmed.
        shown: Box<Shown>,
        /// The folder of the measurement.
        out: Utf8PathBuf,
    },
}
