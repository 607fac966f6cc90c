//! ANSI/IES TM-27-14 `.spdx`.

use serde_json::Value;

use super::axis::AxisUnit;
use super::file::SpectrumFile;
use super::point::Point;
use super::points::Draft;
use super::write_tm27::{NAMESPACES, QUANTITIES, UNIT_COMMENT, tm27};
use crate::file_format::FileFormat;
use crate::finding::{Finding, Findings};
use crate::number;
use crate::parsed::{Format, Kind, Parsed};
use crate::text::Text;
use crate::xml::{self, Element};

pub(crate) const FORMAT: FileFormat = FileFormat {
    format: Format::SPDX,
    title: "TM-27 .spdx",
    extensions: &["spdx"],
    detect: |source| looks_like(source.text()) || source.extension == "spdx",
    read: |source| source.spectrum(read),
    write_distribution: None,
    write_spectrum: Some(tm27),
};

/// Whether the root element stands in the text.
pub(crate) fn looks_like(text: &Text<'_>) -> bool {
    text.lines().take(30).any(|l| l.contains("<IESTM27"))
}

/// Reads the document.
fn read(text: &Text<'_>, mut findings: Findings) -> Parsed<SpectrumFile> {
    let refused = |mut findings: Findings, code: &'static str, line: usize, message: String| {
        let finding = Finding::error(code, message).at(line, 1).raw(text.line(line - 1));
        findings.push(finding.fix("fetch the file again, or check that it is TM-27"));
        Parsed::refused(Some(Format::SPDX), Some(Kind::Spectrum), findings)
    };
    let root = match xml::parse(text.content()) {
        Err(error) => {
            return refused(
                findings,
                "spdx-xml",
                error.line,
                format!("the XML is damaged: {}", error.reason),
            );
        }
        Ok(root) if !root.name.to_ascii_uppercase().starts_with("IESTM27") => {
            let message = format!("the root element is <{}>, not <IESTM2714>", root.name);
            return refused(findings, "spdx-root", root.line, message);
        }
        Ok(root) => root,
    };
    let bodies: Vec<&Element> = root
        .children
        .iter()
        .filter(|child| child.name == "SpectralDistribution")
        .collect();
    let &[body] = bodies.as_slice() else {
        let message = format!("{} elements <SpectralDistribution> where one is needed", bodies.len());
        return refused(findings, "spdx-distribution", root.line, message);
    };
    let mut draft = Draft::new(text.encoding);
    draft.axis = Some(AxisUnit::Nanometre);
    for (key, value) in &root.attributes {
        attribute(key, value, &root, &mut findings);
        draft.header.insert(key.clone(), value.clone().into());
    }
    let header = root.children.iter().filter(|child| child.name == "Header");
    for element in header.flat_map(|header| &header.children).chain(&body.children) {
        if element.name == "SpectralData" {
            match point(element, &mut findings) {
                Some(point) => draft.points.push(point),
                None => draft.whole = false,
            }
        } else if draft
            .header
            .insert(element.name.clone(), element.text.clone().into())
            .is_some()
        {
            let finding = Finding::warning("spdx-repeated", format!("{} stands here again", element.name));
            findings.push(
                finding
                    .at(element.line, element.column)
                    .raw(&element.text)
                    .assumed("the last one"),
            );
        }
    }
    let quantity = draft.header.remove("SpectralQuantity");
    draft.quantity = quantity.as_ref().and_then(Value::as_str).map(str::to_owned);
    let (message, line) = match &draft.quantity {
        Some(name) if QUANTITIES.iter().any(|known| known.eq_ignore_ascii_case(name)) => (None, 0),
        Some(name) => {
            let line = body.child("SpectralQuantity").map_or(body.line, |element| element.line);
            (
                Some(format!("TM-27 does not know the spectral quantity “{name}”")),
                line,
            )
        }
        None => (Some("SpectralQuantity is missing".to_owned()), body.line),
    };
    if let Some(message) = message {
        let finding = Finding::warning("spdx-quantity", message)
            .at(line, 1)
            .assumed("as it stands");
        findings.push(finding.fix(format!("one of {}", QUANTITIES.join(", "))));
    }
    // TM-27 has no field for a unit; the writer leaves it in the comments.
    let comments = draft.header.get("Comments").and_then(Value::as_str);
    let unit = comments.and_then(|comments| comments.rsplit_once(UNIT_COMMENT));
    draft.unit = unit.map(|(_, unit)| unit.trim().to_owned());
    let file = draft.finish(&mut findings);
    Parsed::new(Format::SPDX, Kind::Spectrum, file, findings)
}

/// Namespace and version of the root element.
fn attribute(key: &str, value: &str, root: &Element, findings: &mut Findings) {
    let finding = match key {
        "xmlns" if !NAMESPACES.contains(&value) => {
            Finding::warning("spdx-namespace", "this is no namespace of TM-27-14").assumed(NAMESPACES[0])
        }
        "version" if value != "1.0" => Finding::note("spdx-version", "the version is not 1.0"),
        _ => return,
    };
    findings.push(finding.at(root.line, root.column).raw(value));
}

/// One wavelength and its value; none where one of them is no number.
fn point(element: &Element, findings: &mut Findings) -> Option<Point> {
    let (line, column) = (element.line, element.column);
    let mut read = |raw: &str, what: &str| match number::read_up_to(raw, number::LARGEST_SPECTRAL) {
        Ok(number) => {
            if number.comma {
                let finding = Finding::warning("spdx-decimal-comma", "XML numbers have a decimal point");
                findings.push(finding.at(line, column).raw(raw).assumed("a decimal comma"));
            }
            Some(number.value)
        }
        Err(error) => {
            let finding = Finding::error("spdx-number", format!("{what}: {error}")).at(line, column);
            findings.push(finding.raw(raw).fix("write the number that was measured"));
            None
        }
    };
    let x = read(element.attribute(&["wavelength"]).unwrap_or(""), "wavelength");
    let value = read(&element.text, "value");
    Some(Point {
        line,
        column,
        x: x?,
        value: vec![Some(value?)],
    })
}
