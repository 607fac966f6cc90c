//! A number with its uncertainty.

use isolux_app::run::reduce;
use pyo3::prelude::*;

/// A number with its unit and standard uncertainty; `float` gives the number.
#[pyclass(frozen, module = "isolux")]
pub(crate) struct Quantity(pub(crate) reduce::Quantity);

#[pymethods]
impl Quantity {
    /// The number, in `unit`.
    #[getter]
    fn value(&self) -> f64 {
        self.0.value
    }

    /// Its unit.
    #[getter]
    fn unit(&self) -> &str {
        &self.0.unit
    }

    /// Standard uncertainty (k = 1); None where `missing` says what is not known.
    #[getter]
    fn u(&self) -> Option<f64> {
        self.0.u
    }

    /// The known parts of the uncertainty by name; they add in squares.
    #[getter]
    fn parts(&self) -> std::collections::BTreeMap<String, f64> {
        self.0
            .parts
            .iter()
            .map(|(name, part)| (name.to_string(), *part))
            .collect()
    }

    /// What was neither measured nor stated, one phrase each.
    #[getter]
    fn missing(&self) -> Vec<String> {
        self.0.missing.clone()
    }

    fn __float__(&self) -> f64 {
        self.0.value
    }

    fn __str__(&self) -> String {
        self.0.stated()
    }

    fn __repr__(&self) -> String {
        format!("<isolux.Quantity {}>", self.0.stated())
    }
}
