//! What of a header a format has no field for.

use serde_json::Value;

use crate::distribution::Distribution;
use crate::eulumdat::fields::HEADER;
use crate::finding::Finding;
use crate::ies::edition::{Edition, GENERATION_TYPES};
use crate::number::decimal;
use crate::parsed::{Format, Written};

impl Distribution {
    /// Fields that were read, say something, and have no place in a file of format `target` (LM-63: of `edition`); what
    /// follows from the intensities and the flux is not counted.
    pub fn without_field(&self, target: Format, edition: Edition) -> Vec<String> {
        if target == Format::JSON || (target == Format::EULUMDAT && self.eulumdat.is_some()) {
            return Vec::new();
        }
        let from_ies = target == Format::IES && self.header.contains_key("keywords");
        let generations = edition >= Edition::E2019;
        let mut lost: Vec<String> = self.opening_lost(target).into_iter().collect();
        for (key, value) in &self.header {
            match (key.as_str(), value) {
                (key, _) if DERIVED.contains(&key) || has_field(key, target) => {}
                ("keywords", Value::Array(list)) if !from_ies => lost.extend(keywords_lost(list, target)),
                ("tilt", Value::Object(_)) if from_ies && self.tilt_factors().is_some() => {}
                // Of the generation it is the type that counts.
                ("labels" | "file_generation", _) if from_ies => {}
                ("file_generation_type", _) if from_ies && generations => {}
                ("file_generation_type", Value::String(code)) if from_ies && code == GENERATION_TYPES[0].0 => {}
                ("future_use" | "photometric_factor", Value::Number(number)) if number.as_f64() == Some(1.0) => {}
                ("lamp_sets", Value::Array(sets)) => lost.extend(sets_lost(sets, target)),
                ("Header" | "Emitter" | "Luminaire" | "keywords", _) | (_, Value::Null) => {}
                (_, Value::String(text)) if text.is_empty() => {}
                (_, Value::Number(number)) if number.as_f64() == Some(0.0) => {}
                (_, Value::Array(list)) if list.is_empty() => {}
                (key, _) => lost.push(key.to_owned()),
            }
        }
        if target == Format::TM33 && !self.absolute && self.lamp_flux_lm.is_some() {
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
            let uneven = target == Format::IES && heights.iter().any(|&height| height != most);
            return uneven
                .then(|| format!("luminous heights that differ (LM-63 has one; written: the largest, {most} mm)"));
        };
        let name = self.header.get("opening_shape").and_then(Value::as_str);
        let name = name.unwrap_or("elliptical");
        let size = || format!("{} × {} × {} mm along C0, C90 and γ = 0", x.abs(), y.abs(), z.abs());
        let fits = |outline: &str| format!("the shape of the luminous opening ({name}; written as {outline})");
        let (round, ellipse) = (x < 0.0 && x == y, x < 0.0 && y < 0.0);
        match target {
            Format::EULUMDAT | Format::TM33 if x * y == 0.0 && [x, y, z] != [0.0; 3] => Some(format!(
                "the luminous opening ({name}, {}: no area along γ = 0)",
                size()
            )),
            Format::EULUMDAT if round && z < 0.0 => Some(fits("an upright cylinder")),
            Format::EULUMDAT if ellipse && !round => Some(fits("a rectangle")),
            Format::EULUMDAT if z < 0.0 => Some(fits("a box")),
            Format::TM33 if z < 0.0 => Some(format!(
                "the shape and height of the luminous opening ({name}, {})",
                size()
            )),
            Format::TM33 if z > 0.0 => Some(format!("the height of the luminous opening, {z} mm")),
            _ => None,
        }
    }
}

/// Header keys that follow from the intensities, the flux or the target's own fields.
const DERIVED: [&str; 26] = [
    "changes",
    "encoding",
    "line_ending",
    "symmetry_indicator",
    "c_planes",
    "gamma_angles",
    "direct_ratios",
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

/// Whether a file of format `target` can say what this key of EULUMDAT says.
fn has_field(key: &str, target: Format) -> bool {
    let field = HEADER.iter().find(|field| field.key == key);
    field.is_some_and(|field| (field.elsewhere)(target))
}

/// Keywords of LM-63 that the target has no field for.
fn keywords_lost(list: &[Value], target: Format) -> Vec<String> {
    let kept = ["TEST", "ISSUEDATE", "MANUFAC", "LUMCAT", "LUMINAIRE", "LAMP"];
    list.iter()
        .filter(|pair| pair["text"] != "")
        .filter_map(|pair| pair["name"].as_str())
        .filter(|name| !(kept.contains(name) || (*name == "TESTLAB" && target == Format::TM33)))
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
        let stated = sets.first().and_then(|set| set[key].as_str()).unwrap_or_default();
        let number = decimal(stated).is_some();
        let kept = matches!(stated, "" | "0") || (target == Format::TM33 && number);
        if !kept {
            lost.push(key.to_owned());
        }
    }
    lost
}

/// What was written, and what of the source's header its format (LM-63: of that edition) has no field for.
pub(crate) fn with_losses(
    mut written: Written,
    distribution: &Distribution,
    target: Format,
    edition: Edition,
) -> Written {
    let lost = distribution.without_field(target, edition);
    if !lost.is_empty() {
        let message = format!("this format has no field for: {}", lost.join(", "));
        written.findings.push(Finding::note("convert-header", message));
    }
    written
}
