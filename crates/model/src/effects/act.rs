//! The places where an effect can act on a prediction, in the order of the physics.

use glam::{DMat3, DVec3};
use isolux_record::observation::ReadingCoordinates;

use crate::emitter::Emitter;
use crate::pose::SensorPose;

/// Most keys of an effect.
pub const MOST_KEYS: usize = 4;

/// An effect's values in the order of its keys, zeros behind them. A formula names them:
/// `fn drift(&[rate_per_h, reference_s, ..]: &Values, …)`.
pub type Values = [f64; MOST_KEYS];

/// The true setting of the axes, where the record holds what was read back.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Axes {
    /// Half-plane that contains the detector.
    pub c_deg: f64,
    /// Signed polar angle of the detector.
    pub gamma_deg: f64,
    /// From the intersection of the axes to the detector.
    pub distance_mm: f64,
    /// Tilt of the lamp's axis out of the plane perpendicular to the γ axis.
    pub nonperp_deg: f64,
}

/// The detector as the luminaire sees it, in the luminaire frame.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Mounting {
    /// Where the detector is, from the light centre.
    pub detector_mm: DVec3,
    /// Unit vector from the detector along its axis reversed: light along it arrives at normal incidence.
    pub facing: DVec3,
}

/// A direction out of the luminaire.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Ray {
    /// Azimuth.
    pub c_deg: f64,
    /// Polar angle, not negative.
    pub gamma_deg: f64,
    /// The unit vector.
    pub direction: DVec3,
    /// Geometric mean of cos γ over the luminaire's flux.
    pub mean_cosine: f64,
}

/// A factor on the light of every direction, made ready for one set of values.
pub type DirectionFactor = Box<dyn Fn(&Ray) -> f64 + Send + Sync>;

/// What the detector's own response can depend on.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct DetectorView {
    /// True half-plane.
    pub c_deg: f64,
    /// True γ.
    pub gamma_deg: f64,
    /// Cosine of the angle of incidence.
    pub cos_incidence: f64,
    /// Which photometer head, 0 being that of the model.
    pub head: u32,
}

/// The pose of a sensor and the tilt of the source before it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Placement {
    /// The sensor.
    pub pose: SensorPose,
    /// From the room to the luminaire: unity unless the source is tilted.
    pub luminaire_from_room: DMat3,
}

/// Where light meets the sensor.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Pixel {
    /// From the sensor's centre along its x.
    pub x_mm: f64,
    /// From the sensor's centre along its y.
    pub y_mm: f64,
    /// Half the sensor's width.
    pub half_width_mm: f64,
    /// Cosine of the angle of incidence.
    pub cos_incidence: f64,
}

/// A spectrum that an instrument spoils: value at any wavelength, and where it was read.
pub struct Instrument<'a> {
    /// The value before this act at a wavelength in nm.
    pub truth: &'a dyn Fn(f64) -> f64,
    /// The wavelength that the instrument shows.
    pub wavelength_nm: f64,
    /// The integral of the true spectrum over wavelength.
    pub integral: f64,
}

/// A factor on the lamp at t in s.
pub type LampLaw = fn(&Values, Option<f64>) -> f64;
/// Two numbers from an effect's values.
pub type PairLaw = fn(&Values) -> (f64, f64);

/// Parts of the emitter that give less.
#[derive(Debug, Clone, Copy)]
pub struct PartLaw {
    /// A factor on a part at an azimuth in degrees.
    pub given: fn(&Values, f64) -> f64,
    /// Inward lean in degrees of the parts of an emitter that has no LEDs of its own.
    pub aim_deg: fn(&Values) -> f64,
}

/// What an effect does. Every function takes the effect's values in the order of its keys first.
#[derive(Debug, Clone, Copy)]
pub enum Act {
    /// The axes stand elsewhere than they say.
    Axes(fn(&Values, &ReadingCoordinates, &mut Axes)),
    /// The luminaire hangs otherwise than it should.
    Mount(fn(&Values, &mut Mounting)),
    /// The light comes from elsewhere: an emitter in place of a point or disc.
    Emitter(fn(&Values) -> Emitter),
    /// The luminaire shines otherwise in some directions: a factor.
    Direction(fn(&Values) -> DirectionFactor),
    /// Parts of the emitter give less.
    Part(PartLaw),
    /// The lamp shines otherwise at some times: a factor at t in s, none where the time is not known.
    Lamp(LampLaw),
    /// The path takes light away: a factor over a length in mm.
    Path(fn(&Values, f64) -> f64),
    /// The detector answers to something beside illuminance: a factor.
    Detector(fn(&Values, &DetectorView) -> f64),
    /// The detector is not a point: its radius in mm.
    Aperture(fn(&Values) -> f64),
    /// The floor returns light: (albedo, height in mm).
    Floor(PairLaw),
    /// Light in the room, lamp on or off: lx.
    Ambient(fn(&Values) -> f64),
    /// The reading chain answers otherwise: reading from light in lx, and its inverse.
    Response {
        /// Reading from light.
        apply: fn(&Values, f64, &ReadingCoordinates) -> f64,
        /// Light from reading.
        invert: fn(&Values, f64, &ReadingCoordinates) -> f64,
    },
    /// Added to every reading, capped or not: lx.
    Zero(fn(&Values) -> f64),

    /// The sensor or the source stands elsewhere than it should.
    Placement(fn(&Values, &mut Placement)),
    /// The sensor answers otherwise at some places or angles: a factor on the lamp's light.
    Pixel(fn(&Values, &Pixel) -> f64),
    /// Uniform light on the sensor: (lx, W/m²).
    Background(PairLaw),
    /// The shutter is open for another time: relative exposure.
    Exposure(fn(&Values, f64) -> f64),
    /// The sensor's signal, relative to full scale, grows otherwise than in proportion to the light.
    Signal(fn(&Values, f64) -> f64),
    /// Added to the signal of every map, capped or not, relative to full scale.
    SignalZero(fn(&Values) -> f64),
    /// What becomes of the signal, relative to full scale, when it is read out.
    Readout(fn(&Values, f64) -> f64),
    /// Light spreads to neighbours: standard deviation in pixels.
    Blur(fn(&Values) -> f64),
    /// Luminous efficacy is another: a factor.
    Efficacy(fn(&Values) -> f64),
    /// A lumen has other watts, and another signal of a sensor, in some directions: a factor at cos γ.
    Colour(fn(&Values, f64) -> f64),

    /// The spectrometer shows another value.
    Spectrum(fn(&Values, &Instrument<'_>) -> f64),
    /// Added to every spectrum, capped or not, in its unit.
    SpectrumZero(fn(&Values) -> f64),
}

impl std::fmt::Debug for Instrument<'_> {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Instrument")
            .field("wavelength_nm", &self.wavelength_nm)
            .finish_non_exhaustive()
    }
}

/// A turn by `angle_deg` that carries directions at azimuth `azimuth_deg` to larger γ.
pub(super) fn lean(angle_deg: f64, azimuth_deg: f64) -> DMat3 {
    let (sin, cos) = azimuth_deg.to_radians().sin_cos();
    DMat3::from_axis_angle(DVec3::new(-sin, cos, 0.0), angle_deg.to_radians())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_lean_adds_to_gamma_in_its_own_plane() {
        for (c, gamma) in [(30f64, 10f64), (30.0, 50.0), (210.0, 20.0)] {
            let (c, gamma) = (c.to_radians(), gamma.to_radians());
            let before = DVec3::new(gamma.sin() * c.cos(), gamma.sin() * c.sin(), gamma.cos());
            let after = lean(2.0, 30.0) * before;
            let expected = if c > 3.0 {
                gamma.to_degrees() - 2.0
            } else {
                gamma.to_degrees() + 2.0
            };
            assert!((after.z.acos().to_degrees() - expected).abs() < 1e-9);
        }
    }
}
