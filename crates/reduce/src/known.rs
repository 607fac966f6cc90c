//! What is known of the spectroradiometer's own uncertainty.

use isolux_record::observation::SharedErrors;
use isolux_record::run::Run;
use isolux_record::spectra::DarkSubtraction;

use crate::instrument::{self, Chain};

/// What the station states of the spectroradiometer, and what it does not.
#[derive(Debug, Default)]
pub struct Known {
    pub calibration_rel: f64,
    pub distance_rel: f64,
    pub stray_rel: f64,
    /// Of the ratio of 700 nm to 400 nm.
    pub shape_rel: f64,
    /// Of the wavelength scale.
    pub wavelength_nm: f64,
    /// Missing in the level of the light.
    pub level: Vec<String>,
    /// Missing in its colour.
    pub colour: Vec<String>,
    /// Missing where nothing bounds its stray light.
    pub stray_missing: Vec<String>,
}

impl Known {
    /// Of the spectra of a run at this distance.
    pub fn of(run: &Run, chain: Chain, distance_mm: f64) -> Self {
        let settings = run.header.station.spectroradiometer();
        let mut known = Self::default();
        let stated = |value: Option<f64>, missing: &mut Vec<String>, what: &str| {
            if value.is_none() {
                missing.push(what.to_owned());
            }
            value.unwrap_or(0.0)
        };
        let of = |key: fn(&isolux_record::station::Spectroradiometer) -> Option<f64>| settings.and_then(key);
        known.calibration_rel = stated(
            of(|settings| settings.u_rel),
            &mut known.level,
            "the station states no spectroradiometer.u_rel: its calibration",
        );
        known.distance_rel = stated(
            of(|settings| settings.u_distance_mm).map(|u_mm| 2.0 * u_mm / distance_mm),
            &mut known.level,
            "the station states no spectroradiometer.u_distance_mm: its distance",
        );
        // Nothing was put before the lamp for the spectrum: what comes another way is in it.
        known.stray_rel = stated(
            of(|settings| settings.stray_max_rel).map(|bound| bound / 3.0_f64.sqrt()),
            &mut known.stray_missing,
            "the spectrum is not corrected for stray light (spectroradiometer.stray_max_rel)",
        );
        known.level.extend(known.stray_missing.iter().cloned());
        known.shape_rel = stated(
            of(|settings| settings.u_shape_rel),
            &mut known.colour,
            "the station states no spectroradiometer.u_shape_rel: spectral shape of the calibration",
        );
        known.wavelength_nm = stated(
            of(|settings| settings.u_wavelength_nm),
            &mut known.colour,
            "the station states no spectroradiometer.u_wavelength_nm: wavelength scale",
        );
        if chain.dark == DarkSubtraction::Off {
            for missing in [&mut known.level, &mut known.colour] {
                missing.push("not corrected for the dark spectrum".to_owned());
            }
        }
        if let Some(calibration) = &run.header.spectral {
            known.colour.extend(instrument::left_out(calibration, chain));
        }
        known
    }

    /// What all values of a spectrum share, none where something of it is not stated.
    pub fn shared(&self) -> SharedErrors {
        let level = self.calibration_rel.hypot(self.distance_rel).hypot(self.stray_rel);
        let stated = |value: f64| (value > 0.0).then_some(value);
        SharedErrors {
            gain_rel: stated(level).filter(|_| self.level.is_empty()),
            shape_rel: stated(self.shape_rel),
            wavelength_nm: stated(self.wavelength_nm),
        }
    }
}
