//! The catalogue of physical effects that a model may be missing.
//!
//! Each effect is one file: what it is called, what it belongs to, its keys with units and plausible ranges, where it
//! shows, what looks like it and which measurement tells them apart, and its formula as one or more [`Act`]s on the
//! prediction. The prediction asks the acts in the fixed order of the physics, whatever the order in a model file.

mod act;
mod sentence;
mod spec;
mod value;

pub use act::{Act, Axes, DetectorView, Instrument, LampLaw, Mounting, PairLaw, Pixel, Placement, Ray};
pub use spec::{BelongsTo, EffectSpec, ParameterSpec, Role, Split, Stage};
pub use value::{Effect, EffectError, Notes};

macro_rules! catalogue {
    ($($file:ident: $($spec:ident),+;)*) => {
        $(mod $file;)*
        /// Every effect, in the order of the documentation.
        static CATALOGUE: &[&EffectSpec] = &[$($(&$file::$spec,)+)*];
    };
}

catalogue! {
    ambient_stray: AMBIENT_STRAY;
    ambient_light: AMBIENT_LIGHT;
    dark_offset: DARK_OFFSET;
    floor_reflection: FLOOR_REFLECTION;
    distance_offset: DISTANCE_OFFSET;
    axial_centre: AXIAL_CENTRE;
    lateral_centre: LATERAL_CENTRE;
    near_field: NEAR_FIELD;
    gamma_zero: GAMMA_ZERO;
    gamma_sag: GAMMA_SAG;
    c_zero: C_ZERO;
    luminaire_tilt: LUMINAIRE_TILT;
    axis_nonperp: AXIS_NONPERP;
    backlash: BACKLASH;
    nonlinearity: NONLINEARITY;
    range_step: RANGE_STEP;
    temp_coefficient: TEMP_COEFFICIENT;
    lamp_warmup: LAMP_WARMUP;
    lamp_drift: LAMP_DRIFT;
    flicker_alias: FLICKER_ALIAS;
    dead_sector: DEAD_SECTOR;
    self_absorption: SELF_ABSORPTION;
    polarization: POLARIZATION;
    detector_aperture: DETECTOR_APERTURE;
    cosine_f2: COSINE_F2;
    spectral_mismatch: SPECTRAL_MISMATCH;
    ler_scale: LER_SCALE;
    air_absorption: AIR_ABSORPTION;
    spectro_shift: SPECTRO_SHIFT;
    spectro_bandpass: SPECTRO_BANDPASS;
    spectro_stray: SPECTRO_STRAY;
    spectro_2nd: SPECTRO_2ND;
    spectro_dark: SPECTRO_DARK;
    stage_lateral: STAGE_LATERAL;
    sensor_axial: SENSOR_AXIAL;
    sensor_tilt: SENSOR_TILT;
    source_tilt: SOURCE_TILT;
    cover_glass: COVER_GLASS;
    pixel_angular: PIXEL_ANGULAR;
    vignetting: VIGNETTING;
    prnu_gradient: PRNU_GRADIENT;
    flicker_banding: FLICKER_BANDING;
    ghost: GHOST;
    exposure_offset: EXPOSURE_OFFSET;
    saturation: SATURATION;
    quantization: QUANTIZATION;
    crosstalk: CROSSTALK;
}

/// Every effect that has a name, in the order of the documentation.
pub fn catalogue() -> &'static [&'static EffectSpec] {
    CATALOGUE
}

/// The effect of that name.
pub fn by_name(name: &str) -> Option<&'static EffectSpec> {
    CATALOGUE.iter().copied().find(|spec| spec.name == name)
}
