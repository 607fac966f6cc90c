//! The record of a scan: its readings and spectra, and what they are reduced to.

use std::path::PathBuf;
use std::sync::Arc;

use camino::Utf8PathBuf;
use isolux_app::files::Overwrite;
use isolux_app::formats::inspect;
use isolux_app::formats::{self, Content, SpectrumFile};
use isolux_app::run::record::{self, DarkSubtraction, Reading, Run as Record, SpectrumRecord};
use isolux_app::run::reduce::{self, ReduceRequest, Reduction as Found, ResultFile};
use numpy::IntoPyArray;
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use pyo3::types::{PyBytes, PyDict};

use crate::distribution::Distribution;
use crate::document::to_python;
use crate::error::{bad_input, raised};
use crate::path::utf8;
use crate::quantity::Quantity;
use crate::spectrum::Spectrum;
use crate::wait::on_thread;

/// A run directory: what a scan recorded. `isolux.Run` adds tables to it.
#[pyclass(frozen, subclass, module = "isolux._isolux", name = "Run")]
pub(crate) struct Run {
    path: Utf8PathBuf,
    record: Arc<Record>,
}

#[pymethods]
impl Run {
    #[new]
    fn open(py: Python<'_>, path: PathBuf) -> PyResult<Self> {
        let path = utf8(py, path)?;
        let record = py
            .detach(|| record::read(&path))
            .map_err(|failure| raised(py, failure))?;
        Ok(Self {
            path,
            record: Arc::new(record),
        })
    }

    /// The folder.
    #[getter]
    fn path(&self) -> &str {
        self.path.as_str()
    }

    /// What stands in `run.toml`: station, plan, instruments, sessions.
    #[getter]
    fn header<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        to_python(py, &self.record.header)
    }

    /// What a person should know of the record, one sentence each.
    #[getter]
    fn notices(&self) -> Vec<String> {
        self.record.notices.clone()
    }

    /// Columns of `readings.csv` by name, as one array or list each.
    fn _reading_columns<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        let rows = &self.record.readings.rows;
        let columns = PyDict::new(py);
        let whole = |of: &dyn Fn(&Reading) -> i64| rows.iter().map(of).collect::<Vec<_>>().into_pyarray(py);
        let number = |of: &dyn Fn(&Reading) -> Option<f64>| {
            rows.iter()
                .map(|row| of(row).unwrap_or(f64::NAN))
                .collect::<Vec<_>>()
                .into_pyarray(py)
        };
        let text = |of: &dyn Fn(&Reading) -> String| rows.iter().map(of).collect::<Vec<_>>();
        columns.set_item("index", whole(&|row| row.index as i64))?;
        columns.set_item("block", text(&|row| row.block.clone()))?;
        columns.set_item("kind", text(&|row| row.kind.to_string()))?;
        columns.set_item("time_s", number(&|row| row.time_s))?;
        columns.set_item("c_deg", number(&|row| Some(row.c_deg)))?;
        columns.set_item("gamma_deg", number(&|row| Some(row.gamma_deg)))?;
        columns.set_item("distance_mm", number(&|row| Some(row.distance_mm)))?;
        columns.set_item("travel", whole(&|row| row.travel.into()))?;
        columns.set_item("range", whole(&|row| row.range.into()))?;
        columns.set_item("ambient_c", number(&|row| row.ambient_c))?;
        columns.set_item("illuminance_lx", number(&|row| row.illuminance_lx))?;
        columns.set_item("u_lx", number(&|row| row.u_lx))?;
        columns.set_item("quality", text(&|row| row.quality.to_string()))?;
        columns.set_item("role", text(&|row| row.role.to_string()))?;
        columns.set_item("point", whole(&|row| row.point as i64))?;
        columns.set_item("repeat", whole(&|row| row.repeat.into()))?;
        columns.set_item("c_target_deg", number(&|row| Some(row.c_target_deg)))?;
        columns.set_item("gamma_target_deg", number(&|row| Some(row.gamma_target_deg)))?;
        columns.set_item("digit_lx", number(&|row| row.digit_lx))?;
        columns.set_item("integration_s", number(&|row| row.integration_s))?;
        columns.set_item("raw", text(&|row| row.raw.clone()))?;
        columns.set_item("session", whole(&|row| row.session.into()))?;
        columns.set_item("burning", number(&|row| row.burning.map(f64::from)))?;
        columns.set_item("lamp_s", number(&|row| row.lamp_s))?;
        columns.set_item("voltage_v", number(&|row| row.electrical.voltage_v))?;
        columns.set_item("current_a", number(&|row| row.electrical.current_a))?;
        columns.set_item("power_w", number(&|row| row.electrical.power_w))?;
        columns.set_item("power_factor", number(&|row| row.electrical.power_factor))?;
        Ok(columns)
    }

    /// Columns of the spectra by name; those of pixels have the shape (spectra, pixels).
    fn _spectrum_columns<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        let spectra = &self.record.spectra;
        let columns = PyDict::new(py);
        let number = |of: &dyn Fn(&SpectrumRecord) -> Option<f64>| {
            spectra
                .iter()
                .map(|spectrum| of(spectrum).unwrap_or(f64::NAN))
                .collect::<Vec<_>>()
                .into_pyarray(py)
        };
        let whole = |of: &dyn Fn(&SpectrumRecord) -> i64| spectra.iter().map(of).collect::<Vec<_>>().into_pyarray(py);
        columns.set_item("index", whole(&|spectrum| spectrum.index as i64))?;
        columns.set_item(
            "block",
            spectra
                .iter()
                .map(|spectrum| spectrum.block.clone())
                .collect::<Vec<_>>(),
        )?;
        columns.set_item(
            "kind",
            spectra
                .iter()
                .map(|spectrum| spectrum.kind.to_string())
                .collect::<Vec<_>>(),
        )?;
        columns.set_item("point", whole(&|spectrum| spectrum.point as i64))?;
        columns.set_item("time_s", number(&|spectrum| spectrum.time_s))?;
        columns.set_item("lamp_s", number(&|spectrum| spectrum.lamp_s))?;
        columns.set_item("c_deg", number(&|spectrum| Some(spectrum.c_deg)))?;
        columns.set_item("gamma_deg", number(&|spectrum| Some(spectrum.gamma_deg)))?;
        columns.set_item("distance_mm", number(&|spectrum| Some(spectrum.distance_mm)))?;
        columns.set_item("integration_s", number(&|spectrum| Some(spectrum.integration_s)))?;
        columns.set_item("averages", whole(&|spectrum| spectrum.averages.into()))?;
        columns.set_item("detector_c", number(&|spectrum| spectrum.detector_c))?;
        columns.set_item("ambient_c", number(&|spectrum| spectrum.ambient_c))?;
        let pixels = |of: &dyn Fn(&record::Pixel) -> f64| -> Vec<Vec<f64>> {
            let row = |spectrum: &SpectrumRecord| spectrum.pixels.iter().map(of).collect();
            spectra.iter().map(row).collect()
        };
        columns.set_item("wavelength_nm", pixels(&|pixel| pixel.wavelength_nm))?;
        columns.set_item("counts", pixels(&|pixel| pixel.counts))?;
        columns.set_item("u_counts", pixels(&|pixel| pixel.u_counts))?;
        columns.set_item("dark_counts", pixels(&|pixel| pixel.dark_counts))?;
        columns.set_item("irradiance_w_m2_nm", self.irradiance(py)?)?;
        Ok(columns)
    }

    /// Reduces with every correction, or without those that are named; writes only into `out`.
    #[pyo3(signature = (without, *, out=None, force=false, model=None, accept_drift=None))]
    fn _reduce(
        &self,
        py: Python<'_>,
        without: Vec<String>,
        out: Option<PathBuf>,
        force: bool,
        model: Option<PathBuf>,
        accept_drift: Option<String>,
    ) -> PyResult<Reduction> {
        let out = out.map(|out| utf8(py, out)).transpose()?;
        let model = model.map(|model| utf8(py, model)).transpose()?;
        let path = self.path.clone();
        let (found, files) = on_thread(py, None, move |_| {
            let request = ReduceRequest {
                out: out.as_deref(),
                without: &without,
                with: model.as_deref(),
                accept_drift: accept_drift.as_deref(),
                subject: None,
            };
            reduce::made(&path, &request, out.is_some().then(|| Overwrite::requested(force)))
        })?;
        Ok(Reduction { found, files })
    }

    fn __repr__(&self) -> String {
        format!(
            "<isolux.Run {}: {} readings, {} spectra>",
            self.path,
            self.record.readings.rows.len(),
            self.record.spectra.len()
        )
    }
}

impl Run {
    /// W/m²/nm of every spectrum and pixel; NaN where it was saturated. Empty without a calibration.
    fn irradiance(&self, py: Python<'_>) -> PyResult<Vec<Vec<f64>>> {
        let Some(calibration) = &self.record.header.spectral else {
            return Ok(Vec::new());
        };
        let of = |spectrum: &SpectrumRecord| {
            let found = spectrum
                .irradiance(calibration, DarkSubtraction::Spectrum)
                .map_err(|error| bad_input(py, format!("{}: {error}", self.path), "see the calibration in run.toml"))?;
            Ok(found
                .irradiance_w_m2_nm
                .into_iter()
                .map(|value| value.unwrap_or(f64::NAN))
                .collect())
        };
        self.record.spectra.iter().map(of).collect()
    }
}

/// What a run was reduced to, in memory.
#[pyclass(frozen, module = "isolux")]
pub(crate) struct Reduction {
    found: Found,
    files: Vec<ResultFile>,
}

#[pymethods]
impl Reduction {
    /// Luminous flux in lm.
    #[getter]
    fn flux(&self) -> Quantity {
        Quantity(self.found.flux.clone())
    }

    /// Largest intensity in cd.
    #[getter]
    fn i_max(&self) -> Quantity {
        Quantity(self.found.i_max.clone())
    }

    /// Its direction (C, gamma) in degrees.
    #[getter]
    fn i_max_deg(&self) -> (f64, f64) {
        self.found.i_max_deg
    }

    /// Luminous efficacy of the radiation in lm/W, where a spectrum was taken.
    #[getter]
    fn ler(&self) -> Option<Quantity> {
        self.found
            .spectral
            .as_ref()
            .map(|spectral| Quantity(spectral.ler.clone()))
    }

    /// Irradiance on the axis in W/m² at the distance of the spectrum, where one was taken.
    #[getter]
    fn irradiance_on_axis(&self) -> Option<Quantity> {
        self.found
            .spectral
            .as_ref()
            .map(|spectral| Quantity(spectral.irradiance.clone()))
    }

    /// Correlated colour temperature in K, where a spectrum was taken.
    #[getter]
    fn cct(&self) -> Option<Quantity> {
        let spectral = self.found.spectral.as_ref()?;
        spectral.colour.cct.clone().map(Quantity)
    }

    /// Mean irradiance in W/m² of a sensor of the published case by the inverse square law, where a spectrum was
    /// taken.
    #[getter]
    fn sensor_irradiance(&self) -> Option<Quantity> {
        self.found.sensor_irradiance.clone().map(Quantity)
    }

    /// The distribution, negative values included, every digit kept.
    #[getter]
    fn distribution(&self) -> Distribution {
        let file = formats::Distribution::absolute(self.found.grid.distribution.clone());
        let content = Content::Distribution(Box::new(file));
        Distribution::new(inspect::content("reduction", content))
    }

    /// The spectrum on the axis in W/m²/nm, where one was taken.
    #[getter]
    fn spectrum(&self) -> Option<Spectrum> {
        let spectral = self.found.spectral.as_ref()?;
        let file = SpectrumFile::new(&spectral.spectrum, Some("irradiance"), Some("W/(m2*nm)"));
        let content = Content::Spectrum(Box::new(file));
        Some(Spectrum::new(inspect::content("reduction", content)))
    }

    /// What a person should know, one sentence each.
    #[getter]
    fn notes(&self) -> Vec<String> {
        self.found.notes.clone()
    }

    /// Names of the corrections that were left out.
    #[getter]
    fn without(&self) -> Vec<String> {
        self.found.without.iter().map(ToString::to_string).collect()
    }

    /// Uncertainty budget, with the keys of `budget.json`.
    #[getter]
    fn budget<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        let bytes = self.file(py, "budget.json")?;
        py.import("json")?.call_method1("loads", (bytes,))
    }

    /// Names of the result files.
    #[getter]
    fn file_names(&self) -> Vec<&str> {
        self.files.iter().map(|file| file.name.as_str()).collect()
    }

    /// The bytes of one result file, such as "luminaire.ldt".
    fn file<'py>(&self, py: Python<'py>, name: &str) -> PyResult<Bound<'py, PyBytes>> {
        let found = self.files.iter().find(|file| file.name == name);
        found.map(|file| PyBytes::new(py, &file.bytes)).ok_or_else(|| {
            PyValueError::new_err(format!(
                "there is no file {name:?}; there are {}",
                self.file_names().join(", ")
            ))
        })
    }

    fn __repr__(&self) -> String {
        format!("<isolux.Reduction {}>", self.found.flux.stated())
    }
}
