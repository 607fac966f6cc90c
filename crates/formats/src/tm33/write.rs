//! Distributions as TM-33 documents, absolute candela, every direction of the file.

use serde_json::Value;

use super::parts::{element, stored};
use super::schema_2023::write_2023;
use crate::distribution::Distribution;
use crate::finding::{Finding, Findings};
use crate::ies;
use crate::lost::with_losses;
use crate::luminaire::Luminaire;
use crate::number;
use crate::options::WriteOptions;
use crate::parsed::{Format, Written};

/// An edition that can be written.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Edition {
    /// TM-33-18, root `LuminaireOpticalData`.
    E2018,
    /// TM-33-23, root `IESTM33-22`.
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
    if edition == Edition::E2023 {
        return write_2023(distribution, None);
    }
    // The schema of ATLA S001 puts the root alone into its namespace; a blank one on the children takes them out again.
    let child = " xmlns=\"\"";
    let mut lines = vec![
        "<?xml version=\"1.0\" encoding=\"UTF-8\"?>".to_owned(),
        "<LuminaireOpticalData version=\"1.0\" xmlns=\"http://www.ies.org/tm-33\">".to_owned(),
    ];
    lines.extend(header(distribution, child));
    lines.extend(housing(&distribution.luminaire, child));
    lines.push(format!("  <Emitter{child}>"));
    lines.extend(lamp(distribution));
    if let Some(unit) = distribution.header.get("intensity_unit").and_then(Value::as_str) {
        let message = format!("the source says {unit}; its numbers are written as luminous intensity");
        findings.push(
            Finding::warning("tm33-metric", message)
                .assumed("candela")
                .fix("do not hand this document on as photometry"),
        );
    }
    lines.extend(intensities(distribution));
    lines.push("  </Emitter>".into());
    lines.push("</LuminaireOpticalData>\n".into());
    Written {
        bytes: lines.join("\n").into_bytes(),
        findings: findings.into_vec(),
    }
}

fn header(distribution: &Distribution, child: &str) -> Vec<String> {
    let luminaire = &distribution.luminaire;
    let comments = distribution.header.get("comments").and_then(Value::as_str);
    let fields = [
        ("Manufacturer", luminaire.manufacturer.as_str()),
        ("CatalogNumber", &luminaire.number),
        ("Description", &luminaire.name),
        ("Laboratory", &luminaire.laboratory),
        ("ReportNumber", &luminaire.report),
        ("ReportDate", &luminaire.date),
        ("Comments", comments.unwrap_or_default()),
    ];
    let mut lines = vec![format!("  <Header{child}>")];
    lines.extend(fields.iter().filter_map(|(name, text)| element(name, text)));
    lines.push("  </Header>".into());
    lines
}

/// What the emitter is, before its intensities.
fn lamp(distribution: &Distribution) -> Vec<String> {
    let luminaire = &distribution.luminaire;
    let ten_digits = |value: Option<f64>| value.map_or(String::new(), |value| number::shortest(value, 10));
    let quantity = luminaire.lamp_count.unwrap_or(1.0).max(1.0) as u64;
    let fields = [
        ("Description", luminaire.lamp.clone()),
        ("Quantity", quantity.to_string()),
        ("RatedLumens", ten_digits(distribution.lamp_flux_lm)),
        ("InputWatts", ten_digits(luminaire.watts)),
        ("CCT", number::decimal(&luminaire.colour).unwrap_or_default()),
    ];
    let mut lines: Vec<String> = fields.iter().filter_map(|(name, text)| element(name, text)).collect();
    if let Some(ra) = number::decimal(&luminaire.rendering) {
        lines.push(format!("    <ColorRendering><Ra>{ra}</Ra></ColorRendering>"));
    }
    lines
}

fn intensities(distribution: &Distribution) -> Vec<String> {
    let grid = &distribution.intensity;
    let (planes, last) = stored(distribution);
    let mut lines = [
        "    <IntensityDistribution>",
        "      <PhotometryType>C</PhotometryType>",
        "      <Metric>Luminous</Metric>",
    ]
    .map(str::to_owned)
    .to_vec();
    let closing = last.then_some((0, 360.0));
    for (plane, c) in planes.iter().map(|&plane| (plane, grid.c_deg()[plane])).chain(closing) {
        for (gamma, candela) in grid.gamma_deg().iter().zip(grid.row(plane)) {
            lines.push(format!(
                "      <IntensityData horz=\"{}\" vert=\"{}\">{}</IntensityData>",
                number::shortest(c, 10),
                number::shortest(*gamma, 10),
                number::shortest(*candela, 9)
            ));
        }
    }
    lines.push("    </IntensityDistribution>".to_owned());
    lines
}

/// Housing and luminous opening in mm, where they are known. As in LM-63 length lies along C0–C180 and width along
/// C90–C270.
fn housing(luminaire: &Luminaire, child: &str) -> Vec<String> {
    let size = |value: f64| number::shortest(value, 9);
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
