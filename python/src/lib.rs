//! The native half of the Python package `isolux`: one module a topic of `isolux-app`, and nothing that computes.
//!
//! What the classes mean, with shapes and units, stands in `isolux/_isolux.pyi` as well, where editors read it.

mod arrays;
mod bench;
mod document;
mod error;
mod program;
mod wait;

use pyo3::prelude::*;

/// The native module.
#[pymodule]
mod _isolux {
    #[pymodule_export]
    use crate::bench::{
        Bench, LuxReading, Position, Scan, ScanEvent, ScanSummary, SpectrumReading, WarmedUp, begin_folder,
        close_benches,
    };
    #[pymodule_export]
    use crate::program::run_program;

    /// The version of the program, which is that of the package.
    #[pymodule_export]
    #[expect(non_upper_case_globals, reason = "its name in Python")]
    const __version__: &str = env!("CARGO_PKG_VERSION");
}
