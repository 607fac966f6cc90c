//! A spectrum.

use std::path::PathBuf;

use isolux_app::formats::convert::{Interpolation, Options};
use isolux_app::formats::inspect::{self, Inspection, Quantities, SpectrumQuantities};
use isolux_app::formats::{self as files, Content, SpectrumFile};
use numpy::{PyArray1, PyReadonlyArray1};
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;

use crate::arrays::view;
use crate::document::to_python;
use crate::error::bad_input;
use crate::pictures;
use crate::write::write;

/// A spectrum: values over wavelengths in nm.
#[pyclass(frozen, module = "isolux")]
pub(crate) struct Spectrum {
    inspection: Inspection,
}

impl Spectrum {
    /// Of an inspection with a spectrum.
    pub(crate) fn new(inspection: Inspection) -> Self {
        Self { inspection }
    }

    fn file(&self) -> &SpectrumFile {
        match &self.inspection.content {
            Some(Content::Spectrum(spectrum)) => spectrum,
            _ => unreachable!("`new` is called with a spectrum"),
        }
    }

    /// The values as a spectrum, for use cases that take one.
    ///
    /// # Errors
    /// `InputError` where the values are none.
    pub(crate) fn curve(&self, py: Python<'_>) -> PyResult<files::Spectrum> {
        let spectrum = self.file().spectrum();
        spectrum.map_err(|error| bad_input(py, format!("{}: {error}", self.inspection.file), "correct the file"))
    }

    fn known(&self) -> Option<&SpectrumQuantities> {
        match &self.inspection.quantities {
            Quantities::Spectrum(quantities) => Some(quantities),
            _ => None,
        }
    }
}

#[pymethods]
impl Spectrum {
    /// A spectrum from arrays of one length: wavelengths in nm, rising, and values.
    #[new]
    #[pyo3(signature = (wavelength_nm, value, *, quantity=None, unit=None))]
    fn from_arrays(
        py: Python<'_>,
        wavelength_nm: PyReadonlyArray1<'_, f64>,
        value: PyReadonlyArray1<'_, f64>,
        quantity: Option<&str>,
        unit: Option<&str>,
    ) -> PyResult<Self> {
        let spectrum = files::Spectrum::new(wavelength_nm.as_array().to_vec(), value.as_array().to_vec())
            .map_err(|error| bad_input(py, error, "correct the arrays"))?;
        let content = Content::Spectrum(Box::new(SpectrumFile::new(&spectrum, quantity, unit)));
        Ok(Self::new(inspect::content("arrays", content)))
    }

    /// Wavelengths in nm, rising, shape (n,).
    #[getter]
    fn wavelength_nm<'py>(slf: &Bound<'py, Self>) -> Bound<'py, PyArray1<f64>> {
        view(slf, |own| &own.file().wavelength_nm)
    }

    /// One value a wavelength, in `unit`, shape (n,).
    #[getter]
    fn value<'py>(slf: &Bound<'py, Self>) -> Bound<'py, PyArray1<f64>> {
        view(slf, |own| &own.file().value)
    }

    /// What the values are, where the file says so.
    #[getter]
    fn quantity(&self) -> Option<&str> {
        self.file().quantity.as_deref()
    }

    /// Unit of the values, where the file says so.
    #[getter]
    fn unit(&self) -> Option<&str> {
        self.file().unit.as_deref()
    }

    /// Names of the series of a file with several.
    #[getter]
    fn series(&self) -> Vec<&str> {
        self.file().series.iter().map(|series| series.name.as_str()).collect()
    }

    /// Luminous efficacy of the radiation in lm/W.
    #[getter]
    fn ler_lm_per_w(&self) -> Option<f64> {
        self.known().and_then(|known| known.of.ler_lm_per_w)
    }

    /// Correlated colour temperature in K; None where there is none.
    #[getter]
    fn cct_k(&self) -> Option<f64> {
        self.known().and_then(|known| known.of.cct_k)
    }

    /// Distance from the Planckian locus in CIE 1960 (u, v).
    #[getter]
    fn duv(&self) -> Option<f64> {
        self.known().and_then(|known| known.of.duv)
    }

    /// General colour rendering index (CIE 13.3).
    #[getter]
    fn ra(&self) -> Option<f64> {
        self.known().and_then(|known| known.of.ra)
    }

    /// What follows from the spectrum, with the keys of `isolux inspect --json`.
    #[getter]
    fn quantities<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        to_python(py, &self.inspection.quantities)
    }

    /// What the reader found: dictionaries with code, severity, line, column, message and fix.
    #[getter]
    fn findings<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        to_python(py, &self.inspection.findings)
    }

    /// Every other field of the file.
    #[getter]
    fn header<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        to_python(py, &self.file().header)
    }

    /// Name of the file.
    #[getter]
    fn file_name(&self) -> &str {
        &self.inspection.file
    }

    /// Writes a file of the format of its extension; returns what was lost or assumed.
    #[pyo3(signature = (path, *, force=false, series=None, step_nm=None, interpolation="sprague"))]
    fn write<'py>(
        &self,
        py: Python<'py>,
        path: PathBuf,
        force: bool,
        series: Option<String>,
        step_nm: Option<f64>,
        interpolation: &str,
    ) -> PyResult<Bound<'py, PyAny>> {
        let how = match interpolation {
            "sprague" => Interpolation::Sprague,
            "linear" => Interpolation::Linear,
            other => {
                return Err(PyValueError::new_err(format!(
                    "interpolation = {other:?} is neither 'sprague' nor 'linear'"
                )));
            }
        };
        let requested = Options {
            series,
            resample: step_nm.map(|step_nm| (step_nm, how)),
            ..Options::default()
        };
        write(py, &self.inspection, path, &requested, force)
    }

    /// Values over wavelength on a matplotlib axes, made where none is given; returns the axes.
    #[pyo3(signature = (ax=None))]
    fn plot<'py>(slf: &Bound<'py, Self>, ax: Option<Bound<'py, PyAny>>) -> PyResult<Bound<'py, PyAny>> {
        slf.py().import("isolux._plots")?.getattr("spectrum")?.call1((slf, ax))
    }

    /// The picture `kind` of the report as SVG: "spectrum", "cie1931", "cie1976", "tm30" or "tm30_bins".
    #[pyo3(signature = (kind="spectrum"))]
    fn svg(&self, kind: &str) -> PyResult<String> {
        pictures::one(self.inspection.content.as_ref(), &self.inspection.file, kind)
    }

    fn _repr_svg_(&self) -> PyResult<String> {
        self.svg("spectrum")
    }

    fn _repr_html_(&self) -> PyResult<String> {
        let number =
            |value: Option<f64>, unit: &str| value.map_or("–".to_owned(), |value| format!("{value:.4} {unit}"));
        let facts = [
            ("colour temperature", number(self.cct_k(), "K")),
            ("colour rendering Ra", number(self.ra(), "")),
            ("luminous efficacy of radiation", number(self.ler_lm_per_w(), "lm/W")),
            ("findings", self.inspection.findings.len().to_string()),
        ];
        Ok(pictures::card(&self.inspection.file, &facts, &self.svg("spectrum")?))
    }

    fn __repr__(&self) -> String {
        let nm = &self.file().wavelength_nm;
        let range = nm
            .first()
            .zip(nm.last())
            .map_or(String::new(), |(from, to)| format!(", {from} to {to} nm"));
        format!(
            "<isolux.Spectrum {}: {} values{range}, {} findings>",
            self.inspection.file,
            nm.len(),
            self.inspection.findings.len()
        )
    }
}
