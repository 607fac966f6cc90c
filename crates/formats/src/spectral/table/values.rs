//! The rows of a table as points of a spectrum.

use super::columns::Columns;
use super::rows::{Row, without_nm};
use super::undefined::{self, Extent};
use crate::finding::{Finding, Findings};
use crate::number::{self, LARGEST_SPECTRAL as LARGEST, NotANumber};
use crate::spectral::point::Point;
use crate::spectral::points::Draft;

/// Reads the rows of `body`, each of `width` cells.
pub(super) fn read(body: &[Row<'_>], columns: &Columns, width: usize, draft: &mut Draft, findings: &mut Findings) {
    let mut reader = Reader {
        columns,
        extents: columns.values.iter().map(|&k| Extent::of(body, k)).collect(),
        comma: None,
    };
    let (left_out, kept) = undefined::split(body, columns, findings);
    let wavelength = |row: &&Row<'_>| Some(undefined::number(row, columns.wavelength)?.ok()?.value);
    draft.left_out.extend(left_out.iter().filter_map(wavelength));
    for row in kept.into_iter().filter(|row| !row.comment) {
        let point = if row.cells.len() == width {
            reader.point(row, findings)
        } else {
            let message = format!("{} cells stand where {width} are usual", row.cells.len());
            findings.push(
                Finding::error("csv-cells", message)
                    .at(row.line, 1)
                    .raw(row.text)
                    .fix("correct the line"),
            );
            None
        };
        draft.whole &= point.is_some();
        draft.points.extend(point);
    }
    if let Some(line) = reader.comma {
        findings.push(Finding::note("csv-decimal-comma", "numbers are written with a decimal comma").at(line, 1));
    }
}

struct Reader<'c> {
    columns: &'c Columns,
    /// Where each column of values says anything.
    extents: Vec<Extent>,
    /// First line with a decimal comma.
    comma: Option<usize>,
}

impl Reader<'_> {
    /// The point of a row; none where a cell is damaged, which its finding says.
    fn point(&mut self, row: &Row<'_>, findings: &mut Findings) -> Option<Point> {
        const MEASURED: &str = "write the number that was measured";
        let columns = self.columns;
        let mut damaged = false;
        let mut damage = |k: usize, error: NotANumber, fix: &str, findings: &mut Findings| {
            damaged = true;
            findings.push(
                Finding::error("csv-number", error.to_string())
                    .at(row.line, row.column(k))
                    .raw(row.cells[k])
                    .fix(fix),
            );
        };
        let mut x = 0.0;
        match self.number(row, without_nm(row.cells[columns.wavelength])) {
            Ok(read) => x = read,
            Err(error) => damage(columns.wavelength, error, MEASURED, findings),
        }
        let mut value = Vec::with_capacity(columns.values.len());
        for (place, &k) in columns.values.iter().enumerate() {
            match self.number(row, row.cells[k]) {
                Ok(read) => value.push(Some(read)),
                Err(error) if self.may_be_missing(row, place, error, findings) => value.push(None),
                Err(error) => damage(k, error, MEASURED, findings),
            }
        }
        if let Some(upper) = columns.upper {
            match number::read_up_to(row.cells[upper], LARGEST) {
                Ok(end) => x = 0.5 * (x + end.value),
                Err(error) => damage(upper, error, "write where the bin ends", findings),
            }
        }
        (!damaged).then(|| Point {
            line: row.line,
            column: row.column(columns.wavelength),
            x,
            value,
        })
    }

    fn number(&mut self, row: &Row<'_>, cell: &str) -> Result<f64, NotANumber> {
        let read = number::read_up_to(cell, LARGEST)?;
        if read.comma {
            self.comma.get_or_insert(row.line);
        }
        Ok(read.value)
    }

    /// Whether the value number `place` of the row may be left out.
    fn may_be_missing(&self, row: &Row<'_>, place: usize, error: NotANumber, findings: &mut Findings) -> bool {
        match error {
            NotANumber::Blank => self.columns.values.len() > 1,
            // NaN and infinity are how programs write what they could not compute; a spectrum's own values must be
            // there, but for the ends of the range, which `undefined::split` leaves out.
            NotANumber::NotFinite if place > 0 => {
                if !self.extents[place].excludes(row.line) {
                    let k = self.columns.values[place];
                    findings.push(
                        Finding::warning("csv-nan", "no number stands here")
                            .at(row.line, row.column(k))
                            .raw(row.cells[k])
                            .assumed("missing: null in this series")
                            .fix("write the number that was measured, or leave the cell empty"),
                    );
                }
                true
            }
            _ => false,
        }
    }
}
