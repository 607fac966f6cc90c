//! Empirical alternatives: generic patterns along every coordinate, which compete with the catalogue on equal terms.
//!
//! Where one of them explains the data better than every named effect, the verdict is "unexplained" and this pattern
//! says where. `relative` patterns multiply the expected signal; `absolute` ones add to it.

mod direction;
mod distance;
mod maps;
mod meter;
mod time;
mod wavelength;

use std::sync::Arc;

use crate::pattern::{Acts, Pattern};
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
    pub columns: Vec<Pattern>,
}

/// All alternatives that these rows allow. `level` is the model's expectation, `order` the rows in time order.
pub fn alternatives(rows: &[Row], level: &[f64], order: &[usize]) -> Vec<EmpiricalAlternative> {
    let mut build = Builder {
        rows,
        level: level.into(),
        found: Vec::new(),
    };
    if rows.iter().any(|row| row.source == ObservationKind::Reading) {
        time::time(&mut build);
        time::memory(&mut build, order);
        time::visits(&mut build, order);
        direction::gamma(&mut build);
        direction::azimuth(&mut build);
        distance::distance(&mut build, ObservationKind::Reading);
        distance::travel(&mut build);
        meter::range(&mut build);
        meter::ambient(&mut build, order);
        meter::signal_level(&mut build, ObservationKind::Reading);
    }
    if rows.iter().any(|row| row.source == ObservationKind::Bin) {
        maps::maps(&mut build);
        distance::distance(&mut build, ObservationKind::Bin);
        meter::signal_level(&mut build, ObservationKind::Bin);
    }
    if rows.iter().any(|row| row.source == ObservationKind::Sample) {
        wavelength::wavelength(&mut build);
    }
    build.found
}

/// Collects patterns; knows how to turn a function of a row into a column.
struct Builder<'a> {
    rows: &'a [Row],
    level: Arc<[f64]>,
    found: Vec<EmpiricalAlternative>,
}

impl<'a> Builder<'a> {
    fn along(&mut self, source: ObservationKind, coordinate: Coordinate) -> Along<'_, 'a> {
        Along {
            build: self,
            source,
            coordinate,
        }
    }

    /// Distinct finite values of a coordinate over rows of `source` that carry signal, rising.
    fn distinct(&self, source: ObservationKind, coordinate: Coordinate) -> Vec<f64> {
        let mut values: Vec<f64> = self
            .rows
            .iter()
            .zip(self.level.iter())
            .filter(|(row, _)| row.source == source && row.light == Light::Lit)
            .map(|(row, &level)| row.coordinate(coordinate, level))
            .filter(|value| value.is_finite())
            .collect();
        values.sort_by(f64::total_cmp);
        values.dedup();
        values
    }
}

/// Collects the patterns of rows of one source that live along one coordinate.
struct Along<'b, 'a> {
    build: &'b mut Builder<'a>,
    source: ObservationKind,
    coordinate: Coordinate,
}

impl Along<'_, '_> {
    /// The pattern `law(number, row)`, NaN read as 0.
    fn column(&self, acts: Acts, law: impl Fn(usize, &Row) -> f64 + Send + Sync + 'static) -> Pattern {
        Pattern::new(self.source, acts, &self.build.level, law)
    }

    /// An alternative of one direction.
    fn one(
        &mut self,
        acts: Acts,
        family: &'static str,
        range: [f64; 2],
        note: impl Into<String>,
        law: impl Fn(&Row) -> f64 + Send + Sync + 'static,
    ) {
        let column = self.column(acts, move |_, row| law(row));
        self.add(family, range, note, vec![column]);
    }

    /// As [`one`](Self::one), relative to the expected signal.
    fn relative(
        &mut self,
        family: &'static str,
        range: [f64; 2],
        note: impl Into<String>,
        law: impl Fn(&Row) -> f64 + Send + Sync + 'static,
    ) {
        self.one(Acts::Relative, family, range, note, law);
    }

    /// As [`relative`](Self::relative), for a law of the expected signal.
    fn of_level(
        &mut self,
        family: &'static str,
        range: [f64; 2],
        note: impl Into<String>,
        law: impl Fn(f64, &Row) -> f64 + Send + Sync + 'static,
    ) {
        let level = Arc::clone(&self.build.level);
        let column = self.column(Acts::Relative, move |i, row| law(level[i], row));
        self.add(family, range, note, vec![column]);
    }

    /// Cosine and sine of an angle, both times a size.
    fn waves(
        &mut self,
        acts: Acts,
        family: &'static str,
        range: [f64; 2],
        note: impl Into<String>,
        law: impl Fn(&Row) -> (f64, f64) + Copy + Send + Sync + 'static,
    ) {
        let wave = |wave: fn(f64) -> f64| {
            self.column(acts, move |_, row| {
                let (angle, size) = law(row);
                wave(angle) * size
            })
        };
        let columns = vec![wave(f64::cos), wave(f64::sin)];
        self.add(family, range, note, columns);
    }

    fn add(&mut self, family: &'static str, range: [f64; 2], note: impl Into<String>, columns: Vec<Pattern>) {
        let nothing = |column: &Pattern| column.values(self.build.rows).all(|value| value == 0.0);
        if columns.iter().all(nothing) {
            return;
        }
        // An end that is zero but for rounding is zero.
        let span = (range[1] - range[0]).abs();
        let tidy = |end: f64| if end.abs() < 1e-9 * span { 0.0 } else { end };
        self.build.found.push(EmpiricalAlternative {
            coordinate: self.coordinate,
            family,
            range: range.map(tidy),
            note: note.into(),
            directions: columns.len(),
            columns,
        });
    }
}

fn word(acts: Acts) -> &'static str {
    match acts {
        Acts::Relative => "a relative change",
        Acts::Light | Acts::Everywhere => "an added signal",
    }
}
