//! A run on a small card: what was measured, how it ended, its main numbers, and its light in a small picture.

use camino::{Utf8Path, Utf8PathBuf};
use isolux_formats::{Content, ReadOptions};
use isolux_record::run::StopHow;
use isolux_record::{Reading, ReadingKind, Role, RunHeader, RunLock, readings};
use isolux_reduce::{Budget, Quantity};
use isolux_report::plots::{Curves, thumbnail};
use serde::Serialize;

use crate::Failure;
use crate::files;
use crate::formats::inspect;

/// Readings are drawn where their file is at most so long, in bytes; of more the picture waits for the results.
const LONGEST: u64 = 8 << 20;

/// What a card shows.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Card {
    /// The luminaire as far as it is stated, else the bench.
    pub of: String,
    /// When it was begun, UTC.
    pub started_utc: String,
    /// How it stands.
    pub state: Standing,
    /// Name and value of the main numbers; none before the reduction.
    pub numbers: Vec<(&'static str, String)>,
    /// Its light, SVG; none where there is none yet.
    pub picture: Option<String>,
    /// Whether there is a report.
    pub report: bool,
}

/// How a run stands.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Standing {
    /// A program writes it now.
    BeingMade,
    /// Every point was read.
    Completed,
    /// Somebody ended it.
    Interrupted,
    /// An instrument or the system failed.
    Failed,
    /// Its program was killed.
    BrokenOff,
}

/// The card of the run directory `run`.
///
/// # Errors
/// Bad input (exit 2) for what is no run directory.
pub fn card(run: &Utf8Path) -> Result<Card, Failure> {
    let header = RunHeader::read(run).map_err(Failure::bad_input)?;
    let results = ["results", "results-partial"].map(|name| run.join(name));
    let results = results.into_iter().find(|folder| folder.is_dir());
    let of = [&header.luminaire.maker, &header.luminaire.name];
    let of: Vec<&str> = of.into_iter().filter_map(Option::as_deref).collect();
    let bench = header
        .station
        .document()
        .name
        .as_deref()
        .unwrap_or("bench without a name");
    Ok(Card {
        of: if of.is_empty() { bench.to_owned() } else { of.join(" ") },
        started_utc: header.started_utc.clone(),
        state: standing(run, &header),
        numbers: results.as_deref().and_then(numbers).unwrap_or_default(),
        picture: picture(run, results.as_deref()),
        report: run.join("results/report.html").is_file(),
    })
}

fn standing(run: &Utf8Path, header: &RunHeader) -> Standing {
    match header.stopped.as_ref().map(|stopped| stopped.how) {
        Some(StopHow::Completed) => Standing::Completed,
        Some(StopHow::Interrupted) => Standing::Interrupted,
        Some(StopHow::Failed) => Standing::Failed,
        None if RunLock::held(run).is_some() => Standing::BeingMade,
        None => Standing::BrokenOff,
    }
}

/// The first file of a folder with this beginning and this extension: results of a part of a scan have `partial` in
/// their names.
fn file(folder: &Utf8Path, beginning: &str, extension: &str) -> Option<Utf8PathBuf> {
    let names = crate::run::folder::files(folder);
    let plain = format!("{beginning}.{extension}");
    let partial = format!("{beginning}.partial.{extension}");
    let name = names.into_iter().find(|name| *name == plain || *name == partial)?;
    Some(folder.join(name))
}

fn numbers(results: &Utf8Path) -> Option<Vec<(&'static str, String)>> {
    let budget: Budget = files::read_json(&file(results, "budget", "json")?).ok()?;
    let wanted = [
        ("luminous flux", Some(&budget.flux)),
        ("largest intensity", Some(&budget.i_max)),
        ("CCT", budget.cct.as_ref()),
    ];
    let known = wanted.into_iter().filter_map(|(name, of)| Some((name, number(of?))));
    Some(known.collect())
}

/// A quantity to the digits of the report; why it has no uncertainty is said there.
fn number(of: &Quantity) -> String {
    let (stated, unit) = (of.rounded(), &of.unit);
    match of.u {
        Some(_) => format!("{} ± {} {unit} (k = 2)", stated.value, stated.expanded),
        None => format!("{} {unit}, no uncertainty", stated.value),
    }
}

fn picture(run: &Utf8Path, results: Option<&Utf8Path>) -> Option<String> {
    let reduced = results.and_then(|folder| file(folder, "luminaire", "ldt"));
    let curves = match reduced {
        Some(ldt) => {
            let found = inspect::file(&ldt, ReadOptions::default()).into_iter();
            let light = found.filter_map(|one| match one.content {
                Some(Content::Distribution(light)) => Some(Curves::of(&light.intensity)),
                _ => None,
            });
            light.into_iter().next()?
        }
        None => as_read(run)?,
    };
    thumbnail(&curves)
}

/// E·d² of the readings, not corrected.
fn as_read(run: &Utf8Path) -> Option<Curves> {
    let file = run.join("readings.csv");
    if std::fs::metadata(&file).ok()?.len() > LONGEST {
        return None;
    }
    let rows = readings::parse(&file, &std::fs::read(&file).ok()?).ok()?.rows;
    Some(Curves {
        c0: through(&rows, 0.0),
        c90: through(&rows, 90.0),
    })
}

/// Readings in the half-planes C and C + 180°, by γ, which is below zero in the second.
fn through(rows: &[Reading], c_deg: f64) -> Vec<(f64, f64)> {
    let mut curve: Vec<(f64, f64)> = rows
        .iter()
        .filter(|row| row.role == Role::Point && row.kind == ReadingKind::Lit)
        .filter_map(|row| {
            let turned = (row.c_target_deg - c_deg).rem_euclid(360.0);
            let sign = match turned {
                0.0 => 1.0,
                180.0 => -1.0,
                _ => return None,
            };
            let distance_m = row.distance_mm * 1e-3;
            Some((
                sign * row.gamma_target_deg,
                row.illuminance_lx? * distance_m * distance_m,
            ))
        })
        .collect();
    curve.sort_by(|a, b| a.0.total_cmp(&b.0));
    curve
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_number_is_stated_as_the_report_does() {
        let flux = Quantity::new(338.24, "lm", [("calibration", 1.7)]);
        assert_eq!(number(&flux), "338 ± 3 lm (k = 2)");
        let lacking = flux.lacking(["not corrected for stray light".to_owned()]);
        assert_eq!(number(&lacking), "338 lm, no uncertainty");
        let cct = Quantity::new(5896.69, "K", [("noise", 12.7)]);
        assert_eq!(number(&cct), "5897 ± 25 K (k = 2)");
    }
}
