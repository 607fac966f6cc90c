//! How far each intensity is from what its neighbours say, along γ and across planes.
//!
//! A value is compared with the line through its two neighbours and with the cubic through its four, along γ (past the pole
//! through the opposite plane) and across planes (past the last one by the file's symmetry). What is usual in the
//! surroundings is the yardstick: light is rough where it is cut off, and rough in the same places of the neighbouring
//! planes. Evidence is a ratio of likelihoods under a Cauchy distribution, whose long tails let one misfit be large
//! without outvoting all others.

mod trial;

use std::cell::Cell;

use super::Stored;

pub(super) use trial::Trial;

/// The share of the surroundings' misfits that counts as usual: in other planes, and with few planes, where a second wrong
/// value may stand nearby.
const USUAL: f64 = 0.7;
const USUAL_FEW: f64 = 0.5;
/// No values are smoother than to this part of the peak.
const FINEST: f64 = 0.0002;
/// Fewest misfits of the surroundings that tell what is usual.
const FEWEST: usize = 5;
/// What the misfits of a line and of a cubic count; they are not independent.
const WEIGHT: [f64; 2] = [1.0, 0.5];
/// A cubic takes four neighbours; where planes are few as well there is nothing to compare with, and nothing is told.
const FEWEST_ANGLES: usize = 5;
/// How many neighbours on either side a line and a cubic take.
const REACH: [usize; 2] = [1, 2];

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

/// The four neighbours, of which a line has two with weight 0.
type Along = Option<[Beside; 4]>;
/// Planes beside a plane with their weights.
type Across = Option<[(usize, f64); 4]>;

/// Values with their misfits: along γ by a line and a cubic, across planes by a line and a cubic.
pub(super) struct Field {
    pub planes: usize,
    pub ng: usize,
    pub values: Vec<f64>,
    pub peak: f64,
    gamma_deg: Vec<f64>,
    round: Round,
    c_deg: Vec<f64>,
    /// The plane at C + 180°.
    opposite: Vec<Option<usize>>,
    along: [Vec<Along>; 2],
    across: [Vec<Across>; 2],
    /// NaN where there are too few neighbours; by direction (along, across) and order (line, cubic).
    misfit: [[Vec<f32>; 2]; 2],
    /// What is usual around each misfit, once it was asked for; table after table as [`Which::at`] counts.
    usual: Vec<Cell<f32>>,
    /// What rounding and the finest scatter leave.
    finest: f64,
    /// Misfits that were weighed so far.
    work: Cell<usize>,
}

/// Marks in the table of what is usual: not asked for yet, and too little around to tell.
const UNKNOWN: f32 = f32::NAN;
const NOTHING: f32 = -1.0;

/// One of the four misfits at one value.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
struct Which {
    across: bool,
    order: usize,
    plane: usize,
    angle: usize,
}

impl Which {
    /// Where it stands in a table of all misfits.
    fn at(self, field: &Field) -> usize {
        let table = 2 * usize::from(self.across) + self.order;
        (table * field.planes + self.plane) * field.ng + self.angle
    }
}

/// All misfits that a change reaches, in units of what is usual.
#[derive(Default, Clone)]
pub(super) struct Pattern {
    parts: Vec<Part>,
    /// The logarithm of the likelihood of the misfits as they are, less a constant.
    before: f64,
    /// Changes that would make one of the changed value's own misfits vanish.
    pub suggested: Vec<f64>,
}

#[derive(Clone)]
struct Part {
    misfit: f64,
    /// What a unit of the change adds.
    unit: f64,
    order: usize,
}

impl Pattern {
    /// How much likelier the values are after the change: the logarithm of the ratio, above 0 where they fit better.
    pub fn gain(&self, change: f64) -> f64 {
        self.before - self.unlikelihood(change)
    }

    /// Minus the logarithm of the likelihood after a change, less a constant.
    fn unlikelihood(&self, change: f64) -> f64 {
        const LARGE: f64 = 1e200;
        let (mut products, mut sum) = ([1.0_f64; 2], 0.0);
        for part in &self.parts {
            let misfit = part.misfit + change * part.unit;
            let product = &mut products[part.order];
            *product *= 1.0 + misfit * misfit;
            if *product > LARGE {
                sum += WEIGHT[part.order] * product.ln();
                *product = 1.0;
            }
        }
        sum + WEIGHT[0] * products[0].ln() + WEIGHT[1] * products[1].ln()
    }

    /// The suggested change that gains most, with its gain.
    pub fn best(&self) -> Option<(f64, f64)> {
        let gains = self.suggested.iter().map(|&change| (self.gain(change), change));
        gains.max_by(|a, b| a.0.total_cmp(&b.0))
    }
}

impl Field {
    /// None where there are too few angles to compare anything; `values` stand where those of the file
    /// stood, `step` is their resolution.
    pub fn new(stored: &Stored<'_>, values: &[f64], step: f64) -> Option<Self> {
        let ng = stored.angles_deg.len();
        let mut planes = stored.planes_deg.len();
        if ng < FEWEST_ANGLES || planes == 0 || values.len() != planes * ng {
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
        let values = values[..planes * ng].to_vec();
        let mut field = Self {
            planes,
            ng,
            peak: values.iter().fold(0.0, |most, value| most.max(value.abs())),
            values,
            gamma_deg: stored.angles_deg.to_vec(),
            round,
            c_deg,
            opposite: vec![None; planes],
            along: [Vec::new(), Vec::new()],
            across: [Vec::new(), Vec::new()],
            misfit: Default::default(),
            usual: vec![Cell::new(UNKNOWN); 4 * planes * ng],
            finest: 0.0,
            work: Cell::new(0),
        };
        if field.peak <= 0.0 {
            return None;
        }
        field.finest = step.max(1e-12) + FINEST * field.peak;
        if stored.poles {
            field.opposite = (0..planes).map(|plane| field.opposite_of(plane)).collect();
        }
        for order in 0..2 {
            field.along[order] = (0..ng).map(|angle| field.beside(angle, order)).collect();
            field.across[order] = (0..planes).map(|plane| field.aside(plane, order)).collect();
            field.misfit[0][order] = field.misfits_along(order);
            field.misfit[1][order] = field.misfits_across(order);
        }
        Some(field)
    }

    /// How many misfits were weighed: a measure of the time that was spent.
    pub fn work(&self) -> usize {
        self.work.get()
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

    /// The neighbours of an angle.
    fn beside(&self, angle: usize, order: usize) -> Along {
        let last = self.ng as isize - 1;
        let mut angles = [0.0; 4];
        let mut found = [Beside {
            angle,
            opposite: false,
            weight: 0.0,
        }; 4];
        let mut count = 0;
        for offset in offsets(order) {
            let at = angle as isize + offset;
            let (pole, inside) = match at {
                at if at < 0 => (Some(0.0), -at),
                at if at > last => (Some(180.0), 2 * last - at),
                at => (None, at),
            };
            let inside = inside as usize;
            let own = self.gamma_deg[inside];
            angles[count] = match pole {
                None => own,
                Some(pole) => {
                    let end = self.gamma_deg[if at < 0 { 0 } else { self.ng - 1 }];
                    if end != pole {
                        return None;
                    }
                    2.0 * pole - own
                }
            };
            found[count].angle = inside;
            found[count].opposite = pole.is_some();
            count += 1;
        }
        let weights = lagrange(self.gamma_deg[angle], &angles[..count]);
        for (beside, weight) in found.iter_mut().zip(weights) {
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

    fn aside(&self, plane: usize, order: usize) -> Across {
        if self.planes < 3 + order {
            return None;
        }
        let mut angles = [0.0; 4];
        let mut rows = [plane; 4];
        let mut count = 0;
        for offset in offsets(order) {
            (angles[count], rows[count]) = self.plane(plane as isize + offset)?;
            count += 1;
        }
        let weights = lagrange(self.c_deg[plane], &angles[..count]);
        Some(std::array::from_fn(|k| (rows[k], weights[k])))
    }

    fn row(&self, plane: usize) -> &[f64] {
        &self.values[plane * self.ng..(plane + 1) * self.ng]
    }

    fn misfits_along(&self, order: usize) -> Vec<f32> {
        let mut misfits = vec![f32::NAN; self.planes * self.ng];
        for (plane, misfits) in misfits.chunks_mut(self.ng).enumerate() {
            let row = self.row(plane);
            let opposite = self.opposite[plane].map(|other| self.row(other));
            for (angle, misfit) in misfits.iter_mut().enumerate() {
                *misfit = self.misfit_along(order, row, opposite, angle);
            }
        }
        misfits
    }

    #[inline]
    fn misfit_along(&self, order: usize, row: &[f64], opposite: Option<&[f64]>, angle: usize) -> f32 {
        let Some(beside) = &self.along[order][angle] else {
            return f32::NAN;
        };
        let (reach, [a, b, c, d]) = (REACH[order], beside.map(|beside| beside.weight));
        let inside = (reach..self.ng - reach).contains(&angle);
        let misfit = if inside && order == 0 {
            row[angle] - a * row[angle - 1] - b * row[angle + 1]
        } else if inside {
            row[angle] - a * row[angle - 2] - b * row[angle - 1] - c * row[angle + 1] - d * row[angle + 2]
        } else {
            let value = |beside: &Beside| {
                let from = if beside.opposite { opposite } else { Some(row) };
                from.map_or(f64::NAN, |from| beside.weight * from[beside.angle])
            };
            row[angle] - beside.iter().map(value).sum::<f64>()
        };
        misfit as f32
    }

    fn misfits_across(&self, order: usize) -> Vec<f32> {
        let mut misfits = vec![f32::NAN; self.planes * self.ng];
        for (plane, misfits) in misfits.chunks_mut(self.ng).enumerate() {
            let Some(aside) = self.across[order][plane] else {
                continue;
            };
            let (row, aside) = (self.row(plane), aside.map(|(other, weight)| (self.row(other), weight)));
            for (angle, misfit) in misfits.iter_mut().enumerate() {
                *misfit = misfit_across(order, row[angle], &aside, angle);
            }
        }
        misfits
    }

    /// The misfits along γ (or across planes) of a value, by a line and by a cubic.
    pub fn misfits(&self, index: usize, across: bool) -> [f64; 2] {
        let of = &self.misfit[usize::from(across)];
        [f64::from(of[0][index]), f64::from(of[1][index])]
    }

    /// How much the misfit along γ at an angle grows with the value there and falls with the next one.
    pub fn own_share(&self, angle: usize, order: usize) -> f64 {
        let beside = self.along[order][angle].iter().flatten();
        let next = beside.filter(|beside| beside.angle == angle + 1 && !beside.opposite);
        1.0 + next.map(|beside| beside.weight).sum::<f64>()
    }

    /// How much the misfit across planes in `plane` grows with the value there and falls with that of `other`.
    pub fn own_share_across(&self, plane: usize, other: usize, order: usize) -> f64 {
        let weight = |of: usize| {
            let aside = self.across[order][plane].iter().flatten();
            aside.filter(|aside| aside.0 == of).map(|aside| aside.1).sum::<f64>()
        };
        1.0 - weight(plane) + weight(other)
    }

    /// The plane after a plane, the first one after the last of a circle.
    pub fn next_plane(&self, plane: usize) -> Option<usize> {
        let closes = self.round == Round::Circle && self.planes > 2;
        let next = (plane + 1 < self.planes).then_some(plane + 1);
        next.or_else(|| closes.then_some(0))
    }

    /// The misfits around a value, beyond its own reach: along γ in other planes, where the same edge shows at the same
    /// angle; across planes at other angles; with few planes in the surroundings of the plane as well. None where too
    /// little is around; beside them the rank of the one that is usual.
    fn around<'a>(&self, which: Which, around: &'a mut [f32; 64]) -> Option<(&'a mut [f32], usize)> {
        let Which {
            across,
            order,
            plane,
            angle,
        } = which;
        let misfit = &self.misfit[usize::from(across)][order];
        let mut count = 0;
        let mut take = |values: &[f32]| {
            for &value in values {
                around[count] = value.abs();
                count += usize::from(!value.is_nan());
            }
        };
        let few = self.few();
        let near = if few { 3 } else { 4 };
        let (from, to) = (angle.saturating_sub(near), (angle + near + 1).min(self.ng));
        let mut beside = |other: usize| {
            let row = &misfit[other * self.ng..(other + 1) * self.ng];
            if across {
                // This and the next angle are those of a pair.
                take(&row[from..angle]);
                take(&row[(angle + 2).min(to)..to]);
            } else {
                take(&row[from..to]);
            }
        };
        let share = if few {
            (0..self.planes).filter(|&other| other != plane).for_each(&mut beside);
            let row = &misfit[plane * self.ng..(plane + 1) * self.ng];
            take(&row[angle.saturating_sub(9)..(angle + 1).saturating_sub(4)]);
            take(&row[(angle + 4).min(self.ng)..(angle + 10).min(self.ng)]);
            USUAL_FEW
        } else {
            for offset in [-3, -2, -1, 1, 2, 3] {
                if let Some((_, other)) = self.plane(plane as isize + offset).filter(|found| found.1 != plane) {
                    beside(other);
                }
            }
            USUAL
        };
        let rank = (count.saturating_sub(1) as f64 * share).round() as usize;
        (count >= FEWEST).then_some((&mut around[..count], rank))
    }

    /// Fewer planes than tell what is usual.
    fn few(&self) -> bool {
        self.planes < 4
    }

    /// What is usual around a value.
    fn usual(&self, which: Which) -> Option<f64> {
        let known = &self.usual[which.at(self)];
        if known.get().is_nan() {
            let mut around = [0.0; 64];
            let around = self.around(which, &mut around);
            known.set(around.map_or(NOTHING, |(around, rank)| {
                let (_, usual, _) = around.select_nth_unstable_by(rank, f32::total_cmp);
                *usual
            }));
        }
        let usual = known.get();
        (usual >= 0.0).then_some(f64::from(usual) + self.finest)
    }

    /// Whether one of the misfits at a value is more than `times` what is usual.
    pub fn stands_out(&self, index: usize, times: f64) -> bool {
        let out = |across: bool, order: usize| {
            let least = self.misfits(index, across)[order].abs() / times - self.finest;
            let mut around = [0.0; 64];
            // Counting is faster than finding what is usual.
            least > 0.0
                && (across || !self.edge(index, order))
                && self
                    .around(self.which(index, across, order), &mut around)
                    .is_some_and(|(around, rank)| around.iter().filter(|&&misfit| misfit < least as f32).count() > rank)
        };
        [false, true].into_iter().any(|across| out(across, 0) || out(across, 1))
    }

    /// Most planes around have about the same misfit at this angle: light that is cut off.
    fn edge(&self, index: usize, order: usize) -> bool {
        const SAME: f32 = 1.5;
        const MOST: usize = 4;
        let (plane, angle) = (index / self.ng, index % self.ng);
        let misfit = &self.misfit[0][order];
        let others = [-3, -2, -1, 1, 2, 3]
            .into_iter()
            .filter_map(|offset| self.plane(plane as isize + offset));
        let others = others.filter(|found| found.1 != plane);
        let same = others.filter(|found| SAME * misfit[found.1 * self.ng + angle].abs() > misfit[index].abs());
        same.count() >= MOST
    }

    fn which(&self, index: usize, across: bool, order: usize) -> Which {
        Which {
            across,
            order,
            plane: index / self.ng,
            angle: index % self.ng,
        }
    }

    /// All misfits that a change of `changes` (index and its share) reaches.
    pub fn pattern(&self, changes: &[(usize, f64)]) -> Pattern {
        let mut reached = Vec::with_capacity(24 * changes.len());
        for &(index, _) in changes {
            self.reached(index, &mut reached);
        }
        reached.sort_unstable();
        reached.dedup();
        let mut pattern = Pattern::default();
        for which in reached {
            let index = which.plane * self.ng + which.angle;
            let misfit = f64::from(self.misfit[usize::from(which.across)][which.order][index]);
            if misfit.is_nan() {
                continue;
            }
            let shares = changes
                .iter()
                .map(|&(changed, share)| share * self.unit(which, changed));
            let unit: f64 = shares.sum();
            if unit == 0.0 {
                continue;
            }
            let Some(usual) = self.usual(which) else { continue };
            if changes.iter().any(|change| change.0 == index) {
                pattern.suggested.push(-misfit / unit);
            }
            pattern.parts.push(Part {
                misfit: misfit / usual,
                unit: unit / usual,
                order: which.order,
            });
        }
        self.work.set(self.work.get() + pattern.parts.len());
        pattern.before = pattern.unlikelihood(0.0);
        pattern
    }

    /// The misfits in which a value takes part.
    fn reached(&self, index: usize, into: &mut Vec<Which>) {
        for order in 0..2 {
            for across in [false, true] {
                self.near(self.which(index, across, order), |plane, angle| {
                    into.push(Which {
                        across,
                        order,
                        plane,
                        angle,
                    });
                });
            }
        }
    }

    /// The places whose values take part in a misfit; they are also the places whose misfits of this kind the value at its
    /// place takes part in. Some are named twice.
    fn near(&self, which: Which, mut place: impl FnMut(usize, usize)) {
        let Which {
            across,
            order,
            plane,
            angle,
        } = which;
        let reach = REACH[order];
        if across {
            for offset in -(reach as isize)..=reach as isize {
                if let Some((_, other)) = self.plane(plane as isize + offset) {
                    place(other, angle);
                }
            }
            return;
        }
        for at in angle.saturating_sub(reach)..(angle + reach + 1).min(self.ng) {
            place(plane, at);
        }
        // Past a pole the value is a neighbour of the opposite plane's first or last ones.
        if let Some(other) = self.opposite[plane].filter(|&other| other != plane) {
            let past = |distance: usize| (reach + 1).saturating_sub(distance);
            (0..past(angle)).for_each(|at| place(other, at));
            (0..past(self.ng - 1 - angle)).for_each(|at| place(other, self.ng - 1 - at));
        }
    }

    /// What a unit of the value at `changed` adds to a misfit.
    fn unit(&self, which: Which, changed: usize) -> f64 {
        let (plane, angle) = (changed / self.ng, changed % self.ng);
        let own = f64::from(u8::from(which.plane == plane && which.angle == angle));
        if which.across {
            let aside = self.across[which.order][which.plane].filter(|_| which.angle == angle);
            let near = aside.iter().flatten().filter(|aside| aside.0 == plane);
            return own - near.map(|aside| aside.1).sum::<f64>();
        }
        let beside = self.along[which.order][which.angle];
        let stands = |opposite: bool| {
            if opposite {
                self.opposite[which.plane] == Some(plane)
            } else {
                which.plane == plane
            }
        };
        let near = beside
            .iter()
            .flatten()
            .filter(|b| b.angle == angle && stands(b.opposite));
        own - near.map(|b| b.weight).sum::<f64>()
    }
}

#[inline]
fn misfit_across(order: usize, own: f64, [a, b, c, d]: &[(&[f64], f64); 4], angle: usize) -> f32 {
    let predicted = if order == 0 {
        a.1 * a.0[angle] + b.1 * b.0[angle]
    } else {
        a.1 * a.0[angle] + b.1 * b.0[angle] + c.1 * c.0[angle] + d.1 * d.0[angle]
    };
    (own - predicted) as f32
}

/// Steps to the neighbours that a line or a cubic takes.
fn offsets(order: usize) -> impl Iterator<Item = isize> {
    let reach = REACH[order] as isize;
    (-reach..=reach).filter(|&offset| offset != 0)
}

/// Weights of the values at `points` in the polynomial through them, taken at `x`; 0 past the last point.
fn lagrange(x: f64, points: &[f64]) -> [f64; 4] {
    std::array::from_fn(|k| {
        let Some(point) = points.get(k) else { return 0.0 };
        let others = points.iter().enumerate().filter(|&(other, _)| other != k);
        others.map(|(_, other)| (x - other) / (point - other)).product()
    })
}
