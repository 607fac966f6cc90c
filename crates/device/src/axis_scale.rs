//! Steps ⇄ degrees or millimetres, exactly.

use std::fmt::{Debug, Display};

use isolux_units::{AxisAngle, Millimetre, NotFinite};

/// What the position of an axis is: an angle, or a length along a rail. Each kind of axis has its own type, so that no
/// length is taken for an angle, nor printed as one.
pub trait Coordinate: Copy + PartialEq + PartialOrd + Debug + Display + Send + Sync + 'static {
    /// The unit as it follows a number in a message: `°`, ` mm`.
    const UNIT: &'static str;
    /// The keys of the station file for ratio, limits, speed and acceleration.
    const KEYS: [&'static str; 4];

    /// The position at `value`, in the unit.
    ///
    /// # Errors
    /// [`NotFinite`].
    fn at(value: f64) -> Result<Self, NotFinite>;

    /// The number, in the unit.
    fn number(self) -> f64;
}

impl Coordinate for AxisAngle {
    const UNIT: &'static str = "°";
    const KEYS: [&'static str; 4] = ["counts_per_deg", "limit_deg", "speed_deg_s", "accel_deg_s2"];

    fn at(value: f64) -> Result<Self, NotFinite> {
        Self::new(value)
    }

    fn number(self) -> f64 {
        self.value()
    }
}

impl Coordinate for Millimetre {
    const UNIT: &'static str = " mm";
    const KEYS: [&'static str; 4] = ["counts_per_mm", "limit_mm", "speed_mm_s", "accel_mm_s2"];

    fn at(value: f64) -> Result<Self, NotFinite> {
        Self::new(value)
    }

    fn number(self) -> f64 {
        self.value()
    }
}

/// Which way the position grows as the step count grows.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Sense {
    /// More steps, larger position.
    Positive,
    /// More steps, smaller position.
    Negative,
}

impl Sense {
    /// +1 or −1.
    pub const fn sign(self) -> i64 {
        match self {
            Self::Positive => 1,
            Self::Negative => -1,
        }
    }
}

/// Why a scale was refused.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum InvalidScale {
    /// A ratio with a zero in it.
    #[error("{key} = {numerator}/{denominator}: both parts must be at least 1")]
    Ratio {
        /// Key of the station file.
        key: &'static str,
        /// Steps.
        numerator: u32,
        /// Degrees or millimetres.
        denominator: u32,
    },
}

/// The map between an axis' step count and its position: position = zero + sense · steps ÷ (n/d steps per degree or
/// mm).
///
/// The ratio is rational because gears are: 51200 steps a turn are 1280/9 per degree, which no decimal holds. A target
/// is always computed from the absolute position and a position from the absolute count, so nothing can accumulate.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct AxisScale<P = AxisAngle> {
    numerator: u32,
    denominator: u32,
    zero: P,
    sense: Sense,
}

impl<P: Coordinate> AxisScale<P> {
    /// `numerator/denominator` steps per degree or mm; `zero` is the position at step count 0.
    ///
    /// # Errors
    /// [`InvalidScale`] when a part of the ratio is zero.
    pub fn new(numerator: u32, denominator: u32, zero: P, sense: Sense) -> Result<Self, InvalidScale> {
        if numerator == 0 || denominator == 0 {
            return Err(InvalidScale::Ratio {
                key: P::KEYS[0],
                numerator,
                denominator,
            });
        }
        Ok(Self {
            numerator,
            denominator,
            zero,
            sense,
        })
    }

    /// The step count nearest to `place`.
    pub fn steps(&self, place: P) -> i64 {
        let from_zero = (place.number() - self.zero.number()) * self.sense.sign() as f64;
        (from_zero * f64::from(self.numerator) / f64::from(self.denominator)).round() as i64
    }

    /// The position at `steps`: the correctly rounded quotient, no accumulated error.
    pub fn place(&self, steps: i64) -> P {
        let product = i128::from(steps) * i128::from(self.denominator) * i128::from(self.sense.sign());
        let place = self.zero.number() + product as f64 / f64::from(self.numerator);
        // Finite: |steps·d| < 2¹²⁸ and the zero is finite.
        P::at(place).unwrap_or(self.zero)
    }

    /// Degrees or mm of one step: the resolution of the axis.
    pub fn step(&self) -> f64 {
        f64::from(self.denominator) / f64::from(self.numerator)
    }

    /// Steps of one degree or mm.
    pub fn steps_per_unit(&self) -> f64 {
        f64::from(self.numerator) / f64::from(self.denominator)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn angle(degrees: f64) -> AxisAngle {
        AxisAngle::new(degrees).unwrap()
    }

    #[test]
    fn a_million_moves_leave_no_error() {
        // 1280/9 steps a degree: every 9° is 1280 steps exactly, and 1° is not a whole number of steps.
        let scale = AxisScale::new(1280, 9, angle(0.0), Sense::Positive).unwrap();
        let mut steps = 0_i64;
        for i in 0..1_000_000_i64 {
            let wanted = angle((i * 7 % 361) as f64);
            let target = scale.steps(wanted);
            steps += target - steps; // the axis moves by a difference, as hardware does
            assert!((scale.place(steps).value() - wanted.value()).abs() <= scale.step() / 2.0 + 1e-12);
        }
        steps += scale.steps(angle(360.0)) - steps;
        assert_eq!(steps, 51_200);
        assert_eq!(scale.place(steps).value(), 360.0);
    }

    #[test]
    fn sense_and_zero_act_as_written() {
        let scale = AxisScale::new(100, 1, angle(90.0), Sense::Negative).unwrap();
        assert_eq!(scale.place(0).value(), 90.0);
        assert_eq!(scale.place(1000).value(), 80.0);
        assert_eq!(scale.steps(angle(80.0)), 1000);
        assert!(AxisScale::new(0, 1, angle(0.0), Sense::Positive).is_err());
    }

    proptest! {
        #[test]
        fn steps_survive_the_way_to_degrees_and_back(
            n in 1..2_000_000_u32, d in 1..1000_u32, zero in -360.0..360.0f64, steps in -100_000_000..100_000_000_i64, negative: bool,
        ) {
            let sense = if negative { Sense::Negative } else { Sense::Positive };
            let scale = AxisScale::new(n, d, angle(zero), sense).unwrap();
            // Beyond 2⁵³ ulps of a step the double itself is the limit.
            prop_assume!(scale.step() > 1e-9 && scale.place(steps).value().abs() < 1e5);
            prop_assert_eq!(scale.steps(scale.place(steps)), steps);
        }
    }
}
