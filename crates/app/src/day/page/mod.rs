//! The photometric report of a day, in the order in which EN 13032-4 and LM-79 reports have their parts: what was
//! measured, the verdict, the distribution, flux, colour, glare, the conditions, the uncertainty, and what is behind
//! them.

mod colour;
mod conditions;
mod light;
mod record;
mod simulated;
mod uncertainty;
mod verdict;

use isolux_photometry::IntensityDistribution;
use isolux_record::subject::{LUMINAIRE_KEYS, REPORT_KEYS};
use isolux_report::document::{Document, Section};
use serde_json::{Map, Value};

use super::DayResults;
use crate::Failure;

/// What a report says where the record does not know.
const NOT_STATED: &str = "not stated";

/// The report as a document.
///
/// # Errors
/// When the scene cannot be written.
pub(super) fn document(day_results: &DayResults) -> Result<Document, Failure> {
    let header = &day_results.reduced.run.header;
    let (luminaire, report) = (&header.luminaire, &header.report);
    let name: Vec<&str> = [&luminaire.maker, &luminaire.name]
        .into_iter()
        .filter_map(Option::as_deref)
        .collect();
    let name = if name.is_empty() {
        "luminaire without a name".to_owned()
    } else {
        name.join(" ")
    };
    let number = report.number.as_deref().unwrap_or("without a number");
    let day: String = header.started_utc.chars().take(10).collect();
    let mut sections = vec![verdict::section(day_results)];
    sections.push(light::distribution(day_results));
    sections.push(light::flux(day_results));
    sections.extend(colour::section(day_results));
    sections.push(light::glare(day_results));
    sections.push(conditions::section(day_results));
    sections.push(uncertainty::section(day_results));
    sections.push(simulated::section(day_results)?);
    sections.extend(simulated::comparison(day_results));
    sections.extend(simulated::diagnosis(day_results));
    sections.push(light::tables(day_results));
    sections.push(record::section(day_results));
    let laboratory = report
        .laboratory
        .as_deref()
        .map_or_else(String::new, |text| format!("{text} · "));
    Ok(Document {
        title: format!("Photometric report: {name}"),
        subtitle: format!("Report {number} · measured {day} · {}", header.program),
        foot: format!("{laboratory}report {number} · {name} · measured {day}"),
        sections,
    })
}

/// What was measured and for whom, in full: what is not stated says so.
fn identity(day_results: &DayResults, section: &mut Section) {
    let header = &day_results.reduced.run.header;
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
fn quantities(day_results: &DayResults) -> Map<String, Value> {
    isolux_reduce::photometric(&day_results.reduced.reduction, &day_results.reduced.run).quantities()
}

/// The half-plane of the grid at `c_deg`; the only one of a rotational distribution.
fn plane_at(distribution: &IntensityDistribution, c_deg: f64) -> Option<usize> {
    let at = distribution.c_deg().iter().position(|c| (c - c_deg).abs() < 1e-9);
    at.or(distribution.is_rotational().then_some(0))
}

/// A coordinate without needless zeros.
fn angle(degrees: f64) -> String {
    format!("{}°", (degrees * 100.0).round() / 100.0)
}

/// A direction in words; on the axis every C is the same.
fn direction(c_deg: f64, gamma_deg: f64) -> String {
    if gamma_deg == 0.0 {
        "at γ 0°".to_owned()
    } else {
        format!("at C {}, γ {}", angle(c_deg), angle(gamma_deg))
    }
}
