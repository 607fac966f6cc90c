//! The grating's second order puts the light of λ/2 on λ.

use super::act::{Act, Instrument};
use super::spec::{BelongsTo, EffectSpec, SPECTRA, Split, amplitude};

/// Second diffraction order.
pub(super) static SPECTRO_2ND: EffectSpec = EffectSpec {
    name: "spectro_2nd",
    standard_name: "second diffraction order",
    sentence: "The second order of the grating puts light of half the wavelength beside the right one[: {fraction:%}].",
    belongs_to: &[BelongsTo::Bench],
    stages: SPECTRA,
    formula: "S + k·S(λ/2)",
    source: "grating equation, order 2",
    parameters: &[
        amplitude("fraction", "1", (0.0, 0.05), 0.005, SPECTRA),
    ],
    amplitude_power: 1,
    shows_in: "wavelength_nm",
    splits: &[Split { from: "spectro_stray", by: "long_pass_filter" }],
    acts: &[Act::Spectrum(shown)],
};

fn shown(values: &[f64], at: &Instrument<'_>) -> f64 {
    (at.truth)(at.wavelength_nm) + values[0] * (at.truth)(at.wavelength_nm / 2.0)
}
