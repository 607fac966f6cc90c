//! Patterns of the meter and its room: range, expected signal, temperature.

use super::Acts::{self, Everywhere, Relative};
use super::List;
use super::shape::Shape::{Between, Beyond, Fading, Power, Rising};
use super::shape::{Direction, Values};
use crate::table::{Coordinate, ObservationKind};

pub(super) fn range(list: &mut List<'_>) {
    let Some((ranges, _)) = list.distinct(ObservationKind::Reading, Coordinate::Range, 2) else {
        return;
    };
    let (level, range) = (list.level, list.values(|row| row.range));
    let mut on = list.on(ObservationKind::Reading, Coordinate::Range);
    for here in ranges {
        let at = Between(here, here).along(&range);
        let inside = (0..level.len()).map(|i| at.weight(i) * level[i]);
        let top = inside.fold(0.0, f64::max);
        for acts in [Relative, Everywhere] {
            on.one(acts, "jump", [here, here], "in one range", at.clone());
        }
        if top > 0.0 {
            let slope = at.times(&level.iter().map(|level| level / top).collect());
            on.add(
                Relative,
                "slope",
                [here, here],
                "a non-linearity inside one range",
                slope,
            );
        }
    }
}

pub(super) fn signal_level(list: &mut List<'_>, source: ObservationKind) {
    let own = list.rows.iter().zip(list.level).filter(|(row, _)| row.source == source);
    let top = own.map(|(_, level)| *level).fold(0.0, f64::max);
    if top <= 0.0 {
        return;
    }
    let share: Values = list.level.iter().map(|level| (level / top).max(1e-9)).collect();
    let law = |law: &dyn Fn(f64) -> f64| Direction::of(share.iter().map(|share| law(*share)).collect());
    let whole = [0.0, top];
    let mut on = list.on(source, Coordinate::Level);
    for power in [0.5, 2.0, 4.0] {
        let place = format!("∝ signal^{power}");
        on.one(Relative, "smooth", whole, &place, law(&|share| share.powf(power)));
    }
    on.one(
        Relative,
        "smooth",
        whole,
        "with the logarithm of the signal",
        law(&f64::ln),
    );
    for edge in [0.03, 0.1, 0.3, 0.5, 0.7, 0.85, 0.95] {
        let (above, note) = ([edge * top, top], "a signal that bends above one level");
        on.add(Relative, "knee", above, note, Rising(edge).along(&share));
        on.one(Relative, "jump", above, "above one level", Beyond(edge).along(&share));
        if edge <= 0.3 {
            let (below, note) = ([0.0, edge * top], "a signal that bends at low level");
            on.add(Relative, "knee", below, note, Fading(0.0, edge).along(&share));
        }
    }
}

pub(super) fn ambient(list: &mut List<'_>) {
    let Some((_, whole)) = list.distinct(ObservationKind::Reading, Coordinate::AmbientC, 2) else {
        return;
    };
    let [low, high] = whole;
    if high - low < 1e-6 {
        return;
    }
    let (middle, half) = (0.5 * (low + high), 0.5 * (high - low));
    let place = list.values(|row| (row.ambient_c - middle) / half);
    let (rows, order) = (list.rows, list.order);
    let mut on = list.on(ObservationKind::Reading, Coordinate::AmbientC);
    let curved = "a curved change with temperature";
    on.add(Relative, "smooth", whole, curved, Power(2).along(&place));
    for acts in [Acts::Light, Everywhere] {
        on.one(acts, "smooth", whole, "with temperature", Power(1).along(&place));
    }
    for edge in [-0.5, 0.0, 0.5] {
        let (from, above) = (middle + edge * half, Beyond(edge).along(&place));
        on.one(Relative, "jump", [from, high], "above one temperature", above);
    }
    let in_time: Vec<usize> = order
        .iter()
        .copied()
        .filter(|&i| rows[i].source == ObservationKind::Reading && rows[i].ambient_c.is_finite())
        .collect();
    for lag_s in [100.0, 300.0, 1000.0] {
        let mut lagged = vec![0.0; rows.len()];
        let mut average = in_time.first().map_or(0.0, |&i| rows[i].ambient_c);
        for (k, &i) in in_time.iter().enumerate() {
            let before = in_time[k.saturating_sub(1)];
            let gap = rows[i].time_s - rows[before].time_s;
            let keep = (-gap.max(0.0) / lag_s).exp();
            average = keep * average + (1.0 - keep) * rows[i].ambient_c;
            lagged[i] = (rows[i].ambient_c - average) / half;
        }
        let note = "a change with the rate of temperature";
        on.add(Relative, "lag", whole, note, Direction::of(lagged.into()));
    }
}
