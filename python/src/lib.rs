//! The native half of the Python package `isolux`: one module a topic of `isolux-app`, and nothing that computes.
//!
//! What the classes mean, with shapes and units, stands in `isolux/_isolux.pyi` as well, where editors read it.

mod arrays;
mod bench;
mod diagnose;
mod distribution;
mod document;
mod error;
mod path;
mod pictures;
mod program;
mod quantity;
mod read;
mod run;
mod simulate;
mod spectrum;
mod wait;
mod write;

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
    use crate::diagnose::{_diagnose, _predict};
    #[pymodule_export]
    use crate::distribution::Distribution;
    #[pymodule_export]
    use crate::program::run_program;
    #[pymodule_export]
    use crate::quantity::Quantity;
    #[pymodule_export]
    use crate::read::{read, read_all};
    #[pymodule_export]
    use crate::run::{Reduction, Run};
    #[pymodule_export]
    use crate::simulate::{Simulation, simulate};
    #[pymodule_export]
    use crate::spectrum::Spectrum;

    /// The version of the program, which is that of the package.
    #[pymodule_export]
    #[expect(non_upper_case_globals, reason = "its name in Python")]
    const __version__: &str = env!("CARGO_PKG_VERSION");
}
