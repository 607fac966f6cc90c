//! The data sheet: what a reader wants of a luminaire, on one page.

use crate::document::{Block, Document, Section};
use crate::plots::{PolarOptions, SpectrumOptions, polar, spectrum};
use isolux_units::digits::significant;

use super::results::DayResults;
use super::{light, verdict};

/// The page. `report` is the report, whose title, clothes and language it shares.
pub fn data_sheet(day_results: &DayResults, report: &Document) -> Document {
    let reduction = &day_results.reduction;
    let header = &day_results.run.header;
    let mut section = Section::default();
    if let Some(partial) = &reduction.partial {
        section.add(Block::Verdict(partial.note(), false));
    }
    let item = &header.luminaire;
    let stated = [
        ("maker", &item.maker),
        ("name", &item.name),
        ("catalogue number", &item.catalogue_number),
        ("serial or sample number", &item.sample),
        ("light source", &item.light_source),
        ("rated voltage, current, power", &item.rated),
    ];
    let facts = stated
        .into_iter()
        .filter_map(|(name, text)| Some((name.to_owned(), text.clone()?)));
    section.facts(facts.collect());
    section.add(Block::Tiles(verdict::tiles(day_results)));
    let shown = &reduction.grid.distribution;
    let options = PolarOptions {
        title: String::new(),
        per_lamp_flux_lm: Some(reduction.flux.value),
        doubtful_cd: Some(light::doubtful_cd(day_results)),
    };
    let mut figures = vec![(
        polar(shown, &options),
        "Luminous intensity, C0–C180 solid red, C90–C270 dashed blue, in cd/klm.",
    )];
    figures.extend(day_results.reduction.spectral.as_ref().map(|spectral| {
        let options = SpectrumOptions {
            title: String::new(),
            value_label: format!("spectral irradiance at {} mm in W/(m²·nm)", spectral.distance_mm),
        };
        (spectrum(&spectral.spectrum, &options), "Spectrum on the axis.")
    }));
    let figures = figures.into_iter().map(|(svg, caption)| crate::document::Figure {
        svg,
        caption: caption.to_owned(),
    });
    section.add(Block::Figures(figures.collect()));
    if let Some(sentence) = day_results.conformity.sentence() {
        section.paragraph(format!("Requirements: {sentence}."));
    }
    section.paragraph(format!(
        "± is the expanded uncertainty U (k = 2). Measured at {} m; the full report has conditions, uncertainties and tables.",
        significant(1e-3 * reduction.distance_mm, 4)
    ));
    Document {
        title: report.title.replacen("Photometric report", "Data sheet", 1),
        subtitle: report.subtitle.clone(),
        foot: report.foot.clone(),
        date: report.date,
        language: report.language,
        clothes: report.clothes.clone(),
        sections: vec![section],
    }
}
