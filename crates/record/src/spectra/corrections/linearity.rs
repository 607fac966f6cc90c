//! `isolux-linearity/1`: what is left of the non-linearity of a spectroradiometer after its own polynomial.

use camino::Utf8Path;
use serde::{Deserialize, Serialize};

use super::{Made, check_made, parse};
use crate::document::bounds::within;
use crate::document::{DocumentError, Fault};

/// Value of `format`.
pub const FORMAT: &str = "isolux-linearity/1";

/// The linearity of a spectroradiometer.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Linearity {
    /// [`FORMAT`].
    pub format: String,
    /// Linear counts = counts ÷ (1 + Σ `coefficient[k]`·xᵏ⁺¹), x = counts over full scale, dark taken off and the
    /// instrument's own polynomial applied.
    pub coefficient: Vec<f64>,
    /// Covariance of these coefficients.
    pub covariance: Vec<Vec<f64>>,
    /// Counts over full scale of the least and the most light that it was found with.
    pub range_rel: [f64; 2],
    /// Where it comes from.
    pub made: Made,
}

impl Linearity {
    /// Reads a file.
    ///
    /// # Errors
    /// [`DocumentError`] with file and line.
    pub fn parse(file: &Utf8Path, text: &str) -> Result<Self, DocumentError> {
        parse(file, text, FORMAT, check)
    }

    /// What counts of `x` of full scale are divided by.
    pub fn divisor(&self, x: f64) -> f64 {
        1.0 + x * self.coefficient.iter().rev().fold(0.0, |sum, c| sum * x + c)
    }

    /// Relative standard uncertainty of that at `x` of full scale (k = 1).
    pub fn u_rel(&self, x: f64) -> f64 {
        let row = |(j, row): (usize, &Vec<f64>)| -> f64 {
            let terms = row.iter().enumerate();
            terms.map(|(k, value)| value * x.powi((j + k + 2) as i32)).sum()
        };
        let variance: f64 = self.covariance.iter().enumerate().map(row).sum();
        variance.max(0.0).sqrt() / self.divisor(x)
    }
}

fn check(linearity: &Linearity) -> Result<(), Fault> {
    check_made(&linearity.made)?;
    let count = linearity.coefficient.len();
    if !(1..=2).contains(&count) {
        return Err(Fault::new("coefficient", "needs one or two numbers"));
    }
    for coefficient in &linearity.coefficient {
        within("coefficient", *coefficient, -0.5..=0.5, " (a fraction at full scale)")?;
    }
    if linearity.covariance.len() != count || linearity.covariance.iter().any(|row| row.len() != count) {
        let message = format!("needs {count} rows of {count} numbers, as many as `coefficient`");
        return Err(Fault::new("covariance", message));
    }
    for value in linearity.covariance.iter().flatten() {
        within("covariance", *value, -1.0..=1.0, "")?;
    }
    for end_rel in linearity.range_rel {
        within("range_rel", end_rel, 0.0..=1.0, " of full scale")?;
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::super::wavelengths::tests::scale;
    use super::*;

    #[test]
    fn a_polynomial_survives_its_file_and_knows_its_uncertainty() {
        let linearity = Linearity {
            format: FORMAT.to_owned(),
            coefficient: vec![-0.02, 0.01],
            covariance: vec![vec![4e-6, -1e-6], vec![-1e-6, 9e-6]],
            range_rel: [0.01, 0.7],
            made: scale().made,
        };
        let text = toml::to_string(&linearity).unwrap();
        let read = Linearity::parse(Utf8Path::new("l.toml"), &text).unwrap();
        assert_eq!(read, linearity);
        assert!((read.divisor(0.5) - (1.0 - 0.01 + 0.0025)).abs() < 1e-15);
        let variance: f64 = 4e-6 * 0.25 - 2.0 * 1e-6 * 0.125 + 9e-6 * 0.0625;
        assert!((read.u_rel(0.5) - variance.sqrt() / 0.9925).abs() < 1e-9);
        let error = Linearity::parse(Utf8Path::new("l.toml"), &text.replacen("-0.02", "-2.0", 1)).unwrap_err();
        assert!(error.to_string().contains("l.toml:2:1: coefficient: is -2"), "{error}");
    }
}
