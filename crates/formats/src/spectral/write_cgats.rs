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
    let nm = &file.wavelength_nm;
    let n = nm.len();
    let (first, last) = (nm[0], nm[n - 1]);
    let step = (last - first) / (n.max(2) - 1) as f64;
    let even = nm
        .iter()
        .enumerate()
        .all(|(i, w)| (w - (first + step * i as f64)).abs() < 1e-6 * step.max(1e-9));
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
    let mut lost = Vec::new();
    let mut out = String::from("SPECT\n\n");
    let quote = |text: &str| one_line(text);
    let description = ["DESCRIPTOR", "Description", "description"]
        .iter()
        .find_map(|key| file.header.get(*key))
        .map_or(String::new(), text_of);
    let _ = writeln!(out, "DESCRIPTOR \"{}\"\nORIGINATOR \"isolux\"", quote(&description));
    for (key, value) in &file.header {
        let word = !key.is_empty()
            && key
                .chars()
                .all(|c| c.is_ascii_uppercase() || c.is_ascii_digit() || c == '_');
        if OWN.contains(&key.as_str()) || wavelength_field(key) {
            continue;
        }
        if word {
            let _ = writeln!(out, "KEYWORD \"{key}\"\n{key} \"{}\"", quote(&text_of(value)));
        } else {
            lost.push(key.as_str());
        }
    }
    if let Some(quantity) = &file.quantity {
        let _ = writeln!(
            out,
            "KEYWORD \"SPECTRAL_UNITS\"\nSPECTRAL_UNITS \"{}\"",
            quote(quantity)
        );
    }
    let lost: Vec<&str> = lost
        .into_iter()
        .filter(|k| !["Description", "description", "separator", "columns", "xmlns", "version"].contains(k))
        .collect();
    if !lost.is_empty() {
        findings.push(Finding::note(
            "write-header",
            format!("this format has no field for: {}", lost.join(", ")),
        ));
    }
    let _ = writeln!(out, "KEYWORD \"SPECTRAL_BANDS\"\nSPECTRAL_BANDS \"{n}\"");
    if even {
        let _ = writeln!(
            out,
            "KEYWORD \"SPECTRAL_START_NM\"\nSPECTRAL_START_NM \"{}\"\nKEYWORD \"SPECTRAL_END_NM\"\nSPECTRAL_END_NM \"{}\"",
            number(first),
            number(last)
        );
    }
    let _ = writeln!(out, "\nNUMBER_OF_FIELDS {}\nBEGIN_DATA_FORMAT", n + 1);
    let names: Vec<String> = nm.iter().map(|w| format!("SPEC_{}", number(*w))).collect();
    let _ = writeln!(out, "SAMPLE_ID {}\nEND_DATA_FORMAT\n", names.join(" "));
    let sets: Vec<(String, Vec<Option<f64>>)> = if file.series.is_empty() {
        vec![("1".to_owned(), file.value.iter().copied().map(Some).collect())]
    } else {
        file.series.iter().map(|s| (s.name.clone(), s.value.clone())).collect()
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
        let _ = writeln!(out, "\"{}\" {}", quote(name), row.join(" "));
    }
    out.push_str("END_DATA\n");
    out
}

fn wavelength_field(key: &str) -> bool {
    key.strip_prefix("SPEC_").is_some_and(|n| n.parse::<f64>().is_ok())
}
