//! `inspect --plot`: what a file holds, as pictures.

use std::collections::BTreeMap;

use camino::{Utf8Path, Utf8PathBuf};
use isolux_report::content;

use crate::Failure;
use crate::files::{self, Overwrite};
use crate::formats::inspect::Inspection;

/// Refuses before anything is drawn: two of the files would get pictures of one name, or a picture exists and may not
/// be replaced.
///
/// # Errors
/// Bad input (exit 2) with both files, or with the picture.
pub fn plan(inspections: &[Inspection], folder: &Utf8Path, overwrite: Overwrite) -> Result<(), Failure> {
    let mut drawn: BTreeMap<Utf8PathBuf, &str> = BTreeMap::new();
    for inspection in inspections {
        let kinds = inspection.content.as_ref().map_or(&[][..], content::kinds);
        for kind in kinds {
            let target = target(inspection, folder, kind);
            if let Some(other) = drawn.get(&target) {
                return Err(Failure::bad_input(format!(
                    "{other} and {} would both be drawn as {target}",
                    inspection.file
                ))
                .help("draw them into folders of their own"));
            }
            files::refuse_existing(&target, overwrite)?;
            drawn.insert(target, &inspection.file);
        }
    }
    Ok(())
}

fn name(inspection: &Inspection) -> String {
    Utf8Path::new(&inspection.file)
        .file_name()
        .unwrap_or("file")
        .replace(['!', '/', '\\'], "-")
}

fn target(inspection: &Inspection, folder: &Utf8Path, kind: &str) -> Utf8PathBuf {
    folder.join(format!("{}.{kind}.svg", name(inspection)))
}

/// Draws the content of one file into `folder`, named after the file: `lamp.ldt.polar.svg`. Nothing for a file that
/// could not be read.
///
/// # Errors
/// The folder cannot be made, a picture exists and may not be replaced, or writing fails.
pub fn write(inspection: &Inspection, folder: &Utf8Path, overwrite: Overwrite) -> Result<Vec<Utf8PathBuf>, Failure> {
    let name = name(inspection);
    let Some(content) = &inspection.content else {
        return Ok(Vec::new());
    };
    let pictures = content::pictures(content, &name);
    std::fs::create_dir_all(folder).map_err(|error| Failure::bad_input(format!("{folder} cannot be made: {error}")))?;
    let targets: Vec<Utf8PathBuf> = pictures
        .iter()
        .map(|(kind, _)| target(inspection, folder, kind))
        .collect();
    for target in &targets {
        files::refuse_existing(target, overwrite)?;
    }
    for (target, (_, svg)) in targets.iter().zip(&pictures) {
        files::write(target, svg.as_bytes(), overwrite)?;
    }
    Ok(targets)
}
