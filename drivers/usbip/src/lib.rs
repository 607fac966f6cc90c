//! USB devices over USB/IP, for twins of instruments whose link is USB.
//!
//! A twin speaks on a byte stream; this crate makes a USB device of it: descriptors, control requests, bulk endpoints
//! with pending reads (NAK), short packets, overflow, stalls and unlinked requests. A kernel with `vhci-hcd` attaches
//! it as if it were plugged in; the project's own test bridge gives it to libusb where there is no kernel for it.
//!
//! Sources: the kernel's Documentation/usb/usbip_protocol.rst; USB 2.0, chapters 5.8 (bulk), 8.5 (packets), 9.4
//! (requests). The crates for this on crates.io answer a read of an empty endpoint with nothing instead of waiting.

mod control;
mod device;
mod model;
mod server;
mod wire;

pub use model::{Model, Packing, Speed};
pub use server::{Bench, Twin};
