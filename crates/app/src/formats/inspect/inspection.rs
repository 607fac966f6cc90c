//! What is said of one photometry or spectrum.

use camino::Utf8Path;
use isolux_formats::{Content, Finding, Format, Kind, Severity};
use schemars::JsonSchema;
use serde::{Deserialize, Deserializer, Serialize, Serializer};

use super::coloured::ColouredQuantities;
use super::mismatch::Meter;
use super::ray_quantities::RayQuantities;

/// What is said of one photometry or spectrum; serialises to the object of `inspect --json`.
#[derive(Debug, Serialize)]
pub struct Inspection {
    /// The file, `outer!inner` inside a container.
    pub file: String,
    /// The format that was recognised.
    pub format: Option<Format>,
    /// What it describes.
    pub kind: Option<Kind>,
    /// Whether its content can be used: `convert` writes it, or all its rays are there.
    pub readable: bool,
    /// What the reader found.
    pub findings: Vec<Finding>,
    /// What follows from the content.
    #[serde(serialize_with = "by_key")]
    pub quantities: Quantities,
    /// The content itself, for pictures.
    #[serde(skip)]
    pub content: Option<Content>,
}

/// What follows from the content of a file, with the keys of `inspect --json`.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(untagged)]
pub enum Quantities {
    /// Of a luminous intensity distribution with spectra over angle.
    Coloured(Box<ColouredQuantities>),
    /// Of a luminous intensity distribution.
    Distribution(Box<isolux_formats::Quantities>),
    /// Of a spectrum.
    Spectrum(Box<SpectrumQuantities>),
    /// Of a ray file.
    Rays(Box<RayQuantities>),
    /// Of what could not be read.
    None {},
}

/// How far a colour is from that of a rated temperature.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct RatedColour {
    /// The rated correlated colour temperature, K.
    pub cct_k: f64,
    /// What has the colour that is compared with: a Planckian radiator, or daylight from 5000 K on.
    pub of: String,
    /// Distance in (u′, v′) in steps of 0.0011 (CIE TN 001).
    pub steps: f64,
}

/// The quantities of a spectrum.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct SpectrumQuantities {
    /// What the spectrum gives alone.
    #[serde(flatten)]
    pub of: isolux_spectrum::Quantities,
    /// Spectral mismatch correction factor of the meter that was given, null where it has none; absent without a meter.
    #[serde(default, skip_serializing_if = "Option::is_none", deserialize_with = "given")]
    pub spectral_mismatch: Option<Option<f64>>,
    /// Distance from the colour of the temperature that was given; absent without one, or without light.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub rated_colour: Option<RatedColour>,
    /// Daylight efficacy ratio for the action spectrum that was given (CIE S 026), null where it has none; absent
    /// without one.
    #[serde(default, skip_serializing_if = "Option::is_none", deserialize_with = "given")]
    pub daylight_efficacy_ratio: Option<Option<f64>>,
}

/// A key that is there, null or not.
#[expect(clippy::option_option, reason = "absent, null and a number are three things")]
fn given<'de, D: Deserializer<'de>>(from: D) -> Result<Option<Option<f64>>, D::Error> {
    Deserialize::deserialize(from).map(Some)
}

/// In the order of the keys.
fn by_key<S: Serializer>(quantities: &Quantities, to: S) -> Result<S::Ok, S::Error> {
    let value = serde_json::to_value(quantities).map_err(serde::ser::Error::custom)?;
    value.serialize(to)
}

impl Inspection {
    /// Of a file of which nothing can be read.
    pub(super) fn unreadable(path: &Utf8Path, finding: Finding) -> Self {
        Self {
            file: path.to_string(),
            format: None,
            kind: None,
            readable: false,
            findings: vec![finding],
            quantities: Quantities::None {},
            content: None,
        }
    }

    /// What it is, in words: content and format.
    pub fn what(&self) -> String {
        let kind = match self.kind {
            Some(Kind::Distribution) => "luminous intensity distribution",
            Some(Kind::Spectrum) => "spectrum",
            Some(Kind::Rays) => "ray file",
            None => "",
        };
        let words = match (kind, self.format) {
            ("", _) => "of no known format".to_owned(),
            (kind, Some(format)) => format!("{kind}, {}", format.title()),
            (kind, None) => kind.to_owned(),
        };
        let end = if self.readable { "" } else { ", not readable" };
        format!("{words}{end}")
    }

    /// Whether any finding is an error.
    pub fn has_error(&self) -> bool {
        self.findings.iter().any(|finding| finding.severity == Severity::Error)
    }

    /// Classifies a distribution as an outdoor luminaire whose street side is C = `street_side_c_deg`, whatever the
    /// convention of its format; says so where its file does not allow that.
    pub fn facing(&mut self, street_side_c_deg: f64) {
        let Some(Content::Distribution(distribution)) = &self.content else {
            return;
        };
        let outdoor = distribution.outdoor(street_side_c_deg);
        if outdoor.is_none() {
            self.findings.push(
                Finding::warning(
                    "no-outdoor-classification",
                    "there is no classification of outdoor luminaires: the file does not hold candela from γ 0° to 90°",
                )
                .fix("measure the luminaire from γ 0° to 180°"),
            );
        }
        match &mut self.quantities {
            Quantities::Distribution(of) => of.outdoor = outdoor,
            Quantities::Coloured(all) => all.of.outdoor = outdoor,
            _ => {}
        }
    }

    /// Adds to a spectrum's quantities what `meter` makes of it: `spectral_mismatch`, null where it cannot be had, and
    /// why; and what was found in the meter's own files.
    pub fn seen_by(&mut self, meter: &Meter) {
        let Some(Content::Spectrum(file)) = &self.content else {
            return;
        };
        let Ok(source) = file.spectrum() else {
            return;
        };
        self.findings.extend_from_slice(meter.findings());
        let factor = match meter.mismatch(&source) {
            Ok(factor) => Some(factor),
            Err(why) => {
                self.findings.push(
                    Finding::warning(
                        "meter-no-factor",
                        format!("there is no spectral mismatch correction factor: {why}"),
                    )
                    .fix("check that the responsivity is this meter's, over the wavelengths of this light"),
                );
                None
            }
        };
        if let Quantities::Spectrum(quantities) = &mut self.quantities {
            quantities.spectral_mismatch = Some(factor);
        }
    }
}
