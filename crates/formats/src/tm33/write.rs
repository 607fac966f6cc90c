//! Distributions as TM-33 documents, absolute candela, every direction of the file.

use isolux_photometry::Symmetry;
use serde_json::Value;

use crate::distribution::Distribution;
use crate::distribution::Luminaire;
use crate::finding::{Finding, Findings};
use crate::ies;
use crate::lost::with_losses;
use crate::number;
use crate::options::WriteOptions;
use crate::parsed::{Format, Written};
use crate::xml::escaped;

/// An edition that can be written.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Edition {
    /// TM-33-18, root `LuminaireOpticalData`.
    E2018,
    /// TM-33-23, root `IESTM33-22`; experimental.
    E2023,
}

pub(crate) fn encode(distribution: &Distribution, options: &WriteOptions) -> Result<Written, Finding> {
    options.only_for(Format::TM33)?;
    let edition = match options.edition.as_deref() {
        None | Some("2018") => Edition::E2018,
        Some("2023") => Edition::E2023,
        Some(other) => {
            let message = format!("TM-33 is written in editions 2018 and 2023, not {other}");
            return Err(Finding::error("convert-edition", message));
        }
    };
    let written = write(distribution, edition);
    Ok(with_losses(
        written,
        distribution,
        Format::TM33,
        ies::edition::Edition::E2002,
    ))
}

/// Writes a distribution. The symmetry that the intensities really have is kept where the range of horizontal angles
/// can say it.
pub fn write(distribution: &Distribution, edition: Edition) -> Written {
    let mut findings = Findings::new();
    let grid = &distribution.intensity;
    let luminaire = &distribution.luminaire;
    let mut out = String::from("<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n");
    // The schema of ATLA S001 puts the root alone into its namespace; a blank one on the children takes them out again.
    let (root, child) = match edition {
        Edition::E2018 => {
            out.push_str("<LuminaireOpticalData version=\"1.0\" xmlns=\"http://www.ies.org/tm-33\">\n");
            ("LuminaireOpticalData", " xmlns=\"\"")
        }
        Edition::E2023 => {
            let message = "TM-33-23 is written after samples, not after the standard: experimental";
            findings.push(Finding::warning("tm33-experimental", message).fix("write --edition 2018 for exchange"));
            out.push_str("<IESTM33-22>\n  <Version>1.1</Version>\n");
            ("IESTM33-22", "")
        }
    };
    let mut lines = vec![format!("  <Header{child}>")];
    let element = |lines: &mut Vec<String>, name: &str, text: &str| {
        if !text.is_empty() {
            lines.push(format!("    <{name}>{}</{name}>", escaped(text)));
        }
    };
    for (name, text) in [
        ("Manufacturer", &luminaire.manufacturer),
        ("CatalogNumber", &luminaire.number),
        ("Description", &luminaire.name),
        ("Laboratory", &luminaire.laboratory),
        ("ReportNumber", &luminaire.report),
        ("ReportDate", &luminaire.date),
    ] {
        element(&mut lines, name, text);
    }
    let comments = distribution.header.get("comments").and_then(Value::as_str);
    element(&mut lines, "Comments", comments.unwrap_or_default());
    lines.push("  </Header>".into());
    lines.extend(housing(luminaire, child));
    lines.push(format!("  <Emitter{child}>"));
    element(&mut lines, "Description", &luminaire.lamp);
    let quantity = luminaire.lamp_count.unwrap_or(1.0).max(1.0) as u64;
    element(&mut lines, "Quantity", &quantity.to_string());
    let watts = if edition == Edition::E2018 {
        "InputWatts"
    } else {
        "InputWattage"
    };
    for (name, value) in [("RatedLumens", distribution.lamp_flux_lm), (watts, luminaire.watts)] {
        element(
            &mut lines,
            name,
            &value.map_or(String::new(), |value| number::significant(value, 10)),
        );
    }
    element(
        &mut lines,
        "CCT",
        &number::decimal(&luminaire.colour).unwrap_or_default(),
    );
    if let Some(ra) = number::decimal(&luminaire.rendering) {
        lines.push(format!("    <ColorRendering><Ra>{ra}</Ra></ColorRendering>"));
    }
    let (holder, kind) = match edition {
        Edition::E2018 => ("IntensityDistribution", "C"),
        Edition::E2023 => ("LuminousData", "CIE _ C"),
    };
    let (planes, last) = stored(distribution);
    lines.push(format!("    <{holder}>"));
    lines.push(format!("      <PhotometryType>{kind}</PhotometryType>"));
    if let Some(unit) = distribution.header.get("intensity_unit").and_then(Value::as_str) {
        let message = format!("the source says {unit}; its numbers are written as luminous intensity");
        findings.push(
            Finding::warning("tm33-metric", message)
                .assumed("candela")
                .fix("do not hand this document on as photometry"),
        );
    }
    lines.push("      <Metric>Luminous</Metric>".into());
    // ATLA S001 has neither the flag nor the counts.
    if edition == Edition::E2023 {
        lines.push(format!(
            "      <AbsolutePhotometry>{}</AbsolutePhotometry>",
            distribution.absolute || distribution.lamp_flux_lm.is_none()
        ));
        lines.push(format!(
            "      <NumberHorz>{}</NumberHorz>",
            planes.len() + usize::from(last)
        ));
        lines.push(format!("      <NumberVert>{}</NumberVert>", grid.gamma_deg().len()));
    }
    let closing = last.then_some((0, 360.0));
    for (plane, c) in planes.iter().map(|&plane| (plane, grid.c_deg()[plane])).chain(closing) {
        for (gamma, candela) in grid.gamma_deg().iter().zip(grid.row(plane)) {
            lines.push(format!(
                "      <IntensityData horz=\"{}\" vert=\"{}\">{}</IntensityData>",
                number::significant(c, 10),
                number::significant(*gamma, 10),
                number::significant(*candela, 9)
            ));
        }
    }
    lines.push(format!("    </{holder}>"));
    lines.push("  </Emitter>".into());
    lines.push(format!("</{root}>"));
    out.push_str(&lines.join("\n"));
    out.push('\n');
    Written {
        bytes: out.into_bytes(),
        findings: findings.into_vec(),
    }
}

/// Housing and luminous opening in mm, where they are known. As in LM-63 length lies along C0–C180 and width along
/// C90–C270.
fn housing(luminaire: &Luminaire, child: &str) -> Vec<String> {
    let size = |value: f64| number::significant(value, 9);
    let mut lines = Vec::new();
    if let (Some(length), Some(width), Some(height)) = (luminaire.length_mm, luminaire.width_mm, luminaire.height_mm) {
        let (along_c0, along_c90) = if width == 0.0 { (length, width) } else { (width, length) };
        lines.push("    <Dimensions>".to_owned());
        for (name, value) in [("Length", along_c0), ("Width", along_c90), ("Height", height)] {
            lines.push(format!("      <{name}>{}</{name}>", size(value)));
        }
        lines.push("    </Dimensions>".to_owned());
    }
    if let (Some(length), Some(width)) = (luminaire.luminous_length_mm, luminaire.luminous_width_mm)
        && length > 0.0
    {
        lines.push("    <LuminousOpening>".to_owned());
        if width == 0.0 {
            lines.push("      <Shape>Circular</Shape>".to_owned());
            lines.push(format!("      <Diameter>{}</Diameter>", size(length)));
        } else {
            let elliptic = matches!(luminaire.luminous_body_mm, Some([x, y, _]) if x < 0.0 && y < 0.0);
            let shape = if elliptic { "Elliptical" } else { "Rectangular" };
            lines.push(format!("      <Shape>{shape}</Shape>"));
            lines.push(format!("      <Length>{}</Length>", size(width)));
            lines.push(format!("      <Width>{}</Width>", size(length)));
        }
        lines.push("    </LuminousOpening>".to_owned());
    }
    if lines.is_empty() {
        return lines;
    }
    lines.insert(0, format!("  <Luminaire{child}>"));
    lines.push("  </Luminaire>".to_owned());
    lines
}

/// Planes to write, and whether C0 is repeated at 360°.
fn stored(distribution: &Distribution) -> (Vec<usize>, bool) {
    let grid = &distribution.intensity;
    let c_deg = grid.c_deg();
    let has = |angle: f64| c_deg.contains(&angle);
    let within = |from: f64, to: f64| {
        (0..c_deg.len())
            .filter(|&plane| (from..=to).contains(&c_deg[plane]))
            .collect()
    };
    match grid.detect_symmetry(grid.peak().intensity_cd.abs() * 1e-9) {
        Symmetry::Rotational => (vec![0], false),
        Symmetry::Quadrant if has(0.0) && has(90.0) => (within(0.0, 90.0), false),
        Symmetry::C0C180 if has(0.0) && has(180.0) => (within(0.0, 180.0), false),
        Symmetry::C90C270 if has(90.0) && has(270.0) => (within(90.0, 270.0), false),
        _ => ((0..c_deg.len()).collect(), has(0.0)),
    }
}
