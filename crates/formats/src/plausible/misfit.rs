//! How far each intensity is from what its neighbours say, along γ and across planes.
//!
//! Along γ a value is compared with the cubic through its four neighbours (past the pole through the opposite plane),
//! across planes with the cubic through the four neighbouring planes (past the last one by the file's symmetry). What is
//! usual in the surroundings is the yardstick: light is rough where it is cut off, and rough in the same places of the
//! neighbouring planes.

use super::Stored;

/// The share of the surroundings' misfits that counts as usual.
const USUAL: f64 = 0.7;
/// Fewest misfits of the surroundings that tell what is usual.
const FEWEST: usize = 5;

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

/// A neighbour along γ: angle index, whether it stands in the opposite plane, and its weight in the prediction.
#[derive(Clone, Copy)]
struct Beside {
    angle: usize,
    opposite: bool,
    weight: f64,
}

/// Values with their misfits in both directions.
pub(super) struct Field<'s> {
    pub planes: usize,
    pub ng: usize,
    pub values: &'s [f64],
    pub gamma_deg: &'s [f64],
    pub peak: f64,
    round: Round,
    c_deg: Vec<f64>,
    /// The plane at C + 180°.
    opposite: Vec<Option<usize>>,
    beside: Vec<Option<[Beside; 4]>>,
    /// Planes beside each plane, with their weights.
    aside: Vec<Option<[(usize, f64); 4]>>,
    /// NaN where there are too few neighbours.
    pub along: Vec<f64>,
    pub across: Vec<f64>,
    step: f64,
}

/// Some misfits in units of what is usual, each with what a unit of change would add to it.
#[derive(Default)]
pub(super) struct Pattern {
    pub misfit: Vec<f64>,
    pub unit: Vec<f64>,
}

impl Pattern {
    /// Misfit · unit and unit · unit.
    pub fn products(&self) -> (f64, f64) {
        let pairs = || self.misfit.iter().zip(&self.unit);
        (
            pairs().map(|(misfit, unit)| misfit * unit).sum(),
            pairs().map(|(_, unit)| unit * unit).sum(),
        )
    }

    /// Root mean square (over `freedom`) and largest of what is left after `change`.
    pub fn left(&self, change: f64, freedom: usize) -> (f64, f64) {
        let (mut sum, mut largest) = (0.0, 0.0_f64);
        for (misfit, unit) in self.misfit.iter().zip(&self.unit) {
            let left = misfit + change * unit;
            sum += left * left;
            largest = largest.max(left.abs());
        }
        ((sum / freedom.max(1) as f64).sqrt(), largest)
    }
}

impl<'s> Field<'s> {
    /// None where there are too few angles to compare anything; `step` is the last decimal of the file.
    pub fn new(stored: &'s Stored<'_>, step: f64) -> Option<Self> {
        let ng = stored.angles_deg.len();
        let mut planes = stored.planes_deg.len();
        if ng < 7 || planes == 0 || stored.values.len() != planes * ng {
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
        let mut field = Self {
            planes,
            ng,
            values,
            gamma_deg: stored.angles_deg,
            peak: values.iter().fold(0.0, |most, value| most.max(value.abs())),
            round,
            c_deg,
            opposite: vec![None; planes],
            beside: Vec::new(),
            aside: Vec::new(),
            along: vec![f64::NAN; planes * ng],
            across: vec![f64::NAN; planes * ng],
            step: step.max(1e-12),
        };
        if field.peak <= 0.0 {
            return None;
        }
        if stored.poles {
            field.opposite = (0..planes).map(|plane| field.opposite_of(plane)).collect();
        }
        field.beside = (0..ng).map(|angle| field.beside(angle)).collect();
        field.aside = (0..planes).map(|plane| field.aside(plane)).collect();
        field.misfits();
        Some(field)
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
        let at = self.c_deg.partition_point(|&other| other < wanted - 1e-6);
        (at < self.planes && (self.c_deg[at] - wanted).abs() < 1e-6).then_some(at)
    }

    /// The four neighbours of an angle.
    fn beside(&self, angle: usize) -> Option<[Beside; 4]> {
        let last = self.ng as isize - 1;
        let mut angles = [0.0; 4];
        let mut found = [Beside {
            angle: 0,
            opposite: false,
            weight: 0.0,
        }; 4];
        for (k, offset) in [-2, -1, 1, 2].into_iter().enumerate() {
            let at = angle as isize + offset;
            let (pole, inside) = match at {
                at if at < 0 => (Some(0.0), -at),
                at if at > last => (Some(180.0), 2 * last - at),
                at => (None, at),
            };
            let inside = inside as usize;
            let own = self.gamma_deg[inside];
            angles[k] = match pole {
                None => own,
                Some(pole) => {
                    let end = self.gamma_deg[if at < 0 { 0 } else { self.ng - 1 }];
                    if end != pole {
                        return None;
                    }
                    2.0 * pole - own
                }
            };
            found[k].angle = inside;
            found[k].opposite = pole.is_some();
        }
        for (beside, weight) in found.iter_mut().zip(lagrange(self.gamma_deg[angle], &angles)) {
            beside.weight = weight;
        }
        Some(found)
    }

    /// Angle and row of the plane at index `plane`, which may lie past either end.
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

    fn aside(&self, plane: usize) -> Option<[(usize, f64); 4]> {
        if self.planes < 4 {
            return None;
        }
        let mut angles = [0.0; 4];
        let mut rows = [0; 4];
        for (k, offset) in [-2, -1, 1, 2].into_iter().enumerate() {
            (angles[k], rows[k]) = self.plane(plane as isize + offset)?;
        }
        let weights = lagrange(self.c_deg[plane], &angles);
        Some(std::array::from_fn(|k| (rows[k], weights[k])))
    }

    fn misfits(&mut self) {
        let ng = self.ng;
        for plane in 0..self.planes {
            let row = &self.values[plane * ng..(plane + 1) * ng];
            let opposite = self.opposite[plane].map(|other| &self.values[other * ng..(other + 1) * ng]);
            let along = &mut self.along[plane * ng..(plane + 1) * ng];
            for (angle, beside) in self.beside.iter().enumerate() {
                let Some(beside) = beside else { continue };
                along[angle] = if (2..ng - 2).contains(&angle) {
                    let [a, b, c, d] = beside.map(|beside| beside.weight);
                    row[angle] - a * row[angle - 2] - b * row[angle - 1] - c * row[angle + 1] - d * row[angle + 2]
                } else {
                    let value = |beside: &Beside| {
                        let from = if beside.opposite { opposite } else { Some(row) };
                        from.map_or(f64::NAN, |from| beside.weight * from[beside.angle])
                    };
                    row[angle] - beside.iter().map(value).sum::<f64>()
                };
            }
            let Some(aside) = self.aside[plane] else { continue };
            let [a, b, c, d] = aside.map(|(other, _)| &self.values[other * ng..(other + 1) * ng]);
            let [wa, wb, wc, wd] = aside.map(|(_, weight)| weight);
            for (angle, misfit) in self.across[plane * ng..(plane + 1) * ng].iter_mut().enumerate() {
                *misfit = row[angle] - wa * a[angle] - wb * b[angle] - wc * c[angle] - wd * d[angle];
            }
        }
    }

    /// What is usual around a value, beyond the reach of the value itself: along γ in other planes, where the same edge
    /// shows at the same angle; across planes at other angles. None where too little is around.
    fn usual(&self, plane: usize, angle: usize, along: bool) -> Option<f64> {
        const PLANES: [isize; 6] = [-3, -2, -1, 1, 2, 3];
        let misfit = if along { &self.along } else { &self.across };
        let mut around = [0.0; 64];
        let mut count = 0;
        let mut take = |value: f64| {
            around[count] = value.abs();
            count += usize::from(!value.is_nan());
        };
        if self.planes >= 4 {
            let (from, to) = (angle.saturating_sub(4), (angle + 5).min(self.ng));
            for offset in PLANES {
                let Some((_, other)) = self.plane(plane as isize + offset).filter(|found| found.1 != plane) else {
                    continue;
                };
                let row = &misfit[other * self.ng..(other + 1) * self.ng];
                for (at, &value) in row.iter().enumerate().take(to).skip(from) {
                    if along || !(at == angle || at == angle + 1) {
                        take(value);
                    }
                }
            }
        } else {
            let row = &misfit[plane * self.ng..(plane + 1) * self.ng];
            let below = angle.saturating_sub(9)..(angle + 1).saturating_sub(4);
            let above = (angle + 4).min(self.ng)..(angle + 10).min(self.ng);
            below.chain(above).for_each(|at| take(row[at]));
        }
        if count < FEWEST {
            return None;
        }
        let at = ((count - 1) as f64 * USUAL).round() as usize;
        let (_, usual, _) = around[..count].select_nth_unstable_by(at, f64::total_cmp);
        Some(*usual + self.step)
    }

    /// The larger of both misfits in units of what is usual.
    pub fn prominence(&self, plane: usize, angle: usize) -> f64 {
        let index = plane * self.ng + angle;
        let of = |misfit: f64, along: bool| {
            if misfit.is_nan() {
                return 0.0;
            }
            self.usual(plane, angle, along)
                .map_or(0.0, |usual| misfit.abs() / usual)
        };
        of(self.along[index], true).max(of(self.across[index], false))
    }

    /// All misfits that a change of `changes` (angle and its share) in one plane reaches.
    pub fn pattern(&self, plane: usize, changes: &[(usize, f64)]) -> Pattern {
        let mut pattern = Pattern::default();
        let mut add = |misfit: f64, unit: f64, usual: Option<f64>| {
            if let Some(usual) = usual.filter(|_| !misfit.is_nan() && unit != 0.0) {
                pattern.misfit.push(misfit / usual);
                pattern.unit.push(unit / usual);
            }
        };
        let (first, last) = changes.iter().fold((usize::MAX, 0), |(first, last), &(angle, _)| {
            (first.min(angle), last.max(angle))
        });
        let folded = self.opposite[plane] == Some(plane);
        for angle in first.saturating_sub(2)..(last + 3).min(self.ng) {
            let misfit = self.along[plane * self.ng + angle];
            let Some(beside) = self.beside[angle].filter(|_| !misfit.is_nan()) else {
                continue;
            };
            let unit: f64 = changes
                .iter()
                .map(|&(changed, share)| {
                    let own = f64::from(u8::from(changed == angle));
                    let near = beside.iter().filter(|b| b.angle == changed && (!b.opposite || folded));
                    share * (own - near.map(|b| b.weight).sum::<f64>())
                })
                .sum();
            add(misfit, unit, self.usual(plane, angle, true));
        }
        let mut reached: Vec<usize> = (-2..=2)
            .filter_map(|offset| self.plane(plane as isize + offset).map(|found| found.1))
            .collect();
        reached.sort_unstable();
        reached.dedup();
        for other in reached {
            let Some(aside) = self.aside[other] else { continue };
            let near: f64 = aside
                .iter()
                .filter(|beside| beside.0 == plane)
                .map(|beside| beside.1)
                .sum();
            let unit = f64::from(u8::from(other == plane)) - near;
            for &(angle, share) in changes {
                let misfit = self.across[other * self.ng + angle];
                add(misfit, share * unit, self.usual(other, angle, false));
            }
        }
        pattern
    }

    /// The planes beside a plane.
    pub fn planes_beside(&self, plane: usize) -> impl Iterator<Item = usize> + '_ {
        let beside = [-1, 1]
            .into_iter()
            .filter_map(move |offset| self.plane(plane as isize + offset));
        beside.map(|found| found.1).filter(move |&other| other != plane)
    }

    /// How much the misfit along γ at `angle` grows with the value there and falls with the value at the next angle.
    pub fn step_share(&self, angle: usize) -> f64 {
        let next = |beside: &[Beside; 4]| {
            let near = beside.iter().filter(|b| b.angle == angle + 1 && !b.opposite);
            1.0 + near.map(|b| b.weight).sum::<f64>()
        };
        self.beside[angle].as_ref().map_or(0.0, next)
    }
}

/// Weights of the values at `points` in the cubic through them, taken at `x`.
fn lagrange(x: f64, points: &[f64; 4]) -> [f64; 4] {
    std::array::from_fn(|k| {
        let others = (0..4).filter(|&other| other != k);
        others
            .map(|other| (x - points[other]) / (points[k] - points[other]))
            .product()
    })
}
