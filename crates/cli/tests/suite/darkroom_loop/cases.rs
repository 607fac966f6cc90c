//! What is wrong with each room, and what an honest diagnosis may say of it.

/// One injected effect of a room.
pub struct Case {
    /// The effect's name in `darkroom.toml` and in model files.
    pub name: &'static str,
    /// Its keys.
    pub keys: &'static [(&'static str, f64)],
    /// Other names that these data cannot tell from it; empty where it must stand alone.
    pub twins: &'static [&'static str],
}

const fn case(name: &'static str, keys: &'static [(&'static str, f64)], twins: &'static [&'static str]) -> Case {
    Case { name, keys, twins }
}

/// Injected effects of bench, path and lamp, seen by the lux meter.
pub const READINGS: &[Case] = &[
    case("gamma_zero", &[("offset_deg", 0.1)], &[]),
    case("c_zero", &[("offset_deg", 3.0)], &[]),
    case("luminaire_tilt", &[("angle_deg", 0.15), ("azimuth_deg", 60.0)], &[]),
    // The LEDs are parallel: a dimmed sector moves the light centre and does nothing else.
    case(
        "lateral_centre",
        &[("offset_mm", 2.0), ("azimuth_deg", 30.0)],
        &["dead_sector"],
    ),
    case("axial_centre", &[("offset_mm", 3.0)], &[]),
    case("distance_offset", &[("offset_mm", 5.0)], &[]),
    case("dark_offset", &[("offset_lx", 0.3)], &[]),
    case("ambient_stray", &[("illuminance_lx", 0.3)], &[]),
    case("floor_reflection", &[("albedo", 0.2), ("height_mm", 1000.0)], &[]),
    case("range_step", &[("factor_rel", 0.008), ("range", 2.0)], &[]),
    case("nonlinearity", &[("inverse_scale_per_lx", 1e-5)], &[]),
    case("backlash", &[("width_deg", 0.1)], &[]),
    case("gamma_sag", &[("amplitude_deg", 0.2)], &["gamma_zero"]),
    case("polarization", &[("amplitude_rel", 0.004), ("azimuth_deg", 25.0)], &[]),
    case(
        "lamp_drift",
        &[("rate_per_h", -0.015)],
        &["lamp_warmup", "temp_coefficient"],
    ),
    case("air_absorption", &[("coefficient_per_m", 0.01)], &[]),
];

/// Injected effects of camera and lamp, seen by the camera.
pub const CAMERA: &[Case] = &[
    case("sensor_tilt", &[("angle_deg", 1.0), ("azimuth_deg", 50.0)], &[]),
    case("sensor_axial", &[("offset_mm", 2.0)], &[]),
    case("source_tilt", &[("angle_deg", 1.0), ("azimuth_deg", 120.0)], &[]),
    case("stage_lateral", &[("offset_mm", 2.0), ("azimuth_deg", 30.0)], &[]),
    case("vignetting", &[("coefficient_rel", 0.03)], &[]),
    case("cover_glass", &[("plates", 1.0)], &["pixel_angular"]),
    case("pixel_angular", &[("coefficient", 0.2)], &["cover_glass"]),
    case(
        "flicker_banding",
        &[("amplitude_rel", 0.01), ("period_mm", 9.0), ("phase_rad", 0.7)],
        &[],
    ),
    case("prnu_gradient", &[("gradient_rel", 0.01), ("azimuth_deg", 50.0)], &[]),
    case(
        "ghost",
        &[
            ("amplitude_rel", 0.01),
            ("x_mm", 3.0),
            ("y_mm", -2.0),
            ("width_mm", 5.0),
        ],
        &[],
    ),
    case("exposure_offset", &[("offset", 0.01)], &[]),
    case("dark_offset", &[("offset_rel", 0.004)], &[]),
    case("ambient_light", &[("illuminance_lx", 5.0)], &[]),
];

/// The case of that name.
pub fn find(cases: &'static [Case], name: &str) -> &'static Case {
    cases
        .iter()
        .find(|case| case.name == name)
        .expect("a case of that name")
}
