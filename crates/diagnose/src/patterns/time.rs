//! Patterns along time and number, in visits of half-planes, and those that remember the readings before.

use std::rc::Rc;

use super::Acts::{self, Everywhere, Relative};
use super::place::{Grid, What};
use super::shape::Shape::{Between, Beyond, Bump, Fading};
use super::shape::{Direction, Values};
use super::{List, cosines, waves};
use crate::noise::limits::{EVERY, EVERY_VISIT, RUNS};
use crate::noise::series::Series;
use crate::table::{self, Coordinate, Light, ObservationKind};

/// Of the search.
pub(super) fn time(list: &mut List<'_>) {
    let readings = list.rows.iter().filter(|row| row.source == ObservationKind::Reading);
    let mut times: Vec<f64> = readings.map(|row| row.time_s).filter(|time| time.is_finite()).collect();
    times.sort_by(f64::total_cmp);
    let (Some(&first), Some(&last)) = (times.first(), times.last()) else {
        return;
    };
    if last <= first {
        return;
    }
    let at = |quantile: f64| times[((times.len() - 1) as f64 * quantile) as usize];
    let time = list.values(|row| row.time_s);
    let share = list.values(|row| (row.time_s - first) / (last - first));
    let whole = [first, last];
    let mut on = list.on(ObservationKind::Reading, Coordinate::TimeS);
    for acts in [Relative, Acts::Light, Everywhere] {
        for terms in [2, 4] {
            on.one(acts, "smooth", whole, "that varies smoothly", cosines(terms, &share));
        }
        for step in 1..40 {
            let from = at(step as f64 / 40.0);
            on.one(acts, "jump", [from, last], "from then on", Beyond(from).along(&time));
        }
        for parts in [8_usize, 16, 32] {
            for half in 0..2 * parts - 1 {
                let [from, to] = [half, half + 2].map(|end| at(end as f64 / (2 * parts) as f64));
                on.one(
                    acts,
                    "window",
                    [from, to],
                    "for a while",
                    Between(from, to).along(&time),
                );
                if acts != Everywhere {
                    let bump = Bump(0.5 * (from + to), 0.35 * (to - from).max(1e-9)).along(&time);
                    on.one(acts, "bump", [from, to], "that rises and falls", bump);
                }
            }
        }
        // A relative oscillation has a name: modulated light.
        for cycles in (2..=20).filter(|_| acts != Relative) {
            let wave = waves(std::f64::consts::TAU * f64::from(cycles) / 2.0, &share);
            on.one(acts, "periodic", whole, "that oscillates", wave);
        }
    }
}

/// Patterns that depend on the readings before: lag of the reading, fatigue, transients after a pause.
pub(super) fn memory(list: &mut List<'_>) {
    let (rows, level) = (list.rows, list.level);
    let mut in_time: Vec<usize> = list
        .order
        .iter()
        .copied()
        .filter(|&i| rows[i].source == ObservationKind::Reading && rows[i].time_s.is_finite())
        .collect();
    in_time.dedup();
    if in_time.len() < 8 {
        return;
    }
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
    let top = level.iter().copied().fold(0.0, f64::max).max(f64::MIN_POSITIVE);
    let mut on = list.on(ObservationKind::Reading, Coordinate::TimeS);
    let mut remembers = |acts, note, direction: Direction| on.add(acts, "memory", span, note, direction);
    for steps in [0.4, 1.0, 3.0, 10.0, 40.0] {
        // Exponential average of the signal before this reading.
        let mut before = vec![0.0; rows.len()];
        let mut average = level[in_time[0]];
        for pair in in_time.windows(2) {
            let keep = (-gap(pair) / (steps * typical)).exp();
            before[pair[0]] = average;
            average = keep * average + (1.0 - keep) * level[pair[0]];
            before[pair[1]] = average;
        }
        before[in_time[0]] = level[in_time[0]];
        let lag = Direction::of(before.iter().zip(level).map(|(before, level)| before - level).collect());
        remembers(Acts::Light, "a reading that lags behind the light", lag);
        let fatigue = Direction::of(before.iter().map(|before| before / top).collect());
        remembers(Relative, "a response that remembers the light before", fatigue);
    }
    // Previous reading's level exactly: a meter read before it settled.
    let mut previous = vec![0.0; rows.len()];
    let mut since = vec![f64::INFINITY; rows.len()];
    let mut start = rows[in_time[0]].time_s;
    since[in_time[0]] = 0.0;
    for pair in in_time.windows(2) {
        if gap(pair) < 2.5 * typical {
            previous[pair[1]] = level[pair[0]] - level[pair[1]];
        }
        if gap(pair) > 2.5 * typical {
            start = rows[pair[1]].time_s;
        }
        since[pair[1]] = rows[pair[1]].time_s - start;
    }
    let note = "a reading that keeps a part of the one before";
    remembers(Everywhere, note, Direction::of(previous.into()));
    let since: Values = since.into();
    for steps in [2.0, 6.0, 20.0] {
        let after = Fading(0.0, steps * typical).along(&since);
        remembers(Relative, "a transient after every pause", after);
    }
}

/// Visits of a half-plane with fewer readings hold no ramp of their own.
const OF_A_VISIT: usize = 4;

/// A ramp that starts anew with every visit of a half-plane: a meter or a lamp that creeps while one is read and
/// recovers before the next.
pub(super) fn visits(list: &mut List<'_>) {
    let readings = list.order.iter().map(|&i| (i, &list.rows[i]));
    let visits = table::visits(readings.filter(|(_, row)| row.source == ObservationKind::Reading));
    let longest = visits.iter().map(Vec::len).max().unwrap_or(0);
    if longest < OF_A_VISIT || visits.iter().filter(|visit| visit.len() >= OF_A_VISIT).count() < 3 {
        return;
    }
    let mut since = vec![0.0; list.rows.len()];
    for visit in &visits {
        for (k, &i) in visit.iter().enumerate() {
            since[i] = k as f64 / (longest - 1) as f64;
        }
    }
    let since = Direction::of(since.into());
    let range = [0.0, (longest - 1) as f64];
    let mut on = list.on(ObservationKind::Reading, Coordinate::Index);
    for acts in [Relative, Acts::Light] {
        let place = "that grows within every visit of a half-plane";
        on.one(acts, "visit", range, place, since.clone());
    }
}

/// Of the test of the noise: every second to every [`EVERY`]-th reading.
pub(super) fn every_reading<'a>(series: &'a Series<'a>) -> Vec<Grid<'a>> {
    let phase = |i: usize, n: usize| (series.index[i].round() as i64).rem_euclid(n as i64) as usize;
    let grid = |n: usize| {
        let first = |k: usize| (0..series.len()).find(|&i| phase(i, n) == k);
        let every = |k: usize| {
            let first = first(k).map_or(0.0, |i| series.index[i]);
            What::Reading(n, k, first).over(series.numbers())
        };
        Grid::line(1.0, (0..n).map(every).collect(), move |i| Some(phase(i, n) as f64))
    };
    (2..=EVERY.min(series.len() / 8)).map(grid).collect()
}

/// Of the test of the noise: every second to every [`EVERY_VISIT`]-th visit of a half-plane.
pub(super) fn every_visit<'a>(series: &'a Series<'a>) -> Vec<Grid<'a>> {
    let mut number = vec![None; series.len()];
    let mut count = 0;
    for visit in series.visits() {
        if visit.len() > 2 && series.rows[visit[0]].light == Light::Lit {
            for i in visit {
                number[i] = Some(count);
            }
            count += 1;
        }
    }
    let number: Rc<[Option<usize>]> = number.into();
    let grid = |n: usize| {
        let every = |k: usize| What::Visit(n, k).over(series.numbers());
        let number = Rc::clone(&number);
        Grid::line(1.0, (0..n).map(every).collect(), move |i| Some((number[i]? % n) as f64))
    };
    (2..=EVERY_VISIT).filter(|n| 2 * n <= count).map(grid).collect()
}

/// Of the test of the noise: runs of successive readings, each begun a third of its length after the one before.
pub(super) fn runs<'a>(series: &'a Series<'a>) -> Vec<Grid<'a>> {
    let grid = |length: usize| {
        let step = (length / 3).max(1);
        let run = |from: usize| {
            let to = from + length - 1;
            What::Run(from, to).over([series.index[from], series.index[to]])
        };
        let places = (0..=series.len() - length).step_by(step).map(run).collect();
        // Steps are the cells.
        Grid::line(step as f64, places, move |i| Some((i / step * step) as f64))
    };
    let fits = |length: &usize| 3 * length < series.len();
    RUNS.into_iter().filter(fits).map(grid).collect()
}
