//! A file's own record of its changes.

use serde_json::{Value, json};

use super::request::Edit;
use crate::distribution::Distribution;

impl Distribution {
    /// Keeps the sentences where a format has room for them: `changes` of the JSON, the keyword [OTHER] of LM-63, the
    /// line of date and user of EULUMDAT; and the file generation type of LM-63-2019.
    pub(super) fn record(&mut self, edits: &[Edit], changes: &[String]) {
        if changes.is_empty() {
            return;
        }
        let all = changes.join("; ");
        self.header.insert("changes".to_owned(), changes.into());
        if let Some(list) = self.header.get_mut("keywords").and_then(Value::as_array_mut) {
            list.push(json!({ "name": "OTHER", "text": format!("Changed with isolux: {all}") }));
        }
        let dated = |date: &str| {
            if date.is_empty() {
                format!("isolux: {all}")
            } else {
                format!("{date}; isolux: {all}")
            }
        };
        if let Some(document) = &mut self.eulumdat {
            document.header.date_user = dated(&document.header.date_user);
        }
        if !self.header.contains_key("keywords") {
            self.luminaire.date = dated(&self.luminaire.date);
        }
        let scaled = edits.iter().any(|edit| matches!(edit, Edit::ScaleFlux(_)));
        let interpolated = edits
            .iter()
            .any(|edit| matches!(edit, Edit::Resample(..) | Edit::RotateC(_) | Edit::Symmetrize(_)));
        if let Some(Value::String(code)) = self.header.get_mut("file_generation_type") {
            *code = generation(code, scaled, interpolated);
        }
    }
}

/// The code of LM-63-2019 for a test whose flux was scaled or whose angles were interpolated; other codes stay.
pub(super) fn generation(code: &str, scaled: bool, interpolated: bool) -> String {
    let mut digits: Vec<char> = code.chars().collect();
    let of_a_test = digits.len() == 7 && code.starts_with("1.") && code.ends_with("00");
    if of_a_test {
        for (at, set) in [(3, interpolated), (4, scaled)] {
            if set {
                digits[at] = '1';
            }
        }
    }
    digits.into_iter().collect()
}
