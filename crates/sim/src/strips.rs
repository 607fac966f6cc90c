//! Pixel and emitter, both flat and of comparable size: four dimensions made three.
//!
//! The planes of pixel and emitter share a direction (that of the line in which they meet). Cut both into chords along
//! it: over two chords the line of sight v moves along one straight line, and the density of v on it is the convolution
//! of two intervals, a trapezoid. That integral is exact across every kink of the interpolant; over the two remaining
//! coordinates, one across each patch, the trapezoid's ends have smoothed the kinks, and an adaptive rule does the
//! rest.

use glam::DVec3;

use crate::crossings::{self, Scratch};
use crate::cubature::{self, WorkLimit};
use crate::patch::{Light, Patch};
use crate::rules::Estimate;

/// Mean of `light` over all lines of sight p + e, p over `pixel` and e over `emitter`, with an error below `relative`
/// of it or below `floor` (lx), or a bound that says by how much it is not. `leaves`: whether places are also taken along
/// leaves of even turn.
pub(crate) fn mean(
    light: Light<'_>,
    pixel: &Patch,
    emitter: &Patch,
    [relative, floor]: [f64; 2],
    leaves: bool,
    scratch: &mut Scratch,
) -> Estimate {
    let along = common_direction(pixel, emitter);
    let mut sides = [Side::of(pixel, along), Side::of(emitter, along)];
    let middle = pixel.centre() + emitter.centre();
    // Lines of sight behind the sensor's plane carry no light: the height above it changes across the emitter alone.
    let (height, rise) = (light.toward.dot(middle), light.toward.dot(sides[1].across));
    let horizon = -height / rise;
    if rise != 0.0 && horizon.abs() < sides[1].half_width() {
        sides[1].ends.push(horizon);
        sides[1].ends.sort_by(f64::total_cmp);
    }
    let fan = Fan::new(middle, along, &sides);
    let kinks = Fan::kinks(light.table.gamma_kinks());
    let mut panes = Vec::new();
    for y in sides[0].ends.windows(2) {
        for z in sides[1].ends.windows(2) {
            if height + 0.5 * (z[0] + z[1]) * rise > 0.0 {
                panes.push([[y[0], y[1]], [z[0], z[1]]]);
            }
        }
    }
    let per_area = 1.0 / (sides[0].area * sides[1].area);
    let mut chords = |[y, z]: [f64; 2]| {
        let [p, e] = [sides[0].chord(y), sides[1].chord(z)];
        let [from, to] = [p[0] + e[0], p[1] + e[1]];
        let edges = [p[0] + e[1], p[1] + e[0]];
        let plateau = [edges[0].min(edges[1]), edges[0].max(edges[1])];
        let origin = middle + y * sides[0].across + z * sides[1].across;
        per_area * crossings::trapezoid(light, origin, along, [from, plateau[0], plateau[1], to], scratch)
    };
    // Few kinks, or one side far smaller than the other: the chords' own places serve.
    let larger = usize::from(sides[1].half_width() > sides[0].half_width());
    let mut starts = Vec::new();
    for pane in &panes {
        let mut ends = [0, 1].map(|k: usize| pane[k].to_vec());
        ends[larger].extend(fan.crossings(larger, pane[larger], &kinks));
        let ends = [0, 1].map(|k: usize| fan.parameters(k, std::mem::take(&mut ends[k])));
        for a in ends[0].windows(2) {
            starts.extend(ends[1].windows(2).map(|b| [[a[0], a[1]], [b[0], b[1]]]));
        }
    }
    let found = cubature::integral(&starts, relative, floor, SHORT, |_, u| {
        let [(y, dy), (z, dz)] = [0, 1].map(|k: usize| fan.place(k, u[k]));
        dy * dz * chords([y, z])
    });
    if !leaves || found.error <= floor.max(relative * found.value.abs()) {
        return found;
    }
    // Many kinks across both: along leaves of even turn.
    let mut starts = Vec::new();
    let mut of_start = Vec::new();
    for pane in panes {
        for turn in fan.turns(pane, &kinks).windows(2) {
            starts.push([[turn[0], turn[1]], [0.0, 1.0]]);
            of_start.push(pane);
        }
    }
    let fanned = cubature::integral(&starts, relative, floor, LONG, |start, [turn, share]| {
        fan.leaf(of_start[start], turn, share)
            .map_or(0.0, |(place, density)| density * chords(place))
    });
    if fanned.error < found.error { fanned } else { found }
}

/// For the chords' own places: bounds fall with the cells to the power of 2 to 3.
const SHORT: WorkLimit = WorkLimit {
    cells: 2000,
    hopeless: 200.0,
};
/// For leaves.
const LONG: WorkLimit = WorkLimit {
    cells: 3000,
    hopeless: f64::INFINITY,
};

/// Pairs of chords, sorted by the turn ψ of the plane through emitter and line of sight: over a line at turn ψ, γ does
/// not fall below |ψ|, so that lines touch the cone of a kink γ_j at ψ = ±γ_j and nowhere else.
struct Fan {
    /// Middle and both sides' directions, in the plane across the chords: (height, width).
    middle: [f64; 2],
    across: [[f64; 2]; 2],
    /// The side that moves along a leaf ψ = const; the other one turns ψ.
    leaf: usize,
    /// Radius of a side that is a disc.
    radius: [Option<f64>; 2],
}

impl Fan {
    fn new(middle: DVec3, along: DVec3, sides: &[Side; 2]) -> Self {
        let wide = DVec3::Z.cross(along);
        let flat = |v: DVec3| [v.z, v.dot(wide)];
        let middle = flat(middle);
        let across = [0, 1].map(|k: usize| flat(sides[k].across));
        let swing = [0, 1].map(|k: usize| cross(middle, across[k]).abs());
        // A disc's chords are smooth in its own angle, which a leaf can follow.
        let leaf = usize::from(swing[0] > 0.2 * swing[1]);
        let radius = [0, 1].map(|k: usize| match sides[k].outline {
            Outline::Disc(radius) => Some(radius),
            Outline::Corners(_) => None,
        });
        Self {
            middle,
            across,
            leaf,
            radius,
        }
    }

    fn at(&self, yz: [f64; 2]) -> [f64; 2] {
        [0, 1].map(|k: usize| self.middle[k] + yz[0] * self.across[0][k] + yz[1] * self.across[1][k])
    }

    /// Turns between −π and π at which a cone of a kink is touched, and the pole crossed.
    fn kinks(gamma_kinks: &[f64]) -> Vec<f64> {
        let mut turns = vec![0.0];
        turns.extend(gamma_kinks.iter().flat_map(|kink| [*kink, -kink]));
        turns.sort_by(f64::total_cmp);
        turns
    }

    /// Places on side `k` between `ends`, the other side's middle opposite, at which a kink is touched; not more than
    /// 24.
    fn crossings(&self, k: usize, [low, high]: [f64; 2], kinks: &[f64]) -> Vec<f64> {
        let mut places: Vec<f64> = kinks
            .iter()
            .flat_map(|kink| [*kink, kink + std::f64::consts::PI])
            .filter_map(|turn| {
                let (sin, cos) = turn.sin_cos();
                let place = -cross(self.middle, [cos, sin]) / cross(self.across[k], [cos, sin]);
                let ahead = self.middle[0] * cos
                    + self.middle[1] * sin
                    + place * (self.across[k][0] * cos + self.across[k][1] * sin);
                (place > low && place < high && ahead > 0.0).then_some(place)
            })
            .collect();
        places.sort_by(f64::total_cmp);
        let step = places.len().div_ceil(24).max(1);
        places.into_iter().step_by(step).collect()
    }

    /// Parameters of places on side `k`, rising: the place, or the angle on a disc.
    fn parameters(&self, k: usize, mut places: Vec<f64>) -> Vec<f64> {
        places.sort_by(f64::total_cmp);
        if let Some(radius) = self.radius[k] {
            for place in &mut places {
                *place = (*place / radius).clamp(-1.0, 1.0).asin();
            }
        }
        places.dedup();
        places
    }

    /// The place at a parameter, and places per parameter.
    fn place(&self, k: usize, parameter: f64) -> (f64, f64) {
        self.radius[k].map_or((parameter, 1.0), |radius| {
            (radius * parameter.sin(), radius * parameter.cos())
        })
    }

    /// Ends of the turns of a pane, its corners and the kinks in between, rising.
    fn turns(&self, [y, z]: [[f64; 2]; 2], kinks: &[f64]) -> Vec<f64> {
        let mut turns = Vec::new();
        for y in y {
            for z in z {
                let [height, width] = self.at([y, z]);
                turns.push(width.atan2(height));
            }
        }
        turns.sort_by(f64::total_cmp);
        let (low, high) = (turns[0], turns[3]);
        let within: Vec<f64> = kinks
            .iter()
            .copied()
            .filter(|kink| *kink > low && *kink < high)
            .collect();
        let step = within.len().div_ceil(40).max(1);
        turns.extend(within.into_iter().step_by(step));
        turns.sort_by(f64::total_cmp);
        turns.dedup_by(|b, a| *b - *a < 1e-9 * (high - low));
        if let Some(last) = turns.last_mut() {
            *last = high;
        }
        turns
    }

    /// The place (y, z) at `share` of the leaf at `turn` within a pane, and the area per turn and share. `None` off the
    /// pane.
    fn leaf(&self, pane: [[f64; 2]; 2], turn: f64, share: f64) -> Option<([f64; 2], f64)> {
        let (leaf, other) = (self.leaf, 1 - self.leaf);
        let (sin, cos) = turn.sin_cos();
        let direction = [cos, sin];
        // (middle + l·leaf + w·other) × direction = 0: w = (a + b·l).
        let per = cross(self.across[other], direction);
        let a = -cross(self.middle, direction) / per;
        let b = -cross(self.across[leaf], direction) / per;
        let [mut low, mut high] = pane[leaf];
        if b == 0.0 {
            if a < pane[other][0] || a > pane[other][1] {
                return None;
            }
        } else {
            let ends = pane[other].map(|w| (w - a) / b);
            low = low.max(ends[0].min(ends[1]));
            high = high.min(ends[0].max(ends[1]));
        }
        if low >= high {
            return None;
        }
        let (l, density) = if let Some(radius) = self.radius[leaf] {
            let [from, to] = [low, high].map(|l| (l / radius).clamp(-1.0, 1.0).asin());
            let angle = from + (to - from) * share;
            (radius * angle.sin(), (to - from) * radius * angle.cos())
        } else if self.radius[other].is_some() {
            // Chords of a disc end like roots, which this makes smooth.
            let smooth = share * share * (3.0 - 2.0 * share);
            (low + (high - low) * smooth, (high - low) * 6.0 * share * (1.0 - share))
        } else {
            (low + (high - low) * share, high - low)
        };
        let mut place = [0.0; 2];
        place[leaf] = l;
        place[other] = a + b * l;
        let v = self.at(place);
        let per_turn = (v[0] * v[0] + v[1] * v[1]) / cross(v, self.across[other]).abs();
        Some((place, density * per_turn))
    }
}

fn cross(a: [f64; 2], b: [f64; 2]) -> f64 {
    a[0] * b[1] - a[1] * b[0]
}

/// Unit vector within both planes.
fn common_direction(pixel: &Patch, emitter: &Patch) -> DVec3 {
    let [n, m] = [pixel, emitter].map(|patch| {
        let (first, second) = patch.sides();
        first.cross(second).normalize()
    });
    let cross = n.cross(m);
    if cross.length() > 1e-9 {
        return cross.normalize();
    }
    // Parallel planes: any direction will do; a side of a rectangle makes its chords equal.
    match (pixel, emitter) {
        (_, Patch::Parallelogram { first, .. })
        | (Patch::Parallelogram { first, .. } | Patch::Disc { first, .. }, _) => first.normalize(),
    }
}

/// A patch cut into chords along a direction.
struct Side {
    /// Unit vector across the chords, in the patch's plane.
    across: DVec3,
    outline: Outline,
    area: f64,
    /// Places across between which chords change smoothly, rising.
    ends: Vec<f64>,
}

enum Outline {
    /// Corners (along, across) from the centre, in turn.
    Corners([[f64; 2]; 4]),
    /// Its radius.
    Disc(f64),
}

impl Side {
    fn of(patch: &Patch, along: DVec3) -> Self {
        let (first, second) = patch.sides();
        let normal = first.cross(second);
        let across = normal.cross(along).normalize();
        match patch {
            Patch::Disc { .. } => {
                let radius = first.length();
                Self {
                    across,
                    outline: Outline::Disc(radius),
                    area: std::f64::consts::PI * normal.length(),
                    ends: vec![-radius, radius],
                }
            }
            Patch::Parallelogram { .. } => {
                let corner = |s: f64, t: f64| {
                    let v = s * first + t * second;
                    [v.dot(along), v.dot(across)]
                };
                let corners = [
                    corner(-0.5, -0.5),
                    corner(0.5, -0.5),
                    corner(0.5, 0.5),
                    corner(-0.5, 0.5),
                ];
                let mut ends: Vec<f64> = corners.iter().map(|corner| corner[1]).collect();
                ends.sort_by(f64::total_cmp);
                let width = ends[3] - ends[0];
                ends.dedup_by(|b, a| *b - *a < 1e-9 * width);
                Self {
                    across,
                    outline: Outline::Corners(corners),
                    area: normal.length(),
                    ends,
                }
            }
        }
    }

    fn half_width(&self) -> f64 {
        self.ends.last().copied().unwrap_or(0.0)
    }

    /// Ends along of the chord that lies at `y` across.
    fn chord(&self, y: f64) -> [f64; 2] {
        match &self.outline {
            Outline::Disc(radius) => {
                let half = (radius * radius - y * y).max(0.0).sqrt();
                [-half, half]
            }
            Outline::Corners(corners) => {
                let mut ends = [f64::INFINITY, f64::NEG_INFINITY];
                for k in 0..4 {
                    let ([x0, y0], [x1, y1]) = (corners[k], corners[(k + 1) % 4]);
                    if (y0 <= y) != (y1 <= y) {
                        let x = x0 + (x1 - x0) * (y - y0) / (y1 - y0);
                        ends = [ends[0].min(x), ends[1].max(x)];
                    }
                }
                if ends[0] > ends[1] { [0.0; 2] } else { ends }
            }
        }
    }
}
