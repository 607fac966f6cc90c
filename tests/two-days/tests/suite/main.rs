//! A few cases of the two days.

mod orders;
mod spectra;
mod workflow;
