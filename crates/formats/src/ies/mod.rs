//! IES LM-63: 1986, 1991, 1995, 2002 and 2019.
//!
//! A version line (none in 1986), keyword or label lines, `TILT=`, then one stream of numbers separated by blanks or
//! commas: ten of lamp and geometry, ballast factor, ballast-lamp photometric factor and watts, vertical angles,
//! horizontal angles, candela plane by plane. Grammar after the published descriptions of Radiance's `ies2rad` and of
//! I. Ashdown's parser; the standard itself is not free.

mod angles;
mod grid;
mod header;
mod layout;
mod own;
mod photometry;
mod preamble;
mod read;
mod scene;
mod shape;
mod write;

use crate::text::Text;

pub use own::OwnLight;
pub use photometry::Photometry;
pub use read::{read, read_beside};
pub use shape::Shape;
pub use write::{Facts, TiltFactors, write, write_as};

/// An edition of LM-63.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Edition {
    /// LM-63-1986: no version line.
    E1986,
    /// LM-63-1991.
    E1991,
    /// LM-63-1995.
    E1995,
    /// LM-63-2002.
    E2002,
    /// LM-63-2019.
    E2019,
}

impl Edition {
    /// The year.
    pub const fn year(self) -> u16 {
        match self {
            Self::E1986 => 1986,
            Self::E1991 => 1991,
            Self::E1995 => 1995,
            Self::E2002 => 2002,
            Self::E2019 => 2019,
        }
    }
}

/// LM-63-2019, file generation types: five digits after the point for accredited, interpolated, scaled, simulated, undefined.
pub const GENERATION_TYPES: [(&str, &str); 10] = [
    ("1.00001", "undefined or older file"),
    ("1.00010", "computer simulation"),
    ("1.00000", "test at an unaccredited laboratory"),
    ("1.00100", "test at an unaccredited laboratory, lumen scaled"),
    ("1.01000", "test at an unaccredited laboratory, interpolated angles"),
    (
        "1.01100",
        "test at an unaccredited laboratory, interpolated angles, lumen scaled",
    ),
    ("1.10000", "test at an accredited laboratory"),
    ("1.10100", "test at an accredited laboratory, lumen scaled"),
    ("1.11000", "test at an accredited laboratory, interpolated angles"),
    (
        "1.11100",
        "test at an accredited laboratory, interpolated angles, lumen scaled",
    ),
];

/// Whether this is LM-63: a version line, or a line that begins with `TILT=` in a file that does not count like EULUMDAT (a
/// luminaire may have such a name).
pub fn looks_like(head: &Text<'_>) -> bool {
    let first = head.line(0).trim_start().to_ascii_uppercase();
    let tilt = || head.lines().any(preamble::is_tilt) && !crate::eulumdat::looks_like(head);
    first.starts_with("IESNA") || first.starts_with("IES:") || tilt()
}
