//! The shutter is open longer than it says, by the same time for every exposure.

use super::act::{Act, Values};
use super::spec::{BelongsTo, EffectSpec, MAPS, amplitude};

pub(super) static SPEC: EffectSpec = EffectSpec {
    name: "exposure_offset",
    standard_name: "exposure time error",
    sentence: "The shutter is not open for the time that it says, by the same difference for every exposure[: {offset:size} \
        too {offset:long|short}].",
    belongs_to: &[BelongsTo::Sensor],
    stages: MAPS,
    formula: "(t + δt)",
    source: "EMVA 1288, exposure",
    parameters: &[amplitude("offset", "unit of exposure", (-0.01, 0.01), 0.001)],
    shows_in: "exposure",
    look_alikes: &[
        ("near_field", "distances"),
        ("nonlinearity", "exposures"),
        ("sensor_axial", "distances"),
    ],
    acts: &[Act::Exposure(longer)],
    ..EffectSpec::NEUTRAL
};

fn longer(&[offset, ..]: &Values, exposure: f64) -> f64 {
    exposure + offset
}
