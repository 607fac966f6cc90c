//! The spectrum that a spectroradiometer would show.

use isolux_record::ReadingKind;
use isolux_record::observation::{ReadingCoordinates, SpectraSet};
use isolux_spectrum::Spectrum;

use crate::effects::{Act, Instrument, Values};
use crate::luminaire::Spectral;
use crate::model::Model;

/// Why spectra cannot be predicted.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
pub enum NoSpectrum {
    /// The model has none.
    #[error("the model has no spectrum: give luminaire.spectrum in the model file")]
    Missing,
    /// A unit of spectral irradiance that nobody here knows.
    #[error("unit of irradiance that is not known; W/m2/nm, mW/m2/nm and uW/cm2/nm are")]
    Unit,
    /// A spectrum without visible light cannot be scaled to illuminance.
    #[error("the model's spectrum holds no visible light")]
    Dark,
}

impl Model {
    /// The value at every row of `spectra`, in its order: spectral irradiance in the file's unit where the file says so
    /// (`quantity = "irradiance"`), else the model's spectrum as its file has it.
    ///
    /// # Errors
    /// [`NoSpectrum`] when the model cannot know.
    pub fn predict_spectra(&self, spectra: &SpectraSet) -> Result<Vec<f64>, NoSpectrum> {
        let (spectrum, scale) = self.spectrum_at(spectra)?;
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
        let truth = |wavelength_nm: f64| smoothly_at(spectrum, wavelength_nm) * scale;
        Ok(spectra
            .rows()
            .iter()
            .map(|row| match row.kind {
                ReadingKind::Lit => shown(&laws, &truth, row.wavelength_nm, integral) + zero,
                ReadingKind::Baffled | ReadingKind::LampOff | ReadingKind::Capped => zero,
            })
            .collect())
    }

    /// The model's spectrum, with less noise where it states how much it has, and how many of its units make one of the file's at the place of `spectra`.
    ///
    /// # Errors
    /// [`NoSpectrum`] when the model cannot know.
    pub(crate) fn spectrum_at(&self, spectra: &SpectraSet) -> Result<(&Spectrum, f64), NoSpectrum> {
        let Spectral::Spectrum(spectrum) = self.luminaire().spectral() else {
            return Err(NoSpectrum::Missing);
        };
        let spectrum = self.smoothed_spectrum().map_or(spectrum, |smoothed| &smoothed.spectrum);
        let luminous = spectrum.luminous_integral();
        if luminous <= 0.0 {
            return Err(NoSpectrum::Dark);
        }
        let scale = if spectra.is_irradiance() {
            let unit = per_watt_and_square_metre(&spectra.unit).ok_or(NoSpectrum::Unit)?;
            // The lamp's spectrum at this place is what makes the illuminance there.
            let at = ReadingCoordinates {
                kind: ReadingKind::Lit,
                time_s: None,
                lamp_s: None,
                c_deg: spectra.c_deg,
                gamma_deg: spectra.gamma_deg,
                distance_mm: spectra.distance_mm,
                travel: 0,
                range: None,
                ambient_c: None,
                head: 0,
            };
            let efficacy = self.acts().fold(1.0, |factor, (act, values)| match act {
                Act::Efficacy(law) => factor * law(values),
                _ => factor,
            });
            let light = self
                .effects()
                .iter()
                .filter(|effect| !effect.spec().belongs_to(crate::BelongsTo::Bench));
            self.with_effects(light.cloned().collect()).predict_reading(&at) / luminous / efficacy * unit
        } else {
            // Of a relative spectrum only the refitted level is known.
            self.refined().factor(spectra.c_deg, spectra.gamma_deg.abs())
        };
        Ok((spectrum, scale))
    }
}

/// The value at a wavelength, on the cubic through its neighbours with their slopes (Catmull and Rom 1974): between two
/// values a straight line would blur what an instrument moves. Dark outside.
fn smoothly_at(spectrum: &Spectrum, wavelength_nm: f64) -> f64 {
    let (nm, value) = (spectrum.wavelength_nm(), spectrum.value());
    let above = nm.partition_point(|at| *at < wavelength_nm);
    let below = match (above.checked_sub(1), nm.get(above)) {
        (_, Some(at)) if *at == wavelength_nm => return value[above],
        (Some(below), Some(_)) => below,
        _ => return 0.0,
    };
    let slope = |k: usize| {
        let (before, after) = (k.saturating_sub(1), (k + 1).min(nm.len() - 1));
        (value[after] - value[before]) / (nm[after] - nm[before])
    };
    let step = nm[above] - nm[below];
    let t = (wavelength_nm - nm[below]) / step;
    let (rest, both) = (1.0 - t, t * (1.0 - t));
    value[below] * rest * rest * (1.0 + 2.0 * t)
        + value[above] * t * t * (3.0 - 2.0 * t)
        + step * both * (rest * slope(below) - t * slope(above))
}

/// How many of a unit of spectral irradiance make 1 W/(m²·nm).
fn per_watt_and_square_metre(unit: &str) -> Option<f64> {
    let plain: String = unit.to_lowercase().replace('²', "2").replace(['µ', 'μ'], "u");
    let plain: String = plain.chars().filter(char::is_ascii_alphanumeric).collect();
    let (prefix, rest) = plain.split_once('w')?;
    let prefix = match prefix {
        "" => 1.0,
        "m" => 1e3,
        "u" => 1e6,
        _ => return None,
    };
    let area = match rest.trim_end_matches('1') {
        "m2nm" | "m2" => 1.0,
        "cm2nm" | "cm2" => 1e-4,
        _ => return None,
    };
    Some(prefix * area)
}

type Law<'m> = (fn(&Values, &Instrument<'_>) -> f64, &'m Values);

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

#[cfg(test)]
mod tests {
    use isolux_spectrum::Spectrum;

    use super::{per_watt_and_square_metre, smoothly_at};

    #[test]
    fn units_of_irradiance() {
        for (unit, expected) in [
            ("W/m2/nm", Some(1.0)),
            ("W/(m²·nm)", Some(1.0)),
            ("W·m^-2·nm^-1", Some(1.0)),
            ("mW/m2/nm", Some(1e3)),
            ("µW/cm²/nm", Some(100.0)),
            ("counts", None),
            ("W/m2/um", None),
        ] {
            assert_eq!(per_watt_and_square_metre(unit), expected, "{unit}");
        }
    }

    #[test]
    fn a_parabola_is_kept_between_its_values() {
        let parabola = |nm: f64| 2.0 + 0.1 * nm - 3e-4 * nm * nm;
        let nm: Vec<f64> = (0..20).map(|k| 400.0 + 2.0 * f64::from(k)).collect();
        let value = nm.iter().map(|nm| parabola(*nm)).collect();
        let spectrum = Spectrum::new(nm, value).unwrap();
        for at in [404.0, 405.3, 419.9, 430.1] {
            assert!((smoothly_at(&spectrum, at) - parabola(at)).abs() < 1e-9, "{at}");
        }
        assert_eq!(smoothly_at(&spectrum, 399.0), 0.0);
    }
}
