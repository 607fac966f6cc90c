//! What stands in front of the data: the heading, fields, comments, the unit of the wavelengths.

use serde_json::Value;

use super::rows::{Row, common_width, without_nm};
use crate::finding::{Finding, Findings};
use crate::number;
use crate::spectral::axis::{AxisUnit, is_wavelength_heading};
use crate::spectral::points::Draft;

/// The heading: the last line before the data that has a cell for every column, or a comment that has.
pub(super) fn heading<'r, 't>(before: &'r [Row<'t>], body: &[Row<'t>]) -> Option<&'r Row<'t>> {
    let width = common_width(body);
    before
        .iter()
        .rev()
        .take(4)
        .find(|row| {
            row.cells.len() == width
                && !row.text.contains(">>>>>")
                && (0..width).all(|k| !row.is_number(k))
                && (!row.comment || row.cells.iter().any(|cell| is_wavelength_heading(bare(cell))))
        })
        .or_else(|| {
            before.last().filter(|row| {
                row.cells.len() == width && row.cells.first().is_some_and(|c| is_wavelength_heading(bare(c)))
            })
        })
}

/// A cell without the mark of a comment.
pub(super) fn bare(cell: &str) -> &str {
    cell.trim_start_matches(['#', '%', '!']).trim()
}

/// `Key: value`, `Key,value` and comment lines in front of the data.
pub(super) fn preamble(before: &[Row<'_>], heading: Option<&Row<'_>>, draft: &mut Draft) {
    let mut comments: Vec<Value> = Vec::new();
    for row in before {
        if heading.is_some_and(|h| h.line == row.line) || row.text.contains(">>>>>") {
            continue;
        }
        let plain = row.text.trim().trim_start_matches(['#', '%', '!', '*', '/']).trim();
        let pair = plain
            .split_once(": ")
            .or_else(|| plain.split_once(":\t"))
            .or_else(|| plain.strip_suffix(':').map(|key| (key, "")))
            .or_else(|| (row.cells.len() == 2 && !row.comment).then(|| (row.cells[0], row.cells[1])));
        match pair {
            Some((key, value)) if !key.trim().is_empty() && key.len() < 80 => {
                draft
                    .header
                    .insert(key.trim().to_owned(), value.trim().trim_matches('"').into());
            }
            _ if !plain.is_empty() => comments.push(plain.into()),
            _ => {}
        }
    }
    if !comments.is_empty() {
        draft.header.insert("comments".into(), comments.into());
    }
}

/// A unit of the abscissa that stands in a comment or a line of its own: `XUNITS: 1/cm`, `# wavelength in um`.
fn stated_unit(before: &[Row<'_>], without_heading: bool) -> Option<AxisUnit> {
    before.iter().find_map(|row| {
        let lower = row.text.to_lowercase();
        let alone = row.cells.first().copied().unwrap_or("");
        let unit_alone = ["[nm]", "(nm)", "nm", "[µm]", "µm", "um", "cm-1", "1/cm"]
            .contains(&alone.to_lowercase().as_str())
            && row.cells.iter().skip(1).all(|cell| cell.is_empty());
        let about_axis = unit_alone
            || lower.contains("xunit")
            || lower.contains("x unit")
            || lower.contains("x-axis")
            || lower.contains("xaxis")
            || lower.contains("x axis mode")
            || (without_heading
                && (lower.contains("wavel") || lower.contains("lambda") || lower.contains("wavenumber")));
        let word = row
            .text
            .split_once([':', '=', ',', ';', '\t'])
            .map_or(row.text, |(_, value)| value);
        about_axis
            .then(|| AxisUnit::of(word).or_else(|| AxisUnit::of(row.text)))
            .flatten()
    })
}

/// [`stated_unit`], unless the numbers contradict it: comments outlive a conversion of the numbers.
pub(super) fn believable_unit(
    before: &[Row<'_>],
    without_heading: bool,
    body: &[Row<'_>],
    wavelength: usize,
    findings: &mut Findings,
) -> Option<AxisUnit> {
    let unit = stated_unit(before, without_heading)?;
    let x: Vec<f64> = body
        .iter()
        .filter_map(|row| number::read(without_nm(row.cells.get(wavelength)?)).ok())
        .map(|n| n.value)
        .collect();
    let (low, high) = x
        .iter()
        .fold((f64::INFINITY, 0.0f64), |(a, b), &x| (a.min(x), b.max(x)));
    let contradicted = match unit {
        AxisUnit::Angstrom => high < 2000.0,
        AxisUnit::Micrometre => low > 100.0,
        _ => false,
    };
    if !contradicted || x.is_empty() {
        return Some(unit);
    }
    findings.push(
        Finding::warning(
            "spectrum-axis-unit",
            format!(
                "a comment speaks of {}, but {low} to {high} {} is no range of light",
                unit.name(),
                unit.name()
            ),
        )
        .at(body[0].line, 1)
        .raw(unit.name())
        .assumed("nm")
        .fix("correct the comment, or write the unit into the heading"),
    );
    Some(AxisUnit::Nanometre)
}
