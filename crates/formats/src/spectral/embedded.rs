//! A spectrum that a GLDF product lists itself: `<Spectrum><Intensity wavelength="380">0.1</Intensity>…`.

use super::axis::AxisUnit;
use super::file::SpectrumFile;
use super::point::Point;
use super::points::Draft;
use crate::finding::{Finding, Findings};
use crate::number;
use crate::parsed::{Format, Kind, Parsed};
use crate::xml::Element;

/// The spectrum of one element; none where it refers to a file instead.
pub(crate) fn read(spectrum: &Element) -> Option<Parsed<SpectrumFile>> {
    let rows: Vec<&Element> = spectrum
        .children
        .iter()
        .filter(|child| child.name == "Intensity")
        .collect();
    if rows.is_empty() {
        return None;
    }
    let mut findings = Findings::new();
    let mut draft = Draft::new("utf-8");
    draft.axis = Some(AxisUnit::Nanometre);
    for row in rows {
        let mut value = |raw: &str, what: &str| match number::read(raw) {
            Ok(number) => Some(number.value),
            Err(error) => {
                let finding = Finding::error("gldf-spectrum-number", format!("{what}: {error}"));
                findings.push(finding.at(row.line, 1).raw(raw).fix("correct the number"));
                None
            }
        };
        let wavelength = value(row.attribute(&["wavelength"]).unwrap_or(""), "wavelength");
        let intensity = value(&row.text, "intensity");
        match (wavelength, intensity) {
            (Some(x), Some(intensity)) => draft.points.push(Point {
                line: row.line,
                column: 1,
                x,
                value: vec![Some(intensity)],
            }),
            _ => draft.whole = false,
        }
    }
    let document = draft.finish(&mut findings);
    Some(Parsed::new(Format::GLDF, Kind::Spectrum, document, findings))
}
