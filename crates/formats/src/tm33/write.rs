//! Distributions as TM-33 documents, absolute candela, every direction of the file.

use isolux_photometry::Symmetry;

use super::Edition;
use crate::Distribution;
use crate::eulumdat::Written;
use crate::finding::{Finding, Findings};
use crate::number;
use crate::xml::escaped;

/// Writes a distribution. The symmetry that the intensities really have is kept where the range of horizontal angles
/// can say it.
pub fn write(distribution: &Distribution, edition: Edition) -> Written {
    let mut findings = Findings::new();
    let grid = &distribution.intensity;
    let luminaire = &distribution.luminaire;
    let mut out = String::from("<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n");
    let root = match edition {
        Edition::E2018 => {
            out.push_str("<LuminaireOpticalData version=\"1.0\" xmlns=\"http://www.ies.org/tm-33\">\n");
            "LuminaireOpticalData"
        }
        Edition::E2023 => {
            let message = "TM-33-23 is written after samples, not after the standard: experimental";
            findings.push(Finding::warning("tm33-experimental", message).fix("write --edition 2018 for exchange"));
            out.push_str("<IESTM33-22>\n  <Version>1.1</Version>\n");
            "IESTM33-22"
        }
    };
    let date = if edition == Edition::E2018 {
        "TestDate"
    } else {
        "ReportDate"
    };
    let mut lines = vec![String::from("  <Header>")];
    for (name, text) in [
        ("Manufacturer", &luminaire.manufacturer),
        ("CatalogNumber", &luminaire.number),
        ("Description", &luminaire.name),
        ("Laboratory", &luminaire.laboratory),
        ("ReportNumber", &luminaire.report),
        (date, &luminaire.date),
    ] {
        if !text.is_empty() {
            lines.push(format!("    <{name}>{}</{name}>", escaped(text)));
        }
    }
    lines.push("  </Header>".into());
    lines.push("  <Emitter>".into());
    lines.push(format!(
        "    <Quantity>{}</Quantity>",
        luminaire.lamp_count.unwrap_or(1.0).max(1.0) as u64
    ));
    if !luminaire.lamp.is_empty() {
        lines.push(format!("    <Description>{}</Description>", escaped(&luminaire.lamp)));
    }
    if let Some(flux) = distribution.lamp_flux_lm {
        lines.push(format!(
            "    <RatedLumens>{}</RatedLumens>",
            number::significant(flux, 10)
        ));
    }
    if let Some(watts) = luminaire.watts {
        let name = if edition == Edition::E2018 {
            "InputWatts"
        } else {
            "InputWattage"
        };
        lines.push(format!("    <{name}>{}</{name}>", number::significant(watts, 9)));
    }
    let (holder, kind) = match edition {
        Edition::E2018 => ("IntensityDistribution", "C"),
        Edition::E2023 => ("LuminousData", "CIE _ C"),
    };
    let (planes, last) = stored(distribution);
    lines.push(format!("    <{holder}>"));
    lines.push(format!("      <PhotometryType>{kind}</PhotometryType>"));
    lines.push("      <Metric>Luminous</Metric>".into());
    lines.push(format!(
        "      <AbsolutePhotometry>{}</AbsolutePhotometry>",
        distribution.absolute || distribution.lamp_flux_lm.is_none()
    ));
    lines.push(format!(
        "      <NumberHorz>{}</NumberHorz>",
        planes.len() + usize::from(last)
    ));
    lines.push(format!("      <NumberVert>{}</NumberVert>", grid.gamma_deg().len()));
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
    match grid.detect_symmetry(grid.peak().intensity.value().abs() * 1e-9) {
        Symmetry::Rotational => (vec![0], false),
        Symmetry::Quadrant if has(0.0) && has(90.0) => (within(0.0, 90.0), false),
        Symmetry::C0C180 if has(0.0) && has(180.0) => (within(0.0, 180.0), false),
        Symmetry::C90C270 if has(90.0) && has(270.0) => (within(90.0, 270.0), false),
        _ => ((0..c_deg.len()).collect(), has(0.0)),
    }
}
