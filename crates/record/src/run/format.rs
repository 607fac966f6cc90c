//! The formats of a run.

/// Value of `format` in run.toml.
pub const FORMAT: &str = "isolux-run/4";

/// The format before: readings with the time since the lamp was switched on, and none on the axis of the run.
pub const FORMAT_3: &str = "isolux-run/3";
