//! The values of a certificate between its wavelengths: λ⁻⁵ · exp(A + B/λ) · polynomial in λ, the form in which NIST
//! interpolates its lamps (Walker et al., NBS SP 250-20; Yoon and Gibson, NIST SP 250-89).

use isolux_record::standard::{C2_NM_K, CertifiedRow};
use nalgebra::{DMatrix, DVector};

use super::error::CalibrationError;

/// Degree of the polynomial at most.
const MOST_DEGREE: usize = 5;
/// Rows beyond the wavelengths that are needed, on either side: a curve through a whole table from 250 nm to 2400 nm is
/// worse in its middle.
const BESIDE_NM: f64 = 150.0;
/// A value this many standard uncertainties off the curve was written down wrong.
const OFF_SIGMA: f64 = 3.0;

/// The curve through a table.
#[derive(Debug, Clone, PartialEq)]
pub struct Interpolation {
    a: f64,
    b: f64,
    polynomial: Vec<f64>,
    middle_nm: f64,
    half_nm: f64,
    /// Root mean square of the values' relative differences from it, for their number less that of its parameters.
    pub residual_rel: f64,
}

impl Interpolation {
    /// The curve through the rows that matter between `from_nm` and `to_nm`.
    ///
    /// # Errors
    /// [`CalibrationError::Shape`] names a value that is far off the curve, [`CalibrationError::Dark`] where too few
    /// rows lie there.
    pub fn of(rows: &[CertifiedRow], from_nm: f64, to_nm: f64) -> Result<Self, CalibrationError> {
        let near = from_nm - BESIDE_NM..=to_nm + BESIDE_NM;
        let rows: Vec<CertifiedRow> = rows
            .iter()
            .filter(|row| near.contains(&row.wavelength_nm))
            .copied()
            .collect();
        let count = rows.len();
        let too_few = || CalibrationError::NoPart("certified wavelengths around those of the instrument: at least six");
        if count < 6 {
            return Err(too_few());
        }
        let wien: Vec<f64> = (rows.iter())
            .map(|row| (row.irradiance_w_m2_nm * (row.wavelength_nm / 1000.0).powi(5)).ln())
            .collect();
        let weights: Vec<f64> = rows.iter().map(|row| 1.0 / row.u_rel).collect();
        let inverse = |place: usize, power: usize| rows[place].wavelength_nm.recip().powi(power as i32);
        let line = least_squares(count, 2, &weights, &inverse, &wien).ok_or_else(too_few)?;
        let (first, last) = (rows[0].wavelength_nm, rows[count - 1].wavelength_nm);
        let mut curve = Self {
            a: line[0],
            b: line[1],
            polynomial: vec![1.0],
            middle_nm: 0.5 * (first + last),
            half_nm: 0.5 * (last - first),
            residual_rel: 0.0,
        };
        let degree = MOST_DEGREE.min(count - 4);
        let ratio = |curve: &Self, row: &CertifiedRow| row.irradiance_w_m2_nm / curve.at_nm(row.wavelength_nm);
        let ratios: Vec<f64> = rows.iter().map(|row| ratio(&curve, row)).collect();
        let powers = |place: usize, power: usize| curve.reduced(rows[place].wavelength_nm).powi(power as i32);
        curve.polynomial = least_squares(count, degree + 1, &weights, &powers, &ratios).ok_or_else(too_few)?;
        let mut squares = 0.0;
        for row in &rows {
            let off_rel = ratio(&curve, row) - 1.0;
            squares += off_rel * off_rel;
            if off_rel.abs() > OFF_SIGMA * row.u_rel {
                return Err(CalibrationError::Shape {
                    wavelength_nm: row.wavelength_nm,
                    off_rel,
                    u_rel: row.u_rel,
                });
            }
        }
        // A and the constant of the polynomial are one parameter.
        curve.residual_rel = (squares / (count - degree - 2) as f64).sqrt();
        Ok(curve)
    }

    /// Spectral irradiance, W/(m² nm).
    pub fn at_nm(&self, wavelength_nm: f64) -> f64 {
        let wien = (1000.0 / wavelength_nm).powi(5) * (self.a + self.b / wavelength_nm).exp();
        let x = self.reduced(wavelength_nm);
        wien * self.polynomial.iter().rev().fold(0.0, |sum, k| sum * x + k)
    }

    /// Temperature of the Wien radiator that it is like, K.
    pub fn temperature_k(&self) -> f64 {
        -C2_NM_K / self.b
    }

    fn reduced(&self, wavelength_nm: f64) -> f64 {
        (wavelength_nm - self.middle_nm) / self.half_nm
    }
}

/// Parameters that bring Σ parameter · `basis` nearest to `values`, weighted; none where they are not determined.
fn least_squares(
    rows: usize,
    parameters: usize,
    weights: &[f64],
    basis: &dyn Fn(usize, usize) -> f64,
    values: &[f64],
) -> Option<Vec<f64>> {
    let matrix = DMatrix::from_fn(rows, parameters, |row, parameter| weights[row] * basis(row, parameter));
    let right = DVector::from_fn(rows, |row, _| weights[row] * values[row]);
    let found = matrix.svd(true, true).solve(&right, 1e-13).ok()?;
    found
        .iter()
        .all(|value| value.is_finite())
        .then(|| found.iter().copied().collect())
}

/// Relative change of Planck's law for a relative change of the temperature: x / (1 − e⁻ˣ) with x = c₂/(λT).
pub(super) fn tilt(wavelength_nm: f64, temperature_k: f64) -> f64 {
    let x = C2_NM_K / (wavelength_nm * temperature_k);
    x / -(-x).exp_m1()
}
