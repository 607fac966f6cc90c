//! Whether all readings scatter alike: from block to block, and along a coordinate.

use super::finding::{Finding, Kind, Strongest, digits};
use super::limits::{SCALE, SQUARE_CLIP};
use super::series::Series;
use super::statistic::Test;
use crate::patterns::parts;
use crate::table::{Coordinate, ObservationKind};

/// Squares, outliers held, with their mean and variance.
fn squares(values: &[f64]) -> (Vec<f64>, f64, f64) {
    let n = values.len().max(1) as f64;
    let held = |v: &f64| v.clamp(-SQUARE_CLIP, SQUARE_CLIP).powi(2);
    let squares: Vec<f64> = values.iter().map(held).collect();
    let mean = squares.iter().sum::<f64>() / n;
    let variance = squares.iter().map(|square| (square - mean).powi(2)).sum::<f64>() / n;
    (squares, mean.max(f64::MIN_POSITIVE), variance.max(f64::MIN_POSITIVE))
}

/// Rows that belong together.
struct Group {
    members: Vec<usize>,
    coordinate: Coordinate,
    range: [f64; 2],
    name: &'static str,
    /// Whether it scatters more than the others by more than what counts as noise, and how much more than the others.
    apart: Option<f64>,
}

/// Groups of fewer rows say little.
const FEWEST: usize = 6;

impl Group {
    /// None where the rows are too few or nearly all. `squares` is the sum of the squared residuals of all rows.
    fn new(
        series: &Series<'_>,
        squares: f64,
        coordinate: Coordinate,
        name: &'static str,
        members: Vec<usize>,
    ) -> Option<Self> {
        let n = series.len();
        if members.len() < FEWEST || 10 * members.len() > 7 * n {
            return None;
        }
        let at = |i: usize| match coordinate {
            Coordinate::Index => series.index[i],
            _ => series.rows[i].coordinate(coordinate, series.level[i]),
        };
        let count = members.len() as f64;
        let own = members.iter().map(|&i| series.plain[i].powi(2)).sum::<f64>();
        let others = ((squares - own).max(0.0) / (n as f64 - count)).sqrt();
        let own = (own / count).sqrt();
        Some(Self {
            coordinate,
            range: span(members.iter().map(|&i| at(i))),
            name,
            apart: (own > SCALE * others).then(|| own / others.max(f64::MIN_POSITIVE)),
            members,
        })
    }
}

/// The lowest and the highest of some values.
fn span(values: impl Iterator<Item = f64>) -> [f64; 2] {
    values.fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], at| {
        [low.min(at), high.max(at)]
    })
}

/// Blocks, half-planes, angles, ranges, stretches of time, maps (Levene 1960, with squares and permutations).
pub(super) struct Blocks {
    groups: Vec<Group>,
}

impl Blocks {
    pub(super) fn new(series: &Series<'_>) -> Option<Self> {
        let squares = series.plain.iter().map(|value| value * value).sum();
        let mut groups = Vec::new();
        for (coordinate, name, parts) in parts::apart(series) {
            let group = |members| Group::new(series, squares, coordinate, name, members);
            groups.extend(parts.into_iter().filter_map(group));
        }
        (groups.len() > 1).then_some(Self { groups })
    }

    fn look(&self, values: &[f64], wanted: impl Fn(&Group) -> bool) -> Strongest {
        let (squares, mean, _) = squares(values);
        let n = values.len() as f64;
        let mut best = Strongest::default();
        for (place, group) in self.groups.iter().enumerate().filter(|(_, group)| wanted(group)) {
            let k = group.members.len() as f64;
            let sum: f64 = group.members.iter().map(|&i| squares[i]).sum();
            // Likelihood ratio of two variances: it treats few and many readings alike, which squared deviations do
            // not.
            let (own, others) = (sum / k, (n * mean - sum) / (n - k));
            if own > others && others > 0.0 {
                let ratio = 0.5 * (n * mean.ln() - k * own.ln() - (n - k) * others.ln());
                best.raise(ratio, place);
            }
        }
        best
    }
}

impl Test for Blocks {
    fn strongest(&self, values: &[f64]) -> Strongest {
        self.look(values, |_| true)
    }

    fn observed(&self, values: &[f64]) -> Strongest {
        self.look(values, |group| group.apart.is_some())
    }

    fn finding(&self, strongest: Strongest, series: &Series<'_>) -> Finding {
        let group = &self.groups[strongest.place];
        let note = format!(
            "the readings of {} ({} {} … {}) scatter {} times as much as the others",
            group.name,
            group.coordinate.name(),
            digits(group.range[0]),
            digits(group.range[1]),
            digits(group.apart.unwrap_or(1.0))
        );
        let range = span(group.members.iter().map(|&i| series.index[i]));
        let more: f64 = group
            .members
            .iter()
            .map(|&i| series.plain[i].powi(2) - series.expected)
            .sum();
        Finding::new(Kind::Blocks, Coordinate::Noise, range, strongest, note).explaining(more.max(0.0))
    }
}

/// Scatter that grows along a coordinate (Breusch and Pagan 1979, with permutations).
pub(super) struct Trends {
    along: Vec<(Coordinate, Vec<f64>, [f64; 2])>,
    /// Ratio of scatter of the upper third to the rest, by coordinate and sign.
    apart: Vec<[f64; 2]>,
}

impl Trends {
    pub(super) fn new(series: &Series<'_>) -> Option<Self> {
        let n = series.len();
        let coordinates: &[Coordinate] = match series.source {
            ObservationKind::Reading => &[
                Coordinate::GammaDeg,
                Coordinate::Level,
                Coordinate::TimeS,
                Coordinate::CDeg,
            ],
            _ => &[
                Coordinate::RadiusMm,
                Coordinate::Level,
                Coordinate::XMm,
                Coordinate::YMm,
            ],
        };
        let mut trends = Self {
            along: Vec::new(),
            apart: Vec::new(),
        };
        for &coordinate in coordinates {
            let at = |i: usize| {
                let value = series.rows[i].coordinate(coordinate, series.level[i]);
                if coordinate == Coordinate::GammaDeg {
                    value.abs()
                } else {
                    value
                }
            };
            let mut order: Vec<usize> = (0..n).filter(|&i| at(i).is_finite()).collect();
            order.sort_by(|&a, &b| at(a).total_cmp(&at(b)));
            let (Some(&low), Some(&high)) = (order.first(), order.last()) else {
                continue;
            };
            let range = [at(low), at(high)];
            if order.len() < n / 2 || range[0] >= range[1] {
                continue;
            }
            // Equal values have equal ranks.
            let mut rank = vec![0.0; n];
            let mut start = 0;
            while start < order.len() {
                let end = order[start..].partition_point(|&i| at(i) <= at(order[start])) + start;
                for &i in &order[start..end] {
                    rank[i] = 0.5 * (start + end) as f64 / order.len() as f64 - 0.5;
                }
                start = end;
            }
            let mean = order.iter().map(|&i| rank[i]).sum::<f64>() / order.len() as f64;
            for &i in &order {
                rank[i] -= mean;
            }
            let length = rank.iter().map(|r| r * r).sum::<f64>().sqrt();
            if length <= 0.0 {
                continue;
            }
            for r in &mut rank {
                *r /= length;
            }
            let third = order.len() / 3;
            let (few, many) = (&order[..third], &order[third..]);
            let (most, least) = (&order[order.len() - third..], &order[..order.len() - third]);
            let ratio = |own: &[usize], others: &[usize]| {
                series.scatter(own.iter().copied()) / series.scatter(others.iter().copied()).max(f64::MIN_POSITIVE)
            };
            trends.apart.push([ratio(most, least), ratio(few, many)]);
            trends.along.push((coordinate, rank, range));
        }
        (!trends.along.is_empty()).then_some(trends)
    }

    fn look(&self, values: &[f64], wanted: impl Fn(usize, usize) -> bool) -> Strongest {
        let (squares, mean, variance) = squares(values);
        let mut best = Strongest::default();
        for (k, (_, rank, _)) in self.along.iter().enumerate() {
            let sum: f64 = rank.iter().zip(&squares).map(|(r, square)| r * (square - mean)).sum();
            let z = sum / variance.sqrt();
            let falls = usize::from(z < 0.0);
            if wanted(k, falls) {
                best.raise(0.5 * z * z, 2 * k + falls);
            }
        }
        best
    }
}

impl Test for Trends {
    fn strongest(&self, values: &[f64]) -> Strongest {
        self.look(values, |_, _| true)
    }

    fn observed(&self, values: &[f64]) -> Strongest {
        self.look(values, |k, falls| self.apart[k][falls] > SCALE)
    }

    fn finding(&self, strongest: Strongest, series: &Series<'_>) -> Finding {
        let (k, falls) = (strongest.place / 2, strongest.place % 2);
        let (coordinate, _, range) = &self.along[k];
        let note = format!(
            "the scatter {} with {} ({} … {}): {} times as much in its {} third as in the rest",
            if falls == 0 { "grows" } else { "falls" },
            coordinate.name(),
            digits(range[0]),
            digits(range[1]),
            digits(self.apart[k][falls]),
            if falls == 0 { "upper" } else { "lower" }
        );
        Finding::new(Kind::Trend, Coordinate::Noise, series.numbers(), strongest, note)
    }
}
