//! Why a record gives no distribution or spectrum.

use isolux_record::Quality;

/// Why a record cannot be reduced.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum ReduceError {
    /// No lit reading at a point of the plan.
    #[error("the run holds no lit readings at its points: nothing to reduce")]
    NothingLit,
    /// A point of the grid without a usable reading.
    #[error(
        "C {c_deg}° γ {gamma_deg}° has no usable reading ({found}); finish the scan, or read the point again in another range"
    )]
    Missing {
        /// C of the point.
        c_deg: f64,
        /// γ of the point.
        gamma_deg: f64,
        /// What is there instead.
        found: &'static str,
    },
    /// The grid has too few angles.
    #[error("the lit readings cover {c_planes} C planes and {gammas} γ; two γ are the least")]
    TooFew {
        /// Half-planes found.
        c_planes: usize,
        /// γ found.
        gammas: usize,
    },
    /// The corrected readings make no valid distribution.
    #[error("the corrected readings make no distribution: {0}")]
    Distribution(#[from] isolux_photometry::DistributionError),
    /// The lamp's flux is not above zero.
    #[error("the corrected readings integrate to {flux_lm} lm: there is no luminaire in them")]
    NoFlux {
        /// The integral.
        flux_lm: f64,
    },
    /// A spectrum that cannot be used.
    #[error("spectrum {index} of the run: {message}")]
    Spectrum {
        /// Its number.
        index: u64,
        /// What is wrong with it.
        message: String,
    },
    /// A file of results that its format refuses.
    #[error("{file}: {message}")]
    File {
        /// The file.
        file: &'static str,
        /// What the writer says.
        message: String,
    },
}

/// A quality in the words of [`ReduceError::Missing`].
pub(crate) const fn without_number(quality: Option<Quality>) -> &'static str {
    match quality {
        None => "never read",
        Some(Quality::Ok) => "ok, but without a number",
        Some(Quality::OverRange) => "over range",
        Some(Quality::UnderRange) => "under range",
        Some(Quality::Failed) => "the meter failed",
    }
}
