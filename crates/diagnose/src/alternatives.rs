//! Empirical alternatives: patterns without a name as columns over the rows, which compete with the catalogue on equal
//! terms.
//!
//! Where one of them explains the data better than every named effect, the verdict is "unexplained" and this pattern
//! says where.

use std::sync::Arc;

use crate::patterns::{Acts, Direction, Pattern, Values, patterns};
use crate::table::{Coordinate, Light, ObservationKind, Row};

/// One generic pattern: up to a few columns over one range of one coordinate.
#[derive(Debug, Clone)]
pub struct EmpiricalAlternative {
    /// Where it lives.
    pub coordinate: Coordinate,
    /// Its family: "jump", "window", "bump", "smooth", "periodic", "memory", …; patterns of a family share its prior.
    pub family: &'static str,
    /// The range of the coordinate that it touches.
    pub range: [f64; 2],
    /// In words, for people.
    pub note: String,
    /// How many directions it has.
    pub directions: usize,
    /// Change of the signal for a unit amplitude, one a direction; they move to the dictionary.
    pub columns: Vec<Column>,
}

/// All alternatives that these rows allow. `level` is the model's expectation, `order` the rows in time order.
pub fn alternatives(rows: &[Row], level: &[f64], order: &[usize]) -> Vec<EmpiricalAlternative> {
    let expected: Values = level.into();
    let of = |pattern: Pattern| -> Option<EmpiricalAlternative> {
        let column = |direction: Direction| Column {
            source: pattern.source,
            acts: pattern.acts,
            level: Arc::clone(&expected),
            direction,
        };
        let columns: Vec<Column> = pattern.directions.into_iter().map(column).collect();
        let nothing = |column: &Column| column.values(rows).all(|value| value == 0.0);
        // An end that is zero but for rounding is zero.
        let span = (pattern.range[1] - pattern.range[0]).abs();
        let tidy = |end: f64| if end.abs() < 1e-9 * span { 0.0 } else { end };
        (!columns.iter().all(nothing)).then(|| EmpiricalAlternative {
            coordinate: pattern.coordinate,
            family: pattern.family,
            range: pattern.range.map(tidy),
            note: pattern.note,
            directions: columns.len(),
            columns,
        })
    };
    patterns(rows, level, order).into_iter().filter_map(of).collect()
}

/// The change of every row for a unit amplitude: its law is kept, its values are computed where they are asked for.
///
/// Thousands of columns of 10⁵ readings are gigabytes; their laws are nothing.
#[derive(Debug, Clone)]
pub struct Column {
    source: ObservationKind,
    acts: Acts,
    level: Values,
    direction: Direction,
}

impl Column {
    /// Its value at row number `i`; 0 on other sources and where the law is no number.
    fn at(&self, i: usize, row: &Row) -> f64 {
        if row.source != self.source {
            return 0.0;
        }
        let strength = match self.acts {
            Acts::Relative => self.level[i],
            Acts::Light if row.light == Light::Capped => 0.0,
            Acts::Light | Acts::Everywhere => 1.0,
        };
        let value = strength * self.direction.weight(i);
        if value.is_finite() { value } else { 0.0 }
    }

    /// Its values at all rows.
    pub fn values<'a>(&'a self, rows: &'a [Row]) -> impl Iterator<Item = f64> + 'a {
        rows.iter().enumerate().map(|(i, row)| self.at(i, row))
    }
}
