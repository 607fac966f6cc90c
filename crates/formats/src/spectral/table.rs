//! Columns of numbers in a text: CSV of any separator and decimal sign, pairs, vendors' exports.

mod bins;
mod claim;
mod columns;
mod preamble;
mod rows;
mod tall;
mod undefined;
mod values;
mod wide;

use self::preamble::preamble;
use self::rows::{Lines, Row, SEKONIC, is_begin, without_nm};
use self::tall::tall;
use self::wide::wide;
use super::file::SpectrumFile;
use super::point::Point;
use super::points::Draft;
use crate::finding::{Finding, Findings};
use crate::number;
use crate::parsed::{Format, Kind, Parsed};
use crate::text::Text;
use crate::unfinished::unfinished_line;

/// Whether an Ocean Optics or a like marker stands in the text.
pub(crate) fn looks_like_vendor_text(text: &Text<'_>) -> bool {
    text.lines().take(200).any(is_begin)
}

/// Reads a table of wavelengths and values; beside it, how many points keep one direction, which tells a spectrum even
/// where damage made it unreadable. `requested`: the columns of wavelengths and of values that a person names, counted
/// from
/// 1.
pub(crate) fn read(
    text: &Text<'_>,
    mut findings: Findings,
    format: Format,
    requested: Option<[usize; 2]>,
) -> (Parsed<SpectrumFile>, usize) {
    let mut draft = Draft::new(text.encoding);
    let lines = Lines::of(text, format);
    if let Some(separator) = lines.separator {
        draft.header.insert("separator".into(), separator.name().into());
    }
    let rows: Vec<Row<'_>> = lines.rows(text);
    // A wide table and a tall one fill the same draft, which `Draft::finish` checks.
    if requested.is_some() || !wide(&rows, &mut draft, &mut findings) {
        let block = sekonic(&rows, &mut findings);
        let body = block.unwrap_or(&rows);
        tall(body, text, (format, requested), &mut draft, &mut findings);
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
