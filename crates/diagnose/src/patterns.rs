//! Patterns without a name: the one list of what readings, bins and samples may have in common, whatever makes it.
//!
//! Two ask for them, each with a statistic of its own. The search ([`crate::alternatives`]) fits them to what the model
//! leaves, as columns that multiply the expected signal or are added to it: r and a below. The test of the noise
//! ([`crate::noise`]) compares their sums over what a fit leaves with those of the same residuals in another order; it
//! looks finer, at thousands of places, each of which would take a share of the names' prior.
//!
//! | shape | along | the search | the test of the noise |
//! |---|---|---|---|
//! | from one place on | time | r a: 39 | |
//! | | γ; C, wavelength; angle of incidence | r: 16; each plane, 11; 5 | |
//! | | temperature; light | r: 3; 7 | |
//! | | x, y of a sensor | r a: up to 47 | |
//! | between two places | time, number | r a: eighths to 32nds, half overlapping | runs of 3 to 48 |
//! | | C | r: 1 to 4 planes, whole and in halves | |
//! | | one range, distance or map | r a: each | |
//! | | x, y | r a: bands of 1, 2, 4 | |
//! | rises and falls | time | r a: as above | |
//! | | γ; γ of both sides | r a, r: 0.7, 1.4, 3 steps wide | |
//! | | directions on the sphere | | 3°, 6°, 12° wide |
//! | | distance from a great circle | | 2.5°, 5° wide |
//! | | wavelength; angle of incidence | r a: 2 widths; r: 5 | |
//! | | plane of a sensor | r: 7², 5² spots; r a: 6 rings | 12² of 3 widths |
//! | falls from a place | edges, corners; weak light; a pause | r a: 2 lengths, 1; r: 3; r: 3 | |
//! | every n-th | reading; visit | | n to 24; to 6 |
//! | | column, row | r a: n = 2 | n to 8 |
//! | a period | time, number | a: up to 10 in the record | all |
//! | | γ; C | r: 6° to 90°; 60° to 360° | |
//! | | x, y | r a: up to 12 | |
//! | | number in a visit; in a stretch | | all, each with its own phase; period |
//! | smooth | time, wavelength | r a: cosines | trend of the scatter |
//! | | γ, C, distance, temperature, light | r (some a): powers, logarithms | trend of the scatter |
//! | | plane of a sensor | r a: polynomials | trend of the scatter |
//! | a ramp | number in a visit | r a | |
//! | what was before | light, temperature, map | r a: lags, averages | |
//! | parts of the record | see `parts` | | their means, their scatter |
//!
//! A pattern is added where its coordinate is: `time` (and number), `direction`, `distance`, `meter`, `maps`,
//! `wavelength`; its shape, if it is new, in `shape`.

mod direction;
mod distance;
mod maps;
mod meter;
pub(crate) mod parts;
mod place;
mod shape;
mod time;
mod wavelength;

pub(crate) use place::{Grid, Place};
pub(crate) use shape::{Direction, Shape, Values};

use crate::noise::series::Series;
use crate::table::{Coordinate, Light, ObservationKind, Row};

/// Whether a pattern multiplies the expected signal or adds to it, and on which records.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Acts {
    /// × expected signal.
    Relative,
    /// + on every record that sees the room (not capped).
    Light,
    /// + on every record.
    Everywhere,
}

/// A pattern that the search tries.
#[derive(Debug)]
pub(crate) struct Pattern {
    /// Of which rows.
    pub source: ObservationKind,
    pub acts: Acts,
    pub coordinate: Coordinate,
    /// Patterns of a family share its prior.
    pub family: &'static str,
    /// The range of the coordinate that it touches.
    pub range: [f64; 2],
    /// In words, for people.
    pub note: String,
    pub directions: Vec<Direction>,
}

/// All patterns that these rows allow. `level` is the model's expectation, `order` the rows in time order.
pub(crate) fn patterns(rows: &[Row], level: &[f64], order: &[usize]) -> Vec<Pattern> {
    let mut list = List {
        rows,
        level,
        order,
        found: Vec::new(),
    };
    let has = |source: ObservationKind| rows.iter().any(|row| row.source == source);
    if has(ObservationKind::Reading) {
        time::time(&mut list);
        time::memory(&mut list);
        time::visits(&mut list);
        direction::gamma(&mut list);
        direction::azimuth(&mut list);
        distance::distance(&mut list, ObservationKind::Reading);
        distance::travel(&mut list);
        meter::range(&mut list);
        meter::ambient(&mut list);
        meter::signal_level(&mut list, ObservationKind::Reading);
    }
    if has(ObservationKind::Bin) {
        maps::maps(&mut list);
        distance::distance(&mut list, ObservationKind::Bin);
        meter::signal_level(&mut list, ObservationKind::Bin);
    }
    if has(ObservationKind::Sample) {
        wavelength::wavelength(&mut list);
    }
    list.found
}

/// Grids of places of one kind among the rows of a series.
pub(crate) type Grids = for<'a> fn(&'a Series<'a>) -> Vec<Grid<'a>>;
/// What the test of the noise looks for among readings: each kind is a test of its own.
pub(crate) const AMONG_READINGS: [Grids; 4] = [time::every_reading, time::every_visit, time::runs, direction::patches];
/// The same, of errors relative to the light.
pub(crate) const IN_THE_LIGHT: Grids = direction::circles;
/// The same among bins.
pub(crate) const AMONG_BINS: [Grids; 2] = [maps::lines, maps::spots];

/// Collects patterns.
struct List<'a> {
    rows: &'a [Row],
    level: &'a [f64],
    order: &'a [usize],
    found: Vec<Pattern>,
}

impl List<'_> {
    fn on(&mut self, source: ObservationKind, coordinate: Coordinate) -> On<'_> {
        On {
            found: &mut self.found,
            source,
            coordinate,
        }
    }

    /// A number of every row.
    fn values(&self, of: impl Fn(&Row) -> f64) -> Values {
        self.rows.iter().map(of).collect()
    }

    /// 1 on every lit row.
    fn lit(&self) -> Values {
        self.values(|row| f64::from(row.light == Light::Lit))
    }

    /// Distinct finite values of a coordinate over rows of `source` that carry signal, rising, and the ends of them;
    /// none where they are fewer than `least`.
    fn distinct(&self, source: ObservationKind, coordinate: Coordinate, least: usize) -> Option<(Vec<f64>, [f64; 2])> {
        let signal = |(row, _): &(&Row, &f64)| row.source == source && row.light == Light::Lit;
        let rows = self.rows.iter().zip(self.level).filter(signal);
        let mut values: Vec<f64> = rows
            .map(|(row, &level)| row.coordinate(coordinate, level))
            .filter(|value| value.is_finite())
            .collect();
        values.sort_by(f64::total_cmp);
        values.dedup();
        let ends = [*values.first()?, *values.last()?];
        (values.len() >= least).then_some((values, ends))
    }
}

/// Collects patterns of the rows of one source along one coordinate.
struct On<'l> {
    found: &'l mut Vec<Pattern>,
    source: ObservationKind,
    coordinate: Coordinate,
}

impl On<'_> {
    /// A relative change or an added signal, and where it is.
    fn one(
        &mut self,
        acts: Acts,
        family: &'static str,
        range: [f64; 2],
        place: &str,
        directions: impl Into<Vec<Direction>>,
    ) {
        let what = match acts {
            Acts::Relative => "a relative change",
            Acts::Light | Acts::Everywhere => "an added signal",
        };
        self.add(acts, family, range, &format!("{what} {place}"), directions);
    }

    /// A pattern with words of its own.
    fn add(
        &mut self,
        acts: Acts,
        family: &'static str,
        range: [f64; 2],
        note: &str,
        directions: impl Into<Vec<Direction>>,
    ) {
        self.found.push(Pattern {
            source: self.source,
            acts,
            coordinate: self.coordinate,
            family,
            range,
            note: note.to_owned(),
            directions: directions.into(),
        });
    }
}

/// Cosine and sine of so many radians a unit.
fn waves(turn: f64, x: &Values) -> [Direction; 2] {
    [Shape::Cosine(turn), Shape::Sine(turn)].map(|shape| shape.along(x))
}

/// The smoothest so many cosines over a share from 0 to 1; a constant has a name.
fn cosines(count: u32, share: &Values) -> Vec<Direction> {
    let cosine = |k: u32| Shape::Cosine(std::f64::consts::PI * f64::from(k)).along(share);
    (1..=count).map(cosine).collect()
}
