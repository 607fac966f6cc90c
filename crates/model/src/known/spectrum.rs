//! What is not known of a spectrum: its noise, and what the spectroradiometers have in common with themselves.
//!
//! A model's spectrum and one that it is compared with were read by spectroradiometers. What the file of either states
//! of its shape and its wavelengths counts, unless the same one with the same calibration read both: then both have the
//! same error. The gain counts always: the model's level is the lux meter's.

use isolux_record::ReadingKind;
use isolux_record::observation::SpectraSet;

use crate::direction_noise::DirectionError;
use crate::effect::Effect;
use crate::effects::by_name;
use crate::model::Model;
use crate::spectrum::NoSpectrum;

/// Numbers of values begin where no direction has one.
const FIRST_NUMBER: usize = 1 << 40;

/// An error that all rows of a file of spectra share.
#[derive(Debug, Clone)]
pub struct SpectrumError {
    /// What, in words.
    pub what: &'static str,
    /// Its standard uncertainty.
    pub u: f64,
    /// The unit of that; empty for a ratio.
    pub unit: &'static str,
    /// What one standard uncertainty changes of every row, in the unit of the file.
    pub change: Vec<f64>,
}

impl Model {
    /// What the rows of `spectra` share, where the model's or their own file states it.
    ///
    /// # Errors
    /// [`NoSpectrum`] when the model cannot predict them.
    pub fn errors_of_spectra(&self, spectra: &SpectraSet) -> Result<Vec<SpectrumError>, NoSpectrum> {
        let own = self.uncertainty().and_then(|u| u.spectrum.as_ref());
        let instrument = own.and_then(|own| own.instrument.as_ref());
        let same = instrument.is_some() && instrument == spectra.instrument.as_ref();
        let both = |own: Option<f64>, other: Option<f64>| {
            if same {
                0.0
            } else {
                own.unwrap_or(0.0).hypot(other.unwrap_or(0.0))
            }
        };
        let shared = spectra.shared;
        let gain_rel = shared.gain_rel.unwrap_or(0.0);
        let shape_rel = both(own.and_then(|own| own.shape_rel), shared.shape_rel);
        let scale_nm = both(own.and_then(|own| own.scale_nm), shared.wavelength_nm);
        let expected = self.predict_spectra(spectra)?;
        let factor = |law: &dyn Fn(f64) -> f64| -> Vec<f64> {
            let rows = spectra.rows().iter().zip(&expected);
            rows.map(|(row, value)| value * law(row.wavelength_nm)).collect()
        };
        let from_550 = |nm: f64| (nm - 550.0) / 300.0;
        let shifted = |by_nm: f64| {
            let shift = by_name("spectro_shift").and_then(|spec| Effect::new(spec, &[by_nm]).ok());
            let effects = self.effects().iter().cloned().chain(shift).collect();
            self.with_effects(effects).predict_spectra(spectra)
        };
        let (up, down) = (shifted(scale_nm)?, shifted(-scale_nm)?);
        let moved = up.iter().zip(&down).map(|(up, down)| 0.5 * (up - down)).collect();
        let all = [
            ("the gain of the spectroradiometer", gain_rel, "", factor(&|_| gain_rel)),
            (
                "the ratio of 700 nm to 400 nm",
                shape_rel,
                "",
                factor(&|nm| shape_rel * from_550(nm)),
            ),
            (
                "the ratio of 550 nm to 400 nm and 700 nm",
                shape_rel,
                "",
                factor(&|nm| 0.5 * shape_rel * (1.0 - 8.0 * from_550(nm).powi(2))),
            ),
            ("the wavelength scale", scale_nm, "nm", moved),
        ];
        let stated = all.into_iter().filter(|(_, u, ..)| *u > 0.0);
        Ok(stated
            .map(|(what, u, unit, change)| SpectrumError { what, u, unit, change })
            .collect())
    }

    /// Errors of rows of `spectra` that come from the noise of each value of the model's spectrum, where the model states
    /// it; empty where it does not.
    pub fn noise_errors_of_spectra(&self, spectra: &SpectraSet) -> Vec<DirectionError> {
        let (Some(smoothed), Ok((_, scale))) = (self.smoothed_spectrum(), self.spectrum_at(spectra)) else {
            return Vec::new();
        };
        let mut errors: Vec<DirectionError> = (0..smoothed.noise.len())
            .map(|value| DirectionError {
                number: FIRST_NUMBER + value,
                errors: Vec::new(),
            })
            .collect();
        let lit = |kind| kind == ReadingKind::Lit;
        for (row, sample) in spectra.rows().iter().enumerate().filter(|(_, row)| lit(row.kind)) {
            for (value, change) in smoothed.errors_at(sample.wavelength_nm) {
                errors[value].errors.push((row, scale * change));
            }
        }
        errors.retain(|error| !error.errors.is_empty());
        errors
    }
}
