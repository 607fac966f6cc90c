//! Tables that lie on their side: one column a wavelength, one row a spectrum.

use super::rows::Row;
use crate::finding::{Finding, Findings};
use crate::number::{self, LARGEST_SPECTRAL as LARGEST};
use crate::spectral::axis::{AxisUnit, is_wavelength_heading};
use crate::spectral::point::Point;
use crate::spectral::points::Draft;

/// A line of so few cells between spectra of ten times as many describes them.
const DESCRIPTION: usize = 5;

/// Reads such a table into the draft; false where the file is not one.
pub(super) fn wide(rows: &[Row<'_>], draft: &mut Draft, findings: &mut Findings) -> bool {
    let Some((at, first)) = heading(rows) else {
        return false;
    };
    let head = &rows[at];
    let count = head.cells.len() - first;
    let body: Vec<&Row<'_>> = rows[at + 1..].iter().filter(|r| !r.comment).collect();
    // A tall table with many columns has more rows than a wide one has spectra, unless every heading says nm.
    let stated = head.cells[first..]
        .iter()
        .all(|cell| cell.to_lowercase().contains("nm"));
    if body.is_empty() || (body.len() * 2 > count && !stated) {
        return false;
    }
    let wavelengths: Vec<f64> = head.cells[first..].iter().filter_map(|c| wavelength(c)).collect();
    draft.points = (0..count)
        .map(|k| Point {
            line: head.line,
            column: head.column(first + k),
            x: wavelengths[k],
            value: Vec::with_capacity(body.len()),
        })
        .collect();
    draft.axis = head.cells[..first]
        .iter()
        .filter(|c| is_wavelength_heading(c))
        .chain(&head.cells[first..])
        .find_map(|c| AxisUnit::of(&c.replace(|d: char| d.is_ascii_digit(), " ")));
    for row in body {
        if row.cells.len() <= DESCRIPTION && count >= 10 * DESCRIPTION && !row.is_number(0) {
            findings.push(
                Finding::warning("csv-wide-description", "a line of few cells stands among the spectra")
                    .at(row.line, 1)
                    .raw(row.text)
                    .assumed("a description: not read")
                    .fix("if it is a spectrum that was cut, fetch the file again"),
            );
            continue;
        }
        if row.cells.len() != head.cells.len() {
            draft.whole = false;
            findings.push(
                Finding::error(
                    "csv-cells",
                    format!("{} cells stand under {} headings", row.cells.len(), head.cells.len()),
                )
                .at(row.line, 1)
                .raw(row.text)
                .fix("correct the line"),
            );
            continue;
        }
        draft.names.push(if first > 0 {
            row.cells[0].to_owned()
        } else {
            String::new()
        });
        for (k, cell) in row.cells[first..].iter().enumerate() {
            match number::read_up_to(cell, LARGEST) {
                Ok(n) => draft.points[k].value.push(Some(n.value)),
                Err(error) => {
                    draft.whole = false;
                    findings.push(
                        Finding::error("csv-number", error.to_string())
                            .at(row.line, row.column(first + k))
                            .raw(cell),
                    );
                }
            }
        }
    }
    true
}

/// The row whose cells, after at most twenty words, are at least eight rising wavelengths.
fn heading(rows: &[Row<'_>]) -> Option<(usize, usize)> {
    rows.iter().take(60).enumerate().find_map(|(index, row)| {
        let first = row.cells.iter().position(|c| wavelength(c).is_some())?;
        let x: Vec<f64> = row.cells[first..].iter().map_while(|c| wavelength(c)).collect();
        let all = x.len() == row.cells.len() - first;
        (first <= 20 && all && x.len() >= 8 && x.windows(2).all(|p| p[1] > p[0]) && (100.0..5e4).contains(&x[0]))
            .then_some((index, first))
    })
}

fn wavelength(cell: &str) -> Option<f64> {
    let lower = cell.trim().to_lowercase();
    let plain = lower.trim_end_matches("nm").trim_start_matches("nm").trim();
    number::read(plain).ok().map(|n| n.value)
}
