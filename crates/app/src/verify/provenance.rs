//! provenance.json, as far as it says what else of the results has to be there.

use std::collections::BTreeMap;

use serde::Deserialize;

/// Names of the file in a folder of results that says what was made there: of a whole scan, and of a part of one.
pub(super) const FILES: [&str; 2] = ["provenance.json", "provenance.partial.json"];

/// What provenance.json says of the files beside it.
#[derive(Debug, Deserialize)]
pub(super) struct Provenance {
    pub program: String,
    pub run: OfRun,
    pub results_sha256: BTreeMap<String, String>,
}

/// What it was made of.
#[derive(Debug, Deserialize)]
pub(super) struct OfRun {
    pub sha256: BTreeMap<String, String>,
}
