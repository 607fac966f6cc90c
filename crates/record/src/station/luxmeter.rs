//! The lux meter of a station: its calibration, and what is known of how it answers light that is not that of its
//! calibration.

use serde::{Deserialize, Serialize};

use super::valid::{FRACTION, MOST_U_REL, driver_and_target};
use crate::document::Fault;
use crate::document::bounds::within;

/// The lux meter.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct LuxMeter {
    /// `driver:target`.
    pub open: String,
    /// Serial number that the instrument must answer with, where its language has a word for it.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub serial: Option<String>,
    /// Certificate's factor: true illuminance ÷ shown illuminance.
    pub calibration_factor: f64,
    /// Relative standard uncertainty of the calibration (k = 1).
    pub u_rel: f64,
    /// Relative standard deviation of one reading, of the meter and of the lamp together: what `isolux plan` counts as
    /// noise.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub noise_rel: Option<f64>,
    /// Standard deviation of one reading without light.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub noise_lx: Option<f64>,
    /// Number of the certificate.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub certificate: Option<String>,
    /// Day of the calibration, YYYY-MM-DD.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub calibrated: Option<String>,
    /// Day the calibration is due again, YYYY-MM-DD.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub due: Option<String>,
    /// CSV beside the station: relative spectral responsivity of the head, `wavelength_nm`, `responsivity` and its
    /// relative standard uncertainty `u_rel`. With it and a spectrum of the lamp readings are corrected by F*.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub responsivity: Option<String>,
    /// CSV beside the station: the light under which `calibration_factor` holds, `wavelength_nm` and `power`; without
    /// it CIE standard illuminant A.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub calibration_light: Option<String>,
    /// General V(λ) mismatch index f1′ as a fraction, for a head whose `responsivity` is not known; 0 for a meter that
    /// weighs a spectrum by V(λ).
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub f1_prime_rel: Option<f64>,
}

impl LuxMeter {
    /// Checks the table.
    pub(super) fn check(&self) -> Result<(), Fault> {
        driver_and_target("luxmeter.open", &self.open)?;
        within("luxmeter.calibration_factor", self.calibration_factor, 1e-3..=1e3, "")?;
        within("luxmeter.u_rel", self.u_rel, 0.0..=MOST_U_REL, FRACTION)?;
        within("luxmeter.noise_rel", self.noise_rel, 0.0..=MOST_U_REL, " (a fraction)")?;
        within("luxmeter.noise_lx", self.noise_lx, 0.0..=1e3, " lx")?;
        self.check_spectral()
    }

    fn check_spectral(&self) -> Result<(), Fault> {
        for (key, file) in [
            ("luxmeter.responsivity", &self.responsivity),
            ("luxmeter.calibration_light", &self.calibration_light),
        ] {
            if file.as_ref().is_some_and(|file| file.trim().is_empty()) {
                return Err(Fault::new(key, "is empty; name a CSV file beside the station"));
            }
        }
        // Above it a detector is none that reads lux.
        let unit = " (a fraction: 0.03 is 3 %)";
        within("luxmeter.f1_prime_rel", self.f1_prime_rel, 0.0..=0.3, unit)?;
        if self.responsivity.is_some() && self.f1_prime_rel.is_some() {
            return Err(Fault::new(
                "luxmeter.f1_prime_rel",
                "is that of `responsivity`; remove one of the two keys",
            ));
        }
        if self.responsivity.is_none() && self.calibration_light.is_some() {
            return Err(Fault::new(
                "luxmeter.calibration_light",
                "says nothing without `responsivity`; state the head's curve, or remove this key",
            ));
        }
        Ok(())
    }
}
