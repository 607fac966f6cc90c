//! Where the numbers come from: program, record, hashes, files.

use crate::document::{Block, Section};
use isolux_record::disk::sha256;

use super::results::DayResults;

/// Files of the results with what they are.
const FILES: [(&str, &str); 20] = [
    ("luminaire.ldt", "EULUMDAT"),
    ("luminaire.raw.ldt", "EULUMDAT as read, before smoothing"),
    (
        "luminaire.directions.csv",
        "every direction with its uncertainty and origin",
    ),
    ("luminaire.ies", "IES LM-63-2002"),
    ("luminaire.xml", "IES TM-33-18"),
    ("luminaire.tm33-23.xml", "IES TM-33-23, with the spectra over angle"),
    ("luminaire.spdx", "spectrum, IES TM-27"),
    ("luminaire.spd", "spectrum, plain columns"),
    ("eu_label.csv", "EU energy label and product information"),
    ("luminaire.model.toml", "the model that simulates and predicts"),
    ("modulation.json", "numbers of the light over time"),
    ("irradiance.npy", "the map, 32-bit floats"),
    ("irradiance.png", "the map in false colours"),
    ("result.json", "numbers of the simulation"),
    ("budget.json", "the uncertainty, part by part"),
    ("conformity.json", "conditions, requirements and checklist as judged"),
    ("data-sheet.html", "the data sheet"),
    ("data-sheet.pdf", "the data sheet on paper"),
    ("comparison.json", "the axis at the short distance"),
    ("provenance.json", "what was measured, with what, by which program"),
];

pub fn section(day_results: &DayResults) -> Section {
    let mut section = Section::new("Provenance");
    let run = &day_results.run;
    let header = &run.header;
    let mut facts = vec![
        ("recorded by".to_owned(), header.program.clone()),
        ("begun".to_owned(), header.started_utc.clone()),
    ];
    if let Some(stopped) = &header.stopped {
        facts.push(("ended".to_owned(), format!("{}, {}", stopped.utc, stopped.how)));
        facts.extend(
            stopped
                .readings_sha256
                .iter()
                .map(|sum| ("SHA-256 of readings.csv".to_owned(), sum.clone())),
        );
    }
    for resumed in &header.resumed {
        facts.push(("resumed".to_owned(), format!("{} by {}", resumed.utc, resumed.program)));
    }
    for name in ["luminaire.ldt", "luminaire.spdx", "budget.json"] {
        if let Ok(bytes) = std::fs::read(day_results.folder.join(name)) {
            facts.push((format!("SHA-256 of {name}"), sha256(&bytes)));
        }
    }
    // The folder's own name would make another report of a run that was moved.
    let again = "isolux verify RUN; isolux reduce RUN --force; isolux report RUN --out FILE";
    facts.push(("computed again by".to_owned(), again.to_owned()));
    section.facts(facts);
    section.subheading("Files");
    let there = |file: &str| day_results.folder.join(file).exists() && !day_results.stale.contains(&file);
    let files = FILES.into_iter().filter(|(file, _)| there(file));
    section.add(Block::Files(
        files.map(|(file, what)| (file.to_owned(), what.to_owned())).collect(),
    ));
    if !day_results.stale.is_empty() {
        section.paragraph(format!(
            "Of another reduction or sensor than this page, and not shown: {}. `isolux run --resume` makes all of them again.",
            day_results.stale.join(", ")
        ));
    }
    section.paragraph("End of the report.");
    section
}
