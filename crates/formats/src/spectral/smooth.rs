//! Values that leave a curve which is smooth around them: swapped, mistyped, a lost sign or decimal point, a hot pixel.
//!
//! Every point is compared with the cubic through its two neighbours on either side, and where two values may be swapped also
//! with the line through the two beside it; what is usual for the sixteen points to the left and to the right is the
//! noise. A lamp with spectral lines has many points off that cubic, and noise hides small swaps: no more is claimed than
//! at most two findings of a kind in a file that is otherwise smooth.

use super::points::Point;
use crate::finding::{Finding, Findings};

/// Departures below this part of the values around are not looked at.
const SMALLEST: f64 = 0.004;
/// How far off, in units of what is usual around.
const SPIKE: f64 = 14.0;
/// How much likelier the values must be once two neighbours, or two values apart, have changed places (a logarithm, under a
/// Cauchy distribution), and how far above the third such place of the file.
const GAIN: [f64; 2] = [14.0, 20.0];
const ABOVE_THIRD: f64 = 3.0;
/// What the misfits of a line and of a cubic count; they are not independent.
const WEIGHT: [f64; 2] = [1.0, 0.5];
/// Points that are tried as partners of a swap far apart.
const CANDIDATES: usize = 16;
/// Findings of one kind beyond which the file is rough, not damaged.
const MOST: usize = 2;
/// Points on either side that all have the other sign.
const ALONE: usize = 20;
/// A lone sign among fewer neighbours leaves the curve by this, in units of what is usual, and by no more than the second with
/// the other sign.
const SIGN: (f64, f64) = (8.0, 2.0);
/// Points on either side that tell the level.
const LEVEL: usize = 4;
/// Points on either side that tell the noise.
const AROUND: usize = 16;

/// Looks at the first series.
pub(super) fn check(points: &[Point], findings: &mut Findings) {
    let curve = Curve::of(points);
    let Some(curve) = curve else { return };
    let swaps = curve.swaps();
    for &(i, j) in &swaps {
        findings.push(
            Finding::warning(
                "spectrum-swapped",
                format!(
                    "the values {} and {} (at {} nm) leave a smooth curve, and fit it better exchanged",
                    curve.value[i], curve.value[j], points[j].x
                ),
            )
            .at(points[i].line, points[i].column)
            .raw(&format!("{}", curve.value[i]))
            .assumed("as written")
            .fix("check whether two numbers were swapped"),
        );
    }
    let signs = curve.signs();
    for &i in signs.iter().filter(|_| signs.len() <= MOST) {
        findings.push(
            Finding::warning(
                "spectrum-sign",
                format!(
                    "the value {} has another sign than all around it, and without it would fit them",
                    curve.value[i]
                ),
            )
            .at(points[i].line, points[i].column)
            .raw(&format!("{}", curve.value[i]))
            .assumed("as written")
            .fix("check whether a sign was gained or lost"),
        );
    }
    let told = |i: usize| signs.contains(&i) || swaps.iter().any(|&(a, b)| i.abs_diff(a) <= 2 || i.abs_diff(b) <= 2);
    let spikes: Vec<usize> = curve.spikes().into_iter().filter(|&i| !told(i)).collect();
    for &i in spikes.iter().filter(|_| spikes.len() <= MOST) {
        findings.push(
            Finding::warning(
                "spectrum-spike",
                format!("the value {} leaves the smooth curve of its neighbours", curve.value[i]),
            )
            .at(points[i].line, points[i].column)
            .raw(&format!("{}", curve.value[i]))
            .assumed("as written")
            .fix("check for a mistyped or swapped number, or a single hot pixel"),
        );
    }
}

struct Curve {
    value: Vec<f64>,
    /// Weights of the four neighbours; zero at the two points of either end.
    weight: Vec<[f64; 4]>,
    /// Weights of the two neighbours; zero at either end.
    line: Vec<[f64; 2]>,
    /// Distance from the cubic through the neighbours.
    off: Vec<f64>,
    /// Distance from the line.
    bend: Vec<f64>,
    /// Two thirds of the distances around each point are below this.
    usual: Vec<f64>,
    /// The largest value within a few points of each.
    level: Vec<f64>,
    /// The smallest difference between two values: what rounding leaves.
    quantum: f64,
    largest: f64,
}

impl Curve {
    fn of(points: &[Point]) -> Option<Self> {
        let n = points.len();
        if n < 16 {
            return None;
        }
        let value: Vec<f64> = points
            .iter()
            .map(|p| p.value.first().copied().flatten().unwrap_or(0.0))
            .collect();
        let mut weight = vec![[0.0; 4]; n];
        for (i, weight) in weight.iter_mut().enumerate().take(n - 2).skip(2) {
            let at = [i - 2, i - 1, i + 1, i + 2];
            for (k, &a) in at.iter().enumerate() {
                weight[k] = at
                    .iter()
                    .filter(|&&b| b != a)
                    .map(|&b| (points[i].x - points[b].x) / (points[a].x - points[b].x))
                    .product();
            }
        }
        let mut line = vec![[0.0; 2]; n];
        for (i, line) in line.iter_mut().enumerate().take(n - 1).skip(1) {
            let right = (points[i].x - points[i - 1].x) / (points[i + 1].x - points[i - 1].x);
            *line = [1.0 - right, right];
        }
        let largest = value.iter().fold(0.0f64, |m, v| m.max(v.abs()));
        let level = (0..n)
            .map(|i| {
                let around = value[i.saturating_sub(LEVEL)..(i + LEVEL + 1).min(n)].iter();
                around.fold(0.0f64, |m, v| m.max(v.abs()))
            })
            .collect();
        let mut sorted = value.clone();
        sorted.sort_by(f64::total_cmp);
        let apart = sorted.windows(2).map(|pair| pair[1] - pair[0]);
        let quantum = apart.filter(|&d| d > 1e-12 * largest).fold(f64::INFINITY, f64::min);
        let mut curve = Self {
            value,
            weight,
            line,
            off: vec![0.0; n],
            bend: vec![0.0; n],
            usual: vec![0.0; n],
            level,
            quantum: if quantum.is_finite() { quantum } else { 0.0 },
            largest,
        };
        curve.off = (0..n).map(|i| curve.distance(&curve.value, i).abs()).collect();
        curve.usual = (0..n).map(|i| curve.usual_around(&curve.off, i, i)).collect();
        curve.bend = (0..n).map(|i| curve.bent(&curve.value, i).abs()).collect();
        (largest > 0.0 && curve.off.iter().all(|o| o.is_finite())).then_some(curve)
    }

    fn inner(&self) -> std::ops::Range<usize> {
        2..self.value.len() - 2
    }

    fn distance(&self, value: &[f64], i: usize) -> f64 {
        if !self.inner().contains(&i) {
            return 0.0;
        }
        let w = &self.weight[i];
        value[i] - w[0] * value[i - 2] - w[1] * value[i - 1] - w[2] * value[i + 1] - w[3] * value[i + 2]
    }

    fn bent(&self, value: &[f64], i: usize) -> f64 {
        if i == 0 || i + 1 >= value.len() {
            return 0.0;
        }
        let [left, right] = self.line[i];
        value[i] - left * value[i - 1] - right * value[i + 1]
    }

    fn usual_around(&self, off: &[f64], from: usize, to: usize) -> f64 {
        let inner = self.inner();
        let mut around: Vec<f64> = (from.saturating_sub(AROUND).max(inner.start)..(to + AROUND + 1).min(inner.end))
            .filter(|&k| k + 2 < from || k > to + 2)
            .map(|k| off[k])
            .collect();
        around.sort_by(f64::total_cmp);
        around
            .get(around.len() * 2 / 3)
            .map_or(f64::INFINITY, |usual| usual + self.quantum)
    }

    /// Points of the other sign than everything around, and of a size that would fit with theirs.
    fn signs(&self) -> Vec<usize> {
        let n = self.value.len();
        (0..n)
            .filter(|&i| {
                let v = self.value[i];
                let around = (i.saturating_sub(ALONE)..(i + ALONE + 1).min(n)).filter(|&k| k != i);
                let (mut count, mut other) = (0, true);
                for k in around {
                    count += 1;
                    other &= self.value[k] * v < 0.0;
                }
                let sizes = |reach: usize| {
                    let near = (i.saturating_sub(reach)..(i + reach + 1).min(n)).filter(|&k| k != i);
                    let sizes = near.map(|k| self.value[k].abs());
                    sizes.fold((f64::INFINITY, 0.0_f64), |(low, high), size| {
                        (low.min(size), high.max(size))
                    })
                };
                let ((low, high), (least, most)) = (sizes(1), sizes(LEVEL));
                let alike = (0.5 * low..=2.0 * high).contains(&v.abs());
                // As large as the two beside it, where the values around are of one size: noise about zero is not.
                let alone = other && least > 0.1 * most;
                2 * count > ALONE && alike && (alone || self.lone_sign(i))
            })
            .collect()
    }

    /// The few values beside all have the other sign, and with it this one is on their curve.
    fn lone_sign(&self, i: usize) -> bool {
        if !self.inner().contains(&i) {
            return false;
        }
        let v = self.value[i];
        let near = i.saturating_sub(LEVEL)..(i + LEVEL + 1).min(self.value.len());
        let other = near.filter(|&k| k != i).all(|k| self.value[k] * v < 0.0);
        let flipped = (self.distance(&self.value, i) - 2.0 * v).abs();
        other && self.off[i] > SIGN.0 * self.usual[i] && flipped < SIGN.1 * self.usual[i]
    }

    /// Points off the cubic whose neighbours are on it once the point is put there.
    fn spikes(&self) -> Vec<usize> {
        let inner = self.inner();
        let mut value = self.value.clone();
        inner
            .clone()
            .filter(|&i| {
                let off = self.off[i];
                let around = i.saturating_sub(2).max(inner.start)..(i + 3).min(inner.end);
                if off <= SMALLEST * self.level[i]
                    || off <= SPIKE * self.usual[i]
                    || around.clone().any(|k| self.off[k] > off)
                {
                    return false;
                }
                let kept = value[i];
                value[i] -= self.distance(&self.value, i);
                let left = around
                    .filter(|&k| k != i)
                    .map(|k| self.distance(&value, k).abs())
                    .fold(0.0, f64::max);
                value[i] = kept;
                left <= (4.0 * self.usual[i]).max(0.1 * off)
            })
            .collect()
    }

    /// Pairs that fit the curve better once they change places: neighbours, or any two of the points that are farthest off.
    fn swaps(&self) -> Vec<(usize, usize)> {
        let inner = self.inner();
        let floor = 1e-3 * SMALLEST * self.largest;
        let mut far: Vec<usize> = inner.clone().collect();
        far.sort_by(|&a, &b| {
            let ratio = |i: usize| self.off[i] / self.usual[i].max(floor);
            ratio(b).total_cmp(&ratio(a))
        });
        far.truncate(CANDIDATES);
        far.sort_unstable();
        let mut value = self.value.clone();
        let mut found: Vec<(usize, usize, f64)> = Vec::new();
        let apart = far.iter().flat_map(|&i| far.iter().map(move |&j| (i, j)));
        for (i, j) in (0..value.len() - 1)
            .map(|i| (i, i + 1))
            .chain(apart.filter(|&(i, j)| j > i + 1))
        {
            if (value[i] - value[j]).abs() < SMALLEST * self.level[i].max(self.level[j]) {
                continue;
            }
            value.swap(i, j);
            let gain = self.gain(&value, i, j);
            value.swap(i, j);
            found.extend((gain > 1.0).then_some((i, j, gain)));
        }
        // Of pairs that share a neighbourhood the better one.
        found.sort_by(|a, b| b.2.total_cmp(&a.2));
        let mut places: Vec<(usize, usize, f64)> = Vec::new();
        for (i, j, gain) in found {
            let apart = |a: usize| i.abs_diff(a) > 2 && j.abs_diff(a) > 2;
            if places.iter().all(|&(a, b, _)| apart(a) && apart(b)) {
                places.push((i, j, gain));
            }
        }
        let third = places.get(MOST).map_or(0.0, |place| place.2 + ABOVE_THIRD);
        let told = |&(i, j, gain): &(usize, usize, f64)| gain > GAIN[usize::from(j > i + 1)].max(third);
        let mut kept: Vec<(usize, usize)> = places.into_iter().filter(told).map(|(i, j, _)| (i, j)).collect();
        kept.sort_unstable();
        kept
    }

    /// How much likelier the values become with `exchanged` ones at `i` and `j`.
    fn gain(&self, exchanged: &[f64], i: usize, j: usize) -> f64 {
        let n = self.value.len();
        let mut reached: Vec<usize> = (i.saturating_sub(2)..(i + 3).min(n))
            .chain(j.saturating_sub(2)..(j + 3).min(n))
            .collect();
        reached.sort_unstable();
        reached.dedup();
        // The cheaper question first: most exchanges make the curve rougher.
        let rough = |value: &[f64]| reached.iter().map(|&k| self.bent(value, k).abs()).sum::<f64>();
        if rough(exchanged) >= rough(&self.value) {
            return 0.0;
        }
        let near = j - i <= 4;
        let mut gain = 0.0;
        for (order, off) in [&self.bend, &self.off].into_iter().enumerate() {
            let usual = |a: usize, b: usize| self.usual_around(off, a, b) + 1e-4 * SMALLEST * self.largest;
            let [left, right] = if near {
                [usual(i, j); 2]
            } else {
                [usual(i, i), usual(j, j)]
            };
            for &k in &reached {
                let scale = if k.abs_diff(i) <= 2 { left } else { right };
                let of = |value: &[f64]| {
                    let misfit = if order == 0 {
                        self.bent(value, k)
                    } else {
                        self.distance(value, k)
                    };
                    1.0 + (misfit / scale).powi(2)
                };
                gain += WEIGHT[order] * (of(&self.value) / of(exchanged)).ln();
            }
        }
        gain
    }
}
