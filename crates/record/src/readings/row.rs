//! A row of readings as text, with its checksum and the hash that ties it to the rows before it.

use camino::Utf8Path;

use super::columns::{self, Cells};
use super::error::ReadingsError;
use super::layout::Layout;
use crate::disk::sha256;
use crate::reading::{Quality, Reading};
use crate::row_crc::{self, Damaged};

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
        row += &row_crc::of(row.as_bytes());
        row.push('\n');
        let layout = self.layout;
        (row, Self { layout, last })
    }
}

/// The cells before `chain`, each with its comma.
fn fields(layout: Layout, reading: &Reading) -> String {
    let cells = match layout {
        Layout::V4 => columns::cells(reading),
        Layout::V3 => {
            let time_s = reading.lamp_s;
            let mut cells = columns::cells(&Reading {
                time_s,
                ..reading.clone()
            });
            cells.pop();
            cells
        }
    };
    cells.join(",") + ","
}

/// Reads row number `row`, which stands on `line` and continues `chain`.
pub(super) fn parse_row(
    file: &Utf8Path,
    line: usize,
    row: usize,
    bytes: &[u8],
    chain: &mut Chain,
) -> Result<Reading, ReadingsError> {
    let row_text = bytes.strip_suffix(b"\n").unwrap_or(bytes);
    let text = row_crc::covered(row_text).map_err(|Damaged { found, computed }| ReadingsError::Checksum {
        file: file.to_owned(),
        line,
        row,
        found,
        computed,
    })?;
    let (found, columns) = (text.split(',').count(), chain.layout.columns());
    let before_crc = text.strip_suffix(',').unwrap_or(text);
    let (fields, linked_to) = before_crc.rsplit_once(',').unwrap_or_default();
    let mut cells = Cells {
        file,
        line,
        rest: fields.split(','),
    };
    if found != columns {
        return Err(cells.wrong("row_crc", format!("{found} columns, expected {columns}")));
    }
    // A row of format 3 has no cell of `lamp_s`, the last one; its time is that of the lamp, and the run that it is of
    // knows when it was taken.
    let mut reading = columns::reading(&mut cells)?;
    if chain.layout == Layout::V3 {
        reading.lamp_s = reading.time_s.take();
    }
    if reading.index != row as u64 {
        let message = format!("is {}, expected {row}: a row is missing or doubled", reading.index);
        return Err(cells.wrong("index", message));
    }
    if reading.illuminance_lx.is_some() != (reading.quality == Quality::Ok) {
        let message = "must be given exactly when quality is ok".to_owned();
        return Err(cells.wrong("illuminance_lx", message));
    }
    let linked = &text[..=fields.len()];
    if chain.link(linked) != linked_to {
        let file = file.to_owned();
        return Err(ReadingsError::Chain { file, line, row });
    }
    linked_to.clone_into(&mut chain.last);
    Ok(reading)
}
