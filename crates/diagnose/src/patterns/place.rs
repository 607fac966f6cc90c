//! Places where readings or bins may be off together: the test of the noise looks at thousands of them, so that a place
//! is a few numbers, and its words are made of the one that is found.

use isolux_photometry::direction;

use super::shape::{Along, Shape};
use crate::noise::finding::{Finding, Kind, Strongest, digits};
use crate::table::Coordinate;

/// What readings or bins have in common, and the range of the coordinate that it touches.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Place {
    what: What,
    range: [f64; 2],
}

/// What they have in common.
#[derive(Debug, Clone, Copy)]
pub(super) enum What {
    /// Every n-th reading, from which on; the number of the first.
    Reading(usize, usize, f64),
    /// Every n-th visit of a half-plane, from which on.
    Visit(usize, usize),
    /// Every n-th column or row of bins, from which on.
    Line(Coordinate, usize, usize),
    /// From and to which of the series.
    Run(usize, usize),
    /// C, γ and width of a patch of directions, in degrees.
    Patch([f64; 3]),
    /// C and γ of the pole of a great circle, and its width, in degrees.
    Circle([f64; 3]),
    /// x, y and width of a patch of bins, in mm.
    Spot([f64; 3]),
}

impl What {
    pub(super) fn over(self, range: [f64; 2]) -> Place {
        Place { what: self, range }
    }
}

impl Place {
    /// The shape of its weights.
    pub(crate) fn shape(self) -> (Along, Shape) {
        let towards = |c_deg, gamma_deg| direction(c_deg, gamma_deg).to_array();
        match self.what {
            What::Reading(n, phase, _) | What::Visit(n, phase) | What::Line(_, n, phase) => {
                (Along::Line, Shape::Every(n, phase))
            }
            What::Run(from, to) => (Along::Line, Shape::Between(from as f64, to as f64)),
            What::Patch([c, gamma, width]) => (Along::Direction(towards(c, gamma)), Shape::Bump(0.0, width)),
            What::Circle([c, gamma, width]) => (Along::Circle(towards(c, gamma)), Shape::Bump(0.0, width)),
            What::Spot([x, y, width]) => (Along::Point([x, y]), Shape::Bump(0.0, width)),
        }
    }

    /// What is said where it is found, of values that are `sign` the model.
    pub(crate) fn finding(self, strongest: Strongest, sign: &str) -> Finding {
        let (kind, coordinate, note) = match self.what {
            What::Reading(n, _, first) => {
                let note = format!(
                    "every {} reading from number {first} on is {sign} the model",
                    ordinal(n)
                );
                (Kind::Every, Coordinate::Index, note)
            }
            What::Visit(n, phase) => {
                let (n, from) = (ordinal(n), ordinal(phase + 1));
                let note = format!("every {n} visit of a half-plane from the {from} on is {sign} the model");
                (Kind::EveryVisit, Coordinate::Index, note)
            }
            What::Line(coordinate, n, _) => {
                let of = if coordinate == Coordinate::XMm { "column" } else { "row" };
                let note = format!("every {} {of} of bins is {sign} the model", ordinal(n));
                (Kind::Lines, coordinate, note)
            }
            What::Run(from, to) => {
                let note = format!("{} successive readings are {sign} the model", to - from + 1);
                (Kind::Run, Coordinate::Index, note)
            }
            What::Patch([c_deg, gamma_deg, width]) => {
                let note = format!(
                    "a patch of neighbouring directions around C {}°, γ {}° (about {} ° wide) is {sign} the model",
                    digits(c_deg),
                    digits(gamma_deg),
                    digits(2.4 * width)
                );
                (Kind::Directions, Coordinate::GammaDeg, note)
            }
            What::Circle([c_deg, gamma_deg, width]) => {
                let note = format!(
                    "a stripe of directions {} ° wide, across C {}° and {} ° from the pole, is {sign} the model",
                    digits(2.4 * width),
                    digits(c_deg),
                    digits(90.0 - gamma_deg)
                );
                (Kind::GreatCircle, Coordinate::GammaDeg, note)
            }
            What::Spot([x, y, _]) => {
                let (x, y) = (digits(x), digits(y));
                let note = format!("a patch of bins around x {x} mm, y {y} mm is {sign} the model");
                (Kind::Bins, Coordinate::XMm, note)
            }
        };
        let mut finding = Finding::new(kind, coordinate, self.range, strongest, note);
        match self.what {
            What::Reading(n, ..) => finding.period = Some(n as f64),
            What::Patch(patch) => finding.direction = Some(patch),
            _ => {}
        }
        finding
    }
}

/// Places whose weights are the same for rows that are near each other: these share a cell.
pub(crate) struct Grid<'a> {
    /// Where a row is; none where it is in no cell.
    pub(crate) at: Box<dyn Fn(usize) -> Option<[f64; 3]> + 'a>,
    /// The width of a cell.
    pub(crate) cell: f64,
    pub(crate) places: Vec<Place>,
}

/// Cells in the width of a bump.
const CELLS_A_WIDTH: f64 = 4.0;

impl<'a> Grid<'a> {
    /// Places along one coordinate.
    pub(super) fn line(cell: f64, places: Vec<Place>, at: impl Fn(usize) -> Option<f64> + 'a) -> Self {
        Self {
            at: Box::new(move |i| Some([at(i)?, 0.0, 0.0])),
            cell,
            places,
        }
    }

    /// Bumps of one width.
    pub(super) fn bumps(width: f64, places: Vec<Place>, at: impl Fn(usize) -> Option<[f64; 3]> + 'a) -> Self {
        Self {
            at: Box::new(at),
            cell: width / CELLS_A_WIDTH,
            places,
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
