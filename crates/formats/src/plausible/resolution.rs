//! The resolution of a file's numbers: their last decimal, or the coarser step of the meter's display.

use super::Stored;

/// Values that are looked at for their decimals, and planes for their steps.
const VALUES: usize = 500;
const PLANES: usize = 24;
/// A display's step is this part of the peak at most.
const COARSEST: f64 = 0.01;
/// Differences below this part of a step are none: the distance to the lamp scales every reading a little differently.
const NONE: f64 = 0.1;
/// Fewest differences of none, and of one to three steps.
const FEWEST: (usize, usize) = (5, 10);

/// The step between values that the file can tell apart, and what it is taken from, so that it can be found again when two
/// values are exchanged.
pub(super) struct Resolution {
    /// Decimals of every so many values.
    decimals: Vec<i32>,
    /// Every so many values and planes are looked at.
    every: (usize, usize),
    peak: f64,
    /// Small differences along γ, the smallest first.
    small: Vec<f64>,
}

impl Resolution {
    pub fn of(stored: &Stored<'_>) -> Self {
        let (values, ng) = (stored.values, stored.angles_deg.len().max(1));
        let planes = (values.len() / ng).max(1);
        let every = (values.len() / VALUES + 1, planes.div_ceil(PLANES));
        let peak = values.iter().fold(0.0_f64, |most, value| most.max(value.abs()));
        let rows = values.chunks_exact(ng).step_by(every.1);
        let mut small: Vec<f64> = rows
            .flat_map(|row| row.windows(2))
            .filter_map(|pair| small(pair, peak))
            .collect();
        small.sort_unstable_by(f64::total_cmp);
        Self {
            decimals: (0..values.len())
                .step_by(every.0)
                .map(|index| decimals_of(stored, index))
                .collect(),
            every,
            peak,
            small,
        }
    }

    /// The step, in the file's unit.
    pub fn step(&self) -> f64 {
        step(self.decimals.iter().copied().max(), &self.small, self.peak)
    }

    /// The step after `one` and `other` were exchanged, which gave `values`.
    pub fn exchanged(&self, stored: &Stored<'_>, values: &[f64], one: usize, other: usize) -> f64 {
        let ng = stored.angles_deg.len();
        let after = |at: usize| match at * self.every.0 {
            index if index == one => decimals_of(stored, other),
            index if index == other => decimals_of(stored, one),
            _ => self.decimals[at],
        };
        let decimals = (0..self.decimals.len()).map(after).max();
        let mut pairs: Vec<usize> = [one, other]
            .into_iter()
            .filter(|index| (index / ng).is_multiple_of(self.every.1))
            .flat_map(|index| {
                let (row, at) = (index / ng * ng, index % ng);
                [at.checked_sub(1), Some(at)]
                    .into_iter()
                    .flatten()
                    .map(move |at| row + at)
            })
            .filter(|pair| pair % ng + 1 < ng)
            .collect();
        pairs.sort_unstable();
        pairs.dedup();
        let mut differences = self.small.clone();
        for &pair in &pairs {
            if let Some(old) = small(&stored.values[pair..pair + 2], self.peak) {
                let at = differences.partition_point(|&difference| difference < old);
                differences.remove(at);
            }
        }
        for &pair in &pairs {
            if let Some(new) = small(&values[pair..pair + 2], self.peak) {
                let at = differences.partition_point(|&difference| difference < new);
                differences.insert(at, new);
            }
        }
        step(decimals, &differences, self.peak)
    }
}

fn step(decimals: Option<i32>, small: &[f64], peak: f64) -> f64 {
    let decimal = 10f64.powi(-decimals.unwrap_or(0).min(12));
    display(small, peak).map_or(decimal, |step| step.max(decimal))
}

/// The largest number of decimals among some hundred values, zeros at their end not counted.
pub(super) fn decimals(stored: &Stored<'_>) -> i32 {
    let some = (0..stored.values.len()).step_by(stored.values.len() / VALUES + 1);
    some.map(|index| decimals_of(stored, index)).max().unwrap_or(0).min(12)
}

/// The number of decimals of a value, zeros at their end not counted.
fn decimals_of(stored: &Stored<'_>, index: usize) -> i32 {
    let text = (stored.raw)(index);
    let point = text.bytes().rposition(|byte| matches!(byte, b'.' | b','));
    point.map_or(0, |at| text[at + 1..].trim_end_matches('0').len()) as i32
}

/// A difference small enough to be a display's step; none between zeros.
fn small(pair: &[f64], peak: f64) -> Option<f64> {
    let difference = (pair[1] - pair[0]).abs();
    ((pair[0] != 0.0 || pair[1] != 0.0) && difference <= 3.0 * COARSEST * peak).then_some(difference)
}

/// Neighbours along γ of a rounded display differ by nothing or by whole steps, and by nothing between.
fn display(small: &[f64], peak: f64) -> Option<f64> {
    let gap = |at: &usize| {
        let step = small[*at];
        let like = || small[*at..].partition_point(|&difference| difference <= 3.0 * step);
        step <= COARSEST * peak && small[at - 1] <= NONE * step && like() >= FEWEST.1
    };
    (FEWEST.0..small.len()).rev().find(gap).map(|at| small[at])
}

#[cfg(test)]
mod tests {
    use super::*;

    fn steps(values: &[f64], ng: usize) -> Option<f64> {
        let angles_deg: Vec<f64> = (0..ng).map(|angle| angle as f64).collect();
        let stored = Stored {
            planes_deg: &[],
            angles_deg: &angles_deg,
            values,
            places: &[],
            raw: &|_| "0.000000000001",
            poles: true,
            ends_with_newline: true,
            unit_cd: 1.0,
        };
        let resolution = Resolution::of(&stored);
        display(&resolution.small, resolution.peak)
    }

    #[test]
    fn a_display_shows_in_the_steps_and_smooth_light_has_none() {
        let lobe = |at: usize| 1000.0 * (at as f64).to_radians().cos().powi(3);
        let smooth: Vec<f64> = (0..90).map(lobe).collect();
        assert_eq!(steps(&smooth, 90), None);
        // Rounded to 3, and scaled by distances that differ by a thousandth.
        let shown: Vec<f64> = (0..270)
            .map(|at| (lobe(at % 90) / 3.0).round() * 3.0 * (1.0 + 1e-5 * at as f64))
            .collect();
        let step = steps(&shown, 90).unwrap();
        assert!((2.9..3.1).contains(&step), "{step}");
    }
}
