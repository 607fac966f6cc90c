#![doc = include_str!("../README.md")]
//!
//! A [`Model`] is a [`Luminaire`] (intensity distribution, emitter, spectrum) and a list of [`Effect`]s. The same list,
//! through the same code, predicts a goniometer reading ([`Model::predict_readings`]), the pixels of a sensor map
//! ([`Model::predict_maps`]) and a spectrum ([`Model::predict_spectra`]); each effect acts where it belongs.
//!
//! Frames: luminaire with the light centre at the origin, d(C, γ) = (sin γ cos C, sin γ sin C, cos γ); lengths in mm.

mod angle_table;
mod attitude;
mod bench;
mod colour;
mod direction_noise;
mod document;
mod effect;
pub mod effects;
mod emitter;
mod far_field;
mod floor;
mod known;
mod lobe;
mod luminaire;
mod map;
mod memory;
mod model;
pub mod optics;
mod photometric_file;
mod pose;
mod prepared;
mod quadrature;
mod reader;
mod refined;
mod scene;
mod sector;
mod smoothed_spectrum;
mod spectrum;

pub use bench::{CorrectedReading, NoInverse};
pub use colour::{ColourError, ColourOverAngle};
pub use direction_noise::DirectionError;
pub use document::{Accuracy, ShapeTrust, SpectrumUncertainty, Trust, Uncertainty, UncertaintyScale};
pub use effect::{Effect, EffectError};
pub use effects::{BelongsTo, EffectSpec, ParameterSpec, Role, Sampling, Stage, catalogue, digits};
pub use emitter::{Emitter, EmitterError, Node};
pub use known::{KnownError, SpectrumError, luminous_area_rel};
pub use lobe::Lobe;
pub use luminaire::{Interpolation, Luminaire, Spectral};
pub use model::{InSimulation, Model};
pub use photometric_file::{PhotometricFileError, read_distribution, read_spectrum};
pub use pose::SensorPose;
pub use quadrature::gauss_legendre;
pub use refined::{Harmonic, Refined};
pub use scene::{Scene, Sensor};
pub use sector::Sectors;
pub use spectrum::NoSpectrum;
