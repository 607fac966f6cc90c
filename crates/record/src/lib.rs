//! The documents of a bench: station, plan, job, the run directory with its append-only readings, observations.
//!
//! Everything here is data on disk and its validation. Nothing here asks a clock: whoever writes a record says when.

pub mod bounds;
pub mod conditions;
pub mod disk;
mod distance_class;
pub mod event;
pub mod filter;
pub mod job;
pub mod key;
pub mod layout;
pub mod light_modulation;
pub mod limits;
pub mod lines;
pub mod observation;
pub mod own_clock;
pub mod plan;
pub mod rated;
pub mod reading;
pub mod readings;
pub mod requirements;
pub mod responsivity;
mod row_crc;
pub mod run;
mod run_lock;
pub mod spectra;
pub mod standard;
pub mod station;
pub mod steadiness;
pub mod subject;
pub mod sweeps;
mod table;

pub use bounds::Bounds;
pub use conditions::Conditions;
pub use distance_class::{DistanceClass, apart_from_mm, seen_under_deg};
pub use event::{BenchState, Event, Logged};
pub use isolux_document::{self as document, DocumentError, file};
pub use job::Job;
pub use layout::{Language, Layout};
pub use light_modulation::LightModulation;
pub use limits::Limits;
pub use plan::Plan;
pub use reading::{Electrical, Quality, Reading, ReadingKind, Role, UnknownWord};
pub use requirements::{DecisionRule, Requirements};
pub use run::{Run, RunDir, RunError, RunHeader};
pub use run_lock::{RunLock, RunLockError};
pub use standard::{Standard, StandardError};
pub use station::Station;
pub use subject::Subject;
