//! `read --spectrum`: one spectrum of the light as it is, with its colorimetry.

use camino::Utf8Path;
use isolux_device::{RawSpectrum, SpectroradiometerProperties};
use isolux_scan::{CalibratedSpectro, Devices, ScanError, TwoState, spectrum};
use isolux_spectrum::{Quantities, Spectrum, quantities};
use serde::Serialize;

use crate::Failure;
use crate::front_end::progress::Progress;
use crate::instruments::bench::StationFiles;
use crate::manual::{device, one_step};

/// One spectrum.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Reading {
    /// Integration time that was found, s.
    pub integration_s: f64,
    /// Highest raw counts as a share of saturation.
    pub peak_of_saturation: f64,
    /// Pixels at or above saturation: their values are "at least".
    pub saturated_pixels: usize,
    /// What was subtracted as dark: `dark_pixels` or `shutter`.
    pub dark: &'static str,
    /// Temperature of the detector, °C.
    pub detector_c: Option<f64>,
    /// Illuminance by V(λ) and 683 lm/W, lx.
    pub illuminance_lx: f64,
    /// Irradiance over 360–830 nm, W/m².
    pub irradiance_w_m2: f64,
    /// Everything else; its `integral` and `luminous_integral` are the two above.
    #[serde(flatten)]
    pub quantities: Quantities,
    /// Wavelengths, nm: pixels with a calibration.
    pub wavelength_nm: Vec<f64>,
    /// Spectral irradiance, W/(m² nm).
    pub irradiance_w_m2_nm: Vec<f64>,
}

/// Takes one spectrum with the integration time that its light needs, with lamp, shutter and baffle as they are. An
/// instrument without dark pixels gets its dark from the station's shutter, which is put back as it was.
///
/// # Errors
/// Exit 2 where the station has no spectroradiometer, or nothing to make dark with; else as
/// [`home`](crate::manual::home).
pub fn read(station: &Utf8Path, force: Option<&str>, progress: &dyn Progress) -> Result<Reading, Failure> {
    let source = StationFiles::load(station)?;
    one_step(source, force, progress, async |bench, cancel| {
        bench.spectrum(cancel).await
    })
}

/// What was `taken` on the bench of the file `station`, as irradiance.
///
/// # Errors
/// As [`read`].
pub(crate) fn reading(station: &Utf8Path, taken: Option<Taken>) -> Result<Reading, Failure> {
    let Some((light, dark, properties, factors)) = taken else {
        return Err(Failure::bad_input(format!(
            "{station}: the station has no [spectroradiometer]"
        )));
    };
    if dark.is_none() && properties.dark_pixels.is_empty() {
        return Err(Failure::bad_input(format!(
            "{station}: this spectroradiometer has no dark pixels, and no instrument drives a shutter: its dark cannot be known"
        ))
        .help("give the station a [shutter] with open = …"));
    }
    let linear = properties
        .linear_counts(&light, dark.as_ref())
        .map_err(|error| Failure::instrument(format!("spectroradiometer: {error}")))?;
    let seconds = light.integration_time.as_secs_f64();
    let points = properties.wavelength_nm.iter().zip(&linear).zip(&factors);
    let (wavelength_nm, irradiance_w_m2_nm): (Vec<f64>, Vec<f64>) = points
        .filter(|(_, factor)| **factor > 0.0)
        .map(|((wavelength, counts), factor)| (*wavelength, counts / seconds * factor))
        .unzip();
    let spectrum = Spectrum::new(wavelength_nm.clone(), irradiance_w_m2_nm.clone())
        .map_err(|error| Failure::instrument(format!("spectroradiometer: {error}")))?;
    let quantities = quantities(&spectrum);
    let peak = light.counts.iter().copied().max().unwrap_or(0);
    Ok(Reading {
        integration_s: seconds,
        peak_of_saturation: f64::from(peak) / f64::from(properties.saturation_counts.max(1)),
        saturated_pixels: properties.saturated(&light).len(),
        dark: if dark.is_some() { "shutter" } else { "dark_pixels" },
        detector_c: light.detector_c,
        illuminance_lx: quantities.luminous_integral,
        irradiance_w_m2: quantities.integral,
        quantities,
        wavelength_nm,
        irradiance_w_m2_nm,
    })
}

/// Light, dark where it was taken, what the instrument is, and the factors to irradiance.
pub(crate) type Taken = (RawSpectrum, Option<RawSpectrum>, SpectroradiometerProperties, Vec<f64>);

/// Takes light, and dark where the instrument cannot do without; none where the bench has no spectroradiometer.
///
/// # Errors
/// What the instruments report.
pub(crate) async fn take(devices: &Devices) -> Result<Option<Taken>, ScanError> {
    let Some(spectro) = &devices.spectro else {
        return Ok(None);
    };
    let time = spectrum::expose(spectro, None).await?;
    let light = spectrum::acquire(spectro, time).await?;
    let dark = match &devices.shutter {
        Some(TwoState::Device(shutter)) if spectro.device.properties().dark_pixels.is_empty() => {
            let before = shutter.state().await.map_err(device("shutter"))?;
            shutter.set(false).await.map_err(device("shutter"))?;
            let dark = spectrum::acquire(spectro, time).await;
            shutter.set(before).await.map_err(device("shutter"))?;
            Some(dark?)
        }
        _ => None,
    };
    let CalibratedSpectro {
        device, factor_w_m2_nm, ..
    } = spectro;
    Ok(Some((light, dark, device.properties().clone(), factor_w_m2_nm.clone())))
}
