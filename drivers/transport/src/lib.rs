//! Byte links and who owns them.
//!
//! A link is `AsyncRead + AsyncWrite`: a serial port or pty, a TCP connection, or a pipe inside the process. [`Links`]
//! opens one by its address; [`SystemLinks`] is the real thing, for one process at a time, [`MemoryLinks`] the pipes that twins listen on,
//! [`Recorder`] writes every byte of any of them to a trace, and a [`Trace`] plays one back. [`Bus`] is the one task
//! that owns a link: callers send it requests, and a conversation (the codec) decides which bytes answer which request.

mod bus;
mod link;
mod memory;
mod owner;
mod record;
mod replay;
mod system;
mod usb;
mod users;

pub use bus::{Bus, BusError, Conversation, Outcome};
pub use link::{LineSettings, Link, LinkError, Links, Parity};
pub use memory::{MemoryLinks, MemoryListener, NameTaken};
pub use owner::{lock_files, port_holder};
pub use record::Recorder;
pub use replay::{Direction, Passage, Trace, TraceError};
pub use system::{FoundPort, PortState, SystemLinks, found_ports};
pub use usb::{UsbDevice, usb_devices};
