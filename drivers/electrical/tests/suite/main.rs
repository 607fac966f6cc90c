//! Drivers of power meters, supplies and oscilloscopes on scripted instruments.

mod scpi;
mod wt300;
