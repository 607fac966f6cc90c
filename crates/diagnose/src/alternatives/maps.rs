//! Empirical alternatives on sensor maps: patterns fixed to the sensor, to the angle of incidence, to single maps.

use super::{Builder, word};
use crate::pattern::Acts;
use crate::table::{Coordinate, Light, ObservationKind, Row};

/// Adds the patterns of sensor maps.
pub(super) fn maps(build: &mut Builder<'_>) {
    let (xs, ys) = (
        build.distinct(ObservationKind::Bin, Coordinate::XMm),
        build.distinct(ObservationKind::Bin, Coordinate::YMm),
    );
    if xs.len() < 4 || ys.len() < 4 {
        return;
    }
    along(build, Coordinate::XMm, &xs);
    along(build, Coordinate::YMm, &ys);
    plane(build, &xs, &ys);
    incidence(build);
    single_maps(build);
}

fn position(coordinate: Coordinate, row: &Row) -> f64 {
    if coordinate == Coordinate::XMm {
        row.x_mm
    } else {
        row.y_mm
    }
}

/// Columns or rows of the sensor: taps, bands, periodic patterns.
fn along(build: &mut Builder<'_>, coordinate: Coordinate, places: &[f64]) {
    let (low, high) = (places[0], places[places.len() - 1]);
    let pitch = (high - low) / (places.len() - 1) as f64;
    let stride = (places.len() / 24).max(1);
    let at = move |row: &Row| position(coordinate, row);
    let mut along = build.along(ObservationKind::Bin, coordinate);
    for acts in [Acts::Relative, Acts::Everywhere] {
        let what = word(acts);
        for &edge in places.iter().skip(1).step_by(stride) {
            let from = edge - 0.5 * pitch;
            along.one(
                acts,
                "jump",
                [from, high],
                format!("{what} on one side of the sensor"),
                move |row| f64::from(at(row) > from),
            );
        }
        for width in [1_usize, 2, 4] {
            let width = width * stride;
            for start in (0..places.len().saturating_sub(width)).step_by(width.div_ceil(2)) {
                let (from, to) = (places[start] - 0.5 * pitch, places[start + width - 1] + 0.5 * pitch);
                along.one(
                    acts,
                    "window",
                    [from, to],
                    format!("{what} in one band of the sensor"),
                    move |row| f64::from((from..to).contains(&at(row))),
                );
            }
        }
        let size = high - low + pitch;
        for cycles in [0.5, 1.0, 1.5, 2.0, 2.5, 3.0, 4.0, 5.0, 6.0, 8.0, 12.0] {
            if size / cycles < 1.9 * pitch || (acts == Acts::Relative && cycles >= 1.0 && coordinate == Coordinate::YMm)
            {
                continue; // a relative banding along y has a name: flicker of a rolling shutter
            }
            let turn = std::f64::consts::TAU * cycles / size;
            let note = format!("{what} that repeats over the sensor");
            along.waves(acts, "periodic", [low, high], note, move |row| {
                (turn * (at(row) - low), 1.0)
            });
        }
        along.one(
            acts,
            "alternating",
            [low, high],
            format!("{what} of every other line"),
            move |row| {
                let place = ((at(row) - low) / pitch).round() as i64;
                if place % 2 == 0 { 1.0 } else { -1.0 }
            },
        );
        for side in [-1.0, 1.0] {
            let edge = if side > 0.0 { high } else { low };
            for reach in [0.1, 0.3] {
                let range = if side > 0.0 {
                    [edge - reach * size, edge]
                } else {
                    [edge, edge + reach * size]
                };
                along.one(acts, "edge", range, format!("{what} towards one edge"), move |row| {
                    (-((at(row) - edge).abs()) / (reach * size)).exp()
                });
            }
        }
    }
}

/// Patterns in the plane of the sensor: spots, quadrants, rings, polynomials.
fn plane(build: &mut Builder<'_>, xs: &[f64], ys: &[f64]) {
    let reach = xs[xs.len() - 1]
        .abs()
        .max(ys[ys.len() - 1].abs())
        .max(f64::MIN_POSITIVE);
    let scaled = move |row: &Row| (row.x_mm / reach, row.y_mm / reach);
    let (low, high) = (-reach, reach);
    for acts in [Acts::Relative, Acts::Everywhere] {
        let what = word(acts);
        let mut along = build.along(ObservationKind::Bin, Coordinate::XMm);
        let mut powers = |list: &[(i32, i32)], how: &str| {
            let column = |&(i, j): &(i32, i32)| {
                along.column(acts, move |_, row| {
                    let (x, y) = scaled(row);
                    x.powi(i) * y.powi(j)
                })
            };
            let columns = list.iter().map(column).collect();
            along.add("plane", [low, high], format!("{what} {how}"), columns);
        };
        powers(&[(2, 0), (1, 1), (0, 2)], "curved over the sensor");
        powers(&[(3, 0), (2, 1), (1, 2), (0, 3)], "twisted over the sensor");
        powers(&[(1, 1)], "across the diagonals");
        if acts == Acts::Everywhere {
            powers(&[(1, 0), (0, 1)], "sloping over the sensor");
        }
        along.one(
            acts,
            "quadrant",
            [low, high],
            format!("{what} of opposite quadrants"),
            |row| row.x_mm.signum() * row.y_mm.signum(),
        );
        for (sx, sy) in [(-1.0, -1.0), (-1.0, 1.0), (1.0, -1.0), (1.0, 1.0)] {
            let range = if sx > 0.0 { [0.0, high] } else { [low, 0.0] };
            along.one(acts, "quadrant", range, format!("{what} of one quadrant"), move |row| {
                f64::from(row.x_mm * sx > 0.0 && row.y_mm * sy > 0.0)
            });
            along.one(acts, "corner", range, format!("{what} in one corner"), move |row| {
                let (x, y) = scaled(row);
                (-((x - sx).hypot(y - sy)) / 0.5).exp()
            });
        }
        if acts == Acts::Relative {
            // (an added spot has a name: ghost)
            for width in [0.12, 0.3] {
                let count = if width < 0.2 { 7 } else { 5 };
                for (i, j) in (0..count).flat_map(|i| (0..count).map(move |j| (i, j))) {
                    let centre = |k: i32| -0.85 + 1.7 * f64::from(k) / f64::from(count - 1);
                    let (cx, cy) = (centre(i), centre(j));
                    let range = [(cx - 1.5 * width) * reach, (cx + 1.5 * width) * reach];
                    along.one(acts, "spot", range, format!("{what} in one spot"), move |row| {
                        let (x, y) = scaled(row);
                        (-0.5 * ((x - cx).powi(2) + (y - cy).powi(2)) / (width * width)).exp()
                    });
                }
            }
        }
        let mut along = build.along(ObservationKind::Bin, Coordinate::RadiusMm);
        for ring in 0..6 {
            let centre = 0.2 * f64::from(ring) + 0.1;
            let range = [(centre - 0.15) * reach, (centre + 0.15) * reach];
            along.one(acts, "ring", range, format!("{what} in one ring"), move |row| {
                let (x, y) = scaled(row);
                (-0.5 * ((x.hypot(y) - centre) / 0.12).powi(2)).exp()
            });
        }
        let square = move |row: &Row| {
            let (x, y) = scaled(row);
            x * x + y * y
        };
        along.one(acts, "smooth", [0.0, reach], format!("{what} ∝ r⁴"), move |row| {
            square(row).powi(2)
        });
        if acts == Acts::Everywhere {
            along.one(acts, "smooth", [0.0, reach], format!("{what} ∝ r²"), square);
        }
    }
}

fn incidence(build: &mut Builder<'_>) {
    let angles = build.distinct(ObservationKind::Bin, Coordinate::IncidenceDeg);
    let (Some(&low), Some(&high)) = (angles.first(), angles.last()) else {
        return;
    };
    let mut along = build.along(ObservationKind::Bin, Coordinate::IncidenceDeg);
    for edge in [5.0, 10.0, 20.0, 30.0, 45.0] {
        if edge <= low || edge >= high {
            continue;
        }
        along.relative(
            "jump",
            [edge, high],
            "a relative change beyond one angle of incidence",
            move |row| f64::from(row.incidence_deg > edge),
        );
        let near = [0.7 * edge, 1.3 * edge];
        along.relative(
            "bump",
            near,
            "a relative change near one angle of incidence",
            move |row| (-0.5 * ((row.incidence_deg - edge) / (0.3 * edge)).powi(2)).exp(),
        );
    }
}

/// Single maps, and what one map leaves behind in the next.
fn single_maps(build: &mut Builder<'_>) {
    let key = move |row: &Row| (row.file, row.group);
    let mut keys: Vec<(usize, usize)> = build
        .rows
        .iter()
        .filter(|row| row.source == ObservationKind::Bin)
        .map(key)
        .collect();
    keys.dedup();
    if keys.len() < 2 {
        return;
    }
    for &this in &keys {
        let Some(row) = build
            .rows
            .iter()
            .find(|row| row.source == ObservationKind::Bin && key(row) == this)
            .copied()
        else {
            continue;
        };
        let (coordinate, value) = if row.time_s.is_finite() {
            (Coordinate::TimeS, row.time_s)
        } else {
            (Coordinate::Exposure, row.exposure)
        };
        let mut along = build.along(ObservationKind::Bin, coordinate);
        let inside = move |row: &Row| f64::from(key(row) == this);
        if row.light == Light::Lit {
            along.relative("one_map", [value, value], "a relative change of one map", inside);
        }
        along.one(
            Acts::Everywhere,
            "one_map",
            [value, value],
            "an added signal in one map",
            inside,
        );
    }
    // Dark signal that grows with the exposure, and veiling glare that follows the mean of each map.
    let note = "an added signal ∝ exposure, capped or not";
    let mut along = build.along(ObservationKind::Bin, Coordinate::Exposure);
    along.one(Acts::Everywhere, "smooth", [0.0, 1.0], note, |row| row.exposure);
    let mean = |this: (usize, usize)| {
        let levels: Vec<f64> = build
            .rows
            .iter()
            .zip(build.level.iter())
            .filter(|(row, _)| row.source == ObservationKind::Bin && key(row) == this)
            .map(|(_, level)| *level)
            .collect();
        levels.iter().sum::<f64>() / levels.len().max(1) as f64
    };
    let means: Vec<f64> = keys.iter().map(|&this| mean(this)).collect();
    // Means of every row's own map and of the one before it.
    let of = |row: &Row| keys.iter().position(|&this| this == key(row));
    let own = |row: &Row| of(row).map_or(0.0, |k| means[k]);
    let earlier = |row: &Row| of(row).and_then(|k| k.checked_sub(1)).map_or(0.0, |k| means[k]);
    let (own, earlier): (Vec<f64>, Vec<f64>) = build.rows.iter().map(|row| (own(row), earlier(row))).unzip();
    for (coordinate, note, means) in [
        (Coordinate::Level, "an added signal ∝ the mean of the map", own),
        (Coordinate::TimeS, "an added signal left by the map before", earlier),
    ] {
        let mut along = build.along(ObservationKind::Bin, coordinate);
        let column = along.column(Acts::Everywhere, move |i, _| means[i]);
        along.add("memory", [0.0, 1.0], note, vec![column]);
    }
}
