//! Why a run gives no result.

use isolux_photometry::{DistributionError, NotRound};
use isolux_record::spectra::SpectrumError;

/// Why a run gives no distribution or no spectrum. Nothing is written then: no file that looks whole.
#[derive(Debug, thiserror::Error)]
pub enum ReduceError {
    /// There is nothing to reduce.
    #[error("the run has no lit readings of the lux meter over γ: there is no distribution in it")]
    NoLight,
    /// The displacement of the light of sweeps against the positions is not known.
    #[error(
        "block `{block}` was read in motion, and its first half-plane does not show by how much its light is displaced against the \
         positions: it was not swept in both directions, or has no slope; go on with --resume, or choose a first half-plane with light"
    )]
    Sweeps {
        /// The block.
        block: String,
    },
    /// A Monte Carlo of a scan in motion.
    #[error(
        "the inputs of a scan in motion are not drawn: the samples of a sweep depend on each other; use a run at rest"
    )]
    NotDrawn,
    /// No sweep has light at a direction.
    #[error(
        "block `{block}`: no sweep of the half-plane C {c_deg}° has light near γ {gamma_deg}°, as its conversions there are lost or \
         damaged; look at the meter and its line, and measure the half-plane again"
    )]
    NoSweep {
        /// The block.
        block: String,
        /// Half-plane of the plan.
        c_deg: f64,
        /// Its first direction without light.
        gamma_deg: f64,
    },
    /// A point of the grid has no number.
    #[error(
        "{missing} of {expected} directions have no reading with a number, the first at C {c_deg}°, γ {gamma_deg}°; \
         take the scan up again with --resume, or measure them"
    )]
    Missing {
        /// Directions without a number.
        missing: usize,
        /// Directions of the grid.
        expected: usize,
        /// The first of them.
        c_deg: f64,
        /// The first of them.
        gamma_deg: f64,
    },
    /// The lit readings are no grid over C and γ.
    #[error("the lit blocks do not make one grid: half-plane C {c_deg}° has {found} γ, others have {expected}")]
    NoGrid {
        /// The half-plane.
        c_deg: f64,
        /// Its γ.
        found: usize,
        /// γ of the grid.
        expected: usize,
    },
    /// The half-planes leave a part of the circle out.
    #[error(transparent)]
    NotRound(#[from] NotRound),
    /// The scan of the distribution ended in its first half-plane.
    #[error(
        "{found} of the {planned} directions of the distribution were read and no half-plane is whole; go on with --resume"
    )]
    Unfinished {
        /// Directions that were read.
        found: usize,
        /// Directions of the plan.
        planned: usize,
    },
    /// An axis was read back far from where it was sent.
    #[error("row {row}: read back at C {c_deg}°, γ {gamma_deg}°, far from the plan's direction")]
    Astray {
        /// Number of the row.
        row: u64,
        /// Read-back C.
        c_deg: f64,
        /// Read-back γ.
        gamma_deg: f64,
    },
    /// The reference visits give no light to compare with.
    #[error("the reference readings are {illuminance_lx} lx after the corrections: drift cannot be taken from them")]
    DarkReference {
        /// Their mean.
        illuminance_lx: f64,
    },
    /// Lamp or bench did not stay as they were.
    #[error("{}", crate::finding::sentences(.findings))]
    Unsteady {
        /// What does not agree, with its rows.
        findings: Vec<crate::finding::Finding>,
    },
    /// The spectrum is saturated where light is.
    #[error("spectrum {index} is saturated at {pixels} pixels, the first at {wavelength_nm} nm")]
    Saturated {
        /// Number of the spectrum.
        index: u64,
        /// How many pixels.
        pixels: usize,
        /// The first.
        wavelength_nm: f64,
    },
    /// A spectrum without a calibrated part.
    #[error("spectrum {index}: the calibration covers none of the visible wavelengths")]
    Uncalibrated {
        /// Number of the spectrum.
        index: u64,
    },
    /// The run has spectra, but run.toml no calibration for them.
    #[error("run.toml has no [spectral] calibration, but the run has spectra")]
    NoCalibration,
    /// The counts give no irradiance.
    #[error(transparent)]
    Spectrum(#[from] SpectrumError),
    /// The intensities are no distribution.
    #[error(transparent)]
    Distribution(#[from] DistributionError),
    /// The spectrum is none.
    #[error(transparent)]
    InvalidSpectrum(#[from] isolux_spectrum::SpectrumError),
    /// The measured light has no flux above zero.
    #[error("the luminous flux is {flux_lm} lm: there is no light in this run")]
    NoFlux {
        /// The flux.
        flux_lm: f64,
    },
    /// A format cannot hold the result.
    #[error("{file}: {message}")]
    Format {
        /// Name of the result.
        file: &'static str,
        /// Why.
        message: String,
    },
}
