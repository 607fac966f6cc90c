//! Scalar quantities, one type a meaning.

use serde::{Deserialize, Serialize};

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
        #[derive(Debug, Clone, Copy, PartialEq, PartialOrd, Serialize, Deserialize)]
        #[serde(try_from = "f64", into = "f64")]
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

pub(crate) use quantity;

quantity!(
    /// Illuminance in lux (lm/m²). May be negative: a dark-subtracted reading.
    Lux, "lx"
);
quantity!(
    /// Luminous intensity in candela (lm/sr).
    Candela, "cd"
);
quantity!(
    /// Luminous intensity per kilolumen of lamp flux, the unit of EULUMDAT.
    CandelaPerKilolumen, "cd/klm"
);
quantity!(
    /// Luminous flux in lumen.
    Lumen, "lm"
);
quantity!(
    /// Irradiance in watt per square metre.
    WattPerSquareMetre, "W/m²"
);
quantity!(
    /// Luminous efficacy of radiation in lumen per watt (not of a lamp's electrical power).
    LumenPerWatt, "lm/W"
);
quantity!(
    /// Length in millimetre.
    Millimetre, "mm"
);
quantity!(
    /// Wavelength in nanometre.
    Nanometre, "nm"
);
quantity!(
    /// Time in seconds.
    Second, "s"
);
quantity!(
    /// Temperature in degrees Celsius.
    Celsius, "°C"
);

impl Lux {
    /// The intensity that makes this illuminance at `distance`, perpendicular to it: I = E·d² (inverse square law,
    /// valid in the far field alone).
    ///
    /// # Errors
    /// [`NotFinite`] when the product overflows.
    pub fn intensity_at(self, distance: Millimetre) -> Result<Candela, NotFinite> {
        let metres = distance.value() * 1e-3;
        Candela::new(self.0 * metres * metres)
    }

    /// The irradiance of light with luminous efficacy of radiation `ler`: E_e = E_v / K.
    ///
    /// # Errors
    /// [`NotFinite`] when `ler` is zero.
    pub fn irradiance(self, ler: LumenPerWatt) -> Result<WattPerSquareMetre, NotFinite> {
        WattPerSquareMetre::new(self.0 / ler.value())
    }
}

impl Candela {
    /// This intensity referred to a lamp flux of 1000 lm.
    ///
    /// # Errors
    /// [`NotFinite`] when the lamp flux is zero.
    pub fn per_kilolumen_of(self, lamp: Lumen) -> Result<CandelaPerKilolumen, NotFinite> {
        CandelaPerKilolumen::new(self.0 * 1000.0 / lamp.value())
    }
}

impl CandelaPerKilolumen {
    /// The absolute intensity with a lamp of `lamp` lumen.
    ///
    /// # Errors
    /// [`NotFinite`] when the product overflows.
    pub fn with_lamp(self, lamp: Lumen) -> Result<Candela, NotFinite> {
        Candela::new(self.0 * lamp.value() / 1000.0)
    }
}

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

    #[test]
    fn the_case_of_the_ring_illuminator() {
        // 337 cd at 10 m give 3.37 lx; 1000 cd/klm of 337 lm are 337 cd.
        let lamp = Lumen::new(337.0).unwrap();
        let peak = CandelaPerKilolumen::new(1000.0).unwrap().with_lamp(lamp).unwrap();
        assert_eq!(peak.value(), 337.0);
        let far = Millimetre::new(10_000.0).unwrap();
        assert_eq!(Lux::new(3.37).unwrap().intensity_at(far).unwrap().value(), 337.0);
        assert_eq!(peak.per_kilolumen_of(lamp).unwrap().value(), 1000.0);
    }
}
