//! The virtual darkroom for other programs: its instruments as a process to talk to, its camera as files.

pub mod capture;
pub mod twins;
