//! TOML documents written by people: parsed with the file, line and remedy of every fault.

pub mod bounds;
pub mod file;
mod wrong_type;

use std::fmt;

use camino::{Utf8Path, Utf8PathBuf};
use serde::de::DeserializeOwned;
use toml::Spanned;
use toml::de::{DeTable, DeValue};

use crate::file::LARGEST_DOCUMENT;

/// A document that cannot be used: where and what to do.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct DocumentError {
    /// The file.
    pub file: Utf8PathBuf,
    /// One-based line; none where the fault is of the whole file.
    pub line: Option<usize>,
    /// One-based column in characters.
    pub column: Option<usize>,
    /// What is wrong, in one sentence.
    pub message: String,
}

impl fmt::Display for DocumentError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}", self.file)?;
        if let Some(line) = self.line {
            write!(f, ":{line}")?;
            if let Some(column) = self.column {
                write!(f, ":{column}")?;
            }
        }
        write!(f, ": {}", self.message)
    }
}

impl std::error::Error for DocumentError {}

/// A fault that a domain rule found, before the file is known: the path of the key and what is wrong with it.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error("{path}: {message}")]
pub struct Fault {
    /// Path of the offending key, as `axis.c.limit_deg` or `block.2.kind`.
    pub path: String,
    /// What is wrong and what to do.
    pub message: String,
}

impl Fault {
    /// A fault of the key at `path`.
    pub fn new(path: impl Into<String>, message: impl Into<String>) -> Self {
        Self {
            path: path.into(),
            message: message.into(),
        }
    }
}

/// The text of a document and the file that it came from.
#[derive(Debug, Clone, Copy)]
pub struct SourceText<'a> {
    /// The file, for messages.
    pub file: &'a Utf8Path,
    /// Its whole text.
    pub text: &'a str,
}

impl SourceText<'_> {
    /// Parses the document and checks that its `format` is `format`.
    ///
    /// # Errors
    /// [`DocumentError`] with the line for a syntax error, a missing or unknown key, a value of the wrong type, a
    /// missing or foreign `format`.
    pub fn parse<T: DeserializeOwned>(&self, format: &str) -> Result<T, DocumentError> {
        let table = DeTable::parse(self.text).map_err(|error| self.toml_error(&error))?;
        match table.get_ref().get("format") {
            None => {
                return Err(self.whole(format!(
                    "no `format` key; this file should begin with format = \"{format}\""
                )));
            }
            Some(value) if value.get_ref().as_str() == Some(format) => {}
            Some(value) => {
                let found = value.get_ref().as_str().unwrap_or("no text");
                let message = format!("format is \"{found}\", expected \"{format}\"");
                return Err(self.at(value.span().start, message));
            }
        }
        toml::from_str(self.text).map_err(|error| self.toml_error(&error))
    }

    /// The same fault with file and line. The longest part of its path that stands in the file is pointed at.
    pub fn locate(&self, fault: &Fault) -> DocumentError {
        let mut offset = None;
        if let Ok(table) = DeTable::parse(self.text) {
            let mut place: Option<&Spanned<DeValue<'_>>> = None;
            for (depth, step) in fault.path.split('.').enumerate() {
                let next = match place {
                    None if depth == 0 => table.get_ref().get_key_value(step),
                    None => None,
                    Some(value) => match value.get_ref() {
                        // `list|range`: whichever of the two the file has.
                        DeValue::Table(inner) => step.split('|').find_map(|name| inner.get_key_value(name)),
                        DeValue::Array(inner) => {
                            place = step.parse::<usize>().ok().and_then(|index| inner.get(index));
                            match place {
                                Some(value) => offset = Some(value.span().start),
                                None => break,
                            }
                            continue;
                        }
                        _ => None,
                    },
                };
                match next {
                    Some((key, value)) => {
                        offset = Some(key.span().start);
                        place = Some(value);
                    }
                    None => break,
                }
            }
        }
        match offset {
            Some(offset) => self.at(offset, fault.to_string()),
            None => self.whole(fault.to_string()),
        }
    }

    /// What the TOML reader refused, in words, with file and line.
    pub fn toml_error(&self, error: &toml::de::Error) -> DocumentError {
        let message = wrong_type::explain(self.text, error);
        match error.span() {
            Some(span) => self.at(span.start, message),
            None => self.whole(message),
        }
    }

    /// What is wrong at the byte `offset`.
    pub fn at(&self, offset: usize, message: String) -> DocumentError {
        let before = self.text.get(..offset).unwrap_or(self.text);
        let line_start = before.rfind('\n').map_or(0, |newline| newline + 1);
        DocumentError {
            file: self.file.to_owned(),
            line: Some(before.matches('\n').count() + 1),
            column: Some(before[line_start..].chars().count() + 1),
            message,
        }
    }

    /// What is wrong with the whole file.
    pub fn whole(&self, message: String) -> DocumentError {
        DocumentError {
            file: self.file.to_owned(),
            line: None,
            column: None,
            message,
        }
    }
}

/// Reads a whole text file.
///
/// # Errors
/// [`DocumentError`] when it is not there, is no regular file of at most [`LARGEST_DOCUMENT`] bytes, or is not UTF-8.
pub fn read_text(path: &Utf8Path) -> Result<String, DocumentError> {
    let failed = |message: String| DocumentError {
        file: path.to_owned(),
        line: None,
        column: None,
        message,
    };
    let bytes = file::read(path, LARGEST_DOCUMENT).map_err(|error| failed(error.to_string()))?;
    String::from_utf8(bytes).map_err(|error| {
        let good = error.utf8_error().valid_up_to();
        let line = String::from_utf8_lossy(&error.as_bytes()[..good]).matches('\n').count() + 1;
        DocumentError {
            line: Some(line),
            ..failed("is not UTF-8 text".to_owned())
        }
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[derive(Debug, serde::Deserialize)]
    #[serde(deny_unknown_fields)]
    struct Toy {
        #[serde(rename = "format")]
        _format: String,
        #[serde(rename = "speed_deg_s")]
        _speed: f64,
    }

    #[test]
    fn every_fault_has_its_line() {
        let source = |text| SourceText {
            file: Utf8Path::new("toy.toml"),
            text,
        };
        let parse = |text| source(text).parse::<Toy>("toy/1").unwrap_err().to_string();
        assert!(parse("speed_deg_s = 1.0").contains("toy.toml: no `format`"));
        assert!(
            parse("# c\nformat = \"plan/1\"").starts_with("toy.toml:2:10: format is \"plan/1\", expected \"toy/1\"")
        );
        let unknown = parse("format = \"toy/1\"\nspeed_deg_s = 1.0\nsped = 2");
        assert!(unknown.starts_with("toy.toml:3:1: unknown field `sped`"), "{unknown}");
        let wrong = parse("format = \"toy/1\"\nspeed_deg_s = \"fast\"\n");
        assert_eq!(
            wrong,
            "toy.toml:2:15: `speed_deg_s` is the text \"fast\"; a number is needed, as in speed_deg_s = 1.5"
        );
        assert!(parse("format = \"toy/1\"\nspeed_deg_s = \n").starts_with("toy.toml:2"));
    }

    #[test]
    fn a_domain_fault_points_at_the_key_or_at_what_should_hold_it() {
        let text = "format = \"x\"\n[[block]]\nname = \"a\"\n[[block]]\nname = \"b\"\nkind = 3\n";
        let source = SourceText {
            file: Utf8Path::new("p.toml"),
            text,
        };
        assert_eq!(source.locate(&Fault::new("block.1.kind", "bad")).line, Some(6));
        assert_eq!(source.locate(&Fault::new("block.1.order", "bad")).line, Some(4));
        assert_eq!(source.locate(&Fault::new("block.0.label|name", "bad")).line, Some(3));
        assert_eq!(source.locate(&Fault::new("nowhere", "bad")).line, None);
    }
}
