//! Cells without a finite number: what a function that is not defined, or no light to divide by, leaves in a table.
//!
//! The CIE publishes its action spectra with NaN where a receptor has no value; spectrometers write `nan` for 0/0.

use std::ops::RangeInclusive;

use super::columns::{Columns, is_raw};
use super::rows::{Row, without_nm};
use crate::finding::{Finding, Findings};
use crate::number::{self, LARGEST_SPECTRAL as LARGEST, NotANumber, Number};

/// The wavelengths within which a value that is NaN or infinite is an error, unless it stands at an end of the table.
const VISIBLE_NM: RangeInclusive<f64> = 380.0..=780.0;
/// A column ends early where so many rows of it in a row say nothing; a single one is damage.
const END: usize = 2;

/// The number in a cell; none where the row has no such cell.
pub(super) fn number(row: &Row<'_>, column: usize) -> Option<Result<Number, NotANumber>> {
    let cell = row.cells.get(column)?;
    Some(number::read_up_to(without_nm(cell), LARGEST))
}

/// Where a column says something.
#[derive(Debug, Clone, Copy)]
pub(super) struct Extent {
    /// Lines of the first and the last number; none where the column does not end before the table does.
    begins: Option<usize>,
    ends: Option<usize>,
    /// No blank and no NaN stands between the two.
    unbroken: bool,
}

impl Extent {
    pub(super) fn of(body: &[Row<'_>], column: usize) -> Self {
        let rows: Vec<&Row<'_>> = body.iter().filter(|row| !row.comment).collect();
        let silent = |row: &Row<'_>| {
            let read = number(row, column);
            matches!(read, Some(Err(NotANumber::Blank | NotANumber::NotFinite)))
        };
        let first = rows.iter().position(|row| !silent(row)).unwrap_or(rows.len());
        let last = rows.iter().rposition(|row| !silent(row)).unwrap_or(0);
        let inside = rows.get(first..=last).unwrap_or_default();
        Self {
            begins: (first >= END).then(|| rows.get(first).map_or(usize::MAX, |row| row.line)),
            ends: (last + END < rows.len()).then(|| rows[last].line),
            unbroken: !inside.iter().any(|row| silent(row)),
        }
    }

    /// Whether the line lies before or behind what the column says.
    pub(super) fn excludes(&self, line: usize) -> bool {
        self.begins.is_some_and(|begins| line < begins) || self.ends.is_some_and(|ends| line > ends)
    }

    fn lines(&self) -> (usize, usize) {
        (self.begins.unwrap_or(0), self.ends.unwrap_or(usize::MAX))
    }
}

fn outside_visible(row: &Row<'_>, wavelength: usize) -> bool {
    let x = number(row, wavelength).and_then(Result::ok);
    // Small numbers are µm.
    x.is_some_and(|x| !VISIBLE_NM.contains(&if x.value < 30.0 { 1e3 * x.value } else { x.value }))
}

/// Puts the widest column first where the first of several begins later or ends earlier than the table, and says which
/// columns do.
pub(super) fn whole_first(columns: &mut Columns, names: &[&str], body: &[Row<'_>], findings: &mut Findings) {
    if columns.values.len() < 2 {
        return;
    }
    let extents: Vec<Extent> = columns.values.iter().map(|&column| Extent::of(body, column)).collect();
    let name = |column: usize| {
        names
            .get(column)
            .map_or(format!("column {}", column + 1), |name| format!("“{name}”"))
    };
    let rows = || body.iter().filter(|row| !row.comment);
    // Rows in which no column says anything shorten all of them.
    let from = extents.iter().map(|extent| extent.lines().0).min().unwrap_or(0);
    let to = extents
        .iter()
        .map(|extent| extent.lines().1)
        .max()
        .unwrap_or(usize::MAX);
    let silent = |extent: &Extent| {
        rows()
            .filter(|row| (from..=to).contains(&row.line) && extent.excludes(row.line))
            .count()
    };
    let short: Vec<(usize, usize)> = extents
        .iter()
        .zip(&columns.values)
        .filter_map(|(extent, &column)| Some((column, silent(extent))).filter(|&(_, count)| count > 0))
        .collect();
    let Some(&(_, count)) = short.first() else { return };
    let listed: Vec<String> = short.iter().map(|&(column, _)| name(column)).collect();
    let first = columns.values[0];
    let whole = |at: &usize| extents[*at].unbroken && silent(&extents[*at]) == 0;
    let light = |at: &usize| names.get(columns.values[*at]).is_none_or(|name| !is_raw(name));
    let widest = (0..extents.len()).filter(whole).find(light);
    // A ratio lacks what lies outside the visible; there a column chosen for its meaning stays.
    let lacks_visible = rows().any(|row| {
        let stated = (from..=to).contains(&row.line) && extents[0].excludes(row.line);
        stated && !outside_visible(row, columns.wavelength)
    });
    let mut assumed = "missing: null in these series".to_owned();
    if short[0].0 == first
        && lacks_visible
        && !columns.chosen
        && let Some(at) = widest
    {
        let column = columns.values.remove(at);
        columns.values.insert(0, column);
        assumed = format!("{}, which has all of them, where one series is needed", name(column));
    }
    let message = format!(
        "{} begins or ends before the table does: no value at {count} wavelengths",
        listed.join(", ")
    );
    let line = rows().find(|row| extents.iter().any(|extent| extent.excludes(row.line)));
    let finding = Finding::note("csv-series-shorter", message).assumed(assumed);
    findings.push(match line {
        Some(row) => finding.at(row.line, 1).raw(row.text),
        None => finding,
    });
}

/// The rows whose first value is NaN or infinite at either end of the table or outside the visible, which are left out,
/// and the others.
pub(super) fn split<'r, 't>(
    body: &'r [Row<'t>],
    columns: &Columns,
    findings: &mut Findings,
) -> (Vec<&'r Row<'t>>, Vec<&'r Row<'t>>) {
    let several = columns.values.len() > 1;
    let nothing = |row: &Row<'_>| {
        let silent = |&column: &usize| {
            matches!(
                number(row, column),
                Some(Err(NotANumber::Blank | NotANumber::NotFinite))
            )
        };
        several && columns.values.iter().all(silent)
    };
    let undefined = |row: &Row<'_>| {
        let value = columns.values.first().and_then(|&column| number(row, column));
        !row.comment && (matches!(value, Some(Err(NotANumber::NotFinite))) || nothing(row))
    };
    let outside = |row: &Row<'_>| outside_visible(row, columns.wavelength);
    let first = body.iter().position(|row| !undefined(row)).unwrap_or(0);
    let last = body.iter().rposition(|row| !undefined(row)).unwrap_or(body.len());
    let inside = |at: usize| (first..=last).contains(&at) && !outside(&body[at]);
    let (left_out, kept): (Vec<_>, Vec<_>) = (0..body.len()).partition(|&at| undefined(&body[at]) && !inside(at));
    if let Some(row) = left_out.first().map(|&at| &body[at]) {
        let count = left_out.len();
        let message = format!("{count} wavelengths have no finite value, at the ends or outside the visible");
        findings.push(
            Finding::warning("csv-nan", message)
                .at(row.line, 1)
                .raw(row.text)
                .assumed("left out")
                .fix("write the numbers that were measured, or remove these lines"),
        );
    }
    let rows = |at: Vec<usize>| at.into_iter().map(|at| &body[at]).collect();
    (rows(left_out), rows(kept))
}
