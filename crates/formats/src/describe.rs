//! A luminaire's description from one format's header into another's.

use serde_json::Value;

use crate::Distribution;
use crate::eulumdat;
use crate::ies;

impl Distribution {
    /// The header of an EULUMDAT file. Without a lamp flux, and for absolute photometry, the reference is the
    /// luminaire's own flux: lamp count −1, LORL 100.
    pub fn eulumdat_header(&self) -> eulumdat::Header {
        let luminaire = &self.luminaire;
        let integral = self.intensity.flux().value();
        let (count, flux, lorl) = match self.lamp_flux_lm {
            Some(flux) if self.absolute => (-luminaire.lamp_count.unwrap_or(1.0), flux, None),
            Some(flux) => (luminaire.lamp_count.unwrap_or(1.0), flux, None),
            None => (-luminaire.lamp_count.unwrap_or(1.0).max(1.0), integral, Some(100.0)),
        };
        eulumdat::Header {
            company: luminaire.manufacturer.clone(),
            report: luminaire.report.clone(),
            name: luminaire.name.clone(),
            number: luminaire.number.clone(),
            date_user: luminaire.date.clone(),
            length_mm: luminaire.length_mm.or(luminaire.luminous_length_mm),
            width_mm: luminaire.width_mm.or(luminaire.luminous_width_mm),
            height_mm: luminaire.height_mm,
            luminous_length_mm: luminaire.luminous_length_mm,
            luminous_width_mm: luminaire.luminous_width_mm,
            luminous_height_mm: luminaire.luminous_height_mm,
            lorl_percent: lorl,
            tilt_deg: luminaire.tilt_deg.or(Some(0.0)),
            lamp_sets: vec![eulumdat::LampSet {
                count: Some(count),
                lamp: luminaire.lamp.clone(),
                flux_lm: Some(flux),
                colour: luminaire.colour.clone(),
                rendering: luminaire.rendering.clone(),
                watts: luminaire.watts,
            }],
            ..eulumdat::Header::default()
        }
    }

    /// What an LM-63 file says beside the light: the file's own keywords where it has them, else the description.
    pub fn ies_facts(&self) -> ies::Facts {
        let luminaire = &self.luminaire;
        let kept = self.header.get("keywords").and_then(Value::as_array).map(|list| {
            list.iter()
                .filter_map(|pair| Some((pair["name"].as_str()?.to_owned(), pair["text"].as_str()?.to_owned())))
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
        ies::Facts {
            keywords,
            lamp_flux_lm: self.lamp_flux_lm.filter(|_| !self.absolute),
            lamp_count: luminaire.lamp_count.filter(|&count| count >= 1.0).unwrap_or(1.0),
            opening_m: self.opening_m(),
            watts: luminaire.watts.unwrap_or(0.0),
            generation: None,
        }
    }

    /// Width, length and height of the luminous opening in m; a round one is −d, −d (LM-63-2002, annex on shapes).
    fn opening_m(&self) -> [f64; 3] {
        let luminaire = &self.luminaire;
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
            [width, length, height]
        }
    }
}
