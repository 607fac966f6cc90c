//! The photometric report of a day, in the order in which EN 13032-4 and LM-79 reports have their parts: what was
//! measured, the verdict, the distribution, flux, colour, glare, the conditions, the uncertainty, and what is behind
//! them.

mod amendments;
mod colour;
mod colour_over_angle;
mod conditions;
mod conformity;
mod data_sheet;
mod eu_label;
mod light;
mod modulation;
mod ratings;
mod record;
mod results;
mod simulated;
mod uncertainty;
mod verdict;
mod words;

pub use amendments::{Amendment, Change, amended, changes};
pub use colour_over_angle::{figures as colour_figures, sentence as colour_sentence};
pub use data_sheet::data_sheet;
pub use modulation::facts as modulation_facts;
pub use results::{DayLayout, DayResults, Diagnosed};

use crate::document::{Document, Section};
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
    let mut sections: Vec<(&str, Section)> = Vec::new();
    let mut add =
        |name: &'static str, section: Option<Section>| sections.extend(section.map(|section| (name, section)));
    add("conformity", conformity::requirements(day_results));
    add("distribution", Some(light::distribution(day_results)));
    add("flux", Some(light::flux(day_results)));
    add("colour", colour::section(day_results));
    add("colour_over_angle", colour_over_angle::section(&day_results.reduction));
    add("glare", Some(light::glare(day_results)));
    add("ratings", ratings::section(day_results)?);
    add("eu_label", eu_label::section(day_results)?);
    add("light_modulation", modulation::section(day_results));
    add("conditions", Some(conditions::section(day_results)));
    add("uncertainty", Some(uncertainty::section(day_results)));
    add("simulation", Some(simulated::section(day_results)?));
    add("comparison", simulated::comparison(day_results));
    add("diagnosis", simulated::diagnosis(day_results));
    add("tables", Some(light::tables(day_results)));
    add("checklist", Some(conformity::checklist(day_results)));
    let layout = &day_results.layout;
    let mut sections = chosen(sections, layout.sections.as_deref());
    sections.insert(0, verdict::section(day_results));
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
        date: date_of(&day),
        language: layout.language,
        clothes: layout.clothes.clone(),
        sections,
    })
}

/// The sections that a layout names, in its order; all where it names none.
fn chosen(mut sections: Vec<(&str, Section)>, names: Option<&[String]>) -> Vec<Section> {
    if let Some(names) = names {
        let place = |name: &str| names.iter().position(|chosen| chosen == name);
        sections.retain(|(name, _)| place(name).is_some());
        sections.sort_by_key(|(name, _)| place(name));
    }
    sections.into_iter().map(|(_, section)| section).collect()
}

/// Year, month and day of `YYYY-MM-DD`.
fn date_of(day: &str) -> Option<(u16, u8, u8)> {
    let mut parts = day.split('-');
    Some((
        parts.next()?.parse().ok()?,
        parts.next()?.parse().ok()?,
        parts.next()?.parse().ok()?,
    ))
}
