//! Dust, steam or vapour takes light away over the path from the emitter to the receiver.

use super::act::Act;
use super::spec::{BelongsTo, EffectSpec, READINGS_AND_MAPS, Split, amplitude};

/// Absorption by air or vapour.
pub(super) static AIR_ABSORPTION: EffectSpec = EffectSpec {
    name: "air_absorption",
    standard_name: "absorption by air or vapour",
    sentence: "The air takes light away on its way[: {coefficient_per_m:%} for each metre].",
    belongs_to: &[BelongsTo::Path],
    stages: READINGS_AND_MAPS,
    formula: "e^(−k·r)",
    source: "Beer–Lambert",
    parameters: &[
        amplitude("coefficient_per_m", "1/m", (0.0, 0.05), 0.005, READINGS_AND_MAPS),
    ],
    amplitude_power: 1,
    shows_in: "distance_mm",
    splits: &[Split { from: "distance_offset", by: "second_distance" }, Split { from: "sensor_axial", by: "distances" }],
    acts: &[Act::Path(transmission)],
};

fn transmission(values: &[f64], path_mm: f64) -> f64 {
    (-values[0] * path_mm / 1000.0).exp()
}
