//! What a simulation states about its map: `result.json`.

use std::borrow::Cow;

use isolux_units::json::nan_if_null;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::inverse::{self, Accuracy, Bound};
use crate::noise::Interval;
use crate::setup::Setup;

/// What a map holds.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
pub enum MapUnit {
    /// Irradiance.
    #[serde(rename = "W/m2")]
    WattPerSquareMetre,
    /// Illuminance: the model has neither a spectrum nor an efficacy.
    #[serde(rename = "lx")]
    Lux,
}

impl MapUnit {
    pub(super) const fn of(setup: &Setup) -> Self {
        match setup.ler_lm_per_w {
            Some(_) => Self::WattPerSquareMetre,
            None => Self::Lux,
        }
    }

    /// As people write it.
    pub const fn symbol(self) -> &'static str {
        match self {
            Self::WattPerSquareMetre => "W/m²",
            Self::Lux => "lx",
        }
    }

    /// The quantity.
    pub const fn quantity(self) -> &'static str {
        match self {
            Self::WattPerSquareMetre => "irradiance",
            Self::Lux => "illuminance",
        }
    }
}

/// `result.json`.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Facts {
    /// `inverse` or `direct`.
    pub method: Cow<'static, str>,
    /// `traced`, `thinned`, `expected`; null for inverse.
    pub sampling: Option<Cow<'static, str>>,
    /// Rays over the whole sphere.
    pub rays: Option<u64>,
    /// Seed.
    pub seed: Option<u64>,
    /// Unit of the map and of all that is stated of its pixels.
    pub unit: MapUnit,
    /// Mean over the sensor.
    pub mean: f64,
    /// Inverse: bound on the error of the quadrature; direct: standard error by ray counting.
    pub u_mean_numeric: f64,
    /// What the inverse method was asked for; null for direct.
    pub accuracy: Option<AccuracyFacts>,
    /// What the error of no pixel exceeds; null for direct.
    pub pixel_error_bound: Option<PixelBound>,
    /// Standard uncertainty with what the model knows of its measurement; null where it does not know all of it.
    pub u_mean: Option<f64>,
    /// What is missing in `u_mean`, one phrase each.
    pub u_mean_missing: Vec<String>,
    /// Smallest pixel.
    pub min: f64,
    /// Largest pixel.
    pub max: f64,
    /// Standard deviation over the pixels, divided by n.
    pub std: f64,
    /// Smallest pixel over mean.
    pub uniformity_min_over_mean: f64,
    /// Rays that reached the sensor.
    pub rays_on_sensor: Option<u64>,
    /// Standard error of a mean pixel by ray counting, relative; from the upper limit of 3 rays where none arrived.
    pub relative_error_per_pixel: Option<f64>,
    /// Largest pixel that ray noise alone would give on the noise-free map.
    pub max_ray_noise: Option<Interval>,
    /// Largest pixel of the noise-free map.
    pub max_noise_free: Option<f64>,
    /// Effects of the model that the map contains.
    pub effects_applied: Vec<Cow<'static, str>>,
    /// Effects of the model that belong elsewhere.
    pub effects_not_applicable: Vec<Cow<'static, str>>,
    /// Seconds of the solver alone; null where the same input has to give the same bytes.
    pub elapsed_s: Option<f64>,
    /// Standard deviation without the part that ray counting adds.
    pub std_without_ray_noise: Option<f64>,
    /// Rays over the whole sphere that would bring a mean pixel to 1 %.
    pub rays_for_1_percent_per_pixel: Option<f64>,
    /// Pixels that no ray reached; each is known to be below 3.0 rays at 95 %.
    pub empty_pixels: Option<usize>,
    /// What one ray adds to a pixel.
    pub one_ray_in_a_pixel: Option<f64>,
    /// Flux of the luminaire, lm.
    #[serde(deserialize_with = "nan_if_null")]
    #[schemars(with = "Option<f64>")]
    pub flux_lm: f64,
    /// Luminous efficacy of radiation that links lx and W/m².
    pub ler_lm_per_w: Option<f64>,
    /// Pixels along x and y.
    pub pixels: [usize; 2],
    /// Width and height of the sensor, mm.
    pub size_mm: [f64; 2],
    /// Mean photon irradiance, 1/(m²·s), 360–830 nm; null without a spectrum.
    pub photon_irradiance_per_m2_s: Option<f64>,
    /// Mean illuminance, lx.
    pub illuminance_lx: f64,
    /// Mean irradiance in bands of 50 nm, W/m²; empty without a spectrum.
    pub bands: Vec<Band>,
    /// Mean electrons per second and pixel, with the scene's responsivity; null without one.
    pub electrons_per_s_per_pixel: Option<f64>,
    /// One exposure of the scene's camera; null without one.
    pub camera: Option<CameraFacts>,
    /// Colour over the sensor, where the scene has spectra over angle.
    pub colour: Option<ColourFacts>,
    /// Smallest pixel over mean without the part that ray counting adds: that of the noise-free map.
    pub uniformity_without_ray_noise: Option<f64>,
    /// The verdict beside an earlier simulation, where one was given.
    pub against: Option<Against>,
    /// What the operator should know.
    pub findings: Vec<String>,
}

/// The accuracy that was asked for: no pixel is off by more than `relative` of itself, or of `dim` times the largest
/// pixel where it is dimmer than that.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct AccuracyFacts {
    /// `standard` or `reference`.
    pub name: Cow<'static, str>,
    /// Allowed error of a pixel, relative to it.
    pub relative: f64,
    /// Share of the map's largest pixel below which the allowed error no longer falls.
    pub dim: f64,
    /// The largest bound of a pixel over what is allowed: at most 1 where the accuracy was met.
    pub of_allowed: f64,
}

impl AccuracyFacts {
    pub(super) fn of(accuracy: Accuracy, bound: &Bound) -> Self {
        Self {
            name: accuracy.word().into(),
            relative: inverse::allowed(accuracy),
            dim: inverse::DIM,
            of_allowed: bound.of_allowed,
        }
    }
}

/// Bounds on the error of the inverse method that hold in every pixel.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct PixelBound {
    /// In the map's unit.
    pub absolute: f64,
    /// Relative to the pixel itself.
    #[serde(deserialize_with = "nan_if_null")]
    #[schemars(with = "Option<f64>")]
    pub relative: f64,
}

/// Whether a simulation differs from an earlier one by more than their noise.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Against {
    /// Where the earlier one lies.
    pub folder: String,
    /// Its mean.
    pub mean: f64,
    /// This mean less that.
    pub difference: f64,
    /// Standard uncertainty of the difference, by quadrature and counted rays.
    pub u_difference: f64,
    /// Difference over its uncertainty.
    pub sigma: f64,
    /// Probability of such a difference or a larger one without any real one.
    pub p_value: f64,
    /// Whether that probability is below 1 %.
    pub differs: bool,
    /// Whether both drew the same random numbers: they are not independent then, and the probability does not hold.
    pub same_rays: bool,
}

/// What one exposure holds.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct CameraFacts {
    /// Mean electrons of a pixel, dark current included, full well applied.
    pub mean_electrons: f64,
    /// Mean digital number.
    pub mean_dn: f64,
    /// Pixels whose expected electrons fill the well.
    pub full_well_pixels: usize,
    /// Pixels at the converter's last number.
    pub clipped_pixels: usize,
    /// Mean signal over its noise in one pixel: read noise, shot noise, fixed patterns, quantisation (EMVA 1288).
    pub signal_to_noise: Option<f64>,
    /// Seed of the exposure.
    pub seed: u64,
}

/// Colour over the sensor.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct ColourFacts {
    /// The middle.
    pub centre: ColourAt,
    /// The corner that differs most.
    pub corner: ColourAt,
    /// Their distance in u′v′.
    pub delta_u_prime_v_prime: f64,
}

/// Colour of the light in one direction.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct ColourAt {
    /// Where.
    pub gamma_deg: f64,
    /// Correlated colour temperature, where it is defined.
    pub cct_k: Option<f64>,
    /// CIE 1976.
    pub u_prime: f64,
    /// CIE 1976.
    pub v_prime: f64,
}

/// Irradiance within a band of wavelengths.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Band {
    /// First wavelength.
    pub from_nm: f64,
    /// First wavelength beyond.
    pub to_nm: f64,
    /// Mean over the sensor.
    pub irradiance_w_m2: f64,
}
