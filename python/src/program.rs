//! The program of the command line, inside the package.

use std::ffi::OsString;

use pyo3::prelude::*;

/// Runs the program `isolux` with `words`, its own name first, and returns its exit code.
#[pyfunction]
pub(crate) fn run_program(py: Python<'_>, words: Vec<OsString>) -> u8 {
    py.detach(|| isolux::run(words))
}
