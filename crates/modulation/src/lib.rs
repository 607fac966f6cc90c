//! Temporal light modulation: from the samples of a photodiode to modulation depth, flicker index, SVM and PstLM, and
//! to what a camera sees.
//!
//! A pure function of a [`Waveform`]: no file, no clock. Every number is a [`Quantity`] with the parts of its
//! uncertainty: the noise of the record, which is estimated from it, its sampling, and its own variation.

mod bands;
mod camera;
mod csv;
mod cycle;
mod error;
mod evaluate;
mod filter;
mod harmonics;
mod noise;
mod pst;
mod recorded;
mod roots;
mod svm;
mod transform;
mod wav;
mod waveform;
mod window;

pub use camera::{Banding, Exposed};
pub use error::WaveformError;
pub use evaluate::{Camera, Given, Modulation, evaluate};
pub use isolux_reduce::Quantity;
pub use svm::threshold;
pub use waveform::{Form, Source, Waveform};
