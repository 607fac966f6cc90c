//! What the program writes as JSON it reads as the same types, and the schemas in the book are of these types.

use camino::Utf8Path;
use isolux_app::calibration::Calibration;
use isolux_app::compare::Compared;
use isolux_app::formats::inspect::{self, Quantities};
use isolux_app::modulation::Evaluated;
use isolux_app::verify::Verification;
use isolux_conformity::Conformity;
use isolux_diagnose::document::Document;
use isolux_diagnose::on_axis::Comparison;
use isolux_formats::ReadOptions;
use isolux_reduce::Budget;
use isolux_sim::simulation::Facts;
use schemars::{JsonSchema, schema_for};
use serde::Serialize;
use serde::de::DeserializeOwned;

/// Reads a file as `T`: written again, it says the same in every key and number.
fn same<T: Serialize + DeserializeOwned>(file: &Utf8Path) {
    let text = std::fs::read_to_string(file).unwrap();
    let read: T = serde_json::from_str(&text).unwrap_or_else(|error| panic!("{file}: {error}"));
    let stated: serde_json::Value = serde_json::from_str(&text).unwrap();
    assert_eq!(serde_json::to_value(&read).unwrap(), stated, "{file}");
}

/// The results of a day are read as what they were written from.
pub fn results_are_read_back(folder: &Utf8Path) {
    let results = folder.join("results");
    same::<Budget>(&results.join("budget.json"));
    same::<Conformity>(&results.join("conformity.json"));
    same::<Comparison>(&results.join("comparison.json"));
    same::<Facts>(&results.join("result.json"));
    same::<Document>(&results.join("diagnosis.json"));
    for name in ["luminaire.ldt", "luminaire.spdx"] {
        for found in inspect::file(&results.join(name), ReadOptions::default()) {
            let written = serde_json::to_value(&found).unwrap()["quantities"].to_string();
            let read: Quantities = serde_json::from_str(&written).unwrap();
            assert!(read == found.quantities && read != Quantities::None {}, "{name}");
        }
    }
}

/// The schema of `T` is the file in the book; `WRITE_PAGE=1` writes it.
fn schema<T: JsonSchema>(name: &str) {
    let file = format!(
        "{}/../../docs/src/schemas/{name}.schema.json",
        env!("CARGO_MANIFEST_DIR")
    );
    let text = serde_json::to_string_pretty(&schema_for!(T)).unwrap() + "\n";
    if std::env::var_os("WRITE_PAGE").is_some() {
        std::fs::write(&file, &text).unwrap();
    }
    let shipped = std::fs::read_to_string(&file).unwrap_or_default();
    assert_eq!(
        shipped, text,
        "{file}: WRITE_PAGE=1 cargo test -p isolux-app --test suite results_are_types writes it"
    );
}

#[test]
fn the_schemas_in_the_book_are_those_of_the_types() {
    schema::<Budget>("budget");
    schema::<Conformity>("conformity");
    schema::<Comparison>("comparison");
    schema::<Facts>("result");
    schema::<Document>("diagnosis");
    schema::<Quantities>("quantities");
    schema::<Verification>("verification");
    schema::<Calibration>("calibration");
    schema::<Compared>("compared");
    schema::<Evaluated>("modulation");
}
