//! A few cases of the two days.

mod spectra;
mod workflow;
