//! The pictures of what a file holds.

use isolux_formats::Content;
use isolux_formats::spectral::SpectrumFile;

use crate::plots::{self, Diagram, IsoluxOptions, PolarOptions, SpectrumOptions};

const DISTRIBUTION: [&str; 5] = ["polar", "cartesian", "isocandela", "isolux", "solid"];
const SPECTRUM: [&str; 5] = ["spectrum", "cie1931", "cie1976", "tm30", "tm30_bins"];

/// The pictures that there may be of this content, by name.
pub fn kinds(content: &Content) -> &'static [&'static str] {
    match content {
        Content::Distribution(_) => &DISTRIBUTION,
        Content::Spectrum(_) => &SPECTRUM,
    }
}

/// A picture of this name in words.
pub fn title(kind: &str) -> &str {
    match kind {
        "polar" => "Polar diagram",
        "cartesian" => "Intensity over γ",
        "isocandela" => "Isocandela diagram",
        "isolux" => "Illuminance on a plane at 1 m",
        "solid" => "Photometric solid",
        "spectrum" => "Spectrum",
        "cie1931" => "Chromaticity, CIE 1931",
        "cie1976" => "Chromaticity, CIE 1976",
        "tm30" => "Colour rendition, TM-30",
        "tm30_bins" => "Hue bins, TM-30",
        other => other,
    }
}

/// Pictures of `content` as (name, SVG), with `title` above each; none for a spectrum that is none.
pub fn pictures(content: &Content, title: &str) -> Vec<(&'static str, String)> {
    match content {
        Content::Distribution(distribution) => {
            let intensity = &distribution.intensity;
            let options = PolarOptions {
                title: title.to_owned(),
                per_lamp_flux_lm: distribution.lamp_flux_lm,
                doubtful_cd: None,
            };
            let isolux = IsoluxOptions::at_one_metre(intensity, title);
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
        Content::Spectrum(file) => spectrum(file, title),
    }
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
    pictures.extend(plots::tm30_bins(&spectrum, name));
    SPECTRUM.into_iter().zip(pictures).collect()
}
