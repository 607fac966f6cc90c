//! What a fit leaves, which is to be noise.

use nalgebra::DVector;

use crate::basis::Basis;
use crate::table::Row;
use crate::whitening::Sequence;

/// What a fit leaves.
#[derive(Debug)]
pub struct Residuals<'a> {
    /// The rows.
    pub rows: &'a [Row],
    /// What the model expects of each.
    pub level: Vec<f64>,
    /// (measured − expected)/stated u.
    pub plain: DVector<f64>,
    /// The same, whitened with the correlation `rho` and without outlier weights, what was refitted projected out.
    pub whitened: DVector<f64>,
    /// What was refitted, whitened alike.
    pub refitted: Basis,
    /// Order in time.
    pub sequence: &'a Sequence,
    /// Correlation that counts as noise.
    pub rho: f64,
    /// Correlation that the residuals show.
    pub rho_found: f64,
    /// Its standard uncertainty; 0 where there is none.
    pub u_rho: f64,
    /// Fitted scatter in units of the stated uncertainties, and its degrees of freedom.
    pub scale: f64,
    /// Its degrees of freedom.
    pub freedom: f64,
    /// The noise in which the search counts its σ: the fitted scatter, or 1 where the stated uncertainties hold. What
    /// a place explains is compared with what a name explains, and counts in the same unit.
    pub unit: f64,
}
