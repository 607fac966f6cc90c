//! Whether light that was read all round has the symmetry that half-planes of a part of the circle assume.

use crate::Symmetry;
use crate::around::{MEAN_DEG, Ring, STEP_DEG};

/// Largest displacement between a ring's positions and its light that is looked for, and the step, degrees.
const MOST_DISPLACED_DEG: f64 = 3.0;
const DISPLACED_STEP_DEG: f64 = 0.05;
/// The dip of which [`Asymmetry::narrowest_deg`] says how wide it has to be, in shares of the light around it.
pub const DIP_REL: f64 = 0.05;

/// Where rings differ most from the symmetry.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Asymmetry {
    /// By how much, in shares of the largest light of all rings.
    pub largest_rel: f64,
    /// There: C, degrees.
    pub c_deg: f64,
    /// There: γ, degrees.
    pub gamma_deg: f64,
}

impl Asymmetry {
    /// Of rings, each with +1 where C rose while it was read and −1 where it fell; none for no ring, no light, or no
    /// symmetry. A delay displaces the light of both directions of travel against each other, which is no asymmetry:
    /// the displacement at which they fit best is taken out.
    pub fn of(rings: &[(&Ring, f64)], symmetry: Symmetry) -> Option<Self> {
        let largest = rings.iter().map(|(ring, _)| ring.largest()).fold(0.0, f64::max);
        if largest <= 0.0 || symmetry == Symmetry::None {
            return None;
        }
        let steps = (MOST_DISPLACED_DEG / DISPLACED_STEP_DEG) as i32;
        let shifts = (-steps..=steps).map(|step| DISPLACED_STEP_DEG * f64::from(step));
        let misfit = |shift: f64| -> f64 { differences(rings, symmetry, shift).map(|(_, _, by)| by * by).sum() };
        let shift = shifts.min_by(|a, b| misfit(*a).total_cmp(&misfit(*b)))?;
        let worst = differences(rings, symmetry, shift).max_by(|a, b| a.2.abs().total_cmp(&b.2.abs()))?;
        Some(Self {
            c_deg: worst.0,
            gamma_deg: worst.1,
            largest_rel: worst.2.abs() / largest,
        })
    }

    /// The narrowest dip of [`DIP_REL`] of the light of the brightest ring that differs by more than `most_rel`,
    /// degrees of C; none where none does.
    pub fn narrowest_deg(most_rel: f64) -> Option<f64> {
        // The mean over a stretch flattens what is narrower.
        (DIP_REL > most_rel).then(|| MEAN_DEG * most_rel / DIP_REL)
    }
}

/// (C, γ, difference from the image, or for a rotational lamp from the mean) all round.
fn differences<'r>(
    rings: &'r [(&'r Ring, f64)],
    symmetry: Symmetry,
    shift_deg: f64,
) -> impl Iterator<Item = (f64, f64, f64)> + 'r {
    let count = (360.0 / STEP_DEG) as usize;
    rings.iter().flat_map(move |(ring, sign)| {
        let at = move |c_deg: f64| ring.at(c_deg - sign * shift_deg);
        let mean = ring.mean();
        (0..count).flat_map(move |k| {
            let c_deg = STEP_DEG * k as f64;
            let images = match symmetry {
                Symmetry::Rotational => vec![mean],
                _ => symmetry.images_deg(c_deg)[1..].iter().map(|image| at(*image)).collect(),
            };
            images
                .into_iter()
                .map(move |image| (c_deg, ring.gamma_deg, at(c_deg) - image))
        })
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A ring of `light`, read with a delay that displaces it by 0.8°, with noise of 0.2 %.
    fn ring(gamma_deg: f64, sign: f64, light: impl Fn(f64) -> f64) -> Ring {
        let readings = (0..230).map(|k| {
            let c_deg = 360.0 * (f64::from(k) + 0.5) / 230.0;
            let noise = 1.0 + 0.0028 * (78.233 * (f64::from(k) + 300.0 * gamma_deg)).sin();
            (c_deg, light(c_deg + sign * 0.8) * noise)
        });
        Ring::of(gamma_deg, readings).unwrap()
    }

    fn worst(symmetry: Symmetry, light: impl Fn(f64) -> f64 + Copy) -> Asymmetry {
        let (up, down) = (ring(20.0, 1.0, light), ring(40.0, -1.0, light));
        Asymmetry::of(&[(&up, 1.0), (&down, -1.0)], symmetry).unwrap()
    }

    #[test]
    fn what_is_symmetric_is_within_noise_however_it_is_displaced() {
        let quadrant = |c: f64| 100.0 * (1.0 + 0.4 * (2.0 * c.to_radians()).cos());
        for symmetry in [Symmetry::Quadrant, Symmetry::C0C180, Symmetry::C90C270] {
            assert!(worst(symmetry, quadrant).largest_rel < 0.005, "{symmetry:?}");
        }
        assert!(worst(Symmetry::Rotational, |_| 100.0).largest_rel < 0.004);
        assert!(worst(Symmetry::Rotational, quadrant).largest_rel > 0.2);
        assert!(worst(Symmetry::C0C180, |c| 100.0 + 5.0 * c.to_radians().sin()).largest_rel > 0.05);
        // A luminaire that is turned in its mount by 2° is no displacement: both directions of travel see it alike.
        assert!(worst(Symmetry::C0C180, |c| quadrant(c - 2.0)).largest_rel > 0.03);
        let one = ring(20.0, 1.0, quadrant);
        assert_eq!(Asymmetry::of(&[(&one, 1.0)], Symmetry::None), None);
        assert_eq!(Asymmetry::of(&[], Symmetry::Quadrant), None);
    }

    #[test]
    fn a_dip_at_any_place_is_found_there() {
        for at in (0..36).map(|k| 10.0 * f64::from(k)) {
            let dip = |c: f64| {
                let off = (c - at + 180.0).rem_euclid(360.0) - 180.0;
                100.0 * (1.0 - 0.05 * (-0.5 * (off / 8.5).powi(2)).exp())
            };
            let found = worst(Symmetry::Rotational, dip);
            let off = (found.c_deg - at + 180.0).rem_euclid(360.0) - 180.0;
            assert!(found.largest_rel > 0.03 && off.abs() < 6.0, "{at}: {found:?}");
            // In a mirror plane it is its own image.
            if !(at % 90.0).eq(&0.0) {
                assert!(worst(Symmetry::Quadrant, dip).largest_rel > 0.02, "{at}");
            }
        }
        assert!((Asymmetry::narrowest_deg(0.01).unwrap() - 1.5).abs() < 1e-9);
        assert_eq!(Asymmetry::narrowest_deg(0.05), None);
    }
}
