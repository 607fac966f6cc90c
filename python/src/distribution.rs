//! A luminous intensity distribution.

use std::path::PathBuf;

use isolux_app::formats::convert::{Edit, Options, Photometry, Symmetry};
use isolux_app::formats::inspect::{self, Inspection, Quantities};
use isolux_app::formats::{self as files, Content, IntensityDistribution, WriteOptions};
use numpy::{
    IntoPyArray, PyArray1, PyArray2, PyArrayDyn, PyArrayMethods, PyReadonlyArray1, PyReadonlyArray2, PyReadonlyArrayDyn,
};
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use pyo3::types::PyDict;

use crate::arrays::{rows, view};
use crate::document::to_python;
use crate::error::bad_input;
use crate::pictures;
use crate::write::write;

/// A luminous intensity distribution in candela over C (degrees, full circle) and gamma (degrees).
#[pyclass(frozen, module = "isolux")]
pub(crate) struct Distribution {
    inspection: Inspection,
}

impl Distribution {
    /// Of an inspection with a distribution.
    pub(crate) fn new(inspection: Inspection) -> Self {
        Self { inspection }
    }

    fn file(&self) -> &files::Distribution {
        match &self.inspection.content {
            Some(Content::Distribution(distribution)) => distribution,
            _ => unreachable!("`new` is called with a distribution"),
        }
    }

    /// Absolute candela over C and γ.
    pub(crate) fn grid(&self) -> &IntensityDistribution {
        &self.file().intensity
    }
}

#[pymethods]
impl Distribution {
    /// Absolute photometry from arrays: C of the half-planes (n), gamma (m), candela (n, m).
    #[new]
    #[pyo3(signature = (c_deg, gamma_deg, intensity_cd))]
    fn from_arrays(
        py: Python<'_>,
        c_deg: PyReadonlyArray1<'_, f64>,
        gamma_deg: PyReadonlyArray1<'_, f64>,
        intensity_cd: PyReadonlyArray2<'_, f64>,
    ) -> PyResult<Self> {
        let shape = intensity_cd.as_array().dim();
        let (c_deg, gamma_deg) = (c_deg.as_array().to_vec(), gamma_deg.as_array().to_vec());
        if shape != (c_deg.len(), gamma_deg.len()) {
            return Err(bad_input(
                py,
                format!(
                    "intensity_cd has the shape {shape:?}; {} half-planes and {} angles gamma are given",
                    c_deg.len(),
                    gamma_deg.len()
                ),
                "give one row a half-plane and one column an angle gamma",
            ));
        }
        let intensity = IntensityDistribution::new(c_deg, gamma_deg, intensity_cd.as_array().iter().copied().collect())
            .map_err(|error| bad_input(py, error, "correct the arrays"))?;
        let content = Content::Distribution(Box::new(files::Distribution::absolute(intensity)));
        Ok(Self::new(inspect::content("arrays", content)))
    }

    /// Half-planes in degrees, rising within [0, 360), shape (n,).
    #[getter]
    fn c_deg<'py>(slf: &Bound<'py, Self>) -> Bound<'py, PyArray1<f64>> {
        view(slf, |own| own.grid().c_deg())
    }

    /// Angles in degrees, rising within [0, 180], shape (m,).
    #[getter]
    fn gamma_deg<'py>(slf: &Bound<'py, Self>) -> Bound<'py, PyArray1<f64>> {
        view(slf, |own| own.grid().gamma_deg())
    }

    /// Candela of the grid, shape (n, m).
    #[getter]
    fn intensity_cd<'py>(slf: &Bound<'py, Self>) -> PyResult<Bound<'py, PyArray2<f64>>> {
        rows(slf, slf.get().grid().gamma_deg().len(), |own| own.grid().intensity_cd())
    }

    /// Candela toward (C, gamma), bilinear between the directions of the grid; arrays are broadcast.
    #[pyo3(name = "intensity")]
    fn at<'py>(
        &self,
        py: Python<'py>,
        c_deg: &Bound<'py, PyAny>,
        gamma_deg: &Bound<'py, PyAny>,
    ) -> PyResult<Bound<'py, PyAny>> {
        let numpy = py.import("numpy")?;
        let broadcast = numpy.call_method1("broadcast_arrays", (c_deg, gamma_deg))?;
        let angle = |k: usize| -> PyResult<PyReadonlyArrayDyn<'py, f64>> {
            let options = PyDict::new(py);
            options.set_item("dtype", "float64")?;
            let array = numpy.call_method("asarray", (broadcast.get_item(k)?,), Some(&options))?;
            Ok(array.cast_into::<PyArrayDyn<f64>>().map_err(PyErr::from)?.readonly())
        };
        let (c, gamma) = (angle(0)?, angle(1)?);
        let (c, gamma) = (c.as_array(), gamma.as_array());
        let bad = c.iter().chain(gamma.iter()).any(|angle| !angle.is_finite());
        if bad || gamma.iter().any(|gamma| !(0.0..=180.0).contains(gamma)) {
            return Err(bad_input(
                py,
                "an angle is not finite, or gamma is outside 0 to 180 degrees",
                "give directions in degrees",
            ));
        }
        let grid = self.grid();
        let mut candela = c.to_owned();
        candela.zip_mut_with(&gamma, |c, gamma| *c = grid.intensity_cd_at(*c, *gamma));
        let array = candela.into_pyarray(py).into_any();
        // A number for numbers, as the functions of numpy give.
        array.get_item(pyo3::types::PyTuple::empty(py))
    }

    /// Luminous flux in lm: the integral over the grid.
    #[getter]
    fn flux_lm(&self) -> f64 {
        self.grid().flux_lm()
    }

    /// Luminous flux in lm between two angles gamma in degrees.
    fn flux_between_lm(&self, from_deg: f64, to_deg: f64) -> f64 {
        self.grid().flux_between_lm(from_deg, to_deg)
    }

    /// Luminous flux in lm of rings of gamma, each `step_deg` wide.
    #[pyo3(signature = (step_deg=10.0))]
    fn zonal_flux_lm<'py>(&self, py: Python<'py>, step_deg: f64) -> PyResult<Bound<'py, PyArray1<f64>>> {
        if !(0.01..=180.0).contains(&step_deg) {
            return Err(bad_input(
                py,
                format!("step_deg = {step_deg} is no width of a ring"),
                "give 0.01 to 180 degrees",
            ));
        }
        Ok(self.grid().zonal_flux_lm(step_deg).into_pyarray(py))
    }

    /// Beam angle in degrees (50 % of the maximum) of the plane through half-plane C; None where it does not fall so
    /// far.
    #[pyo3(signature = (c_deg=0.0))]
    fn beam_angle_deg(&self, py: Python<'_>, c_deg: f64) -> PyResult<Option<f64>> {
        let plane = self.plane(py, c_deg)?;
        Ok(self.grid().beam_angle(plane).map(|beam| beam.full_angle_deg()))
    }

    /// Field angle in degrees (10 % of the maximum) of the plane through half-plane C.
    #[pyo3(signature = (c_deg=0.0))]
    fn field_angle_deg(&self, py: Python<'_>, c_deg: f64) -> PyResult<Option<f64>> {
        let plane = self.plane(py, c_deg)?;
        Ok(self.grid().field_angle(plane).map(|beam| beam.full_angle_deg()))
    }

    /// What follows from the distribution, with the keys of `isolux inspect --json`.
    #[getter]
    fn quantities<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        to_python(py, &self.inspection.quantities)
    }

    /// What the reader found: dictionaries with code, severity, line, column, message and fix.
    #[getter]
    fn findings<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        to_python(py, &self.inspection.findings)
    }

    /// Every field of the file's description.
    #[getter]
    fn header<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        to_python(py, &self.file().header)
    }

    /// Name of the file.
    #[getter]
    fn file_name(&self) -> &str {
        &self.inspection.file
    }

    /// Whether the file holds spectra over angle.
    #[getter]
    fn is_coloured(&self) -> bool {
        matches!(self.inspection.quantities, Quantities::Coloured(_))
    }

    /// Writes a file of the format of its extension; returns what was lost or assumed.
    #[pyo3(signature = (path, *, force=false, edition=None, generation=None, photometry=None, rotate_c_deg=None,
        symmetrize=None, resample_deg=None, scale_flux_lm=None, entries=None))]
    fn write<'py>(
        &self,
        py: Python<'py>,
        path: PathBuf,
        force: bool,
        edition: Option<String>,
        generation: Option<String>,
        photometry: Option<&str>,
        rotate_c_deg: Option<f64>,
        symmetrize: Option<&str>,
        resample_deg: Option<(f64, f64)>,
        scale_flux_lm: Option<f64>,
        entries: Option<Vec<(String, String)>>,
    ) -> PyResult<Bound<'py, PyAny>> {
        let photometry = photometry
            .map(|name| match name {
                "A" => Ok(Photometry::A),
                "B" => Ok(Photometry::B),
                "C" => Ok(Photometry::C),
                other => Err(PyValueError::new_err(format!(
                    "photometry = {other:?} is none of 'A', 'B', 'C'"
                ))),
            })
            .transpose()?;
        let symmetrize = symmetrize
            .map(|name| match name {
                "rotational" => Ok(Symmetry::Rotational),
                "c0-c180" => Ok(Symmetry::C0C180),
                "c90-c270" => Ok(Symmetry::C90C270),
                "quadrant" => Ok(Symmetry::Quadrant),
                other => Err(PyValueError::new_err(format!(
                    "symmetrize = {other:?} is none of 'rotational', 'c0-c180', 'c90-c270', 'quadrant'"
                ))),
            })
            .transpose()?;
        let light = [
            rotate_c_deg.map(Edit::RotateC),
            symmetrize.map(Edit::Symmetrize),
            resample_deg.map(|(c, gamma)| Edit::Resample(c, gamma)),
            scale_flux_lm.map(Edit::ScaleFlux),
        ];
        let entries = entries
            .unwrap_or_default()
            .into_iter()
            .map(|(key, text)| Edit::Set(key, text));
        let requested = Options {
            write: WriteOptions {
                edition,
                generation,
                photometry,
                edited: false,
            },
            edits: light.into_iter().flatten().chain(entries).collect(),
            ..Options::default()
        };
        write(py, &self.inspection, path, &requested, force)
    }

    /// A polar diagram on a matplotlib axes, made where none is given; returns the axes.
    #[pyo3(signature = (ax=None))]
    fn plot<'py>(slf: &Bound<'py, Self>, ax: Option<Bound<'py, PyAny>>) -> PyResult<Bound<'py, PyAny>> {
        slf.py().import("isolux._plots")?.getattr("polar")?.call1((slf, ax))
    }

    /// The picture `kind` of the report as SVG: "polar", "cartesian", "isocandela", "isolux" or "solid".
    #[pyo3(signature = (kind="polar"))]
    fn svg(&self, kind: &str) -> PyResult<String> {
        pictures::one(self.inspection.content.as_ref(), &self.inspection.file, kind)
    }

    fn _repr_svg_(&self) -> PyResult<String> {
        self.svg("polar")
    }

    fn _repr_html_(&self) -> PyResult<String> {
        let grid = self.grid();
        let peak = grid.peak();
        let facts = [
            ("luminous flux", format!("{:.4} lm", grid.flux_lm())),
            (
                "largest intensity",
                format!(
                    "{:.4} cd at C {}°, γ {}°",
                    peak.intensity_cd, peak.c_deg, peak.gamma_deg
                ),
            ),
            (
                "grid",
                format!("{} half-planes × {} γ", grid.c_deg().len(), grid.gamma_deg().len()),
            ),
            ("findings", self.inspection.findings.len().to_string()),
        ];
        Ok(pictures::card(&self.inspection.file, &facts, &self.svg("polar")?))
    }

    fn __repr__(&self) -> String {
        let grid = self.grid();
        format!(
            "<isolux.Distribution {}: {} half-planes × {} gamma, {:.4} lm, {} findings>",
            self.inspection.file,
            grid.c_deg().len(),
            grid.gamma_deg().len(),
            grid.flux_lm(),
            self.inspection.findings.len()
        )
    }
}

impl Distribution {
    fn plane(&self, py: Python<'_>, c_deg: f64) -> PyResult<usize> {
        let grid = self.grid();
        let plane = if grid.is_rotational() {
            Some(0)
        } else {
            grid.plane_at(c_deg)
        };
        plane.ok_or_else(|| bad_input(py, format!("there is no half-plane C {c_deg}°"), "take one of c_deg"))
    }
}
