//! The document `isolux-spectrum/1`.

use serde::Deserialize;
use serde_json::{Map, Value};

use super::file::{FORMAT, Series, SpectrumFile};
use super::point::Point;
use super::points::Draft;
use crate::finding::{Finding, Findings};
use crate::parsed::{Format, Kind, Parsed};
use crate::text::Text;

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Document {
    #[serde(rename = "format")]
    _format: String,
    wavelength_nm: Vec<f64>,
    value: Vec<f64>,
    quantity: Option<String>,
    unit: Option<String>,
    #[serde(default)]
    header: Map<String, Value>,
    #[serde(default)]
    series: Vec<Column>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Column {
    name: String,
    value: Vec<Option<f64>>,
}

/// Whether the document says so itself.
pub(crate) fn looks_like(text: &Text<'_>) -> bool {
    text.content().trim_start().starts_with('{') && text.content().contains(FORMAT)
}

/// Reads it back.
pub(crate) fn read(text: &Text<'_>, mut findings: Findings) -> Parsed<SpectrumFile> {
    let document: Document = match serde_json::from_str(text.content()) {
        Ok(document) => document,
        Err(error) => {
            findings
                .push(Finding::error("json-syntax", error.to_string()).at(error.line().max(1), error.column().max(1)));
            return Parsed::refused(Some(Format::JSON), Some(Kind::Spectrum), findings);
        }
    };
    let n = document.wavelength_nm.len();
    let lengths = document.value.len() == n && document.series.iter().all(|s| s.value.len() == n);
    if !lengths {
        findings.push(Finding::error(
            "json-lengths",
            format!(
                "{n} wavelengths, {} values, or a series of another length",
                document.value.len()
            ),
        ));
        return Parsed::refused(Some(Format::JSON), Some(Kind::Spectrum), findings);
    }
    let mut draft = Draft::new(text.encoding);
    draft.points = (0..n)
        .map(|i| Point {
            line: 1,
            column: 1,
            x: document.wavelength_nm[i],
            value: vec![Some(document.value[i])],
        })
        .collect();
    draft.axis = Some(super::axis::AxisUnit::Nanometre);
    let file = draft.finish(&mut findings).map(|file| SpectrumFile {
        series: document
            .series
            .into_iter()
            .map(|s| Series {
                name: s.name,
                value: s.value,
            })
            .collect(),
        quantity: document.quantity,
        unit: document.unit,
        header: document.header,
        ..file
    });
    Parsed::new(Format::JSON, Kind::Spectrum, file, findings)
}
