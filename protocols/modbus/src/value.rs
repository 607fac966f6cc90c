//! Numbers in registers.

use std::fmt;

/// Type of a number.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum NumberType {
    /// One register, unsigned.
    U16,
    /// One register, two's complement.
    I16,
    /// Two registers, unsigned.
    U32,
    /// Two registers, two's complement.
    I32,
    /// Two registers, IEEE 754 single precision.
    F32,
}

/// Which of two registers comes first. Within a register the high byte does, always (AP 4.2).
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum WordOrder {
    /// The upper word has the lower address.
    HighFirst,
    /// The lower word has the lower address.
    LowFirst,
}

/// How a number lies in registers.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Encoding {
    /// Its type.
    pub number: NumberType,
    /// Order of its two registers; of no meaning for 16 bits.
    pub order: WordOrder,
}

impl NumberType {
    /// Registers that it takes.
    pub const fn registers(self) -> u16 {
        match self {
            Self::U16 | Self::I16 => 1,
            Self::U32 | Self::I32 | Self::F32 => 2,
        }
    }
}

impl fmt::Display for NumberType {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::U16 => "u16",
            Self::I16 => "i16",
            Self::U32 => "u32",
            Self::I32 => "i32",
            Self::F32 => "f32",
        })
    }
}

impl Encoding {
    /// The number, exactly: every type fits into a double. A float may be NaN or infinite. None if `words` are not as
    /// many as the type takes.
    pub fn decode(self, words: &[u16]) -> Option<f64> {
        let long = |words: &[u16; 2]| {
            let [first, second] = words.map(u32::from);
            match self.order {
                WordOrder::HighFirst => first << 16 | second,
                WordOrder::LowFirst => second << 16 | first,
            }
        };
        match (self.number, words) {
            (NumberType::U16, [word]) => Some(f64::from(*word)),
            (NumberType::I16, [word]) => Some(f64::from(*word as i16)),
            (NumberType::U32, [a, b]) => Some(f64::from(long(&[*a, *b]))),
            (NumberType::I32, [a, b]) => Some(f64::from(long(&[*a, *b]) as i32)),
            (NumberType::F32, [a, b]) => Some(f64::from(f32::from_bits(long(&[*a, *b])))),
            _ => None,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn each_type_in_each_order() {
        use NumberType::{F32, I16, I32, U16, U32};
        use WordOrder::{HighFirst, LowFirst};
        for (number, order, words, value) in [
            (U16, HighFirst, &[0xFFFF][..], 65_535.0),
            (I16, LowFirst, &[0xFFFF], -1.0),
            // The RS-485 transmitter of the golden frame: 132854 lx.
            (U32, HighFirst, &[0x0002, 0x06F6], 132_854.0),
            (U32, LowFirst, &[0x06F6, 0x0002], 132_854.0),
            (U32, HighFirst, &[0xFFFF, 0xFFFF], 4_294_967_295.0),
            // Oriental Motor's golden frame: −1000.
            (I32, HighFirst, &[0xFFFF, 0xFC18], -1000.0),
            // 230.0 and 0.1834 as IEEE 754 singles.
            (F32, HighFirst, &[0x4366, 0x0000], 230.0),
            (F32, LowFirst, &[0xCD36, 0x3E3B], f64::from(0.1834_f32)),
        ] {
            assert_eq!(
                Encoding { number, order }.decode(words),
                Some(value),
                "{number} {words:X?}"
            );
        }
        let nan = Encoding {
            number: F32,
            order: HighFirst,
        };
        assert!(nan.decode(&[0x7FC0, 0]).is_some_and(f64::is_nan));
        assert_eq!(nan.decode(&[0]), None);
        assert_eq!(nan.decode(&[0, 0, 0]), None);
    }

    proptest! {
        #[test]
        fn the_order_is_the_only_difference(a: u16, b: u16) {
            for number in [NumberType::U32, NumberType::I32, NumberType::F32] {
                let [high, low] = [WordOrder::HighFirst, WordOrder::LowFirst].map(|order| Encoding { number, order });
                let bits = |value: Option<f64>| value.map(f64::to_bits);
                prop_assert_eq!(bits(high.decode(&[a, b])), bits(low.decode(&[b, a])));
            }
        }
    }
}
