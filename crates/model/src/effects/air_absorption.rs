//! Dust, steam or vapour takes light away over the path from the emitter to the receiver.

use super::act::{Act, Values};
use super::spec::{BelongsTo, EffectSpec, READINGS_AND_MAPS, amplitude};

pub(super) static SPEC: EffectSpec = EffectSpec {
    name: "air_absorption",
    standard_name: "absorption by air or vapour",
    sentence: "The air takes light away on its way[: {coefficient_per_m:%} for each metre].",
    belongs_to: &[BelongsTo::Path],
    stages: READINGS_AND_MAPS,
    formula: "e^(−k·r)",
    source: "Beer–Lambert",
    parameters: &[amplitude("coefficient_per_m", "1/m", (0.0, 0.05), 0.005)],
    shows_in: "distance_mm",
    look_alikes: &[("distance_offset", "second_distance"), ("sensor_axial", "distances")],
    acts: &[Act::Path(transmission)],
    ..EffectSpec::NEUTRAL
};

fn transmission(&[coefficient_per_m, ..]: &Values, path_mm: f64) -> f64 {
    (-coefficient_per_m * path_mm / 1000.0).exp()
}
