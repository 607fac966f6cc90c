//! Documents of the program as dictionaries: the keys are those of its JSON files.

use pyo3::prelude::*;
use serde::Serialize;

/// `document` as Python objects: dictionaries, lists, strings, numbers, `None`.
pub(crate) fn to_python<'py>(py: Python<'py>, document: &impl Serialize) -> PyResult<Bound<'py, PyAny>> {
    Ok(pythonize::pythonize(py, document)?)
}
