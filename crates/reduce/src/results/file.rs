//! A file of `results/` and its hash.

use isolux_record::Run;
use isolux_record::disk::sha256;

use crate::Reduction;

/// One file.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct ResultFile {
    /// Its name in the folder of results.
    pub name: String,
    /// Its bytes.
    pub bytes: Vec<u8>,
}

pub fn diameter_mm(run: &Run) -> Option<f64> {
    run.header.station.lamp().and_then(|lamp| lamp.diameter_mm)
}

pub fn hashes(files: &[(String, Vec<u8>)]) -> Vec<(String, String)> {
    files
        .iter()
        .map(|(name, bytes)| (name.clone(), sha256(bytes)))
        .collect()
}

/// The name of a result: `luminaire.partial.ldt` where the scan is not finished.
pub fn file_name(reduction: &Reduction, name: &str) -> String {
    match (&reduction.partial, name.split_once('.')) {
        (Some(_), Some((stem, extension))) => format!("{stem}.partial.{extension}"),
        _ => name.to_owned(),
    }
}
