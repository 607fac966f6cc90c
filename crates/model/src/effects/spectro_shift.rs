//! The instrument shows at λ what belongs to λ + δ.

use super::act::{Act, Instrument};
use super::spec::{BelongsTo, EffectSpec, SPECTRA, Split, amplitude};

/// Wavelength error of the spectroradiometer.
pub(super) static SPECTRO_SHIFT: EffectSpec = EffectSpec {
    name: "spectro_shift",
    standard_name: "wavelength error of the spectroradiometer",
    sentence: "The wavelength scale of the spectroradiometer is off[ by {shift_nm}].",
    belongs_to: &[BelongsTo::Bench],
    stages: SPECTRA,
    formula: "S(λ + δ)",
    source: "CIE 063; line lamp calibration",
    parameters: &[
        amplitude("shift_nm", "nm", (-0.5, 0.5), 0.1, SPECTRA),
    ],
    amplitude_power: 1,
    shows_in: "wavelength_nm",
    splits: &[Split { from: "spectro_bandpass", by: "line_lamp" }],
    acts: &[Act::Spectrum(shown)],
};

fn shown(values: &[f64], at: &Instrument<'_>) -> f64 {
    (at.truth)(at.wavelength_nm + values[0])
}
