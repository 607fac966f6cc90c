//! A distribution as TM-33-23, root `IESTM33-22`, after the schema of its annex, with spectra over angle.
//!
//! What the schema requires and the source does not state is left out with a finding: an invented wattage would look
//! like a measured one.

use std::collections::BTreeSet;

use isolux_photometry::Symmetry;
use isolux_spectrum::Spectrum;

use super::parts::{element, stored};
use crate::distribution::Distribution;
use crate::finding::{Finding, Findings};
use crate::number;
use crate::parsed::Written;

/// Spectra that stand beside the intensities.
#[derive(Debug, Clone, Copy)]
pub struct Spectra<'a> {
    /// Total spectral flux, W/nm.
    pub total: &'a Spectrum,
    /// Directions (C, γ) in degrees with their spectral radiant intensity, W/(sr·nm).
    pub directions: &'a [((f64, f64), &'a Spectrum)],
}

/// Writes a distribution, and its spectra where there are some.
pub fn write_2023(distribution: &Distribution, spectra: Option<&Spectra<'_>>) -> Written {
    let mut findings = Findings::new();
    let mut lines = vec![
        "<?xml version=\"1.0\" encoding=\"UTF-8\"?>".to_owned(),
        "<IESTM33-22>".to_owned(),
        "  <Version>1.1</Version>".to_owned(),
    ];
    lines.extend(header(distribution, &mut findings));
    lines.extend(housing(distribution));
    lines.extend(EQUIPMENT.map(str::to_owned));
    lines.push("  <Emitter>".into());
    lines.extend(lamp(distribution, &mut findings));
    lines.extend(intensities(distribution));
    if let Some(spectra) = spectra {
        lines.extend(spectral(spectra));
    }
    lines.push("  </Emitter>".into());
    lines.push("</IESTM33-22>\n".into());
    Written {
        bytes: lines.join("\n").into_bytes(),
        findings: findings.into_vec(),
    }
}

const EQUIPMENT: [&str; 5] = [
    "  <Equipment>",
    "    <Gonioradiometer>",
    "      <Type>CIE_C</Type>",
    "    </Gonioradiometer>",
    "  </Equipment>",
];

fn lacks(what: &str) -> Finding {
    let message = format!("TM-33-23 requires {what}, which is not known: the document does not follow its schema");
    Finding::warning("tm33-required", message).fix("state it in the source, or write --edition 2018")
}

fn header(distribution: &Distribution, findings: &mut Findings) -> Vec<String> {
    let luminaire = &distribution.luminaire;
    let mut lines = vec!["  <Header>".to_owned()];
    let optional = [
        ("Manufacturer", &luminaire.manufacturer),
        ("CatalogNumber", &luminaire.number),
    ];
    lines.extend(optional.iter().filter_map(|(name, text)| element(name, text)));
    // Strings that may be empty, but must be there.
    for (name, text) in [
        ("Description", &luminaire.name),
        ("Laboratory", &luminaire.laboratory),
        ("ReportNumber", &luminaire.report),
    ] {
        lines.push(element(name, text).unwrap_or_else(|| format!("    <{name}/>")));
    }
    if is_date(&luminaire.date) {
        lines.extend(element("ReportDate", &luminaire.date));
    } else {
        findings.push(lacks("the date of the report (year-month-day)"));
    }
    let comments = distribution.header.get("comments").and_then(serde_json::Value::as_str);
    lines.extend(element("Comment", comments.unwrap_or_default()));
    lines.push("  </Header>".into());
    lines
}

/// `xs:date` without a time zone.
fn is_date(text: &str) -> bool {
    let parts: Vec<&str> = text.split('-').collect();
    let digits = |part: &str, count: usize| part.len() == count && part.bytes().all(|byte| byte.is_ascii_digit());
    matches!(parts[..], [year, month, day] if digits(year, 4) && digits(month, 2) && digits(day, 2))
}

/// Housing in mm. As in LM-63 length lies along C0–C180 and width along C90–C270.
fn housing(distribution: &Distribution) -> Vec<String> {
    let luminaire = &distribution.luminaire;
    let (Some(length), Some(width), Some(height)) = (luminaire.length_mm, luminaire.width_mm, luminaire.height_mm)
    else {
        return Vec::new();
    };
    let (along_c0, along_c90) = if width == 0.0 {
        (length, length)
    } else {
        (width, length)
    };
    let mut lines = vec!["  <Luminaire>".to_owned(), "    <Dimensions>".to_owned()];
    for (name, value) in [("Length", along_c0), ("Width", along_c90), ("Height", height)] {
        lines.push(format!("      <{name}>{}</{name}>", number::shortest(value, 9)));
    }
    lines.push("    </Dimensions>".into());
    lines.push("    <NumEmitter>1</NumEmitter>".into());
    lines.push("  </Luminaire>".into());
    lines
}

/// What the emitter is, before its intensities.
fn lamp(distribution: &Distribution, findings: &mut Findings) -> Vec<String> {
    let luminaire = &distribution.luminaire;
    let quantity = luminaire.lamp_count.unwrap_or(1.0).max(1.0) as u64;
    let mut lines = vec![format!("    <Quantity>{quantity}</Quantity>")];
    lines.push(element("Description", &luminaire.lamp).unwrap_or_else(|| "    <Description/>".to_owned()));
    let number = |name: &str, value: f64| format!("    <{name}>{}</{name}>", number::shortest(value, 10));
    lines.extend(distribution.lamp_flux_lm.map(|lumens| number("RatedLumens", lumens)));
    // A power of zero is how EULUMDAT says that it is not known.
    match luminaire.watts.filter(|watts| *watts > 0.0) {
        Some(watts) => lines.push(number("InputWattage", watts)),
        None => findings.push(lacks("the electrical power")),
    }
    let whole = |text: &str| {
        number::decimal(text)?
            .parse::<f64>()
            .ok()
            .map(|value| value.round() as i64)
    };
    if let Some(cct) = whole(&luminaire.colour) {
        lines.push(format!(
            "    <ColorTemperature><FixedCCT>{cct}</FixedCCT></ColorTemperature>"
        ));
    }
    if let Some(ra) = whole(&luminaire.rendering) {
        lines.push(format!(
            "    <ColorRendering><CIE_CRI><Ra>{ra}</Ra></CIE_CRI></ColorRendering>"
        ));
    }
    lines
}

fn intensities(distribution: &Distribution) -> Vec<String> {
    let grid = &distribution.intensity;
    let (planes, last) = stored(distribution);
    let closing = last.then_some((0, 360.0));
    let planes: Vec<(usize, f64)> = planes
        .iter()
        .map(|&plane| (plane, grid.c_deg()[plane]))
        .chain(closing)
        .collect();
    let symmetry = match grid.detect_symmetry(grid.peak().intensity_cd.abs() * 1e-9) {
        Symmetry::Rotational => "Symm_Full",
        Symmetry::Quadrant if planes.len() < grid.c_deg().len() => "Symm_Quad",
        Symmetry::C0C180 if planes.len() < grid.c_deg().len() => "Symm_Bi_0",
        Symmetry::C90C270 if planes.len() < grid.c_deg().len() => "Symm_Bi_90",
        _ => "Symm_None",
    };
    let absolute = distribution.absolute || distribution.lamp_flux_lm.is_none();
    let (horizontal, vertical) = (planes.len(), grid.gamma_deg().len());
    let mut lines = vec!["    <LuminousData>".to_owned(), "      <LuminousIntensity>".to_owned()];
    lines.extend(
        [
            ("AbsolutePhotometry", absolute.to_string()),
            ("Symm", symmetry.to_owned()),
            ("NumberMeasured", (horizontal * vertical).to_string()),
            ("NumberHorz", horizontal.to_string()),
            ("NumberVert", vertical.to_string()),
        ]
        .map(|(name, text)| format!("        <{name}>{text}</{name}>")),
    );
    for (plane, c_deg) in planes {
        let c_deg = number::shortest(c_deg, 10);
        for (gamma_deg, candela) in grid.gamma_deg().iter().zip(grid.row(plane)) {
            let (gamma_deg, candela) = (number::shortest(*gamma_deg, 10), number::shortest(*candela, 9));
            lines.push(format!(
                "        <IntData h=\"{c_deg}\" v=\"{gamma_deg}\">{candela}</IntData>"
            ));
        }
    }
    lines.push("      </LuminousIntensity>".into());
    lines.push("    </LuminousData>".into());
    lines
}

/// Flux over wavelength, and the spectral radiant intensity of each direction: they need not lie on a grid.
fn spectral(spectra: &Spectra<'_>) -> Vec<String> {
    let wavelengths = spectra.total.wavelength_nm().len();
    let mut lines = vec!["    <SpectralData>".to_owned(), "      <EmitterSpectral>".to_owned()];
    lines.push(format!("        <NumberWavelength>{wavelengths}</NumberWavelength>"));
    for (nm, value) in spectra.total.wavelength_nm().iter().zip(spectra.total.value()) {
        lines.push(format!("        <PwrData w=\"{nm}\">{value:.6e}</PwrData>"));
    }
    lines.push("      </EmitterSpectral>".into());
    let distinct = |angle: fn(&(f64, f64)) -> f64| {
        let bits: BTreeSet<u64> = spectra.directions.iter().map(|(at, _)| angle(at).to_bits()).collect();
        bits.len()
    };
    let longest = spectra.directions.iter().map(|(_, of)| of.wavelength_nm().len()).max();
    lines.push("      <AngularSpectral>".into());
    lines.extend(
        [
            ("Absolute", "true".to_owned()),
            ("Symm", "Symm_Arbitrary".to_owned()),
            ("NumberMeasured", spectra.directions.len().to_string()),
            ("NumberHorz", distinct(|at| at.0).to_string()),
            ("NumberVert", distinct(|at| at.1).to_string()),
            ("NumberWavelength", longest.unwrap_or(0).to_string()),
        ]
        .map(|(name, text)| format!("        <{name}>{text}</{name}>")),
    );
    for ((c_deg, gamma_deg), of) in spectra.directions {
        for (nm, value) in of.wavelength_nm().iter().zip(of.value()) {
            lines.push(format!(
                "        <IntData h=\"{c_deg}\" v=\"{gamma_deg}\" w=\"{nm}\">{value:.6e}</IntData>"
            ));
        }
    }
    lines.push("      </AngularSpectral>".into());
    lines.push("    </SpectralData>".into());
    lines
}
