//! Every effect of the catalogue as a switch of the room, under the names and keys that model files use.
//!
//! An injected effect is switched off by its null value, or by `only = true` with all that a file does not name. How
//! each one acts is in the module of the part that it belongs to: [`crate::mount`], [`crate::floor`],
//! [`crate::output`], [`crate::meter`], [`crate::spectrograph`], [`crate::camera`].

use std::ops::RangeInclusive;

use isolux_document::Fault;
use isolux_document::bounds::within;
use serde::{Deserialize, Serialize};

macro_rules! injected_effects {
    ($( $(#[$doc:meta])* $field:ident : $name:ident { $(
        $(#[$key_doc:meta])* $key:ident = $null:expr $(=> $range:expr)?
    ),* $(,)? } )*) => {
        $(
            $(#[$doc])*
            #[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
            #[serde(default, deny_unknown_fields)]
            pub struct $name { $( $(#[$key_doc])* pub $key: f64, )* }

            impl Default for $name {
                fn default() -> Self { Self { $( $key: $null, )* } }
            }
        )*

        /// All injected effects of one room. `InjectedEffects::default()` is a room without any.
        #[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
        #[serde(default, deny_unknown_fields)]
        pub struct InjectedEffects {
            /// In a file: every injected effect that it does not name is off, whatever the built-in room has. Always
            /// false once read.
            pub only: bool,
            $( $(#[$doc])* pub $field: $name, )*
        }

        impl InjectedEffects {
            /// Names of all injected effects, in the order of the catalogue.
            pub const NAMES: &'static [&'static str] = &[ $( stringify!($field), )* ];

            /// Sets `name.key` to `value`; false if there is no such injected effect or key.
            pub fn set(&mut self, name: &str, key: &str, value: f64) -> bool {
                match (name, key) {
                    $( $( (stringify!($field), stringify!($key)) => { self.$field.$key = value; true } )* )*
                    _ => false,
                }
            }

            /// Whether every value is one that a room can have.
            pub(crate) fn check(&self) -> Result<(), Fault> {
                $( $(
                    let range = None$(.or(Some($range)))?.unwrap_or_else(|| usual_range(stringify!($key)));
                    let path = concat!("injected_effects.", stringify!($field), ".", stringify!($key));
                    within(path, self.$field.$key, range, "")?;
                )* )*
                Ok(())
            }

            /// Every (injected effect, key, value), in the order of the catalogue.
            pub fn values(&self) -> Vec<(&'static str, &'static str, f64)> {
                vec![ $( $( (stringify!($field), stringify!($key), self.$field.$key), )* )* ]
            }
        }
    };
}

/// What a value may be whose key states no range of its own.
fn usual_range(key: &str) -> RangeInclusive<f64> {
    let most = match key {
        _ if key.ends_with("_deg") && !key.ends_with("_per_deg") => 360.0,
        _ if key.ends_with("_mm") => 1e5,
        _ if key.ends_with("_nm") => 1e4,
        _ => 1e6,
    };
    -most..=most
}

injected_effects! {
    /// Uniform stray light in the room, lamp on or off.
    ambient_stray: AmbientStray {
        /// Illuminance that it adds at the meter, lx.
        illuminance_lx = 0.0,
    }
    /// Uniform light on the camera, lamp on or off, not under the cap.
    ambient_light: AmbientLight {
        /// Illuminance on the sensor, lx.
        illuminance_lx = 0.0,
    }
    /// Zero offset of the meter, and of the camera's signal.
    dark_offset: DarkOffset {
        /// Offset of the meter's indication, lx.
        offset_lx = 0.0,
        /// Offset of the camera's signal, relative to full scale.
        offset_rel = 0.0,
    }
    /// A Lambertian floor under the bench.
    floor_reflection: FloorReflection {
        /// Reflectance.
        albedo = 0.0 => 0.0..=1.0,
        /// Height of the axes' intersection over the floor, mm.
        height_mm = 1200.0 => 1e-9..=1e5,
    }
    /// Error of the photometric distance: the detector really stands at `distance + offset_mm`.
    distance_offset: DistanceOffset {
        /// Offset, mm.
        offset_mm = 0.0,
    }
    /// The light centre lies on the luminaire's axis, in front of the axes' intersection.
    axial_centre: AxialCentre {
        /// Offset along +z of the luminaire, mm.
        offset_mm = 0.0,
    }
    /// The light centre lies beside the luminaire's axis.
    lateral_centre: LateralCentre {
        /// Offset, mm.
        offset_mm = 0.0,
        /// Its direction in the luminaire's C, degrees.
        azimuth_deg = 0.0,
    }
    /// γ zero error: the luminaire stands at γ + offset.
    gamma_zero: GammaZero {
        /// Offset, degrees.
        offset_deg = 0.0,
    }
    /// Gravity sag: the luminaire stands at γ + amplitude · cos γ.
    gamma_sag: GammaSag {
        /// Amplitude, degrees.
        amplitude_deg = 0.0,
    }
    /// C zero error: the luminaire stands at C + offset.
    c_zero: CZero {
        /// Offset, degrees.
        offset_deg = 0.0,
    }
    /// The luminaire is mounted tilted on the C axis, away from `azimuth_deg`.
    luminaire_tilt: LuminaireTilt {
        /// Tilt, degrees.
        angle_deg = 0.0,
        /// The half-plane in which γ appears too large by the tilt, degrees.
        azimuth_deg = 0.0,
    }
    /// The C axis is not perpendicular to the γ axis.
    axis_nonperp: AxisNonperp {
        /// Angle missing from 90°, degrees.
        angle_deg = 0.0,
    }
    /// Play between the γ encoder and the luminaire: γ + width/2 in the direction of travel.
    backlash: Backlash {
        /// Width, degrees.
        width_deg = 0.0,
    }
    /// The detector saturates: small-signal slope 1, first-order loss `inverse_scale · signal`.
    nonlinearity: Nonlinearity {
        /// For the lux meter, 1/lx.
        inverse_scale_per_lx = 0.0,
        /// For the camera, relative to full scale.
        inverse_scale = 0.0,
    }
    /// One range of the meter is wrong by a factor.
    range_step: RangeStep {
        /// Relative error of that range.
        factor_rel = 0.0,
        /// The range.
        range = 0.0,
    }
    /// The meter's responsivity depends on its temperature.
    temp_coefficient: TempCoefficient {
        /// Relative change per kelvin.
        coefficient_per_k = 0.0,
        /// Temperature at which the meter was calibrated, °C.
        reference_c = 25.0,
    }
    /// The lamp is brighter when cold. Two thermal masses: the board and the housing.
    lamp_warmup: LampWarmup {
        /// Relative excess at switch-on.
        amplitude_rel = 0.0 => -0.9..=5.0,
        /// Time constant of the board, s.
        time_constant_s = 600.0 => 1e-9..=1e6,
        /// Share of the excess that follows the housing.
        second_share = 0.1 => 0.0..=1.0,
        /// Time constant of the housing, s; 0: four times the board's.
        second_time_constant_s = 0.0,
    }
    /// Depreciation of the lamp or drift of its supply.
    lamp_drift: LampDrift {
        /// Relative change per hour.
        rate_per_h = 0.0,
        /// Time since switch-on at which the lamp has its nominal output, s.
        reference_s = 0.0,
    }
    /// The lamp gives more or less than its nominal light, at any time.
    light_level: LightLevel {
        /// Relative change of all its light.
        factor_rel = 0.0,
    }
    /// Slow beat of the lamp's modulation with the meter's sampling.
    flicker_alias: FlickerAlias {
        /// Relative amplitude.
        amplitude_rel = 0.0,
        /// Period of the beat, s.
        period_s = 60.0 => 1e-9..=1e6,
        /// Phase at switch-on, rad.
        phase_rad = 0.0,
    }
    /// LEDs of one sector are dimmed. With parallel LEDs the far field keeps its shape; give the lamp an aim to see it
    /// in C.
    dead_sector: DeadSector {
        /// Relative loss of the LED in the middle of the sector.
        depth_rel = 0.0 => -1.0..=1.0,
        /// Azimuth of the sector's middle, degrees.
        azimuth_deg = 0.0,
        /// Full width of the sector at half depth, degrees.
        width_deg = 60.0 => 1e-9..=360.0,
    }
    /// A part of the mount or a cable in front of the luminaire, in a direction fixed to it.
    self_absorption: SelfAbsorption {
        /// Relative loss behind its middle.
        depth_rel = 0.0,
        /// C of its middle, degrees.
        azimuth_deg = 0.0,
        /// γ of its middle, degrees.
        gamma_deg = 45.0 => 0.0..=89.0,
        /// Full width at half depth, degrees, as seen from the light centre.
        width_deg = 20.0 => 1e-9..=360.0,
    }
    /// Partly polarized light on a meter that prefers one polarization.
    polarization: Polarization {
        /// Relative amplitude of the cos 2(C − azimuth) term.
        amplitude_rel = 0.0,
        /// C at which the reading is largest, degrees.
        azimuth_deg = 0.0,
    }
    /// The meter's aperture is a disc, not a point.
    detector_aperture: DetectorAperture {
        /// Diameter, mm.
        diameter_mm = 0.0,
    }
    /// The meter's directional response departs from the cosine: factor 1 + coefficient · (1 − cos ε) / (1 − cos
    /// 60°).
    cosine_f2: CosineF2 {
        /// Relative error at 60° incidence.
        coefficient_rel = 0.0,
    }
    /// Colour over angle, seen by a meter whose responsivity is not V(λ): a factor of the reading that changes with
    /// γ.
    spectral_mismatch: SpectralMismatch {
        /// Mismatch factor at γ = 0.
        factor = 1.0,
        /// Its relative change per degree of γ.
        slope_per_deg = 0.0,
    }
    /// The lamp's lumens per watt differ from those of the spectrum that was measured.
    ler_scale: LerScale {
        /// True luminous efficacy over that of the spectrum.
        factor = 1.0 => 1e-9..=1e6,
    }
    /// Absorption along the path, Beer–Lambert.
    air_absorption: AirAbsorption {
        /// Coefficient, 1/m (Napierian).
        coefficient_per_m = 0.0,
    }
    /// The spectrometer's stated wavelength is wrong: light of λ appears at λ + shift.
    spectro_shift: SpectroShift {
        /// Shift, nm.
        shift_nm = 0.0,
    }
    /// The spectrometer's bandpass is a triangle.
    spectro_bandpass: SpectroBandpass {
        /// Full width at half maximum, nm.
        fwhm_nm = 0.0,
    }
    /// Light scattered inside the spectrometer, evenly over all pixels.
    spectro_stray: SpectroStray {
        /// Share of the whole signal that each nanometre receives.
        fraction = 0.0,
    }
    /// Second diffraction order: light of λ appears at 2λ.
    spectro_2nd: SpectroSecondOrder {
        /// Share of the first order.
        fraction = 0.0,
    }
    /// Error of the spectrometer's dark signal.
    spectro_dark: SpectroDark {
        /// Offset, in units of the spectral irradiance, W/(m² nm).
        offset = 0.0,
    }
    /// The camera stands beside its stated place.
    stage_lateral: StageLateral {
        /// Offset in the plane z = const, mm.
        offset_mm = 0.0,
        /// Its direction, degrees from x to y.
        azimuth_deg = 0.0,
    }
    /// The sensor lies deeper than its stated place.
    sensor_axial: SensorAxial {
        /// Offset of the distance, mm.
        offset_mm = 0.0,
    }
    /// The sensor is tilted in its housing.
    sensor_tilt: SensorTilt {
        /// Angle, degrees.
        angle_deg = 0.0,
        /// Direction on the sensor of the side that is lifted towards the lamp, degrees from x to y.
        azimuth_deg = 0.0,
    }
    /// The lamp before the camera is tilted.
    source_tilt: SourceTilt {
        /// Angle, degrees.
        angle_deg = 0.0,
        /// The side on which γ becomes larger by the tilt, degrees from x to y.
        azimuth_deg = 0.0,
    }
    /// Glass plates before the sensor, with all reflections between their faces.
    cover_glass: CoverGlass {
        /// Number of plates.
        plates = 0.0 => 0.0..=100.0,
        /// Refractive index.
        index = 1.52 => 1.0..=4.0,
    }
    /// Response of the pixel over the angle of incidence: exp(−coefficient · tan²θ).
    pixel_angular: PixelAngular {
        /// Coefficient.
        coefficient = 0.0,
    }
    /// Loss towards the rim of the sensor, as cos⁴ of a chief-ray angle.
    vignetting: Vignetting {
        /// Relative loss at half the sensor's width.
        coefficient_rel = 0.0 => -0.9..=0.9,
    }
    /// Responsivity that rises across the sensor.
    prnu_gradient: PrnuGradient {
        /// Relative change from the centre to half the sensor's width.
        gradient_rel = 0.0,
        /// Direction of the rise, degrees from x to y on the sensor.
        azimuth_deg = 0.0,
    }
    /// Rolling-shutter stripes along y.
    flicker_banding: FlickerBanding {
        /// Relative amplitude.
        amplitude_rel = 0.0,
        /// Period, mm on the sensor.
        period_mm = 8.0 => 1e-9..=1e5,
        /// Phase at y = 0, rad.
        phase_rad = 0.0,
    }
    /// A ghost reflection of the lamp: a soft spot at a place fixed to the sensor.
    ghost: Ghost {
        /// Height of the spot over the signal at the sensor's centre.
        amplitude_rel = 0.0,
        /// Its place, mm.
        x_mm = 0.0,
        /// Its place, mm.
        y_mm = 0.0,
        /// Its standard deviation, mm.
        width_mm = 3.0 => 1e-9..=1e5,
    }
    /// The shutter is open longer than stated.
    exposure_offset: ExposureOffset {
        /// Offset, in units of the stated exposure.
        offset = 0.0,
    }
    /// Full well of the pixels.
    saturation: Saturation {
        /// Signal at which a pixel clips, relative to full scale; 0: never.
        level_rel = 0.0,
    }
    /// Step of the converter.
    quantization: Quantization {
        /// Step of the signal, relative to full scale; 0: none.
        step_rel = 0.0,
    }
    /// Charge that spreads to neighbours: a Gaussian point-spread function.
    crosstalk: Crosstalk {
        /// Standard deviation, in bins of the map.
        width_px = 0.0,
    }
}

impl InjectedEffects {
    /// Angle and azimuth in radians, from degrees.
    pub(crate) fn polar(angle_deg: f64, azimuth_deg: f64) -> (f64, f64) {
        (angle_deg.to_radians(), azimuth_deg.to_radians())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_effect_is_set_by_the_names_of_the_catalogue() {
        let mut injected_effects = InjectedEffects::default();
        assert!(injected_effects.set("gamma_zero", "offset_deg", 0.2));
        assert_eq!(injected_effects.gamma_zero.offset_deg, 0.2);
        assert!(!injected_effects.set("gamma_zero", "offset", 0.2));
        assert!(injected_effects.values().contains(&("gamma_zero", "offset_deg", 0.2)));
    }
}
