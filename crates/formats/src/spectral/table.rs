//! Columns of numbers in a text: CSV of any separator and decimal sign, pairs, vendors' exports.

use serde_json::Value;

use super::SpectrumFile;
use super::axis::{AxisUnit, is_wavelength_heading};
use super::points::{Draft, Point};
use crate::finding::{Finding, Findings};
use crate::number;
use crate::read::{Format, Kind, Parsed};
use crate::text::Text;

/// Above this a value is damage, also for photons per second.
pub(super) const LARGEST: f64 = 1e30;

/// Whether an Ocean Optics or a like marker stands in the text.
pub(super) fn looks_like_vendor_text(text: &Text<'_>) -> bool {
    text.lines().take(200).any(is_begin)
}

fn is_begin(line: &str) -> bool {
    line.contains(">>>>>Begin")
}

/// Reads a table of wavelengths and values; beside it, how many points keep one direction, which tells a spectrum even
/// where damage made it unreadable.
pub(super) fn read(text: &Text<'_>, mut findings: Findings, format: Format) -> (Parsed<SpectrumFile>, usize) {
    let mut draft = Draft::new(text.encoding);
    let lines = Lines::of(text, format);
    if let Some(separator) = lines.separator {
        draft.header.insert("separator".into(), separator.name().into());
    }
    let rows: Vec<Row<'_>> = lines.rows(text);
    if let Some(wide) = super::table_wide::read(&rows, text, &mut findings) {
        draft.header.extend(wide.header);
        draft.points = wide.points;
        draft.names = wide.names;
        draft.axis = wide.axis;
        draft.whole = wide.whole;
    } else {
        let block = sekonic(&rows, &mut findings);
        let body = block.unwrap_or(&rows);
        tall(body, text, format, &mut draft, &mut findings);
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

/// The number of points if nearly all of them keep one direction inside what can be a wavelength or wave number, else 0.
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

/// A last line without its end may be cut in the middle of a number.
pub(super) fn unfinished_line(text: &Text<'_>, findings: &mut Findings) {
    if !text.ends_with_newline && text.len() > 1 {
        let last = text.line(text.len() - 1);
        if last.contains(|c: char| c.is_ascii_digit()) && !last.contains(">>>>>") {
            findings.push(
                Finding::warning(
                    "text-unfinished",
                    "the last line has no line end: its last number may be cut",
                )
                .at(text.len(), last.chars().count().max(1))
                .raw(last)
                .assumed("the number is whole")
                .fix("end the file with a line end"),
            );
        }
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
    if let (Some((line, stated)), true) = (stated, draft.whole)
        && stated != draft.points.len() as f64
    {
        findings.push(
            Finding::error(
                "csv-pixels",
                format!(
                    "the header promises {stated} pixels, {} lines of data follow",
                    draft.points.len()
                ),
            )
            .at(line, 1)
            .assumed("the lines that stand there")
            .fix("check for a lost or doubled line"),
        );
    }
}

/// How a line falls into cells.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Separator {
    Tab,
    Semicolon,
    Comma,
    Bar,
    Blank,
}

impl Separator {
    fn name(self) -> &'static str {
        match self {
            Self::Tab => "tab",
            Self::Semicolon => ";",
            Self::Comma => ",",
            Self::Bar => "|",
            Self::Blank => "blank",
        }
    }

    fn cells(self, line: &str) -> Vec<&str> {
        match self {
            Self::Tab => quoted(line, '\t'),
            Self::Semicolon => quoted(line, ';'),
            Self::Comma => quoted(line, ','),
            Self::Bar => quoted(line, '|'),
            Self::Blank => line.split_whitespace().collect(),
        }
    }
}

/// Cells of a line, where a separator inside quotes does not count; quotes are taken off.
fn quoted(line: &str, separator: char) -> Vec<&str> {
    let mut out = Vec::new();
    let (mut start, mut inside) = (0, false);
    for (at, c) in line.char_indices() {
        if c == '"' {
            inside = !inside;
        } else if c == separator && !inside {
            out.push(unquoted(&line[start..at]));
            start = at + c.len_utf8();
        }
    }
    out.push(unquoted(&line[start..]));
    out
}

fn unquoted(cell: &str) -> &str {
    let cell = cell.trim();
    cell.strip_prefix('"')
        .and_then(|rest| rest.strip_suffix('"'))
        .map_or(cell, str::trim)
}

/// One line with its cells.
#[derive(Debug)]
pub(super) struct Row<'t> {
    pub line: usize,
    pub text: &'t str,
    pub cells: Vec<&'t str>,
    /// A `#`, `%`, `!`, `;` or `//` stands in front.
    pub comment: bool,
}

impl Row<'_> {
    pub fn column(&self, cell: usize) -> usize {
        self.cells
            .get(cell)
            .map_or(1, |cell| super::speos::column_of(self.text, cell))
    }

    pub fn is_number(&self, cell: usize) -> bool {
        self.cells
            .get(cell)
            .is_some_and(|c| number::read_up_to(without_nm(c), f64::MAX).is_ok())
    }

    /// A row of data: a number in front and at least one more.
    fn is_data(&self) -> bool {
        !self.comment && self.is_number(0) && (0..self.cells.len()).filter(|&k| self.is_number(k)).count() >= 2
            || self.is_data_behind_a_blank()
    }

    /// As [`is_data`](Self::is_data), with an index or nothing in front.
    fn is_data_behind_a_blank(&self) -> bool {
        !self.comment && self.cells.first().is_some_and(|c| c.is_empty()) && self.is_number(1) && self.is_number(2)
    }

    /// A letter in place of the first digit, `O80,0.5`, in a line that is as long as `next` and stands under a heading.
    fn torn(&self, next: &Row<'_>, above: Option<&Row<'_>>) -> bool {
        let (first, like) = (self.cells.first(), next.cells.first());
        let digits = |cell: &str| cell.chars().filter(char::is_ascii_digit).count();
        let alike = first
            .zip(like)
            .is_some_and(|(a, b)| digits(a) >= 2 && a.chars().count() == b.chars().count());
        !self.comment
            && alike
            && self.cells.len() == next.cells.len()
            && (1..self.cells.len()).all(|k| self.is_number(k))
            && above.is_none_or(|row| row.comment || (0..row.cells.len()).all(|k| !row.is_number(k)))
    }

    /// A line of data whose wavelength is blank or not finite.
    fn lost_its_wavelength(&self, width: usize) -> bool {
        let first = self.cells.first().map(|cell| number::read(cell));
        let lost = matches!(
            first,
            Some(Err(number::NotANumber::Blank | number::NotANumber::NotFinite))
        );
        !self.comment && lost && self.cells.len() == width && (1..width).all(|k| self.is_number(k))
    }

    /// A line that begins like data and is none: a damaged number or a lost cell.
    fn nearly_data(&self) -> bool {
        let first = self.cells.first().copied().unwrap_or("");
        !self.comment && !first.is_empty() && (self.is_number(0) || begins_like_a_number(first))
    }
}

/// `380nm`, `380 [nm]` and Sekonic's `Spectral Data 380[nm]` are 380.
fn without_nm(cell: &str) -> &str {
    let cell = cell.strip_prefix(SEKONIC).map_or(cell, str::trim_start);
    cell.strip_suffix("[nm]")
        .or_else(|| cell.strip_suffix("nm"))
        .map_or(cell, str::trim_end)
}

/// In front of every wavelength of a Sekonic file, which holds the spectrum at 5 nm and again at 1 nm.
const SEKONIC: &str = "Spectral Data ";

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

fn begins_like_a_number(cell: &str) -> bool {
    cell.trim_start_matches(['-', '+', '.', ','])
        .starts_with(|c: char| c.is_ascii_digit())
}

struct Lines {
    separator: Option<Separator>,
    format: Format,
}

impl Lines {
    /// The separator that makes the most lines two or more numbers, all of the same width.
    fn of(text: &Text<'_>, format: Format) -> Self {
        let mut best: Option<(usize, Separator)> = None;
        for separator in [
            Separator::Tab,
            Separator::Semicolon,
            Separator::Bar,
            Separator::Blank,
            Separator::Comma,
        ] {
            let mut widths: Vec<usize> = text
                .lines()
                .filter(|line| !line.trim().is_empty())
                .map(|line| separator.cells(line))
                .filter(|cells| {
                    cells.len() >= 2
                        && cells
                            .iter()
                            .all(|c| c.is_empty() || number::read_up_to(without_nm(c), f64::MAX).is_ok())
                        && cells.iter().filter(|c| !c.is_empty()).count() >= 2
                })
                .map(|cells| cells.len())
                .collect();
            widths.sort_unstable();
            let common = widths.chunk_by(|a, b| a == b).map(<[usize]>::len).max().unwrap_or(0);
            if common > best.map_or(0, |b| b.0) {
                best = Some((common, separator));
            }
        }
        Self {
            separator: best.map(|b| b.1),
            format,
        }
    }

    fn rows<'t>(&self, text: &'t Text<'_>) -> Vec<Row<'t>> {
        let separator = self.separator.unwrap_or(Separator::Comma);
        let mut rows: Vec<Row<'t>> = text
            .lines()
            .enumerate()
            .filter(|(_, line)| !line.trim().is_empty())
            .map(|(index, line)| {
                let trimmed = line.trim_start();
                let comment = ["#", "%", "!", "//", "*"].iter().any(|mark| trimmed.starts_with(mark));
                // pbrt and Mitsuba allow a comment behind the pair.
                let data = match (self.format, line.find('#')) {
                    (Format::Spd, Some(at)) if !comment => &line[..at],
                    _ => line,
                };
                let cells = separator.cells(data);
                Row {
                    line: index + 1,
                    text: line,
                    cells,
                    comment,
                }
            })
            .collect();
        // A separator at the end of every line makes no column.
        let width = common_width(&rows);
        let filled = rows
            .iter()
            .filter(|row| row.cells.len() == width && row.is_data())
            .filter_map(|row| row.cells.iter().rposition(|cell| !cell.is_empty()))
            .max()
            .map_or(width, |last| last + 1);
        for row in &mut rows {
            while row.cells.len() > filled.max(1) && row.cells.last().is_some_and(|cell| cell.is_empty()) {
                row.cells.pop();
            }
        }
        rows
    }
}

/// One wavelength a row.
fn tall(rows: &[Row<'_>], text: &Text<'_>, format: Format, draft: &mut Draft, findings: &mut Findings) {
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
    let last = body
        .iter()
        .rposition(|row| row.is_data() || row.nearly_data() || row.lost_its_wavelength(usual))
        .unwrap_or(0);
    let after = &body[last + 1..];
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
    if format == Format::Spd && names.is_empty() && width > 2 && width.is_multiple_of(2) && in_one_run(body) {
        pairs_in_a_run(body, draft, findings);
        return;
    }
    let names = if names.len() == width { names } else { Vec::new() };
    let columns = Columns::of(&names, body, width, findings);
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
        .or((format != Format::Csv && !small(body, columns.wavelength)).then_some(AxisUnit::Nanometre));
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
    for row in body {
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
                // NaN and infinity are how programs write what they could not compute; a spectrum's own values must be there.
                Err(number::NotANumber::NotFinite) if k != columns.wavelength && columns.values.first() != Some(&k) => {
                    findings.push(
                        Finding::warning("csv-nan", "no number stands here")
                            .at(row.line, row.column(k))
                            .raw(cell)
                            .assumed("missing: null in this series")
                            .fix("write the number that was measured, or leave the cell empty"),
                    );
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
        if quiet >= 3
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

/// The heading: the last line before the data that has a cell for every column, or a comment that has.
fn heading<'r, 't>(before: &'r [Row<'t>], body: &[Row<'t>]) -> Option<&'r Row<'t>> {
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
fn bare(cell: &str) -> &str {
    cell.trim_start_matches(['#', '%', '!']).trim()
}

fn common_width(body: &[Row<'_>]) -> usize {
    let mut widths: Vec<usize> = body.iter().filter(|r| r.is_data()).map(|r| r.cells.len()).collect();
    widths.sort_unstable();
    widths
        .chunk_by(|a, b| a == b)
        .max_by_key(|chunk| chunk.len())
        .map_or(0, |chunk| chunk[0])
}

/// `Key: value`, `Key,value` and comment lines in front of the data.
fn preamble(before: &[Row<'_>], heading: Option<&Row<'_>>, draft: &mut Draft) {
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
fn believable_unit(
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
        .fix("mend the comment, or write the unit into the heading"),
    );
    Some(AxisUnit::Nanometre)
}

/// Which columns are what.
struct Columns {
    wavelength: usize,
    values: Vec<usize>,
}

impl Columns {
    fn of(names: &[&str], body: &[Row<'_>], width: usize, findings: &mut Findings) -> Self {
        let numbers = |k: usize| {
            let good = body.iter().filter(|r| r.cells.len() == width && r.is_number(k)).count();
            2 * good > body.len()
        };
        let named = names.iter().position(|n| is_wavelength_heading(n)).or_else(|| {
            names
                .iter()
                .position(|n| AxisUnit::of(n).is_some() && !is_quantity(n) && !per_something(n))
        });
        // Without a heading: the first column that keeps one direction and never is 0 (0, 1, 2 … counts lines).
        let ordered = |k: usize| {
            let x: Vec<f64> = body
                .iter()
                .filter(|r| r.cells.len() == width)
                .filter_map(|r| number::read_up_to(without_nm(r.cells[k]), LARGEST).ok())
                .map(|n| n.value)
                .collect();
            let rising = x.windows(2).filter(|p| p[1] > p[0]).count();
            let falling = x.windows(2).filter(|p| p[1] < p[0]).count();
            let counts = x.len() > 2 && (x[0] == 0.0 || x[0] == 1.0) && x.windows(2).all(|p| p[1] - p[0] == 1.0);
            !counts
                && x.first().is_some_and(|x| *x > 0.0)
                && rising.max(falling) * 20 >= 19 * x.len().saturating_sub(1).max(1)
        };
        let wavelength = named
            .or_else(|| (0..width).find(|&k| numbers(k) && ordered(k)))
            .unwrap_or(0);
        if names.is_empty() && width > 2 {
            findings.push(
                Finding::warning(
                    "csv-no-heading",
                    format!("{width} columns stand here without a heading"),
                )
                .at(body[0].line, 1)
                .raw(body[0].text)
                .assumed(format!(
                    "column {} holds the wavelengths, the others are series",
                    wavelength + 1
                ))
                .fix("write a heading that names the columns"),
            );
        }
        let mut values = Vec::new();
        for k in (0..width).filter(|&k| k != wavelength) {
            let name = names.get(k).copied().unwrap_or("");
            let counter = k < wavelength
                && (name.is_empty()
                    || ["index", "pixel", "no", "nr", "#", "id"].contains(&name.to_lowercase().as_str()));
            if counter && wavelength > 0 {
                continue;
            }
            if numbers(k) || (width == 2) {
                values.push(k);
            } else {
                findings.push(
                    Finding::note(
                        "csv-column-text",
                        format!("column {} holds no numbers and is not read", k + 1),
                    )
                    .at(body[0].line, body[0].column(k))
                    .raw(name),
                );
            }
        }
        Self { wavelength, values }
    }
}

/// Whether all wavelengths are too small for nm.
fn small(body: &[Row<'_>], wavelength: usize) -> bool {
    body.iter()
        .filter_map(|row| number::read(without_nm(row.cells.get(wavelength)?)).ok())
        .all(|n| n.value < 30.0)
}

/// What a heading says of the values: quantity and unit.
pub(super) fn quantity_of(name: &str) -> (Option<String>, Option<String>) {
    let unit = name
        .split_once(['(', '['])
        .and_then(|(_, rest)| rest.rsplit_once([')', ']']))
        .map(|(unit, _)| unit.trim())
        .filter(|unit| !unit.is_empty())
        .map(str::to_owned);
    let lower = name.to_lowercase();
    let quantity = [
        ("irradiance", "irradiance"),
        ("radiance", "radiance"),
        ("radiant flux", "flux"),
        ("flux", "flux"),
        ("relative", "relative"),
        ("normali", "relative"),
        ("intensity", "intensity"),
        ("reflect", "reflectance"),
        ("transmi", "transmittance"),
        ("absor", "absorbance"),
        ("respons", "responsivity"),
        ("counts", "counts"),
        ("power", "power"),
        ("qe", "quantum efficiency"),
        ("quantum eff", "quantum efficiency"),
    ]
    .iter()
    .find(|(word, _)| lower.contains(word))
    .map(|(_, quantity)| (*quantity).to_owned());
    (quantity, unit)
}

/// `W/(m²·nm)` is no wavelength; `1/cm` and `m/z` stand on the abscissa.
fn per_something(name: &str) -> bool {
    name.contains('/') && !name.contains("1/cm") && !name.contains("m/z")
}

fn is_quantity(name: &str) -> bool {
    quantity_of(name).0.is_some()
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
