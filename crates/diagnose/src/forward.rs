//! What the statistics ask of a model: a prediction for any nuisance and any effects. Nothing else of it reaches them.

use nalgebra::DVector;

use crate::calibration::LN_SMALL;
use crate::known::Known;
use crate::reference::Errors;

/// One effect with values: its linear amplitudes and its shape.
#[derive(Debug, Clone, PartialEq)]
pub struct Hypothesis {
    /// Number of the effect in [`Forward::effects`].
    pub effect: usize,
    /// Amplitudes in which the prediction is linear to first order: one, or two for an effect with a direction or
    /// phase.
    pub linear: Vec<f64>,
    /// Parameters that change the shape (time constant, width, period, …).
    pub shape: Vec<f64>,
}

/// What is assumed of one shape parameter: any value of a range alike.
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

    /// Standard deviation of the normal law that has the density of the uniform one.
    pub fn sigma(&self) -> f64 {
        self.width / std::f64::consts::TAU.sqrt()
    }

    /// How far a value lies outside of the range, signed, in [`sigma`](Self::sigma): belief falls like a normal law
    /// there.
    pub fn beyond(&self, value: f64) -> f64 {
        self.middle.map_or(0.0, |middle| {
            let outside = ((value - middle).abs() - 0.5 * self.width).max(0.0);
            outside.copysign(value - middle) / self.sigma()
        })
    }
}

/// How an effect can be searched for.
#[derive(Debug, Clone)]
pub struct Searchable {
    /// Its id.
    pub name: &'static str,
    /// A size of each linear amplitude at which a difference of predictions is measurable and nearly linear.
    pub step: Vec<f64>,
    /// Share of `step` at which the pattern of each shape is taken; 1 where the list ends. An effect whose first order
    /// vanishes for one shape and not for another has its small sizes listed apart: they look otherwise.
    pub step_share: Vec<f64>,
    /// Largest plausible size of each linear amplitude.
    pub plausible: Vec<f64>,
    /// Smallest plausible size of the first linear amplitude; 0 where there is none.
    pub least: f64,
    /// Lowest and highest possible value of each linear amplitude: no floor returns more light than it gets.
    pub limits: Vec<(f64, f64)>,
    /// The linear amplitudes are two components of one amplitude: a direction or a phase.
    pub turns: bool,
    /// The response does not grow with the amplitude (a level, a step): each shape stands for one value of it.
    pub one_by_one: bool,
    /// The first linear amplitude is the period of what the effect does along the signal, in full scales.
    pub period_of_signal: bool,
    /// How many values those of `shapes` were chosen from by the data ([`crate::steps`]); 0: all are listed.
    pub chosen_from: usize,
    /// The one linear amplitude is never below zero (an albedo, a squared radius); false where it has either sign.
    pub one_sided: bool,
    /// A negative amplitude cannot even be written down (a squared radius).
    pub never_negative: bool,
    /// Shapes worth trying; one empty shape where the effect has none.
    pub shapes: Vec<Vec<f64>>,
    /// Lowest and highest value of each shape parameter in a fit.
    pub bounds: Vec<(f64, f64)>,
    /// Where each shape parameter is assumed to lie before any data.
    pub assumed: Vec<Spread>,
    /// Difference at which the derivative to each shape parameter is taken.
    pub shape_step: Vec<f64>,
    /// Where the one shape is the frequency (in 1/s) of an oscillation 1 + p sin 2πft + q cos 2πft of all light: the
    /// time of every row in s, NaN where it has none. All frequencies follow from one prediction then.
    pub oscillates: Option<Vec<f64>>,
    /// Shape parameters that the data cannot change smoothly (a range's number): kept at their grid value.
    pub fixed: Vec<bool>,
}

impl Searchable {
    /// ln of what a first amplitude smaller than plausible costs.
    pub fn ln_small(&self, first: f64) -> f64 {
        if self.least > 0.0 && first < self.least {
            LN_SMALL * ((first.max(0.0) / self.least).sqrt() - 1.0)
        } else {
            0.0
        }
    }

    /// The difference at which the pattern of a shape is taken.
    pub fn step_of(&self, shape: usize, component: usize) -> f64 {
        self.step[component] * self.step_share.get(shape).copied().unwrap_or(1.0)
    }

    /// How many shapes the one that fits best was taken from.
    pub fn ways(&self) -> f64 {
        self.chosen_from.max(self.shapes.len()) as f64
    }

    /// The difference at which the derivative to a linear amplitude is taken in a fit: of one that cannot be negative
    /// no more than a tenth of it, for its change may go with the root; of a period all of it, for what another one
    /// does is no small change.
    pub fn step_at(&self, component: usize, value: f64) -> f64 {
        let step = 0.1 * self.step[component];
        if self.period_of_signal && value > 0.0 {
            -value
        } else if self.one_by_one {
            1e-3 * value.abs().max(step)
        } else if self.never_negative {
            step.min(0.1 * value).max(1e-4 * self.step[component])
        } else {
            step
        }
    }

    /// How far these amplitudes lie beyond what is plausible, squared, in plausible amplitudes: what was assumed of
    /// them before any data falls like a normal law there.
    pub fn implausibility(&self, linear: &[f64]) -> f64 {
        self.beyond(linear).iter().map(|(share, _)| share * share).sum()
    }

    /// Of each independent amplitude: share beyond the plausible one, and the derivative of that share to every
    /// component.
    pub fn beyond(&self, linear: &[f64]) -> Vec<(f64, Vec<f64>)> {
        let share = |size: f64, plausible: f64| (size / plausible - 1.0).max(0.0);
        if self.turns {
            let size = linear[0].hypot(linear[1]);
            let slope = linear
                .iter()
                .map(|value| value / size.max(f64::MIN_POSITIVE) / self.plausible[0]);
            return vec![(share(size, self.plausible[0]), slope.collect())];
        }
        linear
            .iter()
            .zip(&self.plausible)
            .enumerate()
            .map(|(k, (value, plausible))| {
                let mut slope = vec![0.0; linear.len()];
                slope[k] = value.signum() / plausible;
                (share(value.abs(), *plausible), slope)
            })
            .collect()
    }
}

/// A model of all rows, as the statistics see it.
pub trait Forward: Sync {
    /// Number of nuisance parameters; all zero is the model as it came.
    fn nuisances(&self) -> usize;
    /// 1/σ² of what is assumed of each nuisance parameter before any data; 0 where nothing is.
    fn nuisance_weights(&self) -> Vec<f64> {
        vec![0.0; self.nuisances()]
    }
    /// The order of each nuisance parameter among the terms of the distribution's shape, the level being 0; none where
    /// it is no such term.
    fn shape_terms(&self) -> Vec<Option<usize>> {
        vec![None; self.nuisances()]
    }
    /// Errors that rows share because the model was made from a measurement itself, one list of rows and standard
    /// deviations each.
    fn common_errors(&self) -> Errors {
        Errors::new()
    }
    /// What the model knows with a stated uncertainty: errors that many rows share, one standard uncertainty each.
    fn known(&self) -> Vec<Known> {
        Vec::new()
    }
    /// The effects that could be missing, those already in the model left out.
    fn effects(&self) -> &[Searchable];
    /// The full scale of every row, in its unit, NaN where it is no signal of a sensor; none where no row is.
    fn full_scale(&self) -> Option<DVector<f64>> {
        None
    }
    /// What an effect that is the last step of every reading makes of an expected value of every row; none where it is
    /// not.
    fn read_out(&self, _effect: usize, _amplitude: f64, _prediction: &DVector<f64>) -> Option<DVector<f64>> {
        None
    }
    /// The expected value of every row; none where these effects cannot act together.
    fn predict(&self, nuisance: &[f64], hypotheses: &[Hypothesis]) -> Option<DVector<f64>>;
}
