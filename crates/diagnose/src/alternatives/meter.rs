//! Patterns of the meter and its room: range, expected signal, temperature.

use super::{Builder, word};
use crate::pattern::Acts;
use crate::table::{Coordinate, ObservationKind, Row};

pub(super) fn range(build: &mut Builder<'_>) {
    let ranges = build.distinct(ObservationKind::Reading, Coordinate::Range);
    if ranges.len() < 2 {
        return;
    }
    for &here in &ranges {
        let (at, range) = (move |row: &Row| f64::from(row.range == here), [here, here]);
        let inside = move |level: f64, row: &Row| at(row) * level;
        let levels = build.rows.iter().zip(build.level.iter());
        let top = levels.map(|(row, level)| inside(*level, row)).fold(0.0, f64::max);
        let mut along = build.along(ObservationKind::Reading, Coordinate::Range);
        for acts in [Acts::Relative, Acts::Everywhere] {
            along.one(acts, "jump", range, format!("{} in one range", word(acts)), at);
        }
        if top > 0.0 {
            along.of_level("slope", range, "a non-linearity inside one range", move |level, row| {
                inside(level, row) / top
            });
        }
    }
}

pub(super) fn signal_level(build: &mut Builder<'_>, source: ObservationKind) {
    let levels = build.rows.iter().zip(build.level.iter());
    let own = levels.filter(|(row, _)| row.source == source).map(|(_, level)| *level);
    let top = own.fold(0.0, f64::max);
    if top <= 0.0 {
        return;
    }
    let mut along = build.along(source, Coordinate::Level);
    let share = move |level: f64| (level / top).max(1e-9);
    let whole = [0.0, top];
    for power in [0.5, 2.0, 4.0] {
        along.of_level(
            "smooth",
            whole,
            format!("a relative change ∝ signal^{power}"),
            move |level, _| share(level).powf(power),
        );
    }
    let note = "a relative change with the logarithm of the signal";
    along.of_level("smooth", whole, note, move |level, _| share(level).ln());
    for edge in [0.03, 0.1, 0.3, 0.5, 0.7, 0.85, 0.95] {
        let above = [edge * top, top];
        along.of_level("knee", above, "a signal that bends above one level", move |level, _| {
            (share(level) - edge).max(0.0)
        });
        along.of_level("jump", above, "a relative change above one level", move |level, _| {
            f64::from(share(level) > edge)
        });
        if edge <= 0.3 {
            let below = [0.0, edge * top];
            along.of_level("knee", below, "a signal that bends at low level", move |level, _| {
                (-share(level) / edge).exp()
            });
        }
    }
}

pub(super) fn ambient(build: &mut Builder<'_>, order: &[usize]) {
    let temperatures = build.distinct(ObservationKind::Reading, Coordinate::AmbientC);
    let (Some(&low), Some(&high)) = (temperatures.first(), temperatures.last()) else {
        return;
    };
    if high - low < 1e-6 {
        return;
    }
    let rows = build.rows;
    let mut along = build.along(ObservationKind::Reading, Coordinate::AmbientC);
    let (middle, half) = (0.5 * (low + high), 0.5 * (high - low));
    let (place, whole) = (move |row: &Row| (row.ambient_c - middle) / half, [low, high]);
    along.relative("smooth", whole, "a curved change with temperature", move |row| {
        place(row).powi(2)
    });
    for acts in [Acts::Light, Acts::Everywhere] {
        along.one(acts, "smooth", whole, "an added signal with temperature", place);
    }
    for edge in [-0.5, 0.0, 0.5] {
        let from = middle + edge * half;
        along.relative(
            "jump",
            [from, high],
            "a relative change above one temperature",
            move |row| f64::from(place(row) > edge),
        );
    }
    let in_time: Vec<usize> = order
        .iter()
        .copied()
        .filter(|&i| rows[i].source == ObservationKind::Reading && rows[i].ambient_c.is_finite())
        .collect();
    for lag_s in [100.0, 300.0, 1000.0] {
        let mut lagged = vec![0.0; rows.len()];
        let mut average = in_time.first().map_or(0.0, |&i| rows[i].ambient_c);
        for (k, &i) in in_time.iter().enumerate() {
            let gap = if k == 0 {
                0.0
            } else {
                rows[i].time_s - rows[in_time[k - 1]].time_s
            };
            let keep = (-gap.max(0.0) / lag_s).exp();
            average = keep * average + (1.0 - keep) * rows[i].ambient_c;
            lagged[i] = (rows[i].ambient_c - average) / half;
        }
        let column = along.column(Acts::Relative, move |i, _| lagged[i]);
        along.add("lag", whole, "a change with the rate of temperature", vec![column]);
    }
}
