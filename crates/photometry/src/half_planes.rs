//! Directions on a few half-planes, each at γ of its own, and what each of them weighs in a direction between them.
//!
//! What changes slowly over the sphere, as the colour of a lamp does, is measured on a grid much coarser than its
//! intensity, and not the same in every half-plane: dim directions are left out.

use crate::{Circle, NotRound, Symmetry};

/// Up to so many half-planes at even steps are taken by the harmonics of C that they can show.
const MOST_HARMONIC: usize = 8;
/// Steps that differ by less are even, in degrees.
const EVEN_DEG: f64 = 1e-6;

/// Why directions make no half-planes.
#[derive(Debug, Clone, Copy, PartialEq, thiserror::Error)]
pub enum HalfPlanesError {
    /// No direction.
    #[error("no direction is given")]
    Empty,
    /// An angle that none is.
    #[error("C {c_deg}°, γ {gamma_deg}° is no direction: γ lies between 0° and 180°")]
    Angle {
        /// C as it was given.
        c_deg: f64,
        /// γ as it was given.
        gamma_deg: f64,
    },
    /// One direction twice; the poles are one direction each.
    #[error("C {c_deg}°, γ {gamma_deg}° is given twice")]
    Twice {
        /// C.
        c_deg: f64,
        /// γ.
        gamma_deg: f64,
    },
    /// A part of the circle without half-planes.
    #[error(transparent)]
    NotRound(#[from] NotRound),
}

/// Directions on half-planes.
///
/// Along γ a value is linear between two directions of a half-plane, and beyond its last one it is held. Around C up
/// to eight half-planes at even steps are joined by the harmonics that they can show (of four: the mean, cos C, sin C
/// and cos 2C); more, or at uneven steps, by straight lines. Half-planes over a part of the circle alone stand for a
/// lamp that is symmetric ([`Circle`]).
#[derive(Debug, Clone, PartialEq)]
pub struct HalfPlanes {
    planes: Vec<HalfPlane>,
    assumed: Symmetry,
    /// Half-planes at even steps, few enough for harmonics.
    harmonic: bool,
}

#[derive(Debug, Clone, PartialEq)]
struct HalfPlane {
    c_deg: f64,
    /// γ rising, and the number of the direction that was given for it.
    nodes: Vec<(f64, usize)>,
}

impl HalfPlanes {
    /// Half-planes through `directions_deg`, pairs of C and γ; one at a pole belongs to every half-plane.
    ///
    /// # Errors
    /// [`HalfPlanesError`].
    pub fn new(directions_deg: &[(f64, f64)]) -> Result<Self, HalfPlanesError> {
        let mut poles: Vec<(f64, usize)> = Vec::new();
        let mut read: Vec<HalfPlane> = Vec::new();
        for (index, &(given_deg, gamma_deg)) in directions_deg.iter().enumerate() {
            if !(given_deg.is_finite() && (0.0..=180.0).contains(&gamma_deg)) {
                let c_deg = given_deg;
                return Err(HalfPlanesError::Angle { c_deg, gamma_deg });
            }
            let c_deg = given_deg.rem_euclid(360.0);
            let twice = HalfPlanesError::Twice { c_deg, gamma_deg };
            if is_pole(gamma_deg) {
                if poles.iter().any(|(pole, _)| *pole == gamma_deg) {
                    return Err(twice);
                }
                poles.push((gamma_deg, index));
                continue;
            }
            let place = read.partition_point(|plane| plane.c_deg < c_deg);
            if read.get(place).is_none_or(|plane| plane.c_deg != c_deg) {
                let nodes = Vec::new();
                read.insert(place, HalfPlane { c_deg, nodes });
            }
            let nodes = &mut read[place].nodes;
            let place = nodes.partition_point(|(at, _)| *at < gamma_deg);
            if nodes.get(place).is_some_and(|(at, _)| *at == gamma_deg) {
                return Err(twice);
            }
            nodes.insert(place, (gamma_deg, index));
        }
        if read.is_empty() {
            if poles.is_empty() {
                return Err(HalfPlanesError::Empty);
            }
            let nodes = Vec::new();
            read.push(HalfPlane { c_deg: 0.0, nodes });
        }
        for plane in &mut read {
            plane.nodes.extend(&poles);
            plane.nodes.sort_by(|a, b| a.0.total_cmp(&b.0));
        }
        let c_deg: Vec<f64> = read.iter().map(|plane| plane.c_deg).collect();
        let circle = Circle::of(&c_deg)?;
        let image = |&(c_deg, source): &(f64, usize)| HalfPlane {
            c_deg,
            nodes: read[source].nodes.clone(),
        };
        let planes: Vec<HalfPlane> = circle.planes.iter().map(image).collect();
        let step_deg = 360.0 / planes.len() as f64;
        let even =
            |(k, plane): (usize, &HalfPlane)| (plane.c_deg - planes[0].c_deg - step_deg * k as f64).abs() < EVEN_DEG;
        Ok(Self {
            harmonic: planes.len() <= MOST_HARMONIC && planes.iter().enumerate().all(even),
            assumed: circle.assumed,
            planes,
        })
    }

    /// Symmetry that was assumed, because the half-planes do not go round.
    pub fn assumed(&self) -> Symmetry {
        self.assumed
    }

    /// The half-planes of the full circle by C, in degrees: for each its γ, rising, with the number of the direction
    /// that was given for it. A direction at a pole is in all of them.
    pub fn planes(&self) -> impl Iterator<Item = (f64, &[(f64, usize)])> {
        self.planes.iter().map(|plane| (plane.c_deg, plane.nodes.as_slice()))
    }

    /// Whether γ lies between the first and the last direction of the half-plane nearest to C.
    pub fn holds(&self, c_deg: f64, gamma_deg: f64) -> bool {
        let away = |plane: &HalfPlane| {
            let turned = (c_deg - plane.c_deg).rem_euclid(360.0);
            turned.min(360.0 - turned)
        };
        let nearest = self.planes.iter().min_by(|a, b| away(a).total_cmp(&away(b)));
        let nodes = nearest.map_or(&[][..], |plane| plane.nodes.as_slice());
        let ends = nodes.first().zip(nodes.last());
        ends.is_some_and(|((first, _), (last, _))| (*first..=*last).contains(&gamma_deg))
    }

    /// Hands the number of each direction that the value at (C, γ) is made of to `each`, with its weight; the same
    /// number may come several times, and all weights add up to 1.
    pub fn each_weight(&self, c_deg: f64, gamma_deg: f64, mut each: impl FnMut(usize, f64)) {
        let mut along = |plane: &HalfPlane, share: f64| {
            let nodes = &plane.nodes;
            let above = nodes.partition_point(|(at, _)| *at < gamma_deg);
            match (above.checked_sub(1).map(|below| nodes[below]), nodes.get(above)) {
                (Some((low, below)), Some(&(high, above))) => {
                    let t = (gamma_deg - low) / (high - low);
                    each(below, share * (1.0 - t));
                    each(above, share * t);
                }
                (None, Some(&(_, only))) | (Some((_, only)), None) => each(only, share),
                (None, None) => {}
            }
        };
        let count = self.planes.len();
        if count == 1 || is_pole(gamma_deg) && self.shares(gamma_deg) {
            return along(&self.planes[0], 1.0);
        }
        if self.harmonic {
            for plane in &self.planes {
                along(plane, harmonic_weight(count, c_deg - plane.c_deg));
            }
            return;
        }
        let turned = c_deg.rem_euclid(360.0);
        let next = self.planes.partition_point(|plane| plane.c_deg <= turned) % count;
        let before = (next + count - 1) % count;
        let gap = (self.planes[next].c_deg - self.planes[before].c_deg).rem_euclid(360.0);
        let t = (turned - self.planes[before].c_deg).rem_euclid(360.0) / gap;
        along(&self.planes[before], 1.0 - t);
        along(&self.planes[next], t);
    }

    /// Whether a pole was measured.
    fn shares(&self, pole_deg: f64) -> bool {
        self.planes[0].nodes.iter().any(|(at, _)| *at == pole_deg)
    }
}

fn is_pole(gamma_deg: f64) -> bool {
    gamma_deg == 0.0 || gamma_deg == 180.0
}

/// Weight of one of `count` half-planes at even steps at `away_deg` from it: the trigonometric polynomial that is 1
/// there and 0 in all others, its highest harmonic of an even count halved.
fn harmonic_weight(count: usize, away_deg: f64) -> f64 {
    let n = count as f64;
    let half = 0.5 * away_deg.rem_euclid(360.0).to_radians();
    let (sin, cos) = half.sin_cos();
    if sin.abs() < 1e-9 {
        return 1.0;
    }
    let whole = (n * half).sin() / (n * sin);
    // At half a turn sin(n·half) of an even count vanishes with its cosine.
    if count.is_multiple_of(2) { whole * cos } else { whole }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn value(of: &HalfPlanes, values: &[f64], c_deg: f64, gamma_deg: f64) -> f64 {
        let (mut sum, mut weights) = (0.0, 0.0);
        of.each_weight(c_deg, gamma_deg, |index, weight| {
            sum += weight * values[index];
            weights += weight;
        });
        assert!((weights - 1.0).abs() < 1e-12, "{c_deg} {gamma_deg}: {weights}");
        sum
    }

    #[test]
    fn four_half_planes_show_the_first_harmonic_and_every_direction_is_met() {
        let law = |c: f64, gamma: f64| {
            let (c, g) = (c.to_radians(), gamma.to_radians());
            1.0 + 0.5 * gamma / 90.0 + g * (0.3 * (c - 0.7).cos() + 0.1 * (2.0 * c).cos())
        };
        let mut directions = vec![(0.0, 0.0)];
        for c in [0.0, 90.0, 180.0, 270.0] {
            directions.extend((1..=9).map(|k| (c, 10.0 * f64::from(k))));
        }
        // Turned as a scan may turn them; one half-plane lacks its dim end.
        directions.pop();
        directions.reverse();
        let values: Vec<f64> = directions.iter().map(|&(c, gamma)| law(c, gamma)).collect();
        let of = HalfPlanes::new(&directions).unwrap();
        assert_eq!(of.assumed(), Symmetry::None);
        for (&(c, gamma), expected) in directions.iter().zip(&values) {
            assert!((value(&of, &values, c, gamma) - expected).abs() < 1e-12, "{c} {gamma}");
        }
        for (c, gamma) in [(33.0, 20.0), (200.0, 75.0), (-41.0, 5.0), (359.0, 80.0), (17.0, 0.0)] {
            let (got, expected) = (value(&of, &values, c, gamma), law(c, gamma));
            assert!((got - expected).abs() < 1e-12, "{c} {gamma}: {got} {expected}");
        }
        // Beyond its last direction a half-plane holds it.
        assert_eq!(value(&of, &values, 270.0, 90.0), value(&of, &values, 270.0, 80.0));
        assert_eq!(value(&of, &values, 0.0, 170.0), value(&of, &values, 0.0, 90.0));
        let within = [(200.0, 85.0), (230.0, 85.0), (200.0, 91.0)].map(|(c, gamma)| of.holds(c, gamma));
        assert_eq!(within, [true, false, false], "by the nearest half-plane");
    }

    #[test]
    fn uneven_and_many_half_planes_are_joined_by_lines_and_a_part_is_mirrored() {
        let uneven = [(0.0, 30.0), (100.0, 30.0), (220.0, 30.0)];
        let of = HalfPlanes::new(&uneven).unwrap();
        assert!((value(&of, &[1.0, 2.0, 5.0], 50.0, 30.0) - 1.5).abs() < 1e-12);
        assert!((value(&of, &[1.0, 2.0, 5.0], 290.0, 30.0) - 3.0).abs() < 1e-12);
        let many: Vec<(f64, f64)> = (0..24).map(|k| (15.0 * f64::from(k), 40.0)).collect();
        let values: Vec<f64> = (0..24).map(f64::from).collect();
        let of = HalfPlanes::new(&many).unwrap();
        assert!((value(&of, &values, 22.5, 40.0) - 1.5).abs() < 1e-12);
        let quarter = HalfPlanes::new(&[(0.0, 0.0), (0.0, 60.0), (90.0, 60.0)]).unwrap();
        assert_eq!(quarter.assumed(), Symmetry::Quadrant);
        for c in [0.0, 180.0] {
            assert!((value(&quarter, &[1.0, 2.0, 4.0], c, 60.0) - 2.0).abs() < 1e-12);
        }
        assert!((value(&quarter, &[1.0, 2.0, 4.0], 45.0, 60.0) - 3.0).abs() < 1e-12);
        let rotational = HalfPlanes::new(&[(0.0, 0.0), (0.0, 50.0)]).unwrap();
        assert_eq!(rotational.assumed(), Symmetry::Rotational);
        assert!((value(&rotational, &[1.0, 2.0], 123.0, 25.0) - 1.5).abs() < 1e-12);
    }

    #[test]
    fn what_makes_no_half_planes_is_refused() {
        for (directions, word) in [
            (vec![], "no direction"),
            (vec![(0.0, 10.0), (360.0, 10.0)], "twice"),
            (vec![(0.0, 0.0), (90.0, 0.0)], "twice"),
            (vec![(0.0, -10.0)], "no direction"),
            (vec![(f64::NAN, 10.0)], "no direction"),
            (vec![(0.0, 10.0), (100.0, 10.0)], "do not go round"),
        ] {
            let error = HalfPlanes::new(&directions).unwrap_err().to_string();
            assert!(error.contains(word), "{directions:?}: {error}");
        }
    }
}
