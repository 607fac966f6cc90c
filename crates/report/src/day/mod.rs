//! The photometric report of a day, in the order in which EN 13032-4 and LM-79 reports have their parts: what was
//! measured, the verdict, the distribution, flux, colour, glare, the conditions, the uncertainty, and what is behind
//! them.

mod colour;
mod colour_over_angle;
mod conditions;
mod eu_label;
mod light;
mod ratings;
mod record;
mod results;
mod simulated;
mod uncertainty;
mod verdict;
mod words;

pub use colour_over_angle::{figures as colour_figures, sentence as colour_sentence};
pub use results::{DayResults, Diagnosed};

use crate::document::Document;
use crate::sensor::ViewError;

/// The report as a document.
///
/// # Errors
/// When the scene cannot be written.
pub fn document(day_results: &DayResults) -> Result<Document, ViewError> {
    let header = &day_results.run.header;
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
    sections.extend(colour_over_angle::section(&day_results.reduction));
    sections.push(light::glare(day_results));
    sections.extend(ratings::section(day_results)?);
    sections.extend(eu_label::section(day_results)?);
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
    // Title and foot stand on every page.
    let partial = if day_results.reduction.partial.is_some() {
        "PARTIAL · "
    } else {
        ""
    };
    Ok(Document {
        title: format!("{partial}Photometric report: {name}"),
        subtitle: format!("{partial}Report {number} · measured {day} · {}", header.program),
        foot: format!("{partial}{laboratory}report {number} · {name} · measured {day}"),
        sections,
    })
}
