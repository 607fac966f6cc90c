//! Tables of bins: two columns of wavelengths, where each bin begins and where it ends.

use super::columns::Columns;
use super::rows::Row;
use super::undefined::number;
use crate::finding::{Finding, Findings};

/// Fewest rows that show it.
const FEWEST: usize = 8;
/// A bin ends where the next begins, but for this part of its width.
const APART: f64 = 0.05;

/// Takes the column that holds the ends of bins out of the values.
pub(super) fn take_upper_edges(columns: &mut Columns, body: &[Row<'_>], findings: &mut Findings) {
    let Some(upper) = columns.values.first().copied().filter(|_| columns.values.len() > 1) else {
        return;
    };
    let value = |row: &Row<'_>, column: usize| Some(number(row, column)?.ok()?.value);
    let edges: Vec<(f64, f64)> = body
        .iter()
        .filter_map(|row| Some((value(row, columns.wavelength)?, value(row, upper)?)))
        .collect();
    let meet = |pair: &&[(f64, f64)]| {
        let width = pair[0].1 - pair[0].0;
        width > 0.0 && (pair[0].1 - pair[1].0).abs() <= APART * width
    };
    let meeting = edges.windows(2).filter(meet).count();
    if edges.len() < FEWEST || meeting * 20 < 19 * (edges.len() - 1) {
        return;
    }
    columns.values.retain(|&column| column != upper);
    columns.upper = Some(upper);
    let message = format!(
        "column {} is where the bins of column {} end",
        upper + 1,
        columns.wavelength + 1
    );
    let finding = Finding::note("csv-bins", message).assumed("the wavelength is the middle of each bin");
    findings.push(finding.at(body[0].line, body[0].column(upper)).raw(body[0].text));
}
