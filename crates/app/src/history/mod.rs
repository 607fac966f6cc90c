//! `history`: the diary of a bench, `history.jsonl` beside its station, and control charts of it.

mod chart;

use std::fs::OpenOptions;
use std::io::{ErrorKind, Write as _};

use camino::{Utf8Path, Utf8PathBuf};
use isolux_record::run::BenchCheck;
use isolux_report::plots::{ControlChart, ControlPoint, control_chart};
use serde::{Deserialize, Serialize};

use crate::Failure;
use crate::files::{self, Overwrite};

pub use chart::{Chart, Limits};

/// The diary, beside the station file.
pub const FILE: &str = "history.jsonl";

/// One line of the diary. Lines are added and never changed.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Entry {
    /// When it was written, RFC 3339.
    pub time_utc: String,
    /// What it is of.
    pub kind: Kind,
    /// What the value is.
    pub quantity: String,
    /// The value.
    pub value: f64,
    /// Its unit; empty for a number.
    pub unit: String,
    /// Its standard uncertainty (k = 1).
    pub u: f64,
    /// The run that it comes from, as it was called.
    pub run: String,
    /// SHA-256 of run.toml of that run.
    pub record_sha256: String,
}

/// What a line of the diary is of.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Kind {
    /// A calibration with a standard lamp.
    Calibration,
    /// A lamp with a sample number, measured on a day.
    LampCheck,
    /// The mean reading at the reference point on a day.
    Reference,
    /// The mean reading of the capped lux meter on a day.
    Dark,
}

/// Where the diary of the bench of `station` lies.
pub fn file(station: &Utf8Path) -> Utf8PathBuf {
    station.parent().unwrap_or(Utf8Path::new("")).join(FILE)
}

/// The diary of the bench of `station`; empty where there is none yet.
///
/// # Errors
/// Bad input (exit 2) with the line that is none.
pub fn read(station: &Utf8Path) -> Result<Vec<Entry>, Failure> {
    let path = file(station);
    if !path.exists() {
        return Ok(Vec::new());
    }
    let bytes = files::read(&path)?;
    let text = String::from_utf8(bytes).map_err(|_| Failure::bad_input(format!("{path}: is not UTF-8 text")))?;
    let entry = |(place, line): (usize, &str)| {
        serde_json::from_str(line).map_err(|error| {
            Failure::bad_input(format!("{path}:{}: {error}", place + 1))
                .help("lines are only added; restore this one from a copy")
        })
    };
    text.lines().enumerate().map(entry).collect()
}

/// Adds lines to the diary of the bench of `station`; what is there of the same record is not added again.
///
/// # Errors
/// As [`read`]; exit 3 when the disk refuses.
pub(crate) fn add(station: &Utf8Path, entries: &[Entry]) -> Result<(), Failure> {
    let already = read(station)?;
    let of = |entry: &Entry, other: &Entry| {
        entry.record_sha256 == other.record_sha256 && entry.quantity == other.quantity && entry.value == other.value
    };
    let new = entries
        .iter()
        .filter(|entry| !already.iter().any(|other| of(entry, other)));
    let mut text = String::new();
    for entry in new {
        text += &serde_json::to_string(entry).map_err(Failure::instrument)?;
        text.push('\n');
    }
    if text.is_empty() {
        return Ok(());
    }
    let path = file(station);
    let failed = |error: std::io::Error| Failure::instrument(format!("{path}: {error}"));
    let mut diary = OpenOptions::new()
        .append(true)
        .create(true)
        .open(&path)
        .map_err(failed)?;
    // In one piece: a line of which a part was written is none.
    diary.write_all(text.as_bytes()).map_err(failed)?;
    match diary.sync_all() {
        Err(error) if error.kind() != ErrorKind::Unsupported => Err(failed(error)),
        _ => Ok(()),
    }
}

/// Control charts of the diary of the bench of `station`, one a quantity; written as pictures into `out`, where that is
/// asked for: their names.
///
/// # Errors
/// As [`read`]; bad input (exit 2) for pictures that exist and may not be replaced.
pub fn charts(
    station: &Utf8Path,
    out: Option<&Utf8Path>,
    overwrite: Overwrite,
) -> Result<(Vec<Chart>, Vec<Utf8PathBuf>), Failure> {
    let entries = read(station)?;
    if entries.is_empty() {
        return Err(Failure::bad_input(format!("{} is not there or empty", file(station)))
            .help("`isolux calibrate` and `isolux run` write it beside the station"));
    }
    let charts = chart::of(&entries);
    let mut written = Vec::new();
    if let Some(out) = out {
        for chart in &charts {
            let name: String = (chart.quantity.chars())
                .map(|letter| if letter.is_ascii_alphanumeric() { letter } else { '-' })
                .collect();
            let path = out.join(format!("{}.svg", name.replace("--", "-")));
            files::write(&path, picture(chart).as_bytes(), overwrite)?;
            written.push(path);
        }
    }
    Ok((charts, written))
}

/// What the diary of the bench of `station` says of each quantity, as a run keeps it.
///
/// # Errors
/// As [`read`].
pub(crate) fn checks(station: &Utf8Path) -> Result<Vec<BenchCheck>, Failure> {
    let check = |chart: Chart| {
        let last = chart.points.last()?;
        Some(BenchCheck {
            quantity: chart.quantity.clone(),
            time_utc: last.time_utc.clone(),
            in_control: chart.limits.map(|_| !chart.out_of_control),
            sentence: chart.sentence.clone(),
        })
    };
    Ok(judged(station)?.into_iter().filter_map(check).collect())
}

/// The chart of each quantity in the diary of the bench of `station`.
///
/// # Errors
/// As [`read`].
pub(crate) fn judged(station: &Utf8Path) -> Result<Vec<Chart>, Failure> {
    Ok(chart::of(&read(station)?))
}

fn picture(chart: &Chart) -> String {
    let points = chart.points.iter().map(|entry| ControlPoint {
        label: entry.time_utc.chars().take(10).collect(),
        value: entry.value,
        expanded: 2.0 * entry.u,
    });
    control_chart(&ControlChart {
        title: chart.quantity.clone(),
        unit: chart
            .points
            .first()
            .map_or_else(String::new, |entry| entry.unit.clone()),
        points: points.collect(),
        mean_and_s: chart.limits.map(|limits| (limits.mean, limits.s)),
    })
}
