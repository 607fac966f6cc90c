//! Patterns along the angles γ and C.

use super::{Builder, word};
use crate::pattern::Acts;
use crate::table::{Coordinate, Light, Row, Source};

pub(super) fn gamma(build: &mut Builder<'_>) {
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

pub(super) fn azimuth(build: &mut Builder<'_>) {
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
