//! Patterns on sensor maps: fixed to the sensor, to the angle of incidence, to single maps.

use std::rc::Rc;

use super::Acts::{Everywhere, Relative};
use super::place::{Grid, What};
use super::shape::Shape::{Between, Beyond, Bump, Cosine, Fading};
use super::shape::{Direction, Values};
use super::{List, waves};
use crate::noise::limits::PATCH_SHARE;
use crate::noise::series::Series;
use crate::table::{Coordinate, Light, ObservationKind, Row};

/// Of the search.
pub(super) fn maps(list: &mut List<'_>) {
    let along_x = list.distinct(ObservationKind::Bin, Coordinate::XMm, 4);
    let along_y = list.distinct(ObservationKind::Bin, Coordinate::YMm, 4);
    if let (Some((xs, [_, right])), Some((ys, [_, top]))) = (along_x, along_y) {
        along(list, Coordinate::XMm, &xs);
        along(list, Coordinate::YMm, &ys);
        plane(list, right.abs().max(top.abs()).max(f64::MIN_POSITIVE));
        incidence(list);
        single_maps(list);
    }
}

/// Columns or rows of the sensor: taps, bands, periodic patterns.
fn along(list: &mut List<'_>, coordinate: Coordinate, places: &[f64]) {
    let (low, high) = (places[0], places[places.len() - 1]);
    let pitch = (high - low) / (places.len() - 1) as f64;
    let stride = (places.len() / 24).max(1);
    let (whole, size) = ([low, high], high - low + pitch);
    let at = list.values(|row| row.coordinate(coordinate, 0.0));
    let from_edge: Values = at.iter().map(|at| at - low).collect();
    let line: Values = from_edge.iter().map(|at| (at / pitch).round()).collect();
    let mut on = list.on(ObservationKind::Bin, coordinate);
    for acts in [Relative, Everywhere] {
        for &edge in places.iter().skip(1).step_by(stride) {
            let (from, beyond) = (edge - 0.5 * pitch, Beyond(edge - 0.5 * pitch).along(&at));
            on.one(acts, "jump", [from, high], "on one side of the sensor", beyond);
        }
        for width in [stride, 2 * stride, 4 * stride] {
            for start in (0..places.len().saturating_sub(width)).step_by(width.div_ceil(2)) {
                let (from, to) = (places[start] - 0.5 * pitch, places[start + width - 1] + 0.5 * pitch);
                let band = Between(from, to).along(&at);
                on.one(acts, "window", [from, to], "in one band of the sensor", band);
            }
        }
        for cycles in [0.5, 1.0, 1.5, 2.0, 2.5, 3.0, 4.0, 5.0, 6.0, 8.0, 12.0] {
            if size / cycles < 1.9 * pitch || (acts == Relative && cycles >= 1.0 && coordinate == Coordinate::YMm) {
                continue; // a relative banding along y has a name: flicker of a rolling shutter
            }
            let wave = waves(std::f64::consts::TAU * cycles / size, &from_edge);
            on.one(acts, "periodic", whole, "that repeats over the sensor", wave);
        }
        // A wave whose period is two lines.
        let alternating = Cosine(std::f64::consts::PI).along(&line);
        on.one(acts, "alternating", whole, "of every other line", alternating);
        for (edge, inwards) in [(low, size), (high, -size)] {
            for share in [0.1, 0.3] {
                let inner = edge + share * inwards;
                let fading = Fading(edge, share * size).along(&at);
                let range = [edge.min(inner), edge.max(inner)];
                on.one(acts, "edge", range, "towards one edge", fading);
            }
        }
    }
}

/// Patterns in the plane of the sensor, which reaches so far in mm: spots, quadrants, rings, polynomials.
fn plane(list: &mut List<'_>, reach: f64) {
    let (x, y) = (list.values(|row| row.x_mm / reach), list.values(|row| row.y_mm / reach));
    let of = |law: &dyn Fn(f64, f64) -> f64| Direction::of(x.iter().zip(y.iter()).map(|(x, y)| law(*x, *y)).collect());
    let powers = |powers: &[(i32, i32)]| -> Vec<Direction> {
        powers.iter().map(|&(i, j)| of(&|x, y| x.powi(i) * y.powi(j))).collect()
    };
    let polynomials = [
        (powers(&[(2, 0), (1, 1), (0, 2)]), "curved over the sensor"),
        (powers(&[(3, 0), (2, 1), (1, 2), (0, 3)]), "twisted over the sensor"),
        (powers(&[(1, 1)]), "across the diagonals"),
        // (a displaced sensor makes a relative slope)
        (powers(&[(1, 0), (0, 1)]), "sloping over the sensor"),
    ];
    let opposite = of(&|x, y| x.signum() * y.signum());
    let quadrants = [[-1.0, -1.0], [-1.0, 1.0], [1.0, -1.0], [1.0, 1.0]]
        .map(|[sx, sy]| ([sx, sy], of(&|x, y| f64::from(x * sx > 0.0 && y * sy > 0.0))));
    let square = of(&|x, y| x * x + y * y);
    let fourth = of(&|x, y| (x * x + y * y).powi(2));
    let whole = [-reach, reach];
    for acts in [Relative, Everywhere] {
        let mut on = list.on(ObservationKind::Bin, Coordinate::XMm);
        for (directions, how) in &polynomials[..if acts == Relative { 3 } else { 4 }] {
            on.one(acts, "plane", whole, how, directions.clone());
        }
        on.one(acts, "quadrant", whole, "of opposite quadrants", opposite.clone());
        for (corner, inside) in &quadrants {
            let range = if corner[0] > 0.0 { [0.0, reach] } else { [-reach, 0.0] };
            on.one(acts, "quadrant", range, "of one quadrant", inside.clone());
            let fading = Fading(0.0, 0.5).around(*corner, [&x, &y]);
            on.one(acts, "corner", range, "in one corner", fading);
        }
        // An added spot has a name: ghost.
        for (width, count) in [(0.12, 7), (0.3, 5)].into_iter().filter(|_| acts == Relative) {
            let centre = |k: i32| -0.85 + 1.7 * f64::from(k) / f64::from(count - 1);
            for (i, j) in (0..count).flat_map(|i| (0..count).map(move |j| (i, j))) {
                let range = [-1.5, 1.5].map(|widths| (centre(i) + widths * width) * reach);
                let spot = Bump(0.0, width).around([centre(i), centre(j)], [&x, &y]);
                on.one(acts, "spot", range, "in one spot", spot);
            }
        }
        let mut on = list.on(ObservationKind::Bin, Coordinate::RadiusMm);
        for ring in 0..6 {
            let centre = 0.2 * f64::from(ring) + 0.1;
            let range = [(centre - 0.15) * reach, (centre + 0.15) * reach];
            let bump = Bump(centre, 0.12).around([0.0, 0.0], [&x, &y]);
            on.one(acts, "ring", range, "in one ring", bump);
        }
        on.one(acts, "smooth", [0.0, reach], "∝ r⁴", fourth.clone());
        if acts == Everywhere {
            on.one(acts, "smooth", [0.0, reach], "∝ r²", square.clone());
        }
    }
}

fn incidence(list: &mut List<'_>) {
    let Some((_, [low, high])) = list.distinct(ObservationKind::Bin, Coordinate::IncidenceDeg, 2) else {
        return;
    };
    let angle = list.values(|row| row.incidence_deg);
    let mut on = list.on(ObservationKind::Bin, Coordinate::IncidenceDeg);
    let inside = |edge: &f64| low < *edge && *edge < high;
    for edge in [5.0, 10.0, 20.0, 30.0, 45.0].into_iter().filter(inside) {
        let beyond = Beyond(edge).along(&angle);
        on.one(Relative, "jump", [edge, high], "beyond one angle of incidence", beyond);
        let (range, near) = ([0.7 * edge, 1.3 * edge], Bump(edge, 0.3 * edge).along(&angle));
        on.one(Relative, "bump", range, "near one angle of incidence", near);
    }
}

/// Single maps, and what one map leaves behind in the next.
fn single_maps(list: &mut List<'_>) {
    let key = |row: &Row| (row.file, row.group);
    let bins: Vec<(usize, &Row)> = (list.rows.iter().enumerate())
        .filter(|(_, row)| row.source == ObservationKind::Bin)
        .collect();
    let mut firsts = bins.clone();
    firsts.dedup_by_key(|(_, row)| key(row));
    if firsts.len() < 2 {
        return;
    }
    let of = |row: &Row| firsts.iter().position(|(_, first)| key(first) == key(row));
    let map = list.values(|row| of(row).map_or(f64::NAN, |k| k as f64));
    for &(i, row) in &firsts {
        let (coordinate, value) = if row.time_s.is_finite() {
            (Coordinate::TimeS, row.time_s)
        } else {
            (Coordinate::Exposure, row.exposure)
        };
        let inside = Between(map[i], map[i]).along(&map);
        let mut on = list.on(ObservationKind::Bin, coordinate);
        if row.light == Light::Lit {
            on.one(Relative, "one_map", [value, value], "of one map", inside.clone());
        }
        on.one(Everywhere, "one_map", [value, value], "in one map", inside);
    }
    // Dark signal that grows with the exposure, and veiling glare that follows the mean of each map.
    let exposure = Direction::of(list.values(|row| row.exposure));
    let mut on = list.on(ObservationKind::Bin, Coordinate::Exposure);
    on.one(Everywhere, "smooth", [0.0, 1.0], "∝ exposure, capped or not", exposure);
    let mean = |this: &Row| {
        let own = bins.iter().filter(|(_, row)| key(row) == key(this));
        let levels: Vec<f64> = own.map(|(i, _)| list.level[*i]).collect();
        levels.iter().sum::<f64>() / levels.len().max(1) as f64
    };
    let means: Vec<f64> = firsts.iter().map(|(_, row)| mean(row)).collect();
    // Means of every row's own map and of the one before it.
    let own = list.values(|row| of(row).map_or(0.0, |k| means[k]));
    let earlier = list.values(|row| of(row).and_then(|k| k.checked_sub(1)).map_or(0.0, |k| means[k]));
    for (coordinate, place, means) in [
        (Coordinate::Level, "∝ the mean of the map", own),
        (Coordinate::TimeS, "left by the map before", earlier),
    ] {
        let mut on = list.on(ObservationKind::Bin, coordinate);
        on.one(Everywhere, "memory", [0.0, 1.0], place, Direction::of(means));
    }
}

/// Of the test of the noise: every second to every eighth column and row of the bins.
pub(super) fn lines<'a>(series: &'a Series<'a>) -> Vec<Grid<'a>> {
    let reach = series.rows.iter().fold(0.0_f64, |most, row| most.max(row.x_mm.abs()));
    let along = |coordinate: Coordinate| {
        let at: Vec<f64> = series.rows.iter().map(|row| row.coordinate(coordinate, 0.0)).collect();
        let mut places = at.clone();
        places.sort_by(f64::total_cmp);
        places.dedup_by(|a, b| (*a - *b).abs() < 1e-9);
        let number = move |i: usize| places.partition_point(|place| *place < at[i] - 1e-9);
        let line: Rc<[usize]> = (0..series.len()).map(number).collect();
        (2..=8).map(move |n| {
            let every = |k: usize| What::Line(coordinate, n, k).over([-reach, reach]);
            let line = Rc::clone(&line);
            Grid::line(1.0, (0..n).map(every).collect(), move |i| Some((line[i] % n) as f64))
        })
    };
    [Coordinate::XMm, Coordinate::YMm].into_iter().flat_map(along).collect()
}

/// Of the test of the noise: neighbouring bins, the same in all lit maps.
pub(super) fn spots<'a>(series: &'a Series<'a>) -> Vec<Grid<'a>> {
    let at = |i: usize| {
        let row = series.rows[i];
        (row.light == Light::Lit).then_some([row.x_mm, row.y_mm, 0.0])
    };
    let reach = (0..series.len())
        .filter_map(at)
        .fold(0.0_f64, |most, [x, ..]| most.max(x.abs()));
    let centre = |k: usize| reach * (2.0 * k as f64 / 11.0 - 1.0);
    let grid = |width_mm: f64| {
        let spot = |k: usize| {
            let (x, y) = (centre(k % 12), centre(k / 12));
            What::Spot([x, y, width_mm]).over([x - 1.2 * width_mm, x + 1.2 * width_mm])
        };
        Grid::bumps(width_mm, (0..144).map(spot).collect(), at)
    };
    let widths = PATCH_SHARE.map(|share| 2.0 * share * reach);
    widths.into_iter().filter(|width| *width > 0.0).map(grid).collect()
}
