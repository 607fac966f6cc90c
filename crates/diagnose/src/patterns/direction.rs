//! Patterns along the angles γ and C, and on the sphere of directions.

use std::collections::BTreeSet;

use isolux_photometry::direction;

use super::Acts::{self, Relative};
use super::place::{Grid, What};
use super::shape::Direction;
use super::shape::Shape::{Between, Beyond, Bump, Power};
use super::{List, waves};
use crate::noise::limits::{CENTRES, CIRCLE_DEG, CIRCLES_APART_DEG, PATCH_DEG};
use crate::noise::series::Series;
use crate::table::{Coordinate, Light, ObservationKind, Row};

/// Of the search.
pub(super) fn gamma(list: &mut List<'_>) {
    let Some((angles, whole)) = list.distinct(ObservationKind::Reading, Coordinate::GammaDeg, 2) else {
        return;
    };
    let [low, high] = whole;
    let step = ((high - low) / (angles.len() - 1) as f64).max(2.5);
    let reach = low.abs().max(high.abs());
    let gamma = list.values(|row| row.gamma_deg);
    let either = list.values(|row| row.gamma_deg.abs());
    let share = list.values(|row| row.gamma_deg / reach);
    let lit = list.lit();
    let mut on = list.on(ObservationKind::Reading, Coordinate::GammaDeg);
    for acts in [Relative, Acts::Light] {
        for width in [0.7 * step, 1.4 * step, 3.0 * step] {
            let spacing = width.max(step);
            let count = ((high - low) / spacing).round() as usize;
            for k in 0..=count {
                let centre = low + k as f64 * spacing;
                let (bump, range) = (Bump(centre, width), [centre - 1.5 * width, centre + 1.5 * width]);
                let near = bump.along(&gamma).times(&lit);
                on.one(acts, "bump", range, "near one signed γ", near);
                if centre > 0.0 && acts == Relative {
                    on.one(acts, "bump", range, "near one |γ|", bump.along(&either));
                }
            }
        }
    }
    for &edge in angles.iter().step_by((angles.len() / 16).max(1)) {
        on.one(
            Relative,
            "jump",
            [edge, high],
            "beyond one γ",
            Beyond(edge).along(&gamma),
        );
    }
    for powers in [&[1][..], &[1, 3, 5]] {
        let odd: Vec<Direction> = powers.iter().map(|&power| Power(power).along(&share)).collect();
        on.add(Relative, "smooth", whole, "an odd change over signed γ", odd);
    }
    for period in [6.0, 8.0, 10.0, 12.0, 15.0, 20.0, 24.0, 30.0, 45.0, 60.0, 90.0] {
        if period >= 2.2 * step {
            let (place, turn) = (format!("that repeats every {period}°"), std::f64::consts::TAU / period);
            on.one(Relative, "periodic", whole, &place, waves(turn, &gamma));
        }
    }
}

/// Of the search.
pub(super) fn azimuth(list: &mut List<'_>) {
    let Some((planes, [low, high])) = list.distinct(ObservationKind::Reading, Coordinate::CDeg, 3) else {
        return;
    };
    let c = list.values(|row| row.c_deg);
    let axis = list.values(|row| row.c_deg.to_radians());
    // Azimuth in the luminaire: (C, −γ) is (C + 180°, γ).
    let azimuth = list.values(|row| (row.c_deg + if row.gamma_deg < 0.0 { 180.0 } else { 0.0 }).to_radians());
    let sine = |power: i32| list.values(|row| row.gamma_deg.to_radians().sin().abs().powi(power));
    let sines: Vec<_> = (0..=6).map(sine).collect();
    let sides = [-1.0, 1.0].map(|side| list.values(|row| f64::from(row.gamma_deg * side > 0.0)));
    let span = (high - low).max(1.0);
    let rising = Direction::of(list.values(|row| (row.c_deg - low) / span));
    let mut on = list.on(ObservationKind::Reading, Coordinate::CDeg);
    let around = [0.0, 360.0];
    for harmonic in 1..=6_usize {
        let order = harmonic as f64;
        let periods = match harmonic {
            1 => "with one period".to_owned(),
            _ => format!("with {harmonic} periods"),
        };
        for power in [0, harmonic] {
            let wave = waves(order, &azimuth).map(|wave| wave.times(&sines[power]));
            on.one(Relative, "harmonic", around, &format!("{periods} around C"), wave);
            if harmonic % 2 == 1 && power == 0 {
                let place = format!("{periods} of the C axis");
                on.one(Relative, "harmonic", around, &place, waves(order, &axis));
            }
        }
    }
    for width in (1..=4).filter(|width| *width != planes.len()) {
        for some in planes.windows(width) {
            let (from, to) = (some[0], some[width - 1]);
            let inside = Between(from, to).along(&c);
            on.one(Relative, "window", [from, to], "of whole C planes", inside.clone());
            for side in &sides {
                let half = inside.clone().times(side);
                on.one(Relative, "half_plane", [from, to], "of C half-planes", half);
            }
        }
    }
    for &edge in &planes[..planes.len() - 1] {
        on.one(Relative, "jump", [edge, high], "beyond one C", Beyond(edge).along(&c));
    }
    on.one(Relative, "smooth", [low, high], "along the C axis", rising);
}

/// The direction of a lit reading.
fn lit_direction(row: &Row) -> Option<[f64; 3]> {
    let towards = direction(row.c_deg, row.gamma_deg).to_array();
    (row.light == Light::Lit && towards.iter().all(|part| part.is_finite())).then_some(towards)
}

/// Of the test of the noise: neighbouring directions of lit readings.
pub(super) fn patches<'a>(series: &'a Series<'a>) -> Vec<Grid<'a>> {
    // Directions two degrees apart or less are one centre.
    let mut known = BTreeSet::new();
    let centres: Vec<&Row> = series
        .rows
        .iter()
        .copied()
        .filter(|row| lit_direction(row).is_some_and(|at| known.insert(at.map(|part| (30.0 * part).round() as i32))))
        .collect();
    let every = centres.len().div_ceil(CENTRES).max(1);
    let grid = |width_deg: f64| {
        let patch = |row: &&Row| {
            let range = [row.gamma_deg - 1.2 * width_deg, row.gamma_deg + 1.2 * width_deg];
            What::Patch([row.c_deg, row.gamma_deg, width_deg]).over(range)
        };
        let places = centres.iter().step_by(every).map(patch).collect();
        Grid::bumps(width_deg.to_radians(), places, |i| lit_direction(series.rows[i]))
    };
    PATCH_DEG.into_iter().map(grid).collect()
}

/// Lit readings near one great circle of directions: what a wire across the beam shades.
pub(super) fn circles<'a>(series: &'a Series<'a>) -> Vec<Grid<'a>> {
    let reach = series
        .rows
        .iter()
        .fold(0.0_f64, |most, row| most.max(row.gamma_deg.abs()));
    // Poles of one hemisphere: those of the other are of the same circles.
    let rings = (90.0 / CIRCLES_APART_DEG).round() as usize;
    let poles = (1..=rings).flat_map(|ring| {
        let gamma_deg = ring as f64 * CIRCLES_APART_DEG;
        let half = if ring == rings { 180.0 } else { 360.0 };
        let count = (half * gamma_deg.to_radians().sin() / CIRCLES_APART_DEG)
            .round()
            .max(1.0);
        (0..count as usize).map(move |k| (half * k as f64 / count, gamma_deg))
    });
    let grid = |width_deg: f64| {
        let circle = |(c_deg, gamma_deg)| What::Circle([c_deg, gamma_deg, width_deg]).over([-reach, reach]);
        let places = poles.clone().map(circle).collect();
        Grid::bumps(width_deg.to_radians(), places, |i| lit_direction(series.rows[i]))
    };
    CIRCLE_DEG.into_iter().map(grid).collect()
}
