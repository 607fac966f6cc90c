//! The light of a scan that goes on, with what is not known of it yet.

use isolux_photometry::IntensityDistribution;

/// The light of a scan that goes on, in all directions of its plan.
pub(crate) struct LightSoFar {
    /// As it is known best.
    pub best: IntensityDistribution,
    /// As it may be by what was not measured; none where nothing says that.
    pub other: Option<IntensityDistribution>,
    /// What the difference of both is divided by for a standard uncertainty.
    pub divisor: f64,
    /// Scatter and rounding of the strongest direction, relative.
    pub u_reading_rel: f64,
    /// Half-planes that were read, and those of the plan.
    pub half_planes: [usize; 2],
}
