//! Modbus, the client's side, as sans-IO codecs: no clock, no I/O.
//!
//! [`Rtu`] and [`Mbap`] are the same [`Request`]s and [`Reply`]s in two frames: RTU on serial lines and in byte bridges
//! (unit, PDU, CRC), MBAP on TCP (transaction, protocol 0, length, unit, PDU). Functions 01 to 06, 0F and 10h.
//!
//! A reply counts only if its unit, function, length and, for a write, the address and value or count that it repeats
//! are those of the request. RTU has no transaction number: after any failure the line must be silent for longer than
//! the slowest answer, or each late answer would be taken for that of the next request. In MBAP the number decides.
//!
//! Sources: MODBUS Application Protocol Specification V1.1b3 (cited as AP), MODBUS over Serial Line V1.02 (SL), MODBUS
//! Messaging on TCP/IP Implementation Guide V1.0b (TCP).

mod either;
mod mbap;
mod reply;
mod request;
mod rtu;
mod value;

pub use either::Modbus;
pub use mbap::Mbap;
pub use reply::{Data, Exception, Reply};
pub use request::{Ask, NotARequest, Request};
pub use rtu::{Rtu, crc, silent_interval};
pub use value::{Encoding, NumberType, WordOrder};
