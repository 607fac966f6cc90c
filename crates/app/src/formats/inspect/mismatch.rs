//! A lux meter whose responsivity is known, and the light that it was calibrated with.

use camino::Utf8Path;
use isolux_formats::{Content, Finding, ReadOptions, Severity};
use isolux_spectrum::meter::{self, NoMismatch};
use isolux_spectrum::{Spectrum, illuminant};

use super::read::read;
use crate::Failure;

/// A meter's responsivity and the light of its calibration.
#[derive(Debug, Clone)]
pub struct Meter {
    responsivity: Spectrum,
    calibration: Spectrum,
    findings: Vec<Finding>,
}

impl Meter {
    /// Reads the responsivity, and the light that the meter was calibrated with; without one that is CIE illuminant A.
    ///
    /// # Errors
    /// A file that holds no spectrum, or one with an error; the message says which finding.
    pub fn read(responsivity: &Utf8Path, calibration: Option<&Utf8Path>) -> Result<Self, Failure> {
        let mut findings = Vec::new();
        let responsivity = spectrum(responsivity, &mut findings)?;
        let calibration = match calibration {
            Some(path) => spectrum(path, &mut findings)?,
            None => Spectrum::from_1_nm(&illuminant::illuminant_a())
                .ok_or_else(|| Failure::bad_input("illuminant A is no spectrum"))?,
        };
        Ok(Self {
            responsivity,
            calibration,
            findings,
        })
    }

    /// The spectral mismatch correction factor for `source`, by which a reading is multiplied (ISO/CIE 19476).
    ///
    /// # Errors
    /// The meter does not see one of the two lights, or one of them has none.
    pub fn mismatch(&self, source: &Spectrum) -> Result<f64, NoMismatch> {
        meter::spectral_mismatch(source, &self.calibration, &self.responsivity)
    }

    /// What was found in the meter's own files, each with file and line in its message: they stand beside those of a
    /// source.
    pub fn findings(&self) -> &[Finding] {
        &self.findings
    }
}

/// The one spectrum of a file, and what was found in it.
///
/// # Errors
/// A file that holds none or several, or one with an error.
pub(super) fn spectrum(path: &Utf8Path, findings: &mut Vec<Finding>) -> Result<Spectrum, Failure> {
    let refuse = |why: &str| Failure::bad_input(format!("{path}: {why}")).help("isolux inspect names every finding");
    let mut all = read(path, ReadOptions::default()).map_err(|finding| refuse(&finding.message))?;
    if all.len() != 1 {
        return Err(refuse("one spectrum is needed"));
    }
    let parsed = all.remove(0);
    let error = parsed
        .findings
        .iter()
        .find(|finding| finding.severity == Severity::Error);
    if let Some(finding) = error {
        return Err(refuse(&finding.message));
    }
    let Some(Content::Spectrum(file)) = parsed.document else {
        return Err(refuse("this is no spectrum"));
    };
    findings.extend(parsed.findings.into_iter().map(|finding| of_file(path, finding)));
    file.spectrum().map_err(|error| refuse(&error.to_string()))
}

/// A finding of the meter's file among those of another: its place goes into the message.
fn of_file(path: &Utf8Path, finding: Finding) -> Finding {
    let mut place = path.to_string();
    for at in [finding.line, finding.column.map(|column| column.get() as usize)]
        .into_iter()
        .flatten()
    {
        place.push_str(&format!(":{at}"));
    }
    Finding {
        line: None,
        column: None,
        bytes: None,
        message: format!("{place}: {}", finding.message).into(),
        ..finding
    }
}
