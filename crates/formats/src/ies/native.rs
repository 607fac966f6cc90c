//! A table of type A or B in its own angles.

use isolux_photometry::Symmetry;

/// Measured planes in the file's coordinates, candela `[ih * nv + iv]`.
#[derive(Debug)]
pub(super) struct Native<'a> {
    pub type_a: bool,
    pub vertical_deg: &'a [f64],
    pub horizontal_deg: &'a [f64],
    pub candela: &'a [f64],
}

impl Native<'_> {
    /// The symmetry that angles which begin at 0 imply.
    pub(super) fn symmetry(&self) -> Symmetry {
        match (folds(self.horizontal_deg), folds(self.vertical_deg)) {
            (true, true) => Symmetry::Quadrant,
            (true, false) => Symmetry::C90C270,
            (false, true) => Symmetry::C0C180,
            (false, false) => Symmetry::None,
        }
    }

    /// The smallest distance between two angles of a direction; none where there is one angle alone.
    pub(super) fn smallest_step(&self) -> Option<f64> {
        let steps = |angles: &[f64]| {
            let apart = angles.windows(2).map(|pair| pair[1] - pair[0]);
            apart.fold(f64::INFINITY, f64::min)
        };
        let step = steps(self.vertical_deg).min(steps(self.horizontal_deg));
        (step.is_finite() && step > 0.0).then_some(step)
    }

    /// The farthest from 0 that any angle is.
    pub(super) fn reach_deg(&self) -> f64 {
        let all = self.vertical_deg.iter().chain(self.horizontal_deg);
        all.fold(0.0_f64, |most, angle| most.max(angle.abs()))
    }
}

/// Whether angles that begin at 0 stand for those below 0 as well.
pub(super) fn folds(angles: &[f64]) -> bool {
    angles.first().is_some_and(|&first| first >= 0.0)
}
