//! What was found of each file of a run.

use std::collections::BTreeMap;

use camino::Utf8Path;
use isolux_record::RunLock;

use super::verification::{Difference, FileVerdict, Signed, State, Verification};
use crate::Failure;
use crate::run::record::SUMS;

/// Name of the signature in the run directory.
pub(super) const SIGNATURE: &str = "SHA256SUMS.minisig";

#[derive(Debug, Default)]
struct Entry {
    agrees: Vec<String>,
    differs: Vec<Difference>,
    unchecked: Option<String>,
}

/// Collects what is found.
#[derive(Debug, Default)]
pub(super) struct Ledger {
    entries: BTreeMap<String, Entry>,
    pub notes: Vec<String>,
}

impl Ledger {
    /// Every file of the run directory, none of them checked yet.
    ///
    /// # Errors
    /// Exit 3 when the disk refuses.
    pub fn of(run: &Utf8Path) -> Result<Self, Failure> {
        let mut ledger = Self::default();
        for name in names(run)? {
            ledger.entries.insert(name, Entry::default());
        }
        Ok(ledger)
    }

    pub fn names(&self) -> impl Iterator<Item = &str> {
        self.entries.keys().map(String::as_str)
    }

    /// Something speaks for the file.
    pub fn agrees(&mut self, name: &str, because: impl Into<String>) {
        self.entries
            .entry(name.to_owned())
            .or_default()
            .agrees
            .push(because.into());
    }

    pub fn differs(&mut self, name: &str, line: Option<u64>, what: impl Into<String>) {
        let what = what.into();
        let entry = self.entries.entry(name.to_owned()).or_default();
        entry.differs.push(Difference { line, what });
    }

    /// Why nothing speaks for the file, where nothing else does.
    pub fn unchecked(&mut self, name: &str, why: impl Into<String>) {
        self.entries.entry(name.to_owned()).or_default().unchecked = Some(why.into());
    }

    pub fn has_difference(&self, name: &str) -> bool {
        self.entries.get(name).is_some_and(|entry| !entry.differs.is_empty())
    }

    pub fn is_sound(&self, name: &str) -> bool {
        self.entries
            .get(name)
            .is_some_and(|entry| entry.differs.is_empty() && !entry.agrees.is_empty())
    }

    /// What was found, all in all.
    pub fn verdict(
        self,
        run: &Utf8Path,
        verified_by: &str,
        recorded_by: Option<String>,
        mut reduced_by: Vec<String>,
        signature: Option<Signed>,
    ) -> Verification {
        reduced_by.sort();
        reduced_by.dedup();
        let files: Vec<FileVerdict> = self
            .entries
            .into_iter()
            .map(|(name, entry)| found(name, entry))
            .collect();
        Verification {
            run: run.to_string(),
            verified_by: verified_by.to_owned(),
            recorded_by,
            reduced_by,
            agrees: files.iter().all(|file| file.state != State::Differs),
            files,
            signature,
            notes: self.notes,
        }
    }
}

fn found(name: String, entry: Entry) -> FileVerdict {
    let state = match (entry.differs.is_empty(), entry.agrees.is_empty()) {
        (false, _) => State::Differs,
        (true, false) => State::Agrees,
        (true, true) => State::NotChecked,
    };
    let unchecked = || {
        let why = "no checksum and no computation speaks for it; a signature of the run would".to_owned();
        vec![entry.unchecked.clone().unwrap_or(why)]
    };
    FileVerdict {
        because: if state == State::NotChecked {
            unchecked()
        } else {
            entry.agrees
        },
        name,
        state,
        differs: entry.differs,
    }
}

/// The files of a run by name, without its lock.
///
/// # Errors
/// Exit 3 when the disk refuses.
pub(super) fn names(run: &Utf8Path) -> Result<Vec<String>, Failure> {
    fn below(folder: &Utf8Path, before: &str, names: &mut Vec<String>) -> std::io::Result<()> {
        for entry in folder.read_dir_utf8()? {
            let entry = entry?;
            let name = format!("{before}{}", entry.file_name());
            if entry.path().is_dir() {
                below(entry.path(), &format!("{name}/"), names)?;
            } else if name != RunLock::FILE {
                names.push(name);
            }
        }
        Ok(())
    }
    let mut names = Vec::new();
    below(run, "", &mut names).map_err(|error| Failure::instrument(format!("{run}: cannot be listed: {error}")))?;
    names.sort();
    Ok(names)
}

/// Whether a name is of the list of the files or its signature, which the list cannot hold.
pub(super) fn is_list(name: &str) -> bool {
    name == SUMS || name == SIGNATURE
}
