//! `inspect --plot`: what a file holds, as pictures.

use camino::{Utf8Path, Utf8PathBuf};
use isolux_formats::Content;
use isolux_formats::spectral::SpectrumFile;
use isolux_report::plots::{self, Diagram, IsoluxOptions, PolarOptions, SpectrumOptions};

use crate::Failure;
use crate::files::{self, Overwrite};
use crate::inspect::Inspection;

/// Draws the content of one file into `folder`, named after the file: `lamp.ldt.polar.svg`. Nothing for a file that
/// could not be read.
///
/// # Errors
/// The folder cannot be made, a picture exists and may not be replaced, or writing fails.
pub fn write(inspection: &Inspection, folder: &Utf8Path, overwrite: Overwrite) -> Result<Vec<Utf8PathBuf>, Failure> {
    let name = Utf8Path::new(&inspection.file)
        .file_name()
        .unwrap_or("file")
        .replace(['!', '/', '\\'], "-");
    let pictures = match &inspection.content {
        Some(Content::Distribution(distribution)) => {
            let intensity = &distribution.intensity;
            let options = PolarOptions {
                title: name.clone(),
                per_lamp_flux_lm: distribution.lamp_flux_lm,
            };
            vec![
                ("polar", plots::polar(intensity, &options)),
                ("cartesian", plots::cartesian(intensity, &options)),
                ("isocandela", plots::isocandela(intensity, &options)),
                (
                    "isolux",
                    plots::isolux(intensity, &IsoluxOptions::at_one_metre(intensity, &name)),
                ),
                ("solid", plots::solid(intensity, &options)),
            ]
        }
        Some(Content::Spectrum(file)) => spectrum(file, &name),
        None => return Ok(Vec::new()),
    };
    std::fs::create_dir_all(folder).map_err(|error| Failure::bad_input(format!("{folder} cannot be made: {error}")))?;
    let targets: Vec<Utf8PathBuf> = pictures
        .iter()
        .map(|(kind, _)| folder.join(format!("{name}.{kind}.svg")))
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
        ("spectrum", plots::spectrum(&spectrum, &options)),
        ("cie1931", plots::chromaticity(&spectrum, Diagram::Cie1931, name)),
        ("cie1976", plots::chromaticity(&spectrum, Diagram::Cie1976, name)),
    ];
    pictures.extend(plots::tm30(&spectrum, name).map(|svg| ("tm30", svg)));
    pictures
}
