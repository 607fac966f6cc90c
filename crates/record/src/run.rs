//! The run directory: what a bench did, readable after any death of the program that wrote it.

mod dir;
mod error;
mod header;
mod read;
mod vacant;

pub use dir::RunDir;
pub use error::RunError;
pub use header::{
    DeviceRecord, FORMAT, FORMAT_1, FORMAT_2, Resumed, RunHeader, SpectrumEntry, StopHow, Stopped, Written,
};
pub use read::Run;
pub use vacant::vacant;

#[cfg(test)]
mod tests;
