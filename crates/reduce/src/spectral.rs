//! Counts of the spectroradiometer → spectral irradiance on the axis, with the numbers that follow and their uncertainty.

use isolux_record::ReadingKind;
use isolux_record::run::RunHeader;
use isolux_record::spectra::{DarkSubtraction, SpectralIrradiance, SpectrumRecord};
use isolux_spectrum::Spectrum;
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};
use serde::Serialize;

use crate::correction::{Correction, Switches};
use crate::error::ReduceError;
use crate::uncertainty::{Combined, Part};

/// Draws of the pixel noise from which the uncertainty of non-linear results (CCT, efficacy) is taken (GUM Supplement 1).
const DRAWS: u64 = 200;
/// Their seed: the same run gives the same bytes.
const SEED: u64 = 1;

/// Spectral irradiance on the axis and what follows from it.
#[derive(Debug, Clone, PartialEq)]
pub struct SpectralReduction {
    /// Spectral irradiance in W/m²/nm at the instrument.
    pub spectrum: Spectrum,
    /// Standard uncertainty of each point from noise of light and dark, in W/m²/nm.
    pub u_noise: Vec<f64>,
    /// Distance of the instrument's reference plane.
    pub distance_mm: f64,
    /// Irradiance over 360–830 nm in W/m².
    pub irradiance_w_m2: Combined,
    /// Illuminance from the spectrum in lx.
    pub illuminance_lx: Combined,
    /// Luminous efficacy of radiation in lm/W.
    pub ler_lm_per_w: Combined,
    /// Correlated colour temperature in K; none for light that has none.
    pub cct_k: Option<Combined>,
    /// Whether the dark spectrum was subtracted.
    pub dark_subtracted: bool,
    /// Uncertainties that the station does not state.
    pub not_stated: Vec<&'static str>,
    /// Wavelengths that the instrument does not reach within 360–830 nm, as remarks.
    pub remarks: Vec<String>,
}

/// What one draw of the noise, or the spectrum itself, gives.
#[derive(Clone, Copy, Default, Serialize)]
struct Derived {
    irradiance: f64,
    illuminance: f64,
    ler: f64,
    cct: f64,
}

/// Reduces the first lit spectrum of a run. None when there is no lit spectrum.
///
/// # Errors
/// [`ReduceError::Spectrum`] for saturated pixels within 360–830 nm and for a spectrum without light.
pub fn reduce_spectrum(
    header: &RunHeader,
    spectra: &[SpectrumRecord],
    switches: &Switches,
) -> Result<Option<SpectralReduction>, ReduceError> {
    let (Some(record), Some(calibration)) = (
        spectra.iter().find(|spectrum| spectrum.kind == ReadingKind::Lit),
        &header.spectral,
    ) else {
        return Ok(None);
    };
    let wrong = |message: String| ReduceError::Spectrum {
        index: record.index,
        message,
    };
    let dark_subtracted = switches.on(Correction::SpectralDark);
    let dark = if dark_subtracted {
        DarkSubtraction::Spectrum
    } else {
        DarkSubtraction::Off
    };
    let irradiance = record
        .irradiance(calibration, dark)
        .map_err(|error| wrong(error.to_string()))?;
    let (spectrum, u_noise) = points(record, &irradiance, calibration.dark_pixels)?;

    let own = derive(&spectrum).ok_or_else(|| wrong("it holds no light".to_owned()))?;
    let noise = noise_of(&spectrum, &u_noise);
    let instrument = header.station.spectroradiometer();
    let u_calibration = instrument.and_then(|instrument| instrument.u_rel);
    let u_distance = instrument
        .and_then(|i| i.u_distance_mm)
        .map(|u| 2.0 * u / record.distance_mm);
    let mut not_stated = Vec::new();
    if u_calibration.is_none() {
        not_stated.push("calibration (spectroradiometer.u_rel)");
    }
    if u_distance.is_none() {
        not_stated.push("distance (spectroradiometer.u_distance_mm)");
    }
    // Calibration and distance move the level, not the shape: they cancel in efficacy and colour.
    let level = |value: f64, noise: f64| {
        combined(
            value,
            noise,
            &[
                ("calibration", value * u_calibration.unwrap_or(0.0)),
                ("distance", value * u_distance.unwrap_or(0.0)),
            ],
        )
    };
    Ok(Some(SpectralReduction {
        irradiance_w_m2: level(own.irradiance, noise.irradiance),
        illuminance_lx: level(own.illuminance, noise.illuminance),
        ler_lm_per_w: combined(own.ler, noise.ler, &[]),
        cct_k: (own.cct > 0.0).then(|| combined(own.cct, noise.cct, &[])),
        remarks: reach(&spectrum),
        spectrum,
        u_noise,
        distance_mm: record.distance_mm,
        dark_subtracted,
        not_stated,
    }))
}

/// The pixels that see light and whose wavelength carries into 360–830 nm, as a spectrum.
fn points(
    record: &SpectrumRecord,
    irradiance: &SpectralIrradiance,
    dark_pixels: [usize; 2],
) -> Result<(Spectrum, Vec<f64>), ReduceError> {
    let wrong = |message: String| ReduceError::Spectrum {
        index: record.index,
        message,
    };
    let (mut wavelengths, mut values, mut u) = (Vec::new(), Vec::new(), Vec::new());
    for (index, pixel) in record.pixels.iter().enumerate() {
        // One nanometre beyond the range on either side, so that 360 and 830 nm lie between points.
        let in_range = (359.0..=831.0).contains(&pixel.wavelength_nm);
        if !in_range || (dark_pixels[0]..dark_pixels[1]).contains(&index) {
            continue;
        }
        let value = irradiance.irradiance_w_m2_nm[index].ok_or_else(|| {
            wrong(format!(
                "pixel {index} at {:.2} nm is saturated; measure with a shorter integration",
                pixel.wavelength_nm
            ))
        })?;
        wavelengths.push(pixel.wavelength_nm);
        values.push(value);
        u.push(irradiance.u_w_m2_nm[index]);
    }
    let spectrum = Spectrum::new(wavelengths, values).map_err(|error| wrong(error.to_string()))?;
    Ok((spectrum, u))
}

fn derive(spectrum: &Spectrum) -> Option<Derived> {
    let irradiance = spectrum.integral();
    let ler = spectrum.ler_lm_per_w()?.value();
    let cct = spectrum.cct().map_or(0.0, |cct| cct.cct_k);
    Some(Derived {
        irradiance,
        illuminance: spectrum.luminous_integral(),
        ler,
        cct,
    })
}

/// Standard deviation of what follows over draws of the pixel noise; draw k has its own stream, so that the result does not
/// depend on an order.
fn noise_of(spectrum: &Spectrum, u_noise: &[f64]) -> Derived {
    let mut draws = Vec::new();
    for draw in 0..DRAWS {
        let mut random = ChaCha8Rng::seed_from_u64(SEED);
        random.set_stream(draw);
        let value = spectrum
            .value()
            .iter()
            .zip(u_noise)
            .map(|(value, u)| {
                let z: f64 = StandardNormal.sample(&mut random);
                value + u * z
            })
            .collect();
        draws.extend(
            Spectrum::new(spectrum.wavelength_nm().to_vec(), value)
                .ok()
                .as_ref()
                .and_then(derive),
        );
    }
    let spread = |of: fn(&Derived) -> f64| {
        let n = draws.len() as f64;
        let mean = draws.iter().map(of).sum::<f64>() / n;
        (draws.iter().map(|draw| (of(draw) - mean).powi(2)).sum::<f64>() / (n - 1.0)).sqrt()
    };
    if draws.len() < 2 {
        return Derived::default();
    }
    Derived {
        irradiance: spread(|d| d.irradiance),
        illuminance: spread(|d| d.illuminance),
        ler: spread(|d| d.ler),
        cct: spread(|d| d.cct),
    }
}

fn combined(value: f64, noise: f64, common: &[(&'static str, f64)]) -> Combined {
    let mut parts = vec![Part {
        name: "independent",
        u: noise,
    }];
    parts.extend(
        common
            .iter()
            .filter(|part| part.1 != 0.0)
            .map(|&(name, u)| Part { name, u: u.abs() }),
    );
    let u = parts.iter().map(|part| part.u * part.u).sum::<f64>().sqrt();
    Combined { value, u, parts }
}

/// A spectrometer that starts late or stops early misses light in the denominator of K.
fn reach(spectrum: &Spectrum) -> Vec<String> {
    let wavelengths = spectrum.wavelength_nm();
    let (first, last) = (wavelengths[0], wavelengths[wavelengths.len() - 1]);
    let mut remarks = Vec::new();
    if first > 360.0 {
        remarks.push(format!(
            "the spectrum begins at {first:.1} nm: light below counts as none"
        ));
    }
    if last < 830.0 {
        remarks.push(format!(
            "the spectrum ends at {last:.1} nm: light above counts as none, and K comes out too high"
        ));
    }
    remarks
}
