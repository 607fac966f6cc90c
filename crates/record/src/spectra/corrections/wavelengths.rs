//! `isolux-wavelengths/1`: how far the wavelengths that a spectroradiometer states are off, and its bandpass.

use camino::Utf8Path;
use serde::{Deserialize, Serialize};

use super::{Made, check_made, parse};
use crate::document::bounds::{above, within};
use crate::document::{DocumentError, Fault};

/// Value of `format`.
pub const FORMAT: &str = "isolux-wavelengths/1";

/// The wavelength scale and the bandpass of a spectroradiometer.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct WavelengthScale {
    /// [`FORMAT`].
    pub format: String,
    /// True wavelength less the one that the instrument states: Σ `offset_nm[k]`·tᵏ, t = (stated − 550 nm)/300 nm.
    pub offset_nm: Vec<f64>,
    /// Covariance of these coefficients.
    pub covariance_nm2: Vec<Vec<f64>>,
    /// Shortest and longest wavelength of the lines.
    pub range_nm: [f64; 2],
    /// Full width at half maximum of the bandpass: of the triangle with the variance of the images of the lines.
    pub fwhm_nm: f64,
    /// Its standard uncertainty (k = 1).
    pub u_fwhm_nm: f64,
    /// Where it comes from.
    pub made: Made,
    /// The lines.
    pub line: Vec<LineFound>,
}

/// A line in the record.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct LineFound {
    /// Its wavelength in air.
    pub wavelength_nm: f64,
    /// Where the instrument shows it.
    pub stated_nm: f64,
    /// Standard uncertainty of that from noise.
    pub u_nm: f64,
    /// Where it lies on the corrected scale, less its wavelength.
    pub residual_nm: f64,
    /// Full width at half maximum of the triangle with the variance of its image.
    pub fwhm_nm: f64,
}

impl WavelengthScale {
    /// Reads a file.
    ///
    /// # Errors
    /// [`DocumentError`] with file and line.
    pub fn parse(file: &Utf8Path, text: &str) -> Result<Self, DocumentError> {
        parse(file, text, FORMAT, check)
    }

    /// The true wavelength where the instrument states `stated_nm`.
    pub fn true_nm(&self, stated_nm: f64) -> f64 {
        let t = place(stated_nm);
        stated_nm + self.offset_nm.iter().rev().fold(0.0, |sum, c| sum * t + c)
    }

    /// Standard uncertainty of that (k = 1).
    pub fn u_nm(&self, stated_nm: f64) -> f64 {
        let t = place(stated_nm);
        let row = |(j, row): (usize, &Vec<f64>)| -> f64 {
            let terms = row.iter().enumerate();
            terms.map(|(k, value)| value * t.powi((j + k) as i32)).sum()
        };
        self.covariance_nm2
            .iter()
            .enumerate()
            .map(row)
            .sum::<f64>()
            .max(0.0)
            .sqrt()
    }
}

/// t of the polynomial.
fn place(stated_nm: f64) -> f64 {
    (stated_nm - 550.0) / 300.0
}

fn check(scale: &WavelengthScale) -> Result<(), Fault> {
    check_made(&scale.made)?;
    let count = scale.offset_nm.len();
    if !(1..=5).contains(&count) {
        return Err(Fault::new("offset_nm", "needs 1 to 5 coefficients"));
    }
    for offset_nm in &scale.offset_nm {
        within("offset_nm", *offset_nm, -50.0..=50.0, " nm")?;
    }
    if scale.covariance_nm2.len() != count || scale.covariance_nm2.iter().any(|row| row.len() != count) {
        return Err(Fault::new(
            "covariance_nm2",
            format!("needs {count} rows of {count} numbers, as many as `offset_nm`"),
        ));
    }
    for value in scale.covariance_nm2.iter().flatten() {
        within("covariance_nm2", *value, -1e4..=1e4, " nm²")?;
    }
    for end_nm in scale.range_nm {
        within("range_nm", end_nm, 100.0..=10_000.0, " nm")?;
    }
    within("fwhm_nm", scale.fwhm_nm, 0.01..=50.0, " nm")?;
    above(
        "u_fwhm_nm",
        scale.u_fwhm_nm,
        0.0..=0.5 * scale.fwhm_nm,
        " nm, half of fwhm_nm",
    )
}

#[cfg(test)]
pub(crate) mod tests {
    use super::*;

    pub(crate) fn scale() -> WavelengthScale {
        WavelengthScale {
            format: FORMAT.to_owned(),
            offset_nm: vec![0.3, -0.1],
            covariance_nm2: vec![vec![1e-4, 2e-5], vec![2e-5, 4e-4]],
            range_nm: [404.66, 912.3],
            fwhm_nm: 2.5,
            u_fwhm_nm: 0.05,
            made: Made {
                instrument: "USB2000+ 1".to_owned(),
                day: "2026-11-28".to_owned(),
                with: "mercury_argon".to_owned(),
                record_sha256: "00".to_owned(),
            },
            line: vec![LineFound {
                wavelength_nm: 546.075,
                stated_nm: 545.775,
                u_nm: 0.002,
                residual_nm: 0.001,
                fwhm_nm: 2.5,
            }],
        }
    }

    #[test]
    fn a_scale_survives_its_file_and_what_is_wrong_is_refused_with_its_line() {
        let text = toml::to_string(&scale()).unwrap();
        let file = Utf8Path::new("w.toml");
        assert_eq!(WavelengthScale::parse(file, &text).unwrap(), scale());
        let of = scale();
        assert!((of.true_nm(550.0) - 550.3).abs() < 1e-12 && (of.true_nm(850.0) - 850.2).abs() < 1e-12);
        assert!((of.u_nm(550.0) - 0.01).abs() < 1e-12);
        // At t = 1 all four add: 1 + 2·0.2 + 4 in units of 10⁻⁴ nm².
        assert!((of.u_nm(850.0) - 5.4e-4_f64.sqrt()).abs() < 1e-12);
        for (from, to, expected) in [
            (
                "isolux-wavelengths/1",
                "isolux-wavelengths/9",
                "expected \"isolux-wavelengths/1\"",
            ),
            (
                "[0.3, -0.1]",
                "[0.3]",
                "w.toml:3:1: covariance_nm2: needs 1 rows of 1 numbers",
            ),
            ("fwhm_nm = 2.5", "fwhm_nm = 0.0", "w.toml:5:1: fwhm_nm: is 0"),
            ("u_fwhm_nm = 0.05", "u_fwhm_nm = 2.0", "u_fwhm_nm: is 2"),
            ("2026-11-28", "28.11.2026", "is no day"),
        ] {
            assert!(text.contains(from), "{text}");
            let error = WavelengthScale::parse(file, &text.replacen(from, to, 1)).unwrap_err();
            assert!(error.to_string().contains(expected), "{error}");
        }
    }
}
