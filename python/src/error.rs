//! Failures of use cases as Python exceptions, with what happened and what to do.

use isolux_app::{Failure, FailureKind};
use pyo3::exceptions::{PyBrokenPipeError, PyKeyboardInterrupt};
use pyo3::prelude::*;

/// The exception of `failure`; the classes stand in `package/isolux/_errors.py`.
pub(crate) fn raised(py: Python<'_>, failure: Failure) -> PyErr {
    let class = match failure.kind {
        FailureKind::No => "CheckFailed",
        FailureKind::BadInput => "InputError",
        FailureKind::Instrument => "InstrumentError",
        FailureKind::Interrupted => return PyKeyboardInterrupt::new_err(failure.message),
        FailureKind::Closed => return PyBrokenPipeError::new_err(failure.message),
    };
    of_class(py, class, failure)
}

/// `failure` as an exception of the class of this name in `_errors.py`.
pub(crate) fn of_class(py: Python<'_>, class: &str, failure: Failure) -> PyErr {
    let made = py
        .import("isolux._errors")
        .and_then(|errors| errors.getattr(class))
        .and_then(|class| class.call1((failure.message, failure.help)));
    match made {
        Ok(exception) => PyErr::from_value(exception),
        Err(error) => error,
    }
}

/// Bad input that was found before a use case began.
pub(crate) fn bad_input(py: Python<'_>, message: impl std::fmt::Display, help: &str) -> PyErr {
    raised(py, Failure::bad_input(message).help(help))
}
