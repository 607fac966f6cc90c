//! Room light that falls evenly on a sensor, lamp on or off; a cap keeps it out.

use super::act::{Act, Values};
use super::spec::{BelongsTo, EffectSpec, MAPS, amplitude};

pub(super) static SPEC: EffectSpec = EffectSpec {
    name: "ambient_light",
    standard_name: "uniform ambient light on the sensor",
    sentence: "Light that is not the lamp's falls evenly on the sensor[: {illuminance_lx}][: {irradiance_w_m2}].",
    belongs_to: &[BelongsTo::Sensor],
    stages: MAPS,
    formula: "E + E_a on every map that is not capped, lamp on or off",
    source: "EMVA 1288, dark signal and background",
    parameters: &[
        amplitude("illuminance_lx", "lx", (0.0, 20.0), 1.0),
        amplitude("irradiance_w_m2", "W/m²", (0.0, 0.1), 0.01).alternative(),
    ],
    shows_in: "level",
    look_alikes: &[("dark_offset", "dark_maps")],
    acts: &[Act::Background(light)],
    ..EffectSpec::NEUTRAL
};

fn light(&[illuminance_lx, irradiance_w_m2, ..]: &Values) -> (f64, f64) {
    (illuminance_lx, irradiance_w_m2)
}
