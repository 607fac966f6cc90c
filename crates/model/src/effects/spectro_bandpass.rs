//! The slit averages over wavelength: the triangle of equal entrance and exit slits.

use super::act::{Act, Instrument, Values};
use super::spec::{BelongsTo, EffectSpec, SPECTRA, amplitude};

pub(super) static SPEC: EffectSpec = EffectSpec {
    name: "spectro_bandpass",
    standard_name: "bandpass of the spectroradiometer",
    sentence: "The slit of the spectroradiometer blurs the spectrum[ over {fwhm_nm}].",
    belongs_to: &[BelongsTo::Bench],
    stages: SPECTRA,
    formula: "S ⊗ triangle of the given full width at half maximum",
    source: "CIE 214",
    parameters: &[amplitude("fwhm_nm", "nm", (1.0, 10.0), 3.0)],
    amplitude_power: 2,
    shows_in: "wavelength_nm",
    look_alikes: &[("spectro_shift", "line_lamp")],
    acts: &[Act::Spectrum(shown)],
    ..EffectSpec::NEUTRAL
};

/// Samples on each side of the triangle.
const SAMPLES: i32 = 12;

fn shown(&[fwhm_nm, ..]: &Values, at: &Instrument<'_>) -> f64 {
    let fwhm_nm = fwhm_nm.abs();
    if fwhm_nm == 0.0 {
        return (at.truth)(at.wavelength_nm);
    }
    let (mut sum, mut weights) = (0.0, 0.0);
    for k in -SAMPLES..=SAMPLES {
        let place = f64::from(k) / f64::from(SAMPLES + 1);
        let weight = 1.0 - place.abs();
        sum += weight * (at.truth)(at.wavelength_nm + place * fwhm_nm);
        weights += weight;
    }
    sum / weights
}
