//! A quantity over wavelength.

use crate::{cie, per_nm};

/// Why numbers are no spectrum.
#[derive(Debug, Clone, Copy, PartialEq, thiserror::Error)]
pub enum SpectrumError {
    /// No point at all.
    #[error("a spectrum needs at least one point")]
    Empty,
    /// Wavelengths and values differ in number.
    #[error("{wavelengths} wavelengths but {values} values")]
    Lengths {
        /// Number of wavelengths.
        wavelengths: usize,
        /// Number of values.
        values: usize,
    },
    /// A NaN or an infinity.
    #[error("point {index} (counted from 0) is not finite: {wavelength_nm} nm, {value}")]
    NotFinite {
        /// Index of the point.
        index: usize,
        /// Its wavelength.
        wavelength_nm: f64,
        /// Its value.
        value: f64,
    },
    /// A wavelength that is not above the one before, or not above zero.
    #[error("wavelength {index} (counted from 0) is {wavelength_nm} nm and does not rise above {before_nm} nm")]
    NotRising {
        /// Index of the point.
        index: usize,
        /// The wavelength before (0 for the first).
        before_nm: f64,
        /// Its wavelength.
        wavelength_nm: f64,
    },
}

/// A spectrum: rising wavelengths in nm, finite values (negative ones are data), linear in between, zero outside.
#[derive(Debug, Clone, PartialEq)]
pub struct Spectrum {
    wavelength_nm: Vec<f64>,
    value: Vec<f64>,
}

impl Spectrum {
    /// A spectrum from its points.
    ///
    /// # Errors
    /// [`SpectrumError`] names the first point that is wrong.
    pub fn new(wavelength_nm: Vec<f64>, value: Vec<f64>) -> Result<Self, SpectrumError> {
        if wavelength_nm.len() != value.len() {
            return Err(SpectrumError::Lengths {
                wavelengths: wavelength_nm.len(),
                values: value.len(),
            });
        }
        if value.is_empty() {
            return Err(SpectrumError::Empty);
        }
        let mut before_nm = 0.0;
        for (index, (&wavelength, &v)) in wavelength_nm.iter().zip(&value).enumerate() {
            if !(wavelength.is_finite() && v.is_finite()) {
                return Err(SpectrumError::NotFinite {
                    index,
                    wavelength_nm: wavelength,
                    value: v,
                });
            }
            if wavelength <= before_nm {
                return Err(SpectrumError::NotRising {
                    index,
                    before_nm,
                    wavelength_nm: wavelength,
                });
            }
            before_nm = wavelength;
        }
        Ok(Self { wavelength_nm, value })
    }

    /// Wavelengths in nm, rising.
    pub fn wavelength_nm(&self) -> &[f64] {
        &self.wavelength_nm
    }

    /// Values, one a wavelength.
    pub fn value(&self) -> &[f64] {
        &self.value
    }

    /// The value at a wavelength: linear between the points, zero outside the first and the last.
    pub fn at_nm(&self, wavelength_nm: f64) -> f64 {
        self.at_nm_from(
            self.wavelength_nm.partition_point(|&w| w < wavelength_nm),
            wavelength_nm,
        )
    }

    /// The value at a wavelength, with the first point that is not below it.
    pub(crate) fn at_nm_from(&self, above: usize, wavelength_nm: f64) -> f64 {
        match (above.checked_sub(1), self.wavelength_nm.get(above)) {
            (_, Some(&w)) if w == wavelength_nm => self.value[above],
            (Some(below), Some(&w)) => {
                let from = self.wavelength_nm[below];
                let t = (wavelength_nm - from) / (w - from);
                self.value[below] + t * (self.value[above] - self.value[below])
            }
            _ => 0.0,
        }
    }

    /// What falls to 360, 361, … 830 nm, so that Σ of it times a table of the CIE is ∫ S·t dλ with t linear between its
    /// entries.
    ///
    /// Where the data have points at whole nanometres alone these are the values there, to the bit; in a nanometre that
    /// has a point between its ends the integral is exact (decision 0004), so that no line can hide between two
    /// entries.
    pub fn per_nm(&self) -> [f64; 471] {
        per_nm::per_nm(&[self])
    }

    /// ∫ S dλ over 360–830 nm, the sum of [`Self::per_nm`]; the unit of the values times nm.
    pub fn integral(&self) -> f64 {
        self.per_nm().iter().sum()
    }

    /// K_m ∫ S V dλ over 360–830 nm: lux from W/(m²·nm), lumen from W/nm.
    pub fn luminous_integral(&self) -> f64 {
        cie::K_M_LM_PER_W
            * self
                .per_nm()
                .iter()
                .zip(&cie::V_LAMBDA)
                .map(|(s, v)| s * v)
                .sum::<f64>()
    }

    /// Luminous efficacy of radiation K = K_m ∫SV dλ / ∫S dλ, over 360–830 nm; none where ∫S dλ is not above zero.
    pub fn ler_lm_per_w(&self) -> Option<f64> {
        let radiant = self.integral();
        let ler = self.luminous_integral() / radiant;
        (radiant > 0.0 && ler.is_finite()).then_some(ler)
    }

    /// The same spectrum with every value multiplied by `factor`.
    ///
    /// # Errors
    /// [`SpectrumError::NotFinite`] when a product overflows.
    pub fn scaled(&self, factor: f64) -> Result<Self, SpectrumError> {
        Self::new(
            self.wavelength_nm.clone(),
            self.value.iter().map(|v| v * factor).collect(),
        )
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn linear_between_points_dark_outside() {
        let s = Spectrum::new(vec![400.0, 500.0], vec![1.0, 3.0]).unwrap();
        assert_eq!(
            [
                s.at_nm(399.9),
                s.at_nm(400.0),
                s.at_nm(450.0),
                s.at_nm(500.0),
                s.at_nm(500.1)
            ],
            [0.0, 1.0, 2.0, 3.0, 0.0]
        );
    }

    #[test]
    fn monochromatic_green_gives_the_maximum_efficacy() {
        // V(555 nm) = 1 by definition, so K = K_m.
        let line = Spectrum::new(vec![554.0, 555.0, 556.0], vec![0.0, 1.0, 0.0]).unwrap();
        assert!((line.ler_lm_per_w().unwrap() - 683.0).abs() < 1e-9);
    }

    #[test]
    fn equal_energy_efficacy_is_the_integral_of_v() {
        // ∫V dλ = 106.86 nm (CIE 018), so K(E) = 683·106.857/471 points.
        let e = Spectrum::new(vec![360.0, 830.0], vec![1.0, 1.0]).unwrap();
        assert!(
            (e.luminous_integral() / 683.0 - 106.8566).abs() < 1e-3,
            "{}",
            e.luminous_integral() / 683.0
        );
        assert_eq!(e.integral(), 471.0);
    }

    #[test]
    fn says_which_point_is_wrong() {
        assert_eq!(
            Spectrum::new(vec![400.0, 400.0], vec![1.0, 1.0]),
            Err(SpectrumError::NotRising {
                index: 1,
                before_nm: 400.0,
                wavelength_nm: 400.0
            })
        );
        assert!(matches!(
            Spectrum::new(vec![400.0], vec![f64::NAN]),
            Err(SpectrumError::NotFinite { index: 0, .. })
        ));
        assert_eq!(Spectrum::new(vec![], vec![]), Err(SpectrumError::Empty));
    }
}
