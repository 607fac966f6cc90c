//! The record of a run and its job beside the checksums that were recorded of them.

use camino::Utf8Path;
use isolux_record::disk::sha256;
use isolux_record::event::EVENTS_FILE;
use isolux_record::{Run, RunError};

use super::ledger::Ledger;
use crate::run::record::SUMS;
use crate::{Failure, files};

/// Compares the record with its checksums. The run, where nothing that numbers are computed from differs.
///
/// # Errors
/// Exit 3 when the disk refuses; bad input (exit 2) for a run of another format.
pub(super) fn check(run: &Utf8Path, ledger: &mut Ledger) -> Result<Option<Run>, Failure> {
    job(run, ledger)?;
    let read = match Run::read(run) {
        Ok(read) => Some(read),
        Err(RunError::HeaderChanged { what, .. }) => {
            ledger.differs("run.toml", None, format!("was changed after it was written: {what}"));
            ledger
                .notes
                .push("run.toml holds the checksums of the record: nothing else of it was checked".to_owned());
            return Ok(None);
        }
        Err(RunError::Header(error)) => {
            ledger.differs("run.toml", error.line.map(|line| line as u64), error.to_string());
            return Ok(None);
        }
        Err(RunError::Damaged { damage, .. }) => {
            for sentence in damage {
                let (name, line, what) = located(run, &sentence);
                ledger.differs(&name, line, what);
            }
            None
        }
        Err(error @ RunError::Disk(_)) => return Err(Failure::instrument(error)),
        Err(error) => return Err(Failure::bad_input(error)),
    };
    let header = match &read {
        Some(read) => read.header.clone(),
        None => isolux_record::RunHeader::read(run).map_err(Failure::bad_input)?,
    };
    let sound: Vec<String> = std::iter::once("readings.csv".to_owned())
        .chain(header.spectrum.iter().map(isolux_record::run::SpectrumEntry::file))
        .chain(header.sweep.iter().map(isolux_record::sweeps::SweepEntry::file))
        .filter(|name| !ledger.has_difference(name))
        .collect();
    ledger.agrees("run.toml", "its own checksum; it holds plan, station and calibration");
    let stopped = header.stopped.as_ref();
    for name in sound {
        let rows = name == "readings.csv" && stopped.is_none();
        ledger.agrees(
            &name,
            if rows {
                "the checksums of its rows"
            } else {
                "its SHA-256 in run.toml"
            },
        );
    }
    if let Some(hash) = stopped.and_then(|stopped| stopped.events_sha256.as_ref()) {
        let file = run.join(EVENTS_FILE);
        if !file.is_file() {
            ledger.differs(EVENTS_FILE, None, "is missing");
        } else if sha256(&files::read(&file)?) == *hash {
            ledger.agrees(EVENTS_FILE, "its SHA-256 in run.toml");
        } else {
            ledger.differs(
                EVENTS_FILE,
                None,
                "is not the file that was recorded: its SHA-256 is another",
            );
        }
    }
    if stopped.is_none() {
        let note = "the run was never stopped, its program was killed: no checksum speaks for its events, and none for \
                    rows that were lost from the end";
        ledger.notes.push(note.to_owned());
    }
    Ok(read)
}

/// File, line and sentence of a damage, which begins with them.
fn located(run: &Utf8Path, sentence: &str) -> (String, Option<u64>, String) {
    let in_run = sentence
        .strip_prefix(run.as_str())
        .unwrap_or(sentence)
        .trim_start_matches(['/', '\\']);
    let (place, what) = in_run.split_once(": ").unwrap_or(("readings.csv", in_run));
    let (name, line) = match place.split_once(':') {
        Some((name, line)) => (name, line.split(':').next().and_then(|line| line.parse().ok())),
        None => (place, None),
    };
    // A SHA-256 knows no line; the checksum of the row that says more follows it.
    let line = line.or_else(|| {
        let (_, rest) = what.split_once(&format!("{name}:"))?;
        let digits = rest.split(|c: char| !c.is_ascii_digit()).next()?;
        digits.parse().ok()
    });
    (
        name.to_owned(),
        line,
        what.replace(&format!("{run}/"), "").replace(&format!("{run}\\"), ""),
    )
}

/// Compares the files of the job with the list beside them.
fn job(run: &Utf8Path, ledger: &mut Ledger) -> Result<(), Failure> {
    let folder = run.join("job");
    let list = folder.join(SUMS);
    if !list.is_file() {
        return Ok(());
    }
    let list_name = format!("job/{SUMS}");
    let text = String::from_utf8_lossy(&files::read(&list)?).into_owned();
    let mut all = true;
    for (line, row) in (1..).zip(text.lines()) {
        let Some((hash, name)) = row.split_once("  ") else {
            ledger.differs(&list_name, Some(line), "is not a SHA-256 and a name");
            all = false;
            continue;
        };
        let in_run = format!("job/{name}");
        if !folder.join(name).is_file() {
            ledger.differs(
                &in_run,
                None,
                format!("is missing: line {line} of {list_name} lists it"),
            );
            all = false;
        } else if sha256(&files::read(&folder.join(name))?) == hash {
            ledger.agrees(&in_run, format!("its SHA-256 in {list_name}"));
        } else {
            let other = |other: &str| format!("does not agree with {other}; one of the two was changed");
            ledger.differs(&in_run, None, other(&format!("line {line} of {list_name}")));
            ledger.differs(&list_name, Some(line), other(&in_run));
            all = false;
        }
    }
    if all {
        ledger.agrees(&list_name, "the files that it lists");
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_damage_is_placed_in_its_file_and_line() {
        let run = Utf8Path::new("/lab/day: 2");
        for (sentence, name, line) in [
            (
                "/lab/day: 2/readings.csv:17: its checksum is another",
                "readings.csv",
                Some(17),
            ),
            ("/lab/day: 2/readings.csv:17:3: not a number", "readings.csv", Some(17)),
            ("/lab/day: 2/readings.csv: is missing", "readings.csv", None),
            (
                "/lab/day: 2/spectra/000.csv: is another; /lab/day: 2/spectra/000.csv:9: the row is damaged",
                "spectra/000.csv",
                Some(9),
            ),
        ] {
            let found = located(run, sentence);
            assert_eq!((found.0.as_str(), found.1), (name, line), "{sentence}");
            assert!(!found.2.contains("/lab"), "{}", found.2);
        }
    }
}
