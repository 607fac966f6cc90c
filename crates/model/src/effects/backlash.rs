//! The γ axis stands elsewhere, depending on where it came from. Where the direction is not known nothing is applied.

use isolux_record::observation::ReadingCoordinates;

use super::act::{Act, Axes};
use super::spec::{BelongsTo, EffectSpec, READINGS, Split, amplitude};

/// Backlash (hysteresis).
pub(super) static BACKLASH: EffectSpec = EffectSpec {
    name: "backlash",
    standard_name: "backlash (hysteresis)",
    sentence: "The γ axis has play: where it stands depends on the side that it came from[, by {width_deg:size}].",
    belongs_to: &[BelongsTo::Bench],
    stages: READINGS,
    formula: "γ + b/2 · direction of travel",
    source: "dead travel of a gear",
    parameters: &[
        amplitude("width_deg", "°", (-0.3, 0.3), 0.1, READINGS),
    ],
    amplitude_power: 1,
    shows_in: "travel",
    splits: &[Split { from: "gamma_zero", by: "reverse_travel" }],
    acts: &[Act::Axes(lag)],
};

fn lag(values: &[f64], at: &ReadingCoordinates, axes: &mut Axes) {
    axes.gamma_deg += 0.5 * values[0] * f64::from(at.travel);
}
