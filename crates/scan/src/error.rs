//! How a scan fails.

use isolux_device::{DeviceError, ErrorKind};
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
    #[error("{role} stands at {found}{unit}, sent to {target}{unit} (tolerance {tolerance}{unit})")]
    Position {
        /// The axis.
        role: &'static str,
        /// Where it was sent.
        target: f64,
        /// Where it stands.
        found: f64,
        /// What would be allowed.
        tolerance: f64,
        /// The unit, as it follows a number.
        unit: &'static str,
    },
    /// The lamp did not become stable.
    #[error(
        "the lamp is not stable after {elapsed_s:.0} s: (max − min)/mean of its {of} = {:.2} % over the last {window_s:.0} s, allowed {:.2} %",
        spread_rel * 100.0, allowed_rel * 100.0
    )]
    NotStable {
        /// `light` or `power`.
        of: &'static str,
        /// Seconds since it was switched on.
        elapsed_s: f64,
        /// Length of the window.
        window_s: f64,
        /// (max − min) ÷ mean over it.
        spread_rel: f64,
        /// Allowed.
        allowed_rel: f64,
    },
    /// No power that the meter can follow: the electrical stability cannot be judged.
    #[error(
        "after {elapsed_s:.0} s the power meter gives no power: it is over its range, or no two of its readings in a row agree; \
         look at its ranges, or remove [powermeter] from the station"
    )]
    NoPower {
        /// Seconds since the lamp was switched on.
        elapsed_s: f64,
    },
    /// No light at the reference point that the meter can follow: a warm-up cannot be judged.
    #[error(
        "the lamp gives {illuminance_lx:.3} lx at the reference point (C 0°, γ 0°), and less than {least_lx:.3} lx, ten digits \
         of the display, shows no stability; is the lamp on, the path free, and the detector near enough?"
    )]
    NoLight {
        /// What was read.
        illuminance_lx: f64,
        /// What is needed.
        least_lx: f64,
    },
    /// No number at the reference point: a warm-up cannot be judged.
    #[error(
        "the lux meter is {word} at the reference point (C 0°, γ 0°) and gives no number; is the lamp on, the path free, and \
         the detector at the right distance?"
    )]
    NoNumber {
        /// `over range` or `under range`.
        word: &'static str,
    },
    /// An axis, the rail or an output is not as it was left.
    #[error(
        "{role} was left {expected} and is {found}: another program or a person has moved or switched it; what was read \
         meanwhile is not recorded"
    )]
    Disturbed {
        /// Which.
        role: &'static str,
        /// How it was left.
        expected: String,
        /// How it was found.
        found: String,
    },
    /// Repeats of a point do not agree.
    #[error(
        "the readings at C {c_deg}°, γ {gamma_deg}° do not agree: {value_lx:.3} lx beside a median of {median_lx:.3} lx, \
         allowed ± {allowed_lx:.3} lx (limits.repeats_sigma of the plan); axes and outputs are as they should be, so look at \
         the lamp's supply, the room's light and the meter"
    )]
    Repeats {
        /// Target C.
        c_deg: f64,
        /// Target γ.
        gamma_deg: f64,
        /// The one that is outside.
        value_lx: f64,
        /// Median of all.
        median_lx: f64,
        /// Allowed distance from it.
        allowed_lx: f64,
    },
    /// A sweep was disturbed, or too much of its light is missing. It is in the record as evidence.
    #[error(
        "the sweep at C {c_deg}° is torn: {why}; look at the meter and its line, or measure with a slower `speed_deg_s`"
    )]
    Torn {
        /// Target C.
        c_deg: f64,
        /// Why.
        why: String,
    },
    /// Further sweeps have not filled the gaps of those before.
    #[error(
        "block `{block}`: {again} further sweeps have not filled the gaps that lost and damaged answers have left at {planes}; \
         look at the meter and its line, and go on with --resume"
    )]
    Gaps {
        /// Name of the block.
        block: String,
        /// Further sweeps that were made.
        again: u32,
        /// The half-planes, with their first γ without light.
        planes: String,
    },
    /// Rings show that the light does not have the symmetry that half-planes assume.
    #[error(
        "block `{block}`: its half-planes assume a lamp that is symmetric ({symmetry}), and rings differ from that \
         by {:.2} % of the largest light at C {c_deg}°, γ {gamma_deg}°; the plan allows {:.2} %. Look at how the \
         lamp hangs, measure half-planes all round, or allow more with `symmetry_max_rel`",
        100.0 * found_rel,
        100.0 * most_rel
    )]
    NotSymmetric {
        /// Name of the block.
        block: String,
        /// The symmetry, as words.
        symmetry: &'static str,
        /// The largest difference, in shares of the largest light.
        found_rel: f64,
        /// There: C, degrees.
        c_deg: f64,
        /// There: γ, degrees.
        gamma_deg: f64,
        /// What the plan allows.
        most_rel: f64,
    },
    /// Spectra of one point do not agree.
    #[error(
        "the spectra of one point do not agree: {found:.0} counts above the dark level beside a median of {median:.0}, \
         allowed ± {allowed:.0} (limits of the plan)"
    )]
    Spectra {
        /// Sum over all pixels of the one that is outside.
        found: f64,
        /// Median of all.
        median: f64,
        /// Allowed distance from it.
        allowed: f64,
    },
    /// The reference point does not give what it gave at the visit before.
    #[error("{}", reference(*found_lx, *expected_lx, *allowed_lx, *allowed_rel))]
    Reference {
        /// What it gave now; none without a number.
        found_lx: Option<f64>,
        /// What it gave before, at the last visit or when the lamp was stable; none where this is the first visit.
        expected_lx: Option<f64>,
        /// Allowed distance from that, the digit included.
        allowed_lx: f64,
        /// `limits.reference_rel` of the plan.
        allowed_rel: f64,
    },
    /// The light at the reference point drifted slowly, and farther than is corrected.
    #[error(
        "the reference point (C 0°, γ 0°) gives {found_lx:.3} lx, and its visits reach {:+.2} % from their median of \
         {middle_lx:.3} lx: allowed ± {:.2} % (limits.drift_rel) and one digit, for a larger drift is not corrected; let lamp \
         and room come back, and go on",
        change_rel * 100.0, allowed_rel * 100.0
    )]
    Drifted {
        /// What it gave now.
        found_lx: f64,
        /// Median of its visits since the lamp was switched on, this one among them; where that is the level of another
        /// burning, of its visits.
        middle_lx: f64,
        /// Of the visit that is farthest from the median, or of the burning, relative to it.
        change_rel: f64,
        /// `limits.drift_rel` of the plan.
        allowed_rel: f64,
    },
    /// The program did not run all the time, and what it did meanwhile counts for nothing.
    #[error(
        "the program was stopped, or the computer slept, {most} times during one step: keep the computer awake, and go on"
    )]
    Slept {
        /// Sleeps during one step after which the scan ends.
        most: u32,
    },
    /// A block needs a spectroradiometer, and none was opened.
    #[error("the bench has no spectroradiometer")]
    NoSpectroradiometer,
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
    /// The answer is no: a check fails.
    NotAccepted,
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
                | RunError::OtherFormat { .. }
                | RunError::Damaged { .. },
            ) => ScanErrorKind::BadPlan,
            Self::NotSymmetric { .. }
            | Self::NotStable { .. }
            | Self::NoPower { .. }
            | Self::NoLight { .. }
            | Self::NoNumber { .. }
            | Self::Repeats { .. }
            | Self::Spectra { .. }
            | Self::Reference { .. }
            | Self::Drifted { .. }
            | Self::Slept { .. }
            | Self::Declined { .. } => ScanErrorKind::NotAccepted,
            Self::Interrupted { .. } => ScanErrorKind::Interrupted,
            Self::Device { .. }
            | Self::Position { .. }
            | Self::Disturbed { .. }
            | Self::Torn { .. }
            | Self::Gaps { .. }
            | Self::NoSpectroradiometer
            | Self::Exposure { .. }
            | Self::Panicked { .. }
            | Self::Record(_)
            | Self::Spectrum(_)
            | Self::NotAtRest { .. } => ScanErrorKind::Instrument,
        }
    }

    /// Whether the same visit may succeed when it is made again: nothing is broken, but what was read is not to be
    /// trusted.
    pub(crate) const fn can_be_measured_again(&self) -> bool {
        matches!(
            self,
            Self::Position { .. }
                | Self::Disturbed { .. }
                | Self::Repeats { .. }
                | Self::Torn { .. }
                | Self::Spectra { .. }
                | Self::Reference { .. }
                | Self::Drifted { .. }
        )
    }

    /// Whether the failure may be that of a program which did not run: its deadlines passed, or a person came
    /// meanwhile.
    pub(crate) const fn may_come_of_a_sleep(&self) -> bool {
        !matches!(
            self,
            Self::Plan(_)
                | Self::Record(_)
                | Self::Spectrum(_)
                | Self::NoSpectroradiometer
                | Self::Declined { .. }
                | Self::Panicked { .. }
                | Self::Interrupted { .. }
        )
    }

    /// Whether a limit of the lamp's light was reached: waiting until it is stable may help.
    pub(crate) const fn is_limit_of_lamp(&self) -> bool {
        matches!(self, Self::Reference { .. } | Self::Drifted { .. })
    }

    pub(crate) fn device(role: &'static str) -> impl Fn(DeviceError) -> Self {
        move |source| Self::Device { role, source }
    }
}

fn reference(found_lx: Option<f64>, expected_lx: Option<f64>, allowed_lx: f64, allowed_rel: f64) -> String {
    let look = "axes and outputs are as they should be, so look at the lamp, its supply, the detector and the path";
    match (found_lx, expected_lx) {
        (Some(found), Some(expected)) => format!(
            "the reference point (C 0°, γ 0°) gives {found:.3} lx, and gave {expected:.3} lx before: allowed \
             ± {allowed_lx:.3} lx (limits.reference_rel = {allowed_rel} and one digit); {look}"
        ),
        _ => format!("the reference point (C 0°, γ 0°) gives no number; {look}"),
    }
}

fn not_at_rest(axes: &[(&'static str, DeviceError)]) -> String {
    let taken_over = |error: &DeviceError| error.kind() == ErrorKind::TakenOver;
    let names = axes.iter().map(|(role, error)| {
        let what = if taken_over(error) {
            "was not stopped"
        } else {
            "could not be verified at rest"
        };
        format!("{role} {what} ({error})")
    });
    let names = names.collect::<Vec<_>>().join("; ");
    // What moves an axis that another process has taken over may be a good scan.
    let what_now = if axes.iter().all(|(_, error)| taken_over(error)) {
        "what the axes do now is up to that process"
    } else {
        "SWITCH THE AXES OFF BY HAND"
    };
    format!("{names}; {what_now}")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_another_process_drives_is_not_to_be_switched_off() {
        let (device, action) = ("zaber:/dev/ttyUSB0", "stop");
        let taken_over = |role| {
            let (device, action) = (device.to_owned(), action.to_owned());
            let reason = "the instrument was taken over by isolux scan".to_owned();
            (role, DeviceError::TakenOver { device, action, reason })
        };
        let words = not_at_rest(&[taken_over("axis.c"), taken_over("axis.gamma")]);
        assert!(
            words.contains("taken over by isolux scan") && !words.contains("BY HAND"),
            "{words}"
        );
        let fault = ("rail", DeviceError::fault(device, action, "it still moves", Vec::new()));
        let words = not_at_rest(&[taken_over("axis.c"), fault]);
        assert!(words.contains("BY HAND"), "an axis that nobody drives: {words}");
    }
}
