//! Twins of the instruments: each answers the real bytes of its instrument from the truth of one virtual room.
//!
//! [`VirtualRoom`] is the room with its switches, axes and clock. [`VirtualRoom::listen`] serves its instruments on
//! pipes inside the process: on a runtime whose clock is paused a day of hours takes seconds. [`outlet`] serves them on
//! a pty or over TCP for other programs. [`twins`] is the table of twins. They share no codec with the drivers, so that
//! both must be right.

pub mod fault;
mod modbus;
pub mod outlet;
mod scpi;
mod server;
pub mod station;
mod twin;
pub mod twins;
pub mod usb;
mod world;

pub use isolux_darkroom::BUILT_IN;
pub use isolux_darkroom::Instrument;
pub use server::{Serving, VirtualRoom};
pub use world::{AxisName, Switches, World};
