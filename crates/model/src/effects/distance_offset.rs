//! The detector's reference plane is farther from the axes than the scale says.

use isolux_record::observation::ReadingCoordinates;

use super::act::{Act, Axes, Values};
use super::spec::{BelongsTo, EffectSpec, READINGS, amplitude};

pub(super) static SPEC: EffectSpec = EffectSpec {
    name: "distance_offset",
    standard_name: "photometric distance error",
    sentence: "The detector is not where its scale says[: it is {offset_mm:size} {offset_mm:farther away|nearer}].",
    belongs_to: &[BelongsTo::Bench],
    stages: READINGS,
    formula: "d + δ",
    source: "EN 13032-1, photometric distance",
    parameters: &[amplitude("offset_mm", "mm", (-20.0, 20.0), 2.0)],
    shows_in: "distance_mm",
    look_alikes: &[
        ("air_absorption", "second_distance"),
        ("axial_centre", "second_distance"),
    ],
    acts: &[Act::Axes(longer)],
    ..EffectSpec::NEUTRAL
};

fn longer(&[offset_mm, ..]: &Values, _: &ReadingCoordinates, axes: &mut Axes) {
    axes.distance_mm += offset_mm;
}
