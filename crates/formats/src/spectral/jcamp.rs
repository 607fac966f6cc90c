//! JCAMP-DX is refused, with the reason.

use super::{SpectrumFile, refused};
use crate::finding::{Finding, Findings};
use crate::read::Parsed;
use crate::text::Text;

use super::axis::AxisUnit;

/// Whether a labelled data record opens the file.
pub(super) fn looks_like(text: &Text<'_>) -> bool {
    text.lines()
        .take(40)
        .filter(|line| !line.trim().is_empty())
        .take(1)
        .any(|line| line.trim_start().starts_with("##") && line.contains('='))
        && text
            .lines()
            .take(400)
            .any(|line| line.to_ascii_uppercase().replace(' ', "").starts_with("##JCAMP"))
}

/// Says what stands on the abscissa and that it is not read.
pub(super) fn read(text: &Text<'_>, mut findings: Findings) -> Parsed<SpectrumFile> {
    let units = text.lines().enumerate().find_map(|(index, line)| {
        let (label, value) = line.trim_start().strip_prefix("##")?.split_once('=')?;
        (label.replace([' ', '_', '-'], "").eq_ignore_ascii_case("XUNITS"))
            .then(|| (index + 1, value.trim().to_owned()))
    });
    let finding = match &units {
        Some((line, unit)) => {
            let message = match AxisUnit::of(unit) {
                Some(AxisUnit::Other(name)) => {
                    format!("JCAMP-DX with an abscissa in {name}: this is no spectrum over wavelength")
                }
                Some(axis) => format!("JCAMP-DX is not read (its abscissa is in {})", axis.name()),
                None => "JCAMP-DX without a wavelength axis: this is no spectrum over wavelength".to_owned(),
            };
            Finding::error("jcamp-refused", message).at(*line, 1).raw(unit)
        }
        None => Finding::error(
            "jcamp-refused",
            "JCAMP-DX without a wavelength axis: this is no spectrum over wavelength",
        )
        .at(1, 1)
        .raw(text.line(0)),
    };
    findings.push(finding.fix("export the spectrum as CSV with wavelengths in nm"));
    refused(None, findings)
}
