//! A smooth wavelength scale and one bandpass through lines.

use nalgebra::{DMatrix, DVector};

use super::image::Found;

/// From so many on the scale has a bend.
const LINES_FOR_A_BEND: usize = 6;

/// What all lines share, as a share of the bandpass: the responsivity changes over an image, which moves it by
/// fwhm²/6 · d ln R/dλ, some thousandths of a nanometre at a bandpass of 2 nm, and no image is quite symmetric.
const SHARED_REL: f64 = 0.002;

/// A smooth scale through the lines.
pub(super) struct Scale {
    pub offset_nm: Vec<f64>,
    pub covariance_nm2: Vec<Vec<f64>>,
}

impl Scale {
    /// A parabola, or a straight line where there are few, by their uncertainties; where they scatter more, by that.
    pub fn through(found: &[Found]) -> Self {
        let count = if found.len() >= LINES_FOR_A_BEND { 3 } else { 2 };
        let t = |line: &Found| (line.image.centre_nm - 550.0) / 300.0;
        let matrix = DMatrix::from_fn(found.len(), count, |row, column| {
            t(&found[row]).powi(column as i32) / found[row].u_nm
        });
        let offsets = found
            .iter()
            .map(|line| (line.wavelength_nm - line.image.centre_nm) / line.u_nm);
        let offsets = DVector::from_iterator(found.len(), offsets);
        let normal = matrix.transpose() * &matrix;
        // Lines at different wavelengths make it regular.
        let inverse = normal.try_inverse().unwrap_or_else(|| DMatrix::zeros(count, count));
        let coefficients = &inverse * (matrix.transpose() * &offsets);
        let left = offsets - matrix * &coefficients;
        let scatter = (left.norm_squared() / (found.len() - count) as f64).max(1.0);
        let mean_fwhm_nm = found.iter().map(|line| line.image.fwhm_nm).sum::<f64>() / found.len() as f64;
        let mut covariance = inverse * scatter;
        covariance[(0, 0)] += (SHARED_REL * mean_fwhm_nm).powi(2);
        Self {
            offset_nm: coefficients.iter().copied().collect(),
            covariance_nm2: (0..count)
                .map(|row| (0..count).map(|column| covariance[(row, column)]).collect())
                .collect(),
        }
    }

    /// Where a line lies on the scale, less its wavelength.
    pub fn residual_nm(&self, line: &Found) -> f64 {
        let t = (line.image.centre_nm - 550.0) / 300.0;
        let offset_nm = self.offset_nm.iter().rev().fold(0.0, |sum, c| sum * t + c);
        line.image.centre_nm + offset_nm - line.wavelength_nm
    }
}

/// The mean width by the uncertainties of each, and its uncertainty: how it differs from line to line, and what the
/// shape leaves open.
pub(super) fn bandpass(found: &[Found]) -> (f64, f64) {
    let weight = |line: &Found| line.image.u_fwhm_nm.powi(-2);
    let mean_of = |of: &dyn Fn(&Found) -> f64| {
        let sum: f64 = found.iter().map(|line| weight(line) * of(line)).sum();
        sum / found.iter().map(weight).sum::<f64>()
    };
    let mean = mean_of(&|line| line.image.fwhm_nm);
    let scatter = mean_of(&|line| (line.image.fwhm_nm - mean).powi(2)).sqrt();
    let shape = mean_of(&|line| line.u_fwhm_nm);
    (mean, scatter.hypot(shape).max(1e-3 * mean))
}
