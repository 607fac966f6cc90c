//! A file's own record of its changes.

use serde_json::{Value, json};

use super::request::Edit;
use crate::distribution::Distribution;

impl Distribution {
    /// Keeps the sentences where a format has room for them: `changes` of the JSON, the keyword [OTHER] of LM-63, the
    /// line of date and user of EULUMDAT, in few words; and the file generation type of LM-63-2019. Returns the text of
    /// that line where it had to be cut to make room.
    pub(super) fn record(&mut self, edits: &[Edit], changes: &[String]) -> Option<String> {
        if changes.is_empty() {
            return None;
        }
        let all = changes.join("; ");
        self.header.insert("changes".to_owned(), changes.into());
        if let Some(list) = self.header.get_mut("keywords").and_then(Value::as_array_mut) {
            list.push(json!({ "name": "OTHER", "text": format!("Changed with isolux: {all}") }));
        }
        let words: Vec<String> = edits.iter().map(Edit::brief).collect();
        let words = format!("isolux: {}", words.join(", "));
        let mut cut = None;
        let mut put = |line: &mut String| {
            let (text, without_end) = dated(line, &words);
            let old = std::mem::replace(line, text);
            if without_end {
                cut = Some(old);
            }
        };
        if let Some(document) = &mut self.eulumdat {
            put(&mut document.header.date_user);
        }
        if !self.header.contains_key("keywords") {
            put(&mut self.luminaire.date);
        }
        let scaled = edits.iter().any(|edit| matches!(edit, Edit::ScaleFlux(_)));
        let interpolated = edits
            .iter()
            .any(|edit| matches!(edit, Edit::Resample(..) | Edit::RotateC(_) | Edit::Symmetrize(_)));
        if let Some(Value::String(code)) = self.header.get_mut("file_generation_type") {
            *code = generation(code, scaled, interpolated);
        }
        cut
    }
}

/// Characters of EULUMDAT's line of date and user.
const ROOM: usize = 78;

/// The remark behind what stands there, whose end is cut off where there is no room for both; and whether it was.
fn dated(date: &str, words: &str) -> (String, bool) {
    if date.is_empty() {
        return (words.to_owned(), false);
    }
    let room = ROOM.saturating_sub(words.chars().count() + 2);
    if date.chars().count() <= room {
        return (format!("{date}; {words}"), false);
    }
    let kept: String = date.chars().take(room.saturating_sub(3)).collect();
    (format!("{}...; {words}", kept.trim_end()), true)
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_generation_of_a_test_says_what_was_done_to_it() {
        assert_eq!(generation("1.10000", true, false), "1.10100");
        assert_eq!(generation("1.00000", true, true), "1.01100");
        assert_eq!(generation("1.00010", true, true), "1.00010");
        assert_eq!(generation("1.00001", true, false), "1.00001");
    }
}
