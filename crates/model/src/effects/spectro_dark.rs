//! What the spectrometer shows without light.

use super::act::{Act, Values};
use super::spec::{BelongsTo, EffectSpec, SPECTRA, amplitude};

pub(super) static SPEC: EffectSpec = EffectSpec {
    name: "spectro_dark",
    standard_name: "dark signal of the spectroradiometer",
    sentence: "The spectroradiometer shows something without light[: {offset}].",
    belongs_to: &[BelongsTo::Bench],
    stages: SPECTRA,
    formula: "S + c",
    source: "EMVA 1288, dark signal",
    parameters: &[amplitude("offset", "unit of the spectrum", (-1e-2, 1e-2), 1e-4)],
    shows_in: "wavelength_nm",
    look_alikes: &[("spectro_stray", "shutter")],
    acts: &[Act::SpectrumZero(offset)],
    ..EffectSpec::NEUTRAL
};

fn offset(&[offset, ..]: &Values) -> f64 {
    offset
}
