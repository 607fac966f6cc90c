//! Values and pairs that stand out from what both directions, along γ and across planes, say of them.
//!
//! Each value is predicted by the cubic through its four neighbours along γ (past the pole through the opposite plane)
//! and through its four neighbours across planes (past the last plane by the file's symmetry). Each prediction counts
//! as much as it is right in the surroundings, so a rough direction cannot hide what the smooth one shows. What is left
//! over is measured in units of the surroundings' own misfit, and a file whose light is rough everywhere is its own
//! yardstick: only what stands well above its sixth largest misfit is suspect.

use super::Stored;

/// A single value this many times the surroundings' misfit away.
const SINGLE: f64 = 30.0;
/// A pair that fits only the other way round, likewise.
const PAIR: f64 = 6.0;
/// Above this many times the sixth largest of the file.
const ABOVE_SIXTH: f64 = 1.5;
/// Least misfit of a single value and least difference of a pair, relative.
const RELATIVE: (f64, f64) = (0.02, 0.01);
/// A pair is swapped if its difference is predicted with the other sign, to within this share of twice itself.
const REVERSED: f64 = 0.4;
/// A direction that predicts up to this many times worse than the better one must agree with it.
const CONTRADICTS: f64 = 3.0;
/// The share of the surroundings' misfits that counts as typical.
const TYPICAL: f64 = 0.7;

/// A value, or a value and the next one along γ, that stands out; `change` is what would make it fit.
pub(super) struct Standout {
    pub plane: usize,
    pub angle: usize,
    pub change: f64,
    pub pair: bool,
}

/// What stands out; `step` is the last decimal of the file.
pub(super) fn find(stored: &Stored<'_>, step: f64) -> Vec<Standout> {
    let Some(grid) = Grid::new(stored, step) else {
        return Vec::new();
    };
    let mut single = Vec::new();
    let mut pairs = Vec::new();
    for plane in 0..grid.planes {
        for angle in 0..grid.ng {
            single.extend(grid.single(plane, angle));
            pairs.extend(grid.pair(plane, angle));
        }
    }
    let mut found = stand_out(pairs, PAIR, true);
    let beside =
        |one: &Standout, pair: &Standout| pair.plane.abs_diff(one.plane) <= 2 && pair.angle.abs_diff(one.angle) <= 3;
    let mut alone = stand_out(single, SINGLE, false);
    alone.retain(|one| !found.iter().any(|pair| beside(one, pair)));
    found.extend(alone);
    found
}

/// Misfit in units of the surroundings, plane, angle, change.
type Misfit = (f64, usize, usize, f64);

fn stand_out(mut all: Vec<Misfit>, least: f64, pair: bool) -> Vec<Standout> {
    all.sort_by(|a, b| b.0.total_cmp(&a.0));
    let mut peaks: Vec<Misfit> = Vec::new();
    // One wrong value disturbs the predictions of its neighbours; the largest of a group speaks for it.
    for misfit in all.into_iter().take(400) {
        let apart = |peak: &Misfit| {
            let (planes, angles) = (peak.1.abs_diff(misfit.1), peak.2.abs_diff(misfit.2));
            !(planes == 0 && angles <= 3 || angles == 0 && planes <= 2)
        };
        if peaks.iter().all(apart) {
            peaks.push(misfit);
        }
    }
    let least = least.max(peaks.get(6).map_or(0.0, |sixth| ABOVE_SIXTH * sixth.0));
    peaks
        .into_iter()
        .filter(|peak| peak.0 > least)
        .map(|(_, plane, angle, change)| Standout {
            plane,
            angle,
            change,
            pair,
        })
        .collect()
}

/// How the stored planes go on past the first and the last.
#[derive(Clone, Copy, PartialEq)]
enum Round {
    /// One plane for all.
    One,
    /// Mirrored at both ends, over this span.
    Mirror(f64),
    Circle,
    Open,
}

struct Grid<'s> {
    planes: usize,
    ng: usize,
    values: &'s [f64],
    round: Round,
    /// Angles of the planes, rising.
    c_deg: Vec<f64>,
    gamma_deg: &'s [f64],
    /// The plane at C + 180°.
    opposite: Vec<Option<usize>>,
    /// Residual against the neighbours along γ, against those across planes, and of the step to the next angle.
    along: Vec<f64>,
    across: Vec<f64>,
    step_along: Vec<f64>,
    step: f64,
    peak: f64,
}

impl<'s> Grid<'s> {
    fn new(stored: &'s Stored<'_>, step: f64) -> Option<Self> {
        let ng = stored.angles_deg.len();
        let mut planes = stored.planes_deg.len();
        if ng < 7 || stored.values.len() != planes * ng {
            return None;
        }
        let mut c_deg = stored.planes_deg.to_vec();
        for at in 1..planes {
            while c_deg[at] <= c_deg[at - 1] {
                c_deg[at] += 360.0;
            }
        }
        let span = c_deg[planes - 1] - c_deg[0];
        if planes > 1 && (span - 360.0).abs() < 1e-6 {
            planes -= 1;
            c_deg.pop();
        }
        let widest = c_deg.windows(2).map(|pair| pair[1] - pair[0]).fold(0.0, f64::max);
        let round = match span {
            _ if planes == 1 => Round::One,
            // Types A and B: neither mirrored nor closed.
            _ if !stored.poles => Round::Open,
            span if (span - 90.0).abs() < 1e-6 || (span - 180.0).abs() < 1e-6 => Round::Mirror(span),
            span if span >= 360.0 - 1.5 * widest => Round::Circle,
            _ => Round::Open,
        };
        let values = &stored.values[..planes * ng];
        let mut grid = Self {
            planes,
            ng,
            values,
            round,
            c_deg,
            gamma_deg: stored.angles_deg,
            opposite: Vec::new(),
            along: Vec::new(),
            across: Vec::new(),
            step_along: Vec::new(),
            step: step.max(1e-12),
            peak: values.iter().fold(0.0, |most, value| most.max(value.abs())),
        };
        grid.opposite = (0..planes).map(|plane| grid.opposite_of(plane)).collect();
        if !stored.poles {
            grid.opposite.fill(None);
        }
        grid.residuals();
        (grid.peak > 0.0).then_some(grid)
    }

    fn opposite_of(&self, plane: usize) -> Option<usize> {
        let (first, c) = (*self.c_deg.first()?, self.c_deg[plane]);
        let wanted = match self.round {
            Round::One => return Some(0),
            Round::Open => return None,
            // Of a quadrant the opposite plane is the plane itself, of a half it is the mirror image within the half.
            Round::Mirror(span) if span < 100.0 => c,
            Round::Mirror(span) => 2.0 * first + span - c,
            Round::Circle => (c + 180.0 - first).rem_euclid(360.0) + first,
        };
        self.c_deg.iter().position(|other| (other - wanted).abs() < 1e-6)
    }

    /// Angle and value of plane `plane` at index `angle`, which may lie up to two past either pole.
    fn at(&self, plane: usize, angle: isize) -> Option<(f64, f64)> {
        let last = self.ng as isize - 1;
        let value = |plane: usize, angle: isize| self.values[plane * self.ng + angle as usize];
        if (0..=last).contains(&angle) {
            return Some((self.gamma_deg[angle as usize], value(plane, angle)));
        }
        let (pole, inside) = if angle < 0 {
            (0, -angle)
        } else {
            (last, 2 * last - angle)
        };
        let pole_deg = self.gamma_deg[pole as usize];
        if !(pole_deg == 0.0 || pole_deg == 180.0) || (angle < 0) != (pole_deg == 0.0) {
            return None;
        }
        let opposite = self.opposite[plane]?;
        Some((
            2.0 * pole_deg - self.gamma_deg[inside as usize],
            value(opposite, inside),
        ))
    }

    /// Angle and row of the plane at index `plane`, which may lie up to two past either end.
    fn plane(&self, plane: isize) -> Option<(f64, usize)> {
        let count = self.planes as isize;
        let (first, last) = (*self.c_deg.first()?, *self.c_deg.last()?);
        if (0..count).contains(&plane) {
            return Some((self.c_deg[plane as usize], plane as usize));
        }
        match self.round {
            Round::One | Round::Open => None,
            Round::Circle => {
                let inside = plane.rem_euclid(count) as usize;
                let turn = if plane < 0 { -360.0 } else { 360.0 };
                Some((self.c_deg[inside] + turn, inside))
            }
            Round::Mirror(_) => {
                let (end, inside) = if plane < 0 {
                    (first, -plane)
                } else {
                    (last, 2 * (count - 1) - plane)
                };
                let inside = usize::try_from(inside).ok().filter(|&inside| inside < self.planes)?;
                Some((2.0 * end - self.c_deg[inside], inside))
            }
        }
    }

    fn residuals(&mut self) {
        let missing = f64::NAN;
        let (mut along, mut across, mut step_along) = (Vec::new(), Vec::new(), Vec::new());
        for plane in 0..self.planes {
            let around: Option<Vec<(f64, usize)>> = [-2, -1, 1, 2]
                .iter()
                .map(|offset| self.plane(plane as isize + offset))
                .collect();
            let across_weights = around.filter(|_| self.planes >= 4).map(|around| {
                let angles: Vec<f64> = around.iter().map(|plane| plane.0).collect();
                (lagrange(self.c_deg[plane], &angles), around)
            });
            for angle in 0..self.ng {
                let here = self.values[plane * self.ng + angle];
                let angle_deg = self.gamma_deg[angle];
                let near = |offsets: [isize; 4]| -> Option<Vec<(f64, f64)>> {
                    offsets
                        .iter()
                        .map(|offset| self.at(plane, angle as isize + offset))
                        .collect()
                };
                let predict = |x: f64, points: &[(f64, f64)]| -> f64 {
                    let angles: Vec<f64> = points.iter().map(|point| point.0).collect();
                    lagrange(x, &angles)
                        .iter()
                        .zip(points)
                        .map(|(weight, point)| weight * point.1)
                        .sum()
                };
                along.push(near([-2, -1, 1, 2]).map_or(missing, |points| here - predict(angle_deg, &points)));
                let next = (angle + 1 < self.ng)
                    .then(|| {
                        near([-2, -1, 2, 3])
                            .or_else(|| near([-1, 2, 3, 4]))
                            .or_else(|| near([-3, -2, -1, 2]))
                    })
                    .flatten();
                step_along.push(next.map_or(missing, |points| {
                    let (next_deg, next) = (self.gamma_deg[angle + 1], self.values[plane * self.ng + angle + 1]);
                    next - here - (predict(next_deg, &points) - predict(angle_deg, &points))
                }));
                across.push(across_weights.as_ref().map_or(missing, |(weights, around)| {
                    let sum = |(weight, plane): (&f64, &(f64, usize))| weight * self.values[plane.1 * self.ng + angle];
                    here - weights.iter().zip(around).map(sum).sum::<f64>()
                }));
            }
        }
        (self.along, self.across, self.step_along) = (along, across, step_along);
    }

    /// Residual of the step to the next angle, across planes.
    fn step_across(&self, index: usize) -> f64 {
        if (index + 1).is_multiple_of(self.ng) {
            f64::NAN
        } else {
            self.across[index + 1] - self.across[index]
        }
    }

    /// Typical misfit in the surroundings, beyond the reach of the value itself: along γ in other planes, where the
    /// same edge shows at the same angle; across planes at other angles.
    fn typical(&self, plane: usize, angle: usize, along: bool, residual: &dyn Fn(usize) -> f64) -> Option<f64> {
        let mut around: Vec<f64> = Vec::with_capacity(64);
        let mut take = |plane: Option<usize>, angle: isize| {
            if let Some(plane) = plane
                && (0..self.ng as isize).contains(&angle)
            {
                let misfit = residual(plane * self.ng + angle as usize).abs();
                if !misfit.is_nan() {
                    around.push(misfit);
                }
            }
        };
        let angle = angle as isize;
        if self.planes >= 4 {
            for offset in [-3, -2, -1, 1, 2, 3] {
                let plane = self
                    .plane(plane as isize + offset)
                    .map(|found| found.1)
                    .filter(|&other| other != plane);
                for step in (-4..=4).filter(|step| along || !(0..=1).contains(step)) {
                    take(plane, angle + step);
                }
            }
        } else {
            for step in [-9, -8, -7, -6, -5, -4, 4, 5, 6, 7, 8, 9] {
                take(Some(plane), angle + step);
            }
        }
        if around.len() < 5 {
            return None;
        }
        let at = ((around.len() - 1) as f64 * TYPICAL).round() as usize;
        let (_, typical, _) = around.select_nth_unstable_by(at, f64::total_cmp);
        Some(*typical + self.step)
    }

    /// Both residuals together, each weighted by how well its direction predicts the surroundings, and their misfit.
    /// None where a direction that predicts well contradicts what both say together.
    fn joined(
        &self,
        plane: usize,
        angle: usize,
        along: &dyn Fn(usize) -> f64,
        across: &dyn Fn(usize) -> f64,
    ) -> Option<(f64, f64)> {
        let index = plane * self.ng + angle;
        let heard = [(true, along), (false, across)].map(|(is_along, residual)| {
            let here = residual(index);
            let typical = self
                .typical(plane, angle, is_along, residual)
                .filter(|_| !here.is_nan());
            typical.map(|typical| (here, typical))
        });
        let heard = || heard.iter().flatten();
        let weights: f64 = heard().map(|(_, typical)| typical.powi(-2)).sum();
        let sum: f64 = heard().map(|(here, typical)| here * typical.powi(-2)).sum();
        let best = heard().fold(f64::INFINITY, |best, (_, typical)| best.min(*typical));
        let residual = sum / weights;
        let agrees = |&(here, typical): &(f64, f64)| {
            typical > CONTRADICTS * best || (here - residual).abs() <= 0.5 * residual.abs()
        };
        (weights > 0.0 && heard().all(agrees)).then(|| (residual, 1.0 / weights.sqrt()))
    }

    /// Few planes do not tell an edge of the light from damage, but an edge is at the same angle in all of them, and a
    /// single plane breaks off at the horizon.
    fn edge(&self, plane: usize, angle: usize, here: f64, residual: &[f64]) -> bool {
        if self.planes >= 4 {
            return false;
        }
        let range = angle.saturating_sub(1)..(angle + 2).min(self.ng);
        if self.planes == 1 {
            let width = self.gamma_deg[range.end - 1] - self.gamma_deg[range.start];
            return (self.gamma_deg[angle] - 90.0).abs() <= width.max(5.0);
        }
        let others = (0..self.planes).filter(|&other| other != plane);
        let largest = others
            .flat_map(|other| range.clone().map(move |angle| other * self.ng + angle))
            .fold(0.0, |most: f64, index| most.max(residual[index].abs()));
        here.abs() < 3.0 * largest
    }

    fn single(&self, plane: usize, angle: usize) -> Option<Misfit> {
        let index = plane * self.ng + angle;
        let least = RELATIVE.0 * self.values[index].abs().max(0.002 * self.peak);
        // `max` passes over a direction without a prediction.
        if self.along[index].abs().max(self.across[index].abs()) < least {
            return None;
        }
        let (residual, misfit) = self.joined(plane, angle, &|at| self.along[at], &|at| self.across[at])?;
        (residual.abs() >= least && !self.edge(plane, angle, residual, &self.along))
            .then(|| (residual.abs() / misfit, plane, angle, -residual))
    }

    fn pair(&self, plane: usize, angle: usize) -> Option<Misfit> {
        let index = plane * self.ng + angle;
        if angle + 1 >= self.ng {
            return None;
        }
        let (here, next) = (self.values[index], self.values[index + 1]);
        let difference = next - here;
        let large = difference.abs() > RELATIVE.1 * here.abs().max(next.abs()) && difference.abs() > 2.0 * self.step;
        let reversed = |residual: f64, share: f64| (residual - 2.0 * difference).abs() < share * 2.0 * difference.abs();
        let somewhere = [self.step_along[index], self.step_across(index)];
        if !large || !somewhere.iter().any(|&residual| reversed(residual, 2.0 * REVERSED)) {
            return None;
        }
        let (residual, misfit) = self.joined(plane, angle, &|at| self.step_along[at], &|at| self.step_across(at))?;
        (reversed(residual, REVERSED) && !self.edge(plane, angle, residual, &self.step_along))
            .then(|| (residual.abs() / misfit, plane, angle, difference))
    }
}

/// Weights of the values at `points` in the cubic through them, taken at `x`.
fn lagrange(x: f64, points: &[f64]) -> [f64; 4] {
    std::array::from_fn(|k| {
        let others = (0..points.len()).filter(|&other| other != k);
        others
            .map(|other| (x - points[other]) / (points[k] - points[other]))
            .product()
    })
}
