//! Lines of a text as rows of cells, under the separator that makes the most numbers.

use std::cell::OnceCell;

use crate::number;
use crate::parsed::Format;
use crate::spectral::axis::is_wavelength_heading;
use crate::spectral::characters::Characters;
use crate::text::Text;

/// A line of at most so many bytes is counted anew for each column.
const SHORT: usize = 1024;

/// Lines that decide the separator.
const LOOKED_AT: usize = 2000;

/// Whether this is Ocean Optics' line before the data, or one like it.
pub(super) fn is_begin(line: &str) -> bool {
    line.contains(">>>>>Begin")
}

/// How a line falls into cells.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(in crate::spectral) enum Separator {
    Tab,
    Semicolon,
    Comma,
    Bar,
    Blank,
}

impl Separator {
    pub(super) fn name(self) -> &'static str {
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
pub(in crate::spectral) struct Row<'t> {
    pub line: usize,
    pub text: &'t str,
    pub cells: Vec<&'t str>,
    /// A `#`, `%`, `!`, `;` or `//` stands in front.
    pub comment: bool,
    /// Of a long line, counted when a column of it is first asked for.
    characters: OnceCell<Box<Characters<'t>>>,
    /// Whether it is a row of data, asked for many times.
    data: OnceCell<bool>,
}

impl Row<'_> {
    /// One-based column of a cell, in characters.
    pub fn column(&self, cell: usize) -> usize {
        let Some(cell) = self.cells.get(cell) else { return 1 };
        let byte = (cell.as_ptr() as usize).wrapping_sub(self.text.as_ptr() as usize);
        if self.text.len() <= SHORT || byte > self.text.len() {
            return crate::text::column_of(self.text, cell);
        }
        let characters = self.characters.get_or_init(|| Box::new(Characters::of(self.text)));
        characters.before(byte) + 1
    }

    pub fn is_number(&self, cell: usize) -> bool {
        self.cells
            .get(cell)
            .is_some_and(|c| number::read_up_to(without_nm(c), f64::MAX).is_ok())
    }

    /// A row of data: a number in front and at least one more.
    pub(super) fn is_data(&self) -> bool {
        *self.data.get_or_init(|| {
            let numbers = (1..self.cells.len()).filter(|&cell| self.is_number(cell));
            !self.comment && self.is_number(0) && numbers.take(1).count() == 1 || self.is_data_behind_a_blank()
        })
    }

    /// As [`is_data`](Self::is_data), with an index or nothing in front.
    fn is_data_behind_a_blank(&self) -> bool {
        !self.comment && self.cells.first().is_some_and(|c| c.is_empty()) && self.is_number(1) && self.is_number(2)
    }

    /// A letter in place of the first digit, `O80,0.5`, in a line that is as long as `next` and stands under a heading.
    pub(super) fn torn(&self, next: &Row<'_>, above: Option<&Row<'_>>) -> bool {
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
    pub(super) fn lost_its_wavelength(&self, width: usize) -> bool {
        let first = self.cells.first().map(|cell| number::read(cell));
        let lost = matches!(
            first,
            Some(Err(number::NotANumber::Blank | number::NotANumber::NotFinite))
        );
        !self.comment && lost && self.cells.len() == width && (1..width).all(|k| self.is_number(k))
    }

    /// A line that begins like data and is none: a damaged number or a lost cell.
    pub(super) fn nearly_data(&self) -> bool {
        let first = self.cells.first().copied().unwrap_or("");
        !self.comment && !first.is_empty() && (self.is_number(0) || begins_like_a_number(first))
    }
}

/// `380nm`, `380 [nm]` and Sekonic's `Spectral Data 380[nm]` are 380.
pub(super) fn without_nm(cell: &str) -> &str {
    let cell = cell.strip_prefix(SEKONIC).map_or(cell, str::trim_start);
    cell.strip_suffix("[nm]")
        .or_else(|| cell.strip_suffix("nm"))
        .map_or(cell, str::trim_end)
}

/// In front of every wavelength of a Sekonic file, which holds the spectrum at 5 nm and again at 1 nm.
pub(super) const SEKONIC: &str = "Spectral Data ";

fn begins_like_a_number(cell: &str) -> bool {
    cell.trim_start_matches(['-', '+', '.', ','])
        .starts_with(|c: char| c.is_ascii_digit())
}

/// A text's lines under its separator.
pub(super) struct Lines {
    pub(super) separator: Option<Separator>,
    format: Format,
}

impl Lines {
    /// The separator that makes the most lines two or more numbers, all of the same width; in a long text among lines
    /// from all over it.
    pub(super) fn of(text: &Text<'_>, format: Format) -> Self {
        let mut best: Option<(usize, Separator)> = None;
        let some = text.len() / LOOKED_AT + 1;
        for separator in [
            Separator::Tab,
            Separator::Semicolon,
            Separator::Bar,
            Separator::Blank,
            Separator::Comma,
        ] {
            let mut widths: Vec<usize> = text
                .lines()
                .step_by(some)
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

    pub(super) fn rows<'t>(&self, text: &'t Text<'_>) -> Vec<Row<'t>> {
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
                    (Format::SPD, Some(at)) if !comment => &line[..at],
                    _ => line,
                };
                let cells = separator.cells(data);
                Row {
                    line: index + 1,
                    text: line,
                    cells,
                    comment,
                    characters: OnceCell::new(),
                    data: OnceCell::new(),
                }
            })
            .collect();
        // A separator at the end of every line makes no column; a row's data are the same without it.
        let width = common_width(&rows);
        if separator == Separator::Blank {
            // Names of two words stand apart by two blanks.
            for row in rows.iter_mut().filter(|row| row.cells.len() > width && !row.is_data()) {
                let apart: Vec<&str> = row
                    .text
                    .trim()
                    .split("  ")
                    .map(str::trim)
                    .filter(|name| !name.is_empty())
                    .collect();
                if apart.len() == width && apart.first().is_some_and(|name| is_wavelength_heading(name)) {
                    row.cells = apart;
                }
            }
        }
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

pub(super) fn common_width(body: &[Row<'_>]) -> usize {
    let mut widths: Vec<usize> = body.iter().filter(|r| r.is_data()).map(|r| r.cells.len()).collect();
    widths.sort_unstable();
    widths
        .chunk_by(|a, b| a == b)
        .max_by_key(|chunk| chunk.len())
        .map_or(0, |chunk| chunk[0])
}
