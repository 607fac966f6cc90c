//! Where simulation and measurement disagree, which physical effect is missing, how sure that is, and what to measure
//! next.

pub mod alternatives;
pub mod assumed;
pub mod basis;
pub mod calibration;
pub mod diagnosis;
pub mod dictionary;
pub mod document;
pub mod evidence;
pub mod fit;
pub mod forward;
pub mod heads;
pub mod held_out;
pub mod known;
pub mod next;
pub mod noise;
pub mod observe;
pub mod on_axis;
pub mod overlap;
pub mod own_readings;
mod patterns;
pub mod read_out;
pub mod reference;
pub mod rounding;
pub mod scan;
pub mod search;
pub mod shrinkage;
pub mod steps;
pub mod table;
pub mod whitener;
pub mod whitening;
