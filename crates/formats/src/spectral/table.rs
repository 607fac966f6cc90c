//! Columns of numbers in a text: CSV of any separator and decimal sign, pairs, vendors' exports.

mod bins;
mod claim;
mod columns;
mod preamble;
pub(super) mod rows;
mod undefined;

use serde_json::Value;

use self::columns::{Columns, small};
use self::preamble::{bare, believable_unit, heading, preamble};
use self::rows::{Lines, Row, SEKONIC, common_width, without_nm};
use self::undefined::Extent;
use super::axis::{AxisUnit, is_wavelength_heading};
use super::file::SpectrumFile;
use super::point::Point;
use super::points::Draft;
use super::quantity::quantity_of;
use crate::finding::{Finding, Findings};
use crate::number::{self, LARGEST_SPECTRAL as LARGEST};
use crate::parsed::{Format, Kind, Parsed};
use crate::text::Text;
use crate::unfinished::unfinished_line;

/// Whether an Ocean Optics or a like marker stands in the text.
pub(crate) fn looks_like_vendor_text(text: &Text<'_>) -> bool {
    text.lines().take(200).any(is_begin)
}

fn is_begin(line: &str) -> bool {
    line.contains(">>>>>Begin")
}

/// Reads a table of wavelengths and values; beside it, how many points keep one direction, which tells a spectrum even
/// where damage made it unreadable. `asked`: the columns of wavelengths and of values that a person names, counted from
/// 1.
pub(crate) fn read(
    text: &Text<'_>,
    mut findings: Findings,
    format: Format,
    asked: Option<[usize; 2]>,
) -> (Parsed<SpectrumFile>, usize) {
    let mut draft = Draft::new(text.encoding);
    let lines = Lines::of(text, format);
    if let Some(separator) = lines.separator {
        draft.header.insert("separator".into(), separator.name().into());
    }
    let rows: Vec<Row<'_>> = lines.rows(text);
    let wide = asked
        .is_none()
        .then(|| super::table_wide::read(&rows, text, &mut findings))
        .flatten();
    if let Some(wide) = wide {
        draft.header.extend(wide.header);
        draft.points = wide.points;
        draft.names = wide.names;
        draft.axis = wide.axis;
        draft.whole = wide.whole;
    } else {
        let block = sekonic(&rows, &mut findings);
        let body = block.unwrap_or(&rows);
        tall(body, text, (format, asked), &mut draft, &mut findings);
        if block.is_some() {
            let first = draft.points.first().map_or(0, |point| point.line);
            let before = rows.iter().position(|row| row.line == first).unwrap_or(0);
            preamble(&rows[..before], None, &mut draft);
        }
    }
    pixels(&draft, &rows, &mut findings);
    unfinished_line(text, &mut findings);
    let rising = one_way(&draft.points);
    let file = draft.finish(&mut findings);
    (Parsed::new(format, Kind::Spectrum, file, findings), rising)
}

/// The number of points if nearly all of them keep one direction inside what can be a wavelength or wave number, else
/// 0.
fn one_way(points: &[Point]) -> usize {
    let steps = points.windows(2).map(|p| p[1].x - p[0].x);
    let (rising, falling) = steps.fold((0usize, 0usize), |(r, f), s| {
        (r + usize::from(s > 0.0), f + usize::from(s < 0.0))
    });
    let positive = points.iter().filter(|p| p.x > 0.0).count();
    let keeps = rising.max(falling) * 10 >= 9 * points.len().saturating_sub(1);
    if positive * 10 >= 9 * points.len() && keeps {
        points.len()
    } else {
        0
    }
}

/// Ocean Optics states the number of pixels.
fn pixels(draft: &Draft, rows: &[Row<'_>], findings: &mut Findings) {
    let stated = rows.iter().find_map(|row| {
        let (key, value) = row.text.split_once(':')?;
        let key = key.trim();
        (key.starts_with("Number of Pixels") || key.starts_with("Pixels in")).then_some(())?;
        number::read(value).ok().map(|n| (row.line, n.value))
    });
    let lines = draft.points.len() + draft.left_out.len();
    if let (Some((line, stated)), true) = (stated, draft.whole)
        && stated != lines as f64
    {
        let message = format!("the header promises {stated} pixels, {lines} lines of data follow");
        let fewer = (lines as f64) < stated;
        findings.push(
            if fewer {
                Finding::error("csv-pixels", message)
            } else {
                Finding::warning("csv-pixels", message)
            }
            .at(line, 1)
            .assumed("the lines that stand there")
            .fix("check for a lost or doubled line"),
        );
    }
}

/// The longest of a Sekonic file's blocks.
fn sekonic<'r, 't>(rows: &'r [Row<'t>], findings: &mut Findings) -> Option<&'r [Row<'t>]> {
    let x = |row: &Row<'_>| {
        let cell = row.cells.first().filter(|c| c.starts_with(SEKONIC))?;
        number::read(without_nm(cell)).ok().map(|n| n.value)
    };
    let blocks: Vec<&[Row<'_>]> = rows
        .chunk_by(|a, b| match (x(a), x(b)) {
            (Some(a), Some(b)) => b > a || a - b < 100.0,
            (None, None) => true,
            _ => false,
        })
        .filter(|block| block.first().is_some_and(|row| x(row).is_some()))
        .collect();
    let longest = blocks.iter().copied().max_by_key(|block| block.len())?;
    if blocks.len() > 1 {
        findings.push(
            Finding::note(
                "csv-blocks",
                format!("the file holds {} spectra of one light", blocks.len()),
            )
            .at(longest[0].line, 1)
            .assumed("the finest"),
        );
    }
    Some(longest)
}

/// One wavelength a row.
fn tall(
    rows: &[Row<'_>],
    text: &Text<'_>,
    (format, asked): (Format, Option<[usize; 2]>),
    draft: &mut Draft,
    findings: &mut Findings,
) {
    let begin = rows.iter().position(|row| is_begin(row.text));
    let first = (begin.map_or(0, |b| b + 1)..rows.len()).find(|&i| rows[i].is_data());
    let Some(first) = first else {
        describe_failure(rows, text, draft, findings);
        return;
    };
    // Damage in the very first line of data must not turn it into a heading.
    let first = (begin.map_or(0, |b| b + 1)..first)
        .rev()
        .take_while(|&i| rows[i].nearly_data())
        .last()
        .unwrap_or(first);
    let above = |i: usize| i.checked_sub(1).map(|k| &rows[k]);
    let first = match first.checked_sub(1) {
        Some(i) if i >= begin.map_or(0, |b| b + 1) && rows[i].torn(&rows[first], above(i)) => i,
        _ => first,
    };
    let end = (first..rows.len())
        .find(|&i| rows[i].text.contains(">>>>>"))
        .unwrap_or(rows.len());
    if begin.is_some() && end == rows.len() {
        findings.push(Finding::note("csv-no-end", "no >>>>>End<<<<< line closes the data").at(text.len(), 1));
    }
    let body = &rows[first..end];
    let usual = common_width(body);
    let body = without_footer(body, usual);
    let last = body
        .iter()
        .rposition(|row| row.is_data() || row.nearly_data() || row.lost_its_wavelength(usual))
        .unwrap_or(0);
    let after = &rows[first + last + 1..end];
    if let Some(row) = after.iter().find(|row| !row.comment) {
        findings.push(
            Finding::note(
                "csv-after-data",
                format!(
                    "{} lines stand after the data",
                    after.iter().filter(|row| !row.comment).count()
                ),
            )
            .at(row.line, 1)
            .raw(row.text)
            .assumed("a description: kept in the header"),
        );
    }
    preamble(after, None, draft);
    let body = first_table(&body[..=last], findings);
    let heading = heading(&rows[..first], body);
    preamble(&rows[..first], heading, draft);

    let width = common_width(body);
    let names: Vec<&str> = heading.map_or(Vec::new(), |row| row.cells.clone());
    let names: Vec<&str> = names.iter().map(|n| bare(n)).collect();
    if asked.is_none()
        && format == Format::SPD
        && names.is_empty()
        && width > 2
        && width.is_multiple_of(2)
        && in_one_run(body)
    {
        pairs_in_a_run(body, draft, findings);
        return;
    }
    let names = if names.len() == width { names } else { Vec::new() };
    let mut columns = match asked {
        Some(asked) => match Columns::asked(asked, width) {
            Ok(columns) => columns,
            Err(finding) => {
                draft.whole = false;
                findings.push(finding.at(body[0].line, 1).raw(body[0].text));
                return;
            }
        },
        None => Columns::of(&names, body, width, findings),
    };
    draft.axis = names
        .get(columns.wavelength)
        .and_then(|name| AxisUnit::of(name))
        .or_else(|| believable_unit(&rows[..first], names.is_empty(), body, columns.wavelength, findings))
        .or_else(|| {
            let cell = body.iter().find_map(|row| row.cells.get(columns.wavelength));
            cell.filter(|cell| without_nm(cell) != **cell)
                .map(|_| AxisUnit::Nanometre)
        })
        // Pairs of pbrt and Mitsuba are in nm by definition.
        .or((format != Format::CSV && !small(body, columns.wavelength)).then_some(AxisUnit::Nanometre));
    let claimed = asked.is_some()
        || format != Format::CSV
        || begin.is_some()
        || draft.axis.is_some()
        || names
            .get(columns.wavelength)
            .is_some_and(|name| is_wavelength_heading(name));
    // What stands further up is a description, not a heading.
    let above = rows[..first].last();
    let named: &[&str] = match (heading, above) {
        (Some(heading), Some(above)) if heading.line == above.line => &names,
        _ => &[],
    };
    if !claimed && let Some(finding) = claim::refusal(&columns, named, above, body) {
        draft.whole = false;
        findings.push(finding);
        return;
    }
    if asked.is_none() {
        bins::take_upper_edges(&mut columns, body, findings);
    }
    undefined::whole_first(&mut columns, &names, body, findings);
    draft.names = columns
        .values
        .iter()
        .map(|&k| names.get(k).map_or(String::new(), |n| (*n).to_owned()))
        .collect();
    if let Some(name) = columns.values.first().and_then(|&k| names.get(k)) {
        let (quantity, unit) = quantity_of(name);
        draft.quantity = quantity;
        draft.unit = unit;
        draft
            .header
            .insert("columns".into(), names.iter().map(|n| Value::from(*n)).collect());
    }
    let mut comma = None;
    let extents: Vec<(usize, Extent)> = columns.values.iter().map(|&k| (k, Extent::of(body, k))).collect();
    let (left_out, kept) = undefined::split(body, &columns, findings);
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
                .fix("mend the line"),
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
    // What the writer put into comments.
    for (field, key) in [(&mut draft.quantity, "quantity"), (&mut draft.unit, "unit")] {
        if field.is_none()
            && let Some(text) = draft.header.remove(key)
        {
            *field = text.as_str().map(str::to_owned);
        }
    }
    if let Some(line) = comma {
        findings.push(Finding::note("csv-decimal-comma", "numbers are written with a decimal comma").at(line, 1));
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
