//! Light of all wavelengths scatters evenly over the detector. It goes with the lamp; a dark signal does not.

use super::act::{Act, Instrument, Values};
use super::spec::{BelongsTo, EffectSpec, SPECTRA, amplitude};

pub(super) static SPEC: EffectSpec = EffectSpec {
    name: "spectro_stray",
    standard_name: "stray light in the spectroradiometer",
    sentence: "Light of all wavelengths scatters inside the spectroradiometer[: {fraction:%} of the whole in each \
        nanometre].",
    belongs_to: &[BelongsTo::Bench],
    stages: SPECTRA,
    formula: "S + s·∫S dλ",
    source: "CIE 233, a flat stray light matrix",
    parameters: &[amplitude("fraction", "1/nm", (0.0, 1e-2), 1e-4)],
    shows_in: "wavelength_nm",
    look_alikes: &[("spectro_dark", "shutter")],
    acts: &[Act::Spectrum(shown)],
    ..EffectSpec::NEUTRAL
};

fn shown(&[fraction, ..]: &Values, at: &Instrument<'_>) -> f64 {
    (at.truth)(at.wavelength_nm) + fraction * at.integral
}
