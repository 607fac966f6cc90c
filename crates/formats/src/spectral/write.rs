//! Spectra to the byte: `.spd`, `.spectrum`, `.csv`, JSON, and what all writers share.

use std::fmt::Write as _;

use serde_json::Value;

use super::file::SpectrumFile;
use crate::finding::Finding;
use crate::parsed::Written;

pub(super) fn written(text: impl FnOnce(&mut Vec<Finding>) -> String) -> Written {
    let mut findings = Vec::new();
    let bytes = text(&mut findings).into_bytes();
    Written { bytes, findings }
}

/// Pairs of pbrt and Mitsuba.
pub(crate) fn pairs(file: &SpectrumFile) -> Written {
    written(|findings| spd(file, findings))
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
pub(super) fn number(value: f64) -> String {
    if value != 0.0 && !(1e-5..1e15).contains(&value.abs()) {
        format!("{value:e}")
    } else if value == 0.0 {
        "0".to_owned()
    } else {
        format!("{value}")
    }
}

pub(super) fn text_of(value: &Value) -> String {
    value.as_str().map_or_else(|| value.to_string(), str::to_owned)
}

/// Text on one line, without what would end a comment or a quotation.
pub(super) fn one_line(text: &str) -> String {
    text.replace(['\r', '\n'], " ").replace('"', "'")
}

pub(super) fn other_series(file: &SpectrumFile, findings: &mut Vec<Finding>) {
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

pub(super) fn lost_header(file: &SpectrumFile, kept: &[&str], findings: &mut Vec<Finding>) {
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

pub(super) fn lost_unit(file: &SpectrumFile, findings: &mut Vec<Finding>) {
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
