//! LM-63-2002 and LM-63-2019 to the byte.

use isolux_photometry::IntensityDistribution;

use super::edition::{Edition, GENERATION_TYPES};
use super::facts::Facts;
use super::grid::Grid;
use super::photometry::Photometry;
use super::shape;
use crate::distribution::Distribution;
use crate::finding::{Finding, Findings};
use crate::lost::with_losses;
use crate::number;
use crate::options::WriteOptions;
use crate::parsed::{Format, Written};

/// Longest line of LM-63-2002, CR LF included.
const LINE: usize = 256;

pub(crate) fn encode(distribution: &Distribution, options: &WriteOptions) -> Result<Written, Finding> {
    let edition = match options.edition.as_deref() {
        None | Some("2002") => Edition::E2002,
        Some("2019") => Edition::E2019,
        Some(other) => {
            let message = format!("LM-63 is written in editions 2002 and 2019, not {other}");
            return Err(Finding::error("convert-edition", message));
        }
    };
    let mut facts = distribution.ies_facts();
    if let Some(requested) = &options.generation {
        facts.generation = Some(generation(requested, edition)?);
    }
    let written = write_as(distribution, &facts, edition, options.photometry);
    Ok(with_losses(written, distribution, Format::IES, edition))
}

/// A file generation type of LM-63-2019, as a person asks for it.
fn generation(requested: &str, edition: Edition) -> Result<String, Finding> {
    if edition < Edition::E2019 {
        let message = "file generation types belong to LM-63-2019";
        return Err(Finding::error("convert-generation", message).fix("add --edition 2019"));
    }
    let known = GENERATION_TYPES.iter().find(|(code, _)| *code == requested);
    known.map(|&(code, _)| code.to_owned()).ok_or_else(|| {
        let all: Vec<String> = GENERATION_TYPES
            .iter()
            .map(|(code, meaning)| format!("{code} ({meaning})"))
            .collect();
        Finding::error("convert-generation", format!("{requested} is no file generation type"))
            .fix(format!("one of {}", all.join(", ")))
    })
}

/// Writes a distribution in candela as type C, multiplier and factors 1. The symmetry that the intensities really have
/// is kept where LM-63 has a class for it.
pub fn write(intensity: &IntensityDistribution, facts: &Facts, edition: Edition) -> Written {
    let mut findings = Findings::new();
    let grid = Grid::type_c(intensity, &mut findings);
    lay_out(&grid, facts, edition, findings)
}

/// Writes what was read in the coordinates that are asked for, or in its own: a table of type A or B stays what it is,
/// to the digit; anything else is turned.
pub fn write_as(
    distribution: &Distribution,
    facts: &Facts,
    edition: Edition,
    photometry: Option<Photometry>,
) -> Written {
    let mut findings = Findings::new();
    let own = distribution
        .native
        .as_ref()
        .and_then(|native| Some((native, Photometry::of(native.photometry_type)?)));
    let intensity = &distribution.intensity;
    let kept = own.filter(|&(_, own)| photometry.is_none_or(|requested| requested == own));
    let grid = match (photometry, kept) {
        (_, Some((native, own))) => {
            let message = format!("type {} is written as it was read, not resampled", own.letter());
            findings.push(Finding::note("ies-type", message));
            Grid::native(native, own)
        }
        (None | Some(Photometry::C), _) => Grid::type_c(intensity, &mut findings),
        (Some(requested), _) => Grid::turned(intensity, requested, &mut findings),
    };
    lay_out(&grid, facts, edition, findings)
}

fn lay_out(grid: &Grid<'_>, facts: &Facts, edition: Edition, mut findings: Findings) -> Written {
    let mut lines: Vec<String> = Vec::new();
    lines.push(
        if edition >= Edition::E2019 {
            "IES:LM-63-2019"
        } else {
            "IESNA:LM-63-2002"
        }
        .to_owned(),
    );
    keywords(&mut lines, facts, &mut findings);
    match &facts.tilt {
        None => lines.push("TILT=NONE".to_owned()),
        Some(tilt) => {
            lines.push("TILT=INCLUDE".to_owned());
            lines.push(number::plain(tilt.geometry));
            lines.push(tilt.angle_deg.len().to_string());
            wrap(
                &mut lines,
                tilt.angle_deg.iter().map(|&angle| number::shortest(angle, 10)),
            );
            wrap(
                &mut lines,
                tilt.factor.iter().map(|&factor| number::shortest(factor, 10)),
            );
        }
    }
    let (count, per_lamp) = match facts.lamp_flux_lm {
        Some(flux) if facts.lamp_count > 0.0 => (facts.lamp_count, flux / facts.lamp_count),
        Some(flux) => (1.0, flux),
        None => (if facts.lamp_count > 0.0 { facts.lamp_count } else { 1.0 }, -1.0),
    };
    let body = shape::body(facts.opening_m, Edition::E2002, Photometry::C);
    let [width, length, height] = shape::opening(body, grid.photometry);
    let numbers = [
        number::plain(count),
        number::shortest(per_lamp, 10),
        "1".into(),
        grid.vertical_deg.len().to_string(),
        grid.horizontal_deg.len().to_string(),
        grid.photometry.code().into(),
        "2".into(),
        number::shortest(width, 9),
        number::shortest(length, 9),
        number::shortest(height, 9),
    ];
    lines.push(numbers.join(" "));
    let third = if edition >= Edition::E2019 {
        facts.generation.clone().unwrap_or_else(|| {
            let message = "how the data came about is not known; the file generation type says so";
            findings.push(
                Finding::note("ies-generation", message)
                    .assumed("1.00001, undefined or older file")
                    .fix("state it: convert --generation 1.00000 (measured), 1.10000 (measured, accredited), 1.00010 (simulated) …"),
            );
            GENERATION_TYPES[0].0.to_owned()
        })
    } else {
        "1".into()
    };
    lines.push(format!("1 {third} {}", number::shortest(facts.watts, 9)));
    for angles in [&*grid.vertical_deg, &grid.horizontal_deg] {
        wrap(&mut lines, angles.iter().map(|&angle| number::shortest(angle, 10)));
    }
    for row in &grid.rows_cd {
        wrap(&mut lines, row.iter().map(|&candela| number::shortest(candela, 9)));
    }
    let mut bytes = Vec::new();
    for line in &lines {
        let (encoded, ..) = encoding_rs::WINDOWS_1252.encode(line);
        bytes.extend_from_slice(&encoded);
        bytes.extend_from_slice(b"\r\n");
    }
    Written {
        bytes,
        findings: findings.into_vec(),
    }
}

/// Numbers joined by blanks into lines that stay within the limit.
fn wrap(lines: &mut Vec<String>, numbers: impl Iterator<Item = String>) {
    let mut line = String::new();
    for number in numbers {
        if !line.is_empty() && line.len() + 1 + number.len() > LINE - 2 {
            lines.push(std::mem::take(&mut line));
        }
        if !line.is_empty() {
            line.push(' ');
        }
        line.push_str(&number);
    }
    lines.push(line);
}

fn keywords(lines: &mut Vec<String>, facts: &Facts, findings: &mut Findings) {
    for (name, text) in &facts.keywords {
        for (part, words) in text.split('\n').enumerate() {
            let tag = if part == 0 { name.as_str() } else { "MORE" };
            let clean: String = words.chars().map(|c| if c.is_control() { ' ' } else { c }).collect();
            let mut rest = clean.as_str();
            let mut tag = tag;
            loop {
                let room = LINE - 2 - tag.len() - 3;
                let cut = rest.char_indices().nth(room).map_or(rest.len(), |(at, _)| at);
                lines.push(format!("[{tag}] {}", &rest[..cut]).trim_end().to_owned());
                rest = &rest[cut..];
                if rest.is_empty() {
                    break;
                }
                tag = "MORE";
            }
            if encoding_rs::WINDOWS_1252.encode(words).2 {
                let message = format!("keyword [{name}] has characters that are not in CP1252");
                findings.push(
                    Finding::warning("ies-text-encoding", message)
                        .raw(words)
                        .assumed("numeric references"),
                );
            }
        }
    }
    for required in ["TEST", "TESTLAB", "ISSUEDATE", "MANUFAC"] {
        if !facts.keywords.iter().any(|(name, _)| name == required) {
            lines.push(format!("[{required}]"));
        }
    }
}
