//! The documents `isolux-distribution/1` and `isolux-spectrum/1`, every digit kept.

use crate::content::Content;
use crate::distribution::Distribution;
use crate::file_format::FileFormat;
use crate::finding::Finding;
use crate::options::WriteOptions;
use crate::parsed::{Format, Written};
use crate::spectral::{json, write};

pub(crate) const FORMAT: FileFormat = FileFormat {
    format: Format::JSON,
    title: "isolux JSON",
    extensions: &["json"],
    detect: |source| json::looks_like(source.text()),
    read: |source| {
        let (text, findings) = source.decoded();
        vec![json::read(text, findings).map(Content::spectrum)]
    },
    write_distribution: Some(distribution),
    write_spectrum: Some(write::json),
};

/// The document `isolux-distribution/1`.
fn distribution(distribution: &Distribution, options: &WriteOptions) -> Result<Written, Finding> {
    options.only_for(Format::JSON)?;
    let mut bytes = serde_json::to_vec(&distribution.to_json())
        .map_err(|error| Finding::error("convert-json", error.to_string()))?;
    bytes.push(b'\n');
    Ok(Written {
        bytes,
        findings: Vec::new(),
    })
}
