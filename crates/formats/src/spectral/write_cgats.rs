//! CGATS `.sp` to the byte.

use std::fmt::Write as _;

use super::file::SpectrumFile;
use super::write::{lost_unit, number, one_line, text_of, written};
use crate::finding::Finding;
use crate::parsed::Written;

/// Writes a spectrum.
pub(super) fn cgats(file: &SpectrumFile) -> Written {
    written(|findings| sp(file, findings))
}

/// CGATS as ArgyllCMS writes it; all series as sets.
fn sp(file: &SpectrumFile, findings: &mut Vec<Finding>) -> String {
    let nm = &file.wavelength_nm;
    let even = evenly_spaced(nm);
    if !even {
        findings.push(
            Finding::warning(
                "write-uneven",
                "the wavelengths are not evenly spaced; ArgyllCMS reads even spacing alone",
            )
            .assumed("the exact wavelength in each field's name")
            .fix("resample first if the file is for ArgyllCMS"),
        );
    }
    lost_unit(file, findings);
    let mut out = String::from("SPECT\n\n");
    header(file, &mut out, findings);
    keyword(&mut out, "SPECTRAL_BANDS", &nm.len().to_string());
    if even {
        keyword(&mut out, "SPECTRAL_START_NM", &number(nm[0]));
        keyword(&mut out, "SPECTRAL_END_NM", &number(nm[nm.len() - 1]));
    }
    let names: Vec<String> = nm.iter().map(|w| format!("SPEC_{}", number(*w))).collect();
    let _ = writeln!(out, "\nNUMBER_OF_FIELDS {}\nBEGIN_DATA_FORMAT", nm.len() + 1);
    let _ = writeln!(out, "SAMPLE_ID {}\nEND_DATA_FORMAT\n", names.join(" "));
    data(file, &mut out, findings);
    out
}

fn evenly_spaced(nm: &[f64]) -> bool {
    let (first, last) = (nm[0], nm[nm.len() - 1]);
    let step = (last - first) / (nm.len().max(2) - 1) as f64;
    nm.iter()
        .enumerate()
        .all(|(i, w)| (w - (first + step * i as f64)).abs() < 1e-6 * step.max(1e-9))
}

/// A keyword beyond those of the standard: it is declared before it is used.
fn keyword(out: &mut String, key: &str, value: &str) {
    let _ = writeln!(out, "KEYWORD \"{key}\"\n{key} \"{value}\"");
}

/// Description, quantity, and of the file's header what CGATS has words for.
fn header(file: &SpectrumFile, out: &mut String, findings: &mut Vec<Finding>) {
    let description = ["DESCRIPTOR", "Description", "description"]
        .iter()
        .find_map(|key| file.header.get(*key))
        .map_or(String::new(), text_of);
    let _ = writeln!(out, "DESCRIPTOR \"{}\"\nORIGINATOR \"isolux\"", one_line(&description));
    let mut lost = Vec::new();
    for (key, value) in file.header.iter().filter(|(key, _)| !is_own(key)) {
        if is_keyword(key) {
            keyword(out, key, &one_line(&text_of(value)));
        } else if !["Description", "description", "separator", "columns", "xmlns", "version"].contains(&key.as_str()) {
            lost.push(key.as_str());
        }
    }
    if let Some(quantity) = &file.quantity {
        keyword(out, "SPECTRAL_UNITS", &one_line(quantity));
    }
    if !lost.is_empty() {
        findings.push(Finding::note(
            "write-header",
            format!("this format has no field for: {}", lost.join(", ")),
        ));
    }
}

fn data(file: &SpectrumFile, out: &mut String, findings: &mut Vec<Finding>) {
    let sets: Vec<(&str, Vec<Option<f64>>)> = if file.series.is_empty() {
        vec![("1", file.value.iter().copied().map(Some).collect())]
    } else {
        file.series.iter().map(|s| (s.name.as_str(), s.value.clone())).collect()
    };
    let whole: Vec<_> = sets.iter().filter(|(_, v)| v.iter().all(Option::is_some)).collect();
    if whole.len() < sets.len() {
        findings.push(Finding::warning(
            "write-series",
            format!("{} series have blanks and are left out", sets.len() - whole.len()),
        ));
    }
    let _ = writeln!(out, "NUMBER_OF_SETS {}\nBEGIN_DATA", whole.len());
    for (name, values) in whole {
        let row: Vec<String> = values.iter().flatten().map(|v| number(*v)).collect();
        let _ = writeln!(out, "\"{}\" {}", one_line(name), row.join(" "));
    }
    out.push_str("END_DATA\n");
}

/// Whether the writer gives this itself.
fn is_own(key: &str) -> bool {
    const OWN: [&str; 12] = [
        "SPECT",
        "SPECTRAL_BANDS",
        "SPECTRAL_START_NM",
        "SPECTRAL_END_NM",
        "NUMBER_OF_FIELDS",
        "NUMBER_OF_SETS",
        "DESCRIPTOR",
        "ORIGINATOR",
        "SAMPLE_ID",
        "SAMPLE_NAME",
        "encoding",
        "SPECTRAL_UNITS",
    ];
    OWN.contains(&key) || wavelength_field(key)
}

/// Whether it can be a keyword of CGATS.
fn is_keyword(key: &str) -> bool {
    let may_be = |c: char| c.is_ascii_uppercase() || c.is_ascii_digit() || c == '_';
    !key.is_empty() && key.chars().all(may_be)
}

fn wavelength_field(key: &str) -> bool {
    key.strip_prefix("SPEC_").is_some_and(|n| n.parse::<f64>().is_ok())
}
