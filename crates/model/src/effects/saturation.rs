//! The well is full: the signal grows no further.

use super::act::Act;
use super::spec::{BelongsTo, EffectSpec, MAPS, ParameterSpec, Split, amplitude};

/// Saturation (full well).
pub(super) static SATURATION: EffectSpec = EffectSpec {
    name: "saturation",
    standard_name: "saturation (full well)",
    sentence: "The sensor is full: the signal grows no further[ above {level_rel:%} of full scale].",
    belongs_to: &[BelongsTo::Sensor],
    stages: MAPS,
    formula: "min(S, S_sat); level 0 means none",
    source: "EMVA 1288, saturation",
    parameters: &[
        ParameterSpec { step: 0.9, ..amplitude("level_rel", "1", (0.5, 1.5), 0.9, MAPS) },
    ],
    amplitude_power: 1,
    shows_in: "level",
    splits: &[Split { from: "nonlinearity", by: "exposures" }],
    acts: &[Act::Readout(clip)],
};

fn clip(values: &[f64], signal: f64) -> f64 {
    if values[0] > 0.0 { signal.min(values[0]) } else { signal }
}
