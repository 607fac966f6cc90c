//! Changing what a file says of the luminaire beside its light.

use serde_json::json;

use crate::distribution::Distribution;
use crate::eulumdat::fields::{Field, HEADER, SET, Value};
use crate::finding::Finding;
use crate::luminaire::Luminaire;
use crate::number;

impl Distribution {
    pub(super) fn set(&mut self, key: &str, text: &str) -> Result<String, Finding> {
        let entry = key
            .strip_prefix("luminaire.")
            .and_then(|name| ENTRIES.iter().find(|(entry, _)| *entry == name));
        let Some((name, keyword)) = entry else {
            let known: Vec<String> = ENTRIES.iter().map(|(name, _)| format!("luminaire.{name}")).collect();
            return Err(refused(
                format!("there is no entry “{key}”"),
                &format!("one of {}", known.join(", ")),
            ));
        };
        if text.contains(['\n', '\r']) {
            return Err(refused(format!("{key} has a line break in it"), "give one line"));
        }
        let text = text.trim();
        let luminaire = &mut self.luminaire;
        let mut header = self.eulumdat.as_mut().map(|document| &mut document.header);
        if *name == "laboratory" {
            text.clone_into(&mut luminaire.laboratory);
        } else if !put(HEADER, name, text, luminaire, header.as_deref_mut())? {
            let set = header.and_then(|header| header.lamp_sets.first_mut());
            put(SET, name, text, luminaire, set)?;
        }
        if name.starts_with("luminous_") {
            luminaire.luminous_body_mm = None;
        }
        if let Some(keyword) = keyword {
            self.set_keyword(keyword, text);
        }
        Ok(format!("{key} set to “{text}”"))
    }

    /// Replaces a keyword of LM-63, or adds it; a file of another format has none.
    fn set_keyword(&mut self, name: &str, text: &str) {
        let Some(list) = self
            .header
            .get_mut("keywords")
            .and_then(serde_json::Value::as_array_mut)
        else {
            return;
        };
        match list.iter_mut().find(|pair| pair["name"] == *name) {
            Some(pair) => pair["text"] = text.into(),
            None => list.push(json!({ "name": name, "text": text })),
        }
    }
}

/// Entries of the description by their names after `luminaire.`, with the keyword of LM-63 that says the same.
const ENTRIES: [(&str, Option<&str>); 15] = [
    ("manufacturer", Some("MANUFAC")),
    ("name", Some("LUMINAIRE")),
    ("number", Some("LUMCAT")),
    ("report", Some("TEST")),
    ("date", Some("ISSUEDATE")),
    ("laboratory", Some("TESTLAB")),
    ("lamp", Some("LAMP")),
    ("colour", None),
    ("rendering", None),
    ("watts", None),
    ("length_mm", None),
    ("width_mm", None),
    ("height_mm", None),
    ("luminous_length_mm", None),
    ("luminous_width_mm", None),
];

/// Puts `text` into the field of that name, in the description and in what EULUMDAT has of it; false where none of
/// `fields` has the name.
fn put<T>(
    fields: &[Field<T>],
    name: &str,
    text: &str,
    luminaire: &mut Luminaire,
    of: Option<&mut T>,
) -> Result<bool, Finding> {
    let named = |field: &&Field<T>| match field.value {
        Value::Text(_, Some((known, _))) | Value::Number(_, _, _, Some((known, _))) => known == name,
        _ => false,
    };
    match fields.iter().find(named).map(|field| &field.value) {
        Some(Value::Text(own, Some((_, shared)))) => {
            for place in [Some(shared(luminaire)), of.map(own)].into_iter().flatten() {
                text.clone_into(place);
            }
        }
        Some(Value::Number(_, _, own, Some((_, shared)))) => {
            let value = number::read(text).ok().map(|read| read.value);
            let Some(value) = value.filter(|value| *value >= 0.0) else {
                let message = format!("luminaire.{name}: “{text}” is no number from zero on");
                return Err(refused(message, "give a number"));
            };
            for place in [Some(shared(luminaire)), of.map(own)].into_iter().flatten() {
                *place = Some(value);
            }
        }
        _ => return Ok(false),
    }
    Ok(true)
}

/// An edit that cannot be made.
pub(super) fn refused(message: String, fix: &str) -> Finding {
    Finding::error("convert-edit", message).fix(fix)
}
