//! The columns of a readings file: one list, from which the header, the writer and both readers are made.

use std::fmt::Display;
use std::str::{FromStr, Split};

use camino::Utf8Path;

use super::error::ReadingsError;
use crate::reading::{Electrical, Quality, Reading, ReadingKind, Role};

/// A value of a reading as the text of a cell, and back.
trait Cell: Sized {
    fn text(&self) -> String;
    /// # Errors
    /// What is wrong with the text.
    fn parse(text: &str) -> Result<Self, String>;
}

impl Cell for f64 {
    /// The shortest decimal that reads back as the same number; never −0.
    fn text(&self) -> String {
        (self + 0.0).to_string()
    }

    fn parse(text: &str) -> Result<Self, String> {
        match text.parse::<Self>() {
            Ok(value) if value.is_finite() => Ok(value),
            _ => Err(format!("`{text}` is no finite number")),
        }
    }
}

impl Cell for String {
    fn text(&self) -> String {
        self.clone()
    }

    fn parse(text: &str) -> Result<Self, String> {
        Ok(text.to_owned())
    }
}

/// What is not there is an empty cell.
impl<T: Cell> Cell for Option<T> {
    fn text(&self) -> String {
        self.as_ref().map_or_else(String::new, T::text)
    }

    fn parse(text: &str) -> Result<Self, String> {
        if text.is_empty() {
            return Ok(None);
        }
        T::parse(text).map(Some)
    }
}

macro_rules! words {
    ($($type:ty),*) => {$(
        impl Cell for $type {
            fn text(&self) -> String {
                self.to_string()
            }

            fn parse(text: &str) -> Result<Self, String> {
                word(text)
            }
        }
    )*};
}
words!(u64, u32, i32, i8, ReadingKind, Quality, Role);

fn word<T: FromStr<Err: Display>>(text: &str) -> Result<T, String> {
    text.parse().map_err(|error| format!("`{text}`: {error}"))
}

/// The cells of a row, taken one after the other.
pub(super) struct Cells<'a> {
    pub file: &'a Utf8Path,
    pub line: usize,
    pub rest: Split<'a, char>,
}

impl<'a> Cells<'a> {
    pub fn wrong(&self, column: &'static str, message: String) -> ReadingsError {
        ReadingsError::Content {
            file: self.file.to_owned(),
            line: self.line,
            column,
            message,
        }
    }

    pub fn text(&mut self) -> &'a str {
        self.rest.next().unwrap_or_default()
    }

    fn take<T: Cell>(&mut self, column: &'static str) -> Result<T, ReadingsError> {
        let text = self.text();
        T::parse(text).map_err(|message| self.wrong(column, message))
    }
}

/// Each column is the field of that name; those in brackets are fields of `electrical`.
macro_rules! columns {
    ($($field:ident)* [$($electrical:ident)*] $($last:ident)*) => {
        /// Names of the columns before `chain`.
        pub(crate) const NAMES: &[&str] = &[
            $(stringify!($field),)* $(stringify!($electrical),)* $(stringify!($last),)*
        ];

        /// The header row. The first thirteen columns are the common ones of every readings file.
        pub const HEADER: &str = concat!(
            $(stringify!($field), ",",)* $(stringify!($electrical), ",",)* $(stringify!($last), ",",)* "chain,row_crc"
        );

        /// The cells before `chain`.
        pub(super) fn cells(reading: &Reading) -> Vec<String> {
            vec![$(reading.$field.text(),)* $(reading.electrical.$electrical.text(),)* $(reading.$last.text(),)*]
        }

        /// The reading of a row up to `chain`.
        pub(super) fn reading(cells: &mut Cells<'_>) -> Result<Reading, ReadingsError> {
            // Fields of a literal are evaluated in the order in which they stand.
            Ok(Reading {
                $($field: cells.take(stringify!($field))?,)*
                electrical: Electrical { $($electrical: cells.take(stringify!($electrical))?,)* },
                $($last: cells.take(stringify!($last))?,)*
            })
        }
    };
}

columns! {
    index block kind time_s c_deg gamma_deg distance_mm travel range ambient_c illuminance_lx u_lx quality
    role point repeat c_target_deg gamma_target_deg digit_lx integration_s raw
    [voltage_v current_a power_w power_factor]
    session burning lamp_s
}
