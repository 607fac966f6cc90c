//! The rows of a table as points of a spectrum.

use super::columns::Columns;
use super::rows::{Row, without_nm};
use super::undefined::{self, Extent};
use crate::finding::{Finding, Findings};
use crate::number::{self, LARGEST_SPECTRAL as LARGEST};
use crate::spectral::point::Point;
use crate::spectral::points::Draft;

/// Reads the rows of `body`, each of `width` cells.
pub(super) fn read(body: &[Row<'_>], columns: &Columns, width: usize, draft: &mut Draft, findings: &mut Findings) {
    let mut comma = None;
    let extents: Vec<(usize, Extent)> = columns.values.iter().map(|&k| (k, Extent::of(body, k))).collect();
    let (left_out, kept) = undefined::split(body, columns, findings);
    let wavelength = |row: &&Row<'_>| Some(undefined::number(row, columns.wavelength)?.ok()?.value);
    draft.left_out.extend(left_out.iter().filter_map(wavelength));
    for row in kept {
        if row.comment {
            continue;
        }
        if row.cells.len() != width {
            draft.whole = false;
            findings.push(
                Finding::error(
                    "csv-cells",
                    format!("{} cells stand where {width} are usual", row.cells.len()),
                )
                .at(row.line, 1)
                .raw(row.text)
                .fix("correct the line"),
            );
            continue;
        }
        let mut point = Point {
            line: row.line,
            column: row.column(columns.wavelength),
            x: 0.0,
            value: Vec::with_capacity(columns.values.len()),
        };
        let mut good = true;
        for (k, cell) in std::iter::once(columns.wavelength)
            .chain(columns.values.iter().copied())
            .map(|k| (k, row.cells[k]))
        {
            let text = if k == columns.wavelength {
                without_nm(cell)
            } else {
                cell
            };
            let read = match number::read_up_to(text, LARGEST) {
                Ok(read) => {
                    if read.comma {
                        comma.get_or_insert(row.line);
                    }
                    Some(read.value)
                }
                Err(number::NotANumber::Blank) if k != columns.wavelength && columns.values.len() > 1 => None,
                // NaN and infinity are how programs write what they could not compute; a spectrum's own values must be
                // there, but for the ends of the range, which `undefined::split` leaves out.
                Err(number::NotANumber::NotFinite) if k != columns.wavelength && columns.values.first() != Some(&k) => {
                    if !extents
                        .iter()
                        .any(|&(column, extent)| column == k && extent.excludes(row.line))
                    {
                        findings.push(
                            Finding::warning("csv-nan", "no number stands here")
                                .at(row.line, row.column(k))
                                .raw(cell)
                                .assumed("missing: null in this series")
                                .fix("write the number that was measured, or leave the cell empty"),
                        );
                    }
                    None
                }
                Err(error) => {
                    good = false;
                    findings.push(
                        Finding::error("csv-number", error.to_string())
                            .at(row.line, row.column(k))
                            .raw(cell)
                            .fix("write the number that was measured"),
                    );
                    None
                }
            };
            if k == columns.wavelength && point.value.is_empty() {
                point.x = read.unwrap_or(0.0);
            } else {
                point.value.push(read);
            }
        }
        if let Some(upper) = columns.upper {
            match number::read_up_to(row.cells[upper], LARGEST) {
                Ok(end) => point.x = 0.5 * (point.x + end.value),
                Err(error) => {
                    good = false;
                    findings.push(
                        Finding::error("csv-number", error.to_string())
                            .at(row.line, row.column(upper))
                            .raw(row.cells[upper])
                            .fix("write where the bin ends"),
                    );
                }
            }
        }
        draft.whole &= good;
        if good {
            draft.points.push(point);
        }
    }
    if let Some(line) = comma {
        findings.push(Finding::note("csv-decimal-comma", "numbers are written with a decimal comma").at(line, 1));
    }
}
