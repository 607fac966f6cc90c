//! Patterns along the distance, and of the direction of travel.

use super::Builder;
use crate::pattern::Acts;
use crate::table::{Coordinate, Light, Row, Source};

pub(super) fn distance(build: &mut Builder<'_>, source: Source) {
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

pub(super) fn travel(build: &mut Builder<'_>) {
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
