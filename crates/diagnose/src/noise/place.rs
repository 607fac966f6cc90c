//! What readings that are off together have in common, and how a finding says it.

use super::finding::{Kind, digits};
use super::series::Series;
use crate::table::Coordinate;

/// What they have in common.
#[derive(Clone, Copy)]
pub(super) enum What {
    /// Every so-manieth reading, from which.
    Every(usize, usize),
    /// Every so-manieth visit of a half-plane, from which.
    Visits(usize, usize),
    /// Columns or rows of bins.
    Lines(Coordinate, usize),
    /// From and to which of the series.
    Run(usize, usize),
    /// C, γ and width in degrees.
    Directions(f64, f64, f64),
    /// C and γ of the pole of a great circle, and its width, in degrees.
    Circle(f64, f64, f64),
    /// x, y and width in mm.
    Bins(f64, f64, f64),
}

impl What {
    /// Kind, coordinate, range along it and words, for a place that is `sign` the model.
    pub(super) fn stated(self, series: &Series<'_>, sign: &str) -> (Kind, Coordinate, [f64; 2], String) {
        match self {
            What::Every(n, phase) => {
                let (first, last) = (series.index[0], series.index[series.len() - 1]);
                let from = (0..series.len())
                    .find(|&i| (series.index[i].round() as i64).rem_euclid(n as i64) == phase as i64)
                    .map_or(0.0, |i| series.index[i]);
                let note = format!("every {} reading from number {from} on is {sign} the model", ordinal(n));
                (Kind::Every, Coordinate::Index, [first, last], note)
            }
            What::Visits(n, phase) => {
                let (first, last) = (series.index[0], series.index[series.len() - 1]);
                let note = format!(
                    "every {} visit of a half-plane from the {} on is {sign} the model",
                    ordinal(n),
                    ordinal(phase + 1)
                );
                (Kind::EveryVisit, Coordinate::Index, [first, last], note)
            }
            What::Lines(coordinate, n) => {
                let reach = series.rows.iter().fold(0.0_f64, |most, row| most.max(row.x_mm.abs()));
                let of = if coordinate == Coordinate::XMm { "column" } else { "row" };
                let note = format!("every {} {of} of bins is {sign} the model", ordinal(n));
                (Kind::Lines, coordinate, [-reach, reach], note)
            }
            What::Run(from, to) => {
                let note = format!("{} successive readings are {sign} the model", to - from + 1);
                (
                    Kind::Run,
                    Coordinate::Index,
                    [series.index[from], series.index[to]],
                    note,
                )
            }
            What::Directions(c_deg, gamma_deg, width) => {
                let note = format!(
                    "a patch of neighbouring directions around C {}°, γ {}° (about {} ° wide) is {sign} the model",
                    digits(c_deg),
                    digits(gamma_deg),
                    digits(2.4 * width)
                );
                let range = [gamma_deg - 1.2 * width, gamma_deg + 1.2 * width];
                (Kind::Directions, Coordinate::GammaDeg, range, note)
            }
            What::Circle(c_deg, gamma_deg, width) => {
                let note = format!(
                    "a stripe of directions {} ° wide, across C {}° and {} ° from the pole, is {sign} the model",
                    digits(2.4 * width),
                    digits(c_deg),
                    digits(90.0 - gamma_deg)
                );
                let reach = series
                    .rows
                    .iter()
                    .fold(0.0_f64, |most, row| most.max(row.gamma_deg.abs()));
                (Kind::GreatCircle, Coordinate::GammaDeg, [-reach, reach], note)
            }
            What::Bins(x, y, width) => {
                let note = format!(
                    "a patch of bins around x {} mm, y {} mm is {sign} the model",
                    digits(x),
                    digits(y)
                );
                (Kind::Bins, Coordinate::XMm, [x - 1.2 * width, x + 1.2 * width], note)
            }
        }
    }
}

/// The number of a place in English: 1st, 2nd, 3rd, 4th, 11th, 21st.
fn ordinal(n: usize) -> String {
    let suffix = match (n % 100, n % 10) {
        (11..=13, _) => "th",
        (_, 1) => "st",
        (_, 2) => "nd",
        (_, 3) => "rd",
        _ => "th",
    };
    format!("{n}{suffix}")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ordinals_are_english() {
        for (n, word) in [
            (1, "1st"),
            (2, "2nd"),
            (3, "3rd"),
            (4, "4th"),
            (11, "11th"),
            (12, "12th"),
            (13, "13th"),
            (21, "21st"),
            (102, "102nd"),
            (112, "112th"),
        ] {
            assert_eq!(ordinal(n), word);
        }
    }
}
