//! What every test of the residuals can do.

use super::finding::{Finding, Strongest};
use super::series::Series;

/// One test of the residuals.
pub(super) trait Test: Sync {
    /// The strongest place in values of unit variance.
    fn strongest(&self, values: &[f64]) -> Strongest;

    /// The strongest place of the observed values that would matter.
    fn observed(&self, values: &[f64]) -> Strongest {
        self.strongest(values)
    }

    /// Its share of the false alarms; 1 for what benches often do.
    fn share(&self) -> f64 {
        1.0
    }

    /// What that place is.
    fn finding(&self, strongest: Strongest, series: &Series<'_>) -> Finding;
}
