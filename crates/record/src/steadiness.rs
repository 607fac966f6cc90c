//! What visits to the reference point may do while the lamp counts as the same: one rule for the scan that measures and
//! for the reduction that judges its record, so that a scan which ended well is reduced.

use isolux_units::median;

use crate::limits::Limits;

/// A visit to the reference point as it was read.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Seen {
    /// Illuminance, in lx.
    pub illuminance_lx: f64,
    /// One digit of the display, in lx.
    pub digit_lx: f64,
}

/// Visits of one burning of the lamp, brought into their order in time, at one distance.
#[derive(Debug, Default, Clone, PartialEq)]
pub struct Steadiness {
    /// Those that did not jump.
    followed: Vec<Seen>,
}

impl Steadiness {
    /// The last visit that did not jump; none before the first.
    pub fn last(&self) -> Option<Seen> {
        self.followed.last().copied()
    }

    /// The median of the visits that did not jump, in lx, and the coarsest digit among them; none without visits.
    pub fn level(&self) -> Option<Seen> {
        level(&self.followed)
    }

    /// The same with `next` among them.
    pub fn level_with(&self, next: Seen) -> Seen {
        let all: Vec<Seen> = self.followed.iter().copied().chain([next]).collect();
        level(&all).unwrap_or(next)
    }

    /// Whether `visit` lies farther from `expected_lx` than `reference_rel` and one digit: a lamp that drifts slowly
    /// does not change so much from one visit to the next.
    pub fn jumps(visit: Seen, expected_lx: f64, limits: &Limits) -> bool {
        (visit.illuminance_lx - expected_lx).abs() > allowed_lx(visit, expected_lx, limits)
    }

    /// Whether `visit` lies farther from the median of its burning than `drift_rel` and one digit; the level of a
    /// burning from that of the others.
    pub fn drifts(visit: Seen, middle_lx: f64, limits: &Limits) -> bool {
        (visit.illuminance_lx - middle_lx).abs() > limits.drift_rel() * middle_lx.abs() + visit.digit_lx
    }

    /// Takes the next visit, unless it jumped from the one before. Whether it was taken; the first always is.
    pub fn follow(&mut self, visit: Seen, limits: &Limits) -> bool {
        let jumped = self
            .last()
            .is_some_and(|last| Self::jumps(visit, last.illuminance_lx, limits));
        if !jumped {
            self.followed.push(visit);
        }
        !jumped
    }

    /// With `next` as the next visit, the one that lies farthest beyond `drift_rel` and one digit from the median of
    /// all: a drift that a reduction does not correct. None within the limit.
    pub fn drifted(&self, next: Seen, limits: &Limits) -> Option<Drifted> {
        let all: Vec<Seen> = self.followed.iter().copied().chain([next]).collect();
        let middle_lx = median(all.iter().map(|visit| visit.illuminance_lx))?;
        let off = |visit: &Seen| (visit.illuminance_lx - middle_lx).abs();
        let worst = all
            .iter()
            .filter(|visit| Self::drifts(**visit, middle_lx, limits))
            .max_by(|a, b| off(a).total_cmp(&off(b)))?;
        Some(Drifted {
            middle_lx,
            change_rel: worst.illuminance_lx / middle_lx - 1.0,
        })
    }
}

/// A drift beyond the limit.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Drifted {
    /// Median of the visits, in lx.
    pub middle_lx: f64,
    /// Change of the visit that is farthest away, relative to it.
    pub change_rel: f64,
}

/// The median, and the coarsest digit; none of nothing.
pub fn level(visits: &[Seen]) -> Option<Seen> {
    Some(Seen {
        illuminance_lx: median(visits.iter().map(|visit| visit.illuminance_lx))?,
        digit_lx: visits.iter().map(|visit| visit.digit_lx).fold(0.0, f64::max),
    })
}

/// How far `visit` may lie from `expected_lx`, in lx.
pub fn allowed_lx(visit: Seen, expected_lx: f64, limits: &Limits) -> f64 {
    limits.reference_rel() * expected_lx.abs() + visit.digit_lx
}

#[cfg(test)]
mod tests {
    use super::*;

    fn seen(illuminance_lx: f64) -> Seen {
        Seen {
            illuminance_lx,
            digit_lx: 0.01,
        }
    }

    #[test]
    fn a_slow_drift_is_followed_and_a_jump_is_not() {
        let limits = Limits::default();
        let mut visits = Steadiness::default();
        // 0.1 % from visit to visit, 3 % in all: from the middle ± 1.5 %.
        for step in 0..31 {
            let next = seen(10.0 * (1.0 - 0.001 * f64::from(step)));
            assert_eq!(visits.drifted(next, &limits), None, "{step}");
            assert!(visits.follow(next, &limits), "{step}");
        }
        assert!(!visits.follow(seen(9.5), &limits), "2 % below the visit before");
        assert_eq!(visits.last(), Some(seen(10.0 * (1.0 - 0.001 * 30.0))));
        assert!(visits.follow(seen(9.71), &limits), "measured against what was followed");
    }

    #[test]
    fn a_drift_has_its_limit_and_one_digit_on_top() {
        let limits = Limits::default();
        let mut visits = Steadiness::default();
        let mut level = 10.0;
        while visits.drifted(seen(level), &limits).is_none() {
            assert!(visits.follow(seen(level), &limits));
            level -= 0.01;
        }
        // Both ends 2 % and a digit from the middle.
        let drifted = visits.drifted(seen(level), &limits).unwrap();
        assert!((drifted.change_rel.abs() - 0.0215).abs() < 0.001, "{drifted:?}");
        assert!((drifted.middle_lx - 0.5 * (10.0 + level)).abs() < 0.011, "{drifted:?}");
    }
}
