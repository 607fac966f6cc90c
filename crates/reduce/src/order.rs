//! The rows of a run in the order of their numbers, each once: whatever order they are given in, a reduction is the
//! same.

use std::borrow::Cow;
use std::cmp::Ordering;

use isolux_record::{Reading, Run};

/// The run with its rows by number; the run itself where they are.
pub fn in_order(run: &Run) -> Cow<'_, Run> {
    let rows = &run.readings.rows;
    if rows.windows(2).all(|pair| pair[0].index < pair[1].index) {
        return Cow::Borrowed(run);
    }
    let mut ordered = run.clone();
    ordered.readings.rows.sort_by(order);
    ordered.readings.rows.dedup();
    Cow::Owned(ordered)
}

/// By number. Rows that have the same number and are no copies are of a record that was put together: what they hold
/// decides.
fn order(a: &Reading, b: &Reading) -> Ordering {
    let numbers = |row: &Reading| {
        [
            row.time_s.unwrap_or(f64::NEG_INFINITY),
            row.lamp_s.unwrap_or(f64::NEG_INFINITY),
            row.c_deg,
            row.gamma_deg,
            row.distance_mm,
            row.illuminance_lx.unwrap_or(f64::NEG_INFINITY),
            row.u_lx.unwrap_or(f64::NEG_INFINITY),
        ]
    };
    let by_numbers = || {
        let pairs = numbers(a).into_iter().zip(numbers(b));
        pairs.fold(Ordering::Equal, |order, (a, b)| order.then(a.total_cmp(&b)))
    };
    a.index
        .cmp(&b.index)
        .then(a.kind.cmp(&b.kind))
        .then(a.point.cmp(&b.point))
        .then(a.repeat.cmp(&b.repeat))
        .then_with(by_numbers)
}
