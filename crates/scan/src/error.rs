//! How a scan fails.

use isolux_device::DeviceError;
use isolux_record::document::Fault;
use isolux_record::run::RunError;
use isolux_record::spectra::SpectrumError;

/// Why a scan ended before its plan.
#[derive(Debug, thiserror::Error)]
pub enum ScanError {
    /// The plan asks what the station cannot do; nothing moved.
    #[error("{0}")]
    Plan(#[from] Fault),
    /// An instrument failed.
    #[error("{role}: {source}")]
    Device {
        /// Its part in the bench.
        role: &'static str,
        /// What happened.
        source: DeviceError,
    },
    /// An axis stands elsewhere than it was sent.
    #[error("{role} stands at {found_deg}, sent to {target_deg} (tolerance {tolerance_deg}; degrees, mm for the rail)")]
    Position {
        /// The axis.
        role: &'static str,
        /// Where it was sent.
        target_deg: f64,
        /// Where it stands.
        found_deg: f64,
        /// What would be allowed.
        tolerance_deg: f64,
    },
    /// The lamp did not become stable.
    #[error(
        "the lamp is not stable after {elapsed_s:.0} s: (max − min)/mean = {:.2} % over the last {window_s:.0} s, allowed {:.2} %",
        spread_rel * 100.0, allowed_rel * 100.0
    )]
    NotStable {
        /// Seconds since it was switched on.
        elapsed_s: f64,
        /// Length of the window.
        window_s: f64,
        /// (max − min) ÷ mean over it.
        spread_rel: f64,
        /// Allowed.
        allowed_rel: f64,
    },
    /// No light at the reference point: a warm-up cannot be judged.
    #[error("the lamp gives {illuminance_lx} lx at the reference point (C 0°, γ 0°); is it on, and is the path free?")]
    NoLight {
        /// What was read.
        illuminance_lx: f64,
    },
    /// The spectroradiometer's signal does not fit its range.
    #[error(
        "the spectroradiometer finds no exposure: {peak_counts:.0} counts of {saturation_counts:.0} at {integration_s} s"
    )]
    Exposure {
        /// Highest raw counts.
        peak_counts: f64,
        /// Saturation.
        saturation_counts: f64,
        /// Integration time.
        integration_s: f64,
    },
    /// A person said no.
    #[error("`{prompt}` was declined: {reason}")]
    Declined {
        /// What was asked.
        prompt: String,
        /// Why not.
        reason: String,
    },
    /// The record could not be written.
    #[error(transparent)]
    Record(#[from] RunError),
    /// The counts give no irradiance.
    #[error(transparent)]
    Spectrum(#[from] SpectrumError),
    /// The program itself failed; the axes were stopped first.
    #[error("a defect of the program ended the scan: {message}")]
    Panicked {
        /// What it said.
        message: String,
    },
    /// The end was asked for; the axes were stopped first.
    #[error("interrupted ({reason}) after {readings} readings; the axes are at rest")]
    Interrupted {
        /// By whom.
        reason: String,
        /// Readings recorded.
        readings: u64,
    },
    /// An axis could not be verified at rest. Wins over whatever came before.
    #[error("{}{before}", not_at_rest(axes))]
    NotAtRest {
        /// The axes and why.
        axes: Vec<(&'static str, DeviceError)>,
        /// What had happened before, as a sentence.
        before: String,
    },
}

/// What decides the exit code.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum ScanErrorKind {
    /// Bad input.
    BadPlan,
    /// The answer is no: a gate stays shut.
    Gate,
    /// An instrument or the system failed.
    Instrument,
    /// Somebody asked for the end.
    Interrupted,
}

impl ScanError {
    /// The kind.
    pub const fn kind(&self) -> ScanErrorKind {
        match self {
            Self::Plan(_)
            | Self::Record(
                RunError::Occupied { .. }
                | RunError::NoRun { .. }
                | RunError::Changed { .. }
                | RunError::HeaderChanged { .. }
                | RunError::Damaged { .. },
            ) => ScanErrorKind::BadPlan,
            Self::NotStable { .. } | Self::NoLight { .. } | Self::Declined { .. } => ScanErrorKind::Gate,
            Self::Interrupted { .. } => ScanErrorKind::Interrupted,
            Self::Device { .. }
            | Self::Position { .. }
            | Self::Exposure { .. }
            | Self::Panicked { .. }
            | Self::Record(_)
            | Self::Spectrum(_)
            | Self::NotAtRest { .. } => ScanErrorKind::Instrument,
        }
    }

    pub(crate) fn device(role: &'static str) -> impl Fn(DeviceError) -> Self {
        move |source| Self::Device { role, source }
    }
}

fn not_at_rest(axes: &[(&'static str, DeviceError)]) -> String {
    let names: Vec<String> = axes
        .iter()
        .map(|(role, error)| format!("{role} could not be verified at rest ({error})"))
        .collect();
    format!("{}; SWITCH THE AXES OFF BY HAND", names.join("; "))
}
