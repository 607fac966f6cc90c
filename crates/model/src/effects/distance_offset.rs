//! The detector's reference plane is farther from the axes than the scale says.

use isolux_record::observation::ReadingCoordinates;

use super::act::{Act, Axes};
use super::spec::{BelongsTo, EffectSpec, READINGS, Split, amplitude};

/// Photometric distance error.
pub(super) static DISTANCE_OFFSET: EffectSpec = EffectSpec {
    name: "distance_offset",
    standard_name: "photometric distance error",
    sentence: "The detector is not where its scale says[: it is {offset_mm:size} {offset_mm:farther away|nearer}].",
    belongs_to: &[BelongsTo::Bench],
    stages: READINGS,
    formula: "d + δ",
    source: "EN 13032-1, photometric distance",
    parameters: &[
        amplitude("offset_mm", "mm", (-20.0, 20.0), 2.0, READINGS),
    ],
    amplitude_power: 1,
    shows_in: "distance_mm",
    splits: &[Split { from: "air_absorption", by: "second_distance" }, Split { from: "axial_centre", by: "second_distance" }],
    acts: &[Act::Axes(longer)],
};

fn longer(values: &[f64], _: &ReadingCoordinates, axes: &mut Axes) {
    axes.distance_mm += values[0];
}
