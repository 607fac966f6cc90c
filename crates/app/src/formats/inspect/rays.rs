//! TM-25 ray files: what `inspect` says of them. Files of any size are read in one pass.

use std::io::{self, BufReader, Read};

use camino::Utf8Path;
use isolux_formats::tm25::{Damage, Header, Reader, Survey, Tm25Error};
use isolux_formats::{Finding, Format, Kind};

use super::inspection::{Inspection, Quantities};
use super::ray_quantities::RayQuantities;
use super::source::OpenFile;

/// Whether this is a ray file: by content, and by name where the content is damaged.
pub(super) fn are_in(path: &Utf8Path, source: &OpenFile) -> bool {
    let extension = path.extension().unwrap_or_default().to_ascii_lowercase();
    Format::of_extension(&extension) == Some(Format::TM25) || source.begins_with(b"TM25")
}

/// Looks at a ray file.
pub(super) fn inspection(path: &Utf8Path, source: OpenFile) -> Inspection {
    let mut inspection = Inspection {
        file: path.to_string(),
        format: Some(Format::TM25),
        kind: Some(Kind::Rays),
        readable: false,
        findings: Vec::new(),
        quantities: Quantities::None {},
        content: None,
    };
    if let Err(error) = look(source, &mut inspection) {
        inspection.findings.push(finding(&error));
    }
    inspection
}

/// An error of the reader as a finding, with its bytes.
pub(crate) fn finding(error: &Tm25Error) -> Finding {
    let stated = Finding::error(error.code(), error.to_string());
    let stated = match error.span() {
        Some(span) => stated.bytes(span),
        None => stated,
    };
    match error {
        Tm25Error::Length { expected, found, .. } if found < expected => {
            stated.fix("fetch the file again: it is cut off")
        }
        Tm25Error::Truncated { .. } => stated.fix("fetch the file again: it is cut off"),
        _ => stated,
    }
}

fn look(source: OpenFile, inspection: &mut Inspection) -> Result<(), Tm25Error> {
    let length = source.length();
    let mut stream = Counted {
        from: BufReader::new(source),
        bytes: 0,
    };
    let header = Header::read(&mut stream)?;
    inspection.findings.extend(
        header
            .doubts()
            .into_iter()
            .map(|doubt| Finding::warning("tm25-header", doubt.message).bytes(doubt.span)),
    );
    // What is there is looked at even where the count is wrong.
    let mut reader = Reader::over(header, &mut stream);
    let survey = Survey::of(&mut reader)?;
    let header = reader.header().clone();
    // The end of a pipe is known when it has come.
    let length = if let Some(length) = length {
        length
    } else {
        io::copy(&mut stream, &mut io::sink())?;
        stream.bytes
    };
    let expected = header.end();
    if expected != length {
        inspection.findings.push(finding(&Tm25Error::Length {
            rays: header.rays,
            columns: header.columns.count(),
            expected,
            found: length,
        }));
    }
    damage(&header, &survey, &mut inspection.findings);
    if expected == length {
        sums(&header, &survey, &mut inspection.findings);
    }
    inspection.quantities = Quantities::Rays(Box::new(RayQuantities::of(&header, &survey)));
    inspection.readable = expected == length;
    Ok(())
}

/// Counts the bytes that it hands on.
struct Counted<R> {
    from: R,
    bytes: u64,
}

impl<R: Read> Read for Counted<R> {
    fn read(&mut self, into: &mut [u8]) -> io::Result<usize> {
        let read = self.from.read(into)?;
        self.bytes += read as u64;
        Ok(read)
    }
}

/// Rays that no light can follow.
fn damage(header: &Header, survey: &Survey, findings: &mut Vec<Finding>) {
    let size = 4 * header.columns.count() as u64;
    let mut say = |damage: Damage, make: fn(&'static str, String) -> Finding, code: &'static str, what: &str| {
        if damage.rays > 0 {
            let start = header.data + damage.first * size;
            let first = damage.first + 1;
            let message = format!("{} rays {what}; the first is ray {first}", damage.rays);
            findings.push(make(code, message).bytes([start, start + size]));
        }
    };
    say(
        survey.not_finite,
        Finding::error,
        "tm25-not-finite",
        "have a place, direction or flux that is no finite number",
    );
    say(
        survey.no_direction,
        Finding::error,
        "tm25-no-direction",
        "have the direction (0, 0, 0)",
    );
    say(
        survey.negative,
        Finding::error,
        "tm25-negative-flux",
        "carry less than no flux",
    );
    say(
        survey.no_wavelength,
        Finding::error,
        "tm25-wavelength",
        "have a wavelength that is not above zero",
    );
    say(
        survey.not_unit,
        Finding::warning,
        "tm25-not-unit",
        "have a direction whose length is not 1",
    );
}

/// Header against rays; float32 sums of other programs are allowed their roundings.
fn sums(header: &Header, survey: &Survey, findings: &mut Vec<Finding>) {
    for (stated, found, span, unit) in [
        (header.luminous_flux_lm, survey.luminous_lm, [12, 16], "lm"),
        (header.radiant_flux_w, survey.radiant_w, [16, 20], "W"),
    ] {
        if let (Some(stated), Some(found)) = (stated, found)
            && (found - stated).abs() > 1e-3 * stated.abs()
        {
            findings.push(
                Finding::warning(
                    "tm25-flux",
                    format!("the header states {stated} {unit}, the rays carry {found:.6} {unit}"),
                )
                .bytes(span),
            );
        }
    }
}
