//! Spectra of a lamp over angle: what colour its light has in every direction.

use isolux_photometry::{HalfPlanes, HalfPlanesError, Symmetry, direction};
use isolux_record::document::DocumentError;
use isolux_spectrum::{Spectrum, cie};
use serde::{Deserialize, Serialize};

use crate::reader::Reader;

/// Number of entries at 1 nm, 360–830 nm.
const TABLE: usize = cie::V_LAMBDA.len();

/// Spectra in several directions, and between them the mixture of the nearest, lumen by lumen: how strong each was
/// measured does not matter.
#[derive(Debug, Clone, PartialEq)]
pub struct ColourOverAngle {
    half_planes: HalfPlanes,
    directions_deg: Vec<(f64, f64)>,
    spectra: Vec<Spectrum>,
    /// Each spectrum at 360, 361, … 830 nm, W/nm for one lumen.
    per_lumen: Vec<[f64; TABLE]>,
    /// Their sums, W/lm.
    watt_per_lumen: Vec<f64>,
}

/// Why spectra are no colour over angle.
#[derive(Debug, Clone, Copy, PartialEq, thiserror::Error)]
pub enum ColourError {
    /// The directions.
    #[error(transparent)]
    Directions(#[from] HalfPlanesError),
    /// A spectrum without light.
    #[error("the spectrum at C {c_deg}°, γ {gamma_deg}° holds no visible light")]
    Dark {
        /// Its C.
        c_deg: f64,
        /// Its γ.
        gamma_deg: f64,
    },
}

impl ColourOverAngle {
    /// Spectra, any scale, at directions (C, γ) in degrees.
    ///
    /// # Errors
    /// [`ColourError`].
    pub fn new(measured: Vec<((f64, f64), Spectrum)>) -> Result<Self, ColourError> {
        let (directions_deg, spectra): (Vec<_>, Vec<_>) = measured.into_iter().unzip();
        let half_planes = HalfPlanes::new(&directions_deg)?;
        let mut per_lumen = Vec::with_capacity(spectra.len());
        for (&(c_deg, gamma_deg), spectrum) in directions_deg.iter().zip(&spectra) {
            per_lumen.push(of_one_lumen(spectrum).ok_or(ColourError::Dark { c_deg, gamma_deg })?);
        }
        Ok(Self {
            half_planes,
            directions_deg,
            spectra,
            watt_per_lumen: per_lumen.iter().map(|values| values.iter().sum()).collect(),
            per_lumen,
        })
    }

    /// The directions (C, γ), in the order in which they were given.
    pub fn directions_deg(&self) -> &[(f64, f64)] {
        &self.directions_deg
    }

    /// The spectra as they were given, one for each direction.
    pub fn spectra(&self) -> &[Spectrum] {
        &self.spectra
    }

    /// Each spectrum at 360, 361, … 830 nm for one lumen, W/nm.
    pub fn per_lumen(&self) -> &[[f64; TABLE]] {
        &self.per_lumen
    }

    /// Symmetry that was assumed of the lamp, because the half-planes do not go round.
    pub fn assumed(&self) -> Symmetry {
        self.half_planes.assumed()
    }

    /// Hands the number of each direction of which the light at (C, γ) is mixed to `each`, with its share of the
    /// lumens.
    pub fn each_weight(&self, c_deg: f64, gamma_deg: f64, each: impl FnMut(usize, f64)) {
        self.half_planes.each_weight(c_deg, gamma_deg, each);
    }

    /// The light at (C, γ) in W/lm: one over its luminous efficacy.
    pub fn watt_per_lumen(&self, c_deg: f64, gamma_deg: f64) -> f64 {
        let mut sum = 0.0;
        self.each_weight(c_deg, gamma_deg, |index, weight| {
            sum += weight * self.watt_per_lumen[index];
        });
        sum
    }

    /// The light at (C, γ) at 360, 361, … 830 nm for one lumen, W/nm.
    pub fn at(&self, c_deg: f64, gamma_deg: f64) -> [f64; TABLE] {
        let mut mixed = [0.0; TABLE];
        self.each_weight(c_deg, gamma_deg, |index, weight| {
            for (sum, value) in mixed.iter_mut().zip(&self.per_lumen[index]) {
                *sum += weight * value;
            }
        });
        mixed
    }
}

/// A spectrum at 360, 361, … 830 nm for one lumen, W/nm; none without visible light.
fn of_one_lumen(spectrum: &Spectrum) -> Option<[f64; TABLE]> {
    let per_nm = spectrum.per_nm();
    let lumens = spectrum.luminous_integral();
    (lumens > 0.0 && spectrum.integral() > 0.0 && lumens.is_finite()).then(|| per_nm.map(|value| value / lumens))
}

/// One entry of `[[colour]]` of a scene or `[[luminaire.colour]]` of a model.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct ColourDocument {
    /// Without C the spectra are those of a rotational lamp.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub c_deg: Option<f64>,
    pub gamma_deg: f64,
    pub spectrum: String,
}

/// Reads the spectra that the entries at the key `path` name; none without entries.
///
/// # Errors
/// [`DocumentError`] with the line of the entry.
pub(crate) fn read(
    reader: &Reader<'_>,
    path: &str,
    entries: &[ColourDocument],
) -> Result<Option<ColourOverAngle>, DocumentError> {
    let key = |index: usize, key: &str| format!("{path}.{index}.{key}");
    let over_c = entries.iter().any(|entry| entry.c_deg.is_some());
    let mut measured = Vec::with_capacity(entries.len());
    for (index, entry) in entries.iter().enumerate() {
        reader.within(&key(index, "gamma_deg"), entry.gamma_deg, 0.0, 180.0)?;
        if let Some(c_deg) = entry.c_deg {
            reader.within(&key(index, "c_deg"), c_deg, -360.0, 360.0)?;
        }
        let pole = direction(0.0, entry.gamma_deg).truncate().length() < 1e-12;
        if over_c && entry.c_deg.is_none() && !pole {
            let message = "lacks c_deg, which other spectra have";
            return Err(reader.fault(&format!("{path}.{index}"), message));
        }
        let before = index.checked_sub(1).map(|before| entries[before].gamma_deg);
        if !over_c && before.is_some_and(|before| before >= entry.gamma_deg) {
            return Err(reader.fault(&key(index, "gamma_deg"), "angles must rise"));
        }
        let spectrum = reader.spectrum(&key(index, "spectrum"), &entry.spectrum)?;
        if of_one_lumen(&spectrum).is_none() {
            return Err(reader.fault(&key(index, "spectrum"), "holds no visible light"));
        }
        measured.push(((entry.c_deg.unwrap_or(0.0), entry.gamma_deg), spectrum));
    }
    if measured.is_empty() {
        return Ok(None);
    }
    ColourOverAngle::new(measured)
        .map(Some)
        .map_err(|error| reader.fault(path, &error.to_string()))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn line(nm: f64, value: f64) -> Spectrum {
        Spectrum::new(vec![nm - 1.0, nm, nm + 1.0], vec![0.0, value, 0.0]).unwrap()
    }

    #[test]
    fn light_between_two_directions_is_mixed_by_lumens() {
        // Whatever the strength of the measurement: half the lumens of each in the middle.
        let of = ColourOverAngle::new(vec![((0.0, 0.0), line(555.0, 7.0)), ((0.0, 20.0), line(610.0, 0.002))]).unwrap();
        assert_eq!(of.assumed(), Symmetry::Rotational);
        let middle = of.at(123.0, 10.0);
        let lumens = |nm: usize| 683.0 * middle[nm - 360] * cie::V_LAMBDA[nm - 360];
        assert!((lumens(555) - 0.5).abs() < 1e-12 && (lumens(610) - 0.5).abs() < 1e-12);
        assert!((of.watt_per_lumen(0.0, 10.0) - middle.iter().sum::<f64>()).abs() < 1e-15);
        let dark = ColourOverAngle::new(vec![((0.0, 0.0), line(850.0, 1.0))]).unwrap_err();
        assert!(dark.to_string().contains("no visible light"), "{dark}");
    }
}
