//! First stage: the model without effects, and the noise that it leaves.

use crate::fit::Fit;
use crate::forward::Forward;

use super::estimate::Estimate;
use super::problem::Problem;

/// The model without effects.
pub(super) struct Baseline<'p, 'a, F: Forward + ?Sized> {
    pub(super) estimate: Estimate<'p, 'a, F>,
    pub(super) fit: Fit,
}

pub(super) fn baseline<'p, 'a, F: Forward + ?Sized>(problem: &'p Problem<'a, F>) -> Option<Baseline<'p, 'a, F>> {
    let (estimate, fit) = Estimate::baseline(problem)?;
    Some(Baseline { estimate, fit })
}
