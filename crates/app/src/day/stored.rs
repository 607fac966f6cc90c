//! The results that lie in a run's folder, for its report: the reduction that made them, and which of the files beside
//! them belong to another one.

use camino::Utf8Path;
use isolux_conformity::Conformity;
use isolux_diagnose::document::{Document, Independence, Verdict};
use isolux_diagnose::on_axis::Comparison;
use isolux_record::Run;
use isolux_reduce::{Budget, Reduction};
use isolux_report::day::{DayResults, Diagnosed};
use isolux_sim::simulation::Facts;
use serde::Serialize;
use serde_json::Value;

use crate::Failure;
use crate::files;
use crate::run::{record, reduce};

/// Numbers that were computed twice from the same bytes may differ by the last digits of another machine's functions.
const ALIKE_REL: f64 = 1e-9;

/// The reduction that made `results/`: the run reduced again as `budget.json` says that it was, and the same numbers.
///
/// # Errors
/// Bad input (exit 2) where there is no budget, or this record does not give it.
pub(crate) fn reduction(folder: &Utf8Path, run: &Run) -> Result<Reduction, Failure> {
    let places = [("results", "budget.json"), ("results-partial", "budget.partial.json")];
    let Some((results, file)) = places
        .map(|(results, file)| (folder.join(results), folder.join(results).join(file)))
        .into_iter()
        .find(|(_, file)| file.is_file())
    else {
        return Err(Failure::bad_input(format!("{folder}: no results/budget.json"))
            .help(format!("reduce the run first: isolux reduce {folder}")));
    };
    record::check_results(&results)?;
    let budget: Budget = files::read_json(&file)?;
    let options = reduce::options_of(&file)?.unwrap_or_default();
    let with = reduce::kept_model(&results)?;
    for model in std::iter::once(None).chain(with.map(Some)) {
        if let Ok(reduction) = isolux_reduce::reduce(run, &options, model)
            && same(
                &isolux_reduce::budget_of(&reduction).map_err(Failure::bad_input)?,
                &budget,
            )?
        {
            return Ok(reduction);
        }
    }
    Err(
        Failure::bad_input(format!("{file}: reducing this record again gives other numbers")).help(
            "the results are of another record, model or version of isolux: make them again with isolux reduce --force",
        ),
    )
}

/// The sentence of the diagnosis in `results/`, if it is of the reduction there (`own_model`: of a model that the job
/// names). Names of the files that are of another reduction go to `day_results.stale`.
///
/// # Errors
/// Bad input (exit 2) for a file that cannot be read.
pub(super) fn beside(folder: &Utf8Path, own_model: bool, day_results: &mut DayResults) -> Result<(), Failure> {
    let results = &day_results.folder.clone();
    let file = results.join("result.json");
    if file.is_file() {
        let (now, then): (_, Facts) = (&day_results.simulation.facts, files::read_json(&file)?);
        let numbers = |facts: &Facts| (facts.mean, facts.min, facts.max, facts.pixels, facts.size_mm);
        if !same(&numbers(now), &numbers(&then))? {
            day_results
                .stale
                .extend(["irradiance.npy", "irradiance.png", "result.json"]);
        }
    }
    let file = results.join("comparison.json");
    if file.is_file() && !same(&day_results.comparison, &files::read_json::<Option<Comparison>>(&file)?)? {
        day_results.stale.push("comparison.json");
    }
    let file = results.join("conformity.json");
    if file.is_file() && !same(&day_results.conformity, &files::read_json::<Conformity>(&file)?)? {
        day_results.stale.push("conformity.json");
    }
    let file = results.join("diagnosis.json");
    let made = results.join("diagnosis/diagnosis.json");
    if file.is_file() || made.is_file() {
        // The one is a copy of the other.
        if std::fs::read(&made).ok() != std::fs::read(&file).ok() {
            return Err(
                Failure::bad_input(format!("{file} and {made} differ: one of them was changed"))
                    .help(format!("make them again: isolux run --resume {folder}")),
            );
        }
        if own_model || diagnosed_here(results)? {
            let answer: Document = files::read_json(&file)?;
            day_results.diagnosis = Some(Diagnosed {
                good: answer.verdict == Verdict::Consistent,
                same_record: answer.independence == Independence::SameRun,
                plain: answer.plain,
                details: Vec::new(),
            });
        } else {
            day_results.stale.push("diagnosis.json");
        }
    }
    Ok(())
}

/// Whether the diagnosis beside the results began with the model that lies there: the same files, uncertainties and
/// origin.
fn diagnosed_here(results: &Utf8Path) -> Result<bool, Failure> {
    let same = ["luminaire.ldt", "luminaire.spdx"].into_iter().all(|name| {
        let bytes = |folder: &Utf8Path| std::fs::read(folder.join(name)).ok();
        bytes(results) == bytes(&results.join("diagnosis"))
    });
    if !same {
        return Ok(false);
    }
    let luminaire = |file: &Utf8Path| -> Result<[Option<toml::Value>; 2], Failure> {
        if !file.is_file() {
            return Ok([None, None]);
        }
        let text = String::from_utf8_lossy(&files::read(file)?).into_owned();
        let table: toml::Table = text
            .parse()
            .map_err(|error| Failure::bad_input(format!("{file}: {error}")))?;
        let luminaire = table.get("luminaire");
        Ok(["u", "provenance"].map(|key| luminaire.and_then(|luminaire| luminaire.get(key)).cloned()))
    };
    let [here, there] = ["luminaire.model.toml", "diagnosis/model.baseline.toml"].map(|name| results.join(name));
    Ok(luminaire(&here)? == luminaire(&there)?)
}

/// Equal but for the last digits of numbers; sentences may be worded anew.
fn same<T: Serialize>(now: &T, then: &T) -> Result<bool, Failure> {
    let value = |of: &T| serde_json::to_value(of).map_err(Failure::instrument);
    Ok(alike(&value(now)?, &value(then)?))
}

fn alike(a: &Value, b: &Value) -> bool {
    match (a, b) {
        (Value::Number(a), Value::Number(b)) => {
            let (a, b) = (a.as_f64().unwrap_or(f64::NAN), b.as_f64().unwrap_or(f64::NAN));
            (a - b).abs() <= ALIKE_REL * a.abs().max(b.abs())
        }
        (Value::Array(a), Value::Array(b)) => a.len() == b.len() && a.iter().zip(b).all(|(a, b)| alike(a, b)),
        (Value::Object(a), Value::Object(b)) => {
            a.len() == b.len()
                && a.iter()
                    .all(|(key, a)| key == "notes" || b.get(key).is_some_and(|b| alike(a, b)))
        }
        _ => a == b,
    }
}
