//! Why a record of a standard lamp gives no calibration.

use isolux_record::spectra::SpectrumError;

/// Why a record of a standard lamp gives no calibration: what was found, what was needed, what to do.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum CalibrationError {
    /// The scan is not finished.
    #[error("the scan of the standard is not finished; resume it")]
    Unfinished,
    /// The certificate has no such values.
    #[error("the certificate states no {0}; give the one that does")]
    NotCertified(&'static str),
    /// The run was after the last day of the certificate.
    #[error("the certificate expired on {expires}, and the record is of {day}; have the lamp calibrated")]
    Expired {
        /// Its last day.
        expires: String,
        /// The day of the record.
        day: String,
    },
    /// The run was before the certificate.
    #[error("the certificate was issued on {issued}, after the record of {day}; look at the clock of the computer")]
    NotYetIssued {
        /// Day of issue.
        issued: String,
        /// The day of the record.
        day: String,
    },
    /// Nothing measured the current.
    #[error("no reading of the lit lamp has its current; give the station a [powermeter]")]
    NoCurrent,
    /// The lamp did not have its current.
    #[error(
        "reading {row}: the lamp had {found_a:.4} A; the certificate is of {certified_a:.4} A ± {tolerance_a:.4} A; \
         set the current and begin again"
    )]
    Current {
        /// Number of the row of readings.csv.
        row: u64,
        /// Its current.
        found_a: f64,
        /// That of the certificate.
        certified_a: f64,
        /// How far from it it may be.
        tolerance_a: f64,
    },
    /// An uncertainty that the station does not state.
    #[error("the station does not state {0}, without which the calibration has no uncertainty")]
    Missing(&'static str),
    /// Too far from the distance of the certificate.
    #[error(
        "read at {found_mm} mm, certified at {certified_mm} mm: the inverse square law is trusted up to a ratio of \
         {most}; go nearer to the certified distance"
    )]
    Distance {
        /// Distance of the readings.
        found_mm: f64,
        /// That of the certificate.
        certified_mm: f64,
        /// The largest ratio.
        most: f64,
    },
    /// A part of the procedure is not in the record.
    #[error("the record has no {0}")]
    NoPart(&'static str),
    /// A pixel was full.
    #[error("{file}: saturated at {wavelength_nm} nm; take a lower peak_counts_rel or go farther away")]
    Saturated {
        /// File of the spectrum in the run.
        file: String,
        /// First such wavelength.
        wavelength_nm: f64,
    },
    /// A reading of the lux meter without a number.
    #[error("reading {row}: {quality}; choose a distance within the ranges of the meter")]
    NoNumber {
        /// Number of the row of readings.csv.
        row: u64,
        /// What the meter said.
        quality: String,
    },
    /// Rates at two integration times differ.
    #[error(
        "not linear: pixels at {of_full_scale:.0} % of full scale count {difference:+.2} % more per second at \
         {short_s} s than at {long_s} s, {allowed:.2} % are allowed; the instrument needs another linearity polynomial",
        of_full_scale = 100.0 * of_full_scale, difference = 100.0 * difference_rel, allowed = 100.0 * allowed_rel
    )]
    Nonlinear {
        /// Mean of the pixels in the brighter spectrum.
        of_full_scale: f64,
        /// Rate of the darker spectrum over that of the brighter one, less 1.
        difference_rel: f64,
        /// What noise, drift and [`LINEARITY_MAX_REL`](super::LINEARITY_MAX_REL) allow.
        allowed_rel: f64,
        /// Integration time of the darker spectrum.
        short_s: f64,
        /// That of the brighter one.
        long_s: f64,
    },
    /// The lamp's light changed.
    #[error(
        "the light changed by {change:+.2} % from the first reading to the last, {limit:.2} % are allowed; let the \
         lamp settle and begin again",
        change = 100.0 * change_rel, limit = 100.0 * limit_rel
    )]
    Unsteady {
        /// Last over first, less 1.
        change_rel: f64,
        /// `reference_rel` of the plan.
        limit_rel: f64,
    },
    /// The table of the certificate is no filament's.
    #[error(
        "the certificate's value at {wavelength_nm} nm is {off:+.2} % off a filament's curve through the others, its \
         u is {u:.2} %; compare the table with the paper",
        off = 100.0 * off_rel, u = 100.0 * u_rel
    )]
    Shape {
        /// Where.
        wavelength_nm: f64,
        /// Value over curve, less 1.
        off_rel: f64,
        /// Its relative standard uncertainty.
        u_rel: f64,
    },
    /// No wavelengths with enough light within the table.
    #[error("only {0} pixels have enough light within the certificate's wavelengths; go nearer or read longer")]
    Dark(usize),
    /// The lamp is not near illuminant A.
    #[error("the standard has {found_k} K; a lux meter is calibrated within {tolerance_k} K of illuminant A, 2856 K")]
    ColourTemperature {
        /// That of the certificate.
        found_k: f64,
        /// How far from 2856 K it may be.
        tolerance_k: f64,
    },
    /// The instrument has no calibration in the record, and so no saturation and no linearity.
    #[error("the record has no spectroradiometer")]
    NoSpectroradiometer,
    /// The instrument's linearity polynomial.
    #[error(transparent)]
    Polynomial(#[from] SpectrumError),
}

impl CalibrationError {
    /// Whether the certificate or the station is at fault, and not what was measured.
    pub fn is_input(&self) -> bool {
        matches!(
            self,
            Self::NotCertified(_)
                | Self::Expired { .. }
                | Self::NotYetIssued { .. }
                | Self::Missing(_)
                | Self::Shape { .. }
                | Self::ColourTemperature { .. }
                | Self::NoSpectroradiometer
        )
    }
}
