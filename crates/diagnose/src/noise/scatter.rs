//! Whether all readings scatter alike: from block to block, and along a coordinate.

use super::finding::{Finding, Kind, Strongest, digits};
use super::groups::{Group, groups};
use super::limits::{SCALE, SQUARE_CLIP};
use super::series::Series;
use super::statistic::Test;
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

/// Blocks, half-planes, angles, ranges, stretches of time, maps (Levene 1960, with squares and permutations).
pub(super) struct Blocks {
    groups: Vec<Group>,
}

impl Blocks {
    pub(super) fn new(series: &Series<'_>) -> Option<Self> {
        let groups = groups(series);
        (groups.len() > 1).then_some(Self { groups })
    }

    fn look(&self, values: &[f64], wanted: impl Fn(&Group) -> bool) -> Strongest {
        let (squares, mean, _) = squares(values);
        let n = values.len() as f64;
        let mut best = Strongest::default();
        for (place, group) in self.groups.iter().enumerate().filter(|(_, group)| wanted(group)) {
            let k = group.members.len() as f64;
            let sum: f64 = group.members.iter().map(|&i| squares[i as usize]).sum();
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
        let numbers = group.members.iter().map(|&i| series.index[i as usize]);
        let range = numbers.fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], at| {
            [low.min(at), high.max(at)]
        });
        let more: f64 = group
            .members
            .iter()
            .map(|&i| series.plain[i as usize].powi(2) - series.expected)
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
        let numbers = [series.index[0], series.index[series.len() - 1]];
        Finding::new(Kind::Trend, Coordinate::Noise, numbers, strongest, note)
    }
}
