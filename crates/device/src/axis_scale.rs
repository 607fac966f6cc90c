//! Steps ⇄ degrees, exactly.

use isolux_units::AxisAngle;

/// Which way the axis angle grows as the step count grows.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Sense {
    /// More steps, larger angle.
    Positive,
    /// More steps, smaller angle.
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
    #[error("counts_per_deg = {numerator}/{denominator}: both parts must be at least 1")]
    Ratio {
        /// Steps.
        numerator: u32,
        /// Degrees.
        denominator: u32,
    },
}

/// The map between an axis' step count and its angle: angle = zero + sense · steps ÷ (n/d steps per degree).
///
/// The ratio is rational because gears are: 51200 steps a turn are 1280/9 per degree, which no decimal holds. A target is
/// always computed from the absolute angle and a position from the absolute count, so nothing can accumulate.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct AxisScale {
    numerator: u32,
    denominator: u32,
    zero: AxisAngle,
    sense: Sense,
}

impl AxisScale {
    /// `numerator/denominator` steps per degree; `zero` is the angle at step count 0.
    ///
    /// # Errors
    /// [`InvalidScale`] when a part of the ratio is zero.
    pub fn new(numerator: u32, denominator: u32, zero: AxisAngle, sense: Sense) -> Result<Self, InvalidScale> {
        if numerator == 0 || denominator == 0 {
            return Err(InvalidScale::Ratio { numerator, denominator });
        }
        Ok(Self {
            numerator,
            denominator,
            zero,
            sense,
        })
    }

    /// The step count nearest to `angle`.
    pub fn steps(&self, angle: AxisAngle) -> i64 {
        let from_zero = (angle.value() - self.zero.value()) * self.sense.sign() as f64;
        (from_zero * f64::from(self.numerator) / f64::from(self.denominator)).round() as i64
    }

    /// The angle at `steps`: the correctly rounded quotient, no accumulated error.
    pub fn angle(&self, steps: i64) -> AxisAngle {
        let product = i128::from(steps) * i128::from(self.denominator) * i128::from(self.sense.sign());
        let degrees = self.zero.value() + product as f64 / f64::from(self.numerator);
        // Finite: |steps·d| < 2¹²⁸ and the zero is finite.
        AxisAngle::new(degrees).unwrap_or(self.zero)
    }

    /// Degrees of one step: the resolution of the axis.
    pub fn step_deg(&self) -> f64 {
        f64::from(self.denominator) / f64::from(self.numerator)
    }

    /// Steps of one degree.
    pub fn steps_per_deg(&self) -> f64 {
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
            assert!((scale.angle(steps).value() - wanted.value()).abs() <= scale.step_deg() / 2.0 + 1e-12);
        }
        steps += scale.steps(angle(360.0)) - steps;
        assert_eq!(steps, 51_200);
        assert_eq!(scale.angle(steps).value(), 360.0);
    }

    #[test]
    fn sense_and_zero_act_as_written() {
        let scale = AxisScale::new(100, 1, angle(90.0), Sense::Negative).unwrap();
        assert_eq!(scale.angle(0).value(), 90.0);
        assert_eq!(scale.angle(1000).value(), 80.0);
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
            prop_assume!(scale.step_deg() > 1e-9 && scale.angle(steps).value().abs() < 1e5);
            prop_assert_eq!(scale.steps(scale.angle(steps)), steps);
        }
    }
}
