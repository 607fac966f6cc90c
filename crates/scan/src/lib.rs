//! Plan → points → dry run → run.
//!
//! [`Engine::run`] homes, warms up until the lamp is stable, moves, waits until position *and* reading have settled,
//! reads, records, visits the reference point, and stops the axes on every exit. All waiting is on `tokio::time`, so
//! that hours pass in seconds where the clock is paused; nothing ever sleeps for "long enough".

pub mod awake;
mod bench_state;
pub mod cancel;
mod chosen;
pub mod clock;
mod conversions;
pub mod dark;
pub mod devices;
pub mod distance;
pub mod dry_run;
pub mod electrical;
pub mod engine;
pub mod error;
pub mod itinerary;
pub mod motion;
pub mod observe;
pub mod pause;
mod read_distance;
mod second;
pub mod settle;
pub mod spectrum;
mod sweep_note;
mod sweeps;
pub mod warmup;

#[cfg(test)]
mod testing;

pub use awake::Awake;
pub use cancel::Cancel;
pub use chosen::{Chosen, Known, Next};
pub use devices::{CalibratedSpectro, Devices, Nobody, Operator, OperatorRequest, TwoState};
pub use distance::{Cost, DisplayRange, Distances, distances, distribution_block, lobe_exponent};
pub use dry_run::{DryRun, VisitTime, dry_run, visit_times};
pub use engine::{Engine, ScanSummary};
pub use error::{ScanError, ScanErrorKind};
pub use observe::{Observer, Silent};
pub use pause::Pause;
pub use read_distance::distance_mm;
pub use sweeps::{most_by_own_clock_deg_s, most_deg_s};
