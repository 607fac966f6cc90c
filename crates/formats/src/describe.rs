//! A luminaire's description from one format's header into another's.

use serde_json::Value;

use crate::distribution::Distribution;
use crate::eulumdat;
use crate::ies;
use crate::parsed::Format;
use crate::tm33;

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
        ies::Facts {
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
    pub fn tilt_factors(&self) -> Option<ies::TiltFactors> {
        let tilt = self.header.get("tilt")?;
        let numbers =
            |key: &str| -> Option<Vec<f64>> { tilt.get(key)?.as_array()?.iter().map(Value::as_f64).collect() };
        Some(ies::TiltFactors {
            geometry: tilt.get("geometry")?.as_f64()?,
            angle_deg: numbers("angle_deg")?,
            factor: numbers("factor")?,
        })
    }

    /// Fields that were read, say something, and have no place in a file of format `target` (LM-63: of `edition`); what
    /// follows from the intensities and the flux is not counted.
    pub fn without_field(&self, target: Format, edition: ies::Edition) -> Vec<String> {
        if target == Format::Json || (target == Format::Eulumdat && self.eulumdat.is_some()) {
            return Vec::new();
        }
        let from_ies = target == Format::Ies && self.header.contains_key("keywords");
        let generations = edition >= ies::Edition::E2019;
        let mut lost: Vec<String> = self.opening_lost(target).into_iter().collect();
        for (key, value) in &self.header {
            match (key.as_str(), value) {
                (key, _) if SAID_AGAIN.contains(&key) || DESCRIPTION.contains(&key) => {}
                ("length_mm" | "width_mm" | "height_mm", _) if target != Format::Ies => {}
                (key, _) if key.starts_with("luminous_height") && target == Format::Ies => {}
                ("keywords", Value::Array(list)) if !from_ies => lost.extend(keywords_lost(list, target)),
                ("tilt", Value::Object(_)) if from_ies && self.tilt_factors().is_some() => {}
                // Of the generation it is the type that counts.
                ("labels" | "file_generation", _) if from_ies => {}
                ("file_generation_type", _) if from_ies && generations => {}
                ("file_generation_type", Value::String(code)) if from_ies && code == ies::GENERATION_TYPES[0].0 => {}
                ("future_use" | "photometric_factor", Value::Number(number)) if number.as_f64() == Some(1.0) => {}
                ("lamp_sets", Value::Array(sets)) => lost.extend(sets_lost(sets, target)),
                ("Header" | "Emitter" | "Luminaire" | "keywords", _) | (_, Value::Null) => {}
                (_, Value::String(text)) if text.is_empty() => {}
                (_, Value::Number(number)) if number.as_f64() == Some(0.0) => {}
                (_, Value::Array(list)) if list.is_empty() => {}
                (key, _) => lost.push(key.to_owned()),
            }
        }
        if target == Format::Tm33 && !self.absolute && self.lamp_flux_lm.is_some() {
            lost.push("relative photometry (the lamps' flux is kept as rated lumens)".to_owned());
        }
        lost.sort();
        lost.dedup();
        lost
    }

    /// What of the luminous opening a file of format `target` cannot say.
    fn opening_lost(&self, target: Format) -> Option<String> {
        let luminaire = &self.luminaire;
        let Some([x, y, z]) = luminaire.luminous_body_mm else {
            let heights = luminaire.luminous_height_mm.map(Option::unwrap_or_default);
            let most = heights.iter().fold(0.0_f64, |most, &height| most.max(height));
            let uneven = target == Format::Ies && heights.iter().any(|&height| height != most);
            return uneven
                .then(|| format!("luminous heights that differ (LM-63 has one; written: the largest, {most} mm)"));
        };
        let name = self.header.get("opening_shape").and_then(Value::as_str);
        let name = name.unwrap_or("elliptical");
        let size = || format!("{} × {} × {} mm along C0, C90 and γ = 0", x.abs(), y.abs(), z.abs());
        let fits = |outline: &str| format!("the shape of the luminous opening ({name}; written as {outline})");
        let (round, ellipse) = (x < 0.0 && x == y, x < 0.0 && y < 0.0);
        match target {
            Format::Eulumdat | Format::Tm33 if x * y == 0.0 && [x, y, z] != [0.0; 3] => Some(format!(
                "the luminous opening ({name}, {}: no area along γ = 0)",
                size()
            )),
            Format::Eulumdat if round && z < 0.0 => Some(fits("an upright cylinder")),
            Format::Eulumdat if ellipse && !round => Some(fits("a rectangle")),
            Format::Eulumdat if z < 0.0 => Some(fits("a box")),
            Format::Tm33 if z < 0.0 => Some(format!(
                "the shape and height of the luminous opening ({name}, {})",
                size()
            )),
            Format::Tm33 if z > 0.0 => Some(format!("the height of the luminous opening, {z} mm")),
            _ => None,
        }
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

/// Header keys that the intensities, the flux or the target's own fields say again.
const SAID_AGAIN: [&str; 32] = [
    "changes",
    "encoding",
    "line_ending",
    "symmetry_indicator",
    "type_indicator",
    "c_planes",
    "c_step_deg",
    "gamma_angles",
    "gamma_step_deg",
    "dff_percent",
    "lorl_percent",
    "direct_ratios",
    "conversion_factor",
    "version",
    "edition",
    "candela_multiplier",
    "ballast_factor",
    "vertical_angles",
    "horizontal_angles",
    "photometric_type",
    "units",
    "opening_shape",
    "lamp_count",
    "lumens_per_lamp",
    "input_watts",
    "width",
    "length",
    "height",
    "root",
    "@version",
    "@xmlns",
    "Version",
];

/// Header keys of EULUMDAT that every format has a field for.
const DESCRIPTION: [&str; 7] = [
    "company",
    "report_number",
    "luminaire_name",
    "luminaire_number",
    "date_user",
    "luminous_length_mm",
    "luminous_width_mm",
];

/// Keywords of LM-63 that the target has no field for.
fn keywords_lost(list: &[Value], target: Format) -> Vec<String> {
    let told = ["TEST", "ISSUEDATE", "MANUFAC", "LUMCAT", "LUMINAIRE", "LAMP"];
    list.iter()
        .filter(|pair| pair["text"] != "")
        .filter_map(|pair| pair["name"].as_str())
        .filter(|name| !(told.contains(name) || (*name == "TESTLAB" && target == Format::Tm33)))
        .map(|name| format!("[{name}]"))
        .collect()
}

/// What of EULUMDAT's lamp sets the target has no field for.
fn sets_lost(sets: &[Value], target: Format) -> Vec<String> {
    let mut lost = Vec::new();
    if sets.len() > 1 {
        lost.push(format!("{} lamp sets after the first", sets.len() - 1));
    }
    for key in ["colour_appearance", "colour_rendering"] {
        let said = sets.first().and_then(|set| set[key].as_str()).unwrap_or_default();
        let number = tm33::decimal(said).is_some();
        let kept = matches!(said, "" | "0") || (target == Format::Tm33 && number);
        if !kept {
            lost.push(key.to_owned());
        }
    }
    lost
}
