//! Counts of a spectroradiometer → linear counts a second at true wavelengths, by what the laboratory found of it.
//!
//! The order is that of light through the instrument, backwards: dark, linearity of detector and converter, scattered
//! light, bandpass of slit and grating, wavelength of a pixel, factor.

use std::collections::BTreeSet;

use isolux_record::spectra::{DarkSubtraction, Scatter, SpectralCalibration, SpectrumError, SpectrumRecord};
use nalgebra::{DMatrix, DVector};

use crate::correction::Correction;

/// Which corrections are on.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Chain {
    /// The dark.
    pub dark: DarkSubtraction,
    /// The wavelength scale.
    pub wavelengths: bool,
    /// The bandpass.
    pub bandpass: bool,
    /// Light scattered inside.
    pub scatter: bool,
    /// What is left of the non-linearity.
    pub linearity: bool,
}

impl Chain {
    /// All of them: whatever the station names.
    pub const ALL: Self = Self {
        dark: DarkSubtraction::Spectrum,
        wavelengths: true,
        bandpass: true,
        scatter: true,
        linearity: true,
    };

    /// All but those that are switched off.
    pub fn without(without: &BTreeSet<Correction>) -> Self {
        let on = |correction| !without.contains(&correction);
        Self {
            dark: if on(Correction::SpectralDark) {
                DarkSubtraction::Spectrum
            } else {
                DarkSubtraction::Off
            },
            wavelengths: on(Correction::Wavelengths),
            bandpass: on(Correction::Bandpass),
            scatter: on(Correction::Scatter),
            linearity: on(Correction::SpectralLinearity),
        }
    }
}

/// Linear counts a second of every pixel.
#[derive(Debug, Clone, PartialEq)]
pub struct Linear {
    /// True wavelength of each pixel, nm.
    pub wavelength_nm: Vec<f64>,
    /// Counts a second; none where saturated.
    pub per_s: Vec<Option<f64>>,
    /// Their standard uncertainty from the scatter of light and dark.
    pub u_per_s: Vec<f64>,
}

impl Linear {
    /// Of a record, with its bandpass still in it.
    ///
    /// # Errors
    /// [`SpectrumError`] where the instrument's own linearity polynomial has no meaning.
    pub fn of(record: &SpectrumRecord, calibration: &SpectralCalibration, chain: Chain) -> Result<Self, SpectrumError> {
        let mut counts = record.clone();
        counts.pixels.iter_mut().for_each(|pixel| pixel.factor_w_m2_nm = 1.0);
        let mut light = counts.irradiance(calibration, chain.dark)?;
        let stated = record.pixels.iter().map(|pixel| pixel.wavelength_nm);
        let wavelength_nm = if chain.wavelengths {
            stated.map(|nm| calibration.corrections.true_nm(nm)).collect()
        } else {
            stated.collect()
        };
        if let Some(linearity) = calibration.corrections.linearity.as_ref().filter(|_| chain.linearity) {
            let of_full_scale = record.integration_s / calibration.full_scale_counts;
            let values = light.irradiance_w_m2_nm.iter_mut().zip(&mut light.u_w_m2_nm);
            for (value, u) in values.filter_map(|(value, u)| Some((value.as_mut()?, u))) {
                let divisor = linearity.divisor(*value * of_full_scale);
                *value /= divisor;
                *u /= divisor;
            }
        }
        let mut linear = Self {
            wavelength_nm,
            per_s: light.irradiance_w_m2_nm,
            u_per_s: light.u_w_m2_nm,
        };
        if let Some(scatter) = calibration.corrections.scatter.as_ref().filter(|_| chain.scatter) {
            // The optically black pixels are covered: no light of any kind reaches them.
            linear.gather(scatter, calibration.dark_pixels);
        }
        Ok(linear)
    }

    /// Takes the light away that `scatter` says is scattered. With Y the counts that the bands show, X those of their
    /// own light and D the shares, Y = X + D·X (Zong et al., Appl. Opt. 45, 1111, 2006, equations 3 to 7).
    fn gather(&mut self, scatter: &Scatter, black: [usize; 2]) {
        let bands = scatter.edges_nm.len() + 1;
        let is_black = |place: usize| (black[0]..black[1]).contains(&place);
        let (mut shown, mut pixels) = (DVector::zeros(bands), vec![0.0; bands]);
        for (place, value) in self.per_s.iter().enumerate().filter(|(place, _)| !is_black(*place)) {
            let band = scatter.band(self.wavelength_nm[place]);
            shown[band] += value.unwrap_or_default();
            pixels[band] += 1.0;
        }
        let shares = DMatrix::from_fn(bands, bands, |row, column| scatter.share_rel[row][column]);
        let whole = DMatrix::identity(bands, bands) + &shares;
        // Shares are small against 1: the matrix is regular.
        let Some(own) = whole.lu().solve(&shown) else { return };
        let scattered = shares * own;
        for (place, value) in self.per_s.iter_mut().enumerate().filter(|(place, _)| !is_black(*place)) {
            let band = scatter.band(self.wavelength_nm[place]);
            if let Some(value) = value {
                *value -= scattered[band] / pixels[band];
            }
        }
    }
}

/// The bandpass that is corrected for, nm; none where the station names none or the correction is off.
pub fn bandpass_nm(calibration: &SpectralCalibration, chain: Chain) -> Option<f64> {
    let scale = calibration
        .corrections
        .wavelengths
        .as_ref()
        .filter(|_| chain.bandpass)?;
    Some(scale.fwhm_nm)
}

/// The calibration with one input of its corrections after the other moved by its standard uncertainty, each with its
/// part of a budget. Of the wavelength scale the station states `u_wavelength_nm`.
pub fn moved(calibration: &SpectralCalibration, chain: Chain) -> Vec<(&'static str, SpectralCalibration)> {
    let mut all = Vec::new();
    if chain.bandpass && calibration.corrections.wavelengths.is_some() {
        let mut wider = calibration.clone();
        if let Some(scale) = &mut wider.corrections.wavelengths {
            scale.fwhm_nm += scale.u_fwhm_nm;
        }
        all.push(("bandpass", wider));
    }
    if chain.scatter && calibration.corrections.scatter.is_some() {
        let mut more = calibration.clone();
        if let Some(scatter) = &mut more.corrections.scatter {
            scatter.move_by(1.0);
        }
        all.push(("scatter", more));
    }
    if let Some(linearity) = calibration.corrections.linearity.as_ref().filter(|_| chain.linearity) {
        // Each column of the root of the covariance is one standard uncertainty of its own.
        for (part, column) in ["spectral_linearity", "spectral_linearity_bend"]
            .into_iter()
            .zip(root(&linearity.covariance))
        {
            let mut bent = calibration.clone();
            if let Some(linearity) = &mut bent.corrections.linearity {
                linearity
                    .coefficient
                    .iter_mut()
                    .zip(&column)
                    .for_each(|(c, change)| *c += change);
            }
            all.push((part, bent));
        }
    }
    all
}

/// What the station names and `chain` leaves out, as what is missing in the colour of a spectrum.
pub fn left_out(calibration: &SpectralCalibration, chain: Chain) -> Vec<String> {
    let corrections = &calibration.corrections;
    let named = [
        (
            corrections.wavelengths.is_some() && !chain.wavelengths,
            "the wavelength scale",
        ),
        (corrections.wavelengths.is_some() && !chain.bandpass, "the bandpass"),
        (corrections.scatter.is_some() && !chain.scatter, "the scattered light"),
        (corrections.linearity.is_some() && !chain.linearity, "the linearity"),
    ];
    let off = named.into_iter().filter(|(off, _)| *off);
    off.map(|(_, what)| format!("not corrected for {what} of the spectroradiometer"))
        .collect()
}

/// Columns whose products summed are the covariance: what is drawn or moved independently of each other.
pub fn root(covariance: &[Vec<f64>]) -> Vec<Vec<f64>> {
    let count = covariance.len();
    let matrix = DMatrix::from_fn(count, count, |row, column| {
        0.5 * (covariance[row][column] + covariance[column][row])
    });
    let of = matrix.symmetric_eigen();
    let column = |place: usize| {
        let u = of.eigenvalues[place].max(0.0).sqrt();
        of.eigenvectors.column(place).iter().map(|share| share * u).collect()
    };
    (0..count).map(column).collect()
}

#[cfg(test)]
mod tests {
    use isolux_record::spectra::Made;

    use super::*;

    fn light(per_s: &[f64]) -> Linear {
        Linear {
            wavelength_nm: (0..per_s.len()).map(|place| 400.0 + 10.0 * place as f64).collect(),
            per_s: per_s.iter().copied().map(Some).collect(),
            u_per_s: vec![0.0; per_s.len()],
        }
    }

    #[test]
    fn scattered_light_goes_back_where_it_came_from() {
        let own = [0.0, 0.0, 900.0, 100.0, 50.0, 0.0, 0.0, 10.0];
        let scatter = Scatter {
            format: String::new(),
            edges_nm: vec![430.0, 450.0],
            share_rel: vec![vec![0.01, 0.02, 0.03], vec![0.0, 0.004, 0.01], vec![0.02, 0.0, 0.05]],
            u_share_rel: vec![vec![0.0; 3]; 3],
            made: Made {
                instrument: String::new(),
                day: String::new(),
                with: String::new(),
                record_sha256: String::new(),
            },
        };
        // The first pixel is black. Bands: pixels 1 to 2, 3 to 4, 5 to 7.
        let of_band = [900.0, 150.0, 10.0];
        let pixels = [2.0, 2.0, 3.0];
        let shown: Vec<f64> = (0..own.len())
            .map(|place| {
                let band = scatter.band(400.0 + 10.0 * place as f64);
                let falls: f64 = (0..3).map(|from| scatter.share_rel[band][from] * of_band[from]).sum();
                own[place] + if place == 0 { 0.0 } else { falls / pixels[band] }
            })
            .collect();
        let mut linear = light(&shown);
        linear.gather(&scatter, [0, 1]);
        for (found, expected) in linear.per_s.iter().zip(own) {
            assert!((found.unwrap() - expected).abs() < 1e-9, "{found:?} {expected}");
        }
    }

    #[test]
    fn the_root_of_a_covariance_makes_it_again() {
        let covariance = vec![vec![4.0, -1.0], vec![-1.0, 9.0]];
        let root = root(&covariance);
        for row in 0..2 {
            for column in 0..2 {
                let sum: f64 = root.iter().map(|of| of[row] * of[column]).sum();
                assert!((sum - covariance[row][column]).abs() < 1e-12);
            }
        }
    }
}
