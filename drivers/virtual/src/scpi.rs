//! Program messages of SCPI as a twin reads them: one line, units joined by `;`, headers in their short or long form.
//!
//! After SCPI-99 volume 1, chapters 6 and 7, and IEEE 488.2.

use std::collections::VecDeque;

use crate::twin::Answer;

/// Ten bits a byte.
const BYTE_S: f64 = 10.0 / 9600.0;
/// From the end of a message to the beginning of its answer.
const THINKING_S: f64 = 0.01;
/// Entries of the error queue.
const MOST_ERRORS: usize = 16;

/// One unit of a message: `:NUM:NORM:ITEM1 U`.
pub(crate) struct Unit {
    /// Words of the header in capitals, without the question mark.
    words: Vec<String>,
    pub query: bool,
    /// What stands behind the header, in capitals, without blanks around commas.
    pub parameters: Vec<String>,
}

impl Unit {
    /// Whether the header is this one, as `NUMeric:NORMal:ITEM#`: capitals are the short form, `#` a number (1 if left
    /// out). The numbers.
    pub fn is(&self, pattern: &str) -> Option<Vec<usize>> {
        let expected: Vec<&str> = pattern.split(':').collect();
        if expected.len() != self.words.len() {
            return None;
        }
        let mut numbers = Vec::new();
        for (word, expected) in self.words.iter().zip(expected) {
            let (name, numbered) = expected
                .strip_suffix('#')
                .map_or((expected, false), |name| (name, true));
            let bare = if numbered {
                let bare = word.trim_end_matches(|c: char| c.is_ascii_digit());
                numbers.push(word[bare.len()..].parse().unwrap_or(1));
                bare
            } else {
                word
            };
            let short: String = name.chars().filter(|c| !c.is_ascii_lowercase()).collect();
            if bare != short && bare != name.to_ascii_uppercase() {
                return None;
            }
        }
        Some(numbers)
    }

    /// Its one parameter.
    pub fn parameter(&self) -> Option<&str> {
        match &self.parameters[..] {
            [one] => Some(one),
            _ => None,
        }
    }
}

/// What SCPI demands of every instrument: the error queue.
#[derive(Debug, Default)]
pub(crate) struct Errors(VecDeque<(i32, &'static str)>);

impl Errors {
    pub fn push(&mut self, error: (i32, &'static str)) {
        if self.0.len() < MOST_ERRORS {
            self.0.push_back(error);
        } else if let Some(last) = self.0.back_mut() {
            *last = (-350, "Queue overflow");
        }
    }

    /// The oldest entry, as `SYST:ERR?` gives it.
    fn pop(&mut self) -> String {
        let (code, text) = self.0.pop_front().unwrap_or((0, "No error"));
        format!("{code},\"{text}\"")
    }
}

pub(crate) const UNDEFINED_HEADER: (i32, &str) = (-113, "Undefined header");
pub(crate) const ILLEGAL_VALUE: (i32, &str) = (-224, "Illegal parameter value");

/// One line off the front of `inbox`, without its end; CR LF and LF end it.
pub(crate) fn line(inbox: &mut Vec<u8>) -> Option<String> {
    let end = inbox.iter().position(|byte| *byte == b'\n')?;
    let line: Vec<u8> = inbox.drain(..=end).collect();
    Some(String::from_utf8_lossy(&line).trim_end_matches(['\r', '\n']).to_owned())
}

/// The units of a line. A header without a colon before it stands in the path of the one before (SCPI-99, 6.2.4).
pub(crate) fn units(line: &str) -> Vec<Unit> {
    let mut path: Vec<String> = Vec::new();
    let mut units = Vec::new();
    for text in line.split(';').map(str::trim).filter(|text| !text.is_empty()) {
        let (header, rest) = text.split_once([' ', '\t']).unwrap_or((text, ""));
        let (header, query) = header
            .strip_suffix('?')
            .map_or((header, false), |header| (header, true));
        let upper = header.to_ascii_uppercase();
        let words: Vec<String> = match upper.strip_prefix(':') {
            Some(whole) => whole.split(':').map(str::to_owned).collect(),
            None if upper.starts_with('*') => vec![upper.clone()],
            None => path
                .iter()
                .cloned()
                .chain(upper.split(':').map(str::to_owned))
                .collect(),
        };
        if !upper.starts_with('*') {
            path = words[..words.len() - 1].to_vec();
        }
        let parameters = rest.split(',').map(|parameter| parameter.trim().to_ascii_uppercase());
        units.push(Unit {
            words,
            query,
            parameters: parameters.filter(|parameter| !parameter.is_empty()).collect(),
        });
    }
    units
}

/// Runs a line: what all instruments have is answered here, the rest by `run`. The answers come in one line joined by
/// `;`.
pub(crate) fn run_line(
    line: &str,
    identity: &str,
    errors: &mut Errors,
    mut run: impl FnMut(&Unit) -> Result<Option<String>, (i32, &'static str)>,
) -> String {
    let mut answers = Vec::new();
    for unit in units(line) {
        match (unit.words.first().map(String::as_str), unit.query) {
            (Some("*IDN"), true) => answers.push(identity.to_owned()),
            (Some("*OPC"), true) => answers.push("1".to_owned()),
            (Some("*CLS"), false) => errors.0.clear(),
            (Some("*RST" | "*OPC"), false) => {}
            _ if unit.query && unit.is("SYSTem:ERRor").or(unit.is("SYSTem:ERRor:NEXT")).is_some() => {
                answers.push(errors.pop());
            }
            _ => match run(&unit) {
                Ok(answer) => answers.extend(answer),
                Err(error) => errors.push(error),
            },
        }
    }
    answers.join(";")
}

/// When and what is sent back; nothing for a line without a query.
pub(crate) fn reply(requested: &str, answer: &str, now_s: f64) -> Answer {
    if answer.is_empty() {
        return Answer::At(now_s, Vec::new());
    }
    let bytes = format!("{answer}\r\n").into_bytes();
    Answer::At(
        now_s + BYTE_S * (requested.len() + bytes.len()) as f64 + THINKING_S,
        bytes,
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn headers_have_two_forms_a_path_and_numbers() {
        let units = units(":num:norm:item2 u,1;number?;*IDN?;VAL?;:Numeric:Normal:VALUE? 1");
        assert_eq!(units[0].is("NUMeric:NORMal:ITEM#"), Some(vec![2]));
        assert_eq!(units[0].parameters, ["U", "1"]);
        assert!(units[1].query && units[1].is("NUMeric:NORMal:NUMBer").is_some());
        assert!(
            units[3].is("NUMeric:NORMal:VALue").is_some(),
            "a common command keeps the path"
        );
        assert!(units[4].is("NUMeric:NORMal:VALue").is_some() && units[4].parameter() == Some("1"));
        assert!(units[0].is("NUMeric:NORMal").is_none());
    }

    #[test]
    fn errors_queue_up_and_are_read_one_by_one() {
        let mut errors = Errors::default();
        let mut say = |line: &str| run_line(line, "me", &mut errors, |_| Err(UNDEFINED_HEADER));
        assert_eq!(say("*IDN?;NONSENSE"), "me");
        assert_eq!(say("SYST:ERR?"), "-113,\"Undefined header\"");
        assert_eq!(say(":SYSTEM:ERROR:NEXT?"), "0,\"No error\"");
    }
}
