//! What an LM-63 file says beside the light, from a distribution of any source.

use serde_json::Value;

use super::tilt::TiltFactors;
use crate::distribution::Distribution;

/// What an LM-63 file says beside the light.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Facts {
    /// Keyword lines in order, without brackets: (`MANUFAC`, text). Text with line breaks continues with `[MORE]`.
    pub keywords: Vec<(String, String)>,
    /// Flux of all lamps in lm; none for absolute photometry (written as −1).
    pub lamp_flux_lm: Option<f64>,
    /// Number of lamps.
    pub lamp_count: f64,
    /// Luminous opening in m: width, length, height as type C has them, with the codes of 2002 for shapes.
    pub opening_m: [f64; 3],
    /// Input power in W.
    pub watts: f64,
    /// 2019: the file generation type, one of [`GENERATION_TYPES`](super::GENERATION_TYPES); undefined where none is
    /// given.
    pub generation: Option<String>,
    /// Written as `TILT=INCLUDE`.
    pub tilt: Option<TiltFactors>,
}

impl Distribution {
    /// What an LM-63 file says beside the light: the file's own keywords where it has them, else the description.
    pub fn ies_facts(&self) -> Facts {
        let luminaire = &self.luminaire;
        let kept = self.header.get("keywords").and_then(Value::as_array).map(|list| {
            list.iter()
                .filter_map(|pair| Some((pair["name"].as_str()?.to_owned(), pair["text"].as_str()?.to_owned())))
                .chain(self.labels())
                .collect::<Vec<_>>()
        });
        let keywords = kept.unwrap_or_else(|| {
            [
                ("TEST", &luminaire.report),
                ("TESTLAB", &luminaire.laboratory),
                ("ISSUEDATE", &luminaire.date),
                ("MANUFAC", &luminaire.manufacturer),
                ("LUMCAT", &luminaire.number),
                ("LUMINAIRE", &luminaire.name),
                ("LAMP", &luminaire.lamp),
            ]
            .into_iter()
            .filter(|(name, text)| !text.is_empty() || ["TEST", "TESTLAB", "ISSUEDATE", "MANUFAC"].contains(name))
            .map(|(name, text)| (name.to_owned(), text.clone()))
            .collect()
        });
        // A file of LM-63 keeps the record among its own keywords; see `edit`.
        let changes = self.header.get("changes").and_then(Value::as_array);
        let changes = changes.filter(|_| !self.header.contains_key("keywords"));
        let changes = changes.into_iter().flatten().filter_map(Value::as_str);
        let keywords = keywords
            .into_iter()
            .chain(changes.map(|change| ("OTHER".to_owned(), format!("Changed with isolux: {change}"))))
            .collect();
        Facts {
            keywords,
            lamp_flux_lm: self.lamp_flux_lm.filter(|_| !self.absolute),
            lamp_count: luminaire.lamp_count.filter(|&count| count >= 1.0).unwrap_or(1.0),
            opening_m: self.opening_m(),
            watts: luminaire.watts.unwrap_or(0.0),
            generation: self
                .header
                .get("file_generation_type")
                .and_then(Value::as_str)
                .map(str::to_owned),
            tilt: self.tilt_factors(),
        }
    }

    /// Label lines of LM-63-1986, as later editions have them.
    fn labels(&self) -> impl Iterator<Item = (String, String)> {
        let labels = self.header.get("labels").and_then(Value::as_array);
        let texts = labels.into_iter().flatten().filter_map(Value::as_str);
        texts
            .filter(|text| !text.trim().is_empty())
            .map(|text| ("OTHER".to_owned(), text.trim().to_owned()))
    }

    /// The tilt table of an LM-63 file, from `TILT=INCLUDE` or from the file that it names.
    pub fn tilt_factors(&self) -> Option<TiltFactors> {
        let tilt = self.header.get("tilt")?;
        let numbers =
            |key: &str| -> Option<Vec<f64>> { tilt.get(key)?.as_array()?.iter().map(Value::as_f64).collect() };
        Some(TiltFactors {
            geometry: tilt.get("geometry")?.as_f64()?,
            angle_deg: numbers("angle_deg")?,
            factor: numbers("factor")?,
        })
    }

    /// Width, length and height of the luminous opening in m, as type C has them, in the codes of LM-63-2002: length
    /// lies along C0–C180, where EULUMDAT has its width.
    fn opening_m(&self) -> [f64; 3] {
        let luminaire = &self.luminaire;
        if let Some([x, y, z]) = luminaire.luminous_body_mm {
            return [y, x, z].map(|mm| mm / 1000.0);
        }
        let length = luminaire.luminous_length_mm.unwrap_or(0.0) / 1000.0;
        let width = luminaire.luminous_width_mm.unwrap_or(0.0) / 1000.0;
        let height = luminaire
            .luminous_height_mm
            .iter()
            .flatten()
            .fold(0.0_f64, |most, &h| most.max(h))
            / 1000.0;
        if width == 0.0 && length > 0.0 {
            [-length, -length, height]
        } else {
            [length, width, height]
        }
    }
}
