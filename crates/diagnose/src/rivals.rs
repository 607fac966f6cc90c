//! Rivals without a name: generic patterns along every coordinate, which compete with the catalogue on equal terms.
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
use crate::table::{Coordinate, Light, Row, Source};

/// One generic pattern: up to a few columns over one range of one coordinate.
#[derive(Debug, Clone)]
pub struct Rival {
    /// Where it lives.
    pub coordinate: Coordinate,
    /// Its family: "jump", "window", "bump", "smooth", "periodic", "memory", …; patterns of a family share its prior.
    pub family: &'static str,
    /// The range of the coordinate that it touches.
    pub range: [f64; 2],
    /// In words, for people.
    pub note: String,
    /// Change of the signal for a unit amplitude, one a direction.
    pub columns: Vec<Pattern>,
}

/// All rivals that these rows allow. `level` is the model's expectation, `order` the rows in time order.
pub fn rivals(rows: &[Row], level: &[f64], order: &[usize]) -> Vec<Rival> {
    let mut build = Builder {
        rows,
        level: level.into(),
        found: Vec::new(),
    };
    if rows.iter().any(|row| row.source == Source::Reading) {
        time::time(&mut build, order);
        time::memory(&mut build, order);
        time::visits(&mut build, order);
        direction::gamma(&mut build);
        direction::azimuth(&mut build);
        distance::distance(&mut build, Source::Reading);
        distance::travel(&mut build);
        meter::range(&mut build);
        meter::ambient(&mut build, order);
        meter::signal_level(&mut build, Source::Reading);
    }
    if rows.iter().any(|row| row.source == Source::Bin) {
        maps::maps(&mut build);
        distance::distance(&mut build, Source::Bin);
        meter::signal_level(&mut build, Source::Bin);
    }
    if rows.iter().any(|row| row.source == Source::Sample) {
        wavelength::wavelength(&mut build);
    }
    build.found
}

/// Collects patterns; knows how to turn a function of a row into a column.
struct Builder<'a> {
    rows: &'a [Row],
    level: Arc<[f64]>,
    found: Vec<Rival>,
}

impl Builder<'_> {
    /// The pattern `law(row)`, NaN read as 0, acting on rows of `source`.
    fn column(&self, source: Source, acts: Acts, law: impl Fn(usize, &Row) -> f64 + Send + Sync + 'static) -> Pattern {
        Pattern::new(source, acts, &self.level, law)
    }

    /// As [`column`](Self::column), for a law of the expected signal.
    fn of_level(&self, source: Source, acts: Acts, law: impl Fn(f64, &Row) -> f64 + Send + Sync + 'static) -> Pattern {
        let level = Arc::clone(&self.level);
        self.column(source, acts, move |i, row| law(level[i], row))
    }

    fn add(
        &mut self,
        coordinate: Coordinate,
        family: &'static str,
        range: [f64; 2],
        note: impl Into<String>,
        columns: Vec<Pattern>,
    ) {
        let nothing = |column: &Pattern| column.values(self.rows).all(|value| value == 0.0);
        if columns.iter().all(nothing) {
            return;
        }
        // An end that is nought but for rounding is nought.
        let span = (range[1] - range[0]).abs();
        let tidy = |end: f64| if end.abs() < 1e-9 * span { 0.0 } else { end };
        self.found.push(Rival {
            coordinate,
            family,
            range: range.map(tidy),
            note: note.into(),
            columns,
        });
    }

    /// Distinct finite values of a coordinate over rows of `source` that carry signal, rising.
    fn distinct(&self, source: Source, coordinate: Coordinate) -> Vec<f64> {
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

fn word(acts: Acts) -> &'static str {
    match acts {
        Acts::Relative => "a relative change",
        Acts::Light | Acts::Everywhere => "an added signal",
    }
}
