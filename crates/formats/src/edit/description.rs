//! Changing what a file says of the luminaire beside its light.

use serde_json::{Value, json};

use crate::distribution::{Distribution, Luminaire};
use crate::eulumdat::document::Header;
use crate::finding::Finding;
use crate::number;

impl Distribution {
    pub(super) fn set(&mut self, key: &str, text: &str) -> Result<String, Finding> {
        let Some(name) = key
            .strip_prefix("luminaire.")
            .and_then(|name| FIELDS.iter().find(|field| **field == name))
        else {
            let known: Vec<String> = FIELDS.iter().map(|field| format!("luminaire.{field}")).collect();
            return Err(refused(
                format!("there is no entry “{key}”"),
                &format!("one of {}", known.join(", ")),
            ));
        };
        if text.contains(['\n', '\r']) {
            return Err(refused(format!("{key} has a line break in it"), "give one line"));
        }
        let text = text.trim();
        let header = self.eulumdat.as_mut().map(|document| &mut document.header);
        if let Some((of_luminaire, of_header)) = texts(&mut self.luminaire, header, name) {
            for field in [Some(of_luminaire), of_header].into_iter().flatten() {
                text.clone_into(field);
            }
        } else {
            let value = number::read(text)
                .ok()
                .map(|read| read.value)
                .filter(|value| *value >= 0.0);
            let Some(value) = value else {
                return Err(refused(
                    format!("{key}: “{text}” is no number from zero on"),
                    "give a number",
                ));
            };
            let header = self.eulumdat.as_mut().map(|document| &mut document.header);
            for field in numbers(&mut self.luminaire, header, name) {
                *field = Some(value);
            }
        }
        if let Some((_, keyword)) = KEYWORDS.iter().find(|(field, _)| field == name) {
            self.set_keyword(keyword, text);
        }
        Ok(format!("{key} set to “{text}”"))
    }

    /// Replaces a keyword of LM-63, or adds it; a file of another format has none.
    fn set_keyword(&mut self, name: &str, text: &str) {
        let Some(list) = self.header.get_mut("keywords").and_then(Value::as_array_mut) else {
            return;
        };
        match list.iter_mut().find(|pair| pair["name"] == *name) {
            Some(pair) => pair["text"] = text.into(),
            None => list.push(json!({ "name": name, "text": text })),
        }
    }
}

/// Entries of the description by their names after `luminaire.`.
const FIELDS: [&str; 15] = [
    "manufacturer",
    "name",
    "number",
    "report",
    "date",
    "laboratory",
    "lamp",
    "colour",
    "rendering",
    "watts",
    "length_mm",
    "width_mm",
    "height_mm",
    "luminous_length_mm",
    "luminous_width_mm",
];

/// Keywords of LM-63 that say the same.
const KEYWORDS: [(&str, &str); 7] = [
    ("manufacturer", "MANUFAC"),
    ("name", "LUMINAIRE"),
    ("number", "LUMCAT"),
    ("report", "TEST"),
    ("date", "ISSUEDATE"),
    ("laboratory", "TESTLAB"),
    ("lamp", "LAMP"),
];

/// The text of that name in the description, and in the header of EULUMDAT where it has a line for it.
fn texts<'d>(
    luminaire: &'d mut Luminaire,
    header: Option<&'d mut Header>,
    name: &str,
) -> Option<(&'d mut String, Option<&'d mut String>)> {
    let set = |header: &'d mut Header| header.lamp_sets.first_mut();
    Some(match name {
        "manufacturer" => (&mut luminaire.manufacturer, header.map(|header| &mut header.company)),
        "name" => (&mut luminaire.name, header.map(|header| &mut header.name)),
        "number" => (&mut luminaire.number, header.map(|header| &mut header.number)),
        "report" => (&mut luminaire.report, header.map(|header| &mut header.report)),
        "date" => (&mut luminaire.date, header.map(|header| &mut header.date_user)),
        "laboratory" => (&mut luminaire.laboratory, None),
        "lamp" => (&mut luminaire.lamp, header.and_then(set).map(|set| &mut set.lamp)),
        "colour" => (&mut luminaire.colour, header.and_then(set).map(|set| &mut set.colour)),
        "rendering" => (
            &mut luminaire.rendering,
            header.and_then(set).map(|set| &mut set.rendering),
        ),
        _ => return None,
    })
}

/// The numbers of that name in the description and in the header of EULUMDAT.
fn numbers<'d>(luminaire: &'d mut Luminaire, header: Option<&'d mut Header>, name: &str) -> Vec<&'d mut Option<f64>> {
    let (own, of_header) = match name {
        "watts" => (
            &mut luminaire.watts,
            header
                .and_then(|header| header.lamp_sets.first_mut())
                .map(|set| &mut set.watts),
        ),
        "length_mm" => (&mut luminaire.length_mm, header.map(|header| &mut header.length_mm)),
        "width_mm" => (&mut luminaire.width_mm, header.map(|header| &mut header.width_mm)),
        "height_mm" => (&mut luminaire.height_mm, header.map(|header| &mut header.height_mm)),
        "luminous_length_mm" => {
            luminaire.luminous_body_mm = None;
            (
                &mut luminaire.luminous_length_mm,
                header.map(|header| &mut header.luminous_length_mm),
            )
        }
        "luminous_width_mm" => {
            luminaire.luminous_body_mm = None;
            (
                &mut luminaire.luminous_width_mm,
                header.map(|header| &mut header.luminous_width_mm),
            )
        }
        _ => return Vec::new(),
    };
    std::iter::once(own).chain(of_header).collect()
}

/// An edit that cannot be made.
pub(super) fn refused(message: String, fix: &str) -> Finding {
    Finding::error("convert-edit", message).fix(fix)
}
