//! What can be hidden: every effect of the darkroom that its readings or maps can show, with keys, ranges and draws.

use crate::random::Draws;

/// How one effect of the darkroom is hidden.
#[derive(Debug, Clone, Copy)]
pub struct Recipe {
    /// Its name, in the words of the darkroom's document.
    pub name: &'static str,
    /// The key whose value sets its strength.
    pub key: &'static str,
    /// Largest plausible strength.
    pub plausible: f64,
    /// It can have either sign.
    pub signed: bool,
    /// Whether some other key is drawn, and how.
    pub extra: &'static [(&'static str, Extra)],
}

/// How another key is drawn.
#[derive(Debug, Clone, Copy)]
pub enum Extra {
    /// Uniform.
    Between(f64, f64),
    /// Log-uniform.
    Decades(f64, f64),
    /// One of these.
    OneOf(&'static [f64]),
}

impl Recipe {
    /// Draws the other keys and the sign.
    pub fn draw(&self, draws: &mut Draws) -> (f64, Vec<(&'static str, f64)>) {
        let sign = if self.signed { draws.sign() } else { 1.0 };
        let extra = self
            .extra
            .iter()
            .map(|&(key, how)| {
                let value = match how {
                    Extra::Between(low, high) => draws.between(low, high),
                    Extra::Decades(low, high) => draws.decades(low, high),
                    Extra::OneOf(list) => *draws.pick(list),
                };
                (key, value)
            })
            .collect();
        (sign, extra)
    }
}

use Extra::{Between, Decades, OneOf};

const AZIMUTH: (&str, Extra) = ("azimuth_deg", Between(0.0, 360.0));

const fn recipe(
    name: &'static str,
    key: &'static str,
    plausible: f64,
    signed: bool,
    extra: &'static [(&'static str, Extra)],
) -> Recipe {
    Recipe {
        name,
        key,
        plausible,
        signed,
        extra,
    }
}

/// Effects that goniometer readings can show.
pub const GONIO: &[Recipe] = &[
    recipe("ambient_stray", "illuminance_lx", 0.9, false, &[]),
    recipe("dark_offset", "offset_lx", 1.3, true, &[]),
    recipe(
        "floor_reflection",
        "albedo",
        0.9,
        false,
        &[("height_mm", Between(800.0, 1600.0))],
    ),
    recipe("distance_offset", "offset_mm", 20.0, true, &[]),
    recipe("axial_centre", "offset_mm", 30.0, true, &[]),
    recipe("lateral_centre", "offset_mm", 20.0, false, &[AZIMUTH]),
    recipe(
        "near_field",
        "radius_mm",
        60.0,
        false,
        &[("aim_deg", Between(0.0, 8.0))],
    ),
    recipe("gamma_zero", "offset_deg", 0.5, true, &[]),
    recipe("gamma_sag", "amplitude_deg", 0.3, true, &[]),
    recipe("c_zero", "offset_deg", 5.0, true, &[]),
    recipe("luminaire_tilt", "angle_deg", 1.0, false, &[AZIMUTH]),
    recipe("backlash", "width_deg", 0.3, true, &[]),
    recipe("nonlinearity", "inverse_scale_per_lx", 1.5e-4, true, &[]),
    recipe(
        "range_step",
        "factor_rel",
        0.01,
        true,
        &[("range", OneOf(&[1.0, 2.0, 3.0]))],
    ),
    recipe("temp_coefficient", "coefficient_per_k", 0.01, true, &[]),
    recipe(
        "lamp_warmup",
        "amplitude_rel",
        0.1,
        false,
        &[("time_constant_s", Decades(150.0, 1500.0))],
    ),
    recipe("lamp_drift", "rate_per_h", 0.02, true, &[]),
    recipe(
        "flicker_alias",
        "amplitude_rel",
        0.05,
        false,
        &[
            ("period_s", Decades(11.0, 400.0)),
            ("phase_rad", Between(0.0, std::f64::consts::TAU)),
        ],
    ),
    recipe(
        "dead_sector",
        "depth_rel",
        0.3,
        false,
        &[
            AZIMUTH,
            ("width_deg", Between(40.0, 120.0)),
            ("aim_deg", Between(3.0, 9.0)),
        ],
    ),
    recipe(
        "self_absorption",
        "depth_rel",
        0.3,
        false,
        &[
            AZIMUTH,
            ("gamma_deg", Between(30.0, 60.0)),
            ("width_deg", Between(15.0, 35.0)),
        ],
    ),
    recipe("polarization", "amplitude_rel", 0.02, false, &[AZIMUTH]),
    recipe("air_absorption", "coefficient_per_m", 0.05, false, &[]),
];

/// Effects that sensor maps can show.
pub const SENSOR: &[Recipe] = &[
    recipe("ambient_light", "illuminance_lx", 13.0, false, &[]),
    recipe("dark_offset", "offset_rel", 0.01, true, &[]),
    recipe(
        "near_field",
        "radius_mm",
        60.0,
        false,
        &[("aim_deg", Between(0.0, 8.0))],
    ),
    recipe("nonlinearity", "inverse_scale", 0.01, true, &[]),
    recipe("stage_lateral", "offset_mm", 5.0, false, &[AZIMUTH]),
    recipe("sensor_axial", "offset_mm", 3.0, true, &[]),
    recipe("sensor_tilt", "angle_deg", 2.0, false, &[AZIMUTH]),
    recipe("source_tilt", "angle_deg", 3.0, false, &[AZIMUTH]),
    recipe("cover_glass", "plates", 4.0, false, &[]),
    recipe("pixel_angular", "coefficient", 1.0, false, &[]),
    recipe("vignetting", "coefficient_rel", 0.05, false, &[]),
    recipe("prnu_gradient", "gradient_rel", 0.02, false, &[AZIMUTH]),
    recipe(
        "flicker_banding",
        "amplitude_rel",
        0.02,
        false,
        &[
            ("period_mm", Decades(3.0, 20.0)),
            ("phase_rad", Between(0.0, std::f64::consts::TAU)),
        ],
    ),
    recipe(
        "ghost",
        "amplitude_rel",
        0.02,
        false,
        &[
            ("x_mm", Between(-8.0, 8.0)),
            ("y_mm", Between(-8.0, 8.0)),
            ("width_mm", Between(1.5, 4.0)),
        ],
    ),
    recipe("exposure_offset", "offset", 0.02, true, &[]),
];

/// The recipe of a name in a list.
pub fn find(list: &'static [Recipe], name: &str) -> Option<&'static Recipe> {
    list.iter().find(|recipe| recipe.name == name)
}
