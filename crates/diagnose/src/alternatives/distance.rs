//! Patterns along the distance, and of the direction of travel.

use super::Builder;
use crate::pattern::Acts;
use crate::table::{Coordinate, Light, ObservationKind, Row};

pub(super) fn distance(build: &mut Builder<'_>, source: ObservationKind) {
    let distances = build.distinct(source, Coordinate::DistanceMm);
    if distances.len() < 2 {
        return;
    }
    let mut along = build.along(source, Coordinate::DistanceMm);
    let illuminated = |row: &Row| f64::from(row.light == Light::Lit);
    let sin = |row: &Row| row.gamma_deg.to_radians().sin();
    for &here in &distances {
        let (at, range) = (move |row: &Row| f64::from(row.distance_mm == here), [here, here]);
        along.relative("jump", range, "a relative change at one distance", at);
        along.one(
            Acts::Light,
            "jump",
            range,
            "an added signal at one distance",
            move |row| at(row) * illuminated(row),
        );
        if source == ObservationKind::Reading {
            along.relative("odd", range, "an odd change over γ at one distance", move |row| {
                at(row) * sin(row)
            });
            along.relative("even", range, "an even change over γ at one distance", move |row| {
                at(row) * sin(row).powi(2)
            });
        }
    }
    let reach = [distances[0], distances[distances.len() - 1]];
    along.relative("smooth", reach, "another power of the distance", move |row| {
        (row.distance_mm / reach[0]).ln()
    });
    along.one(
        Acts::Light,
        "smooth",
        reach,
        "an added signal that falls with distance",
        move |row| illuminated(row) * (reach[0] / row.distance_mm),
    );
}

pub(super) fn travel(build: &mut Builder<'_>) {
    let ways = build.distinct(ObservationKind::Reading, Coordinate::Travel);
    if ways.len() < 2 {
        return;
    }
    let reach = [ways[0], ways[ways.len() - 1]];
    let mut along = build.along(ObservationKind::Reading, Coordinate::Travel);
    let way = |row: &Row| row.travel;
    along.relative("jump", reach, "a relative change with the direction of travel", way);
    along.one(
        Acts::Light,
        "jump",
        reach,
        "an added signal with the direction of travel",
        way,
    );
    along.relative("even", reach, "a change with travel that grows with γ", |row| {
        row.travel * row.gamma_deg.to_radians().sin().powi(2)
    });
    along.relative("jump", [0.0, 0.0], "a relative change of readings at rest", |row| {
        f64::from(row.travel == 0.0)
    });
}
