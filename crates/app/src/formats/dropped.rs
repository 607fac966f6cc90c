//! A file that came as bytes: inspected and drawn beside nothing else, as `inspect --plot` would.

use camino::Utf8Path;
use isolux_formats::Finding;
use isolux_report::content;
use serde::Serialize;

use crate::Failure;
use crate::formats::inspect::{self, Inspection};
use crate::study::Figure;

/// What is said of a file.
#[derive(Debug, Serialize)]
pub struct Dropped {
    /// One entry a photometry or spectrum in it.
    pub contents: Vec<FileContent>,
    /// Whether any finding is an error.
    pub wrong: bool,
}

/// What is said of one photometry or spectrum.
#[derive(Debug, Serialize)]
pub struct FileContent {
    /// The file, `outer!inner` inside a container.
    pub file: String,
    /// What it is, in words.
    pub what: String,
    /// What the reader found.
    pub findings: Vec<Finding>,
    /// Names, and values with their units.
    pub quantities: Vec<(String, String)>,
    /// Its pictures.
    pub figures: Vec<Figure>,
}

/// Inspects and draws the file of this name. It is kept nowhere; files that it names beside itself are not there.
///
/// # Errors
/// Bad input (exit 2) for a name that is none; exit 3 when the system gives no temporary folder.
pub fn dropped(name: &str, bytes: &[u8]) -> Result<Dropped, Failure> {
    if !crate::run::folder::is_name(name) {
        return Err(Failure::bad_input(format!("`{name}` is no name of a file")));
    }
    let folder = tempfile::tempdir().map_err(Failure::instrument)?;
    let folder = Utf8Path::from_path(folder.path())
        .ok_or_else(|| Failure::instrument("the temporary folder's name is not UTF-8"))?;
    let path = folder.join(name);
    std::fs::write(&path, bytes).map_err(Failure::instrument)?;
    let inspections = inspect::file(&path, isolux_formats::ReadOptions::default());
    Ok(Dropped {
        wrong: inspections.iter().any(Inspection::has_error),
        contents: inspections
            .into_iter()
            .map(|inspection| FileContent {
                file: inspection.file.replace(path.as_str(), name),
                what: inspection.what(),
                quantities: inspection.stated(),
                figures: figures(&inspection),
                findings: inspection.findings,
            })
            .collect(),
    })
}

fn figures(inspection: &Inspection) -> Vec<Figure> {
    let pictures = inspection
        .content
        .as_ref()
        .map_or_else(Vec::new, |content| content::pictures(content, ""));
    let figure = |(kind, svg)| Figure {
        title: content::title(kind).to_owned(),
        svg,
    };
    pictures.into_iter().map(figure).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_spectrum_is_told_and_drawn_and_nonsense_is_a_finding() {
        let table = "wavelength_nm,value\n400,1\n500,2\n600,3\n700,1\n";
        let described = dropped("lamp.csv", table.as_bytes()).unwrap();
        let [one] = &described.contents[..] else {
            panic!("{described:?}")
        };
        assert!(
            !described.wrong && one.file == "lamp.csv" && one.what.starts_with("spectrum"),
            "{described:?}"
        );
        assert!(
            one.quantities
                .contains(&("peak wavelength".to_owned(), "600 nm".to_owned())),
            "{described:?}"
        );
        assert!(one.figures[0].title == "Spectrum" && one.figures[0].svg.contains("<svg"));
        let nonsense = dropped("lamp.ldt", b"\x00\x01").unwrap();
        assert!(nonsense.wrong && nonsense.contents[0].figures.is_empty());
        assert!(dropped("../lamp.ldt", b"").is_err());
    }
}
