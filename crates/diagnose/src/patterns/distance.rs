//! Patterns along the distance, and of the direction of travel.

use super::Acts::{self, Relative};
use super::List;
use super::shape::Direction;
use super::shape::Shape::{Between, Power};
use crate::table::{Coordinate, ObservationKind};

pub(super) fn distance(list: &mut List<'_>, source: ObservationKind) {
    let Some((distances, reach)) = list.distinct(source, Coordinate::DistanceMm, 2) else {
        return;
    };
    let (distance, lit) = (list.values(|row| row.distance_mm), list.lit());
    let logarithm = Direction::of(list.values(|row| (row.distance_mm / reach[0]).ln()));
    let falling = Direction::of(list.values(|row| reach[0] / row.distance_mm)).times(&lit);
    let odd = list.values(|row| row.gamma_deg.to_radians().sin());
    let even = list.values(|row| row.gamma_deg.to_radians().sin().powi(2));
    let mut on = list.on(source, Coordinate::DistanceMm);
    for here in distances {
        let (at, range) = (Between(here, here).along(&distance), [here, here]);
        on.one(Relative, "jump", range, "at one distance", at.clone());
        on.one(Acts::Light, "jump", range, "at one distance", at.clone().times(&lit));
        if source == ObservationKind::Reading {
            for (family, sine) in [("odd", &odd), ("even", &even)] {
                let note = format!("an {family} change over γ at one distance");
                on.add(Relative, family, range, &note, at.clone().times(sine));
            }
        }
    }
    on.add(Relative, "smooth", reach, "another power of the distance", logarithm);
    on.one(Acts::Light, "smooth", reach, "that falls with distance", falling);
}

pub(super) fn travel(list: &mut List<'_>) {
    let Some((_, ways)) = list.distinct(ObservationKind::Reading, Coordinate::Travel, 2) else {
        return;
    };
    let travel = list.values(|row| row.travel);
    let even = list.values(|row| row.gamma_deg.to_radians().sin().powi(2));
    let way = Power(1).along(&travel);
    let mut on = list.on(ObservationKind::Reading, Coordinate::Travel);
    for acts in [Relative, Acts::Light] {
        on.one(acts, "jump", ways, "with the direction of travel", way.clone());
    }
    let note = "a change with travel that grows with γ";
    on.add(Relative, "even", ways, note, way.times(&even));
    let rest = Between(0.0, 0.0).along(&travel);
    on.one(Relative, "jump", [0.0, 0.0], "of readings at rest", rest);
}
