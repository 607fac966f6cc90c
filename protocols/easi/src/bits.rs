//! Status words: 32 bits, written as `0000_0000_…` with bit 1 leftmost.

use std::fmt;

/// A status word.
#[derive(Clone, Copy, PartialEq, Eq, Default)]
pub struct Bits(u32);

/// Not a status word.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error("\"{0}\" is no word of 32 bits in eight groups of four")]
pub struct NotBits(String);

impl Bits {
    /// Reads what stands after the asterisk of a report.
    ///
    /// # Errors
    /// [`NotBits`] for anything but eight groups of four digits 0 or 1.
    pub fn parse(text: &str) -> Result<Self, NotBits> {
        let wrong = || NotBits(text.to_owned());
        let groups: Vec<&str> = text.split('_').collect();
        if groups.len() != 8 || groups.iter().any(|group| group.len() != 4) {
            return Err(wrong());
        }
        let digits = groups.concat();
        if !digits.bytes().all(|byte| byte == b'0' || byte == b'1') {
            return Err(wrong());
        }
        u32::from_str_radix(&digits, 2).map(Self).map_err(|_| wrong())
    }

    /// Whether bit `number` is set, counted as the manual does: 1 is the leftmost, 32 the rightmost.
    pub const fn has(self, number: u32) -> bool {
        number >= 1 && number <= 32 && self.0 & (1 << (32 - number)) != 0
    }

    /// No bit at all.
    pub const fn is_empty(self) -> bool {
        self.0 == 0
    }

    /// The numbers of the bits that are set, rising.
    pub fn numbers(self) -> impl Iterator<Item = u32> {
        (1..=32).filter(move |number| self.has(*number))
    }
}

impl fmt::Debug for Bits {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "bits {:?}", self.numbers().collect::<Vec<_>>())
    }
}

/// Bits of ST, table 4-3.
pub mod status {
    /// Command processing is paused.
    pub const PAUSED: u32 = 1;
    /// A program of the drive is running.
    pub const PROGRAM: u32 = 4;
    /// Going home.
    pub const HOMING: u32 = 5;
    /// The motor has current.
    pub const ENERGISED: u32 = 9;
    /// The negative limit was seen during the last move.
    pub const NEGATIVE_LIMIT: u32 = 13;
    /// The positive limit was seen during the last move.
    pub const POSITIVE_LIMIT: u32 = 14;
    /// In motion.
    pub const MOVING: u32 = 19;
    /// Stationary, in position.
    pub const STATIONARY: u32 = 20;
}

/// What bit `number` of UF means, table 4-5.
pub const fn user_fault(number: u32) -> &'static str {
    match number {
        1 => "value is out of range",
        2 => "incorrect command syntax",
        3 => "last label already in use",
        4 => "label of this name not defined",
        5 => "missing Z pulse when homing",
        6 => "homing failed, no signal detected",
        7 => "home signal too narrow",
        8 => "drive de-energised",
        9 => "cannot relate END statement to a label",
        10 => "program memory buffer full",
        11 => "no more motion profiles available",
        12 => "no more sequence labels available",
        13 => "end of travel limit hit",
        14 => "still moving",
        15 => "deceleration error",
        16 => "transmit buffer overflow",
        17 => "user program nesting overflow",
        18 => "cannot use an undefined profile",
        19 => "drive not ready",
        22 => "save error",
        23 => "command not supported by this product",
        _ => "reserved",
    }
}

/// What bit `number` of DF means, table 4-4.
pub const fn drive_fault(number: u32) -> &'static str {
    match number {
        1 => "composite fault",
        2 => "output stage over current",
        3 => "supply rail failure",
        4 => "ambient over temperature",
        5 => "drive over temperature",
        6 => "configuration error",
        7 => "motor high voltage rail failure",
        8 => "output fault",
        _ => "reserved",
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_leftmost_bit_is_number_1() {
        let bits = Bits::parse("0000_0000_1000_0000_0001_0000_0000_0000").unwrap();
        assert_eq!(
            bits.numbers().collect::<Vec<_>>(),
            [status::ENERGISED, status::STATIONARY]
        );
        assert!(Bits::parse("1000_0000_0000_0000_0000_0000_0000_0001").unwrap().has(32));
        assert!(!bits.has(0) && !bits.has(33));
        for wrong in [
            "",
            "0000_0000_1000_0000_0001_0000_0000",
            "0000_0000_1000_0000_0001_0000_0000_0002",
            "00000000_10000000_00010000_00000000",
            "0000_0000_1000_0000_0001_0000_0000_000",
        ] {
            assert!(Bits::parse(wrong).is_err(), "{wrong}");
        }
    }
}
