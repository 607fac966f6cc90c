//! SCPI and the subset of IEEE 488.2 that power meters and supplies use, as a sans-IO codec: no clock, no I/O.
//!
//! One program message, one response line or one block of definite length. The language has no request numbers: whoever
//! reads values with it demands two exchanges that agree. Words and sentinels (`NAN`, 9.91E37, ±9.9E37, `INF`, `----`)
//! are never numbers: see [`Reading`]. Sources: IEEE 488.2-1992, chapters 7 and 8; SCPI-99, sections 7.2.1.4 and 21.8.

mod error_queue;
mod language;
mod reading;

pub use error_queue::{NotAnError, QueuedError};
pub use language::{Answer, Expect, Request, Scpi, Terminator};
pub use reading::Reading;
