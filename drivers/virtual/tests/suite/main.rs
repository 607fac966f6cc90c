//! Twins with the drivers that read them.

mod axis_faults;
mod man_in_the_middle;
mod oscilloscope;
mod parker;
mod with_drivers;
