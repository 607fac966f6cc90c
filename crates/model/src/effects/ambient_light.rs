//! Hall light that falls evenly on a sensor, lamp on or off; a cap keeps it out.

use super::act::Act;
use super::spec::{BelongsTo, EffectSpec, MAPS, ParameterSpec, Role, Split, amplitude};

/// Uniform ambient light on the sensor.
pub(super) static AMBIENT_LIGHT: EffectSpec = EffectSpec {
    name: "ambient_light",
    standard_name: "uniform ambient light on the sensor",
    sentence: "Light that is not the lamp's falls evenly on the sensor[: {illuminance_lx}][: {irradiance_w_m2}].",
    belongs_to: &[BelongsTo::Sensor],
    stages: MAPS,
    formula: "E + E_a on every map that is not capped, lamp on or off",
    source: "EMVA 1288, dark signal and background",
    parameters: &[
        amplitude("illuminance_lx", "lx", (0.0, 20.0), 1.0, MAPS),
        ParameterSpec { role: Role::Alternative, ..amplitude("irradiance_w_m2", "W/m²", (0.0, 0.1), 0.01, MAPS) },
    ],
    amplitude_power: 1,
    shows_in: "level",
    splits: &[Split { from: "dark_offset", by: "dark_maps" }],
    acts: &[Act::Background(light)],
};

fn light(values: &[f64]) -> (f64, f64) {
    (values[0], values[1])
}
