//! The thirteen numbers of LM-63 against their definitions, against each other and against the light; single angles
//! against their row.

use isolux_photometry::IntensityDistribution;

use super::edition::Edition;
use super::lamp::Lamp;
use super::layout::{Layout, Token};
use super::shape::Shape;
use crate::finding::{Finding, Findings};
use crate::ratings;

/// More lamps than this are another number.
const MOST_LAMPS: f64 = 1000.0;
/// Beyond this no side of a luminous opening is believed, in m.
const LARGEST_M: f64 = 6.0;
/// A row of angles shorter than this has no step to speak of.
const SHORTEST_ROW: usize = 5;

/// What was read, and where.
pub(super) struct Numbers<'n, 't> {
    pub tokens: &'n [Token<'t>],
    /// Index of the number of lamps.
    pub start: usize,
    pub layout: &'n Layout,
    pub lamp: &'n Lamp,
    pub vertical: &'n [f64],
    pub horizontal: &'n [f64],
}

/// Says which of the numbers cannot be meant.
pub(super) fn check(numbers: &Numbers<'_, '_>, grid: &IntensityDistribution, findings: &mut Findings) {
    numbers.lamps(findings);
    numbers.opening(findings);
    numbers.ratings(grid, findings);
    numbers.lone_angle(numbers.layout.vertical, numbers.vertical, "vertical", findings);
    numbers.lone_angle(numbers.layout.horizontal, numbers.horizontal, "horizontal", findings);
}

impl Numbers<'_, '_> {
    fn at(&self, index: usize, finding: Finding) -> Finding {
        match self.tokens.get(index) {
            Some(token) => finding.at(token.line + 1, token.column).raw(token.text),
            None => finding,
        }
    }

    fn lamps(&self, findings: &mut Findings) {
        let Some(count) = self.lamp.count else { return };
        let dim = self
            .lamp
            .lumens_per_lamp
            .filter(|&lumens| ratings::dim(count, count * lumens));
        let message = match dim {
            Some(lumens) => format!("{count} lamps of {lumens} lm each"),
            None if count > MOST_LAMPS => format!("{count} are no number of lamps"),
            None => return,
        };
        let finding = Finding::warning("ies-lamp-count", message).assumed("as it stands");
        let fix = "check the order of the ten numbers; the lumens of one lamp stand second";
        findings.push(self.at(self.start, finding.fix(fix)));
    }

    /// Width, length and height: a shape that the standard has, of a size that a luminaire has.
    fn opening(&self, findings: &mut Findings) {
        let [Some(width), Some(length), Some(height)] = self.lamp.opening else {
            return;
        };
        if let shape @ (Shape::Line | Shape::Unknown) = Shape::of([width, length, height], Edition::E2002) {
            let message = format!("an opening of {width} × {length} × {height} is no shape of the standard");
            let finding = Finding::warning("ies-opening", message)
                .assumed(if shape == Shape::Line {
                    "a line, without an area"
                } else {
                    "no known shape"
                })
                .fix(
                    "a rectangle has width and length above zero, a circle negative ones; check the order of the three",
                );
            findings.push(self.at(self.start + 7, finding));
        }
        let Some(metres) = self.lamp.metres else { return };
        for (offset, (value, what)) in [(width, "wide"), (length, "long"), (height, "high")]
            .into_iter()
            .enumerate()
        {
            let size = value.abs() * metres;
            if size > LARGEST_M {
                let finding = Finding::warning("ies-opening", format!("the luminous opening is {size:.1} m {what}"))
                    .assumed("as it stands")
                    .fix("check the unit (1 feet, 2 metres) and the order of the numbers");
                findings.push(self.at(self.start + 7 + offset, finding));
            }
        }
    }

    /// Lumens, candela and watts against each other.
    fn ratings(&self, grid: &IntensityDistribution, findings: &mut Findings) {
        let integral = grid.flux().value();
        let stated = self.lamp.flux_lm();
        let (Some(watts), Some(at)) = (self.lamp.watts, self.layout.factors) else {
            return;
        };
        // Without stated lumens the light itself may be counted in other units, as ultraviolet is in mW: too little of
        // it says nothing.
        let rounded = (integral * 10.0).round() / 10.0;
        let message = match stated {
            Some(lamps) => ratings::efficacy(lamps, watts),
            None => ratings::efficacy(rounded, watts).filter(|_| rounded > watts),
        };
        if let Some(message) = message {
            let finding = Finding::warning("flux-efficacy", message)
                .assumed("as it stands")
                .fix("check lumens, multiplier and input watts; two numbers may have changed places");
            findings.push(self.at(at + 2, finding));
        }
    }

    /// One angle that alone keeps a row from having one step.
    fn lone_angle(&self, from: usize, row: &[f64], name: &str, findings: &mut Findings) {
        let Some(at) = off_the_step(row) else { return };
        let even = 0.5 * (row[at - 1] + row[at + 1]);
        let message = format!("all {name} angles but this one have one step; it would be {even}°");
        let finding = Finding::warning("ies-angle-step", message)
            .assumed("the angle as it stands")
            .fix(format!("write {even} if that is meant"));
        findings.push(self.at(from + at, finding));
    }
}

/// The inner angle without which the row has one step.
fn off_the_step(row: &[f64]) -> Option<usize> {
    if row.len() < SHORTEST_ROW {
        return None;
    }
    let step = (row[row.len() - 1] - row[0]) / (row.len() - 1) as f64;
    let off = |at: usize| (row[at] - row[0] - step * at as f64).abs() > 1e-3 * step;
    let mut odd = (1..row.len() - 1).filter(|&at| off(at));
    let at = odd.next()?;
    odd.next().is_none().then_some(at)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn one_angle_off_its_step() {
        let even: Vec<f64> = (0..19).map(|at| 5.0 * f64::from(at)).collect();
        assert_eq!(off_the_step(&even), None);
        let mut odd = even.clone();
        odd[7] = 37.0;
        assert_eq!(off_the_step(&odd), Some(7));
        odd[9] = 46.0;
        assert_eq!(off_the_step(&odd), None);
        assert_eq!(off_the_step(&[0.0, 30.0, 50.0, 90.0]), None);
    }
}
