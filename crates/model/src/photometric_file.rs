//! The distribution and spectrum files that a model names.

use camino::{Utf8Path, Utf8PathBuf};
use isolux_formats::{Content, Distribution, Finding, LARGEST_FILE, Severity, read_any};
use isolux_photometry::IntensityDistribution;
use isolux_record::file::{self, FileError};
use isolux_spectrum::{Spectrum, SpectrumError};

/// Why a file that a model names cannot be used.
#[derive(Debug, thiserror::Error)]
pub enum PhotometricFileError {
    /// The operating system refused.
    #[error("{path}: {source}")]
    Read {
        /// The file.
        path: Utf8PathBuf,
        /// What the system says, or what else stands there.
        source: FileError,
    },
    /// The reader found an error: a number from such a file is not to be trusted.
    #[error("{path}{}: {message}", line.map_or(String::new(), |line| format!(":{line}")))]
    Finding {
        /// The file.
        path: Utf8PathBuf,
        /// One-based line.
        line: Option<usize>,
        /// What is wrong and how to correct it.
        message: String,
    },
    /// Numbers that make no spectrum.
    #[error("{path}: {source}")]
    Spectrum {
        /// The file.
        path: Utf8PathBuf,
        /// What is wrong.
        source: SpectrumError,
    },
}

/// The absolute intensity distribution of a photometric file, or of a CSV `gamma_deg,intensity_cd` for a rotational
/// one.
///
/// # Errors
/// [`PhotometricFileError`] with file and line; also for a file that can be read but has a finding of level error.
pub fn read_distribution(path: &Utf8Path) -> Result<IntensityDistribution, PhotometricFileError> {
    let bytes = read(path)?;
    let (document, findings) =
        Distribution::load(&bytes, path.file_name().unwrap_or("")).map_err(|findings| first(path, &findings))?;
    if findings.iter().any(is_error) {
        return Err(first(path, &findings));
    }
    Ok(document.intensity)
}

/// The spectrum of a `.spdx`, `.spd`, `.sp`, `.spectrum` or CSV file: its first series.
///
/// # Errors
/// [`PhotometricFileError`] with file and line; also for a file that can be read but has a finding of level error.
pub fn read_spectrum(path: &Utf8Path) -> Result<Spectrum, PhotometricFileError> {
    let bytes = read(path)?;
    let refuse = |message: &str| PhotometricFileError::Finding {
        path: path.to_owned(),
        line: None,
        message: message.to_owned(),
    };
    let mut parsed = read_any(&bytes, path.file_name().unwrap_or(""));
    if parsed.len() != 1 {
        return Err(refuse(
            "the file holds several photometries or spectra; one spectrum is needed",
        ));
    }
    let only = parsed.remove(0);
    if only.findings.iter().any(is_error) {
        return Err(first(path, &only.findings));
    }
    match only.document {
        Some(Content::Spectrum(file)) => {
            Spectrum::new(file.wavelength_nm, file.value).map_err(|source| PhotometricFileError::Spectrum {
                path: path.to_owned(),
                source,
            })
        }
        Some(Content::Distribution(_)) => Err(refuse("the file holds a distribution, not a spectrum")),
        None => Err(first(path, &only.findings)),
    }
}

fn read(path: &Utf8Path) -> Result<Vec<u8>, PhotometricFileError> {
    file::read(path, LARGEST_FILE as u64).map_err(|source| PhotometricFileError::Read {
        path: path.to_owned(),
        source,
    })
}

fn is_error(finding: &Finding) -> bool {
    finding.severity == Severity::Error
}

/// The first error among the findings.
fn first(path: &Utf8Path, findings: &[Finding]) -> PhotometricFileError {
    let (line, message) = match findings.iter().find(|finding| is_error(finding)) {
        Some(finding) => {
            let fix = finding.fix.as_ref().map_or(String::new(), |fix| format!("; {fix}"));
            (finding.line, format!("{}{fix}", finding.message))
        }
        None => (None, "the file cannot be read".to_owned()),
    };
    PhotometricFileError::Finding {
        path: path.to_owned(),
        line,
        message,
    }
}
