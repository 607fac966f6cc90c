//! What follows from spectra over angle, with the keys of `inspect --json`.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// The quantities of a distribution with spectra over angle.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct ColouredQuantities {
    /// What the intensities give.
    #[serde(flatten)]
    pub of: isolux_formats::Quantities,
    /// What the spectra give.
    pub colour_over_angle: AngularColour,
}

/// Colour over angle.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct AngularColour {
    /// Colour of the whole light: every direction's spectrum by its intensity over the sphere.
    pub total: ColourOfDirection,
    /// Largest Δu′v′ from it among the directions with a spectrum and at least a tenth of the largest intensity; not
    /// corrected for noise.
    pub delta_u_prime_v_prime: f64,
    /// The directions with a spectrum, in the order of the file.
    pub directions: Vec<ColourOfDirection>,
}

/// Colour of the light in one direction, or of all of it.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct ColourOfDirection {
    /// C; null of the whole light.
    pub c_deg: Option<f64>,
    /// γ; null of the whole light.
    pub gamma_deg: Option<f64>,
    /// CIE 1976 u′.
    pub u_prime: f64,
    /// CIE 1976 v′.
    pub v_prime: f64,
    /// Correlated colour temperature, where there is one.
    pub cct_k: Option<f64>,
}
