//! The spectrum that a spectroradiometer would show.

use isolux_record::ReadingKind;
use isolux_record::observation::{ReadingCoordinates, SpectraSet};

use crate::effects::{Act, Instrument};
use crate::luminaire::Spectral;
use crate::model::Model;

/// Why spectra cannot be predicted.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
pub enum NoSpectrum {
    /// The model has none.
    #[error("the model has no spectrum: give luminaire.spectrum in the model file")]
    Missing,
    /// A spectrum without visible light cannot be scaled to illuminance.
    #[error("the model's spectrum holds no visible light")]
    Dark,
}

impl Model {
    /// The value at every row of `spectra`, in its order: spectral irradiance in W/(m²·nm) where the file says so
    /// (`quantity = "irradiance"`), else the model's spectrum as its file has it.
    ///
    /// # Errors
    /// [`NoSpectrum`] when the model cannot know.
    pub fn predict_spectra(&self, spectra: &SpectraSet) -> Result<Vec<f64>, NoSpectrum> {
        let Spectral::Spectrum(spectrum) = self.luminaire().spectral() else {
            return Err(NoSpectrum::Missing);
        };
        let luminous = spectrum.luminous_integral();
        if luminous <= 0.0 {
            return Err(NoSpectrum::Dark);
        }
        let scale = if spectra.quantity.to_ascii_lowercase().contains("irradiance") {
            // The lamp's spectrum at this place is what makes the illuminance there.
            let at = ReadingCoordinates {
                kind: ReadingKind::Lit,
                time_s: None,
                c_deg: spectra.c_deg,
                gamma_deg: spectra.gamma_deg,
                distance_mm: spectra.distance_mm,
                travel: 0,
                range: None,
                ambient_c: None,
            };
            let efficacy = self.acts().fold(1.0, |factor, (act, values)| match act {
                Act::Efficacy(law) => factor * law(values),
                _ => factor,
            });
            let light = self
                .effects()
                .iter()
                .filter(|effect| !effect.spec().belongs_to(crate::BelongsTo::Bench));
            self.with_effects(light.cloned().collect()).predict_reading(&at) / luminous / efficacy
        } else {
            1.0
        };
        let integral = spectrum.integral() * scale;
        let laws: Vec<_> = self
            .acts()
            .filter_map(|(act, values)| match act {
                Act::Spectrum(law) => Some((*law, values)),
                _ => None,
            })
            .collect();
        let zero: f64 = self
            .acts()
            .map(|(act, values)| match act {
                Act::SpectrumZero(law) => law(values),
                _ => 0.0,
            })
            .sum();
        let truth = |wavelength_nm: f64| spectrum.at_nm(wavelength_nm) * scale;
        Ok(spectra
            .rows()
            .iter()
            .map(|row| match row.kind {
                ReadingKind::Lit => shown(&laws, &truth, row.wavelength_nm, integral) + zero,
                ReadingKind::Baffled | ReadingKind::LampOff | ReadingKind::Capped => zero,
            })
            .collect())
    }
}

type Law<'m> = (fn(&[f64], &Instrument<'_>) -> f64, &'m [f64]);

/// The laws one after the other: each sees as truth what those before it show.
fn shown(laws: &[Law<'_>], truth: &dyn Fn(f64) -> f64, wavelength_nm: f64, integral: f64) -> f64 {
    match laws.split_last() {
        None => truth(wavelength_nm),
        Some(((law, values), before)) => {
            let truth = |wavelength_nm: f64| shown(before, truth, wavelength_nm, integral);
            law(
                values,
                &Instrument {
                    truth: &truth,
                    wavelength_nm,
                    integral,
                },
            )
        }
    }
}
