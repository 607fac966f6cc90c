//! The catalogue of physical effects that a model may be missing.
//!
//! Each effect is one file: its paragraph of the book, what it is called, what it belongs to, its keys with units and
//! plausible ranges, where it shows, what looks like it and which measurement tells them apart, and its formula as one
//! or more [`Act`]s on the prediction. The prediction asks the acts in the fixed order of the physics, whatever the
//! order in a model file. The book's page is made from these files (`tests/suite/page.rs`).

mod act;
mod sentence;
mod spec;

mod air_absorption;
mod ambient_light;
mod ambient_stray;
mod axial_centre;
mod axis_nonperp;
mod backlash;
mod beam_width;
mod c_zero;
mod colour_over_angle;
mod cosine_f2;
mod cover_glass;
mod crosstalk;
mod dark_offset;
mod dead_sector;
mod detector_aperture;
mod distance_offset;
mod exposure_offset;
mod flicker_alias;
mod flicker_banding;
mod floor_reflection;
mod gamma_sag;
mod gamma_zero;
mod ghost;
mod lamp_drift;
mod lamp_warmup;
mod lateral_centre;
mod ler_scale;
mod light_level;
mod luminaire_tilt;
mod near_field;
mod nonlinearity;
mod pixel_angular;
mod polarization;
mod prnu_gradient;
mod quantization;
mod range_step;
mod saturation;
mod self_absorption;
mod sensor_axial;
mod sensor_tilt;
mod source_tilt;
mod spectral_mismatch;
mod spectro_2nd;
mod spectro_bandpass;
mod spectro_dark;
mod spectro_shift;
mod spectro_stray;
mod stage_lateral;
mod temp_coefficient;
mod vignetting;

pub use act::{
    Act, Axes, DetectorView, DirectionFactor, Instrument, LampLaw, MOST_KEYS, Mounting, PairLaw, PartLaw, Pixel,
    Placement, Ray, Values,
};
pub use sentence::digits;
pub use spec::{BelongsTo, EffectSpec, ParameterSpec, Role, Sampling, Stage};

/// Every effect, in the order of the book.
static CATALOGUE: &[&EffectSpec] = &[
    &ambient_stray::SPEC,
    &ambient_light::SPEC,
    &dark_offset::SPEC,
    &floor_reflection::SPEC,
    &distance_offset::SPEC,
    &axial_centre::SPEC,
    &lateral_centre::SPEC,
    &near_field::SPEC,
    &gamma_zero::SPEC,
    &gamma_sag::SPEC,
    &c_zero::SPEC,
    &luminaire_tilt::SPEC,
    &axis_nonperp::SPEC,
    &backlash::SPEC,
    &nonlinearity::SPEC,
    &range_step::SPEC,
    &temp_coefficient::SPEC,
    &lamp_warmup::SPEC,
    &lamp_drift::SPEC,
    &light_level::SPEC,
    &beam_width::SPEC,
    &flicker_alias::SPEC,
    &dead_sector::SPEC,
    &self_absorption::SPEC,
    &polarization::SPEC,
    &detector_aperture::SPEC,
    &cosine_f2::SPEC,
    &spectral_mismatch::SPEC,
    &colour_over_angle::SPEC,
    &ler_scale::SPEC,
    &air_absorption::SPEC,
    &spectro_shift::SPEC,
    &spectro_bandpass::SPEC,
    &spectro_stray::SPEC,
    &spectro_2nd::SPEC,
    &spectro_dark::SPEC,
    &stage_lateral::SPEC,
    &sensor_axial::SPEC,
    &sensor_tilt::SPEC,
    &source_tilt::SPEC,
    &cover_glass::SPEC,
    &pixel_angular::SPEC,
    &vignetting::SPEC,
    &prnu_gradient::SPEC,
    &flicker_banding::SPEC,
    &ghost::SPEC,
    &exposure_offset::SPEC,
    &saturation::SPEC,
    &quantization::SPEC,
    &crosstalk::SPEC,
];

/// Every effect that has a name, in the order of the book.
pub fn catalogue() -> &'static [&'static EffectSpec] {
    CATALOGUE
}

/// The light that the floor returns.
pub(crate) fn floor() -> &'static EffectSpec {
    &floor_reflection::SPEC
}

/// The effect of that name.
pub fn by_name(name: &str) -> Option<&'static EffectSpec> {
    CATALOGUE.iter().copied().find(|spec| spec.name == name)
}
