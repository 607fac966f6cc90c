//! JCAMP-DX 4.24 and 5: spectra over wavelength or wave number are read, everything else is refused with the reason.

use serde_json::Value;

use super::axis::AxisUnit;
use super::file::SpectrumFile;
use super::point::Point;
use super::points::Draft;
use crate::file_format::FileFormat;
use crate::finding::{Finding, Findings};
use crate::number;
use crate::parsed::{Format, Kind, Parsed};
use crate::text::Text;

/// Points beyond this are no spectrum but a forged repeat count.
const MOST_POINTS: usize = 300_000;

pub(crate) const FORMAT: FileFormat = FileFormat {
    format: Format::JCAMP,
    title: "JCAMP-DX",
    extensions: &["jdx", "dx", "jcamp"],
    detect: |source| looks_like(source.text()) || source.named(&["jdx", "dx", "jcamp"]),
    read: |source| source.spectrum(read),
    write_distribution: None,
    write_spectrum: None,
};

/// Whether a labelled data record opens the file and one names JCAMP.
pub(crate) fn looks_like(text: &Text<'_>) -> bool {
    let first = text.lines().map(str::trim).find(|line| !line.is_empty()).unwrap_or("");
    first.starts_with("##")
        && first.contains('=')
        && text
            .lines()
            .take(400)
            .any(|line| label_of(line).is_some_and(|(label, _)| label.starts_with("JCAMP")))
}

/// `##X UNITS= 1/CM` as (`XUNITS`, `1/CM`); `$$` begins a comment.
fn label_of(line: &str) -> Option<(String, &str)> {
    let (label, value) = line.trim_start().strip_prefix("##")?.split_once('=')?;
    let label = label
        .chars()
        .filter(|c| !matches!(c, ' ' | '-' | '_' | '/'))
        .collect::<String>()
        .to_ascii_uppercase();
    Some((label, value.split("$$").next().unwrap_or("").trim()))
}

/// One block: its records and the lines of its table.
#[derive(Default)]
struct Block<'t> {
    records: Vec<(String, &'t str, usize)>,
    table: Vec<(usize, &'t str)>,
    form: Option<(String, usize)>,
    ended: bool,
}

impl Block<'_> {
    fn record(&self, label: &str) -> Option<(&str, usize)> {
        self.records
            .iter()
            .find(|(own, ..)| own == label)
            .map(|(_, value, line)| (*value, *line))
    }

    fn number(&self, label: &str) -> Result<Option<f64>, Finding> {
        let Some((value, line)) = self.record(label) else {
            return Ok(None);
        };
        number::read_up_to(value, number::LARGEST_SPECTRAL)
            .map(|n| Some(n.value))
            .map_err(|error| {
                Finding::error("jcamp-number", format!("{label}: {error}"))
                    .at(line, 1)
                    .raw(value)
            })
    }
}

/// Reads the file.
pub(crate) fn read(text: &Text<'_>, mut findings: Findings) -> Parsed<SpectrumFile> {
    let blocks = blocks(text);
    let spectra: Vec<&Block<'_>> = blocks.iter().filter(|block| block.form.is_some()).collect();
    let refuse = |finding: Finding, mut findings: Findings| {
        findings.push(finding.fix("export the spectrum as CSV with wavelengths in nm"));
        Parsed::refused(Some(Format::JCAMP), Some(Kind::Spectrum), findings)
    };
    let axis = spectra
        .first()
        .or(blocks.first().as_ref())
        .and_then(|b| b.record("XUNITS"));
    let (unit, line) = axis.unwrap_or((text.line(0), 1));
    let axis = match AxisUnit::of(unit) {
        Some(AxisUnit::Other(name)) => {
            let message = format!("JCAMP-DX with an abscissa in {name}: this is no spectrum over wavelength");
            return refuse(Finding::error("jcamp-refused", message).at(line, 1).raw(unit), findings);
        }
        None => {
            let message = "JCAMP-DX without a wavelength axis: this is no spectrum over wavelength";
            return refuse(Finding::error("jcamp-refused", message).at(line, 1).raw(unit), findings);
        }
        Some(axis) => axis,
    };
    let Some(block) = spectra.first() else {
        let message = "JCAMP-DX without a table of a spectrum";
        return refuse(
            Finding::error("jcamp-refused", message).at(1, 1).raw(text.line(0)),
            findings,
        );
    };
    let mut draft = Draft::new(text.encoding);
    draft.axis = Some(axis);
    for (label, value, _) in &block.records {
        draft.header.insert(label.clone(), Value::from(*value));
    }
    draft.unit = block.record("YUNITS").map(|(unit, _)| unit.to_ascii_lowercase());
    draft.quantity = draft
        .unit
        .as_deref()
        .and_then(|unit| super::quantity::quantity_of(unit).0);
    if blocks.iter().any(|block| !block.ended) {
        findings.push(
            Finding::error("jcamp-end", "##END= is missing: the file is cut")
                .at(text.len().max(1), 1)
                .fix("fetch the file again"),
        );
        draft.whole = false;
    }
    for block in &spectra {
        match points(block, &mut findings) {
            Ok(points) if draft.names.is_empty() => draft.points = points,
            Ok(points) if points.iter().map(|p| p.x).eq(draft.points.iter().map(|p| p.x)) => {
                for (all, own) in draft.points.iter_mut().zip(points) {
                    all.value.extend(own.value);
                }
            }
            Ok(_) => {
                let (title, line) = block.record("TITLE").unwrap_or(("", 1));
                findings.push(
                    Finding::error("jcamp-blocks", "this block has other abscissas than the first")
                        .at(line, 1)
                        .raw(title)
                        .fix("put each block into a file of its own"),
                );
                draft.whole = false;
            }
            Err(finding) => {
                findings.push(finding.fix("fetch the file again"));
                draft.whole = false;
            }
        }
        draft.names.push(
            block
                .record("TITLE")
                .map_or(String::new(), |(title, _)| title.to_owned()),
        );
    }
    let file = if draft.points.is_empty() {
        None
    } else {
        draft.finish(&mut findings)
    };
    Parsed::new(Format::JCAMP, Kind::Spectrum, file, findings)
}

fn blocks<'t>(text: &'t Text<'_>) -> Vec<Block<'t>> {
    let mut open = vec![Block::default()];
    let mut done = Vec::new();
    for (index, line) in text.lines().enumerate() {
        if line.trim_start().starts_with("$$") {
            continue;
        }
        let Some((label, value)) = label_of(line) else {
            if let Some(block) = open.last_mut()
                && block.form.is_some()
            {
                block.table.push((index + 1, line.split("$$").next().unwrap_or("")));
            }
            continue;
        };
        match label.as_str() {
            "TITLE" if open.last().is_some_and(|b| !b.records.is_empty()) => open.push(Block::default()),
            "END" => {
                if let Some(mut block) = open.pop() {
                    block.ended = true;
                    done.push(block);
                }
                continue;
            }
            "XYDATA" | "XYPOINTS" | "PEAKTABLE" => {
                if let Some(block) = open.last_mut() {
                    block.form = Some((value.to_ascii_uppercase().replace(' ', ""), index + 1));
                }
            }
            _ => {}
        }
        if let Some(block) = open.last_mut() {
            block.records.push((label, value, index + 1));
        }
    }
    done.extend(open.into_iter().filter(|block| !block.records.is_empty()));
    done
}

fn points(block: &Block<'_>, findings: &mut Findings) -> Result<Vec<Point>, Finding> {
    let (form, form_line) = block.form.clone().unwrap_or_default();
    let (x_factor, y_factor) = (
        block.number("XFACTOR")?.unwrap_or(1.0),
        block.number("YFACTOR")?.unwrap_or(1.0),
    );
    let stated = block.number("NPOINTS")?;
    let out = if form.starts_with("(X++(Y..Y))") {
        let ends = (block.number("FIRSTX")?, block.number("LASTX")?, stated);
        let (Some(first), Some(last), Some(count)) = ends else {
            return Err(Finding::error(
                "jcamp-abscissa",
                "FIRSTX, LASTX and NPOINTS must stand in front of the table",
            )
            .at(form_line, 1));
        };
        ordinates(block, [first, last, count], [x_factor, y_factor], findings)?
    } else if form.starts_with("(XY..XY)") {
        pairs(block, [x_factor, y_factor])?
    } else {
        return Err(Finding::error("jcamp-form", "this form of table is not known here")
            .at(form_line, 1)
            .raw(&form));
    };
    if let Some(stated) = stated
        && stated != out.len() as f64
    {
        let (raw, line) = block.record("NPOINTS").unwrap_or(("", form_line));
        findings.push(
            Finding::error(
                "jcamp-points",
                format!("NPOINTS promises {stated} points, {} follow", out.len()),
            )
            .at(line, 1)
            .raw(raw)
            .assumed("the points that stand there")
            .fix("check for a lost or doubled line"),
        );
    }
    Ok(out)
}

/// `(XY..XY)`: pairs, apart by blanks, commas or semicolons.
fn pairs(block: &Block<'_>, factor: [f64; 2]) -> Result<Vec<Point>, Finding> {
    let mut out: Vec<Point> = Vec::new();
    let mut pending: Option<f64> = None;
    for &(line, content) in &block.table {
        for token in content.split([' ', '\t', ',', ';']).filter(|token| !token.is_empty()) {
            let value = number::read_up_to(token, number::LARGEST_SPECTRAL)
                .map_err(|error| {
                    Finding::error("jcamp-number", error.to_string())
                        .at(line, crate::text::column_of(content, token))
                        .raw(token)
                })?
                .value;
            match pending.take() {
                None => pending = Some(value * factor[0]),
                Some(x) => out.push(Point {
                    line,
                    column: 1,
                    x,
                    value: vec![Some(value * factor[1])],
                }),
            }
        }
    }
    match (pending, block.table.last()) {
        (Some(_), Some(&(line, content))) => Err(Finding::error(
            "jcamp-pair",
            "an abscissa without its ordinate ends the table",
        )
        .at(line, 1)
        .raw(content)),
        _ => Ok(out),
    }
}

/// One step of the ASDF code (JCAMP-DX 4.24, 5.4–5.8).
enum Code {
    Absolute(f64),
    Difference(f64),
    Repeat(usize),
}

/// `(X++(Y..Y))`: an abscissa a line, then ordinates in AFFN, PAC, SQZ, DIF and DUP form, with both of their checks.
fn ordinates(
    block: &Block<'_>,
    [first, last, count]: [f64; 3],
    [x_factor, y_factor]: [f64; 2],
    findings: &mut Findings,
) -> Result<Vec<Point>, Finding> {
    if !(2.0..=MOST_POINTS as f64).contains(&count) {
        return Err(Finding::error("jcamp-points", "NPOINTS is no number of points").at(1, 1));
    }
    let step = (last - first) / (count - 1.0);
    let mut y: Vec<(f64, usize)> = Vec::new();
    // The last line ended on a difference: the next begins with the same ordinate again.
    let mut in_difference = false;
    for &(line, content) in &block.table {
        if content.trim().is_empty() {
            continue;
        }
        let bad = |column: usize, raw: &str| {
            Finding::error("jcamp-number", "this is no number of JCAMP-DX")
                .at(line, column + 1)
                .raw(raw)
        };
        let (x, codes) = decode(content).map_err(|(column, raw)| bad(column, &raw))?;
        let index = if in_difference {
            y.len().saturating_sub(1)
        } else {
            y.len()
        };
        let expected = first + step * index as f64;
        // Abscissas of the lines are rounded to the digits that fit.
        if (x * x_factor - expected).abs() > 0.6 * step.abs() + 1.0_f64.min(0.002 * expected.abs()) {
            findings.push(
                Finding::error(
                    "jcamp-abscissa",
                    format!(
                        "the line begins at {}, the points before it lead to {expected:.4}",
                        x * x_factor
                    ),
                )
                .at(line, 1)
                .raw(content)
                .assumed("FIRSTX, LASTX and NPOINTS")
                .fix("check for a lost, doubled or damaged line"),
            );
        }
        let mut check = in_difference;
        let (mut now, mut difference) = (y.last().map_or(0.0, |last| last.0), None);
        for code in codes {
            match code {
                Code::Absolute(value) => {
                    difference = None;
                    if check && (value - now).abs() > 1.0 {
                        findings.push(
                            Finding::error(
                                "jcamp-check",
                                format!("the line begins with {value}, the line before ends with {now}"),
                            )
                            .at(line, 1)
                            .raw(content)
                            .assumed("the differences")
                            .fix("check for a lost or damaged line"),
                        );
                    }
                    now = value;
                    if !check {
                        y.push((now, line));
                    }
                }
                Code::Difference(value) => {
                    difference = Some(value);
                    now += value;
                    y.push((now, line));
                }
                Code::Repeat(times) => {
                    if y.len() + times > MOST_POINTS {
                        return Err(bad(0, "repeat count"));
                    }
                    for _ in 1..times {
                        now += difference.unwrap_or(0.0);
                        y.push((now, line));
                    }
                }
            }
            check = false;
        }
        in_difference = difference.is_some();
    }
    Ok(y.iter()
        .enumerate()
        .map(|(i, &(value, line))| Point {
            line,
            column: 1,
            x: first + step * i as f64,
            value: vec![Some(value * y_factor)],
        })
        .collect())
}

/// The abscissa and the codes of a line; an error is the zero-based column and the text.
fn decode(line: &str) -> Result<(f64, Vec<Code>), (usize, String)> {
    let bytes = line.as_bytes();
    let mut out = Vec::new();
    let mut abscissa = None;
    let mut at = 0;
    while at < bytes.len() {
        let start = at;
        let (lead, kind) = match bytes[at] {
            b' ' | b'\t' | b',' | b';' => {
                at += 1;
                continue;
            }
            b'@' => ("0".to_owned(), 0),
            c @ b'A'..=b'I' => (format!("{}", c - b'A' + 1), 0),
            c @ b'a'..=b'i' => (format!("-{}", c - b'a' + 1), 0),
            b'%' => ("0".to_owned(), 1),
            c @ b'J'..=b'R' => (format!("{}", c - b'J' + 1), 1),
            c @ b'j'..=b'r' => (format!("-{}", c - b'j' + 1), 1),
            c @ b'S'..=b'Z' => (format!("{}", c - b'S' + 1), 2),
            b's' => ("9".to_owned(), 2),
            c @ (b'+' | b'-' | b'.' | b'0'..=b'9') => ((c as char).to_string(), 0),
            _ => return Err((at, line.get(at..).unwrap_or("").chars().take(12).collect())),
        };
        let plain = matches!(bytes[at], b'+' | b'-' | b'.' | b'0'..=b'9');
        at += 1;
        let digits = at;
        while at < bytes.len() {
            let exponent = plain
                && matches!(bytes[at], b'E' | b'e')
                && matches!(bytes.get(at + 1), Some(b'+' | b'-'))
                && bytes.get(at + 2).is_some_and(u8::is_ascii_digit);
            if exponent {
                at += 2;
            } else if !(bytes[at].is_ascii_digit() || bytes[at] == b'.') {
                break;
            }
            at += 1;
        }
        let text = format!("{lead}{}", line.get(digits..at).unwrap_or("?"));
        let value: f64 = text
            .parse()
            .ok()
            .filter(|v: &f64| v.is_finite() && v.abs() < number::LARGEST_SPECTRAL)
            .ok_or_else(|| (start, line.get(start..at).unwrap_or("").to_owned()))?;
        match (abscissa, kind) {
            (None, 0) if plain => abscissa = Some(value),
            (None, _) => return Err((start, line.get(start..at).unwrap_or("").to_owned())),
            (_, 0) => out.push(Code::Absolute(value)),
            (_, 1) => out.push(Code::Difference(value)),
            _ => out.push(Code::Repeat((value.max(0.0) as usize).min(MOST_POINTS + 1))),
        }
    }
    abscissa.map(|x| (x, out)).ok_or((0, line.to_owned()))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn values(line: &str) -> Vec<f64> {
        let mut out: Vec<f64> = Vec::new();
        let mut step = 0.0;
        for code in decode(line).unwrap().1 {
            match code {
                Code::Absolute(v) => {
                    step = 0.0;
                    out.push(v);
                }
                Code::Difference(v) => {
                    step = v;
                    out.push(out.last().unwrap() + v);
                }
                Code::Repeat(n) => (1..n).for_each(|_| out.push(out.last().unwrap() + step)),
            }
        }
        out
    }

    #[test]
    fn the_five_forms_of_the_standard_are_the_same_numbers() {
        // The example of JCAMP-DX 4.24, 5.9.
        let expected = [1.0, 2.0, 3.0, 3.0, 2.0, 1.0, 0.0, -1.0, -2.0, -3.0];
        for line in [
            "99 1 2 3 3 2 1 0 -1 -2 -3",
            "99+1+2+3+3+2+1+0-1-2-3",
            "99ABCCBA@abc",
            "99AJJ%jjjjjj",
            "99AJT%jX",
        ] {
            assert_eq!(values(line), expected, "{line}");
        }
    }
}
