//! The language of the Gossen MAVO-USB illuminance meters (MAVOLUX 5032) as a sans-IO codec: no clock, no I/O.
//!
//! 9600 baud, 7E2. A command has 32 characters at most, its LF included; one request, one line. With the echo on, an
//! answer repeats the header of its request as it was written, in capitals. Long forms may be cut anywhere after their
//! short form (`PHO?` to `PHOTOMETRIC?` all measure), so [`Mavo`] writes the request for a measurement in nine ways by
//! turns, and an answer to one of the last eight requests is told from the one that is due. An error (`ERROR = nnn`)
//! has no echo. Source: Gossen, "Interface description MAVO-USB", 1.1/02.18.

mod language;
mod measurement;

pub use language::{Answer, Mavo, Request};
pub use measurement::{ErrorCode, Measurement, NotAMeasurement};
