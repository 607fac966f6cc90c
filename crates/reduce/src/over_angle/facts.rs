//! The colour of a lamp over angle, as `budget.json` has it.

use std::borrow::Cow;

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::measured::LeftOut;
use crate::colour::Colour;
use crate::quantity::Quantity;

/// Colour over angle: the whole of the light, the average of LM-79, and every direction.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct ColourOverAngle {
    /// Of the total spectral flux Φ_λ = ∫ I_v·s_λ/K(s) dΩ: the colour that the whole light has, as an
    /// integrating sphere sees it.
    pub total: TotalColour,
    /// Average of x and of y over the directions that were read, weighted by I·Ω (IES LM-79-08, 12). It is close to
    /// the colour of the whole light, and not the same.
    pub average_lm79: AverageColour,
    /// Δu′v′, the largest distance of a direction from that average.
    pub delta_u_prime_v_prime: LargestDifference,
    /// Every direction that was read.
    pub directions: Vec<DirectionColour>,
    /// Directions whose spectra are not used.
    pub left_out: Vec<LeftOut>,
    /// Distance of the spectroradiometer.
    pub distance_mm: f64,
    /// Half the angle under which it sees the lamp: what it mixes; null without lamp.diameter_mm.
    pub blur_deg: Option<f64>,
    /// What is missing in the uncertainty of every direction.
    pub missing: Vec<Cow<'static, str>>,
}

/// Colour of the whole light.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct TotalColour {
    /// Its colour.
    #[serde(flatten)]
    pub colour: Colour,
    /// Luminous efficacy of radiation of the whole light.
    pub efficacy: Quantity,
    /// Radiant flux, 360–830 nm.
    pub radiant_flux: Quantity,
}

/// Colour by averaged chromaticities.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct AverageColour {
    /// Chromaticity x of CIE 1931.
    pub x: Option<Quantity>,
    /// Chromaticity y of CIE 1931.
    pub y: Option<Quantity>,
    /// u′ of the averaged x and y.
    pub u_prime: Option<Quantity>,
    /// v′ likewise.
    pub v_prime: Option<Quantity>,
    /// Correlated colour temperature of the averaged x and y in K, never an average of temperatures.
    pub cct: Option<Quantity>,
    /// Duv likewise.
    pub duv: Option<Quantity>,
}

/// The largest distance in (u′, v′) from the average.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct LargestDifference {
    /// Without what noise adds to a maximum, and what the size of the lamp takes from it.
    pub value: Quantity,
    /// As it was read.
    pub read: f64,
    /// What noise adds in the mean.
    pub noise_bias: f64,
    /// What the spectroradiometer adds because it mixes the colours of a lamp that it sees under an angle: negative
    /// where it takes.
    #[serde(default)]
    pub lamp_size_bias: f64,
    /// C of the direction.
    pub c_deg: f64,
    /// Its γ.
    pub gamma_deg: f64,
    /// Directions of which it is the largest: those with at least `least_share` of the largest intensity.
    pub directions: usize,
    /// That share.
    pub least_share: f64,
}

/// Colour of one direction, with standard uncertainties (k = 1); null where `missing` says what is not known.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct DirectionColour {
    /// C within 0° to 360°; 0 at a pole.
    pub c_deg: f64,
    /// γ.
    pub gamma_deg: f64,
    /// Intensity by the lux meter.
    pub intensity_cd: f64,
    /// Illuminance of its spectrum.
    pub illuminance_lx: f64,
    /// x of CIE 1931.
    pub x: f64,
    /// Its standard uncertainty.
    pub u_x: Option<f64>,
    /// y of CIE 1931.
    pub y: f64,
    /// Its standard uncertainty.
    pub u_y: Option<f64>,
    /// u′ of CIE 1976.
    pub u_prime: f64,
    /// Its standard uncertainty.
    pub u_u_prime: Option<f64>,
    /// v′ of CIE 1976.
    pub v_prime: f64,
    /// Its standard uncertainty.
    pub u_v_prime: Option<f64>,
    /// Correlated colour temperature in K; null farther than 0.05 from the Planckian locus.
    pub cct_k: Option<f64>,
    /// Its standard uncertainty.
    pub u_cct_k: Option<f64>,
    /// Duv.
    pub duv: Option<f64>,
    /// Its standard uncertainty.
    pub u_duv: Option<f64>,
    /// Distance in (u′, v′) from the average of LM-79, as it was read.
    pub delta_u_prime_v_prime: f64,
    /// Standard uncertainty that noise gives u′ and v′, the mean of both.
    pub noise_u_prime_v_prime: f64,
}
