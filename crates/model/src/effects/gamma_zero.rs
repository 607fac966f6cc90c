//! The γ scale has its zero elsewhere: odd in signed γ.

use isolux_record::observation::ReadingCoordinates;

use super::act::{Act, Axes};
use super::spec::{BelongsTo, EffectSpec, READINGS, Split, amplitude};

/// Γ zero error (alignment).
pub(super) static GAMMA_ZERO: EffectSpec = EffectSpec {
    name: "gamma_zero",
    standard_name: "γ zero error (alignment)",
    sentence: "The γ scale has its zero [{offset_deg:size} ]beside the optical axis.",
    belongs_to: &[BelongsTo::Bench],
    stages: READINGS,
    formula: "γ + δ",
    source: "EN 13032-1, alignment of the goniometer axes",
    parameters: &[
        amplitude("offset_deg", "°", (-0.5, 0.5), 0.1, READINGS),
    ],
    amplitude_power: 1,
    shows_in: "gamma_deg",
    splits: &[Split { from: "backlash", by: "reverse_travel" }, Split { from: "gamma_sag", by: "rotate_c_180" }],
    acts: &[Act::Axes(turn)],
};

fn turn(values: &[f64], _: &ReadingCoordinates, axes: &mut Axes) {
    axes.gamma_deg += values[0];
}
