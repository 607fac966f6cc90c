//! Light of all wavelengths scatters evenly over the detector. It goes with the lamp; a dark signal does not.

use super::act::{Act, Instrument};
use super::spec::{BelongsTo, EffectSpec, SPECTRA, Split, amplitude};

/// Stray light in the spectroradiometer.
pub(super) static SPECTRO_STRAY: EffectSpec = EffectSpec {
    name: "spectro_stray",
    standard_name: "stray light in the spectroradiometer",
    sentence: "Light of all wavelengths scatters inside the spectroradiometer[: {fraction:%} of the whole in each nanometre].",
    belongs_to: &[BelongsTo::Bench],
    stages: SPECTRA,
    formula: "S + s·∫S dλ",
    source: "CIE 233, a flat stray light matrix",
    parameters: &[
        amplitude("fraction", "1/nm", (0.0, 1e-2), 1e-4, SPECTRA),
    ],
    amplitude_power: 1,
    shows_in: "wavelength_nm",
    splits: &[Split { from: "spectro_dark", by: "shutter" }],
    acts: &[Act::Spectrum(shown)],
};

fn shown(values: &[f64], at: &Instrument<'_>) -> f64 {
    (at.truth)(at.wavelength_nm) + values[0] * at.integral
}
