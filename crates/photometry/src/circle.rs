//! Measured half-planes → the full circle.

use crate::Symmetry;

/// A part of the circle that was not measured and that no symmetry gives.
#[derive(Debug, Clone, Copy, PartialEq, thiserror::Error)]
#[error(
    "the half-planes do not go round: nothing was measured between C {from_c_deg}° and C {to_c_deg}°; measure C \
     0° to 360°, or, for a lamp that is taken as symmetric, C 0° to 90° or C 0° to 180°, both ends included"
)]
pub struct NotRound {
    /// The last half-plane before the gap.
    pub from_c_deg: f64,
    /// The first behind it.
    pub to_c_deg: f64,
}

/// A gap between half-planes that is taken for a part that was not measured: at least this, and more than twice the
/// next.
const GAP_DEG: f64 = 90.0;

/// The half-planes of the full circle.
#[derive(Debug)]
pub struct Circle {
    /// C rising in [0, 360), and which measured half-plane gives it.
    pub planes: Vec<(f64, usize)>,
    /// Symmetry that was assumed for it.
    pub assumed: Symmetry,
}

impl Circle {
    /// The circle of half-planes at `c_deg`, rising in [0, 360). One half-plane is a rotational lamp. Half-planes from
    /// one principal plane to the next (C 0°…90°) or the next but one (C 0°…180°, C 90°…270°) are those of
    /// a lamp that is taken as symmetric, as EN 13032-1 lets it be measured: the others are their mirror images.
    ///
    /// # Errors
    /// [`NotRound`] when another part of the circle is missing.
    pub fn of(c_deg: &[f64]) -> Result<Self, NotRound> {
        let as_measured = |assumed| Self {
            planes: c_deg.iter().copied().zip(0..).collect(),
            assumed,
        };
        let count = c_deg.len();
        if count < 2 {
            return Ok(as_measured(Symmetry::Rotational));
        }
        // Each gap by the half-plane behind it.
        let gap = |at: usize| {
            let gap = (c_deg[at] - c_deg[(at + count - 1) % count]).rem_euclid(360.0);
            if gap == 0.0 { 360.0 } else { gap }
        };
        let mut by_gap: Vec<usize> = (0..count).collect();
        by_gap.sort_by(|a, b| gap(*b).total_cmp(&gap(*a)));
        let (first, widest, next) = (by_gap[0], gap(by_gap[0]), gap(by_gap[1]));
        let two_opposite = count == 2 && widest == next;
        let open = widest >= GAP_DEG && widest > 2.0 * next || widest >= 180.0 && !two_opposite;
        if !open {
            return Ok(as_measured(Symmetry::None));
        }
        let (from, last) = (c_deg[first], c_deg[(first + count - 1) % count]);
        let assumed = match (from % 90.0 == 0.0, 360.0 - widest) {
            (true, 90.0) => Symmetry::Quadrant,
            (true, 180.0) if from % 180.0 == 0.0 => Symmetry::C0C180,
            (true, 180.0) => Symmetry::C90C270,
            _ => {
                return Err(NotRound {
                    from_c_deg: last,
                    to_c_deg: from,
                });
            }
        };
        let mut planes: Vec<(f64, usize)> = c_deg
            .iter()
            .enumerate()
            .flat_map(|(plane, &c)| assumed.images_deg(c).into_iter().map(move |image| (image, plane)))
            .collect();
        // Of equal directions the measured one, whose image it is; a half-plane in a principal plane is its own image.
        planes.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
        planes.dedup_by(|later, earlier| later.0 == earlier.0);
        Ok(Self { planes, assumed })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_goes_round_stays_and_what_does_not_is_mirrored_or_refused() {
        let of = |c: &[f64]| Circle::of(c).map(|circle| (circle.assumed, circle.planes.len()));
        let every_15: Vec<f64> = (0..24).map(|i| 15.0 * f64::from(i)).collect();
        for round in [
            &every_15[..],
            &every_15[..23],
            &[0.0, 180.0],
            &[0.0, 90.0, 180.0, 270.0],
            &[10.0, 130.0, 250.0],
        ] {
            assert_eq!(of(round).unwrap(), (Symmetry::None, round.len()));
        }
        assert_eq!(of(&[30.0]).unwrap(), (Symmetry::Rotational, 1));
        assert_eq!(of(&[0.0, 90.0]).unwrap(), (Symmetry::Quadrant, 4));
        assert_eq!(of(&[90.0, 120.0, 180.0]).unwrap(), (Symmetry::Quadrant, 8));
        assert_eq!(of(&every_15[..=12]).unwrap(), (Symmetry::C0C180, 24));
        assert_eq!(of(&every_15[6..=18]).unwrap(), (Symmetry::C90C270, 24));
        assert_eq!(of(&[0.0, 45.0, 90.0, 270.0, 315.0]).unwrap(), (Symmetry::C90C270, 8));
        for open in [&every_15[..12], &every_15[..19], &[0.0, 100.0], &[20.0, 50.0]] {
            assert!(matches!(of(open), Err(NotRound { .. })), "{open:?}");
        }
    }
}
