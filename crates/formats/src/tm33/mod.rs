//! TM-33-18 (ATLA S001, UNI 11733) and TM-33-23.
//!
//! Read after the published schema of ATLA S001 and after samples of TM-33-23 (root `IESTM33-22`); the standards
//! themselves are not free, so writing TM-33-23 is marked experimental.

mod read;
mod table;
mod write;

pub use read::{looks_like, read};
pub(crate) use write::decimal;
pub use write::{Edition, write};
