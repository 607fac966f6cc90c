//! What several parts of the report say alike.

use isolux_record::subject::{LUMINAIRE_KEYS, REPORT_KEYS};
use serde_json::{Map, Value};

use super::results::DayResults;
use crate::document::Section;

/// What a report says where the record does not know.
pub const NOT_STATED: &str = "not stated";

/// What was measured and for whom, in full: what is not stated says so.
pub fn identity(day_results: &DayResults, section: &mut Section) {
    let header = &day_results.run.header;
    let mut facts = Vec::new();
    let stated = |text: Option<&str>| text.unwrap_or(NOT_STATED).to_owned();
    for (key, text) in LUMINAIRE_KEYS.iter().zip(header.luminaire.texts()) {
        facts.push((key.what.to_owned(), stated(text)));
    }
    for (key, text) in REPORT_KEYS.iter().zip(header.report.texts()) {
        // The method is always told; notes only where there are some.
        if text.is_some() || key.name != "notes" {
            facts.push((key.what.to_owned(), stated(text)));
        }
    }
    section.facts(facts);
    section.paragraph(
        "The results are valid for this item alone, in the state and under the conditions that are stated here.",
    );
}

/// What the photometric formats compute of the distribution: zonal flux, flux code, UGR.
pub fn quantities(day_results: &DayResults) -> Map<String, Value> {
    isolux_reduce::photometric(&day_results.reduction, &day_results.run).quantities()
}

/// A coordinate without needless zeros.
pub fn angle(degrees: f64) -> String {
    format!("{}°", (degrees * 100.0).round() / 100.0)
}

/// A direction in words; on the axis every C is the same.
pub fn direction(c_deg: f64, gamma_deg: f64) -> String {
    if gamma_deg == 0.0 {
        "at γ 0°".to_owned()
    } else {
        format!("at C {}, γ {}", angle(c_deg), angle(gamma_deg))
    }
}
