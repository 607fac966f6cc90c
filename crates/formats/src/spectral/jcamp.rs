//! JCAMP-DX 4.24 and 5: spectra over wavelength or wave number are read, everything else is refused with the reason.

mod asdf;

use serde_json::Value;

use self::asdf::ordinates;
use super::axis::AxisUnit;
use super::file::SpectrumFile;
use super::point::Point;
use super::points::Draft;
use crate::file_format::FileFormat;
use crate::finding::{Finding, Findings};
use crate::number;
use crate::parsed::{Format, Kind, Parsed};
use crate::text::Text;

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
        ordinates(&block.table, [first, last, count], [x_factor, y_factor], findings)?
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
