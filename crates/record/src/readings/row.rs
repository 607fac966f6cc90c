//! A row of readings as text, with its checksum and the hash that ties it to the rows before it.

use std::fmt::Display;
use std::str::{FromStr, Split};

use camino::Utf8Path;

use super::error::ReadingsError;
use super::layout::Layout;
use crate::disk::sha256;
use crate::reading::{Electrical, Quality, Reading};

/// The hash of all rows up to one: the first 16 digits of SHA-256 over the one before and the row's own fields. A row
/// that was removed, doubled, exchanged or taken from another run does not continue it.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) struct Chain {
    layout: Layout,
    last: String,
}

impl Chain {
    pub(crate) const fn new(layout: Layout) -> Self {
        Self {
            layout,
            last: String::new(),
        }
    }

    /// The chain after a row whose hash is `last`.
    pub(super) const fn after(layout: Layout, last: String) -> Self {
        Self { layout, last }
    }

    /// The hash of the rows so far; empty before the first.
    pub(crate) fn last(&self) -> &str {
        &self.last
    }

    /// Continues with the fields of a row before its `chain`, with their last comma.
    fn link(&self, fields: &str) -> String {
        sha256(format!("{}{fields}", self.last).as_bytes())[..16].to_owned()
    }

    /// The row of `reading` with chain, checksum and line end, and the chain after it.
    pub(crate) fn row(&self, reading: &Reading) -> (String, Self) {
        let mut row = fields(self.layout, reading);
        let last = self.link(&row);
        row.push_str(&format!("{last},"));
        let crc = crc32fast::hash(row.as_bytes());
        row.push_str(&format!("{crc:08x}\n"));
        let layout = self.layout;
        (row, Self { layout, last })
    }
}

/// A number, or an empty cell.
fn optional(value: Option<f64>) -> String {
    value.map_or_else(String::new, number)
}

/// The columns before `chain`, each with its comma.
fn fields(layout: Layout, reading: &Reading) -> String {
    let time_s = if layout.has_run_time() {
        reading.time_s
    } else {
        reading.lamp_s
    };
    let line = &reading.electrical;
    let mut row = [
        reading.index.to_string(),
        reading.block.clone(),
        reading.kind.to_string(),
        optional(time_s),
        number(reading.c_deg),
        number(reading.gamma_deg),
        number(reading.distance_mm),
        reading.travel.to_string(),
        reading.range.to_string(),
        optional(reading.ambient_c),
        optional(reading.illuminance_lx),
        optional(reading.u_lx),
        reading.quality.to_string(),
        reading.role.to_string(),
        reading.point.to_string(),
        reading.repeat.to_string(),
        number(reading.c_target_deg),
        number(reading.gamma_target_deg),
        optional(reading.digit_lx),
        optional(reading.integration_s),
        reading.raw.clone(),
        optional(line.voltage_v),
        optional(line.current_a),
        optional(line.power_w),
        optional(line.power_factor),
        reading.session.to_string(),
        reading.burning.map_or_else(String::new, |burning| burning.to_string()),
    ]
    .join(",");
    row.push(',');
    if layout.has_run_time() {
        row.push_str(&format!("{},", optional(reading.lamp_s)));
    }
    row
}

/// The shortest decimal that reads back as the same number; never −0.
fn number(value: f64) -> String {
    format!("{}", value + 0.0)
}

/// Reads row number `row`, which stands on `line` and continues `chain`.
pub(super) fn parse_row(
    file: &Utf8Path,
    line: usize,
    row: usize,
    bytes: &[u8],
    chain: &mut Chain,
) -> Result<Reading, ReadingsError> {
    let text = checked(file, line, row, bytes)?;
    let (found, columns) = (text.split(',').count(), chain.layout.columns());
    let rest = text.split(',');
    let mut cells = Cells { file, line, rest };
    if found != columns {
        return Err(cells.wrong("row_crc", format!("{found} columns, expected {columns}")));
    }
    let reading = cells.reading(chain.layout)?;
    if reading.index != row as u64 {
        let message = format!("is {}, expected {row}: a row is missing or doubled", reading.index);
        return Err(cells.wrong("index", message));
    }
    if reading.illuminance_lx.is_some() != (reading.quality == Quality::Ok) {
        let message = "must be given exactly when quality is ok".to_owned();
        return Err(cells.wrong("illuminance_lx", message));
    }
    let linked_to = cells.text();
    // All fields but `chain` itself and the checksum, which `text` ends before.
    let linked = &text[..text.len() - linked_to.len() - 1];
    if chain.link(linked) != linked_to {
        let file = file.to_owned();
        return Err(ReadingsError::Chain { file, line, row });
    }
    linked_to.clone_into(&mut chain.last);
    Ok(reading)
}

/// The row up to its checksum, which is that of the bytes before it.
fn checked<'a>(file: &Utf8Path, line: usize, row: usize, bytes: &'a [u8]) -> Result<&'a str, ReadingsError> {
    let body = &bytes[..bytes.len() - 1];
    let split = body.iter().rposition(|&byte| byte == b',').map_or(0, |comma| comma + 1);
    let (covered, written) = body.split_at(split);
    let computed = format!("{:08x}", crc32fast::hash(covered));
    let text = std::str::from_utf8(covered).ok();
    text.filter(|_| written == computed.as_bytes())
        .ok_or_else(|| ReadingsError::Checksum {
            file: file.to_owned(),
            line,
            row,
            found: String::from_utf8_lossy(written).chars().take(16).collect(),
            computed,
        })
}

/// The cells of a row, taken one after the other.
struct Cells<'a> {
    file: &'a Utf8Path,
    line: usize,
    rest: Split<'a, char>,
}

impl<'a> Cells<'a> {
    fn wrong(&self, column: &'static str, message: String) -> ReadingsError {
        ReadingsError::Content {
            file: self.file.to_owned(),
            line: self.line,
            column,
            message,
        }
    }

    fn text(&mut self) -> &'a str {
        self.rest.next().unwrap_or_default()
    }

    fn number(&mut self, column: &'static str) -> Result<f64, ReadingsError> {
        let number = self.optional(column)?;
        number.ok_or_else(|| self.wrong(column, "`` is no finite number".to_owned()))
    }

    /// None where the cell is empty.
    fn optional(&mut self, column: &'static str) -> Result<Option<f64>, ReadingsError> {
        let text = self.text();
        match text.parse::<f64>() {
            _ if text.is_empty() => Ok(None),
            Ok(value) if value.is_finite() => Ok(Some(value)),
            _ => Err(self.wrong(column, format!("`{text}` is no finite number"))),
        }
    }

    fn word<T: FromStr<Err: Display>>(&mut self, column: &'static str) -> Result<T, ReadingsError> {
        let text = self.text();
        self.parsed(column, text)
    }

    fn parsed<T: FromStr<Err: Display>>(&self, column: &'static str, text: &str) -> Result<T, ReadingsError> {
        text.parse()
            .map_err(|error| self.wrong(column, format!("`{text}`: {error}")))
    }

    /// Everything up to `chain`. The cells are taken in the order in which the fields stand here.
    fn reading(&mut self, layout: Layout) -> Result<Reading, ReadingsError> {
        let mut reading = Reading {
            index: self.word("index")?,
            block: self.text().to_owned(),
            kind: self.word("kind")?,
            time_s: self.optional("time_s")?,
            c_deg: self.number("c_deg")?,
            gamma_deg: self.number("gamma_deg")?,
            distance_mm: self.number("distance_mm")?,
            travel: self.word("travel")?,
            range: self.word("range")?,
            ambient_c: self.optional("ambient_c")?,
            illuminance_lx: self.optional("illuminance_lx")?,
            u_lx: self.optional("u_lx")?,
            quality: self.word("quality")?,
            role: self.word("role")?,
            point: self.word("point")?,
            repeat: self.word("repeat")?,
            c_target_deg: self.number("c_target_deg")?,
            gamma_target_deg: self.number("gamma_target_deg")?,
            digit_lx: self.optional("digit_lx")?,
            integration_s: self.optional("integration_s")?,
            raw: self.text().to_owned(),
            electrical: Electrical {
                voltage_v: self.optional("voltage_v")?,
                current_a: self.optional("current_a")?,
                power_w: self.optional("power_w")?,
                power_factor: self.optional("power_factor")?,
            },
            session: self.word("session")?,
            burning: match self.text() {
                "" => None,
                burning => Some(self.parsed("burning", burning)?),
            },
            lamp_s: None,
        };
        if layout.has_run_time() {
            reading.lamp_s = self.optional("lamp_s")?;
        } else {
            // The run that these rows are of knows when they were taken.
            reading.lamp_s = reading.time_s.take();
        }
        Ok(reading)
    }
}
