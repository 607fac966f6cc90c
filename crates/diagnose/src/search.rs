//! From residuals to a set of effects, stage by stage: `estimate` (the baseline), `scanned`, `select`, `compete`. Each
//! is a function of what the one before found; the report of a diagnosis ([`crate::diagnosis`]) is the last.

mod candidates;
mod comparison;
mod compete;
mod empirical;
mod estimate;
mod fits;
mod grow;
mod outcome;
mod problem;
mod remains;
mod scanned;
mod select;

use crate::forward::Forward;
use crate::rounding::hides_noise;
use crate::steps::Stepped;
use crate::table::{ObservationKind, Row};
use crate::whitening::Sequence;

pub use outcome::{Comparison, Label, Outcome, Place, Ranked, Settings, Unexplained};

/// Searches. None where the model cannot even predict these rows.
pub fn search(forward: &dyn Forward, rows: &[Row], settings: &Settings) -> Option<Outcome> {
    let sequence = in_time(rows);
    let plain = problem::Plain::of(forward, rows, &sequence)?;
    let stepped = Stepped::of(forward, &plain.light, &(&plain.measured - &plain.light), &plain.u);
    let problem = problem::Problem::new(&stepped, rows, &sequence, settings, plain);
    let baseline = estimate::baseline(&problem)?;
    let scanned = scanned::scan(&baseline);
    let selected = select::select(baseline, &scanned)?;
    compete::compete(scanned, selected)
}

/// The rows in time. Those that show no noise say nothing of its serial correlation: twenty dark readings of one digit
/// are one rounding.
fn in_time(rows: &[Row]) -> Sequence {
    let run: Vec<usize> = rows.iter().map(|row| row.file).collect();
    let ordered = |row: &Row| match row.source {
        ObservationKind::Reading if !hides_noise(row) => row.time_s,
        _ => f64::NAN,
    };
    let time: Vec<f64> = rows.iter().map(ordered).collect();
    Sequence::by_time(&run, &time)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn readings_that_show_their_digit_alone_are_no_neighbours_in_time() {
        let neighbours = |digit: f64| {
            let row = |i: i32| Row {
                digit,
                time_s: f64::from(i),
                ..Row::bare(ObservationKind::Reading, 0.01, 0.003)
            };
            in_time(&(0..20).map(row).collect::<Vec<_>>()).has_neighbours()
        };
        // u = 0.003: digit/√12 = 0.0029 and a scatter of 0.0008, or digit/√12 = 0.0014 and a scatter of 0.0026.
        assert!(!neighbours(0.01) && neighbours(0.005) && neighbours(0.0));
    }
}
