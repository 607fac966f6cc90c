//! The language of the Gigahertz-Optik P-9710 optometer as a sans-IO codec: no clock, no I/O.
//!
//! 9600 baud, 8N1, mode "Remote RS232". Several commands may stand in one line; LF ends it, and LF ends the one line
//! that answers it. What stands between two commands with an answer (`,` `;` blank or tab) stands between the answers.
//! [`P9710`] separates the three commands of a measurement in sixteen ways by turns, so that an answer to one of the
//! last fifteen requests is told from the one that is due. An error (`?16`) carries no such mark. Source:
//! Gigahertz-Optik, "P-9710 Operating Manual" V1.20, chapter 15.

mod language;
mod measurement;

pub use language::{Answer, P9710, Range, Request};
pub use measurement::{ErrorCode, Measurement, RANGES};
