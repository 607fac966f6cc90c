//! The shapes of patterns: how much a row has of one, by its place along a coordinate or its distance from a place.

use std::sync::Arc;

/// How much a row has of a pattern, by its place.
#[derive(Debug, Clone, Copy)]
pub(crate) enum Shape {
    /// A power of the place.
    Power(i32),
    /// 1 beyond a place.
    Beyond(f64),
    /// Rises from a place on.
    Rising(f64),
    /// 1 between two places and on both.
    Between(f64, f64),
    /// Rises and falls around a place, with a standard deviation.
    Bump(f64, f64),
    /// Falls away from a place, to 1/e over a length.
    Fading(f64, f64),
    /// A wave of so many radians a unit.
    Cosine(f64),
    /// The same, a quarter of a period later.
    Sine(f64),
    /// 1 at every n-th whole number, from which on.
    Every(usize, usize),
}

impl Shape {
    /// The shape along a coordinate, which is `x` at every row.
    pub(super) fn along(self, x: &Values) -> Direction {
        Direction {
            shape: self,
            along: Along::Line,
            x: Arc::clone(x),
            y: None,
            times: None,
        }
    }

    /// The shape over the distance from a point of the plane.
    pub(super) fn around(self, point: [f64; 2], [x, y]: [&Values; 2]) -> Direction {
        Direction {
            along: Along::Point(point),
            y: Some(Arc::clone(y)),
            ..self.along(x)
        }
    }

    /// Its weight at a place; no number where the place is none, or 0.
    pub(crate) fn weight(self, at: f64) -> f64 {
        match self {
            Self::Power(power) => at.powi(power),
            Self::Beyond(from) => f64::from(at > from),
            Self::Rising(from) => (at - from).max(0.0),
            Self::Between(from, to) => f64::from(from <= at && at <= to),
            Self::Bump(centre, width) => (-0.5 * ((at - centre) / width).powi(2)).exp(),
            Self::Fading(from, length) => (-(at - from).abs() / length).exp(),
            Self::Cosine(turn) => (turn * at).cos(),
            Self::Sine(turn) => (turn * at).sin(),
            Self::Every(n, phase) => f64::from((at.round() as i64).rem_euclid(n as i64) == phase as i64),
        }
    }
}

/// What a shape counts as the place of a row that is at `[x, y, z]`.
#[derive(Debug, Clone, Copy)]
pub(crate) enum Along {
    /// x alone.
    Line,
    /// The distance from a point of the plane.
    Point([f64; 2]),
    /// The angle, in degrees, from a direction of unit length.
    Direction([f64; 3]),
    /// The angle, in degrees, from the great circle around a pole of unit length.
    Circle([f64; 3]),
}

impl Along {
    pub(crate) fn place(self, at: [f64; 3]) -> f64 {
        let cosine = |towards: [f64; 3]| -> f64 {
            let product: f64 = at.iter().zip(&towards).map(|(a, b)| a * b).sum();
            product.clamp(-1.0, 1.0)
        };
        match self {
            Self::Line => at[0],
            Self::Point([x, y]) => (at[0] - x).hypot(at[1] - y),
            Self::Direction(towards) => cosine(towards).acos().to_degrees(),
            Self::Circle(pole) => cosine(pole).asin().to_degrees(),
        }
    }
}

/// One number of every row.
pub(crate) type Values = Arc<[f64]>;

/// A shape over the rows of a table: what they change by for a unit of one amplitude.
///
/// Thousands of columns of 10⁵ readings are gigabytes; the few coordinates that they share are nothing.
#[derive(Debug, Clone)]
pub(crate) struct Direction {
    shape: Shape,
    along: Along,
    x: Values,
    y: Option<Values>,
    times: Option<Values>,
}

impl Direction {
    /// Values of every row as they are.
    pub(super) fn of(values: Values) -> Self {
        Shape::Power(1).along(&values)
    }

    /// The same, times a factor of every row.
    pub(super) fn times(self, factor: &Values) -> Self {
        Self {
            times: Some(Arc::clone(factor)),
            ..self
        }
    }

    /// Its weight at row number `i`.
    pub(crate) fn weight(&self, i: usize) -> f64 {
        let y = self.y.as_ref().map_or(0.0, |y| y[i]);
        self.shape.weight(self.along.place([self.x[i], y, 0.0])) * self.times.as_ref().map_or(1.0, |times| times[i])
    }
}

impl From<Direction> for Vec<Direction> {
    fn from(one: Direction) -> Self {
        vec![one]
    }
}
