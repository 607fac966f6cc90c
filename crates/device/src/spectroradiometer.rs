//! A spectrometer: counts over wavelength.

use std::ops::Range;
use std::time::Duration;

use async_trait::async_trait;
use tokio::time::Instant;

use crate::{DeviceError, Identity};

/// A spectroradiometer.
#[async_trait]
pub trait Spectroradiometer: Send + Sync {
    /// What the instrument said of itself when it was opened.
    fn identity(&self) -> &Identity;

    /// Wavelengths, limits and its own calibration, read when it was opened.
    fn properties(&self) -> &SpectroradiometerProperties;

    /// Sets the integration time of the spectra that follow and discards the one that was begun with the old time.
    /// Returns the time as the instrument reads it back.
    ///
    /// # Errors
    /// [`Unsupported`](DeviceError::Unsupported) outside [`SpectroradiometerProperties::integration_limits`].
    async fn set_integration_time(&self, time: Duration) -> Result<Duration, DeviceError>;

    /// One spectrum whose integration began after the call.
    ///
    /// # Errors
    /// [`Timeout`](DeviceError::Timeout) at `deadline`; [`Malformed`](DeviceError::Malformed) for a spectrum of the
    /// wrong length or without its end mark.
    async fn acquire(&self, deadline: Instant) -> Result<RawSpectrum, DeviceError>;

    /// The next spectrum, at once and confirmed by no second one, for light that changes while it is read. It was
    /// integrated from [`RawSpectrum::began`] on; its detector's temperature is not asked for.
    ///
    /// # Errors
    /// As [`acquire`](Self::acquire), and for a spectrum that was ready before it could be integrated: when its light
    /// was is not known. After an error the next call first proves that the line is in step.
    async fn sample(&self, deadline: Instant) -> Result<RawSpectrum, DeviceError>;
}

/// What is fixed about a spectrometer.
#[derive(Debug, Clone, PartialEq)]
pub struct SpectroradiometerProperties {
    /// Wavelength of each pixel in nm, rising.
    pub wavelength_nm: Vec<f64>,
    /// Pixels that no light reaches.
    pub dark_pixels: Range<usize>,
    /// Shortest and longest integration time.
    pub integration_limits: (Duration, Duration),
    /// Raw counts at which a pixel saturates.
    pub saturation_counts: u16,
    /// Counts at which a pixel saturates after scaling: raw counts are multiplied by this ÷ `saturation_counts`.
    pub full_scale_counts: u16,
    /// Non-linearity polynomial, lowest power first, of the dark-subtracted scaled counts; the counts are divided by
    /// it. Empty: the instrument stores none.
    pub nonlinearity: Vec<f64>,
    /// The irradiance calibration that the instrument itself stores, one factor a pixel: W/(m²·nm) for one linear count
    /// a second. `None` when it stores none.
    pub irradiance_factor: Option<Vec<f64>>,
}

/// One spectrum as the detector gave it.
#[derive(Debug, Clone, PartialEq)]
pub struct RawSpectrum {
    /// Raw counts, one a pixel.
    pub counts: Vec<u16>,
    /// Integration time.
    pub integration_time: Duration,
    /// Temperature of the detector in °C, when the instrument has a sensor.
    pub detector_c: Option<f64>,
    /// No light before this moment contributed.
    pub began: Instant,
    /// No light after this moment contributed.
    pub ended: Instant,
}

/// Why a spectrum could not be made linear.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum LinearisationError {
    /// Another number of pixels than the instrument has.
    #[error("{found} pixels, the instrument has {expected}")]
    Pixels {
        /// Pixels of the instrument.
        expected: usize,
        /// Pixels of the spectrum.
        found: usize,
    },
    /// A dark spectrum taken with another integration time.
    #[error("the dark spectrum was taken with {dark:?}, the light with {light:?}")]
    IntegrationTime {
        /// That of the dark spectrum.
        dark: Duration,
        /// That of the light spectrum.
        light: Duration,
    },
    /// The instrument's polynomial is not above zero there.
    #[error("the non-linearity polynomial is {value} at pixel {pixel}")]
    Polynomial {
        /// The pixel.
        pixel: usize,
        /// The polynomial's value.
        value: f64,
    },
}

impl SpectroradiometerProperties {
    /// Pixels of `raw` at or above saturation: their counts are no measurement.
    pub fn saturated(&self, raw: &RawSpectrum) -> Vec<usize> {
        (0..raw.counts.len())
            .filter(|&pixel| raw.counts[pixel] >= self.saturation_counts)
            .collect()
    }

    /// Counts proportional to light, one a pixel, in the order the manufacturer's software uses (Ocean Optics,
    /// OOINLCorrect): scale to full scale, subtract dark, divide by the non-linearity polynomial. Without a `dark`
    /// spectrum the mean of the dark pixels is subtracted.
    ///
    /// # Errors
    /// [`LinearisationError`] when lengths or integration times differ, or the polynomial is not above zero.
    pub fn linear_counts(&self, raw: &RawSpectrum, dark: Option<&RawSpectrum>) -> Result<Vec<f64>, LinearisationError> {
        let scale = f64::from(self.full_scale_counts) / f64::from(self.saturation_counts.max(1));
        let scaled = |spectrum: &RawSpectrum| -> Result<Vec<f64>, LinearisationError> {
            let (expected, found) = (self.wavelength_nm.len(), spectrum.counts.len());
            if expected != found {
                return Err(LinearisationError::Pixels { expected, found });
            }
            Ok(spectrum
                .counts
                .iter()
                .map(|&counts| f64::from(counts) * scale)
                .collect())
        };
        let mut light = scaled(raw)?;
        if let Some(dark) = dark {
            if dark.integration_time != raw.integration_time {
                return Err(LinearisationError::IntegrationTime {
                    dark: dark.integration_time,
                    light: raw.integration_time,
                });
            }
            light
                .iter_mut()
                .zip(scaled(dark)?)
                .for_each(|(light, dark)| *light -= dark);
        } else if !self.dark_pixels.is_empty() && self.dark_pixels.end <= light.len() {
            let pixels = &light[self.dark_pixels.clone()];
            let mean = pixels.iter().sum::<f64>() / pixels.len() as f64;
            for light in &mut light {
                *light -= mean;
            }
        }
        if !self.nonlinearity.is_empty() {
            for (pixel, counts) in light.iter_mut().enumerate() {
                let value = self
                    .nonlinearity
                    .iter()
                    .rev()
                    .fold(0.0, |sum, coefficient| sum * *counts + coefficient);
                if value <= 0.0 || !value.is_finite() {
                    return Err(LinearisationError::Polynomial { pixel, value });
                }
                *counts /= value;
            }
        }
        Ok(light)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn properties() -> SpectroradiometerProperties {
        SpectroradiometerProperties {
            wavelength_nm: vec![400.0, 500.0, 600.0, 700.0],
            dark_pixels: 0..1,
            integration_limits: (Duration::from_millis(1), Duration::from_secs(1)),
            saturation_counts: 32_768,
            full_scale_counts: 65_535,
            nonlinearity: vec![1.0, -1e-6],
            irradiance_factor: None,
        }
    }

    fn spectrum(counts: [u16; 4], milliseconds: u64) -> RawSpectrum {
        let now = Instant::now();
        RawSpectrum {
            counts: counts.to_vec(),
            integration_time: Duration::from_millis(milliseconds),
            detector_c: None,
            began: now,
            ended: now,
        }
    }

    #[test]
    fn scales_then_subtracts_then_divides() {
        let scale = 65_535.0 / 32_768.0;
        let net = (10_000.0 - 1_000.0) * scale;
        let linear = properties()
            .linear_counts(&spectrum([1_000, 10_000, 1_000, 900], 10), None)
            .unwrap();
        assert_eq!(linear[1], net / (1.0 - 1e-6 * net));
        assert!(linear[3] < 0.0, "noise below dark stays negative");
        let dark = spectrum([500, 2_000, 500, 500], 10);
        let linear = properties()
            .linear_counts(&spectrum([1_000, 10_000, 1_000, 900], 10), Some(&dark))
            .unwrap();
        let net = 8_000.0 * scale;
        assert!((linear[1] - net / (1.0 - 1e-6 * net)).abs() < 1e-9);
    }

    #[test]
    fn refuses_a_dark_of_another_time_and_finds_saturation() {
        let light = spectrum([0, 32_768, 32_767, 40_000], 10);
        assert_eq!(properties().saturated(&light), [1, 3]);
        assert!(matches!(
            properties().linear_counts(&light, Some(&spectrum([0; 4], 20))),
            Err(LinearisationError::IntegrationTime { .. })
        ));
    }
}
