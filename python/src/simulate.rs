//! The light on a sensor: `simulate`.

use std::path::PathBuf;

use camino::Utf8PathBuf;
use isolux_app::Failure;
use isolux_app::files::{self, Overwrite};
use isolux_app::front_end::progress::{Event, Progress};
use isolux_app::simulation::scene::{self, Changes, Value};
use isolux_app::simulation::simulate::{self as solver, Accuracy, Method, Sampling, Stop};
use numpy::{PyArray1, PyArray2};
use pyo3::exceptions::{PyTypeError, PyValueError};
use pyo3::prelude::*;
use pyo3::types::{PyBytes, PyDict};

use crate::arrays::rows;
use crate::distribution::Distribution;
use crate::document::to_python;
use crate::error::raised;
use crate::path::utf8;
use crate::spectrum::Spectrum;
use crate::wait::on_thread;

/// A map of the light on a sensor, with its bound and facts. `numpy.asarray` gives the map.
#[pyclass(frozen, module = "isolux")]
pub(crate) struct Simulation {
    solved: solver::Exact,
}

/// The light of `luminaire` (a scene, model, run folder or photometric file, or a `Distribution`) on a sensor.
#[pyfunction]
#[pyo3(signature = (luminaire, *, distance_mm=None, sensor_mm=None, pixels=None, spectrum=None, emitter=None,
    accuracy=None, method="inverse", sampling=None, rays=None, seed=None, luminous_area=false,
    changes=None, progress=None))]
#[expect(clippy::too_many_arguments, reason = "keywords")]
pub(crate) fn simulate(
    py: Python<'_>,
    luminaire: &Bound<'_, PyAny>,
    distance_mm: Option<f64>,
    sensor_mm: Option<&Bound<'_, PyAny>>,
    pixels: Option<&Bound<'_, PyAny>>,
    spectrum: Option<&Bound<'_, PyAny>>,
    emitter: Option<&Bound<'_, PyAny>>,
    accuracy: Option<&str>,
    method: &str,
    sampling: Option<&str>,
    rays: Option<f64>,
    seed: Option<u64>,
    luminous_area: bool,
    changes: Option<&Bound<'_, PyDict>>,
    progress: Option<&Bound<'_, PyAny>>,
) -> PyResult<Simulation> {
    let mut set = Vec::new();
    if let Some(emitter) = emitter {
        set.push(change("luminaire.emitter", emitter)?);
    }
    for (key, value) in changes.into_iter().flatten() {
        set.push(change(&key.extract::<String>()?, &value)?);
    }
    let mut asked = Changes {
        spectrum: None,
        distance_mm,
        sensor_mm: sensor_mm.map(one_or_two).transpose()?,
        pixels: pixels.map(one_or_two).transpose()?,
        accuracy: accuracy.map(accuracy_of).transpose()?,
        set,
        luminous_area,
    };
    let method = method_of(method, sampling, rays, seed)?;
    let source = if let Ok(distribution) = luminaire.cast::<Distribution>() {
        let spectrum = spectrum.map(spectrum_in_memory).transpose()?;
        Source::Memory(Box::new((distribution.get().grid().clone(), spectrum)))
    } else {
        asked.spectrum = spectrum.map(|path| utf8(py, path.extract()?)).transpose()?;
        Source::File(utf8(py, luminaire.extract()?)?)
    };
    let stop = Stop::default();
    let requested = stop.clone();
    let solved = on_thread(py, progress, move |listener| {
        source.solve(&asked, method, &requested, listener)
    });
    if solved.is_err() {
        stop.request();
    }
    Ok(Simulation { solved: solved? })
}

/// What is lit.
enum Source {
    File(Utf8PathBuf),
    Memory(
        Box<(
            isolux_app::formats::IntensityDistribution,
            Option<isolux_app::formats::Spectrum>,
        )>,
    ),
}

impl Source {
    fn solve(
        self,
        asked: &Changes,
        method: Method,
        stop: &Stop,
        listener: &dyn Progress,
    ) -> Result<solver::Exact, Failure> {
        let (scene, path) = match self {
            Self::File(path) => (scene::load(&path, asked)?, path),
            Self::Memory(parts) => (
                scene::of_distribution(parts.0, parts.1, asked)?,
                Utf8PathBuf::from("the distribution"),
            ),
        };
        listener.event(Event::Began {
            step: "simulate",
            total: None,
        });
        let mut solved = solver::solve_exact(&scene, method, stop).map_err(|failure| Failure {
            message: format!("{path}: {}", failure.message),
            ..failure
        })?;
        if let Some(assumption) = scene::assumption(&path, &scene, asked) {
            solved.facts.findings.insert(0, assumption);
        }
        Ok(solved)
    }
}

/// A spectrum object, or one in a file.
fn spectrum_in_memory(spectrum: &Bound<'_, PyAny>) -> PyResult<isolux_app::formats::Spectrum> {
    let py = spectrum.py();
    if let Ok(object) = spectrum.cast::<Spectrum>() {
        return object.get().curve(py);
    }
    let read = crate::read::read(py, spectrum.extract()?, None, false, false)?.into_bound(py);
    read.cast::<Spectrum>().map_err(PyErr::from)?.get().curve(py)
}

/// `key=value` as the scene file would have it.
fn change(key: &str, value: &Bound<'_, PyAny>) -> PyResult<String> {
    let value: Value = pythonize::depythonize(value)
        .map_err(|error| PyTypeError::new_err(format!("{key}: no value of a scene file: {error}")))?;
    Ok(format!("{key}={value}"))
}

/// One number for both sides, or one for each.
fn one_or_two<'py, T: Copy + FromPyObjectOwned<'py>>(value: &Bound<'py, PyAny>) -> PyResult<[T; 2]> {
    if let Ok(one) = value.extract::<T>() {
        return Ok([one; 2]);
    }
    value
        .extract::<(T, T)>()
        .map(|(x, y)| [x, y])
        .map_err(|_| PyTypeError::new_err(format!("{value} is neither one number nor two, along x and y")))
}

fn accuracy_of(word: &str) -> PyResult<Accuracy> {
    match word {
        "standard" => Ok(Accuracy::Standard),
        "reference" => Ok(Accuracy::Reference),
        other => Err(PyValueError::new_err(format!(
            "accuracy = {other:?} is neither 'standard' nor 'reference'"
        ))),
    }
}

fn method_of(method: &str, sampling: Option<&str>, rays: Option<f64>, seed: Option<u64>) -> PyResult<Method> {
    let sampling = match sampling {
        None | Some("thinned") => Sampling::Thinned,
        Some("traced") => Sampling::Traced,
        Some("expected") => Sampling::Expected,
        Some(other) => {
            let message = format!("sampling = {other:?} is none of 'traced', 'thinned', 'expected'");
            return Err(PyValueError::new_err(message));
        }
    };
    match method {
        "inverse" if rays.is_some() || seed.is_some() => Err(PyValueError::new_err(
            "rays and seed are for method='direct'; the inverse method draws none",
        )),
        "inverse" => Ok(Method::Inverse),
        "direct" => {
            let rays = rays.unwrap_or(2e9);
            if !(1.0..=1e18).contains(&rays) || rays.fract() != 0.0 {
                return Err(PyValueError::new_err(format!("rays = {rays} is no number of rays")));
            }
            Ok(Method::Direct {
                sampling,
                rays: rays as u64,
                seed: seed.unwrap_or(1),
            })
        }
        other => Err(PyValueError::new_err(format!(
            "method = {other:?} is neither 'inverse' nor 'direct'"
        ))),
    }
}

#[pymethods]
impl Simulation {
    /// Mean of each pixel in `unit`, shape (ny, nx); not a copy.
    #[getter]
    fn irradiance<'py>(slf: &Bound<'py, Self>) -> PyResult<Bound<'py, PyArray2<f64>>> {
        rows(slf, slf.get().solved.facts.pixels[0], |own| &own.solved.map)
    }

    #[pyo3(signature = (dtype=None, copy=None))]
    fn __array__<'py>(
        slf: &Bound<'py, Self>,
        dtype: Option<&Bound<'py, PyAny>>,
        copy: Option<bool>,
    ) -> PyResult<Bound<'py, PyAny>> {
        let map = Self::irradiance(slf)?.into_any();
        match (dtype, copy) {
            (Some(dtype), _) => map.call_method1("astype", (dtype,)),
            (None, Some(true)) => map.call_method0("copy"),
            _ => Ok(map),
        }
    }

    /// "W/m2", or "lx" where the luminaire has no spectrum and no efficacy.
    #[getter]
    fn unit(&self) -> &'static str {
        self.solved.facts.unit.symbol()
    }

    /// Mean over the sensor, in `unit`.
    #[getter]
    fn mean(&self) -> f64 {
        self.solved.facts.mean
    }

    /// Inverse: bound on the error of the quadrature of the mean; direct: its standard error by ray counting.
    #[getter]
    fn u_mean_numeric(&self) -> f64 {
        self.solved.facts.u_mean_numeric
    }

    /// What the error of no pixel exceeds, in `unit`; None for the direct method.
    #[getter]
    fn pixel_error_bound<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        to_python(py, &self.solved.facts.pixel_error_bound)
    }

    /// All facts, with the keys of `result.json`.
    #[getter]
    fn facts<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        to_python(py, &self.solved.facts)
    }

    /// Digital numbers of one exposure, shape (ny, nx), where the scene has a camera.
    #[getter]
    fn signal_dn<'py>(slf: &Bound<'py, Self>) -> PyResult<Option<Bound<'py, PyArray2<u16>>>> {
        if slf.get().solved.signal_dn.is_none() {
            return Ok(None);
        }
        rows(slf, slf.get().solved.facts.pixels[0], |own| {
            own.solved.signal_dn.as_deref().unwrap_or_default()
        })
        .map(Some)
    }

    /// Middles of the pixels along x in mm, shape (nx,).
    #[getter]
    fn x_mm<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<f64>> {
        self.middles(py, 0)
    }

    /// Middles of the pixels along y in mm, shape (ny,).
    #[getter]
    fn y_mm<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<f64>> {
        self.middles(py, 1)
    }

    /// The map on a matplotlib axes, made where none is given; returns the axes.
    #[pyo3(signature = (ax=None))]
    fn plot<'py>(slf: &Bound<'py, Self>, ax: Option<Bound<'py, PyAny>>) -> PyResult<Bound<'py, PyAny>> {
        slf.py()
            .import("isolux._plots")?
            .getattr("sensor_map")?
            .call1((slf, ax))
    }

    /// Writes `irradiance.npy` (float32), `irradiance.png` and `result.json` into a folder, as `isolux simulate` does.
    #[pyo3(signature = (out, *, force=false))]
    fn write(&self, py: Python<'_>, out: PathBuf, force: bool) -> PyResult<()> {
        let out = utf8(py, out)?;
        let simulation = self.solved.clone();
        py.detach(|| {
            let overwrite = Overwrite::requested(force);
            files::refuse_occupied(&out, overwrite)?;
            solver::write(
                &files::output_folder(&out, overwrite)?,
                &simulation.rounded(),
                None,
                overwrite,
            )
        })
        .map_err(|failure| raised(py, failure))
    }

    /// The map as it stands in `irradiance.png`.
    fn _repr_png_<'py>(&self, py: Python<'py>) -> Bound<'py, PyBytes> {
        let png = py.detach(|| solver::picture(&self.solved.clone().rounded()));
        PyBytes::new(py, &png)
    }

    fn __repr__(&self) -> String {
        let [nx, ny] = self.solved.facts.pixels;
        format!(
            "<isolux.Simulation {nx} × {ny} pixels, mean {:.4} {}, {}>",
            self.solved.facts.mean,
            self.unit(),
            self.solved.facts.method
        )
    }
}

impl Simulation {
    fn middles<'py>(&self, py: Python<'py>, axis: usize) -> Bound<'py, PyArray1<f64>> {
        let (size_mm, count) = (self.solved.facts.size_mm[axis], self.solved.facts.pixels[axis]);
        let pitch_mm = size_mm / count as f64;
        let middles: Vec<f64> = (0..count)
            .map(|k| (k as f64 + 0.5) * pitch_mm - size_mm / 2.0)
            .collect();
        PyArray1::from_vec(py, middles)
    }
}
