//! What can be wrong on the second day: every injected effect of the room that readings or maps can show, some in two
//! shapes, and changes of lamp and meter that the catalogue of effects has no name for.

use isolux_darkroom::Darkroom;
use isolux_hidden_effects::random::Draws;
use isolux_hidden_effects::recipe::Extra::{self, Between, Decades};

/// What is recorded on the second day.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum Kind {
    /// A scan of the goniophotometer.
    Readings,
    /// Maps of the camera.
    Maps,
}

/// One fault.
#[derive(Debug, Clone, Copy)]
pub struct Fault {
    /// Its name in tables and on the command line.
    pub label: &'static str,
    /// What shows it.
    pub kind: Kind,
    /// The effect of the catalogue that it is; none: the catalogue has no name for it.
    pub effect: Option<&'static str>,
    change: Change,
    /// The largest plausible strength.
    pub plausible: f64,
    signed: bool,
    extra: &'static [(&'static str, Extra)],
}

/// What a strength changes in the room.
#[derive(Debug, Clone, Copy)]
enum Change {
    /// This key of the fault's effect becomes larger by the strength.
    More(&'static str),
    /// That key is the strength.
    Is(&'static str),
    /// That key falls from this value by the strength.
    Below(&'static str, f64),
    /// The meter's calibration is wrong by the strength, relative.
    MeterGain,
    /// The lamp gives more light by the strength, relative.
    LampFlux,
    /// The lamp's lobe becomes wider: its exponent falls by the strength, relative.
    WiderLobe,
    /// The LEDs stand on rings that are wider by the strength, relative.
    WiderRings,
}

/// A fault with every value drawn but its strength.
#[derive(Debug, Clone)]
pub struct Drawn {
    /// The fault.
    pub fault: &'static Fault,
    sign: f64,
    extra: Vec<(&'static str, f64)>,
}

impl Fault {
    /// Draws sign and further values.
    pub fn draw(&'static self, draws: &mut Draws) -> Drawn {
        let sign = if self.signed { draws.sign() } else { 1.0 };
        let value = |how: Extra, draws: &mut Draws| match how {
            Between(low, high) => draws.between(low, high),
            Decades(low, high) => draws.decades(low, high),
            Extra::OneOf(list) => *draws.pick(list),
        };
        let extra = self.extra.iter().map(|&(key, how)| (key, value(how, draws)));
        Drawn {
            fault: self,
            sign,
            extra: extra.collect(),
        }
    }

    /// Whether the lamp is read before it is warm; then it is the warm lamp without the fault.
    pub fn hasty(&self) -> bool {
        self.effect == Some("lamp_warmup")
    }
}

impl Drawn {
    /// The room with the fault at this strength, above zero.
    ///
    /// # Panics
    /// Where the room has no such injected effect: a mistake in the tables below.
    pub fn within(&self, mut room: Darkroom, strength: f64) -> Darkroom {
        let amount = self.sign * strength;
        let effect = self.fault.effect.unwrap_or_default();
        let mut set = |key: &'static str, value: f64| {
            assert!(
                room.injected_effects.set(effect, key, value),
                "the darkroom has no {effect}.{key}"
            );
        };
        for &(key, value) in &self.extra {
            set(key, value);
        }
        match self.fault.change {
            Change::Is(key) => set(key, amount),
            Change::Below(key, from) => set(key, from - amount),
            Change::More(key) => {
                let values = room.injected_effects.values();
                let before = values.iter().find(|(name, of, _)| (*name, *of) == (effect, key));
                let before = before.map_or(0.0, |(.., value)| *value);
                assert!(
                    room.injected_effects.set(effect, key, before + amount),
                    "the darkroom has no {effect}.{key}"
                );
            }
            Change::MeterGain => room.luxmeter.gain_error_rel += amount,
            Change::LampFlux => room.lamp.flux_lm *= 1.0 + amount,
            Change::WiderLobe => room.lamp.exponent *= 1.0 - amount,
            Change::WiderRings => {
                let wider = |diameter: &mut f64| *diameter *= 1.0 + amount;
                room.lamp.ring_diameter_mm.iter_mut().for_each(wider);
            }
        }
        room
    }

    /// The strength and what was drawn with it, for a line of a table.
    pub fn words(&self, strength: f64) -> String {
        let extra: Vec<String> = self
            .extra
            .iter()
            .map(|(key, value)| format!(", {key} {value:.3}"))
            .collect();
        format!("{:.4e}{}", self.sign * strength, extra.concat())
    }
}

const AZIMUTH: (&str, Extra) = ("azimuth_deg", Between(0.0, 360.0));
const PHASE: (&str, Extra) = ("phase_rad", Between(0.0, std::f64::consts::TAU));

/// An injected effect of the room; its label is the effect's name, with a word for its shape where there are several.
const fn fault(
    kind: Kind,
    label: &'static str,
    effect: &'static str,
    change: Change,
    plausible: f64,
    signed: bool,
    extra: &'static [(&'static str, Extra)],
) -> Fault {
    Fault {
        label,
        kind,
        effect: Some(effect),
        change,
        plausible,
        signed,
        extra,
    }
}

/// As [`injected effect`], of readings, of either sign and without further values.
const fn either(effect: &'static str, key: &'static str, plausible: f64) -> Fault {
    fault(Kind::Readings, effect, effect, Change::More(key), plausible, true, &[])
}

/// What the catalogue has no name for.
const fn outside_catalogue(kind: Kind, label: &'static str, change: Change, plausible: f64) -> Fault {
    Fault {
        label,
        kind,
        effect: None,
        change,
        plausible,
        signed: true,
        extra: &[],
    }
}

use Change::{Below, Is, More};
use Kind::{Maps, Readings};

/// All faults, those of readings first. Plausible strengths are those of the catalogue of effects.
pub static FAULTS: &[Fault] = &[
    fault(
        Readings,
        "ambient_stray",
        "ambient_stray",
        More("illuminance_lx"),
        1.0,
        false,
        &[],
    ),
    either("dark_offset", "offset_lx", 1.5),
    fault(
        Readings,
        "floor_reflection",
        "floor_reflection",
        More("albedo"),
        0.48,
        false,
        &[],
    ),
    either("distance_offset", "offset_mm", 20.0),
    either("axial_centre", "offset_mm", 30.0),
    fault(
        Readings,
        "lateral_centre",
        "lateral_centre",
        Is("offset_mm"),
        20.0,
        false,
        &[AZIMUTH],
    ),
    outside_catalogue(Readings, "wider_rings", Change::WiderRings, 0.9),
    either("gamma_zero", "offset_deg", 0.5),
    either("gamma_sag", "amplitude_deg", 0.3),
    either("c_zero", "offset_deg", 5.0),
    fault(
        Readings,
        "luminaire_tilt",
        "luminaire_tilt",
        Is("angle_deg"),
        1.0,
        false,
        &[AZIMUTH],
    ),
    fault(
        Readings,
        "axis_nonperp",
        "axis_nonperp",
        Is("angle_deg"),
        0.3,
        false,
        &[],
    ),
    either("backlash", "width_deg", 0.3),
    either("nonlinearity", "inverse_scale_per_lx", 1e-3),
    fault(
        Readings,
        "range_step 1",
        "range_step",
        Is("factor_rel"),
        0.01,
        true,
        &[("range", Between(1.0, 1.0))],
    ),
    fault(
        Readings,
        "range_step 2",
        "range_step",
        Is("factor_rel"),
        0.01,
        true,
        &[("range", Between(2.0, 2.0))],
    ),
    either("temp_coefficient", "coefficient_per_k", 0.01),
    fault(
        Readings,
        "lamp_warmup fast",
        "lamp_warmup",
        Is("amplitude_rel"),
        0.1,
        false,
        &[("time_constant_s", Decades(200.0, 500.0))],
    ),
    fault(
        Readings,
        "lamp_warmup slow",
        "lamp_warmup",
        Is("amplitude_rel"),
        0.1,
        false,
        &[("time_constant_s", Decades(700.0, 1500.0))],
    ),
    either("lamp_drift", "rate_per_h", 0.02),
    fault(
        Readings,
        "flicker_alias fast",
        "flicker_alias",
        Is("amplitude_rel"),
        0.05,
        false,
        &[("period_s", Decades(11.0, 40.0)), PHASE],
    ),
    fault(
        Readings,
        "flicker_alias slow",
        "flicker_alias",
        Is("amplitude_rel"),
        0.05,
        false,
        &[("period_s", Decades(100.0, 600.0)), PHASE],
    ),
    fault(
        Readings,
        "dead_sector narrow",
        "dead_sector",
        Is("depth_rel"),
        0.3,
        false,
        &[AZIMUTH, ("width_deg", Between(30.0, 60.0))],
    ),
    fault(
        Readings,
        "dead_sector wide",
        "dead_sector",
        Is("depth_rel"),
        0.3,
        false,
        &[AZIMUTH, ("width_deg", Between(90.0, 140.0))],
    ),
    fault(
        Readings,
        "self_absorption narrow",
        "self_absorption",
        Is("depth_rel"),
        0.5,
        false,
        &[
            AZIMUTH,
            ("gamma_deg", Between(15.0, 50.0)),
            ("width_deg", Between(12.0, 20.0)),
        ],
    ),
    fault(
        Readings,
        "self_absorption wide",
        "self_absorption",
        Is("depth_rel"),
        0.5,
        false,
        &[
            AZIMUTH,
            ("gamma_deg", Between(15.0, 50.0)),
            ("width_deg", Between(30.0, 50.0)),
        ],
    ),
    fault(
        Readings,
        "polarization",
        "polarization",
        Is("amplitude_rel"),
        0.02,
        false,
        &[("azimuth_deg", Between(0.0, 180.0))],
    ),
    fault(
        Readings,
        "detector_aperture",
        "detector_aperture",
        Is("diameter_mm"),
        60.0,
        false,
        &[],
    ),
    fault(
        Readings,
        "cosine_f2",
        "cosine_f2",
        Is("coefficient_rel"),
        0.1,
        true,
        &[],
    ),
    fault(
        Readings,
        "spectral_mismatch slope",
        "spectral_mismatch",
        Is("slope_per_deg"),
        5e-4,
        true,
        &[],
    ),
    fault(
        Readings,
        "spectral_mismatch factor",
        "spectral_mismatch",
        More("factor"),
        0.03,
        true,
        &[],
    ),
    fault(
        Readings,
        "air_absorption",
        "air_absorption",
        Is("coefficient_per_m"),
        0.05,
        false,
        &[],
    ),
    fault(
        Readings,
        "light_level of the meter",
        "light_level",
        Change::MeterGain,
        0.1,
        true,
        &[],
    ),
    fault(
        Readings,
        "light_level of the lamp",
        "light_level",
        Change::LampFlux,
        0.1,
        true,
        &[],
    ),
    fault(Readings, "wider_lobe", "beam_width", Change::WiderLobe, 0.1, true, &[]),
    fault(
        Maps,
        "ambient_light",
        "ambient_light",
        Is("illuminance_lx"),
        20.0,
        false,
        &[],
    ),
    fault(Maps, "dark_offset", "dark_offset", More("offset_rel"), 0.01, true, &[]),
    fault(Maps, "near_field", "near_field", Change::WiderRings, 0.9, true, &[]),
    fault(
        Maps,
        "nonlinearity",
        "nonlinearity",
        Is("inverse_scale"),
        0.05,
        true,
        &[],
    ),
    fault(
        Maps,
        "stage_lateral",
        "stage_lateral",
        Is("offset_mm"),
        5.0,
        false,
        &[AZIMUTH],
    ),
    fault(Maps, "sensor_axial", "sensor_axial", Is("offset_mm"), 3.0, true, &[]),
    fault(
        Maps,
        "sensor_tilt",
        "sensor_tilt",
        Is("angle_deg"),
        2.0,
        false,
        &[AZIMUTH],
    ),
    fault(
        Maps,
        "source_tilt",
        "source_tilt",
        Is("angle_deg"),
        3.0,
        false,
        &[AZIMUTH],
    ),
    fault(Maps, "cover_glass", "cover_glass", Is("plates"), 4.0, false, &[]),
    fault(
        Maps,
        "pixel_angular",
        "pixel_angular",
        Is("coefficient"),
        1.0,
        false,
        &[],
    ),
    fault(
        Maps,
        "vignetting",
        "vignetting",
        Is("coefficient_rel"),
        0.05,
        false,
        &[],
    ),
    fault(
        Maps,
        "prnu_gradient",
        "prnu_gradient",
        Is("gradient_rel"),
        0.02,
        false,
        &[AZIMUTH],
    ),
    fault(
        Maps,
        "flicker_banding fine",
        "flicker_banding",
        Is("amplitude_rel"),
        0.02,
        false,
        &[("period_mm", Decades(3.0, 6.0)), PHASE],
    ),
    fault(
        Maps,
        "flicker_banding coarse",
        "flicker_banding",
        Is("amplitude_rel"),
        0.02,
        false,
        &[("period_mm", Decades(9.0, 20.0)), PHASE],
    ),
    fault(
        Maps,
        "ghost narrow",
        "ghost",
        Is("amplitude_rel"),
        0.02,
        false,
        &[
            ("x_mm", Between(-8.0, 8.0)),
            ("y_mm", Between(-8.0, 8.0)),
            ("width_mm", Between(1.5, 2.5)),
        ],
    ),
    fault(
        Maps,
        "ghost wide",
        "ghost",
        Is("amplitude_rel"),
        0.02,
        false,
        &[
            ("x_mm", Between(-8.0, 8.0)),
            ("y_mm", Between(-8.0, 8.0)),
            ("width_mm", Between(3.5, 5.0)),
        ],
    ),
    fault(
        Maps,
        "exposure_offset",
        "exposure_offset",
        Is("offset"),
        0.01,
        true,
        &[],
    ),
    fault(
        Maps,
        "saturation",
        "saturation",
        Below("level_rel", 1.1),
        0.3,
        false,
        &[],
    ),
    fault(Maps, "quantization", "quantization", Is("step_rel"), 0.02, false, &[]),
    fault(Maps, "crosstalk", "crosstalk", Is("width_px"), 3.0, false, &[]),
    fault(
        Maps,
        "air_absorption",
        "air_absorption",
        Is("coefficient_per_m"),
        0.05,
        false,
        &[],
    ),
    fault(
        Maps,
        "dead_sector",
        "dead_sector",
        Is("depth_rel"),
        0.3,
        false,
        &[AZIMUTH, ("width_deg", Between(40.0, 120.0))],
    ),
];

/// The faults that one kind of observation shows.
pub fn of(kind: Kind) -> impl Iterator<Item = &'static Fault> {
    FAULTS.iter().filter(move |fault| fault.kind == kind)
}
