//! Patterns of the meter and its room: range, expected signal, temperature.

use super::{Builder, word};
use crate::pattern::Acts;
use crate::table::{Coordinate, Row, Source};

pub(super) fn range(build: &mut Builder<'_>) {
    let ranges = build.distinct(Source::Reading, Coordinate::Range);
    if ranges.len() < 2 {
        return;
    }
    for &here in &ranges {
        let at = move |row: &Row| f64::from(row.range == here);
        for acts in [Acts::Relative, Acts::Everywhere] {
            let column = build.column(Source::Reading, acts, move |_, row| at(row));
            build.add(
                Coordinate::Range,
                "jump",
                [here, here],
                format!("{} in one range", word(acts)),
                vec![column],
            );
        }
        let inside = move |level: f64, row: &Row| at(row) * level;
        let top = build
            .rows
            .iter()
            .zip(build.level.iter())
            .map(|(row, level)| inside(*level, row))
            .fold(0.0, f64::max);
        if top > 0.0 {
            let column = build.of_level(Source::Reading, Acts::Relative, move |level, row| {
                inside(level, row) / top
            });
            build.add(
                Coordinate::Range,
                "slope",
                [here, here],
                "a non-linearity inside one range",
                vec![column],
            );
        }
    }
}

pub(super) fn signal_level(build: &mut Builder<'_>, source: Source) {
    let top = build
        .rows
        .iter()
        .zip(build.level.iter())
        .filter(|(row, _)| row.source == source)
        .map(|(_, level)| *level)
        .fold(0.0, f64::max);
    if top <= 0.0 {
        return;
    }
    let share = move |level: f64| (level / top).max(1e-9);
    for power in [0.5, 2.0, 4.0] {
        let column = build.of_level(source, Acts::Relative, move |level, _| share(level).powf(power));
        build.add(
            Coordinate::Level,
            "smooth",
            [0.0, top],
            format!("a relative change ∝ signal^{power}"),
            vec![column],
        );
    }
    let column = build.of_level(source, Acts::Relative, move |level, _| share(level).ln());
    build.add(
        Coordinate::Level,
        "smooth",
        [0.0, top],
        "a relative change with the logarithm of the signal",
        vec![column],
    );
    for edge in [0.03, 0.1, 0.3, 0.5, 0.7, 0.85, 0.95] {
        let column = build.of_level(source, Acts::Relative, move |level, _| (share(level) - edge).max(0.0));
        build.add(
            Coordinate::Level,
            "knee",
            [edge * top, top],
            "a signal that bends above one level",
            vec![column],
        );
        let column = build.of_level(source, Acts::Relative, move |level, _| f64::from(share(level) > edge));
        build.add(
            Coordinate::Level,
            "jump",
            [edge * top, top],
            "a relative change above one level",
            vec![column],
        );
        if edge <= 0.3 {
            let column = build.of_level(source, Acts::Relative, move |level, _| (-share(level) / edge).exp());
            build.add(
                Coordinate::Level,
                "knee",
                [0.0, edge * top],
                "a signal that bends at low level",
                vec![column],
            );
        }
    }
}

pub(super) fn ambient(build: &mut Builder<'_>, order: &[usize]) {
    let temperatures = build.distinct(Source::Reading, Coordinate::AmbientC);
    let (Some(&low), Some(&high)) = (temperatures.first(), temperatures.last()) else {
        return;
    };
    if high - low < 1e-6 {
        return;
    }
    let (middle, half) = (0.5 * (low + high), 0.5 * (high - low));
    let place = move |row: &Row| (row.ambient_c - middle) / half;
    let column = build.column(Source::Reading, Acts::Relative, move |_, row| place(row).powi(2));
    build.add(
        Coordinate::AmbientC,
        "smooth",
        [low, high],
        "a curved change with temperature",
        vec![column],
    );
    for acts in [Acts::Light, Acts::Everywhere] {
        let column = build.column(Source::Reading, acts, move |_, row| place(row));
        build.add(
            Coordinate::AmbientC,
            "smooth",
            [low, high],
            "an added signal with temperature",
            vec![column],
        );
    }
    for edge in [-0.5, 0.0, 0.5] {
        let column = build.column(Source::Reading, Acts::Relative, move |_, row| {
            f64::from(place(row) > edge)
        });
        let from = middle + edge * half;
        build.add(
            Coordinate::AmbientC,
            "jump",
            [from, high],
            "a relative change above one temperature",
            vec![column],
        );
    }
    let in_time: Vec<usize> = order
        .iter()
        .copied()
        .filter(|&i| build.rows[i].source == Source::Reading && build.rows[i].ambient_c.is_finite())
        .collect();
    for lag_s in [100.0, 300.0, 1000.0] {
        let mut lagged = vec![0.0; build.rows.len()];
        let mut average = in_time.first().map_or(0.0, |&i| build.rows[i].ambient_c);
        for (k, &i) in in_time.iter().enumerate() {
            let gap = if k == 0 {
                0.0
            } else {
                build.rows[i].time_s - build.rows[in_time[k - 1]].time_s
            };
            let keep = (-gap.max(0.0) / lag_s).exp();
            average = keep * average + (1.0 - keep) * build.rows[i].ambient_c;
            lagged[i] = (build.rows[i].ambient_c - average) / half;
        }
        let column = build.column(Source::Reading, Acts::Relative, move |i, _| lagged[i]);
        build.add(
            Coordinate::AmbientC,
            "lag",
            [low, high],
            "a change with the rate of temperature",
            vec![column],
        );
    }
}
