//! Spectrum on the axis: counts → irradiance → efficacy and colour, with uncertainty.

use isolux_record::ReadingKind;
use isolux_record::observation::SharedErrors;
use isolux_record::plan::Instrument;
use isolux_record::run::Run;
use isolux_record::spectra::{SpectralCorrections, SpectrumRecord};
use isolux_spectrum::Spectrum;
use isolux_spectrum::cie;

use crate::colour::{Colour, bow_changed, numbers, shape_changed, wavelengths_changed};
use crate::error::ReduceError;
use crate::instrument::{self, Chain};
use crate::known::Known;
use crate::one_nm::AtOneNm;
use crate::quantity::Quantity;
use crate::{Options, Wanted};

/// The spectrum of a run on the axis, at 1 nm.
#[derive(Debug, Clone)]
pub struct SpectralResult {
    /// Spectral irradiance in W/m²/nm.
    pub spectrum: Spectrum,
    /// Standard uncertainty of each value from the scatter of light and dark.
    pub u_w_m2_nm: Vec<f64>,
    /// The same from the noise that all pixels show together (that of a single one is known from a few scans alone), with
    /// what neighbours share: as if the values were independent, their sums have the noise that they have.
    pub u_expected_w_m2_nm: Vec<f64>,
    /// Distance at which it was read.
    pub distance_mm: f64,
    /// Half-plane in which it was read.
    pub c_deg: f64,
    /// Middle of the readings in seconds since the run began.
    pub time_s: Option<f64>,
    /// The same since the lamp was switched on.
    pub lamp_s: Option<f64>,
    /// What all its values share.
    pub shared: SharedErrors,
    /// What the laboratory has found of the instrument, which it is corrected by unless that is switched off.
    pub corrections: SpectralCorrections,
    /// Luminous efficacy of radiation.
    pub ler: Quantity,
    /// Irradiance 360–830 nm.
    pub irradiance: Quantity,
    /// Illuminance 683·Σ E·V.
    pub illuminance: Quantity,
    /// Colour: correlated colour temperature, chromaticity, rendering.
    pub colour: Colour,
}

/// The mean of the lit spectra on the axis (γ = 0) of the first spectral block; none when the run has no such spectrum.
///
/// # Errors
/// [`ReduceError`] for saturation where there is light, or no calibration.
pub fn on_axis(run: &Run, options: &Options) -> Result<Option<SpectralResult>, ReduceError> {
    on_axis_to(Wanted::Everything, run, options)
}

/// The same, as far as it is wanted.
pub(crate) fn on_axis_to(wanted: Wanted, run: &Run, options: &Options) -> Result<Option<SpectralResult>, ReduceError> {
    let chain = Chain::without(&options.without);
    let on_axis = |record: &&SpectrumRecord| is_lit(run, record) && record.gamma_deg.abs() < ON_AXIS_DEG;
    let Some(first) = run.spectra.iter().find(on_axis) else {
        return Ok(None);
    };
    let records: Vec<&SpectrumRecord> = run
        .spectra
        .iter()
        .filter(on_axis)
        .filter(|record| record.distance_mm == first.distance_mm)
        .collect();
    let calibration = run.header.spectral.as_ref().ok_or(ReduceError::NoCalibration)?;
    let AtOneNm {
        wavelength_nm: wavelength,
        value,
        variance,
        expected,
    } = AtOneNm::mean(&records, calibration, chain)?;
    let spectrum = Spectrum::new(wavelength, value)?;
    let root = |variance: Vec<f64>| -> Vec<f64> { variance.into_iter().map(f64::sqrt).collect() };
    let mut known = Known::of(run, chain, first.distance_mm);
    let mut moved = Vec::new();
    let u_w_m2_nm = root(variance);
    let colour = match wanted {
        Wanted::Everything => {
            for (part, calibration) in instrument::moved(calibration, chain) {
                let mean = AtOneNm::mean(&records, &calibration, chain)?;
                moved.push((part, Spectrum::new(mean.wavelength_nm, mean.value)?));
            }
            Colour::of(&spectrum, &u_w_m2_nm, &known, &moved)
        }
        Wanted::Values => {
            // A budget without these parts is none.
            let left_out = "the value alone was asked for".to_owned();
            known.level.push(left_out.clone());
            known.colour.push(left_out);
            Colour::from_parts(&numbers(&spectrum), &[], &known.colour)
        }
    };
    Ok(Some(SpectralResult {
        u_expected_w_m2_nm: root(expected),
        c_deg: first.c_deg,
        corrections: calibration.corrections.clone(),
        time_s: middle(records.iter().map(|record| record.time_s)),
        lamp_s: middle(records.iter().map(|record| record.lamp_s)),
        ..result(spectrum, u_w_m2_nm, colour, first.distance_mm, &known, &moved)
    }))
}

/// Whether a spectrum is one of the lamp, of a block of the plan.
pub fn is_lit(run: &Run, record: &SpectrumRecord) -> bool {
    let mut blocks = run.header.plan.blocks().iter();
    record.kind == ReadingKind::Lit
        && blocks.any(|block| block.name == record.block && block.instrument == Instrument::Spectroradiometer)
}

/// A spectrum nearer to γ = 0 than this is one on the axis.
pub const ON_AXIS_DEG: f64 = 0.5;

/// The mean of times, all of which are known.
fn middle(times: impl ExactSizeIterator<Item = Option<f64>>) -> Option<f64> {
    let count = times.len() as f64;
    times.sum::<Option<f64>>().map(|sum| sum / count)
}

fn result(
    spectrum: Spectrum,
    u_w_m2_nm: Vec<f64>,
    colour: Colour,
    distance_mm: f64,
    known: &Known,
    moved: &[(&'static str, Spectrum)],
) -> SpectralResult {
    let v_lambda: Vec<f64> = spectrum.wavelength_nm().iter().map(|&nm| v_at(nm)).collect();
    let (integral, luminous) = (spectrum.integral(), spectrum.luminous_integral());
    let ler = luminous / integral;
    let squares = |slope: &dyn Fn(usize) -> f64| -> f64 {
        u_w_m2_nm
            .iter()
            .enumerate()
            .map(|(place, u)| (slope(place) * u).powi(2))
            .sum::<f64>()
            .sqrt()
    };
    let level = |of: &dyn Fn(&Spectrum) -> f64, noise: f64, unit| {
        let value = of(&spectrum);
        let moved = moved.iter().map(|(part, there)| (*part, of(there) - value));
        let parts = [
            ("noise", noise),
            ("calibration", value * known.calibration_rel),
            ("distance", value * known.distance_rel),
            ("stray", value * known.stray_rel),
        ];
        Quantity::new(value, unit, parts.into_iter().chain(moved)).lacking(known.level.iter().cloned())
    };
    // What a number of the spectrum changes by when its shape or its wavelengths are wrong by their uncertainty.
    let shaped = shape_changed(&spectrum, known.shape_rel);
    let bowed = bow_changed(&spectrum, known.shape_rel);
    let shifted = wavelengths_changed(&spectrum, known.wavelength_nm);
    let noise_of_ler = squares(&|place| (683.0 * v_lambda[place] - ler) / integral);
    let ler_change = |changed: &Option<Spectrum>| {
        let there = changed
            .as_ref()
            .map(|changed| changed.luminous_integral() / changed.integral());
        there.map_or(0.0, |there| there - ler)
    };
    let of_moved = moved
        .iter()
        .map(|(part, there)| (*part, there.luminous_integral() / there.integral() - ler));
    let parts = [
        ("noise", noise_of_ler),
        ("calibration_shape", ler_change(&shaped)),
        ("calibration_bow", ler_change(&bowed)),
        ("wavelength", ler_change(&shifted)),
    ];
    let parts = parts.into_iter().chain(of_moved);
    SpectralResult {
        ler: Quantity::new(ler, "lm/W", parts).lacking(known.colour.iter().cloned()),
        irradiance: level(&Spectrum::integral, squares(&|_| 1.0), "W/m²"),
        illuminance: level(
            &Spectrum::luminous_integral,
            squares(&|place| 683.0 * v_lambda[place]),
            "lx",
        ),
        colour,
        spectrum,
        u_expected_w_m2_nm: u_w_m2_nm.clone(),
        u_w_m2_nm,
        distance_mm,
        c_deg: 0.0,
        time_s: None,
        lamp_s: None,
        shared: known.shared(),
        corrections: SpectralCorrections::default(),
    }
}

fn v_at(wavelength_nm: f64) -> f64 {
    let index = wavelength_nm - 360.0;
    if index < 0.0 || index.fract() != 0.0 {
        0.0
    } else {
        cie::V_LAMBDA.get(index as usize).copied().unwrap_or(0.0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn noise_of_every_pixel_reaches_efficacy_and_colour() {
        let wavelength: Vec<f64> = (380..=780).map(f64::from).collect();
        let value: Vec<f64> = wavelength
            .iter()
            .map(|nm| 0.01 * (-((nm - 560.0) / 80.0).powi(2)).exp() + 0.004)
            .collect();
        let u: Vec<f64> = value.iter().map(|value| 0.01 * value).collect();
        let spectrum = Spectrum::new(wavelength, value.clone()).unwrap();
        let known = Known {
            calibration_rel: 0.02,
            distance_rel: 0.004,
            shape_rel: 0.01,
            wavelength_nm: 0.2,
            ..Known::default()
        };
        let spectrum_of_test = spectrum.clone();
        let colour = Colour::of(&spectrum, &u, &known, &[]);
        let result = result(spectrum, u, colour, 500.0, &known, &[]);
        let expected: f64 = value.iter().map(|value| (0.01 * value).powi(2)).sum::<f64>().sqrt();
        assert!((result.irradiance.parts["noise"] - expected).abs() < 1e-12);
        assert!((result.irradiance.parts["calibration"] / result.irradiance.value - 0.02).abs() < 1e-12);
        assert!(
            result.ler.u_rel() < result.irradiance.u_rel(),
            "a common factor does not touch the efficacy"
        );
        let colour = &result.colour;
        // What the closed form gives of x: ∂x/∂E(λ) = (x̄ − x·(x̄ + ȳ + z̄))/(X + Y + Z).
        let xyz = spectrum_of_test.tristimulus();
        let sum = xyz.x + xyz.y + xyz.z;
        let x = colour.x.as_ref().unwrap();
        let exact: f64 = (0..value.len())
            .map(|place| {
                let mut one = vec![0.0; value.len()];
                one[place] = 1.0;
                let one = Spectrum::new(spectrum_of_test.wavelength_nm().to_vec(), one)
                    .unwrap()
                    .tristimulus();
                ((one.x - x.value * (one.x + one.y + one.z)) / sum * 0.01 * value[place]).powi(2)
            })
            .sum::<f64>()
            .sqrt();
        assert!((x.parts["noise"] / exact - 1.0).abs() < 0.01, "{x:?} {exact}");
        // A bow of the calibration moves Duv more than a tilt does, which runs along the Planckian locus.
        let duv = colour.duv.as_ref().unwrap();
        assert!(duv.parts["calibration_bow"] > duv.parts["calibration_shape"], "{duv:?}");
        for (quantity, low, high) in [
            (&colour.ra, 0.001, 2.0),
            (&colour.duv, 1e-6, 1e-3),
            (&colour.v_prime, 1e-6, 1e-3),
        ] {
            let u = quantity.as_ref().unwrap().u.unwrap();
            assert!((low..high).contains(&u), "{quantity:?}");
        }
        let cct = result.colour.cct.unwrap();
        assert!(cct.parts["noise"] > 0.5 && cct.parts["noise"] < 50.0, "{cct:?}");
        // 1 % more red light makes it warmer by some tens of kelvins, and so does a scale that reads too long.
        assert!((5.0..50.0).contains(&cct.parts["calibration_shape"]), "{cct:?}");
        assert!((1.0..50.0).contains(&cct.parts["wavelength"]), "{cct:?}");
    }
}
