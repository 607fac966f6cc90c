//! A file that came as bytes: inspected and drawn beside nothing else, as `inspect --plot` would.

use camino::{Utf8Path, Utf8PathBuf};
use serde::Serialize;

use crate::files::Overwrite;
use crate::inspect::{self, Inspection};
use crate::{Failure, plot};

/// What is said of a file, and its pictures.
#[derive(Debug, Serialize)]
pub struct Dropped {
    /// One entry a photometry or spectrum in it.
    pub inspections: Vec<Inspection>,
    /// Whether any finding is an error.
    pub wrong: bool,
    /// Pictures, SVG, each with its name.
    pub pictures: Vec<(String, String)>,
}

/// Inspects and draws the file of this name. It is kept nowhere; files that it names beside itself are not there.
///
/// # Errors
/// Bad input (exit 2) for a name that is none; exit 3 when the system gives no temporary folder.
pub fn dropped(name: &str, bytes: &[u8]) -> Result<Dropped, Failure> {
    if !crate::folder::is_name(name) {
        return Err(Failure::bad_input(format!("`{name}` is no name of a file")));
    }
    let folder = tempfile::tempdir().map_err(Failure::instrument)?;
    let folder = Utf8Path::from_path(folder.path())
        .ok_or_else(|| Failure::instrument("the temporary folder's name is not UTF-8"))?;
    let path = folder.join(name);
    std::fs::write(&path, bytes).map_err(Failure::instrument)?;
    let mut inspections = inspect::file(&path, isolux_formats::ReadOptions::default());
    let mut pictures: Vec<Utf8PathBuf> = Vec::new();
    let drawn = folder.join("pictures");
    for inspection in &inspections {
        // A picture of the same name is of the same content twice.
        pictures.extend(plot::write(inspection, &drawn, Overwrite::Force)?);
    }
    let pictures = pictures.iter().map(|picture| {
        let svg = std::fs::read_to_string(picture).map_err(Failure::instrument)?;
        Ok((picture.file_name().unwrap_or("picture").to_owned(), svg))
    });
    let pictures = pictures.collect::<Result<Vec<_>, Failure>>()?;
    for inspection in &mut inspections {
        inspection.file = inspection.file.replace(path.as_str(), name);
    }
    Ok(Dropped {
        wrong: inspections.iter().any(Inspection::has_error),
        inspections,
        pictures,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_spectrum_is_told_and_drawn_and_nonsense_is_a_finding() {
        let table = "wavelength_nm,value\n400,1\n500,2\n600,3\n700,1\n";
        let told = dropped("lamp.csv", table.as_bytes()).unwrap();
        assert!(!told.wrong && told.inspections[0].file == "lamp.csv", "{told:?}");
        assert!(
            told.pictures
                .iter()
                .any(|(name, svg)| name.starts_with("lamp.csv.") && svg.contains("<svg"))
        );
        let nonsense = dropped("lamp.ldt", b"\x00\x01").unwrap();
        assert!(nonsense.wrong && nonsense.pictures.is_empty());
        assert!(dropped("../lamp.ldt", b"").is_err());
    }
}
