//! A lux meter whose responsivity is known, and the light that it was calibrated with.

use camino::Utf8Path;
use isolux_formats::{Content, ReadOptions, Severity};
use isolux_spectrum::{Spectrum, illuminant, meter};

use crate::Failure;

/// A meter's responsivity and the light of its calibration.
#[derive(Debug, Clone)]
pub struct Meter {
    responsivity: Spectrum,
    calibration: Spectrum,
}

impl Meter {
    /// Reads the responsivity, and the light that the meter was calibrated with; without one that is CIE illuminant A.
    ///
    /// # Errors
    /// A file that holds no spectrum, or one with an error; the message says which finding.
    pub fn read(responsivity: &Utf8Path, calibration: Option<&Utf8Path>) -> Result<Self, Failure> {
        let calibration = match calibration {
            Some(path) => spectrum(path)?,
            None => Spectrum::from_1_nm(&illuminant::illuminant_a())
                .ok_or_else(|| Failure::bad_input("illuminant A is no spectrum"))?,
        };
        Ok(Self {
            responsivity: spectrum(responsivity)?,
            calibration,
        })
    }

    /// The spectral mismatch correction factor for `source`, by which a reading is multiplied (ISO/CIE 19476); none where
    /// the meter does not answer one of the two lights.
    pub fn mismatch(&self, source: &Spectrum) -> Option<f64> {
        meter::spectral_mismatch(source, &self.calibration, &self.responsivity)
    }
}

fn spectrum(path: &Utf8Path) -> Result<Spectrum, Failure> {
    let refuse = |why: &str| Failure::bad_input(format!("{path}: {why}")).help("isolux inspect names every finding");
    let mut all = super::read(path, ReadOptions::default()).map_err(|finding| refuse(&finding.message))?;
    if all.len() != 1 {
        return Err(refuse("one spectrum is needed"));
    }
    let parsed = all.remove(0);
    let error = parsed
        .findings
        .iter()
        .find(|finding| finding.severity == Severity::Error);
    match (error, parsed.document) {
        (Some(finding), _) => Err(refuse(&finding.message)),
        (None, Some(Content::Spectrum(file))) => file.spectrum().map_err(|error| refuse(&error.to_string())),
        _ => Err(refuse("this is no spectrum")),
    }
}
