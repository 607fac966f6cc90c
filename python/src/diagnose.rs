//! Where model and measurement disagree, and what a model predicts.

use std::path::PathBuf;

use isolux_app::diagnosis::diagnose::{self, DiagnoseRequest};
use isolux_app::files::Overwrite;
use isolux_app::simulation::predict;
use numpy::IntoPyArray;
use pyo3::prelude::*;
use pyo3::types::PyDict;

use crate::document::to_python;
use crate::path::utf8;
use crate::wait::on_thread;

/// Diagnoses into the folder `out`; returns diagnosis.json, the difference of the models, and the adopted model.
#[pyfunction]
#[pyo3(signature = (model, observations, out, *, held_out=None, seed=1, accept=false, force=false, progress=None))]
pub(crate) fn _diagnose<'py>(
    py: Python<'py>,
    model: PathBuf,
    observations: Vec<PathBuf>,
    out: PathBuf,
    held_out: Option<PathBuf>,
    seed: u64,
    accept: bool,
    force: bool,
    progress: Option<&Bound<'py, PyAny>>,
) -> PyResult<(Bound<'py, PyAny>, Vec<String>, Option<String>)> {
    let request = DiagnoseRequest {
        model: utf8(py, model)?,
        observations: observations
            .into_iter()
            .map(|path| utf8(py, path))
            .collect::<PyResult<_>>()?,
        out: utf8(py, out)?,
        held_out: held_out.map(|path| utf8(py, path)).transpose()?,
        seed,
        accept,
        overwrite: Overwrite::requested(force),
    };
    let found = on_thread(py, progress, move |listener| diagnose::run(&request, listener))?;
    let document = to_python(py, &found.document)?;
    Ok((
        document,
        found.diff,
        found.accepted.map(camino::Utf8PathBuf::into_string),
    ))
}

/// What `model` says would be read at the coordinates of `observations`: (facts, columns as text, name, values).
#[pyfunction]
#[expect(clippy::type_complexity, reason = "four values, which the Python half names")]
pub(crate) fn _predict(
    py: Python<'_>,
    model: PathBuf,
    observations: PathBuf,
) -> PyResult<(Bound<'_, PyAny>, Bound<'_, PyDict>, &'static str, Bound<'_, PyAny>)> {
    let (model, observations) = (utf8(py, model)?, utf8(py, observations)?);
    let (facts, table) = on_thread(py, None, move |_| predict::table(&model, &observations))?;
    let columns = PyDict::new(py);
    for (k, name) in table.header.iter().enumerate() {
        let column: Vec<&str> = table.coordinates.iter().map(|row| row[k].as_str()).collect();
        columns.set_item(name, column)?;
    }
    let values = table.values.into_pyarray(py).into_any();
    Ok((to_python(py, &facts)?, columns, table.column, values))
}
