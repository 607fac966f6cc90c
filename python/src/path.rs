//! Paths from Python.

use std::path::PathBuf;

use camino::Utf8PathBuf;
use pyo3::prelude::*;

use crate::error::bad_input;

/// `path` as the program takes paths.
///
/// # Errors
/// `InputError` for a path that is not UTF-8.
pub(crate) fn utf8(py: Python<'_>, path: PathBuf) -> PyResult<Utf8PathBuf> {
    Utf8PathBuf::from_path_buf(path).map_err(|path| {
        bad_input(
            py,
            format!("{} is not UTF-8", path.display()),
            "give the file another name",
        )
    })
}
