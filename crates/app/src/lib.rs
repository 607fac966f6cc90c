//! Use cases of `isolux`, shared by the command line and the local page.
//!
//! A front end calls one function a command, hands it a [`progress::Progress`] and prints what comes back. Nothing here
//! writes to a terminal; nothing in a front end holds physics.

pub mod array_files;
mod asleep;
pub mod bench;
pub mod capture;
pub mod catalogue;
pub mod check;
pub mod control;
pub mod convert;
pub mod day;
pub mod devices;
pub mod diagnose;
pub mod dropped;
pub mod failure;
pub mod files;
pub mod folder;
pub mod identify;
pub mod init;
pub mod inspect;
pub mod investigate;
pub mod keep_awake;
pub mod live;
pub mod log;
pub mod manual;
pub mod manual_spectrum;
mod memory;
pub mod operator;
pub mod owner;
pub mod plan;
pub mod plot;
pub mod predict;
pub mod progress;
pub mod record;
pub mod reduce;
pub mod replay;
pub mod rest;
mod roles;
pub mod scan;
pub mod scene;
pub mod sensor_so_far;
pub mod session;
pub mod signals;
pub mod simulate;
pub mod stop;
pub mod study;
pub mod sweep;
pub mod twins;

pub use failure::{Failure, FailureKind};

/// What a browser draws with, in reports and on the local page alike.
pub mod drawing {
    pub use isolux_report::plots::{PolarSoFar, polar_so_far};
    pub use isolux_report::viewer::{MAP, STAGE, STYLE, THREE};
}

/// Findings, reader options and rounded numbers, for front ends.
pub mod formats {
    pub use isolux_formats::spectral::SpectrumFile;
    pub use isolux_formats::{
        Content, Distribution, Finding, Kind, Place, ReadOptions, Severity, WriteOptions, significant,
    };
}
