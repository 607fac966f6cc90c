//! Use cases of `isolux`, shared by the command line and the local page.
//!
//! A front end calls one function a command, hands it a [`front_end::progress::Progress`] and prints what comes back.
//! Nothing here writes to a terminal; nothing in a front end holds physics.
//!
//! Each folder is a topic: [`instruments`] of a station, [`manual`] steps, a [`scan`], the [`run`] directory that it
//! leaves, a [`calibration`] with a standard lamp and the [`history`] of those and of days, whether a run
//! [still is](verify) what was recorded, [`formats`] of files, what is [compared](compare), [`modulation`] of light,
//! [`simulation`], [`diagnosis`], the whole [`day`], a [`study`] of a run on the page. [`init`] writes the files to
//! start from and [`darkroom`] serves the virtual instruments; [`front_end`] and [`system`] are what the rest reports
//! to and runs on.

pub mod calibration;
pub mod compare;
pub mod darkroom;
pub mod day;
pub mod diagnosis;
pub mod failure;
pub mod files;
pub mod formats;
pub mod front_end;
pub mod history;
pub mod init;
pub mod instruments;
pub mod manual;
pub mod modulation;
pub mod run;
pub mod scan;
pub mod simulation;
pub mod study;
pub mod system;
pub mod verify;

pub use failure::{Failure, FailureKind};

/// What a browser draws with, in reports and on the local page alike.
pub mod drawing {
    pub use isolux_report::plots::{PolarSoFar, polar_so_far};
    pub use isolux_report::viewer::{MAP, STAGE, STYLE, THREE};
}
