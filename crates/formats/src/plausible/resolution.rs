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

/// The step between values that the file can tell apart, in its unit.
pub(super) fn resolution(stored: &Stored<'_>) -> f64 {
    let decimal = 10f64.powi(-decimals(stored));
    steps(stored.values, stored.angles_deg.len()).map_or(decimal, |step| step.max(decimal))
}

/// The largest number of decimals among some hundred values, zeros at their end not counted.
pub(super) fn decimals(stored: &Stored<'_>) -> i32 {
    let count = |index: usize| {
        let text = (stored.raw)(index);
        let point = text.bytes().rposition(|byte| matches!(byte, b'.' | b','));
        point.map_or(0, |at| text[at + 1..].trim_end_matches('0').len())
    };
    let some = (0..stored.values.len()).step_by(stored.values.len() / VALUES + 1);
    some.map(count).max().unwrap_or(0).min(12) as i32
}

/// Neighbours along γ of a rounded display differ by nothing or by whole steps, and by nothing between.
fn steps(values: &[f64], ng: usize) -> Option<f64> {
    let peak = values.iter().fold(0.0_f64, |most, value| most.max(value.abs()));
    let planes = (values.len() / ng.max(1)).max(1);
    let rows = values.chunks_exact(ng.max(1)).step_by(planes.div_ceil(PLANES));
    let pairs = rows
        .flat_map(|row| row.windows(2))
        .filter(|pair| pair[0] != 0.0 || pair[1] != 0.0);
    let differences = pairs.map(|pair| (pair[1] - pair[0]).abs());
    let mut small: Vec<f64> = differences
        .filter(|&difference| difference <= 3.0 * COARSEST * peak)
        .collect();
    small.sort_unstable_by(f64::total_cmp);
    let gap = |at: &usize| {
        let step = small[*at];
        let like = small[*at..].partition_point(|&difference| difference <= 3.0 * step);
        step <= COARSEST * peak && small[at - 1] <= NONE * step && like >= FEWEST.1
    };
    (FEWEST.0..small.len()).rev().find(gap).map(|at| small[at])
}

#[cfg(test)]
mod tests {
    use super::*;

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
