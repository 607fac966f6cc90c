//! Runs as use cases read them: what is damaged comes with what can be done about it.

use std::collections::BTreeMap;

use camino::Utf8Path;
pub use isolux_record::Run;
use isolux_record::disk::sha256;
pub use isolux_record::reading::Reading;
pub use isolux_record::spectra::{DarkSubtraction, Pixel, SpectrumRecord};
use isolux_record::{RunError, RunLock};
use serde::Deserialize;

use crate::{Failure, files};

/// File in a folder of a run with the SHA-256 of the other files, as `sha256sum` writes and checks it.
pub(crate) const SUMS: &str = "SHA256SUMS";

/// Reads the run in `path`.
///
/// # Errors
/// Bad input (exit 2): no run, or one that is not as it was recorded.
pub fn read(path: &Utf8Path) -> Result<Run, Failure> {
    Run::read(path).map_err(|error| Failure {
        help: help(&error),
        ..Failure::bad_input(error)
    })
}

/// Reads a run that no other process is writing: a part of a scan is no result.
///
/// # Errors
/// Exit 3 naming who writes it; as [`read`].
pub fn read_at_rest(path: &Utf8Path) -> Result<Run, Failure> {
    let us = std::process::id();
    let held = RunLock::held(path).filter(|held| held.holder.as_ref().is_none_or(|holder| holder.pid != us));
    match held {
        Some(held) => Err(
            Failure::instrument(format!("{path} is in use by {held}: its record is not complete"))
                .help("wait until it ends"),
        ),
        None => read(path),
    }
}

/// What to do about a run that cannot be used.
pub(crate) fn help(error: &RunError) -> Option<String> {
    match error {
        RunError::Damaged { path, .. } => Some(format!(
            "restore the damaged files from a copy; without one, `isolux run --resume {path} --reread` (or `isolux scan STATION \
             PLAN --resume {path} --reread`) keeps what is whole, sets the damaged files aside in the run, and reads again what \
             is missing"
        )),
        _ => None,
    }
}

/// The lines of [`SUMS`] for these files.
pub(crate) fn sums<'a>(files: impl IntoIterator<Item = (&'a str, &'a [u8])>) -> String {
    files.into_iter().fold(String::new(), |text, (name, bytes)| {
        text + &format!("{}  {name}\n", sha256(bytes))
    })
}

/// Compares the files of `folder` with its [`SUMS`].
///
/// # Errors
/// Bad input (exit 2) with the file that is missing or not what was written, or that is among `needed` and not in the
/// list.
pub(crate) fn check_sums(folder: &Utf8Path, needed: &[&str]) -> Result<(), Failure> {
    let file = folder.join(SUMS);
    if !file.is_file() {
        return Err(Failure::bad_input(format!(
            "{file} is missing: {folder} cannot be compared with what was written"
        )));
    }
    let text =
        String::from_utf8(files::read(&file)?).map_err(|_| Failure::bad_input(format!("{file}: is not UTF-8 text")))?;
    let mut listed = BTreeMap::new();
    for (place, line) in text.lines().enumerate() {
        let (hash, name) = line
            .split_once("  ")
            .ok_or_else(|| Failure::bad_input(format!("{file}:{}: not a SHA-256 and a name", place + 1)))?;
        listed.insert(name.to_owned(), hash.to_owned());
    }
    if let Some(name) = needed.iter().find(|name| !listed.contains_key(**name)) {
        return Err(Failure::bad_input(format!("{file}: {name} is not listed")));
    }
    compare(folder, &listed, &file)
}

/// Compares the results of a reduction with the list of them in its provenance.json; nothing where nothing was reduced.
///
/// # Errors
/// Bad input (exit 2) with the file that is missing or not what the reduction wrote.
pub(crate) fn check_results(results: &Utf8Path) -> Result<(), Failure> {
    #[derive(Deserialize)]
    struct Provenance {
        results_sha256: BTreeMap<String, String>,
    }
    let partial = results.join("provenance.partial.json");
    let file = if partial.exists() {
        partial
    } else {
        results.join("provenance.json")
    };
    if !file.exists() && !results.join("budget.json").exists() {
        return Ok(());
    }
    let again = "make the results again with `isolux reduce RUN --force`; a file of your own keeps its changes under another name";
    let provenance: Provenance = serde_json::from_slice(&files::read(&file)?)
        .map_err(|error| Failure::bad_input(format!("{file}: {error}")).help(again))?;
    compare(results, &provenance.results_sha256, &file).map_err(|failure| failure.help(again))
}

fn compare(folder: &Utf8Path, listed: &BTreeMap<String, String>, list: &Utf8Path) -> Result<(), Failure> {
    for (name, hash) in listed {
        let file = folder.join(name);
        if sha256(&files::read(&file)?) != *hash {
            let message = format!("{file}: is not the file that was written: its SHA-256 is another than in {list}");
            return Err(Failure::bad_input(message).help("restore it from a copy"));
        }
    }
    Ok(())
}
