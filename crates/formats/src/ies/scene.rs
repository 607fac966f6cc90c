//! What the numbers of an LM-63 file mean together: unit, header, luminaire.

use serde_json::{Map, Value, json};

use super::edition::{Edition, GENERATION_TYPES};
use super::lamp::Lamp;
use super::layout::{Layout, Token};
use super::photometry::Photometry;
use super::preamble::{Preamble, Tilt};
use super::shape::{self, Shape};
use super::tilt::TiltFactors;
use crate::finding::{Finding, Findings};
use crate::luminaire::Luminaire;
use crate::text::Text;

/// What was read, for the parts that are put together from it.
pub(super) struct Scene<'s, 't> {
    pub text: &'s Text<'t>,
    pub preamble: &'s Preamble,
    pub lamp: &'s Lamp,
    pub layout: &'s Layout,
    pub tokens: &'s [Token<'t>],
}

impl Scene<'_, '_> {
    pub(super) fn place(&self, index: usize) -> (usize, usize) {
        self.tokens
            .get(index)
            .map_or((1, 1), |token| (token.line + 1, token.column))
    }

    /// Keywords that speak of radiation, not of light.
    pub fn unit(&self, findings: &mut Findings) {
        if let Some((line, unit)) = self.preamble.radiometric() {
            let message = format!("the keywords say {unit}; the numbers are no luminous intensity");
            findings.push(
                Finding::warning("ies-unit", message)
                    .at(line + 1, 1)
                    .raw(self.text.line(line))
                    .assumed("candela: what is called cd, lm or lx is in the file's own unit")
                    .fix("read every photometric quantity of this file in its own unit"),
            );
        }
    }

    pub fn header(&self, tilt: Option<&TiltFactors>, vertical: &[f64], horizontal: &[f64]) -> Map<String, Value> {
        let lamp = self.lamp;
        let keywords: Vec<Value> = self
            .preamble
            .keywords
            .iter()
            .map(|keyword| json!({ "name": keyword.name, "text": keyword.text }))
            .collect();
        let tilt = match (&self.preamble.tilt, tilt) {
            (Tilt::File(name), None) => json!({ "file": name }),
            (Tilt::File(name), Some(tilt)) => {
                json!({ "file": name, "geometry": tilt.geometry, "angle_deg": tilt.angle_deg, "factor": tilt.factor })
            }
            (_, Some(tilt)) => {
                json!({ "geometry": tilt.geometry, "angle_deg": tilt.angle_deg, "factor": tilt.factor })
            }
            _ => Value::Null,
        };
        let opening: Vec<f64> = lamp.opening.iter().flatten().copied().collect();
        let shape = <[f64; 3]>::try_from(opening)
            .ok()
            .map(|opening| Shape::of(opening, self.preamble.edition).name());
        let mut header = json!({
            "version": self.preamble.version,
            "edition": self.preamble.edition.year(),
            "keywords": keywords,
            "labels": self.preamble.labels,
            "tilt": tilt,
            "lamp_count": lamp.count,
            "lumens_per_lamp": lamp.lumens_per_lamp,
            "candela_multiplier": lamp.multiplier,
            "vertical_angles": vertical.len(),
            "horizontal_angles": horizontal.len(),
            "photometric_type": lamp.photometric_type.to_string(),
            "units": lamp.units,
            "width": lamp.opening[0],
            "length": lamp.opening[1],
            "height": lamp.opening[2],
            "opening_shape": shape,
            "ballast_factor": lamp.ballast_factor,
            "input_watts": lamp.watts,
            "encoding": self.text.encoding,
            "line_ending": self.text.line_ending,
        });
        if let Some((_, unit)) = self.preamble.radiometric() {
            header["intensity_unit"] = unit.into();
        }
        match self.preamble.edition {
            Edition::E1986 | Edition::E1991 => header["photometric_factor"] = lamp.third.into(),
            Edition::E1995 | Edition::E2002 => header["future_use"] = lamp.third.into(),
            Edition::E2019 => {
                header["file_generation_type"] = lamp.third_text.clone().into();
                header["file_generation"] = lamp.third.and_then(generation).into();
            }
        }
        match header {
            Value::Object(map) => map,
            _ => Map::new(),
        }
    }

    pub fn luminaire(&self) -> Luminaire {
        let lamp = self.lamp;
        let keyword = |name: &str| {
            let found = self
                .preamble
                .keywords
                .iter()
                .find(|keyword| keyword.name.eq_ignore_ascii_case(name));
            found.map_or(String::new(), |keyword| keyword.text.replace('\n', " "))
        };
        let mut luminaire = Luminaire {
            manufacturer: keyword("MANUFAC"),
            name: keyword("LUMINAIRE"),
            number: keyword("LUMCAT"),
            report: keyword("TEST"),
            date: keyword("ISSUEDATE"),
            laboratory: keyword("TESTLAB"),
            lamp: keyword("LAMP"),
            lamp_count: lamp.count,
            watts: lamp.watts,
            ..Luminaire::default()
        };
        if let (Some(metres), [Some(width), Some(length), Some(height)]) = (lamp.metres, lamp.opening) {
            let photometry = match lamp.photometric_type {
                'A' => Photometry::A,
                'B' => Photometry::B,
                _ => Photometry::C,
            };
            let opening = [width, length, height].map(|value| value * metres * 1000.0);
            luminaire.set_luminous_body(shape::body(opening, self.preamble.edition, photometry));
        }
        luminaire
    }
}

/// What a file generation type means, if it is one.
fn generation(value: f64) -> Option<&'static str> {
    let types = GENERATION_TYPES.iter();
    let found = types
        .into_iter()
        .find(|(code, _)| code.parse::<f64>().is_ok_and(|code| (code - value).abs() < 5e-6));
    found.map(|&(_, meaning)| meaning)
}
