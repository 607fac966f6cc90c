//! Drivers of axes on scripted instruments.

mod ascii;
mod oriental;
mod zaber;
