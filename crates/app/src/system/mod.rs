//! The process and its computer: signals, sleep, the log.

pub(crate) mod asleep;
pub mod keep_awake;
pub mod log;
pub mod signals;
