//! The grating's second order puts the light of λ/2 on λ.

use super::act::{Act, Instrument, Values};
use super::spec::{BelongsTo, EffectSpec, SPECTRA, amplitude};

pub(super) static SPEC: EffectSpec = EffectSpec {
    name: "spectro_2nd",
    standard_name: "second diffraction order",
    sentence: "The second order of the grating puts light of half the wavelength beside the right one[: {fraction:%}].",
    belongs_to: &[BelongsTo::Bench],
    stages: SPECTRA,
    formula: "S + k·S(λ/2)",
    source: "grating equation, order 2",
    parameters: &[amplitude("fraction", "1", (0.0, 0.05), 0.005)],
    shows_in: "wavelength_nm",
    look_alikes: &[("spectro_stray", "long_pass_filter")],
    acts: &[Act::Spectrum(shown)],
    ..EffectSpec::NEUTRAL
};

fn shown(&[fraction, ..]: &Values, at: &Instrument<'_>) -> f64 {
    (at.truth)(at.wavelength_nm) + fraction * (at.truth)(at.wavelength_nm / 2.0)
}
