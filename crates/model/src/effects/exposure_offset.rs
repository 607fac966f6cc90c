//! The shutter is open longer than it says, by the same time for every exposure.

use super::act::Act;
use super::spec::{BelongsTo, EffectSpec, MAPS, Split, amplitude};

/// Exposure time error.
pub(super) static EXPOSURE_OFFSET: EffectSpec = EffectSpec {
    name: "exposure_offset",
    standard_name: "exposure time error",
    sentence: "The shutter is not open for the time that it says, by the same difference for every exposure[: {offset:size} too {offset:long|short}].",
    belongs_to: &[BelongsTo::Sensor],
    stages: MAPS,
    formula: "(t + δt)",
    source: "EMVA 1288, exposure",
    parameters: &[
        amplitude("offset", "unit of exposure", (-0.01, 0.01), 0.001, MAPS),
    ],
    amplitude_power: 1,
    shows_in: "exposure",
    splits: &[Split { from: "near_field", by: "distances" }, Split { from: "nonlinearity", by: "exposures" }, Split { from: "sensor_axial", by: "distances" }],
    acts: &[Act::Exposure(longer)],
};

fn longer(values: &[f64], exposure: f64) -> f64 {
    exposure + values[0]
}
