//! Parts of the record: the readings of one block, visit, plane, angle, light or time, the bins of one map or ring. The
//! test of the noise compares their means and their scatter.

use std::collections::HashMap;
use std::hash::Hash;

use crate::noise::limits::{ALIKE, MEANS, PARTS, PIECES};
use crate::noise::series::Series;
use crate::table::{Coordinate, Light, ObservationKind, Row};

/// The rows of each part, by their places in a series.
type Parts = Vec<Vec<usize>>;

/// Rows of the same key, for each key.
fn by<K: Hash + Eq>(series: &Series<'_>, key: impl Fn(&Row) -> Option<K>) -> Parts {
    let mut known: HashMap<K, usize> = HashMap::new();
    let mut parts = Parts::new();
    for (i, row) in series.rows.iter().enumerate() {
        let Some(key) = key(row) else { continue };
        let part = *known.entry(key).or_insert(parts.len());
        if part == parts.len() {
            parts.push(Vec::new());
        }
        parts[part].push(i);
    }
    parts
}

/// Numbers of the rows for which `at` is finite, those of a low value first.
fn rising(series: &Series<'_>, at: impl Fn(usize) -> f64) -> Vec<usize> {
    let mut order: Vec<usize> = (0..series.len()).filter(|&i| at(i).is_finite()).collect();
    order.sort_by(|&a, &b| at(a).total_cmp(&at(b)));
    order
}

/// A value of lit rows, NaN elsewhere.
fn lit(row: &Row, value: f64) -> f64 {
    if row.light == Light::Lit { value } else { f64::NAN }
}

/// Eight parts of as many rows.
fn eighths(order: &[usize]) -> Parts {
    let end = |k: usize| k * order.len() / 8;
    (0..8).map(|k| order[end(k)..end(k + 1)].to_vec()).collect()
}

/// Blocks, or maps.
fn blocks(series: &Series<'_>) -> Parts {
    by(series, |row| Some((row.file, row.group)))
}

/// Parts of successive readings: whether their means wander.
pub(crate) fn successive(series: &Series<'_>) -> Vec<(String, Parts)> {
    let all: Vec<usize> = (0..series.len()).collect();
    let of = |length: usize| {
        let note = format!("the means of {length} successive readings wander");
        (note, all.chunks_exact(length).map(<[usize]>::to_vec).collect())
    };
    MEANS.into_iter().map(of).collect()
}

/// Fewer readings are no piece.
const SHORTEST: usize = 3;

/// Pieces of the visits of half-planes: whether they have levels of their own, whatever the smooth terms follow.
pub(crate) fn pieces(series: &Series<'_>) -> Vec<(String, Parts)> {
    let visits = series.visits();
    let of = |count: usize| {
        let note = match count {
            1 => "each visit of a half-plane has a level of its own".to_owned(),
            _ => format!("each of {count} parts of the visits of half-planes has a level of its own"),
        };
        let long = visits.iter().filter(|visit| visit.len() >= SHORTEST * count);
        let piece =
            |visit: &Vec<usize>, k: usize| visit[k * visit.len() / count..(k + 1) * visit.len() / count].to_vec();
        (
            note,
            long.flat_map(|visit| (0..count).map(|k| piece(visit, k))).collect(),
        )
    };
    PIECES.into_iter().map(of).collect()
}

/// Readings of one γ or one level of the light, however often they were visited: a wheel that is not round, codes that
/// are missing.
pub(crate) fn levels(series: &Series<'_>) -> Vec<(String, Parts)> {
    let lit_gamma = |row: &Row| {
        let known = row.light == Light::Lit && row.c_deg.is_finite() && row.gamma_deg.is_finite();
        known.then(|| (10.0 * row.gamma_deg).round() as i64)
    };
    let alike = rising(series, |i| {
        lit_gamma(series.rows[i]).map_or(f64::NAN, |_| series.level[i])
    });
    let mut alike: Parts = alike.chunks(ALIKE).map(<[usize]>::to_vec).collect();
    for part in &mut alike {
        part.sort_unstable();
    }
    alike.sort_unstable();
    [
        ("each γ has a level of its own", by(series, lit_gamma)),
        (
            "each γ has a level of its own in each direction of travel",
            by(series, |row| Some((lit_gamma(row)?, row.travel as i64))),
        ),
        ("each level of the light has an error of its own", alike),
    ]
    .map(|(note, parts)| (note.to_owned(), parts))
    .into()
}

/// Parts whose scatter is compared with that of the others, along which coordinate, and what one of them is.
pub(crate) fn apart(series: &Series<'_>) -> Vec<(Coordinate, &'static str, Parts)> {
    match series.source {
        ObservationKind::Reading => apart_readings(series),
        _ => apart_bins(series),
    }
}

fn apart_readings(series: &Series<'_>) -> Vec<(Coordinate, &'static str, Parts)> {
    let (rows, n) = (&series.rows, series.len());
    let visits = series.visits();
    let long = visits.iter().filter(|visit| visit.len() > 2);
    let first = long.map(|visit| visit[0]).collect();
    let range = |k: usize| rows[k].range.to_bits();
    let switched = |k: &usize| series.follows[*k] && range(*k) != range(*k - 1);
    let dark = [Light::Baffled, Light::LampOff, Light::Capped]
        .map(|light| (0..n).filter(|&i| rows[i].light == light).collect());
    let either = rising(series, |i| lit(rows[i], rows[i].gamma_deg.abs()));
    let signed = rising(series, |i| lit(rows[i], rows[i].gamma_deg));
    let stretch = |length: usize| {
        (0..=n - length)
            .step_by(length / 2)
            .map(move |from| (from..from + length).collect())
    };
    let stretches = PARTS.into_iter().filter(|length| 3 * length < n).flat_map(stretch);
    let illuminated = |row: &Row| (row.light == Light::Lit).then(|| row.c_deg.to_bits());
    vec![
        (Coordinate::Index, "one block", blocks(series)),
        (
            Coordinate::Index,
            "the first of each visit of a half-plane",
            vec![first],
        ),
        (
            Coordinate::Index,
            "the first after each change of the range",
            vec![(1..n).filter(switched).collect()],
        ),
        (Coordinate::Index, "one visit of a half-plane", visits),
        (Coordinate::CDeg, "one C plane", by(series, illuminated)),
        (
            Coordinate::DistanceMm,
            "one distance",
            by(series, |row| Some(row.distance_mm.to_bits())),
        ),
        (
            Coordinate::Range,
            "one range",
            by(series, |row| Some(row.range.to_bits())),
        ),
        (Coordinate::Index, "the dark readings", dark.into()),
        (
            Coordinate::GammaDeg,
            "some γ",
            [eighths(&either), eighths(&signed)].concat(),
        ),
        (Coordinate::Index, "one part of the record", stretches.collect()),
    ]
}

fn apart_bins(series: &Series<'_>) -> Vec<(Coordinate, &'static str, Parts)> {
    let along = |coordinate: Coordinate| {
        let at = |i: usize| lit(series.rows[i], series.rows[i].coordinate(coordinate, 0.0));
        eighths(&rising(series, at))
    };
    vec![
        (Coordinate::Exposure, "one map", blocks(series)),
        (Coordinate::RadiusMm, "one ring", along(Coordinate::RadiusMm)),
        (Coordinate::XMm, "some columns", along(Coordinate::XMm)),
        (Coordinate::YMm, "some rows", along(Coordinate::YMm)),
    ]
}
