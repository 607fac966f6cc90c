//! A certificate as it is written, table by table.

use serde::{Deserialize, Serialize};

/// A certificate as written.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct StandardDocument {
    /// [`FORMAT`](super::FORMAT).
    pub format: String,
    /// The lamp.
    pub lamp: Lamp,
    /// The paper.
    pub certificate: Certificate,
    /// Under what it is true.
    pub conditions: Conditions,
    /// Irradiance over wavelength: for a spectroradiometer.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub spectral_irradiance: Option<SpectralIrradiance>,
    /// Illuminance: for a lux meter.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub illuminance: Option<Illuminance>,
}

/// The lamp.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Lamp {
    /// Type, as "FEL 1000 W".
    pub designation: String,
    /// Serial number.
    pub number: String,
    /// Hours it has burned.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub hours_run: Option<f64>,
}

/// Who states it, and how long it holds.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Certificate {
    /// Its number.
    pub number: String,
    /// The laboratory.
    pub laboratory: String,
    /// Day of issue, YYYY-MM-DD.
    pub issued: String,
    /// Last day on which it is used, YYYY-MM-DD.
    pub expires: String,
}

/// Under what the values are true.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Conditions {
    /// Current of the lamp.
    pub current_a: f64,
    /// How far from it a calibration may be.
    pub current_tolerance_a: f64,
    /// The plane of the lamp from which distances count.
    pub reference_plane: String,
    /// Standard uncertainty of the lamp's direction in its mount (k = 1), each of its two angles.
    pub u_alignment_deg: f64,
}

/// Irradiance over wavelength.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct SpectralIrradiance {
    /// From the reference plane to the detector.
    pub distance_mm: f64,
    /// CSV beside the certificate, with the columns `wavelength_nm`, `irradiance_w_m2_nm` and `u_rel` (k = 1).
    pub table: String,
    /// The part of `u_rel` that all wavelengths share (k = 1).
    pub u_scale_rel: f64,
    /// Relative standard uncertainty of the temperature of the radiator that carries the scale (k = 1): it tilts the
    /// spectrum.
    pub u_temperature_rel: f64,
}

/// Illuminance.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Illuminance {
    /// From the reference plane to the detector.
    pub distance_mm: f64,
    /// At that distance.
    pub illuminance_lx: f64,
    /// Its relative standard uncertainty (k = 1).
    pub u_rel: f64,
    /// Correlated colour temperature, or distribution temperature, of the light.
    pub colour_temperature_k: f64,
}
