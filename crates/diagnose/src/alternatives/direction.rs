//! Patterns along the angles γ and C.

use super::{Builder, word};
use crate::pattern::Acts;
use crate::table::{Coordinate, Light, ObservationKind, Row};

pub(super) fn gamma(build: &mut Builder<'_>) {
    let angles = build.distinct(ObservationKind::Reading, Coordinate::GammaDeg);
    let (Some(&low), Some(&high)) = (angles.first(), angles.last()) else {
        return;
    };
    if high <= low {
        return;
    }
    let mut along = build.along(ObservationKind::Reading, Coordinate::GammaDeg);
    let (step, whole) = (((high - low) / (angles.len() - 1) as f64).max(2.5), [low, high]);
    let illuminated = |row: &Row| f64::from(row.light == Light::Lit);
    for acts in [Acts::Relative, Acts::Light] {
        for width in [0.7 * step, 1.4 * step, 3.0 * step] {
            let spacing = width.max(step);
            let count = ((high - low) / spacing).round() as usize;
            for k in 0..=count {
                let centre = low + k as f64 * spacing;
                let bump = move |gamma: f64| (-0.5 * ((gamma - centre) / width).powi(2)).exp();
                let range = [centre - 1.5 * width, centre + 1.5 * width];
                let note = format!("{} near one signed γ", word(acts));
                along.one(acts, "bump", range, note, move |row| {
                    illuminated(row) * bump(row.gamma_deg)
                });
                if centre > 0.0 && acts == Acts::Relative {
                    let note = format!("{} near one |γ|", word(acts));
                    along.relative("bump", range, note, move |row| bump(row.gamma_deg.abs()));
                }
            }
        }
    }
    for &edge in angles.iter().step_by((angles.len() / 16).max(1)) {
        along.relative("jump", [edge, high], "a relative change beyond one γ", move |row| {
            f64::from(row.gamma_deg > edge)
        });
    }
    let reach = low.abs().max(high.abs());
    let odd = [1, 3, 5].map(|power| along.column(Acts::Relative, move |_, row| (row.gamma_deg / reach).powi(power)));
    along.add("smooth", whole, "an odd change over signed γ", odd[..1].to_vec());
    along.add("smooth", whole, "an odd change over signed γ", odd.to_vec());
    for period in [6.0, 8.0, 10.0, 12.0, 15.0, 20.0, 24.0, 30.0, 45.0, 60.0, 90.0] {
        if period < 2.2 * step {
            continue;
        }
        let turn = std::f64::consts::TAU / period;
        let note = format!("a relative change that repeats every {period}°");
        along.waves(Acts::Relative, "periodic", whole, note, move |row| {
            (turn * row.gamma_deg, 1.0)
        });
    }
}

pub(super) fn azimuth(build: &mut Builder<'_>) {
    let planes = build.distinct(ObservationKind::Reading, Coordinate::CDeg);
    let (Some(&low), Some(&high)) = (planes.first(), planes.last()) else {
        return;
    };
    if planes.len() < 3 {
        return;
    }
    let mut along = build.along(ObservationKind::Reading, Coordinate::CDeg);
    for harmonic in 1..=6 {
        let order = f64::from(harmonic);
        let periods = if harmonic == 1 {
            "one period".to_owned()
        } else {
            format!("{harmonic} periods")
        };
        for power in [0, harmonic] {
            let note = format!("a relative change with {periods} around C");
            along.waves(Acts::Relative, "harmonic", [0.0, 360.0], note, move |row| {
                // Azimuth in the luminaire: (C, −γ) is (C + 180°, γ).
                let azimuth = (row.c_deg + if row.gamma_deg < 0.0 { 180.0 } else { 0.0 }).to_radians();
                (order * azimuth, row.gamma_deg.to_radians().sin().abs().powi(power))
            });
            if harmonic % 2 == 1 && power == 0 {
                let note = format!("a relative change with {periods} of the C axis");
                along.waves(Acts::Relative, "harmonic", [0.0, 360.0], note, move |row| {
                    (order * row.c_deg.to_radians(), 1.0)
                });
            }
        }
    }
    for width in 1..=4_usize {
        for start in 0..planes.len().saturating_sub(width - 1) {
            let (from, to) = (planes[start], planes[start + width - 1]);
            if width == planes.len() {
                continue;
            }
            let inside = move |row: &Row| row.c_deg >= from && row.c_deg <= to;
            along.relative(
                "window",
                [from, to],
                "a relative change of whole C planes",
                move |row| f64::from(inside(row)),
            );
            for side in [-1.0, 1.0] {
                along.relative(
                    "half_plane",
                    [from, to],
                    "a relative change of C half-planes",
                    move |row| f64::from(inside(row) && row.gamma_deg * side > 0.0),
                );
            }
        }
    }
    for &edge in planes.iter().take(planes.len() - 1) {
        along.relative("jump", [edge, high], "a relative change beyond one C", move |row| {
            f64::from(row.c_deg > edge)
        });
    }
    let span = (high - low).max(1.0);
    along.relative(
        "smooth",
        [low, high],
        "a relative change along the C axis",
        move |row| (row.c_deg - low) / span,
    );
}
