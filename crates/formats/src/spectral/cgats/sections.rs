//! What stands in a CGATS file up to the end of its first table: keywords, names of fields, cells of data.

use serde_json::{Map, Value};

use super::tokens::{Token, cells, tokens};
use crate::finding::{Finding, Findings};
use crate::number;
use crate::text::Text;

/// The parts of a file.
pub(super) struct Sections<'t> {
    pub keywords: Map<String, Value>,
    /// Line of each keyword, in the order of the file.
    places: Vec<(String, usize)>,
    pub fields: Vec<Token<'t>>,
    pub data: Vec<Token<'t>>,
    /// Without damage so far.
    pub whole: bool,
}

/// A number that a keyword states, and its line.
pub(super) type Stated = Option<(f64, usize)>;

#[derive(Clone, Copy, PartialEq, Eq)]
enum Section {
    Keywords,
    Fields,
    Data,
}

impl<'t> Sections<'t> {
    /// None where the file has no table.
    pub fn of(text: &'t Text<'_>, findings: &mut Findings) -> Option<Self> {
        let mut sections = Self {
            keywords: Map::new(),
            places: Vec::new(),
            fields: Vec::new(),
            data: Vec::new(),
            whole: true,
        };
        let mut section = Section::Keywords;
        let (mut seen_format, mut seen_data, mut seen_end) = (false, false, false);
        for (index, line) in text.lines().enumerate() {
            let trimmed = line.trim();
            match (trimmed, section) {
                ("BEGIN_DATA_FORMAT", _) => (section, seen_format) = (Section::Fields, true),
                ("END_DATA_FORMAT", Section::Fields) => section = Section::Keywords,
                ("BEGIN_DATA", _) => (section, seen_data) = (Section::Data, true),
                ("END_DATA", _) => {
                    seen_end = true;
                    break;
                }
                ("", _) => {}
                (_, Section::Data) => {
                    let row = cells(line, index + 1, sections.fields.len());
                    if !trimmed.starts_with('#') || row.len() == sections.fields.len() {
                        sections.data.extend(row);
                    }
                }
                _ if trimmed.starts_with('#') => {}
                (_, Section::Keywords) => sections.keyword(line, index + 1, findings),
                (_, Section::Fields) => sections.fields.extend(tokens(line, index + 1)),
            }
        }
        if !seen_data || !seen_format {
            findings.push(
                Finding::error("sp-no-data", "the file has no BEGIN_DATA_FORMAT and BEGIN_DATA")
                    .at(text.len().max(1), 1)
                    .fix("the file is cut: fetch it again"),
            );
            return None;
        }
        if !seen_end {
            sections.whole = false;
            findings.push(
                Finding::error("sp-end", "END_DATA is missing: the file is cut")
                    .at(text.len().max(1), 1)
                    .fix("fetch the file again"),
            );
        }
        Some(sections)
    }

    fn keyword(&mut self, line: &str, number: usize, findings: &mut Findings) {
        let trimmed = line.trim();
        let (key, value) = trimmed.split_once(char::is_whitespace).unwrap_or((trimmed, ""));
        let value = value.trim().trim_matches('"');
        if key == "KEYWORD" {
            return;
        }
        self.places.push((key.to_owned(), number));
        let before = self.keywords.insert(key.to_owned(), value.into());
        match before {
            // One line each for illuminant, observer and filter.
            Some(Value::String(before)) if key == "WEIGHTING_FUNCTION" => {
                self.keywords
                    .insert(key.to_owned(), format!("{before}; {value}").into());
            }
            Some(_) => findings.push(
                Finding::warning("sp-keyword-repeated", format!("{key} stands here again"))
                    .at(number, 1)
                    .raw(line)
                    .assumed("the last one"),
            ),
            None => {}
        }
    }

    /// The number that a keyword states.
    pub fn number(&mut self, key: &str, findings: &mut Findings) -> Stated {
        let raw = self.keywords.get(key)?.as_str()?;
        let place = self.places.iter().rev().find(|(known, _)| known == key);
        let line = place.map_or(1, |(_, line)| *line);
        match number::read(raw) {
            Ok(number) => Some((number.value, line)),
            Err(error) => {
                findings.push(
                    Finding::error("sp-number", format!("{key}: {error}"))
                        .at(line, 1)
                        .raw(raw),
                );
                self.whole = false;
                None
            }
        }
    }
}
