//! The head of the lux meter, the spectra of the lamp, and F* of both with its uncertainty.

use std::borrow::Cow;
use std::collections::BTreeMap;

use isolux_photometry::HalfPlanes;
use isolux_record::Run;
use isolux_record::responsivity::{MeterCurves, WavelengthCurve};
use isolux_spectrum::meter::{NoMismatch, spectral_mismatch};
use isolux_spectrum::{Spectrum, cie, illuminant};

use crate::colour::{bow_changed, shape_changed, wavelengths_changed};
use crate::error::ReduceError;
use crate::instrument::Chain;
use crate::known::Known;
use crate::over_angle::Measured;
use crate::spectral::on_axis_to;
use crate::{Options, Wanted};

/// Why there is no F*.
pub enum Fails {
    /// The curves or the light have none.
    Mismatch(String),
    /// The record has no spectrum that can be used.
    Reduce(ReduceError),
}

impl From<NoMismatch> for Fails {
    fn from(why: NoMismatch) -> Self {
        Self::Mismatch(why.to_string())
    }
}

impl From<ReduceError> for Fails {
    fn from(error: ReduceError) -> Self {
        Self::Reduce(error)
    }
}

impl From<isolux_spectrum::SpectrumError> for Fails {
    fn from(error: isolux_spectrum::SpectrumError) -> Self {
        Self::Mismatch(error.to_string())
    }
}

/// Period of what a curve may be wrong by, nm: no other moves F* of white LEDs by more than 1.13 times as much.
const WAVE_NM: f64 = 200.0;

/// What a relative curve may be wrong by, one after the other: it is not known what its wavelengths share. Two waves, a
/// quarter of a turn apart, have its variance at every wavelength. None without an uncertainty.
pub fn waves(wavelength_nm: &[f64], u_rel: &[f64]) -> Vec<Vec<f64>> {
    if u_rel.len() != wavelength_nm.len() {
        return Vec::new();
    }
    let wave = |phase: f64| {
        let turn = move |nm: f64| std::f64::consts::TAU * nm / WAVE_NM + phase;
        wavelength_nm
            .iter()
            .zip(u_rel)
            .map(|(nm, u)| u * turn(*nm).cos())
            .collect()
    };
    vec![wave(0.0), wave(std::f64::consts::FRAC_PI_2)]
}

/// Responsivity and calibration of a head.
pub struct Head {
    /// Its curve.
    pub responsivity: Spectrum,
    /// As far as its uncertainty goes, one by one.
    moved: Vec<Spectrum>,
    calibration: Spectrum,
}

impl Head {
    /// Of the curves of a run.
    ///
    /// # Errors
    /// Numbers that are no spectrum.
    pub fn of(curves: &MeterCurves) -> Result<Self, Fails> {
        let spectrum = |curve: &WavelengthCurve| Spectrum::new(curve.wavelength_nm.clone(), curve.value.clone());
        let calibration = match &curves.calibration_light {
            Some(light) => spectrum(light)?,
            None => Spectrum::from_1_nm(&illuminant::illuminant_a())
                .ok_or_else(|| Fails::Mismatch("illuminant A is no spectrum".to_owned()))?,
        };
        let curve = &curves.responsivity;
        let moved = waves(&curve.wavelength_nm, &curve.u_rel).into_iter().map(|wave| {
            let value = curve.value.iter().zip(&wave).map(|(value, rel)| value * (1.0 + rel));
            Spectrum::new(curve.wavelength_nm.clone(), value.collect())
        });
        Ok(Self {
            responsivity: spectrum(curve)?,
            moved: moved.collect::<Result<_, _>>()?,
            calibration,
        })
    }

    /// Whether its curve has no uncertainty.
    pub fn states_no_u(&self) -> bool {
        self.moved.is_empty()
    }

    /// F* for a light.
    ///
    /// # Errors
    /// The head does not see it, or it has no visible light.
    pub fn f_star(&self, light: &Spectrum) -> Result<f64, NoMismatch> {
        spectral_mismatch(light, &self.calibration, &self.responsivity)
    }
}

/// The spectrum of a direction.
pub struct Light {
    /// C and γ.
    pub deg: (f64, f64),
    /// At whole nanometres.
    pub spectrum: Spectrum,
    /// Of each value, from noise.
    variance: Vec<f64>,
    illuminance_lx: f64,
}

/// The spectra of a run's lamp: of the directions that show colour, else of the axis alone.
pub struct Lights {
    /// One by one.
    pub of: Vec<Light>,
    /// On which they lie; none: the axis alone.
    pub half_planes: Option<HalfPlanes>,
    /// Distance of the spectroradiometer.
    pub distance_mm: f64,
}

impl Lights {
    /// Of a run; none without a spectrum.
    ///
    /// # Errors
    /// What makes counts no irradiance.
    pub fn of(run: &Run, options: &Options) -> Result<Option<Self>, ReduceError> {
        let chain = Chain::without(&options.without);
        let measured = match &run.header.spectral {
            Some(calibration) => Measured::of(run, calibration, chain)?,
            None => None,
        };
        if let Some(measured) = measured {
            let directions: Vec<(f64, f64)> = measured.directions.iter().map(|of| (of.c_deg, of.gamma_deg)).collect();
            if let (true, Ok(half_planes)) = (directions.len() > 1, HalfPlanes::new(&directions)) {
                let of = measured.directions.into_iter().map(|of| Light {
                    deg: (of.c_deg, of.gamma_deg),
                    spectrum: of.spectrum,
                    variance: of.variance,
                    illuminance_lx: of.illuminance_lx,
                });
                return Ok(Some(Self {
                    of: of.collect(),
                    half_planes: Some(half_planes),
                    distance_mm: measured.distance_mm,
                }));
            }
        }
        Ok(on_axis_to(Wanted::Values, run, options)?.map(|axis| Self {
            of: vec![Light {
                deg: (0.0, 0.0),
                variance: axis.u_expected_w_m2_nm.iter().map(|u| u * u).collect(),
                illuminance_lx: axis.illuminance.value,
                spectrum: axis.spectrum,
            }],
            half_planes: None,
            distance_mm: axis.distance_mm,
        }))
    }
}

/// Relative standard uncertainties of F* by cause, the largest of all directions; noise that of the brightest
/// direction, for the others average out.
///
/// # Errors
/// A light without F*.
pub fn parts_rel(
    head: &Head,
    lights: &Lights,
    f_star: &[f64],
    known: &Known,
) -> Result<BTreeMap<Cow<'static, str>, f64>, Fails> {
    let mut parts: BTreeMap<Cow<'static, str>, f64> = BTreeMap::new();
    let mut largest = |name: &'static str, change: f64| {
        let part = parts.entry(name.into()).or_default();
        *part = part.max(change.abs());
    };
    for (light, centre) in lights.of.iter().zip(f_star) {
        let mut squares = 0.0;
        for moved in &head.moved {
            let there = spectral_mismatch(&light.spectrum, &head.calibration, moved)?;
            squares += (there / centre - 1.0).powi(2);
        }
        largest("responsivity", squares.sqrt());
        for (name, changed) in [
            ("calibration_shape", shape_changed(&light.spectrum, known.shape_rel)),
            ("calibration_bow", bow_changed(&light.spectrum, known.shape_rel)),
            ("wavelength", wavelengths_changed(&light.spectrum, known.wavelength_nm)),
        ] {
            let there = changed.map_or(Ok(*centre), |changed| head.f_star(&changed))?;
            largest(name, there / centre - 1.0);
        }
    }
    let brightest = lights
        .of
        .iter()
        .max_by(|a, b| a.illuminance_lx.total_cmp(&b.illuminance_lx));
    largest("noise", brightest.map_or(0.0, |light| noise_rel(head, light)));
    Ok(parts)
}

/// Relative standard deviation of F* from the noise of a spectrum at whole nanometres.
fn noise_rel(head: &Head, light: &Light) -> f64 {
    let v = Spectrum::from_1_nm(&cie::V_LAMBDA);
    let at: Vec<(f64, f64, f64)> = (light.spectrum.wavelength_nm().iter().zip(light.spectrum.value()))
        .map(|(nm, value)| {
            let v = v.as_ref().map_or(0.0, |v| v.at_nm(*nm));
            (*value, v, head.responsivity.at_nm(*nm))
        })
        .collect();
    let ideal: f64 = at.iter().map(|(value, v, _)| value * v).sum();
    let seen: f64 = at.iter().map(|(value, _, s)| value * s).sum();
    let squares = at.iter().zip(&light.variance);
    squares
        .map(|((_, v, s), variance)| (v / ideal - s / seen).powi(2) * variance)
        .sum::<f64>()
        .sqrt()
}

#[cfg(test)]
pub mod tests {
    use super::*;
    use isolux_spectrum::meter::f1_prime;

    /// V(λ) displaced by 4 nm, with a leak of 2 % at 440 nm.
    pub fn curves() -> MeterCurves {
        let v = Spectrum::from_1_nm(&cie::V_LAMBDA).unwrap();
        let wavelength_nm: Vec<f64> = (360..=830).map(f64::from).collect();
        let leak = |nm: f64| 0.02 * (-0.5 * ((nm - 440.0) / 25.0).powi(2)).exp();
        MeterCurves {
            responsivity: WavelengthCurve {
                file: "head.csv".to_owned(),
                sha256: String::new(),
                value: wavelength_nm.iter().map(|nm| v.at_nm(nm - 4.0) + leak(*nm)).collect(),
                u_rel: vec![0.02; wavelength_nm.len()],
                wavelength_nm,
            },
            calibration_light: None,
        }
    }

    /// A blue chip under a phosphor, of which there is so much; 1 lm or lx of it.
    pub fn white(phosphor: f64) -> Spectrum {
        let bell = |nm: f64, peak: f64, below: f64, above: f64| {
            let width = if nm < peak { below } else { above };
            (-0.5 * ((nm - peak) / width).powi(2)).exp()
        };
        let at = |nm: f64| {
            let glow = 0.58 * bell(nm, 533.0, 31.0, 46.0) + 0.42 * bell(nm, 612.0, 38.0, 46.0);
            bell(nm, 457.0, 9.5, 12.0) + 0.74 * phosphor * glow
        };
        let light = Spectrum::from_1_nm(&std::array::from_fn(|place| at(360.0 + place as f64))).unwrap();
        light.scaled(light.luminous_integral().recip()).unwrap()
    }

    fn light(gamma_deg: f64, phosphor: f64) -> Light {
        let spectrum = white(phosphor);
        Light {
            deg: (0.0, gamma_deg),
            variance: spectrum.value().iter().map(|value| (0.01 * value).powi(2)).collect(),
            illuminance_lx: 1.0,
            spectrum,
        }
    }

    /// Expected values by numpy, with V(λ) of colour-science 0.4.7 and the formula of illuminant A.
    #[test]
    fn f_star_is_that_of_an_independent_calculation() {
        let Ok(head) = Head::of(&curves()) else {
            panic!("a head")
        };
        for (phosphor, expected) in [(1.0, 1.022_130_043), (1.25, 1.022_570_018), (0.8, 1.021_589_645)] {
            let found = head.f_star(&white(phosphor)).unwrap();
            assert!((found - expected).abs() < 1e-8, "{phosphor}: {found}");
        }
        let index = f1_prime(&head.responsivity).unwrap();
        assert!((index - 0.078_221_65).abs() < 2e-6, "{index}");
        // Calibrated under the light that it reads, no head is wrong.
        let own = white(1.0);
        let mut calibrated = curves();
        calibrated.calibration_light = Some(WavelengthCurve {
            wavelength_nm: own.wavelength_nm().to_vec(),
            value: own.value().to_vec(),
            u_rel: Vec::new(),
            ..calibrated.responsivity.clone()
        });
        let Ok(head) = Head::of(&calibrated) else {
            panic!("a head")
        };
        assert!((head.f_star(&own).unwrap() - 1.0).abs() < 1e-12);
    }

    #[test]
    fn the_uncertainty_of_f_star_is_that_of_its_inputs() {
        let Ok(head) = Head::of(&curves()) else {
            panic!("a head")
        };
        let lights = Lights {
            of: vec![light(0.0, 1.0)],
            half_planes: None,
            distance_mm: 500.0,
        };
        let known = Known {
            shape_rel: 0.01,
            wavelength_nm: 0.2,
            ..Known::default()
        };
        let f_star = [head.f_star(&white(1.0)).unwrap()];
        let Ok(parts) = parts_rel(&head, &lights, &f_star, &known) else {
            panic!("parts")
        };
        // By numpy: 3.37e-3 for 2 % along both phases of 200 nm, with the same tables.
        assert!((parts["responsivity"] - 0.003_37).abs() < 1e-5, "{parts:?}");
        // Noise of every value moves F* by the difference of two weights, each of which adds up to 1.
        let (at, value) = (lights.of[0].spectrum.wavelength_nm(), lights.of[0].spectrum.value());
        let moved: f64 = (0..at.len())
            .map(|place| {
                let mut changed = value.to_vec();
                changed[place] *= 1.01;
                let changed = Spectrum::new(at.to_vec(), changed).unwrap();
                (head.f_star(&changed).unwrap() / f_star[0] - 1.0).powi(2)
            })
            .sum();
        assert!(
            (parts["noise"] / moved.sqrt() - 1.0).abs() < 0.01,
            "{parts:?} {}",
            moved.sqrt()
        );
        for part in ["calibration_shape", "calibration_bow", "wavelength"] {
            assert!((1e-6..1e-3).contains(&parts[part]), "{parts:?}");
        }
    }
}
