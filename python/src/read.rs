//! Files of any known format: `read` and `read_all`.

use camino::Utf8PathBuf;
use isolux_app::formats::inspect::{self, Inspection};
use isolux_app::formats::{Content, ReadOptions, Severity};
use pyo3::prelude::*;

use crate::distribution::Distribution;
use crate::error::bad_input;
use crate::path::utf8;
use crate::spectrum::Spectrum;

/// The one distribution or spectrum in a file of any known format, with what its reader found.
#[pyfunction]
#[pyo3(signature = (path, *, columns=None, isym3_c90_first=false, apply_future_use=false))]
pub(crate) fn read(
    py: Python<'_>,
    path: std::path::PathBuf,
    columns: Option<[usize; 2]>,
    isym3_c90_first: bool,
    apply_future_use: bool,
) -> PyResult<Py<PyAny>> {
    let mut all = read_all(py, path.clone(), columns, isym3_c90_first, apply_future_use)?;
    if all.len() != 1 {
        return Err(bad_input(
            py,
            format!("{} holds {} photometries or spectra", path.display(), all.len()),
            "read them with read_all",
        ));
    }
    Ok(all.remove(0))
}

/// All distributions and spectra of a file: a container, or a model with several.
#[pyfunction]
#[pyo3(signature = (path, *, columns=None, isym3_c90_first=false, apply_future_use=false))]
pub(crate) fn read_all(
    py: Python<'_>,
    path: std::path::PathBuf,
    columns: Option<[usize; 2]>,
    isym3_c90_first: bool,
    apply_future_use: bool,
) -> PyResult<Vec<Py<PyAny>>> {
    let options = ReadOptions {
        columns,
        isym3_c90_first,
        apply_future_use,
    };
    if columns.is_some_and(|[wavelength, value]| wavelength == 0 || value == 0 || wavelength == value) {
        return Err(bad_input(
            py,
            format!("columns = {columns:?} are no two columns"),
            "count them from 1, such as (1, 2)",
        ));
    }
    let path: Utf8PathBuf = utf8(py, path)?;
    let inspections = py.detach(|| inspect::file(&path, options));
    inspections
        .into_iter()
        .map(|inspection| object(py, inspection))
        .collect()
}

/// The class for what an inspection holds.
///
/// # Errors
/// `InputError` with every error that the reader found, where nothing could be read.
fn object(py: Python<'_>, inspection: Inspection) -> PyResult<Py<PyAny>> {
    match &inspection.content {
        Some(Content::Distribution(_)) => Ok(Py::new(py, Distribution::new(inspection))?.into_any()),
        Some(Content::Spectrum(_)) => Ok(Py::new(py, Spectrum::new(inspection))?.into_any()),
        None => {
            let errors = inspection
                .findings
                .iter()
                .filter(|finding| finding.severity == Severity::Error);
            let messages: Vec<String> = errors
                .map(|finding| match finding.line {
                    Some(line) => format!("{}:{line}: {}", inspection.file, finding.message),
                    // What says that a file cannot be opened names it.
                    None if finding.message.starts_with(&inspection.file) => finding.message.to_string(),
                    None => format!("{}: {}", inspection.file, finding.message),
                })
                .collect();
            let message = if messages.is_empty() {
                format!(
                    "{}: {} is no distribution and no spectrum",
                    inspection.file,
                    inspection.what()
                )
            } else {
                messages.join("\n")
            };
            Err(bad_input(py, message, "`isolux inspect --all` shows every finding"))
        }
    }
}
