//! Tables with one wavelength a row: where the data begin and end, and which column is what.

use serde_json::Value;

use super::columns::{Columns, small};
use super::preamble::{bare, believable_unit, heading, preamble};
use super::rows::{Row, common_width, is_begin, without_nm};
use super::{bins, claim, undefined, values};
use crate::finding::{Finding, Findings};
use crate::number::{self, LARGEST_SPECTRAL as LARGEST};
use crate::parsed::Format;
use crate::spectral::axis::{AxisUnit, is_wavelength_heading};
use crate::spectral::point::Point;
use crate::spectral::points::Draft;
use crate::spectral::quantity::quantity_of;
use crate::text::Text;

/// One wavelength a row.
pub(super) fn tall(
    rows: &[Row<'_>],
    text: &Text<'_>,
    (format, requested): (Format, Option<[usize; 2]>),
    draft: &mut Draft,
    findings: &mut Findings,
) {
    let Some((first, end)) = extent(rows, text, findings) else {
        describe_failure(rows, text, draft, findings);
        return;
    };
    let before = &rows[..first];
    let body = without_description(&rows[first..end], draft, findings);
    let heading = heading(before, body);
    preamble(before, heading, draft);

    let width = common_width(body);
    let names: Vec<&str> = heading.map_or(Vec::new(), |row| row.cells.iter().map(|name| bare(name)).collect());
    let pairs =
        requested.is_none() && format == Format::SPD && names.is_empty() && width > 2 && width.is_multiple_of(2);
    if pairs && in_one_run(body) {
        pairs_in_a_run(body, draft, findings);
        return;
    }
    let names = if names.len() == width { names } else { Vec::new() };
    let mut columns = match requested {
        Some(requested) => match Columns::requested(requested, width) {
            Ok(columns) => columns,
            Err(finding) => {
                draft.whole = false;
                findings.push(finding.at(body[0].line, 1).raw(body[0].text));
                return;
            }
        },
        None => Columns::of(&names, body, width, findings),
    };
    let name = names.get(columns.wavelength);
    draft.axis = name
        .and_then(|name| AxisUnit::of(name))
        .or_else(|| believable_unit(before, names.is_empty(), body, columns.wavelength, findings))
        .or_else(|| {
            let cell = body.iter().find_map(|row| row.cells.get(columns.wavelength));
            cell.filter(|cell| without_nm(cell) != **cell)
                .map(|_| AxisUnit::Nanometre)
        })
        // Pairs of pbrt and Mitsuba are in nm by definition.
        .or((format != Format::CSV && !small(body, columns.wavelength)).then_some(AxisUnit::Nanometre));
    let marked = rows.iter().any(|row| is_begin(row.text));
    let claimed = requested.is_some()
        || format != Format::CSV
        || marked
        || draft.axis.is_some()
        || name.is_some_and(|name| is_wavelength_heading(name));
    // What stands further up is a description, not a heading.
    let above = before.last();
    let named: &[&str] = match (heading, above) {
        (Some(heading), Some(above)) if heading.line == above.line => &names,
        _ => &[],
    };
    if !claimed && let Some(finding) = claim::refusal(&columns, named, above, body) {
        draft.whole = false;
        findings.push(finding);
        return;
    }
    if requested.is_none() {
        bins::take_upper_edges(&mut columns, body, findings);
    }
    undefined::whole_first(&mut columns, &names, body, findings);
    describe_values(&columns, &names, draft);
    values::read(body, &columns, width, draft, findings);
    // What the writer put into comments.
    for (field, key) in [(&mut draft.quantity, "quantity"), (&mut draft.unit, "unit")] {
        if field.is_none()
            && let Some(text) = draft.header.remove(key)
        {
            *field = text.as_str().map(str::to_owned);
        }
    }
}

/// First row of the data, and the row behind which nothing of them can be.
fn extent(rows: &[Row<'_>], text: &Text<'_>, findings: &mut Findings) -> Option<(usize, usize)> {
    let begin = rows.iter().position(|row| is_begin(row.text));
    let earliest = begin.map_or(0, |begin| begin + 1);
    let first = (earliest..rows.len()).find(|&i| rows[i].is_data())?;
    // Damage in the very first line of data must not turn it into a heading.
    let first = (earliest..first)
        .rev()
        .take_while(|&i| rows[i].nearly_data())
        .last()
        .unwrap_or(first);
    let above = |i: usize| i.checked_sub(1).map(|k| &rows[k]);
    let first = match first.checked_sub(1) {
        Some(i) if i >= earliest && rows[i].torn(&rows[first], above(i)) => i,
        _ => first,
    };
    let end = (first..rows.len()).find(|&i| rows[i].text.contains(">>>>>"));
    if begin.is_some() && end.is_none() {
        findings.push(Finding::note("csv-no-end", "no >>>>>End<<<<< line closes the data").at(text.len(), 1));
    }
    Some((first, end.unwrap_or(rows.len())))
}

/// The first table without what is written behind it, which goes into the header.
fn without_description<'r, 't>(rows: &'r [Row<'t>], draft: &mut Draft, findings: &mut Findings) -> &'r [Row<'t>] {
    let usual = common_width(rows);
    let body = without_footer(rows, usual);
    let last = body
        .iter()
        .rposition(|row| row.is_data() || row.nearly_data() || row.lost_its_wavelength(usual))
        .unwrap_or(0);
    let after = &rows[last + 1..];
    let mut words = after.iter().filter(|row| !row.comment);
    if let Some(row) = words.next() {
        findings.push(
            Finding::note(
                "csv-after-data",
                format!("{} lines stand after the data", 1 + words.count()),
            )
            .at(row.line, 1)
            .raw(row.text)
            .assumed("a description: kept in the header"),
        );
    }
    preamble(after, None, draft);
    first_table(&body[..=last], findings)
}

/// What the heading says of the values.
fn describe_values(columns: &Columns, names: &[&str], draft: &mut Draft) {
    let of = |&k: &usize| names.get(k).copied();
    draft.names = columns
        .values
        .iter()
        .map(|k| of(k).unwrap_or_default().to_owned())
        .collect();
    if let Some(name) = columns.values.first().and_then(of) {
        (draft.quantity, draft.unit) = quantity_of(name);
        let columns = names.iter().map(|name| Value::from(*name)).collect();
        draft.header.insert("columns".into(), columns);
    }
}

/// The rows before a second table: three lines without data, then wavelengths that begin anew.
fn first_table<'r, 't>(body: &'r [Row<'t>], findings: &mut Findings) -> &'r [Row<'t>] {
    let x = |row: &Row<'_>| number::read(without_nm(row.cells.first().copied().unwrap_or(""))).map(|n| n.value);
    let last_before = |at: usize| at.checked_sub(1).map(|at| x(&body[at]));
    let mut quiet = 0;
    for (i, row) in body.iter().enumerate() {
        if !row.is_data() {
            quiet += 1;
            continue;
        }
        // A blank line, a title, and numbers that begin below all before are a table of something else.
        let titled = || quiet >= 1 && body[i - quiet].line > body[i - quiet - 1].line + 1;
        let below_all = || matches!((x(&body[0]), x(row)), (Ok(first), Ok(now)) if now < first);
        if (quiet >= 3 || (i > quiet && titled() && below_all()))
            && let (Some(Ok(before)), Ok(now)) = (last_before(i - quiet), x(row))
            && now <= before
        {
            findings.push(
                Finding::warning("csv-blocks", "a second table stands in this file and is not read")
                    .at(body[i - quiet].line, 1)
                    .raw(body[i - quiet].text)
                    .assumed("the first table")
                    .fix("put each table into a file of its own"),
            );
            return &body[..i - quiet];
        }
        quiet = 0;
    }
    body
}

/// The rows without those that stand, behind a blank line, below the last row of the usual width: `Lux`, `276`.
fn without_footer<'r, 't>(body: &'r [Row<'t>], usual: usize) -> &'r [Row<'t>] {
    let Some(last) = body.iter().rposition(|row| row.is_data() && row.cells.len() == usual) else {
        return body;
    };
    let blank = (last + 1..body.len()).find(|&at| body[at].line > body[at - 1].line + 1);
    &body[..blank.unwrap_or(body.len())]
}

/// Whether all cells, read line by line, are pairs of one rising run.
fn in_one_run(body: &[Row<'_>]) -> bool {
    let x: Vec<f64> = body
        .iter()
        .flat_map(|r| r.cells.iter().step_by(2))
        .filter_map(|c| number::read_up_to(c, LARGEST).ok())
        .map(|n| n.value)
        .collect();
    x.windows(2).all(|p| p[1] > p[0])
}

fn pairs_in_a_run(body: &[Row<'_>], draft: &mut Draft, findings: &mut Findings) {
    for row in body.iter().filter(|r| !r.comment) {
        for k in (0..row.cells.len()).step_by(2) {
            let read = |k: usize| {
                let cell = row.cells.get(k).copied().unwrap_or("");
                number::read_up_to(cell, LARGEST).map_err(|e| (k, cell, e))
            };
            match (read(k), read(k + 1)) {
                (Ok(x), Ok(y)) => draft.points.push(Point {
                    line: row.line,
                    column: row.column(k),
                    x: x.value,
                    value: vec![Some(y.value)],
                }),
                (Err((k, cell, error)), _) | (_, Err((k, cell, error))) => {
                    draft.whole = false;
                    findings.push(
                        Finding::error("spd-number", error.to_string())
                            .at(row.line, row.column(k))
                            .raw(cell),
                    );
                }
            }
        }
    }
}

/// Nothing reads as data: say why, at the likeliest line.
fn describe_failure(rows: &[Row<'_>], text: &Text<'_>, draft: &mut Draft, findings: &mut Findings) {
    draft.whole = false;
    let suspect = rows.iter().find(|row| row.nearly_data());
    let (line, raw) = suspect.map_or((1, text.line(0)), |row| (row.line, row.text));
    findings.push(
        Finding::error("csv-no-data", "no line holds a wavelength and a value")
            .at(line, 1)
            .raw(raw)
            .fix("write one line a wavelength: wavelength in nm, value"),
    );
}
