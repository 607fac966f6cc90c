//! Angles of the C-γ system and of the axes that realise it.

use serde::{Deserialize, Serialize};

use crate::quantity::{NotFinite, quantity};

quantity!(
    /// An angle or a difference of angles in degrees.
    Degrees, "°"
);
quantity!(
    /// The position of a motor axis in degrees. Never wraps: 360° and 0° differ by a turn of cable.
    AxisAngle, "°"
);

/// Azimuth of a C half-plane, in [0°, 360°).
#[derive(Debug, Clone, Copy, PartialEq, PartialOrd, Serialize, Deserialize)]
#[serde(try_from = "f64", into = "f64")]
pub struct CPlane(f64);

impl CPlane {
    /// The half-plane at `degrees`, wrapped into [0°, 360°).
    ///
    /// # Errors
    /// [`NotFinite`] for NaN and ±∞.
    pub fn new(degrees: f64) -> Result<Self, NotFinite> {
        if !degrees.is_finite() {
            return Err(NotFinite {
                value: degrees,
                unit: "°",
            });
        }
        // rem_euclid of a tiny negative number rounds up to 360 itself.
        let wrapped = degrees.rem_euclid(360.0);
        Ok(Self(if wrapped >= 360.0 { 0.0 } else { wrapped }))
    }

    /// The azimuth in degrees, in [0, 360).
    pub const fn degrees(self) -> f64 {
        self.0
    }

    /// The half-plane that continues this one beyond γ = 0, C + 180°.
    #[must_use]
    pub fn opposite(self) -> Self {
        Self(if self.0 >= 180.0 {
            self.0 - 180.0
        } else {
            self.0 + 180.0
        })
    }
}

/// A γ outside [−180°, 180°].
#[derive(Debug, Clone, Copy, PartialEq, thiserror::Error)]
#[error("γ = {degrees}° is outside −180°…180°")]
pub struct GammaOutOfRange {
    /// The offending angle.
    pub degrees: f64,
}

/// Polar angle γ from the luminaire's axis, signed: (C, −γ) is (C + 180°, γ).
#[derive(Debug, Clone, Copy, PartialEq, PartialOrd, Serialize, Deserialize)]
#[serde(try_from = "f64", into = "f64")]
pub struct Gamma(f64);

impl Gamma {
    /// The angle at `degrees`.
    ///
    /// # Errors
    /// [`GammaOutOfRange`] outside [−180°, 180°] and for NaN: γ does not wrap.
    pub fn new(degrees: f64) -> Result<Self, GammaOutOfRange> {
        if (-180.0..=180.0).contains(&degrees) {
            Ok(Self(degrees))
        } else {
            Err(GammaOutOfRange { degrees })
        }
    }

    /// The angle in degrees, in [−180, 180].
    pub const fn degrees(self) -> f64 {
        self.0
    }

    /// The same direction with γ ≥ 0.
    #[must_use]
    pub fn unsigned(self, c: CPlane) -> (CPlane, Self) {
        if self.0 < 0.0 {
            (c.opposite(), Self(-self.0))
        } else {
            (c, self)
        }
    }
}

macro_rules! angle_as_number {
    ($name:ident, $error:ty) => {
        impl TryFrom<f64> for $name {
            type Error = $error;
            fn try_from(degrees: f64) -> Result<Self, $error> {
                Self::new(degrees)
            }
        }
        impl From<$name> for f64 {
            fn from(angle: $name) -> f64 {
                angle.0
            }
        }
        impl std::fmt::Display for $name {
            fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
                write!(f, "{}°", self.0)
            }
        }
    };
}
angle_as_number!(CPlane, NotFinite);
angle_as_number!(Gamma, GammaOutOfRange);

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn c_wraps_gamma_does_not() {
        assert_eq!(CPlane::new(360.0).unwrap().degrees(), 0.0);
        assert_eq!(CPlane::new(-90.0).unwrap().degrees(), 270.0);
        assert_eq!(CPlane::new(-1e-300).unwrap().degrees(), 0.0);
        assert!(Gamma::new(180.1).is_err());
        assert!(Gamma::new(f64::NAN).is_err());
        let (c, gamma) = Gamma::new(-30.0).unwrap().unsigned(CPlane::new(15.0).unwrap());
        assert_eq!((c.degrees(), gamma.degrees()), (195.0, 30.0));
    }

    proptest! {
        #[test]
        fn every_azimuth_lands_in_the_circle(degrees in -1e9..1e9f64) {
            let c = CPlane::new(degrees).unwrap();
            prop_assert!((0.0..360.0).contains(&c.degrees()));
            prop_assert!((c.opposite().opposite().degrees() - c.degrees()).abs() < 1e-9);
        }
    }
}
