//! What an object holds, written to a file.

use std::path::PathBuf;

use isolux_app::files::Overwrite;
use isolux_app::formats::convert::{self, Options};
use isolux_app::formats::inspect::Inspection;
use pyo3::prelude::*;

use crate::document::to_python;
use crate::error::{bad_input, raised};
use crate::path::utf8;

/// Writes the content of `inspection` to a file of the format of its extension; what was lost or assumed.
///
/// # Errors
/// `InputError` for a file that exists without `force`, and a format that cannot hold the content.
pub(crate) fn write<'py>(
    py: Python<'py>,
    inspection: &Inspection,
    path: PathBuf,
    requested: &Options,
    force: bool,
) -> PyResult<Bound<'py, PyAny>> {
    let target = utf8(py, path)?;
    let Some(content) = &inspection.content else {
        let message = format!("{}: nothing was read that could be written", inspection.file);
        return Err(bad_input(py, message, "read the file again"));
    };
    let findings = convert::write(content, &target, requested, Overwrite::requested(force));
    to_python(py, &findings.map_err(|failure| raised(py, failure))?)
}
