//! Ansys Speos `.spectrum`: a mark, a description, a count, pairs.

use super::file::SpectrumFile;
use super::point::Point;
use super::points::Draft;
use crate::file_format::FileFormat;
use crate::finding::{Finding, Findings};
use crate::number;
use crate::parsed::{Format, Kind, Parsed};
use crate::text::{Text, column_of};

/// Real files also write "fie"; the version is `v1` or `v1.0`.
const MARK: &str = "OPTIS - Spectrum";

pub(crate) const FORMAT: FileFormat = FileFormat {
    format: Format::SPECTRUM,
    title: "Speos",
    extensions: &["spectrum"],
    detect: |source| !source.is_xml() && (looks_like(source.text()) || source.extension == "spectrum"),
    read: |source| source.spectrum(read),
    write_distribution: None,
    write_spectrum: Some(super::write::spectrum),
};

/// Whether the mark opens the file.
pub(crate) fn looks_like(text: &Text<'_>) -> bool {
    text.line(0).trim_start().starts_with(MARK)
}

/// Reads the file.
pub(crate) fn read(text: &Text<'_>, mut findings: Findings) -> Parsed<SpectrumFile> {
    let mut draft = Draft::new(text.encoding);
    if !looks_like(text) {
        findings.push(
            Finding::error("speos-mark", format!("the first line does not begin with “{MARK}”"))
                .at(1, 1)
                .raw(text.line(0))
                .fix(format!("begin the file with “{MARK} file v1.0”")),
        );
        draft.whole = false;
    } else if !text.line(0).contains("Spectrum file v1") {
        findings.push(
            Finding::note(
                "speos-mark",
                "the first line is not exactly “OPTIS - Spectrum file v1.0”",
            )
            .at(1, 1)
            .raw(text.line(0)),
        );
    }
    draft.header.insert("version".into(), text.line(0).trim().into());
    draft.header.insert("description".into(), text.line(1).trim().into());
    let stated = match number::read(text.line(2)) {
        Ok(n) if n.value >= 0.0 && n.value.fract() == 0.0 => Some(n.value as usize),
        _ => {
            draft.whole = false;
            findings.push(
                Finding::error("speos-count", "the third line must be the number of pairs")
                    .at(3, 1)
                    .raw(text.line(2))
                    .fix("write the number of lines that follow"),
            );
            None
        }
    };
    let mut last_line = 3;
    for (index, line) in text.lines().enumerate().skip(3) {
        if line.trim().is_empty() {
            continue;
        }
        last_line = index + 1;
        match pair(line) {
            Ok((x, value, column)) => draft.points.push(Point {
                line: index + 1,
                column,
                x,
                value: vec![Some(value)],
            }),
            Err(finding) => {
                draft.whole = false;
                let column = finding.column.map_or(1, std::num::NonZeroU32::get);
                findings.push(finding.at(index + 1, column as usize));
            }
        }
    }
    if let Some(stated) = stated {
        let found = draft.points.len();
        if draft.whole && found != stated {
            findings.push(
                Finding::error(
                    "speos-count",
                    format!("the third line promises {stated} pairs, {found} follow"),
                )
                .at(if found < stated { last_line } else { 3 }, 1)
                .raw(text.line(2))
                .assumed("all pairs that stand there")
                .fix("check for a lost line, or correct the number"),
            );
        }
    }
    crate::unfinished::unfinished_line(text, &mut findings);
    draft.axis = Some(super::axis::AxisUnit::Nanometre);
    let file = draft.finish(&mut findings);
    Parsed::new(Format::SPECTRUM, Kind::Spectrum, file, findings)
}

fn pair(line: &str) -> Result<(f64, f64, usize), Finding> {
    let tokens: Vec<&str> = line.split_whitespace().collect();
    if tokens.len() != 2 {
        return Err(Finding::error(
            "speos-pair",
            format!("{} words stand where a wavelength and a value are needed", tokens.len()),
        )
        .at(1, 1)
        .raw(line));
    }
    let mut read = [0.0; 2];
    for (token, out) in tokens.iter().zip(&mut read) {
        let column = column_of(line, token);
        *out = number::read_up_to(token, number::LARGEST_SPECTRAL)
            .map_err(|error| {
                Finding::error("speos-number", error.to_string())
                    .at(1, column)
                    .raw(token)
            })?
            .value;
    }
    Ok((read[0], read[1], column_of(line, tokens[0])))
}
