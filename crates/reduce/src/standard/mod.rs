//! A run with a standard lamp → what the instrument has to be multiplied by, and how sure that is.
//!
//! The record is that of any scan: its lit readings tell the lamp's current, its spectra are at several integration
//! times and with the baffle in the path. What a certificate does not cover is refused with the evidence.

mod conditions;
mod covariance;
mod error;
mod interpolation;
mod luxmeter;
mod procedure;
mod spectroradiometer;

pub use conditions::{Calibrated, Conditions, Stated, stated};
pub use covariance::Component;
pub use error::CalibrationError;
pub use interpolation::Interpolation;
pub use luxmeter::{LuxFactor, luxmeter};
pub use spectroradiometer::{Colour, Drift, SpectralFactors, spectroradiometer};

/// Distance of a calibration over that of the certificate, and the inverse of it, at most. Lamps of type FEL leave the
/// inverse square law between 50 cm and 150 cm (Yoon et al., Proc. SPIE 8510, 2012).
pub const DISTANCE_RATIO_MAX: f64 = 1.25;

/// Rates at two integration times may differ by this much, relative, beside their noise and the lamp's drift.
pub const LINEARITY_MAX_REL: f64 = 0.003;

/// Relative change of a filament's temperature for one of its current: T ∝ I^0.7. Of incandescent lamps T ∝ V^0.37 and
/// I ∝ V^0.54 (exponents of the IES Lighting Handbook).
pub const TEMPERATURE_OVER_CURRENT: f64 = 0.7;

/// Share of the light behind the baffle that may be wrong, half width: a baffle hides a part of what is scattered.
pub const STRAY_HALF_WIDTH: f64 = 0.5;
