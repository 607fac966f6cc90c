//! What the noise of the distribution's own directions does to predictions: one reading made each direction, and
//! whoever looks there again meets the same error again.

use isolux_record::ReadingKind;
use isolux_record::observation::{MapSet, ReadingCoordinates};

use crate::model::Model;
use crate::prepared::PreparedModel;

/// What the reading of one direction of the distribution, wrong by one standard uncertainty, does to predictions.
/// Readings are independent of each other; where the distribution was smoothed, one changes neighbouring directions too.
#[derive(Debug, Clone, PartialEq)]
pub struct DirectionError {
    /// Its number in the distribution, `[ic * ng + ig]`; the first half-plane's at a pole.
    pub direction: usize,
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
        if let Some(shares) = u.direction_share {
            changes.smooth(shares, rows, is_pole);
        }
        let u_cd = |direction: usize| {
            // At a pole every half-plane had a reading of its own.
            let readings = if is_pole(direction % gammas.len()) {
                planes as f64
            } else {
                1.0
            };
            u.of_direction_cd(distribution.intensity_cd()[direction]) / readings.sqrt()
        };
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
        let strong = |(direction, of): (usize, Vec<(usize, f64)>)| {
            let most = of.iter().fold(0.0_f64, |most, (_, change)| most.max(change.abs()));
            let u_cd = u_cd(direction);
            let errors = of
                .into_iter()
                .filter(|(_, change)| change.abs() > NEGLIGIBLE * most)
                .map(|(number, change)| (number, change * u_cd))
                .collect();
            DirectionError { direction, errors }
        };
        let of = self.of.into_iter().enumerate();
        of.filter(|(_, of)| !of.is_empty()).map(strong).collect()
    }
}

/// The [`weights`] of a smoothing, as far as they matter.
fn kernel(own: f64) -> Vec<f64> {
    const LEAST: f64 = 0.02;
    let mut kernel = weights(own, MOST_REACH);
    let last = kernel.iter().rposition(|weight| weight.abs() > LEAST * kernel[0]);
    kernel.truncate(last.unwrap_or(0) + 1);
    kernel
}

/// The weights of a smoothing of evenly spaced values by the squares of their third differences, from the middle
/// outward, that of the middle being `own`: the least sum of Σ(x − y)² + λ·Σ(D³x)² makes of a wave of ω per step
/// 1/(1 + λ·(2 − 2·cos ω)³) of it.
fn weights(own: f64, count: usize) -> Vec<f64> {
    const WAVES: usize = 512;
    let waves: Vec<(f64, f64)> = (0..WAVES)
        .map(|k| std::f64::consts::PI * (k as f64 + 0.5) / WAVES as f64)
        .map(|wave| (wave, (2.0 - 2.0 * wave.cos()).powi(3)))
        .collect();
    let at = |lambda: f64, place: usize| {
        let passed = |(wave, bend): &(f64, f64)| (wave * place as f64).cos() / (1.0 + lambda * bend);
        waves.iter().map(passed).sum::<f64>() / WAVES as f64
    };
    // The larger λ, the less of the middle: by halving the range of its logarithm.
    let (mut low, mut high) = (-20.0_f64, 25.0_f64);
    for _ in 0..60 {
        let middle = 0.5 * (low + high);
        if at(middle.exp(), 0) > own {
            low = middle;
        } else {
            high = middle;
        }
    }
    (0..count).map(|place| at(low.exp(), place)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// x + λ·D³ᵀD³·x is the impulse whose smoothing x is; D³ᵀD³ has the binomials of 6 with alternating signs.
    #[test]
    fn the_weights_solve_the_sum_of_squares() {
        const BINOMIALS: [f64; 7] = [-1.0, 6.0, -15.0, 20.0, -15.0, 6.0, -1.0];
        for own in [0.25, 0.4, 0.7, 0.95] {
            let weights = weights(own, 64);
            assert!((weights[0] - own).abs() < 1e-9, "{own}: {}", weights[0]);
            let bent = |place: isize| -> f64 {
                let near = (-3..=3).zip(BINOMIALS);
                near.map(|(by, factor)| factor * weights[(place + by).unsigned_abs()])
                    .sum()
            };
            let lambda = (1.0 - weights[0]) / bent(0);
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
        let (along, around) = (weights(0.5, 3), weights(0.6, 3));
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
}
