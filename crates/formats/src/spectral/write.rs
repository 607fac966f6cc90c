//! Spectra to the byte: `.spdx`, `.spd`, `.sp`, `.spectrum`, `.csv`.

use std::fmt::Write as _;

use serde_json::Value;

use super::file::SpectrumFile;
use super::spdx::{NAMESPACES, QUANTITIES, UNIT_COMMENT};
use crate::finding::Finding;
use crate::parsed::Written;

fn written(text: impl FnOnce(&mut Vec<Finding>) -> String) -> Written {
    let mut findings = Vec::new();
    let bytes = text(&mut findings).into_bytes();
    Written { bytes, findings }
}

/// TM-27.
pub(crate) fn tm27(file: &SpectrumFile) -> Written {
    written(|findings| spdx(file, findings))
}

/// Pairs of pbrt and Mitsuba.
pub(crate) fn pairs(file: &SpectrumFile) -> Written {
    written(|findings| spd(file, findings))
}

/// CGATS.
pub(crate) fn cgats(file: &SpectrumFile) -> Written {
    written(|findings| sp(file, findings))
}

/// Speos.
pub(crate) fn spectrum(file: &SpectrumFile) -> Written {
    written(|findings| speos(file, findings))
}

/// Comma-separated values.
pub(crate) fn table(file: &SpectrumFile) -> Written {
    written(|findings| csv(file, findings))
}

/// The document `isolux-spectrum/1`.
pub(crate) fn json(file: &SpectrumFile) -> Written {
    written(|_| format!("{:#}\n", file.to_json()))
}

/// The shortest notation that reads back as the same number, with an exponent where plain digits would run away.
fn number(value: f64) -> String {
    if value != 0.0 && !(1e-5..1e15).contains(&value.abs()) {
        format!("{value:e}")
    } else if value == 0.0 {
        "0".to_owned()
    } else {
        format!("{value}")
    }
}

fn text_of(value: &Value) -> String {
    value.as_str().map_or_else(|| value.to_string(), str::to_owned)
}

/// Text on one line, without what would end a comment or a quotation.
fn one_line(text: &str) -> String {
    text.replace(['\r', '\n'], " ").replace('"', "'")
}

fn other_series(file: &SpectrumFile, findings: &mut Vec<Finding>) {
    if file.series.len() > 1 {
        let others: Vec<&str> = file.series[1..].iter().map(|s| s.name.as_str()).collect();
        findings.push(
            Finding::warning(
                "write-series",
                format!("this format holds one series; left out: {}", others.join(", ")),
            )
            .fix("write CSV, or choose one with --series"),
        );
    }
}

fn lost_header(file: &SpectrumFile, kept: &[&str], findings: &mut Vec<Finding>) {
    let lost: Vec<&str> = file
        .header
        .keys()
        .map(String::as_str)
        .filter(|key| !kept.contains(key) && !["encoding", "separator", "columns", "xmlns", "version"].contains(key))
        .collect();
    if !lost.is_empty() {
        findings.push(Finding::note(
            "write-header",
            format!("this format has no field for: {}", lost.join(", ")),
        ));
    }
}

fn escape(text: &str) -> String {
    let mut out = String::with_capacity(text.len());
    for c in text.chars() {
        match c {
            '&' => out.push_str("&amp;"),
            '<' => out.push_str("&lt;"),
            '>' => out.push_str("&gt;"),
            '"' => out.push_str("&quot;"),
            c if c < ' ' && !matches!(c, '\n' | '\t') => out.push(' '),
            c => out.push(c),
        }
    }
    out
}

/// TM-27-14. Elements in the order of the schema.
fn spdx(file: &SpectrumFile, findings: &mut Vec<Finding>) -> String {
    const HEADER: [&str; 11] = [
        "Manufacturer",
        "CatalogNumber",
        "Description",
        "DocumentCreator",
        "UniqueIdentifier",
        "MeasurementEquipment",
        "Laboratory",
        "ReportNumber",
        "ReportDate",
        "DocumentCreationDate",
        "Comments",
    ];
    const BODY: [&str; 4] = [
        "ReflectionGeometry",
        "TransmissionGeometry",
        "BandwidthFWHM",
        "BandwidthCorrected",
    ];
    other_series(file, findings);
    lost_header(file, &[HEADER.as_slice(), BODY.as_slice()].concat(), findings);
    let mut out = format!(
        "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n<IESTM2714 xmlns=\"{}\" version=\"1.0\">\n  <Header>\n",
        NAMESPACES[0]
    );
    for key in HEADER {
        let comment_unit = (key == "Comments")
            .then(|| file.unit.as_ref().map(|unit| format!("{UNIT_COMMENT}{unit}")))
            .flatten();
        let own = file.header.get(key).map(text_of);
        let text = match (own, comment_unit) {
            (Some(own), Some(unit)) if !own.contains(&unit) => Some(format!("{own}; {unit}")),
            (own, unit) => own.or(unit),
        };
        // Three fields are required by the schema.
        let required = [
            "Description",
            "DocumentCreator",
            "UniqueIdentifier",
            "DocumentCreationDate",
        ]
        .contains(&key);
        match text {
            Some(text) => {
                let _ = writeln!(out, "    <{key}>{}</{key}>", escape(&text));
            }
            None if required => {
                let text = if key == "DocumentCreator" { "isolux" } else { "N/A" };
                let _ = writeln!(out, "    <{key}>{text}</{key}>");
            }
            None => {}
        }
    }
    out.push_str("  </Header>\n  <SpectralDistribution>\n");
    let stated = file.quantity.as_deref().unwrap_or("other");
    let quantity = QUANTITIES.iter().find(|q| q.eq_ignore_ascii_case(stated));
    if quantity.is_none() || file.quantity.is_none() {
        findings.push(
            Finding::warning("write-quantity", format!("TM-27 has no quantity “{stated}”"))
                .assumed("other")
                .raw(stated),
        );
    }
    let _ = writeln!(
        out,
        "    <SpectralQuantity>{}</SpectralQuantity>",
        quantity.unwrap_or(&"other")
    );
    for key in BODY {
        if let Some(value) = file.header.get(key) {
            let _ = writeln!(out, "    <{key}>{}</{key}>", escape(&text_of(value)));
        }
    }
    for (nm, value) in file.wavelength_nm.iter().zip(&file.value) {
        let _ = writeln!(
            out,
            "    <SpectralData wavelength=\"{}\">{}</SpectralData>",
            number(*nm),
            number(*value)
        );
    }
    out.push_str("  </SpectralDistribution>\n</IESTM2714>\n");
    out
}

/// Pairs, as pbrt and Mitsuba read them; the header as comments.
fn spd(file: &SpectrumFile, findings: &mut Vec<Finding>) -> String {
    other_series(file, findings);
    let mut out = comments(file);
    // The unit last: comments above may speak of the unit that the source had.
    out.push_str("#wavelength_nm value\n");
    for (nm, value) in file.wavelength_nm.iter().zip(&file.value) {
        let _ = writeln!(out, "{} {}", number(*nm), number(*value));
    }
    out
}

fn lost_unit(file: &SpectrumFile, findings: &mut Vec<Finding>) {
    if let Some(unit) = &file.unit {
        findings
            .push(Finding::warning("write-unit", format!("this format has no field for the unit {unit}")).raw(unit));
    }
}

fn comments(file: &SpectrumFile) -> String {
    let mut out = String::new();
    let stated = [("quantity", &file.quantity), ("unit", &file.unit)];
    for (key, value) in stated {
        if let Some(value) = value {
            let _ = writeln!(out, "# {key}: {}", one_line(value));
        }
    }
    for (key, value) in &file.header {
        if !["encoding", "separator", "columns", "quantity", "unit"].contains(&key.as_str()) {
            let _ = writeln!(out, "# {}: {}", one_line(key), one_line(&text_of(value)));
        }
    }
    out
}

/// Speos: the description is all that it holds.
fn speos(file: &SpectrumFile, findings: &mut Vec<Finding>) -> String {
    other_series(file, findings);
    lost_unit(file, findings);
    lost_header(file, &["description"], findings);
    let description = ["description", "Description", "DESCRIPTOR"]
        .iter()
        .find_map(|key| file.header.get(*key))
        .map_or_else(|| file.quantity.clone().unwrap_or_default(), text_of);
    let mut out = format!(
        "OPTIS - Spectrum file v1.0\n{}\n{}\n",
        one_line(&description),
        file.value.len()
    );
    for (nm, value) in file.wavelength_nm.iter().zip(&file.value) {
        let _ = writeln!(out, "{}\t{}", number(*nm), number(*value));
    }
    out
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

/// CSV: comma, point, LF; the header as comments.
fn csv(file: &SpectrumFile, _findings: &mut Vec<Finding>) -> String {
    let mut out = comments(file);
    let cell = |text: &str| {
        let text = one_line(text);
        if text.contains(',') {
            format!("\"{text}\"")
        } else {
            text
        }
    };
    if file.series.is_empty() {
        let name = file.quantity.as_deref().unwrap_or("value");
        let heading = file
            .unit
            .as_ref()
            .map_or_else(|| name.to_owned(), |unit| format!("{name} ({unit})"));
        let _ = writeln!(out, "wavelength_nm,{}", cell(&heading));
    } else {
        let names: Vec<String> = file.series.iter().map(|s| cell(&s.name)).collect();
        let _ = writeln!(out, "wavelength_nm,{}", names.join(","));
    }
    for (i, nm) in file.wavelength_nm.iter().enumerate() {
        out.push_str(&number(*nm));
        if file.series.is_empty() {
            let _ = write!(out, ",{}", number(file.value[i]));
        } else {
            for series in &file.series {
                out.push(',');
                if let Some(value) = series.value[i] {
                    out.push_str(&number(value));
                }
            }
        }
        out.push('\n');
    }
    out
}
