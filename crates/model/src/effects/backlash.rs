//! The γ axis stands elsewhere, depending on where it came from. Where the direction is not known nothing is applied.

use isolux_record::observation::ReadingCoordinates;

use super::act::{Act, Axes, Values};
use super::spec::{BelongsTo, EffectSpec, READINGS, amplitude};

pub(super) static SPEC: EffectSpec = EffectSpec {
    name: "backlash",
    standard_name: "backlash (hysteresis)",
    sentence: "The γ axis has play: where it stands depends on the side that it came from[, by {width_deg:size}].",
    belongs_to: &[BelongsTo::Bench],
    stages: READINGS,
    formula: "γ + b/2 · direction of travel",
    source: "dead travel of a gear",
    parameters: &[amplitude("width_deg", "°", (-0.3, 0.3), 0.1)],
    shows_in: "travel",
    look_alikes: &[("gamma_zero", "reverse_travel")],
    acts: &[Act::Axes(lag)],
    ..EffectSpec::NEUTRAL
};

fn lag(&[width_deg, ..]: &Values, at: &ReadingCoordinates, axes: &mut Axes) {
    axes.gamma_deg += 0.5 * width_deg * f64::from(at.travel);
}
