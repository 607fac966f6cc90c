//! Third differences between neighbouring directions along meridians.

/// One direction of a difference along a meridian.
#[derive(Debug, Clone, Copy)]
pub struct Term {
    /// Whether it is across a pole, in the opposite half-plane.
    pub across: bool,
    /// Its γ, by number.
    pub ig: usize,
    pub weight: f64,
}

/// A difference of four neighbours along a meridian.
#[derive(Debug, Clone, Copy)]
pub struct Window {
    /// The γ that it stands at, by number.
    pub ig: usize,
    pub terms: [Term; 4],
}

impl Window {
    /// Whether one of its directions is across a pole.
    pub fn across(&self) -> bool {
        self.terms.iter().any(|term| term.across)
    }
}

/// The differences that every meridian has, across the poles too, and the half-plane in which each goes on there.
pub struct Meridians {
    pub windows: Vec<Window>,
    /// The opposite of each half-plane, where it was measured; that of a rotational lamp is itself.
    pub opposite: Vec<Option<usize>>,
}

impl Meridians {
    pub fn of(c_deg: &[f64], gammas: &[f64]) -> Self {
        let opposite = |ic: usize| {
            if c_deg.len() == 1 {
                return Some(0);
            }
            let behind = (c_deg[ic] + 180.0).rem_euclid(360.0);
            let near = c_deg.partition_point(|c| *c < behind - 1e-9);
            (near < c_deg.len() && (c_deg[near] - behind).abs() < 1e-9).then_some(near)
        };
        let last = gammas.len() - 1;
        let own = |ig: usize| (false, ig, gammas[ig]);
        let mut meridian: Vec<(bool, usize, f64)> = (0..=last).map(own).collect();
        let before = usize::from(gammas[0] == 0.0);
        if before == 1 {
            meridian.insert(0, (true, 1, -gammas[1]));
        }
        if gammas[last] == 180.0 {
            meridian.push((true, last - 1, 360.0 - gammas[last - 1]));
        }
        let windows = meridian.windows(4).enumerate().map(|(first, four)| {
            let weights = third_difference([four[0].2, four[1].2, four[2].2, four[3].2]);
            let term = |k: usize| Term {
                across: four[k].0,
                ig: four[k].1,
                weight: weights[k],
            };
            Window {
                ig: first + 1 - before,
                terms: [term(0), term(1), term(2), term(3)],
            }
        });
        Self {
            windows: windows.collect(),
            opposite: (0..c_deg.len()).map(opposite).collect(),
        }
    }

    /// The differences that all half-planes have.
    pub fn of_all(&self) -> impl Iterator<Item = &Window> {
        let round = self.opposite.iter().all(Option::is_some);
        self.windows.iter().filter(move |window| round || !window.across())
    }
}

/// Divided difference over four places, scaled as if they were one apart: −1, 3, −3, 1 where they are evenly spaced.
pub fn third_difference(along: [f64; 4]) -> [f64; 4] {
    let step = (along[3] - along[0]) / 3.0;
    [0, 1, 2, 3].map(|k| {
        let others = (0..4).filter(|other| *other != k);
        others.fold(6.0, |weight, other| weight * step / (along[k] - along[other]))
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_difference_goes_on_across_the_poles() {
        let gammas: Vec<f64> = (0..=6).map(|i| 30.0 * f64::from(i)).collect();
        let meridians = Meridians::of(&[0.0, 90.0, 180.0, 270.0], &gammas);
        assert_eq!(meridians.opposite, [Some(2), Some(3), Some(0), Some(1)]);
        assert_eq!(meridians.windows.len(), 6);
        let first = meridians.windows[0];
        assert_eq!(
            first.terms.map(|term| (term.across, term.ig)),
            [(true, 1), (false, 0), (false, 1), (false, 2)]
        );
        for (term, weight) in first.terms.iter().zip([-1.0, 3.0, -3.0, 1.0]) {
            assert!((term.weight - weight).abs() < 1e-12, "{first:?}");
        }
        assert_eq!(meridians.of_all().count(), 6);
        // Three half-planes have no opposite: no difference that all have goes across.
        let three = Meridians::of(&[0.0, 120.0, 240.0], &gammas);
        assert_eq!((three.opposite, three.windows.len()), (vec![None; 3], 6));
        let three = Meridians::of(&[0.0, 120.0, 240.0], &gammas);
        assert_eq!(three.of_all().count(), 4);
    }

    #[test]
    fn a_parabola_has_no_third_difference_however_its_places_are_spaced() {
        let places = [0.0, 7.0, 11.0, 30.0];
        let weights = third_difference(places);
        let sum = |f: &dyn Fn(f64) -> f64| weights.iter().zip(places).map(|(w, x)| w * f(x)).sum::<f64>();
        assert!(sum(&|x| 3.0 - x + 2.0 * x * x).abs() < 1e-9);
        // Its scale: 6 steps³ for x³, the step being a third of all.
        assert!((sum(&|x| x.powi(3)) / 6e3 - 1.0).abs() < 1e-12);
    }
}
