//! Macam's `.DTA` and `.DAT`: date, time and title behind `@` and `#`, then wavelength and value on lines of their own.

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
    format: Format::MACAM,
    title: "Macam",
    extensions: &[],
    detect: |source| !source.is_xml() && looks_like(source.text()),
    read: |source| source.spectrum(read),
    write_distribution: None,
    write_spectrum: None,
};

/// Whether the text begins with lines behind `@` and goes on with one number a line.
pub(crate) fn looks_like(text: &Text<'_>) -> bool {
    let mut body = text.lines().skip_while(|line| is_heading(line)).take(2);
    text.lines().next().is_some_and(|line| line.starts_with('@'))
        && body.by_ref().all(|line| number::read(line).is_ok())
}

fn is_heading(line: &str) -> bool {
    line.starts_with(['@', '#'])
}

/// Reads wavelengths in nm and values, line after line.
pub(crate) fn read(text: &Text<'_>, mut findings: Findings) -> Parsed<SpectrumFile> {
    let mut draft = Draft::new(text.encoding);
    draft.axis = Some(AxisUnit::Nanometre);
    let heading: Vec<&str> = text.lines().take_while(|line| is_heading(line)).collect();
    for (name, line) in ["date", "time"]
        .iter()
        .zip(heading.iter().filter(|line| line.starts_with('@')))
    {
        draft.header.insert((*name).to_owned(), line[1..].trim().into());
    }
    if let Some(title) = heading.iter().find_map(|line| line.strip_prefix('#')) {
        draft.header.insert("title".to_owned(), title.trim().into());
    }
    let mut numbers: Vec<(usize, f64)> = Vec::new();
    for (index, line) in text.lines().enumerate().skip(heading.len()) {
        if line.trim().is_empty() {
            continue;
        }
        match number::read_up_to(line, number::LARGEST_SPECTRAL) {
            Ok(read) => numbers.push((index + 1, read.value)),
            Err(error) => {
                draft.whole = false;
                let finding = Finding::error("macam-number", error.to_string());
                findings.push(
                    finding
                        .at(index + 1, 1)
                        .raw(line)
                        .fix("write the number that was measured"),
                );
            }
        }
    }
    if !numbers.len().is_multiple_of(2) {
        draft.whole = false;
        let finding = Finding::error(
            "macam-pairs",
            "a wavelength stands without its value, or a line is lost",
        );
        findings.push(
            finding
                .at(text.len().max(1), 1)
                .fix("fetch the file again; it may be cut"),
        );
    }
    draft.points = numbers
        .chunks_exact(2)
        .map(|pair| Point {
            line: pair[0].0,
            column: 1,
            x: pair[0].1,
            value: vec![Some(pair[1].1)],
        })
        .collect();
    let file = draft.finish(&mut findings);
    Parsed::new(Format::MACAM, Kind::Spectrum, file, findings)
}
