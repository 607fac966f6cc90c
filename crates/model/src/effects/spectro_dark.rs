//! What the spectrometer shows without light.

use super::act::Act;
use super::spec::{BelongsTo, EffectSpec, SPECTRA, Split, amplitude};

/// Dark signal of the spectroradiometer.
pub(super) static SPECTRO_DARK: EffectSpec = EffectSpec {
    name: "spectro_dark",
    standard_name: "dark signal of the spectroradiometer",
    sentence: "The spectroradiometer shows something without light[: {offset}].",
    belongs_to: &[BelongsTo::Bench],
    stages: SPECTRA,
    formula: "S + c",
    source: "EMVA 1288, dark signal",
    parameters: &[
        amplitude("offset", "unit of the spectrum", (-1e-2, 1e-2), 1e-4, SPECTRA),
    ],
    amplitude_power: 1,
    shows_in: "wavelength_nm",
    splits: &[Split { from: "spectro_stray", by: "shutter" }],
    acts: &[Act::SpectrumZero(offset)],
};

fn offset(values: &[f64]) -> f64 {
    values[0]
}
