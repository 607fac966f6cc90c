//! Fuzz targets: every codec and every file reader, as functions of bytes that must never panic.
//!
//! `fuzz/` at the root of the project hands them to `cargo fuzz` (nightly); `tests/damaged.rs` drives each with damaged
//! copies of its seeds on stable.

mod codecs;
mod readers;

/// One thing that reads bytes of strangers.
#[derive(Debug, Clone, Copy)]
pub struct Target {
    /// As `cargo fuzz run` names it.
    pub name: &'static str,
    /// Reads the bytes; panics where the code under test is wrong.
    pub run: fn(&[u8]),
    /// Good input to start from.
    pub seeds: fn() -> Vec<Vec<u8>>,
}

/// All of them.
pub fn targets() -> impl Iterator<Item = &'static Target> {
    codecs::TARGETS.iter().chain(readers::TARGETS)
}

/// The target of this name.
///
/// # Panics
/// If there is none: a mistake in `fuzz/`.
pub fn run(name: &str, data: &[u8]) {
    let target = targets().find(|target| target.name == name);
    (target.unwrap_or_else(|| panic!("no target {name}")).run)(data);
}
