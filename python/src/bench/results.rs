//! What a bench answers.

use isolux_app::manual::{self, spectrum};
use numpy::{Ix1, PyArray};
use pyo3::prelude::*;

use crate::arrays::view;
use crate::document::to_python;

/// Where the axes stand, read back.
#[pyclass(frozen, get_all, eq, module = "isolux")]
#[derive(PartialEq)]
pub(crate) struct Position {
    /// C in degrees.
    c_deg: f64,
    /// γ in degrees, signed.
    gamma_deg: f64,
    /// Distance of the detector in mm, where it is driven and was asked for.
    distance_mm: Option<f64>,
}

#[pymethods]
impl Position {
    fn __repr__(&self) -> String {
        let distance = self
            .distance_mm
            .map_or_else(String::new, |mm| format!(", distance_mm={mm:?}"));
        let Self { c_deg, gamma_deg, .. } = self;
        format!("Position(c_deg={c_deg:?}, gamma_deg={gamma_deg:?}{distance})")
    }
}

impl From<manual::Position> for Position {
    fn from(at: manual::Position) -> Self {
        let manual::Position {
            c_deg,
            gamma_deg,
            distance_mm,
        } = at;
        Self {
            c_deg,
            gamma_deg,
            distance_mm,
        }
    }
}

/// One reading of the lux meter, and of the power meter with it.
#[pyclass(frozen, get_all, module = "isolux")]
pub(crate) struct LuxReading {
    /// Illuminance in lx after the station's calibration factor; `None` out of range or of unsteady light.
    illuminance_lx: Option<f64>,
    /// One digit of the display in lx.
    digit_lx: f64,
    /// The meter's range.
    range: u8,
    /// `ok`, `over_range`, `under_range` or `unsteady`.
    quality: &'static str,
    /// Voltage of the lamp's supply in V, where the bench has a power meter that gave a number.
    voltage_v: Option<f64>,
    /// Its current in A.
    current_a: Option<f64>,
    /// Its active power in W.
    power_w: Option<f64>,
    /// Active power ÷ (voltage · current).
    power_factor: Option<f64>,
}

#[pymethods]
impl LuxReading {
    fn __repr__(&self) -> String {
        let lux = self
            .illuminance_lx
            .map_or_else(|| "None".to_owned(), |lux| format!("{lux:?}"));
        let Self {
            digit_lx,
            range,
            quality,
            ..
        } = self;
        format!("LuxReading(illuminance_lx={lux}, quality='{quality}', range={range}, digit_lx={digit_lx:?})")
    }
}

impl From<manual::Lux> for LuxReading {
    fn from(lux: manual::Lux) -> Self {
        Self {
            illuminance_lx: lux.illuminance_lx,
            digit_lx: lux.digit_lx,
            range: lux.range,
            quality: lux.quality,
            voltage_v: lux.electrical.voltage_v,
            current_a: lux.electrical.current_a,
            power_w: lux.electrical.power_w,
            power_factor: lux.electrical.power_factor,
        }
    }
}

/// The lamp is stable.
#[pyclass(frozen, get_all, module = "isolux")]
pub(crate) struct WarmedUp {
    /// Seconds since it was switched on.
    elapsed_s: f64,
    /// (max − min)/mean over the window.
    spread_rel: f64,
    /// Illuminance at the reference point in lx.
    illuminance_lx: f64,
}

#[pymethods]
impl WarmedUp {
    fn __repr__(&self) -> String {
        let Self {
            elapsed_s,
            spread_rel,
            illuminance_lx,
        } = self;
        format!("WarmedUp(elapsed_s={elapsed_s:?}, spread_rel={spread_rel:?}, illuminance_lx={illuminance_lx:?})")
    }
}

impl From<manual::WarmedUp> for WarmedUp {
    fn from(stable: manual::WarmedUp) -> Self {
        let manual::WarmedUp {
            elapsed_s,
            spread_rel,
            illuminance_lx,
        } = stable;
        Self {
            elapsed_s,
            spread_rel,
            illuminance_lx,
        }
    }
}

/// One spectrum of the light as it is, with its colorimetry.
#[pyclass(frozen, module = "isolux")]
pub(crate) struct SpectrumReading(spectrum::Reading);

#[pymethods]
impl SpectrumReading {
    /// Wavelengths in nm, shape (n,): pixels with a calibration. Read-only.
    #[getter]
    fn wavelength_nm<'py>(slf: &Bound<'py, Self>) -> Bound<'py, PyArray<f64, Ix1>> {
        view(slf, |reading: &Self| &reading.0.wavelength_nm)
    }

    /// Spectral irradiance in W/(m² nm), shape (n,). Read-only.
    #[getter]
    fn irradiance_w_m2_nm<'py>(slf: &Bound<'py, Self>) -> Bound<'py, PyArray<f64, Ix1>> {
        view(slf, |reading: &Self| &reading.0.irradiance_w_m2_nm)
    }

    /// Integration time that was found, in s.
    #[getter]
    fn integration_s(&self) -> f64 {
        self.0.integration_s
    }

    /// Highest raw counts as a share of saturation.
    #[getter]
    fn peak_of_saturation(&self) -> f64 {
        self.0.peak_of_saturation
    }

    /// Pixels at or above saturation: their values are "at least".
    #[getter]
    fn saturated_pixels(&self) -> usize {
        self.0.saturated_pixels
    }

    /// What was subtracted as dark: `dark_pixels` or `shutter`.
    #[getter]
    fn dark(&self) -> &'static str {
        self.0.dark
    }

    /// Temperature of the detector in °C, where the instrument states it.
    #[getter]
    fn detector_c(&self) -> Option<f64> {
        self.0.detector_c
    }

    /// Illuminance by V(λ) and 683 lm/W, in lx.
    #[getter]
    fn illuminance_lx(&self) -> f64 {
        self.0.illuminance_lx
    }

    /// Irradiance over 360–830 nm, in W/m².
    #[getter]
    fn irradiance_w_m2(&self) -> f64 {
        self.0.irradiance_w_m2
    }

    /// Colorimetry: `x`, `y`, `cct_k`, `duv`, `ra`, `rf`, `peak_nm`, …; `None` where a quantity is not defined.
    #[getter]
    fn quantities<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        to_python(py, &self.0.quantities)
    }

    fn __repr__(&self) -> String {
        let (lux, pixels) = (self.0.illuminance_lx, self.0.wavelength_nm.len());
        format!("<isolux.SpectrumReading of {pixels} pixels, {lux:.3} lx>")
    }
}

impl From<spectrum::Reading> for SpectrumReading {
    fn from(reading: spectrum::Reading) -> Self {
        Self(reading)
    }
}

/// What a scan came to.
#[pyclass(frozen, get_all, module = "isolux")]
pub(crate) struct ScanSummary {
    /// The run directory.
    run: String,
    /// Points of the plan.
    points: u64,
    /// Readings recorded in this session.
    readings: u64,
    /// Spectra recorded in this session.
    spectra: u64,
    /// Readings without a number: over or under range, failed.
    without_number: u64,
    /// Points whose light did not settle.
    unsettled: u64,
    /// Answers that were lost or damaged and asked again.
    retries: u64,
    /// Visits that were made again.
    visits_again: u64,
    /// How long it took, in s of the bench's clock.
    duration_s: f64,
    /// Seconds until the lamp was stable, where it was warmed up.
    warm_up_s: Option<f64>,
}

#[pymethods]
impl ScanSummary {
    fn __repr__(&self) -> String {
        let Self {
            run, points, readings, ..
        } = self;
        format!("<isolux.ScanSummary of {run}: {points} points, {readings} readings>")
    }
}

impl ScanSummary {
    pub(crate) fn of(summary: &isolux_app::scan::ScanSummary, run: String) -> Self {
        Self {
            run,
            points: summary.points,
            readings: summary.readings,
            spectra: summary.spectra,
            without_number: summary.without_number,
            unsettled: summary.unsettled,
            retries: summary.retries,
            visits_again: summary.visits_again,
            duration_s: summary.duration_s,
            warm_up_s: summary.warm_up_s,
        }
    }
}
