//! What the statistics ask of a model: a prediction for any nuisance and any effects. Nothing else of it reaches them.

use nalgebra::DVector;

/// One effect with values: its linear amplitudes and its shape.
#[derive(Debug, Clone, PartialEq)]
pub struct Hypothesis {
    /// Number of the effect in [`Forward::effects`].
    pub effect: usize,
    /// Amplitudes in which the prediction is linear to first order: one, or two for an effect with a direction or phase.
    pub linear: Vec<f64>,
    /// Parameters that change the shape (time constant, width, period, …).
    pub shape: Vec<f64>,
}

/// A prior of one shape parameter, normal with the spread of a uniform one.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Spread {
    /// The middle; none where every value is as likely (an azimuth).
    pub middle: Option<f64>,
    /// The width of the plausible range.
    pub width: f64,
}

impl Spread {
    /// Uniform over a plausible range.
    pub fn over(low: f64, high: f64) -> Self {
        Self {
            middle: Some(0.5 * (low + high)),
            width: high - low,
        }
    }
}

/// How an effect can be searched for.
#[derive(Debug, Clone)]
pub struct Searchable {
    /// Its id.
    pub name: &'static str,
    /// A size of each linear amplitude at which a difference of predictions is measurable and nearly linear.
    pub step: Vec<f64>,
    /// Largest plausible size of each linear amplitude.
    pub plausible: Vec<f64>,
    /// The one linear amplitude is never below zero (an albedo, a squared radius); false where it has either sign.
    pub one_sided: bool,
    /// A negative amplitude cannot even be written down (a squared radius).
    pub never_negative: bool,
    /// Shapes worth trying; one empty shape where the effect has none.
    pub shapes: Vec<Vec<f64>>,
    /// Lowest and highest value of each shape parameter in a fit.
    pub bounds: Vec<(f64, f64)>,
    /// Where each shape parameter is believed to lie before any data.
    pub believed: Vec<Spread>,
    /// Difference at which the derivative to each shape parameter is taken.
    pub shape_step: Vec<f64>,
    /// Shape parameters that the data cannot change smoothly (a range's number): kept at their grid value.
    pub fixed: Vec<bool>,
}

/// A model of all rows, as the statistics see it.
pub trait Forward: Sync {
    /// Number of nuisance parameters; all zero is the model as it came.
    fn nuisances(&self) -> usize;
    /// The effects that could be missing, those already in the model left out.
    fn effects(&self) -> &[Searchable];
    /// The expected value of every row; none where these effects cannot act together.
    fn predict(&self, nuisance: &[f64], hypotheses: &[Hypothesis]) -> Option<DVector<f64>>;
}
