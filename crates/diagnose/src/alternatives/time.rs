//! Patterns along time, and those that remember the readings before.

use std::sync::Arc;

use super::{Builder, word};
use crate::pattern::Acts;
use crate::table::{self, Coordinate, ObservationKind, Row};

pub(super) fn time(build: &mut Builder<'_>) {
    let mut times: Vec<f64> = build
        .rows
        .iter()
        .filter(|row| row.source == ObservationKind::Reading && row.time_s.is_finite())
        .map(|row| row.time_s)
        .collect();
    times.sort_by(f64::total_cmp);
    let (Some(&first), Some(&last)) = (times.first(), times.last()) else {
        return;
    };
    if last <= first {
        return;
    }
    let at = |quantile: f64| times[((times.len() - 1) as f64 * quantile) as usize];
    let place = move |row: &Row| (row.time_s - first) / (last - first);
    let mut along = build.along(ObservationKind::Reading, Coordinate::TimeS);
    for acts in [Acts::Relative, Acts::Light, Acts::Everywhere] {
        // The constant is the level (relative) or has a name (stray light, offset).
        let from = 1;
        for terms in [2, 4] {
            let columns: Vec<_> = (from..from + terms)
                .map(|k| std::f64::consts::PI * k as f64)
                .map(|turn| along.column(acts, move |_, row| (turn * place(row)).cos()))
                .collect();
            along.add(
                "smooth",
                [first, last],
                format!("{} that varies smoothly", word(acts)),
                columns,
            );
        }
        for step in 1..40 {
            let from = at(step as f64 / 40.0);
            along.one(
                acts,
                "jump",
                [from, last],
                format!("{} from then on", word(acts)),
                move |row| f64::from(row.time_s > from),
            );
        }
        for parts in [8_usize, 16, 32] {
            for half in 0..2 * parts - 1 {
                let from = at(half as f64 / (2 * parts) as f64);
                let to = at((half + 2) as f64 / (2 * parts) as f64);
                along.one(
                    acts,
                    "window",
                    [from, to],
                    format!("{} for a while", word(acts)),
                    move |row| f64::from(row.time_s >= from && row.time_s <= to),
                );
                if acts != Acts::Everywhere {
                    let (centre, width) = (0.5 * (from + to), 0.35 * (to - from).max(1e-9));
                    let note = format!("{} that rises and falls", word(acts));
                    along.one(acts, "bump", [from, to], note, move |row| {
                        (-0.5 * ((row.time_s - centre) / width).powi(2)).exp()
                    });
                }
            }
        }
        // A relative oscillation has a name: modulated light.
        for cycles in (2..=20).filter(|_| acts != Acts::Relative) {
            let turn = std::f64::consts::TAU * f64::from(cycles) / 2.0;
            along.waves(
                acts,
                "periodic",
                [first, last],
                "an added signal that oscillates",
                move |row| (turn * place(row), 1.0),
            );
        }
    }
}

/// Patterns that depend on the readings before: lag of the reading, fatigue, transients after a pause.
pub(super) fn memory(build: &mut Builder<'_>, order: &[usize]) {
    let mut in_time: Vec<usize> = order
        .iter()
        .copied()
        .filter(|&i| build.rows[i].source == ObservationKind::Reading && build.rows[i].time_s.is_finite())
        .collect();
    in_time.dedup();
    if in_time.len() < 8 {
        return;
    }
    let rows = build.rows;
    let span = in_time
        .iter()
        .fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], &i| {
            [low.min(rows[i].time_s), high.max(rows[i].time_s)]
        });
    // Nothing is remembered from one run to the next.
    let gap = |pair: &[usize]| {
        let (before, row) = (&rows[pair[0]], &rows[pair[1]]);
        if before.file == row.file {
            row.time_s - before.time_s
        } else {
            f64::INFINITY
        }
    };
    let mut gaps: Vec<f64> = in_time.windows(2).map(gap).filter(|gap| *gap > 0.0).collect();
    gaps.sort_by(f64::total_cmp);
    let Some(&typical) = gaps.get(gaps.len() / 2) else {
        return;
    };
    let top = build.level.iter().copied().fold(0.0, f64::max).max(f64::MIN_POSITIVE);
    let levels = Arc::clone(&build.level);
    let mut along = build.along(ObservationKind::Reading, Coordinate::TimeS);
    for steps in [0.4, 1.0, 3.0, 10.0, 40.0] {
        // Exponential average of the signal before this reading.
        let level = Arc::clone(&levels);
        let mut before = vec![0.0; rows.len()];
        let mut average = level[in_time[0]];
        for pair in in_time.windows(2) {
            let keep = (-gap(pair) / (steps * typical)).exp();
            before[pair[0]] = average;
            average = keep * average + (1.0 - keep) * level[pair[0]];
            before[pair[1]] = average;
        }
        before[in_time[0]] = level[in_time[0]];
        let before: Arc<[f64]> = before.into();
        let again = Arc::clone(&before);
        let lag = along.column(Acts::Light, move |i, _| before[i] - level[i]);
        along.add("memory", span, "a reading that lags behind the light", vec![lag]);
        let fatigue = along.column(Acts::Relative, move |i, _| again[i] / top);
        along.add(
            "memory",
            span,
            "a response that remembers the light before",
            vec![fatigue],
        );
    }
    // Previous reading's level exactly: a meter read before it settled.
    let mut previous = vec![0.0; rows.len()];
    for pair in in_time.windows(2) {
        let near = gap(pair) < 2.5 * typical;
        previous[pair[1]] = if near { levels[pair[0]] - levels[pair[1]] } else { 0.0 };
    }
    let unsettled = along.column(Acts::Everywhere, move |i, _| previous[i]);
    along.add(
        "memory",
        span,
        "a reading that keeps a part of the one before",
        vec![unsettled],
    );
    let mut since = vec![f64::INFINITY; rows.len()];
    let mut start = rows[in_time[0]].time_s;
    for pair in in_time.windows(2) {
        if gap(pair) > 2.5 * typical {
            start = rows[pair[1]].time_s;
        }
        since[pair[1]] = rows[pair[1]].time_s - start;
    }
    since[in_time[0]] = 0.0;
    let since: Arc<[f64]> = since.into();
    for steps in [2.0, 6.0, 20.0] {
        let since = Arc::clone(&since);
        let column = along.column(Acts::Relative, move |i, _| (-since[i] / (steps * typical)).exp());
        along.add("memory", span, "a transient after every pause", vec![column]);
    }
}

/// Visits of a half-plane with fewer readings hold no ramp of their own.
const OF_A_VISIT: usize = 4;

/// A ramp that starts anew with every visit of a half-plane: a meter or a lamp that creeps while one is read and
/// recovers before the next.
pub(super) fn visits(build: &mut Builder<'_>, order: &[usize]) {
    let readings = order.iter().map(|&i| (i, &build.rows[i]));
    let visits = table::visits(readings.filter(|(_, row)| row.source == ObservationKind::Reading));
    let longest = visits.iter().map(Vec::len).max().unwrap_or(0);
    if longest < OF_A_VISIT || visits.iter().filter(|visit| visit.len() >= OF_A_VISIT).count() < 3 {
        return;
    }
    let mut since = vec![0.0; build.rows.len()];
    for visit in &visits {
        for (k, &i) in visit.iter().enumerate() {
            since[i] = k as f64 / (longest - 1) as f64;
        }
    }
    let since: Arc<[f64]> = since.into();
    let mut along = build.along(ObservationKind::Reading, Coordinate::Index);
    for acts in [Acts::Relative, Acts::Light] {
        let since = Arc::clone(&since);
        let column = along.column(acts, move |i, _| since[i]);
        let note = format!("{} that grows within every visit of a half-plane", word(acts));
        along.add("visit", [0.0, (longest - 1) as f64], note, vec![column]);
    }
}
