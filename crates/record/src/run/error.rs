//! Why a run directory cannot be written or read.

use camino::{Utf8Path, Utf8PathBuf};

use super::format::{FORMAT, FORMAT_3};
use crate::disk::DiskError;
use crate::document::DocumentError;
use crate::readings::Layout;
use crate::run_lock::LOCK_FILE;
use crate::spectra::SpectrumError;

/// A run directory that cannot be written or read.
#[derive(Debug, thiserror::Error)]
pub enum RunError {
    /// The target exists.
    #[error("{path} is not empty; choose another folder for the run")]
    Occupied {
        /// The folder.
        path: Utf8PathBuf,
    },
    /// There is no run there.
    #[error("{path} is no run directory: {}", no_run(*unfinished, path))]
    NoRun {
        /// The folder.
        path: Utf8PathBuf,
        /// Whether a program was killed there before its run began.
        unfinished: bool,
    },
    /// The system refused.
    #[error(transparent)]
    Disk(#[from] DiskError),
    /// A run of a format that is read no more, or not yet.
    #[error(
        "{file}:1: the run has the format {found}; this program reads {FORMAT} and {FORMAT_3}. Reduce it with the \
         version that wrote it (`program` in that file), or measure again"
    )]
    OtherFormat {
        /// run.toml.
        file: Utf8PathBuf,
        /// Its format.
        found: String,
    },
    /// run.toml is not what this program wrote.
    #[error("{file} was changed or damaged after it was written: {what}; restore it from a copy")]
    HeaderChanged {
        /// The file.
        file: Utf8PathBuf,
        /// How that is known.
        what: String,
    },
    /// Files of the run are not what was recorded.
    #[error("{}; {sound}", damage.join("; "))]
    Damaged {
        /// The folder.
        path: Utf8PathBuf,
        /// What is wrong, each with its file.
        damage: Vec<String>,
        /// What is still as it was recorded.
        sound: String,
    },
    /// run.toml cannot be used.
    #[error(transparent)]
    Header(#[from] DocumentError),
    /// A header or a sweep could not be written as TOML.
    #[error("cannot be written as TOML: {0}")]
    Serialise(#[from] toml::ser::Error),
    /// An event could not be written as JSON.
    #[error("events.jsonl: {0}")]
    Event(serde_json::Error),
    /// A spectrum cannot be used.
    #[error(transparent)]
    Spectrum(#[from] SpectrumError),
    /// Another process has taken the folder over from this one.
    #[error("{path} was taken over by another process; this one writes nothing more to it")]
    TakenOver {
        /// The folder.
        path: Utf8PathBuf,
    },
    /// The run is not the one that is to be resumed.
    #[error("cannot resume {path}: {what} is not that of the run")]
    Changed {
        /// The folder.
        path: Utf8PathBuf,
        /// What differs, with both values where they are short.
        what: String,
    },
}

/// Whether a run can begin in `path`: it is not there, is empty, or holds nothing but what
/// [`RunDir::create`](super::RunDir::create) writes before run.toml, left by a program that was killed.
pub fn vacant(path: &Utf8Path) -> bool {
    if !path.exists() {
        return true;
    }
    let Ok(entries) = path.read_dir_utf8() else {
        return false;
    };
    entries.into_iter().all(|entry| {
        let Ok(entry) = entry else { return false };
        let file = entry.path();
        let name = entry.file_name();
        let only = |bytes: &[&[u8]]| std::fs::read(file).is_ok_and(|found| bytes.contains(&found.as_slice()));
        match name {
            "spectra" => file.read_dir_utf8().is_ok_and(|mut entries| entries.next().is_none()),
            "readings.csv" => {
                let headers = Layout::ALL.map(Layout::header);
                only(&[b"".as_slice()]) || headers.iter().any(|header| only(&[header.as_bytes()]))
            }
            "events.jsonl" => only(&[b""]),
            LOCK_FILE => true,
            _ => name.starts_with('.') && file.extension() == Some("part"),
        }
    })
}

fn no_run(unfinished: bool, path: &Utf8Path) -> String {
    if unfinished {
        format!("its program ended before anything was recorded; begin the run anew with --out {path}")
    } else {
        "it has no run.toml".to_owned()
    }
}
