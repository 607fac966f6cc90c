//! The report of a day in other languages.

use camino::Utf8Path;
use isolux_app::day;
use isolux_app::front_end::progress::Silent;
use isolux_record::Language;

/// Of the luminaire, of instruments, and SHA-256.
const NAMES: [&str; 6] = [
    "LED rings of the virtual darkroom",
    "Zaber device",
    "Konica Minolta",
    "Ocean Optics",
    "isolux 0",
    "virtual 1",
];

/// Every text of the report of a day has its German and French; `ISOLUX_TEXTS=FILE` writes those that lack.
pub fn every_text_is_translated(folder: &Utf8Path) {
    let mut document = day::report_document(folder, None, &Silent).unwrap();
    for language in [Language::De, Language::Fr] {
        document.language = language;
        let mut lacking = document.untranslated();
        // Names are the same in every language.
        lacking.retain(|text| !NAMES.iter().any(|name| text.starts_with(name)) && text.len() != 64);
        if let Some(file) = std::env::var_os("ISOLUX_TEXTS") {
            std::fs::write(file, lacking.join("\n")).unwrap();
        }
        assert!(
            lacking.is_empty(),
            "{language:?} lacks {} texts: {lacking:#?}",
            lacking.len()
        );
        let paper = document.pdf().unwrap();
        assert_eq!((paper.unknown.len(), paper.not_archival), (0, None));
    }
}
