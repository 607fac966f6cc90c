//! Editions of LM-63, and the file generation types of the last.

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

/// LM-63-2019, file generation types: five digits after the point for accredited, interpolated, scaled, simulated,
/// undefined.
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
