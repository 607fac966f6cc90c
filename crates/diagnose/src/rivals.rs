//! Rivals without a name: generic patterns along every coordinate, which compete with the catalogue on equal terms.
//!
//! Where one of them explains the data better than every named effect, the verdict is "unexplained" and this pattern says
//! where. `relative` patterns multiply the expected signal; `absolute` ones add to it.

use std::sync::Arc;

use crate::pattern::{Acts, Pattern};
use crate::table::{Coordinate, Light, Row, Source};

/// One generic pattern: up to a few columns over one range of one coordinate.
#[derive(Debug, Clone)]
pub struct Rival {
    /// Where it lives.
    pub coordinate: Coordinate,
    /// Its family: "jump", "window", "bump", "smooth", "periodic", "memory", …; patterns of a family share its prior.
    pub family: &'static str,
    /// The range of the coordinate that it touches.
    pub range: [f64; 2],
    /// In words, for people.
    pub note: String,
    /// Change of the signal for a unit amplitude, one a direction.
    pub columns: Vec<Pattern>,
}

/// All rivals that these rows allow. `level` is the model's expectation, `order` the rows in time order.
pub fn rivals(rows: &[Row], level: &[f64], order: &[usize]) -> Vec<Rival> {
    let mut build = Builder {
        rows,
        level: level.into(),
        found: Vec::new(),
    };
    if rows.iter().any(|row| row.source == Source::Reading) {
        time(&mut build, order);
        memory(&mut build, order);
        gamma(&mut build);
        azimuth(&mut build);
        distance(&mut build, Source::Reading);
        travel(&mut build);
        range(&mut build);
        ambient(&mut build, order);
        signal_level(&mut build, Source::Reading);
    }
    if rows.iter().any(|row| row.source == Source::Bin) {
        crate::rivals_maps::maps(&mut build);
        distance(&mut build, Source::Bin);
        signal_level(&mut build, Source::Bin);
    }
    if rows.iter().any(|row| row.source == Source::Sample) {
        wavelength(&mut build);
    }
    build.found
}

/// Collects patterns; knows how to turn a function of a row into a column.
pub(crate) struct Builder<'a> {
    pub(crate) rows: &'a [Row],
    pub(crate) level: Arc<[f64]>,
    pub(crate) found: Vec<Rival>,
}

impl Builder<'_> {
    /// The pattern `law(row)`, NaN read as 0, acting on rows of `source`.
    pub(crate) fn column(
        &self,
        source: Source,
        acts: Acts,
        law: impl Fn(usize, &Row) -> f64 + Send + Sync + 'static,
    ) -> Pattern {
        Pattern::new(source, acts, &self.level, law)
    }

    /// As [`column`](Self::column), for a law of the expected signal.
    fn of_level(&self, source: Source, acts: Acts, law: impl Fn(f64, &Row) -> f64 + Send + Sync + 'static) -> Pattern {
        let level = Arc::clone(&self.level);
        self.column(source, acts, move |i, row| law(level[i], row))
    }

    pub(crate) fn add(
        &mut self,
        coordinate: Coordinate,
        family: &'static str,
        range: [f64; 2],
        note: impl Into<String>,
        columns: Vec<Pattern>,
    ) {
        let nothing = |column: &Pattern| column.values(self.rows).all(|value| value == 0.0);
        if columns.iter().all(nothing) {
            return;
        }
        self.found.push(Rival {
            coordinate,
            family,
            range,
            note: note.into(),
            columns,
        });
    }

    /// Distinct finite values of a coordinate over rows of `source` that carry signal, rising.
    pub(crate) fn distinct(&self, source: Source, coordinate: Coordinate) -> Vec<f64> {
        let mut values: Vec<f64> = self
            .rows
            .iter()
            .zip(self.level.iter())
            .filter(|(row, _)| row.source == source && row.light == Light::Lit)
            .map(|(row, &level)| row.coordinate(coordinate, level))
            .filter(|value| value.is_finite())
            .collect();
        values.sort_by(f64::total_cmp);
        values.dedup();
        values
    }
}

fn word(acts: Acts) -> &'static str {
    match acts {
        Acts::Relative => "a relative change",
        Acts::Light | Acts::Everywhere => "an added signal",
    }
}

fn time(build: &mut Builder<'_>, order: &[usize]) {
    let times: Vec<f64> = order
        .iter()
        .map(|&i| &build.rows[i])
        .filter(|row| row.source == Source::Reading && row.time_s.is_finite())
        .map(|row| row.time_s)
        .collect();
    let (Some(&first), Some(&last)) = (times.first(), times.last()) else {
        return;
    };
    if last <= first {
        return;
    }
    let at = |quantile: f64| times[((times.len() - 1) as f64 * quantile) as usize];
    let place = move |row: &Row| (row.time_s - first) / (last - first);
    for acts in [Acts::Relative, Acts::Light, Acts::Everywhere] {
        // The constant is the level (relative) or has a name (stray light, offset).
        let from = 1;
        for terms in [2, 4] {
            let columns: Vec<_> = (from..from + terms)
                .map(|k| std::f64::consts::PI * k as f64)
                .map(|turn| build.column(Source::Reading, acts, move |_, row| (turn * place(row)).cos()))
                .collect();
            let note = format!("{} that varies smoothly", word(acts));
            build.add(Coordinate::TimeS, "smooth", [first, last], note, columns);
        }
        for step in 1..40 {
            let from = at(step as f64 / 40.0);
            let column = build.column(Source::Reading, acts, move |_, row| f64::from(row.time_s > from));
            build.add(
                Coordinate::TimeS,
                "jump",
                [from, last],
                format!("{} from then on", word(acts)),
                vec![column],
            );
        }
        for parts in [8_usize, 16, 32] {
            for half in 0..2 * parts - 1 {
                let from = at(half as f64 / (2 * parts) as f64);
                let to = at((half + 2) as f64 / (2 * parts) as f64);
                let column = build.column(Source::Reading, acts, move |_, row| {
                    f64::from(row.time_s >= from && row.time_s <= to)
                });
                build.add(
                    Coordinate::TimeS,
                    "window",
                    [from, to],
                    format!("{} for a while", word(acts)),
                    vec![column],
                );
                if acts != Acts::Everywhere {
                    let (centre, width) = (0.5 * (from + to), 0.35 * (to - from).max(1e-9));
                    let column = build.column(Source::Reading, acts, move |_, row| {
                        (-0.5 * ((row.time_s - centre) / width).powi(2)).exp()
                    });
                    let note = format!("{} that rises and falls", word(acts));
                    build.add(Coordinate::TimeS, "bump", [from, to], note, vec![column]);
                }
            }
        }
        for cycles in 2..=20 {
            let turn = std::f64::consts::TAU * f64::from(cycles) / 2.0;
            if acts == Acts::Relative {
                continue; // a relative oscillation has a name: modulated light
            }
            let columns = vec![
                build.column(Source::Reading, acts, move |_, row| (turn * place(row)).cos()),
                build.column(Source::Reading, acts, move |_, row| (turn * place(row)).sin()),
            ];
            build.add(
                Coordinate::TimeS,
                "periodic",
                [first, last],
                "an added signal that oscillates",
                columns,
            );
        }
    }
}

/// Patterns that depend on the readings before: lag of the reading, fatigue, transients after a pause.
fn memory(build: &mut Builder<'_>, order: &[usize]) {
    let mut in_time: Vec<usize> = order
        .iter()
        .copied()
        .filter(|&i| build.rows[i].source == Source::Reading && build.rows[i].time_s.is_finite())
        .collect();
    in_time.dedup();
    if in_time.len() < 8 {
        return;
    }
    let time = |i: usize| build.rows[i].time_s;
    let span = [time(in_time[0]), time(in_time[in_time.len() - 1])];
    let mut gaps: Vec<f64> = in_time
        .windows(2)
        .map(|pair| time(pair[1]) - time(pair[0]))
        .filter(|gap| *gap > 0.0)
        .collect();
    gaps.sort_by(f64::total_cmp);
    let Some(&typical) = gaps.get(gaps.len() / 2) else {
        return;
    };
    let top = build.level.iter().copied().fold(0.0, f64::max).max(f64::MIN_POSITIVE);
    let mut found = Vec::new();
    for steps in [0.4, 1.0, 3.0, 10.0, 40.0] {
        // Exponential average of the signal before this reading.
        let level = Arc::clone(&build.level);
        let mut before = vec![0.0; build.rows.len()];
        let mut average = level[in_time[0]];
        for pair in in_time.windows(2) {
            let keep = (-(time(pair[1]) - time(pair[0])) / (steps * typical)).exp();
            before[pair[0]] = average;
            average = keep * average + (1.0 - keep) * level[pair[0]];
            before[pair[1]] = average;
        }
        before[in_time[0]] = level[in_time[0]];
        let before: Arc<[f64]> = before.into();
        let again = Arc::clone(&before);
        let lag = build.column(Source::Reading, Acts::Light, move |i, _| before[i] - level[i]);
        found.push(("a reading that lags behind the light", lag));
        let fatigue = build.column(Source::Reading, Acts::Relative, move |i, _| again[i] / top);
        found.push(("a response that remembers the light before", fatigue));
    }
    // Previous reading's level exactly: a meter read before it settled.
    let mut previous = vec![0.0; build.rows.len()];
    for pair in in_time.windows(2) {
        let near = time(pair[1]) - time(pair[0]) < 2.5 * typical;
        previous[pair[1]] = if near {
            build.level[pair[0]] - build.level[pair[1]]
        } else {
            0.0
        };
    }
    let unsettled = build.column(Source::Reading, Acts::Everywhere, move |i, _| previous[i]);
    found.push(("a reading that keeps a part of the one before", unsettled));
    let mut since = vec![f64::INFINITY; build.rows.len()];
    let mut start = time(in_time[0]);
    for pair in in_time.windows(2) {
        if time(pair[1]) - time(pair[0]) > 2.5 * typical {
            start = time(pair[1]);
        }
        since[pair[1]] = time(pair[1]) - start;
    }
    since[in_time[0]] = 0.0;
    let since: Arc<[f64]> = since.into();
    for steps in [2.0, 6.0, 20.0] {
        let since = Arc::clone(&since);
        let column = build.column(Source::Reading, Acts::Relative, move |i, _| {
            (-since[i] / (steps * typical)).exp()
        });
        found.push(("a transient after every pause", column));
    }
    for (note, column) in found {
        build.add(Coordinate::TimeS, "memory", span, note, vec![column]);
    }
}

fn gamma(build: &mut Builder<'_>) {
    let angles = build.distinct(Source::Reading, Coordinate::GammaDeg);
    let (Some(&low), Some(&high)) = (angles.first(), angles.last()) else {
        return;
    };
    if high <= low {
        return;
    }
    let step = ((high - low) / (angles.len() - 1) as f64).max(2.5);
    for acts in [Acts::Relative, Acts::Light] {
        for width in [0.7 * step, 1.4 * step, 3.0 * step] {
            let spacing = width.max(step);
            let count = ((high - low) / spacing).round() as usize;
            for k in 0..=count {
                let centre = low + k as f64 * spacing;
                let bump = move |gamma: f64| (-0.5 * ((gamma - centre) / width).powi(2)).exp();
                let lit = move |row: &Row| f64::from(row.light == Light::Lit);
                let column = build.column(Source::Reading, acts, move |_, row| lit(row) * bump(row.gamma_deg));
                let range = [centre - 1.5 * width, centre + 1.5 * width];
                let note = format!("{} near one signed γ", word(acts));
                build.add(Coordinate::GammaDeg, "bump", range, note, vec![column]);
                if centre > 0.0 && acts == Acts::Relative {
                    let column = build.column(Source::Reading, acts, move |_, row| bump(row.gamma_deg.abs()));
                    let note = format!("{} near one |γ|", word(acts));
                    build.add(Coordinate::GammaDeg, "bump", range, note, vec![column]);
                }
            }
        }
    }
    for &edge in angles.iter().step_by((angles.len() / 16).max(1)) {
        let column = build.column(Source::Reading, Acts::Relative, move |_, row| {
            f64::from(row.gamma_deg > edge)
        });
        build.add(
            Coordinate::GammaDeg,
            "jump",
            [edge, high],
            "a relative change beyond one γ",
            vec![column],
        );
    }
    let reach = low.abs().max(high.abs());
    let odd: Vec<_> = [1, 3, 5]
        .iter()
        .map(|&power| {
            build.column(Source::Reading, Acts::Relative, move |_, row| {
                (row.gamma_deg / reach).powi(power)
            })
        })
        .collect();
    build.add(
        Coordinate::GammaDeg,
        "smooth",
        [low, high],
        "an odd change over signed γ",
        odd[..1].to_vec(),
    );
    build.add(
        Coordinate::GammaDeg,
        "smooth",
        [low, high],
        "an odd change over signed γ",
        odd,
    );
    for period in [6.0, 8.0, 10.0, 12.0, 15.0, 20.0, 24.0, 30.0, 45.0, 60.0, 90.0] {
        if period < 2.2 * step {
            continue;
        }
        let turn = std::f64::consts::TAU / period;
        let columns = vec![
            build.column(Source::Reading, Acts::Relative, move |_, row| {
                (turn * row.gamma_deg).cos()
            }),
            build.column(Source::Reading, Acts::Relative, move |_, row| {
                (turn * row.gamma_deg).sin()
            }),
        ];
        let note = format!("a relative change that repeats every {period}°");
        build.add(Coordinate::GammaDeg, "periodic", [low, high], note, columns);
    }
}

fn azimuth(build: &mut Builder<'_>) {
    let planes = build.distinct(Source::Reading, Coordinate::CDeg);
    let (Some(&low), Some(&high)) = (planes.first(), planes.last()) else {
        return;
    };
    if planes.len() < 3 {
        return;
    }
    for harmonic in 1..=6 {
        let order = f64::from(harmonic);
        for power in [0, harmonic] {
            let shape = move |row: &Row| row.gamma_deg.to_radians().sin().abs().powi(power);
            // Azimuth in the luminaire: (C, −γ) is (C + 180°, γ).
            let azimuth = move |row: &Row| (row.c_deg + if row.gamma_deg < 0.0 { 180.0 } else { 0.0 }).to_radians();
            let columns = vec![
                build.column(Source::Reading, Acts::Relative, move |_, row| {
                    (order * azimuth(row)).cos() * shape(row)
                }),
                build.column(Source::Reading, Acts::Relative, move |_, row| {
                    (order * azimuth(row)).sin() * shape(row)
                }),
            ];
            let periods = if harmonic == 1 {
                "one period".to_owned()
            } else {
                format!("{harmonic} periods")
            };
            let note = format!("a relative change with {periods} around C");
            build.add(Coordinate::CDeg, "harmonic", [0.0, 360.0], note, columns);
            if harmonic % 2 == 1 && power == 0 {
                let columns = vec![
                    build.column(Source::Reading, Acts::Relative, move |_, row| {
                        (order * row.c_deg.to_radians()).cos()
                    }),
                    build.column(Source::Reading, Acts::Relative, move |_, row| {
                        (order * row.c_deg.to_radians()).sin()
                    }),
                ];
                let note = format!("a relative change with {periods} of the C axis");
                build.add(Coordinate::CDeg, "harmonic", [0.0, 360.0], note, columns);
            }
        }
    }
    for width in 1..=4_usize {
        for start in 0..planes.len().saturating_sub(width - 1) {
            let (from, to) = (planes[start], planes[start + width - 1]);
            if width == planes.len() {
                continue;
            }
            let column = build.column(Source::Reading, Acts::Relative, move |_, row| {
                f64::from(row.c_deg >= from && row.c_deg <= to)
            });
            build.add(
                Coordinate::CDeg,
                "window",
                [from, to],
                "a relative change of whole C planes",
                vec![column],
            );
            for side in [-1.0, 1.0] {
                let column = build.column(Source::Reading, Acts::Relative, move |_, row| {
                    f64::from(row.c_deg >= from && row.c_deg <= to && row.gamma_deg * side > 0.0)
                });
                build.add(
                    Coordinate::CDeg,
                    "half_plane",
                    [from, to],
                    "a relative change of C half-planes",
                    vec![column],
                );
            }
        }
    }
    for &edge in planes.iter().take(planes.len() - 1) {
        let column = build.column(Source::Reading, Acts::Relative, move |_, row| {
            f64::from(row.c_deg > edge)
        });
        build.add(
            Coordinate::CDeg,
            "jump",
            [edge, high],
            "a relative change beyond one C",
            vec![column],
        );
    }
    let span = (high - low).max(1.0);
    let column = build.column(Source::Reading, Acts::Relative, move |_, row| (row.c_deg - low) / span);
    build.add(
        Coordinate::CDeg,
        "smooth",
        [low, high],
        "a relative change along the C axis",
        vec![column],
    );
}

fn distance(build: &mut Builder<'_>, source: Source) {
    let distances = build.distinct(source, Coordinate::DistanceMm);
    if distances.len() < 2 {
        return;
    }
    for &here in &distances {
        let at = move |row: &Row| f64::from(row.distance_mm == here);
        let column = build.column(source, Acts::Relative, move |_, row| at(row));
        build.add(
            Coordinate::DistanceMm,
            "jump",
            [here, here],
            "a relative change at one distance",
            vec![column],
        );
        let column = build.column(source, Acts::Light, move |_, row| {
            at(row) * f64::from(row.light == Light::Lit)
        });
        build.add(
            Coordinate::DistanceMm,
            "jump",
            [here, here],
            "an added signal at one distance",
            vec![column],
        );
        if source == Source::Reading {
            let column = build.column(source, Acts::Relative, move |_, row| {
                at(row) * row.gamma_deg.to_radians().sin()
            });
            build.add(
                Coordinate::DistanceMm,
                "odd",
                [here, here],
                "an odd change over γ at one distance",
                vec![column],
            );
            let column = build.column(source, Acts::Relative, move |_, row| {
                at(row) * row.gamma_deg.to_radians().sin().powi(2)
            });
            build.add(
                Coordinate::DistanceMm,
                "even",
                [here, here],
                "an even change over γ at one distance",
                vec![column],
            );
        }
    }
    let reach = [distances[0], distances[distances.len() - 1]];
    let logarithm = move |row: &Row| (row.distance_mm / reach[0]).ln();
    let column = build.column(source, Acts::Relative, move |_, row| logarithm(row));
    build.add(
        Coordinate::DistanceMm,
        "smooth",
        reach,
        "another power of the distance",
        vec![column],
    );
    let column = build.column(source, Acts::Light, move |_, row| {
        f64::from(row.light == Light::Lit) * (reach[0] / row.distance_mm)
    });
    build.add(
        Coordinate::DistanceMm,
        "smooth",
        reach,
        "an added signal that falls with distance",
        vec![column],
    );
}

fn travel(build: &mut Builder<'_>) {
    let ways = build.distinct(Source::Reading, Coordinate::Travel);
    if ways.len() < 2 {
        return;
    }
    let reach = [ways[0], ways[ways.len() - 1]];
    let column = build.column(Source::Reading, Acts::Relative, move |_, row| row.travel);
    build.add(
        Coordinate::Travel,
        "jump",
        reach,
        "a relative change with the direction of travel",
        vec![column],
    );
    let column = build.column(Source::Reading, Acts::Light, move |_, row| row.travel);
    build.add(
        Coordinate::Travel,
        "jump",
        reach,
        "an added signal with the direction of travel",
        vec![column],
    );
    let column = build.column(Source::Reading, Acts::Relative, move |_, row| {
        row.travel * row.gamma_deg.to_radians().sin().powi(2)
    });
    build.add(
        Coordinate::Travel,
        "even",
        reach,
        "a change with travel that grows with γ",
        vec![column],
    );
    let column = build.column(Source::Reading, Acts::Relative, move |_, row| {
        f64::from(row.travel == 0.0)
    });
    build.add(
        Coordinate::Travel,
        "jump",
        [0.0, 0.0],
        "a relative change of readings at rest",
        vec![column],
    );
}

fn range(build: &mut Builder<'_>) {
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

fn ambient(build: &mut Builder<'_>, order: &[usize]) {
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

fn signal_level(build: &mut Builder<'_>, source: Source) {
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

fn wavelength(build: &mut Builder<'_>) {
    let samples = build.distinct(Source::Sample, Coordinate::WavelengthNm);
    let (Some(&low), Some(&high)) = (samples.first(), samples.last()) else {
        return;
    };
    if high <= low {
        return;
    }
    let place = move |row: &Row| (row.wavelength_nm - low) / (high - low);
    for acts in [Acts::Relative, Acts::Everywhere] {
        for width in [0.03, 0.1] {
            let count = (0.7 / width) as usize;
            for k in 0..=count {
                let centre = k as f64 / count as f64;
                let column = build.column(Source::Sample, acts, move |_, row| {
                    (-0.5 * ((place(row) - centre) / width).powi(2)).exp()
                });
                let middle = low + centre * (high - low);
                let reach = 1.5 * width * (high - low);
                let note = format!("{} near one wavelength", word(acts));
                build.add(
                    Coordinate::WavelengthNm,
                    "bump",
                    [middle - reach, middle + reach],
                    note,
                    vec![column],
                );
            }
        }
        let columns: Vec<_> = (1..=4)
            .map(|k| {
                let turn = std::f64::consts::PI * f64::from(k);
                build.column(Source::Sample, acts, move |_, row| (turn * place(row)).cos())
            })
            .collect();
        let note = format!("{} that varies smoothly", word(acts));
        build.add(Coordinate::WavelengthNm, "smooth", [low, high], note, columns);
    }
    for step in 1..12 {
        let edge = f64::from(step) / 12.0;
        let column = build.column(Source::Sample, Acts::Relative, move |_, row| {
            f64::from(place(row) > edge)
        });
        let from = low + edge * (high - low);
        build.add(
            Coordinate::WavelengthNm,
            "jump",
            [from, high],
            "a relative change beyond one wavelength",
            vec![column],
        );
    }
}
