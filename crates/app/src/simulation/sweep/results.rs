//! The points of a sweep as files: `sweep.json`, a table, and a chart for each key.

use camino::Utf8Path;
use isolux_report::sweep::{Line, sweep};
use serde::{Deserialize, Serialize, Serializer};

use crate::Failure;
use crate::files::{self, Overwrite};
use crate::simulation::simulate::Facts;

/// One point: the values of the varied keys and what came out. `elapsed_s` is left out, so that bytes repeat.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Point {
    pub index: usize,
    pub vary: Vec<serde_json::Value>,
    #[serde(serialize_with = "lasting")]
    pub result: Facts,
}

/// The points of a sweep or of a shard of it, as `sweep.json`.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Results {
    pub format: String,
    /// Of the sweep file, its scene and the scene's model: shards of other inputs do not belong together.
    pub inputs_sha256: String,
    pub keys: Vec<String>,
    pub points: usize,
    pub results: Vec<Point>,
}

/// Without the wall clock, in the order of the keys.
fn lasting<S: Serializer>(facts: &Facts, to: S) -> Result<S::Ok, S::Error> {
    let mut value = serde_json::to_value(facts).map_err(serde::ser::Error::custom)?;
    if let Some(object) = value.as_object_mut() {
        object.remove("elapsed_s");
    }
    value.serialize(to)
}

pub fn write(folder: &Utf8Path, table: &Results, overwrite: Overwrite) -> Result<(), Failure> {
    let mut json = serde_json::to_string_pretty(table).map_err(Failure::instrument)?;
    json.push('\n');
    files::write(&folder.join("sweep.csv"), &csv(table)?, overwrite)?;
    for (position, key) in table.keys.iter().enumerate() {
        if let Some(svg) = chart(table, position) {
            let name = format!(
                "{}.svg",
                key.replace(|letter: char| !letter.is_ascii_alphanumeric(), "_")
            );
            files::write(&folder.join(name), svg.as_bytes(), overwrite)?;
        }
    }
    files::write(&folder.join("sweep.json"), json.as_bytes(), overwrite)
}

const COLUMNS: [&str; 8] = [
    "unit",
    "mean",
    "u_mean_numeric",
    "min",
    "max",
    "std",
    "uniformity_min_over_mean",
    "relative_error_per_pixel",
];

fn csv(table: &Results) -> Result<Vec<u8>, Failure> {
    let plain = |value: &serde_json::Value| match value {
        serde_json::Value::Null => String::new(),
        serde_json::Value::String(text) => text.clone(),
        serde_json::Value::Array(list) => list.iter().map(ToString::to_string).collect::<Vec<_>>().join(" "),
        other => other.to_string(),
    };
    let mut writer = csv::Writer::from_writer(Vec::new());
    writer
        .write_record(table.keys.iter().map(String::as_str).chain(COLUMNS))
        .map_err(Failure::instrument)?;
    for point in &table.results {
        let varied = point.vary.iter().map(plain);
        let facts = serde_json::to_value(&point.result).map_err(Failure::instrument)?;
        let facts = COLUMNS.iter().map(|column| plain(&facts[*column]));
        writer.write_record(varied.chain(facts)).map_err(Failure::instrument)?;
    }
    writer.into_inner().map_err(Failure::instrument)
}

/// Mean and maximum against one key, a line for each combination of the others; `None` for a key without numbers.
fn chart(table: &Results, position: usize) -> Option<String> {
    let number = |value: &serde_json::Value| {
        value
            .as_f64()
            .or_else(|| value.get(0).and_then(serde_json::Value::as_f64))
    };
    let mut lines: Vec<Line> = Vec::new();
    for point in &table.results {
        let x = number(&point.vary[position])?;
        let others: Vec<String> = table
            .keys
            .iter()
            .zip(&point.vary)
            .enumerate()
            .filter(|(k, _)| *k != position)
            .map(|(_, (key, value))| format!("{key} {value}"))
            .collect();
        let entry = [x, point.result.mean, point.result.max];
        let name = others.join(", ");
        match lines.iter_mut().find(|line| line.name == name) {
            Some(line) => line.points.push(entry),
            None => lines.push(Line {
                name,
                points: vec![entry],
            }),
        }
    }
    let unit = table.results.first()?.result.unit;
    Some(sweep(&table.keys[position], unit.symbol(), &lines))
}
