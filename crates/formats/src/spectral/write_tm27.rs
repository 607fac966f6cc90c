//! TM-27 `.spdx` to the byte.

use std::fmt::Write as _;

use super::file::SpectrumFile;
use super::write::{lost_header, number, other_series, text_of, written};
use crate::finding::Finding;
use crate::parsed::Written;
use crate::xml::escaped;

/// Both namespaces that files carry.
pub(super) const NAMESPACES: [&str; 2] = ["iestm2714", "http://www.ies.org/iestm2714"];

/// The quantities that TM-27 names.
pub(super) const QUANTITIES: [&str; 12] = [
    "absorptance",
    "exitance",
    "flux",
    "intensity",
    "irradiance",
    "radiance",
    "reflectance",
    "relative",
    "transmittance",
    "R-Factor",
    "T-Factor",
    "other",
];

/// In front of the unit among the comments of a TM-27 file.
pub(super) const UNIT_COMMENT: &str = "unit of the values: ";

/// Writes a spectrum.
pub(super) fn tm27(file: &SpectrumFile) -> Written {
    written(|findings| spdx(file, findings))
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
                let _ = writeln!(out, "    <{key}>{}</{key}>", escaped(&text));
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
            let _ = writeln!(out, "    <{key}>{}</{key}>", escaped(&text_of(value)));
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
