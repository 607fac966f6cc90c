//! USB devices without a driver of the kernel: who is there, and a link over the bulk endpoints of one.
//!
//! libusb is compiled in. Every call that waits runs on a thread of its own; no call to libusb's global context is
//! made, since that panics on a computer without USB.

mod address;
mod link;
mod listing;
mod open;
mod profile;

pub use address::{UsbAddress, UsbId};
pub use listing::{UsbAccess, UsbDevice, usb_devices};
pub use open::{FoundUsb, find_usb};
pub use profile::{UsbFraming, UsbProfile};
