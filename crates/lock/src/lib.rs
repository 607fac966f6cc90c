//! One owner at a time, across processes: a locked file that names who holds it.
//!
//! [`Lock`] is a lock of the operating system on a file, so a process that dies frees it. The file says who holds it
//! ([`Holder`]), and its modification time says when the holder last gave a sign of life. A lock can be taken over from
//! a process that no longer answers: the file is replaced by another, and the former owner finds by [`Lock::is_ours`]
//! that what stands at the path is not the file that it has locked. It must then touch nothing any more.

mod holder;
mod lock;
mod place;
#[cfg_attr(unix, path = "system/unix.rs")]
#[cfg_attr(windows, path = "system/windows.rs")]
mod system;

pub use holder::{Holder, ProcessState};
pub use lock::{Held, Lock, LockError, SILENT_AFTER};
pub use place::{file_name, shared_folder};
