//! Byte links and who owns them.
//!
//! A link is `AsyncRead + AsyncWrite`: a serial port or pty, a TCP connection, or a pipe inside the process. [`Links`]
//! opens one by its address; [`SystemLinks`] is the real thing, for one process at a time, [`MemoryLinks`] the pipes
//! that twins listen on, [`Recorder`] writes every byte of any of them to a trace, and a [`Trace`] plays one back.
//! [`Ports`] opens each address once a session and gives every device on it a [`Bus`]: a handle on the one task that
//! owns the link, to which callers send requests, and where a conversation (the codec) decides which bytes answer which
//! request. [`Driver`] is what a driver says of itself to the catalogue.

mod bus;
mod driver;
mod exchange;
mod link;
mod memory;
mod owner;
mod port;
mod ports;
mod probe;
mod record;
mod replay;
mod serial;
mod system;
mod usb;
mod users;

pub use bus::{Bus, ExclusiveAccess, TRIES};
pub use driver::{Driver, Place, UsbModel, no_display};
pub use exchange::{BusError, Exchanged, worth_another_try};
pub use link::{LineSettings, Link, LinkError, Links, Parity};
pub use memory::{MemoryLinks, MemoryListener, NameTaken};
pub use owner::{lock_files, port_holder, things};
pub use ports::{Ports, conflict};
pub use probe::{Probe, printable};
pub use record::Recorder;
pub use replay::{Direction, Passage, Trace, TraceError};
pub use system::{FoundPort, PortState, SystemLinks, found_ports};
pub use usb::{FoundUsb, UsbAccess, UsbAddress, UsbDevice, UsbFraming, UsbId, UsbProfile, find_usb, usb_devices};
