//! One spectrum: exposure from raw counts, light and dark with the same integration time.

use std::time::Duration;

use isolux_device::{DeviceError, RawSpectrum, awake};
use isolux_record::limits::Limits;
use isolux_record::spectra::Pixel;
use tokio::time::Instant;

use crate::devices::CalibratedSpectro;
use crate::error::ScanError;

/// Peak of the raw counts aimed at where a plan names none, as a share of saturation.
const AIM: f64 = 0.7;
/// A peak within this band, in shares of the aim, is good enough: 40 % to 90 % of saturation without an aim of a plan.
const BAND: [f64; 2] = [0.4 / AIM, 0.9 / AIM];
/// Above this share of saturation no peak is good.
const MOST: f64 = 0.9;
const MOST_EXPOSURES: u32 = 12;
/// Longer integrations than this only make the day long.
const LONGEST: Duration = Duration::from_secs(10);
/// By so many counts the dark level may differ between two spectra.
const DARK_LEVEL_COUNTS: f64 = 20.0;

/// Means of several spectra of one kind.
#[derive(Debug, Clone, PartialEq)]
pub struct Mean {
    counts: Vec<f64>,
    u_counts: Vec<f64>,
    saturated: Vec<bool>,
    /// Middle of the first and the last integration.
    pub middle: Instant,
    /// Mean temperature of the detector.
    pub detector_c: Option<f64>,
    /// Sum over all pixels above the dark level, of each spectrum.
    totals: Vec<f64>,
}

/// Finds the integration time at which the peak of the raw counts is near `aim`, a share of saturation; without one
/// between 40 % and 90 % of it. Light that is too weak for that within ten seconds is taken with ten seconds.
///
/// # Errors
/// [`ScanError::Exposure`] when even the shortest time saturates; what the instrument reports.
pub async fn expose(spectro: &CalibratedSpectro, aim: Option<f64>) -> Result<Duration, ScanError> {
    let aim = aim.unwrap_or(AIM);
    let band = BAND[0] * aim..=(BAND[1] * aim).min(MOST);
    let properties = spectro.device.properties();
    let (shortest, longest) = properties.integration_limits;
    let longest = longest.min(LONGEST);
    let saturation = f64::from(properties.saturation_counts);
    let mut time = Duration::from_millis(10).clamp(shortest, longest);
    let mut peak = 0.0;
    for _ in 0..MOST_EXPOSURES {
        time = spectro
            .device
            .set_integration_time(time)
            .await
            .map_err(ScanError::device("spectroradiometer"))?;
        let raw = acquire(spectro, time).await?;
        let dark = dark_level(spectro, &raw);
        peak = raw.counts.iter().copied().map(f64::from).fold(0.0, f64::max);
        if band.contains(&(peak / saturation)) || (peak / saturation < aim && time >= longest) {
            return Ok(time);
        }
        // A saturated peak says only "less"; otherwise light above dark is proportional to time.
        let factor = if peak >= saturation * 0.98 {
            0.2
        } else {
            (aim * saturation - dark) / (peak - dark).max(1.0)
        };
        let next = time.mul_f64(factor.clamp(0.05, 20.0)).clamp(shortest, longest);
        if next == time {
            break;
        }
        time = next;
    }
    Err(ScanError::Exposure {
        peak_counts: peak,
        saturation_counts: saturation,
        integration_s: time.as_secs_f64(),
    })
}

/// Sums over several spectra of one kind.
pub struct Sums<'a> {
    spectro: &'a CalibratedSpectro,
    sum: Vec<f64>,
    squares: Vec<f64>,
    saturated: Vec<bool>,
    bounds: Option<(Instant, Instant)>,
    temperatures: Vec<f64>,
    totals: Vec<f64>,
}

impl<'a> Sums<'a> {
    /// No spectrum yet.
    pub fn new(spectro: &'a CalibratedSpectro) -> Self {
        let pixels = spectro.device.properties().wavelength_nm.len();
        Self {
            spectro,
            sum: vec![0.0; pixels],
            squares: vec![0.0; pixels],
            saturated: vec![false; pixels],
            bounds: None,
            temperatures: Vec::new(),
            totals: Vec::new(),
        }
    }

    /// One spectrum more.
    ///
    /// # Errors
    /// [`ScanError::Device`] for another number of pixels than the instrument has.
    pub fn add(&mut self, raw: &RawSpectrum) -> Result<(), ScanError> {
        let properties = self.spectro.device.properties();
        let (pixels, found) = (self.sum.len(), raw.counts.len());
        if found != pixels {
            let source = DeviceError::malformed(
                &self.spectro.device.identity().target,
                "acquire",
                format!("{found} pixels, the instrument has {pixels}"),
                Vec::new(),
            );
            return Err(ScanError::Device {
                role: "spectroradiometer",
                source,
            });
        }
        let mut total = 0.0;
        for (pixel, &counts) in raw.counts.iter().enumerate() {
            let value = f64::from(counts);
            self.sum[pixel] += value;
            self.squares[pixel] += value * value;
            self.saturated[pixel] |= counts >= properties.saturation_counts;
            total += value;
        }
        self.totals.push(total - dark_level(self.spectro, raw) * pixels as f64);
        self.bounds = Some((self.bounds.map_or(raw.began, |(began, _)| began), raw.ended));
        self.temperatures.extend(raw.detector_c);
        Ok(())
    }

    /// The means.
    pub fn mean(self) -> Mean {
        let n = self.totals.len().max(1) as f64;
        let counts: Vec<f64> = self.sum.iter().map(|sum| sum / n).collect();
        // Scatter of the mean; rounding to whole counts is always there, rectangular, and not reduced by repeats.
        let u_counts = counts
            .iter()
            .zip(&self.squares)
            .map(|(mean, squares)| {
                let variance = if n > 1.0 {
                    ((squares / n - mean * mean) * n / (n - 1.0)).max(0.0) / n
                } else {
                    0.0
                };
                (variance + 1.0 / 12.0).sqrt()
            })
            .collect();
        let (began, ended) = self.bounds.unwrap_or_else(|| (Instant::now(), Instant::now()));
        let count = self.temperatures.len();
        Mean {
            counts,
            u_counts,
            saturated: self.saturated,
            middle: began + ended.saturating_duration_since(began) / 2,
            detector_c: (count > 0).then(|| self.temperatures.iter().sum::<f64>() / count as f64),
            totals: self.totals,
        }
    }
}

impl Mean {
    /// Whether the spectra agree in their total, which is their light: within the plan's limit for light that comes
    /// back, and so many standard uncertainties of the scatter of the pixels and of the dark level.
    ///
    /// # Errors
    /// [`ScanError::Spectra`] with the first that does not.
    pub fn agrees(&self, limits: &Limits) -> Result<(), ScanError> {
        let mut sorted = self.totals.clone();
        sorted.sort_by(f64::total_cmp);
        let Some(&median) = sorted.get(sorted.len() / 2) else {
            return Ok(());
        };
        // u_counts are those of the mean; one spectrum scatters √n times as much. A count of the dark level is one of
        // all pixels.
        let n = self.totals.len() as f64;
        let scatter = (self.u_counts.iter().map(|u| u * u).sum::<f64>() * n).sqrt();
        let allowed = limits.reference_rel() * median.abs()
            + limits.repeats_sigma() * scatter
            + self.counts.len() as f64 * DARK_LEVEL_COUNTS;
        match self.totals.iter().find(|total| (*total - median).abs() > allowed) {
            None => Ok(()),
            Some(&found) => Err(ScanError::Spectra { found, median, allowed }),
        }
    }
}

/// Light and dark, pixel by pixel.
pub fn pixels(spectro: &CalibratedSpectro, light: &Mean, dark: &Mean) -> Vec<Pixel> {
    let wavelength_nm = &spectro.device.properties().wavelength_nm;
    (0..wavelength_nm.len().min(spectro.factor_w_m2_nm.len()))
        .map(|pixel| Pixel {
            wavelength_nm: wavelength_nm[pixel],
            counts: light.counts[pixel],
            u_counts: light.u_counts[pixel],
            dark_counts: dark.counts[pixel],
            u_dark_counts: dark.u_counts[pixel],
            saturated: light.saturated[pixel],
            factor_w_m2_nm: spectro.factor_w_m2_nm[pixel],
        })
        .collect()
}

/// The calibration's factors at the instrument's wavelengths: linear between the points of the table, zero outside it,
/// because nothing is known there.
pub fn factors_at(wavelength_nm: &[f64], table: &[(f64, f64)]) -> Vec<f64> {
    wavelength_nm
        .iter()
        .map(|&wavelength| {
            let above = table.partition_point(|(at, _)| *at < wavelength);
            match (
                above.checked_sub(1).and_then(|below| table.get(below)),
                table.get(above),
            ) {
                (_, Some(&(at, factor))) if at == wavelength => factor,
                (Some(&(low, first)), Some(&(high, second))) => {
                    first + (second - first) * (wavelength - low) / (high - low)
                }
                _ => 0.0,
            }
        })
        .collect()
}

/// One spectrum with the integration time that is set; asked once more when it was lost or damaged.
///
/// # Errors
/// What the instrument reports.
pub async fn acquire(spectro: &CalibratedSpectro, time: Duration) -> Result<RawSpectrum, ScanError> {
    let patience = 3 * time + Duration::from_secs(5);
    let mut tries = 0;
    loop {
        tries += 1;
        let deadline = Instant::now() + patience;
        let source = match awake::until(deadline + Duration::from_secs(2), spectro.device.acquire(deadline)).await {
            Some(Ok(raw)) => return Ok(raw),
            Some(Err(error)) => error,
            None => DeviceError::Timeout {
                device: spectro.device.identity().target.clone(),
                action: "acquire".to_owned(),
                waited: patience,
                received: Vec::new(),
            },
        };
        let again = matches!(
            source.kind(),
            isolux_device::ErrorKind::Timeout | isolux_device::ErrorKind::Malformed
        );
        if !again || tries == 2 {
            return Err(ScanError::Device {
                role: "spectroradiometer",
                source,
            });
        }
    }
}

fn dark_level(spectro: &CalibratedSpectro, raw: &RawSpectrum) -> f64 {
    let pixels = &spectro.device.properties().dark_pixels;
    match raw.counts.get(pixels.clone()) {
        Some(dark) if !dark.is_empty() => dark.iter().copied().map(f64::from).sum::<f64>() / dark.len() as f64,
        _ => 0.0,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn factors_are_linear_inside_the_table_and_nothing_outside() {
        let table = [(400.0, 1.0), (500.0, 3.0), (600.0, 2.0)];
        assert_eq!(
            factors_at(&[399.0, 400.0, 450.0, 500.0, 575.0, 600.0, 601.0], &table),
            [0.0, 1.0, 2.0, 3.0, 2.25, 2.0, 0.0]
        );
    }
}
