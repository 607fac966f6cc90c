//! The physics of the virtual darkroom, and the truth that its twins report.
//!
//! One [`Room`] is built from one document ([`Darkroom`], the file `darkroom.toml`). It answers what a lux meter, a
//! spectrometer or a camera in that room would see, by adding up individual LEDs (or the parts of a luminous
//! disc with a table), floor patches and rotation matrices.
//! It shares no physics with the operator's model, so that an agreement between the two means something.
//!
//! Everything here is a pure function of the document and of the coordinates asked for. Noise is drawn by counter:
//! reading number k has the same noise whatever was read before it.

pub mod built_in;
pub mod camera;
pub mod certificate;
pub mod climate;
pub mod document;
pub mod electrical;
pub mod far_field;
mod fault;
pub mod filament;
pub mod floor;
pub mod head;
pub mod illuminator;
pub mod injected_effects;
mod lines;
pub mod meter;
pub mod motion;
pub mod mount;
pub mod noise;
pub mod optics;
pub mod output;
pub mod parts;
mod pixel;
pub mod room;
mod rules;
pub mod spectrograph;
pub mod spectrum;
pub mod table;

pub use built_in::{BUILT_IN, Completed};
pub use camera::{Capture, MapPose, SensorFrame};
pub use document::Darkroom;
pub use fault::{Fault, FaultKind, Instrument};
pub use injected_effects::InjectedEffects;
pub use room::{Kind, Observation, Room};
pub use table::LampTable;
