//! CSV rows with their lines, and TOML with the line of its first error.

mod error;

use std::collections::HashMap;
use std::str::FromStr;

use camino::Utf8Path;

pub use self::error::{ObservationError, Problem};
use crate::document::{Fault, SourceText};
use crate::file::{self, LARGEST_TABLE};
use crate::reading::UnknownWord;
use crate::row_crc;

/// A CSV file in memory: header, rows, and the line of each row.
#[derive(Debug, Clone, PartialEq, Default)]
pub(crate) struct Table {
    pub header: Vec<String>,
    rows: Vec<Row>,
}

#[derive(Debug, Clone, PartialEq)]
struct Row {
    /// One-based.
    line: u64,
    fields: Vec<String>,
    /// As it stands in the file, without its line end: what a row checksum is of.
    text: String,
}

pub(crate) fn read_bytes(path: &Utf8Path) -> Result<Vec<u8>, ObservationError> {
    file::read(path, LARGEST_TABLE).map_err(|error| ObservationError::new(path, None, Problem::Read(error.to_string())))
}

pub(crate) fn read_text(path: &Utf8Path) -> Result<String, ObservationError> {
    let text = String::from_utf8(read_bytes(path)?).map_err(|_| ObservationError::new(path, None, Problem::NotText))?;
    Ok(text.strip_prefix('\u{feff}').map(str::to_owned).unwrap_or(text))
}

pub(crate) fn parse_toml<T: serde::de::DeserializeOwned>(path: &Utf8Path, text: &str) -> Result<T, ObservationError> {
    toml::from_str(text).map_err(|error| {
        let wrong = SourceText { file: path, text }.toml_error(&error);
        ObservationError::new(path, wrong.line.map(|line| line as u64), Problem::Toml(wrong.message))
    })
}

/// What is wrong with a key of the TOML file `text`, with its line.
pub(crate) fn wrong_key<'a>(path: &'a Utf8Path, text: &'a str) -> impl Fn(Fault) -> ObservationError + 'a {
    move |fault| {
        let wrong = SourceText { file: path, text }.locate(&fault);
        ObservationError::new(path, wrong.line.map(|line| line as u64), Problem::Toml(wrong.message))
    }
}

pub(crate) fn line_of(text: &str, at: usize) -> u64 {
    1 + text.get(..at).unwrap_or(text).matches('\n').count() as u64
}

/// Counts lines that end in LF, CR LF or CR. The CSV reader's own count is one behind after CR LF, for the LF belongs
/// to its next row.
struct Lines<'a> {
    rest: &'a [u8],
    passed: usize,
    line: u64,
}

impl<'a> Lines<'a> {
    fn of(text: &'a str) -> Self {
        Self {
            rest: text.as_bytes(),
            passed: 0,
            line: 1,
        }
    }

    /// The line of the byte `at`, which rises from call to call.
    fn up_to(&mut self, at: usize) -> u64 {
        let (before, rest) = self.rest.split_at(at.saturating_sub(self.passed).min(self.rest.len()));
        let ends = |(i, byte): &(usize, &u8)| match **byte {
            b'\n' => true,
            b'\r' => before.get(i + 1).or(rest.first()) != Some(&b'\n'),
            _ => false,
        };
        self.line += before.iter().enumerate().filter(ends).count() as u64;
        self.passed += before.len();
        self.rest = rest;
        self.line
    }
}

impl Table {
    /// `torn_tail`: a last line without its line end is what a power cut leaves, and is no row.
    pub fn parse(path: &Utf8Path, text: &str, torn_tail: bool) -> Result<Self, ObservationError> {
        let whole = if torn_tail {
            text.rfind('\n').map_or("", |end| &text[..=end])
        } else {
            text
        };
        let mut table = Self::default();
        let mut reader = csv::ReaderBuilder::new()
            .has_headers(false)
            .flexible(true)
            .from_reader(whole.as_bytes());
        let mut lines = Lines::of(whole);
        for record in reader.records() {
            let record = record.map_err(|error| {
                let line = error.position().map(csv::Position::line);
                ObservationError::new(path, line, Problem::Read(error.to_string()))
            })?;
            let after_last = record.position().map_or(0, |position| position.byte() as usize);
            let row_text = whole.get(after_last..).unwrap_or("").trim_start_matches(['\r', '\n']);
            let line = lines.up_to(whole.len() - row_text.len());
            let fields: Vec<String> = record.iter().map(|field| field.trim().to_owned()).collect();
            if table.header.is_empty() {
                table.header = fields;
                for (index, name) in table.header.iter().enumerate() {
                    if !name.is_empty() && table.header[..index].contains(name) {
                        return Err(ObservationError::new(
                            path,
                            Some(line),
                            Problem::DuplicateColumn(name.clone()),
                        ));
                    }
                }
                continue;
            }
            if fields.len() != table.header.len() {
                let problem = Problem::FieldCount {
                    found: fields.len(),
                    expected: table.header.len(),
                };
                return Err(ObservationError::new(path, Some(line), problem));
            }
            let text = row_text.split(['\r', '\n']).next().unwrap_or("").to_owned();
            table.rows.push(Row { line, fields, text });
        }
        Ok(table)
    }

    /// The header, and the fields of every row as they were written.
    pub fn into_text(self) -> (Vec<String>, Vec<Vec<String>>) {
        (self.header, self.rows.into_iter().map(|row| row.fields).collect())
    }

    /// Column numbers by name, of a table that has the columns that it must have.
    pub fn columns_with(
        &self,
        path: &Utf8Path,
        required: &[&'static str],
    ) -> Result<HashMap<&str, usize>, ObservationError> {
        let columns = self.columns();
        match required.iter().find(|column| !columns.contains_key(*column)) {
            None => Ok(columns),
            Some(&column) => {
                let needed = required.join(", ");
                let problem = Problem::MissingColumn { column, needed };
                Err(ObservationError::new(path, Some(1), problem))
            }
        }
    }

    /// The rows, each with the numbers of the columns.
    pub fn rows<'a>(
        &'a self,
        path: &'a Utf8Path,
        columns: &'a HashMap<&'a str, usize>,
    ) -> impl Iterator<Item = Fields<'a>> {
        self.rows.iter().map(move |row| Fields { path, row, columns })
    }

    /// Column numbers by name.
    pub fn columns(&self) -> HashMap<&str, usize> {
        self.header
            .iter()
            .enumerate()
            .map(|(index, name)| (name.as_str(), index))
            .collect()
    }
}

/// Reads the fields of one row by column, with errors that say where.
pub(crate) struct Fields<'a> {
    path: &'a Utf8Path,
    row: &'a Row,
    columns: &'a HashMap<&'a str, usize>,
}

impl Fields<'_> {
    /// One-based line of the row.
    pub fn line(&self) -> u64 {
        self.row.line
    }

    pub fn error(&self, problem: Problem) -> ObservationError {
        ObservationError::new(self.path, Some(self.row.line), problem)
    }

    /// The text; empty where the column is absent.
    pub fn text(&self, column: &str) -> &str {
        self.columns
            .get(column)
            .map_or("", |index| self.row.fields[*index].as_str())
    }

    /// A word that names one of a few things.
    pub fn word<T: FromStr<Err = UnknownWord>>(&self, column: &'static str) -> Result<T, ObservationError> {
        let word = self.text(column).parse();
        word.map_err(|UnknownWord { found, expected }| {
            self.error(Problem::UnknownWord {
                column,
                found,
                expected,
            })
        })
    }

    /// Compares the row with its checksum, `row_crc` in the last column.
    pub fn checked(&self) -> Result<(), ObservationError> {
        let end = self.row.text.rfind(',').map_or(0, |comma| comma + 1);
        let (found, computed) = (
            self.text("row_crc").to_owned(),
            row_crc::of(&self.row.text.as_bytes()[..end]),
        );
        if found == computed {
            return Ok(());
        }
        Err(self.error(Problem::Checksum { found, computed }))
    }

    pub fn optional(&self, column: &'static str) -> Result<Option<f64>, ObservationError> {
        let text = self.text(column);
        if text.is_empty() {
            return Ok(None);
        }
        match text.parse::<f64>() {
            Ok(value) if value.is_finite() => Ok(Some(value)),
            _ => Err(self.error(Problem::NotANumber {
                column,
                found: text.to_owned(),
            })),
        }
    }

    pub fn number(&self, column: &'static str) -> Result<f64, ObservationError> {
        self.optional(column)?.ok_or_else(|| self.error(Problem::Empty(column)))
    }

    pub fn whole(&self, column: &'static str) -> Result<Option<i64>, ObservationError> {
        let Some(value) = self.optional(column)? else {
            return Ok(None);
        };
        let is_whole = value.fract() == 0.0 && value.abs() < 9e15;
        self.require(is_whole, column, value, "a whole number")?;
        Ok(Some(value as i64))
    }

    pub fn positive(&self, column: &'static str) -> Result<f64, ObservationError> {
        let value = self.number(column)?;
        self.require(value > 0.0, column, value, "above zero")
    }

    /// A number in `low`…`high`, both ends included; `expected` says so.
    pub fn within(
        &self,
        column: &'static str,
        low: f64,
        high: f64,
        expected: &'static str,
    ) -> Result<f64, ObservationError> {
        let value = self.number(column)?;
        self.require((low..=high).contains(&value), column, value, expected)
    }

    /// A number above that of the row before.
    pub fn above(&self, column: &'static str, before: f64) -> Result<f64, ObservationError> {
        let value = self.number(column)?;
        self.require(value > before, column, value, "above that of the row before")
    }

    /// `found`, where it is what is `expected`.
    pub fn require(
        &self,
        holds: bool,
        column: &'static str,
        found: f64,
        expected: &'static str,
    ) -> Result<f64, ObservationError> {
        if holds {
            return Ok(found);
        }
        Err(self.error(Problem::OutOfRange {
            column,
            found,
            expected,
        }))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rows_know_their_lines_whatever_ends_them() {
        for end in ["\n", "\r\n", "\r"] {
            let text = ["index,u", "0,1", "", "1,2", "2,3", ""].join(end);
            let table = Table::parse("readings.csv".into(), &text, false).unwrap();
            let lines: Vec<u64> = table.rows.iter().map(|row| row.line).collect();
            assert_eq!(lines, [2, 4, 5], "{end:?}");
        }
    }
}
