//! Files read and written: whole ones, damaged ones, and those of other programs.

mod coordinates;
mod damage;
mod edits;
mod gldf;
mod openings;
mod photometric;
mod ratings;
mod spectral;
