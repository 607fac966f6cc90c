//! `inspect --plot`: what a file holds, as pictures.

use std::collections::BTreeMap;

use camino::{Utf8Path, Utf8PathBuf};
use isolux_formats::Content;
use isolux_formats::spectral::SpectrumFile;
use isolux_report::plots::{self, Diagram, IsoluxOptions, PolarOptions, SpectrumOptions};

use crate::Failure;
use crate::files::{self, Overwrite};
use crate::inspect::Inspection;

/// Refuses before anything is drawn: two of the files would get pictures of one name, or a picture exists and may not
/// be replaced.
///
/// # Errors
/// Bad input (exit 2) with both files, or with the picture.
pub fn plan(inspections: &[Inspection], folder: &Utf8Path, overwrite: Overwrite) -> Result<(), Failure> {
    let mut drawn: BTreeMap<Utf8PathBuf, &str> = BTreeMap::new();
    for inspection in inspections {
        let kinds: &[&str] = match &inspection.content {
            Some(Content::Distribution(_)) => &DISTRIBUTION,
            Some(Content::Spectrum(_)) => &SPECTRUM,
            None => &[],
        };
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

const DISTRIBUTION: [&str; 5] = ["polar", "cartesian", "isocandela", "isolux", "solid"];
const SPECTRUM: [&str; 4] = ["spectrum", "cie1931", "cie1976", "tm30"];

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
    let pictures = match &inspection.content {
        Some(Content::Distribution(distribution)) => {
            let intensity = &distribution.intensity;
            let options = PolarOptions {
                title: name.clone(),
                per_lamp_flux_lm: distribution.lamp_flux_lm,
                doubtful_cd: None,
            };
            let isolux = IsoluxOptions::at_one_metre(intensity, &name);
            DISTRIBUTION
                .into_iter()
                .zip([
                    plots::polar(intensity, &options),
                    plots::cartesian(intensity, &options),
                    plots::isocandela(intensity, &options),
                    plots::isolux(intensity, &isolux),
                    plots::solid(intensity, &options),
                ])
                .collect()
        }
        Some(Content::Spectrum(file)) => spectrum(file, &name),
        None => return Ok(Vec::new()),
    };
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

fn spectrum(file: &SpectrumFile, name: &str) -> Vec<(&'static str, String)> {
    let Ok(spectrum) = file.spectrum() else {
        return Vec::new();
    };
    let label = match (&file.quantity, &file.unit) {
        (Some(quantity), Some(unit)) => format!("{quantity} in {unit}"),
        (Some(quantity), None) => quantity.clone(),
        (None, Some(unit)) => format!("value in {unit}"),
        (None, None) => "value".to_owned(),
    };
    let options = SpectrumOptions {
        title: name.to_owned(),
        value_label: label,
    };
    let mut pictures = vec![
        plots::spectrum(&spectrum, &options),
        plots::chromaticity(&spectrum, Diagram::Cie1931, name),
        plots::chromaticity(&spectrum, Diagram::Cie1976, name),
    ];
    pictures.extend(plots::tm30(&spectrum, name));
    SPECTRUM.into_iter().zip(pictures).collect()
}
