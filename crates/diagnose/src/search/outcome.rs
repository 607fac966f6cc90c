//! What a search found: members, their rivals, the noise and what is left.

use nalgebra::DVector;

use crate::fit::Fit;
use crate::forward::Hypothesis;
use crate::noise::NoiseTest;
use crate::reference::Errors;
use crate::rivals::Rival;
use crate::rounding::Rounding;
use crate::table::Coordinate;
use crate::whitening::Sequence;

/// The noise of these observations.
#[derive(Debug, Clone)]
pub struct Noise {
    /// Common factor on the stated uncertainties.
    pub scale: f64,
    /// The factor that the residuals show, fitted or not.
    pub observed: f64,
    /// Serial correlation of neighbours in time.
    pub rho: f64,
    /// Its standard uncertainty; 0 where there is none.
    pub u_rho: f64,
    /// What the variance of the residuals would be expected to be, in units of what it is, were the correlation lower
    /// or higher by `u_rho`.
    pub variance_at: [f64; 2],
    /// Outlier weights, one a row.
    pub weights: Vec<f64>,
}

/// Who could make what one member of the set makes.
#[derive(Debug, Clone)]
pub struct Rivalry {
    /// Names and patterns by falling probability; what is left to 1 belongs to "nothing".
    pub ranked: Vec<Ranked>,
    /// ln Bayes factor of the member against nothing.
    pub ln_bayes_factor: f64,
    /// Probability of the whole scan under noise alone, given the other members.
    pub p_value: f64,
}

/// One row of the ranked table.
#[derive(Debug, Clone)]
pub struct Ranked {
    /// Who.
    pub label: Label,
    /// Posterior probability.
    pub posterior: f64,
    /// ln(prior · Bayes factor) before the likelihood is blunted.
    pub ln_evidence: f64,
    /// Significance in σ.
    pub sigma: f64,
    /// The refined fit with it, where one was made.
    pub hypothesis: Option<Hypothesis>,
}

/// A name, or a place without one.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Label {
    /// Number of an effect.
    Named(usize),
    /// No name, along this coordinate.
    Unnamed(Coordinate),
}

/// Structure that no effect in the catalogue makes.
#[derive(Debug, Clone)]
pub struct Unexplained {
    /// The strongest pattern.
    pub rival: Rival,
    /// Its significance in σ.
    pub sigma: f64,
    /// Its fitted change of every row.
    pub pattern: DVector<f64>,
}

/// The strongest generic pattern along one coordinate.
#[derive(Debug, Clone)]
pub struct Place {
    /// Along what.
    pub coordinate: Coordinate,
    /// Where.
    pub range: [f64; 2],
    /// Significance in σ.
    pub sigma: f64,
    /// In words.
    pub note: String,
}

/// Everything that the search found.
#[derive(Debug)]
pub struct Outcome {
    /// The baseline: nuisance alone.
    pub baseline: Fit,
    /// Nuisance and the named effects.
    pub after: Fit,
    /// The noise.
    pub noise: Noise,
    /// Rows that were rounded alike.
    pub rounding: Rounding,
    /// What the noise of the model's own distribution does to the rows.
    pub errors: Errors,
    /// Order of the rows.
    pub sequence: Sequence,
    /// Probability of the first scan under noise alone.
    pub p_global: f64,
    /// One entry for each hypothesis of `after`.
    pub rivalries: Vec<Rivalry>,
    /// What is left without a name.
    pub unexplained: Option<Unexplained>,
    /// Where the baseline disagrees, strongest first.
    pub places: Vec<Place>,
    /// Significance (σ) of every effect at its plausible maximum: what the data could show (effect, component, σ).
    pub visibility: Vec<(usize, usize, f64)>,
    /// Whether what is left is noise; none where there is too little of it.
    pub noise_test: Option<NoiseTest>,
    /// 1/σ² of every refitted term in the two fits.
    pub held: Vec<f64>,
    /// Number of simulated scans.
    pub nulls: usize,
}
