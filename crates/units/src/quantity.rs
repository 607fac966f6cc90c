//! Scalar quantities, one type a meaning.

/// A number that was to become a quantity is NaN or infinite.
#[derive(Debug, Clone, Copy, PartialEq, thiserror::Error)]
#[error("{value} is not a finite number of {unit}")]
pub struct NotFinite {
    /// The offending number.
    pub value: f64,
    /// The unit that it was to carry.
    pub unit: &'static str,
}

macro_rules! quantity {
    ($(#[$doc:meta])* $name:ident, $unit:literal) => {
        $(#[$doc])*
        #[derive(Debug, Clone, Copy, PartialEq, PartialOrd)]
        pub struct $name(f64);

        impl $name {
            /// The unit's symbol.
            pub const UNIT: &'static str = $unit;

            /// The quantity from its number, in the type's unit.
            ///
            /// # Errors
            /// [`NotFinite`] for NaN and ±∞.
            pub fn new(value: f64) -> Result<Self, NotFinite> {
                if value.is_finite() { Ok(Self(value)) } else { Err(NotFinite { value, unit: $unit }) }
            }

            /// The number, in the type's unit.
            pub const fn value(self) -> f64 {
                self.0
            }
        }

        impl TryFrom<f64> for $name {
            type Error = NotFinite;
            fn try_from(value: f64) -> Result<Self, NotFinite> {
                Self::new(value)
            }
        }

        impl From<$name> for f64 {
            fn from(quantity: $name) -> f64 {
                quantity.0
            }
        }

        impl std::fmt::Display for $name {
            fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
                std::fmt::Display::fmt(&self.0, f)?;
                f.write_str(concat!(" ", $unit))
            }
        }
    };
}

quantity!(
    /// Illuminance in lux (lm/m²). May be negative: a dark-subtracted reading.
    Lux, "lx"
);
quantity!(
    /// Length in millimetre.
    Millimetre, "mm"
);
quantity!(
    /// Temperature in degrees Celsius.
    Celsius, "°C"
);

quantity!(
    /// The position of a motor axis in degrees. Never wraps: 360° and 0° differ by a turn of cable.
    AxisAngle, "°"
);

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn refuses_what_is_not_a_number_and_keeps_negative_readings() {
        assert!(Lux::new(f64::NAN).is_err());
        assert_eq!(
            Lux::new(f64::INFINITY),
            Err(NotFinite {
                value: f64::INFINITY,
                unit: "lx"
            })
        );
        assert_eq!(Lux::new(-0.02).map(Lux::value), Ok(-0.02));
        assert_eq!(Lux::new(3.4).unwrap().to_string(), "3.4 lx");
    }
}
