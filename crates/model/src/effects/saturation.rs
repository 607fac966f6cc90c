//! The well is full: the signal grows no further.

use super::act::{Act, Values};
use super::spec::{BelongsTo, EffectSpec, MAPS, amplitude};

pub(super) static SPEC: EffectSpec = EffectSpec {
    name: "saturation",
    standard_name: "saturation (full well)",
    sentence: "The sensor is full: the signal grows no further[ above {level_rel:%} of full scale].",
    belongs_to: &[BelongsTo::Sensor],
    stages: MAPS,
    formula: "min(S, S_sat); level 0 means none",
    source: "EMVA 1288, saturation",
    parameters: &[amplitude("level_rel", "1", (0.5, 1.5), 0.9)],
    shows_in: "level",
    look_alikes: &[("nonlinearity", "exposures")],
    tried: Some(levels),
    acts: &[Act::Readout(clip)],
    ..EffectSpec::NEUTRAL
};

/// From just below the largest signal down to a quarter of it, 3 % apart.
fn levels(largest: f64) -> Vec<f64> {
    (0..46).map(|k| 0.995 * largest * 0.97_f64.powi(k)).collect()
}

fn clip(&[level_rel, ..]: &Values, signal: f64) -> f64 {
    if level_rel > 0.0 { signal.min(level_rel) } else { signal }
}
