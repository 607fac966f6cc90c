//! What an address says of a spectroradiometer that reads illuminance.

use std::time::Duration;

use camino::Utf8PathBuf;
use isolux_device::{OpenError, SpectroradiometerProperties, Target};
use isolux_record::disk::sha256;
use isolux_record::spectra::parse_calibration;
use isolux_scan::spectrum::factors_at;

/// Options of the address that are not the driver's own.
const CALIBRATION: &str = "calibration";
const INTEGRATION_MS: &str = "integration_ms";
const FULL_SCALE_LX: &str = "full_scale_lx";

/// An example of them, behind an address.
pub(crate) const EXAMPLE: &str = "calibration=device&integration_ms=100";

/// What the address says.
pub(crate) struct Settings {
    target: Target,
    calibration: String,
    /// Of the most sensitive range.
    pub integration: Duration,
    /// Illuminance by the lamp at which the brightest pixel is full in that range, where it is known.
    pub full_scale_lx: Option<f64>,
}

impl Settings {
    /// Those of `target`, and the address of the instrument itself.
    ///
    /// # Errors
    /// [`OpenError::Address`] names the option that is missing or wrong.
    pub fn of(target: &Target) -> Result<(Self, Target), OpenError> {
        let Some(calibration) = target.option(CALIBRATION) else {
            return Err(target.wrong(
                "a spectroradiometer as lux meter needs calibration=device or calibration=FILE.csv beside the station",
            ));
        };
        let positive = |key: &str| -> Result<Option<f64>, OpenError> {
            let value = target.number(key, f64::NAN)?;
            match target.option(key) {
                None => Ok(None),
                Some(_) if value.is_finite() && value > 0.0 => Ok(Some(value)),
                Some(_) => Err(target.wrong(format!("{key} is a number above zero"))),
            }
        };
        let Some(integration_ms) = positive(INTEGRATION_MS)?.filter(|ms| *ms <= 1e6) else {
            return Err(target.wrong(
                "a spectroradiometer as lux meter needs integration_ms, the longest integration time; whole periods of \
                 the mains, of 50 and of 60 Hz alike, are multiples of 100 ms",
            ));
        };
        let settings = Self {
            target: target.clone(),
            calibration: calibration.to_owned(),
            integration: Duration::from_secs_f64(integration_ms * 1e-3),
            full_scale_lx: positive(FULL_SCALE_LX)?,
        };
        let own = [CALIBRATION, INTEGRATION_MS, FULL_SCALE_LX];
        Ok((settings, target.clone().without(&own)))
    }

    /// Spectral irradiance of one linear count a second in each pixel, W/(m²·nm), and where it is from.
    ///
    /// # Errors
    /// [`OpenError::Address`] where the file cannot be read, or the instrument stores no calibration.
    pub fn factors(&self, properties: &SpectroradiometerProperties) -> Result<(Vec<f64>, String), OpenError> {
        if self.calibration == "device" {
            let stored = properties.irradiance_factor.clone();
            let stored = stored.ok_or_else(|| {
                self.wrong(
                    "the instrument stores no calibration that can be used: name a CSV file of wavelength_nm,factor",
                )
            })?;
            let text = stored
                .iter()
                .fold(String::new(), |text, one| text + &format!("{one:e}\n"));
            let said = format!("calibration of the instrument, SHA-256 {}", sha256(text.as_bytes()));
            return Ok((stored, said));
        }
        let path = Utf8PathBuf::try_from(self.target.path(&self.calibration));
        let path = path.map_err(|error| self.wrong(error.to_string()))?;
        let text = std::fs::read_to_string(&path).map_err(|error| self.wrong(format!("{path}: {error}")))?;
        let table = parse_calibration(&path, &text).map_err(|error| self.wrong(error.to_string()))?;
        let said = format!("calibration {}, SHA-256 {}", self.calibration, sha256(text.as_bytes()));
        Ok((factors_at(&properties.wavelength_nm, &table), said))
    }

    /// What is wrong with the address.
    pub fn wrong(&self, reason: impl Into<String>) -> OpenError {
        self.target.wrong(reason)
    }
}
