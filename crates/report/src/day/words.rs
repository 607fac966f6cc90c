//! What several parts of the report say alike.

use isolux_formats::Quantities;
use isolux_record::subject::{LUMINAIRE_KEYS, REPORT_KEYS};

use super::results::DayResults;
use crate::document::Section;

/// What was measured and for whom; one line names what is not stated.
pub fn identity(day_results: &DayResults, section: &mut Section) {
    let header = &day_results.run.header;
    let luminaire = LUMINAIRE_KEYS.iter().zip(header.luminaire.texts());
    let keys = luminaire.chain(REPORT_KEYS.iter().zip(header.report.texts()));
    let (mut facts, mut missing) = (Vec::new(), Vec::new());
    for (key, text) in keys {
        match text {
            Some(text) => facts.push((key.what.to_owned(), text.to_owned())),
            // Notes are no gap.
            None if key.name != "notes" => missing.push(key.what),
            None => {}
        }
    }
    if !facts.is_empty() {
        section.facts(facts);
    }
    if !missing.is_empty() {
        section.paragraph(format!("Not stated: {}.", missing.join(", ")));
    }
    section.paragraph(
        "The results are valid for this item alone, in the state and under the conditions that are stated here.",
    );
}

/// What the photometric formats compute of the distribution: zonal flux, flux code, UGR.
pub fn quantities(day_results: &DayResults) -> Quantities {
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
