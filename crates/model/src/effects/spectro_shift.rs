//! The instrument shows at λ what belongs to λ + δ.

use super::act::{Act, Instrument, Values};
use super::spec::{BelongsTo, EffectSpec, SPECTRA, amplitude};

pub(super) static SPEC: EffectSpec = EffectSpec {
    name: "spectro_shift",
    standard_name: "wavelength error of the spectroradiometer",
    sentence: "The wavelength scale of the spectroradiometer is off[ by {shift_nm}].",
    belongs_to: &[BelongsTo::Bench],
    stages: SPECTRA,
    formula: "S(λ + δ)",
    source: "CIE 063; line lamp calibration",
    parameters: &[amplitude("shift_nm", "nm", (-0.5, 0.5), 0.1)],
    shows_in: "wavelength_nm",
    look_alikes: &[("spectro_bandpass", "line_lamp")],
    acts: &[Act::Spectrum(shown)],
    ..EffectSpec::NEUTRAL
};

fn shown(&[shift_nm, ..]: &Values, at: &Instrument<'_>) -> f64 {
    (at.truth)(at.wavelength_nm + shift_nm)
}
