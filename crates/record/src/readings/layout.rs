//! The columns of a readings file, by its format.

use super::columns::{HEADER, NAMES};

/// Which columns a file has.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Layout {
    /// Format 3: no time on the axis of the run, `time_s` counts from the last switching on of the lamp.
    V3,
    /// Format 4.
    #[default]
    V4,
}

impl Layout {
    /// All of them.
    pub(crate) const ALL: [Self; 2] = [Self::V3, Self::V4];

    /// Whether each row has its time on the axis of the run, beside that of the lamp.
    pub const fn has_run_time(self) -> bool {
        matches!(self, Self::V4)
    }

    /// The header row with its line end.
    pub fn header(self) -> String {
        match self {
            Self::V3 => format!("{}\n", HEADER.replace("lamp_s,", "")),
            Self::V4 => format!("{HEADER}\n"),
        }
    }

    /// How many columns a row has, `chain` and `row_crc` among them.
    pub(super) const fn columns(self) -> usize {
        match self {
            Self::V3 => NAMES.len() + 1,
            Self::V4 => NAMES.len() + 2,
        }
    }
}
