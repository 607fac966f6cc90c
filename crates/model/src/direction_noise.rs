//! What the noise of the distribution's own directions does to predictions: one reading made each direction, and
//! whoever looks there again meets the same error again.

use isolux_record::ReadingKind;
use isolux_record::observation::{MapSet, ReadingCoordinates};

use crate::model::Model;
use crate::prepared::PreparedModel;

/// What the reading of one direction of the distribution, wrong by one standard uncertainty, does to predictions; or
/// the mean of all readings of one γ. Errors are independent of each other; where the distribution was smoothed, one
/// changes neighbouring directions too.
#[derive(Debug, Clone, PartialEq)]
pub struct DirectionError {
    /// Of a direction its number in the distribution, `[ic * ng + ig]` (the first half-plane's at a pole); of a mean,
    /// the number of directions and that of its γ.
    pub number: usize,
    /// Numbers of the predictions that it changes, each with how much, in its own unit.
    pub errors: Vec<(usize, f64)>,
}

/// Shares below this of a direction's uncertainty do not matter.
const NEGLIGIBLE: f64 = 1e-3;
/// Neighbours to either side that smoothing reaches, at most.
const MOST_REACH: usize = 64;

impl Model {
    /// Errors of the readings that come from the noise of single directions of the distribution, where the model states
    /// it (`luminaire.u.direction_rel`, `direction_cd`); empty where it does not.
    pub fn direction_errors_of_readings(&self, readings: &[ReadingCoordinates]) -> Vec<DirectionError> {
        self.direction_errors(readings.len(), |prepared, changes| {
            let places = self.detector_places(readings);
            let lamp: Vec<f64> = readings.iter().map(|at| self.lamp_factor(at.lamp_age_s())).collect();
            for (number, ((at, (point_mm, facing)), lamp)) in readings.iter().zip(places).zip(lamp).enumerate() {
                if at.kind == ReadingKind::Lit {
                    prepared.shares(point_mm, facing, |direction, lx_per_cd| {
                        changes.add(direction, number, lx_per_cd * lamp);
                    });
                }
            }
        })
    }

    /// The same of the cells of maps, in their unit.
    pub fn direction_errors_of_maps(&self, maps: &MapSet) -> Vec<DirectionError> {
        self.direction_errors(maps.cells().len(), |prepared, changes| {
            for (number, place) in self.cell_places(maps).into_iter().enumerate() {
                if let Some((point_mm, facing, unit_per_lx)) = place {
                    prepared.shares(point_mm, facing, |direction, lx_per_cd| {
                        changes.add(direction, number, lx_per_cd * unit_per_lx);
                    });
                }
            }
        })
    }

    fn direction_errors(
        &self,
        rows: usize,
        collect: impl FnOnce(&PreparedModel<'_>, &mut Changes),
    ) -> Vec<DirectionError> {
        let Some(u) = self.uncertainty().filter(|u| u.of_direction_cd(1.0) > 0.0) else {
            return Vec::new();
        };
        let distribution = self.luminaire().distribution();
        let (planes, gammas) = (distribution.c_deg().len(), distribution.gamma_deg());
        let mut changes = Changes::new(planes, gammas.len());
        collect(&PreparedModel::new(self), &mut changes);
        let is_pole = |row: usize| gammas[row] == 0.0 || gammas[row] == 180.0;
        let means = match (u.direction_share, u.mean_share) {
            (Some([along, _]), Some(mean)) if planes > 1 => changes.of_means([along, mean], rows, is_pole),
            _ => Vec::new(),
        };
        if let Some(shares) = u.direction_share {
            changes.smooth(shares, rows, is_pole);
        }
        let of_direction_cd = |direction: usize| u.of_direction_cd(distribution.intensity_cd()[direction]);
        let u_cd = |number: usize| {
            let ig = number % gammas.len();
            if number < planes * gammas.len() && !is_pole(ig) {
                return of_direction_cd(number);
            }
            // At a pole, too, every half-plane had a reading of its own.
            let squares = (0..planes).map(|ic| of_direction_cd(ic * gammas.len() + ig).powi(2));
            squares.sum::<f64>().sqrt() / planes as f64
        };
        changes.of.extend(means);
        changes.into_errors(u_cd)
    }
}

/// What one candela more in each direction changes of predictions.
struct Changes {
    planes: usize,
    gammas: usize,
    /// By direction, the numbers of the predictions in rising order and the change of each.
    of: Vec<Vec<(usize, f64)>>,
}

impl Changes {
    fn new(planes: usize, gammas: usize) -> Self {
        Self {
            planes,
            gammas,
            of: vec![Vec::new(); planes * gammas],
        }
    }

    /// Predictions come in rising order.
    fn add(&mut self, direction: usize, number: usize, change: f64) {
        let of = &mut self.of[direction];
        match of.last_mut() {
            Some((last, sum)) if *last == number => *sum += change,
            _ => of.push((number, change)),
        }
    }

    /// Of one candela more in the reading of a direction, where the distribution was smoothed with these shares along γ
    /// and around C. A pole is taken as it was read.
    fn smooth(&mut self, [along, around]: [f64; 2], rows: usize, is_pole: impl Fn(usize) -> bool) {
        let (planes, gammas) = (self.planes as isize, self.gammas as isize);
        let inside = |ig: isize| (0..gammas).contains(&ig) && !is_pole(ig as usize);
        self.spread(&kernel(along), rows, |ic, ig, by| {
            inside(ig + by).then_some(ic * gammas + ig + by)
        });
        if planes > 1 {
            let reach = (planes as usize - 1) / 2;
            let mut kernel = kernel(around);
            kernel.truncate(reach + 1);
            self.spread(&kernel, rows, |ic, ig, by| {
                inside(ig).then_some((ic + by).rem_euclid(planes) * gammas + ig)
            });
        }
    }

    /// By γ, of one candela more in the mean of all half-planes there, what [`Self::smooth`] lacks: the mean was smoothed
    /// along γ by itself and has the share `mean` left, while the directions together are smoothed to that of `along`.
    /// Of a wave in γ the one lets more through than the other, and what it lets through more, in squares, is the noise
    /// that a mean has beyond its directions'.
    fn of_means(
        &self,
        [along, mean]: [f64; 2],
        rows: usize,
        is_pole: impl Fn(usize) -> bool,
    ) -> Vec<Vec<(usize, f64)>> {
        let mut means = Changes::new(1, self.gammas);
        let mut sum = vec![0.0; rows];
        for (ig, of_mean) in means.of.iter_mut().enumerate().filter(|(ig, _)| !is_pole(*ig)) {
            let of_ring = || self.of.iter().skip(ig).step_by(self.gammas).flatten();
            let mut numbers: Vec<usize> = of_ring().map(|(number, _)| *number).collect();
            numbers.sort_unstable();
            numbers.dedup();
            of_ring().for_each(|(number, change)| sum[*number] += change);
            *of_mean = numbers
                .into_iter()
                .map(|number| (number, std::mem::take(&mut sum[number])))
                .collect();
        }
        let [along, mean] = [along, mean].map(lambda_of);
        let beyond = |third: f64| {
            let more = passed(mean, third).powi(2) - passed(along, third).powi(2);
            more.max(0.0).sqrt()
        };
        let kernel = reaching(weights(beyond, MOST_REACH));
        let inside = |ig: isize| (0..self.gammas as isize).contains(&ig) && !is_pole(ig as usize);
        means.spread(&kernel, rows, |_, ig, by| {
            (inside(ig) && inside(ig + by)).then_some(ig + by)
        });
        means.of
    }

    /// Each direction's changes become the sum of its neighbours', weighted by `kernel` from the middle outward.
    fn spread(&mut self, kernel: &[f64], rows: usize, neighbour: impl Fn(isize, isize, isize) -> Option<isize>) {
        let mut sum = vec![0.0; rows];
        let reach = kernel.len() as isize - 1;
        let of = |direction: usize| {
            let (ic, ig) = ((direction / self.gammas) as isize, (direction % self.gammas) as isize);
            if neighbour(ic, ig, 0).is_none() {
                return self.of[direction].clone();
            }
            let mut numbers = Vec::new();
            for by in -reach..=reach {
                let Some(near) = neighbour(ic, ig, by) else { continue };
                for (number, change) in &self.of[near as usize] {
                    if sum[*number] == 0.0 {
                        numbers.push(*number);
                    }
                    sum[*number] += kernel[by.unsigned_abs()] * change;
                }
            }
            numbers.sort_unstable();
            numbers.dedup();
            numbers
                .into_iter()
                .map(|number| (number, std::mem::take(&mut sum[number])))
                .collect()
        };
        self.of = (0..self.of.len()).map(of).collect();
    }

    fn into_errors(self, u_cd: impl Fn(usize) -> f64) -> Vec<DirectionError> {
        let strong = |(number, of): (usize, Vec<(usize, f64)>)| {
            let most = of.iter().fold(0.0_f64, |most, (_, change)| most.max(change.abs()));
            let u_cd = u_cd(number);
            let errors = of
                .into_iter()
                .filter(|(_, change)| change.abs() > NEGLIGIBLE * most)
                .map(|(row, change)| (row, change * u_cd))
                .collect();
            DirectionError { number, errors }
        };
        let of = self.of.into_iter().enumerate();
        of.filter(|(_, of)| !of.is_empty()).map(strong).collect()
    }
}

/// The weights of a smoothing of evenly spaced values by the squares of their third differences, from the middle
/// outward, as far as they matter; that of the middle is `own`.
fn kernel(own: f64) -> Vec<f64> {
    let lambda = lambda_of(own);
    reaching(weights(|third| passed(lambda, third), MOST_REACH))
}

/// Weights as far as they matter.
fn reaching(mut kernel: Vec<f64>) -> Vec<f64> {
    const LEAST: f64 = 0.02;
    let last = kernel.iter().rposition(|weight| weight.abs() > LEAST * kernel[0]);
    kernel.truncate(last.unwrap_or(0) + 1);
    kernel
}

/// What the least sum of Σ(x − y)² + λ·Σ(D³x)² lets through of a wave of ω per step: `third` is (2 − 2·cos ω)³.
fn passed(lambda: f64, third: f64) -> f64 {
    1.0 / (1.0 + lambda * third)
}

/// The weights, from the middle outward, of what makes of a wave of ω per step `of((2 − 2·cos ω)³)` of it.
fn weights(of: impl Fn(f64) -> f64, count: usize) -> Vec<f64> {
    const WAVES: usize = 512;
    let waves: Vec<(f64, f64)> = (0..WAVES)
        .map(|k| std::f64::consts::PI * (k as f64 + 0.5) / WAVES as f64)
        .map(|wave| (wave, of((2.0 - 2.0 * wave.cos()).powi(3))))
        .collect();
    let at = |place: usize| {
        let waves = waves.iter().map(|(wave, of)| (wave * place as f64).cos() * of);
        waves.sum::<f64>() / WAVES as f64
    };
    (0..count).map(at).collect()
}

/// The λ of the smoothing whose weight of the middle is `own`.
fn lambda_of(own: f64) -> f64 {
    // The larger λ, the less of the middle: by halving the range of its logarithm.
    let (mut low, mut high) = (-20.0_f64, 25.0_f64);
    for _ in 0..60 {
        let middle = 0.5 * (low + high);
        if weights(|third| passed(middle.exp(), third), 1)[0] > own {
            low = middle;
        } else {
            high = middle;
        }
    }
    low.exp()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// x + λ·D³ᵀD³·x is the impulse whose smoothing x is; D³ᵀD³ has the binomials of 6 with alternating signs.
    #[test]
    fn the_weights_solve_the_sum_of_squares() {
        const BINOMIALS: [f64; 7] = [-1.0, 6.0, -15.0, 20.0, -15.0, 6.0, -1.0];
        for own in [0.25, 0.4, 0.7, 0.95] {
            let lambda = lambda_of(own);
            let weights = weights(|third| passed(lambda, third), 64);
            assert!((weights[0] - own).abs() < 1e-9, "{own}: {}", weights[0]);
            let bent = |place: isize| -> f64 {
                let near = (-3..=3).zip(BINOMIALS);
                near.map(|(by, factor)| factor * weights[(place + by).unsigned_abs()])
                    .sum()
            };
            assert!((lambda / ((1.0 - weights[0]) / bent(0)) - 1.0).abs() < 1e-6);
            for place in 1..20 {
                let left = weights[place as usize] + lambda * bent(place);
                assert!(left.abs() < 1e-9, "{own} {place}: {left}");
            }
        }
    }

    #[test]
    fn a_reading_lends_its_neighbours_what_smoothing_takes_from_it() {
        let (planes, gammas, rows) = (12, 19, 3);
        let mut changes = Changes::new(planes, gammas);
        // Row 0 looks at plane 4, γ 9; row 1 at the pole; row 2 half-way between planes 0 and 11.
        changes.add(4 * gammas + 9, 0, 2.0);
        changes.add(0, 1, 1.0);
        changes.add(9, 2, 0.5);
        changes.add(11 * gammas + 9, 2, 0.5);
        changes.smooth([0.5, 0.6], rows, |ig| ig == 0 || ig == gammas - 1);
        let (along, around) = (kernel(0.5), kernel(0.6));
        let of = |ic: usize, ig: usize, row: usize| {
            let found = changes.of[ic * gammas + ig].iter().find(|(number, _)| *number == row);
            found.map_or(0.0, |(_, change)| *change)
        };
        assert!((of(4, 9, 0) - 2.0 * 0.5 * 0.6).abs() < 1e-9);
        assert!((of(5, 8, 0) - 2.0 * along[1] * around[1]).abs() < 1e-9);
        assert_eq!((of(0, 0, 1), of(0, 1, 1)), (1.0, 0.0));
        assert!((of(0, 9, 2) - 0.5 * 0.5 * (around[0] + around[1])).abs() < 1e-9);
        assert!((of(11, 9, 2) - of(0, 9, 2)).abs() < 1e-12);
    }
    /// Smoothed as `reduce` does it: the mean of the half-planes with one share, what they differ from it with another.
    #[test]
    fn the_mean_of_all_half_planes_keeps_the_noise_that_its_own_smoothing_leaves() {
        const ROWS: usize = 4;
        let (planes, gammas) = (12, 41);
        let (along, around, mean) = (0.3, 0.5, 0.9);
        // All half-planes alike around γ 20: what a sensor near the axis sees of a narrow beam. And one half-plane alone.
        let ring_weights = [(18, 0.2), (19, 0.7), (20, 1.0), (21, 0.5)];
        let mut changes = Changes::new(planes, gammas);
        for ic in 0..planes {
            for (row, (ig, weight)) in ring_weights.into_iter().enumerate() {
                changes.add(ic * gammas + ig, row, weight);
            }
        }
        let no_pole = |_: usize| false;
        let means = changes.of_means([along, mean], ROWS, no_pole);
        changes.smooth([along, around], ROWS, no_pole);
        let square = |of: &[Vec<(usize, f64)>], each: f64| -> f64 {
            let of = of.iter().map(|of| of.iter().map(|(_, change)| change).sum::<f64>());
            of.map(|sum| sum * sum).sum::<f64>() * each
        };
        let variance = square(&changes.of, 1.0) + square(&means, 1.0 / planes as f64);
        // The exact one: the mean's kernel alone on the sum over the half-planes.
        let kernel = kernel(mean);
        let exact: f64 = (0..gammas)
            .map(|ig| {
                let near = ring_weights
                    .iter()
                    .filter_map(|(at, weight)| Some(weight * kernel.get(ig.abs_diff(*at))?));
                near.sum::<f64>().powi(2) * planes as f64
            })
            .sum();
        assert!((variance / exact - 1.0).abs() < 0.02, "{variance} {exact}");
        assert!(square(&changes.of, 1.0) < 0.95 * exact);
    }
}
