//! The mean of the direct irradiance over a flat patch of lines of sight, exact across the kinks of the interpolant.
//!
//! Light from an emitter point e reaches the sensor point p along v = p − e, and both the pixel and the emitter are flat,
//! so v runs over a flat parallelogram or disc while p or e runs over its own. Along a straight line of v the bilinear
//! interpolant bends where the line crosses a half-plane C = C_i (a linear equation) or a cone γ = γ_j (a monotone one, once
//! the line is cut at its extremum of γ). Between the crossings the integrand is analytic and a short Gauss rule is exact to
//! rounding; the integral over the lines is adaptive.

use std::f64::consts::{PI, TAU};

use glam::DVec3;

use crate::rules::{self, Estimate, K7, K15};
use crate::table::Table;

/// The integrand: irradiance in lx on a surface that faces along −`toward`, for a line of sight v in mm.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Light<'a> {
    pub table: &'a Table,
    /// Unit vector R·(0, 0, 1): the cosine of incidence is its product with the direction of light.
    pub toward: DVec3,
    /// Light that the path swallows, 1/mm.
    pub extinction_per_mm: f64,
}

impl Light<'_> {
    /// I(v)·cos α / |v|² in lx; zero where the surface is lit from behind.
    #[inline]
    pub fn at(&self, v: DVec3) -> f64 {
        let projected = self.toward.dot(v);
        if projected <= 0.0 {
            return 0.0;
        }
        let square = v.length_squared();
        let length = square.sqrt();
        let light = 1e6 * self.table.toward(v) * projected / (square * length);
        if self.extinction_per_mm == 0.0 {
            light
        } else {
            light * (-self.extinction_per_mm * length).exp()
        }
    }
}

/// A flat set of lines of sight, in mm.
#[derive(Debug, Clone, Copy)]
pub(crate) enum Patch {
    /// v = corner + s·first + t·second, s and t in [0, 1].
    Parallelogram { corner: DVec3, first: DVec3, second: DVec3 },
    /// v = centre + x·first + y·second, x² + y² ≤ 1 (the vectors have the disc's radius as their length).
    Disc { centre: DVec3, first: DVec3, second: DVec3 },
}

impl Patch {
    pub fn centre(&self) -> DVec3 {
        match *self {
            Self::Parallelogram { corner, first, second } => corner + 0.5 * (first + second),
            Self::Disc { centre, .. } => centre,
        }
    }

    /// Radius of a ball round the centre that holds the patch.
    pub fn radius(&self) -> f64 {
        match *self {
            Self::Parallelogram { first, second, .. } => 0.5 * (first + second).length().max((first - second).length()),
            Self::Disc { first, .. } => first.length(),
        }
    }

    pub fn shifted(&self, by: DVec3) -> Self {
        match *self {
            Self::Parallelogram { corner, first, second } => Self::Parallelogram {
                corner: corner + by,
                first,
                second,
            },
            Self::Disc { centre, first, second } => Self::Disc {
                centre: centre + by,
                first,
                second,
            },
        }
    }

    /// The patch with every vector mapped (a rotation).
    pub fn mapped(&self, by: impl Fn(DVec3) -> DVec3) -> Self {
        match *self {
            Self::Parallelogram { corner, first, second } => Self::Parallelogram {
                corner: by(corner),
                first: by(first),
                second: by(second),
            },
            Self::Disc { centre, first, second } => Self::Disc {
                centre: by(centre),
                first: by(first),
                second: by(second),
            },
        }
    }

    /// Nodes (offset from the centre) and weights, sum 1, of a product rule of `n` points a side (disc: n radii, 2n + 2
    /// azimuths), exact for polynomials up to degree 2n − 1 at least.
    pub fn nodes(&self, n: usize, out: &mut Vec<(DVec3, f64)>) {
        out.clear();
        match *self {
            Self::Parallelogram { first, second, .. } => {
                for &(s, ws) in rules::gauss(n) {
                    for &(t, wt) in rules::gauss(n) {
                        out.push(((s - 0.5) * first + (t - 0.5) * second, ws * wt));
                    }
                }
            }
            Self::Disc { first, second, .. } => {
                let azimuths = 2 * n + 2;
                for (ring, &(area, w)) in rules::gauss(n).iter().enumerate() {
                    let radius = area.sqrt();
                    for k in 0..azimuths {
                        let turn = 0.5 * (ring % 2) as f64 + 0.25;
                        let azimuth = TAU * (k as f64 + turn) / azimuths as f64;
                        out.push((
                            radius * (azimuth.cos() * first + azimuth.sin() * second),
                            w / azimuths as f64,
                        ));
                    }
                }
            }
        }
    }
}

/// Working memory of the line splitter; one a thread.
#[derive(Debug, Default)]
pub(crate) struct Scratch {
    breaks: Vec<f64>,
    panels: Vec<f64>,
}

/// Whether a kink of the table or its pole can lie within the ball of `radius` round `centre`.
pub(crate) fn may_bend(table: &Table, centre: DVec3, radius: f64) -> bool {
    let distance = centre.length();
    if radius >= distance {
        return true;
    }
    let axis = centre.x.hypot(centre.y);
    if axis <= radius {
        return true;
    }
    let gamma = axis.atan2(centre.z);
    let spread = (radius / distance).asin() * (1.0 + 1e-9) + 1e-12;
    let kinks = table.gamma_kinks();
    let first = kinks.partition_point(|&kink| kink < gamma - spread);
    if first < kinks.len() && kinks[first] <= gamma + spread {
        return true;
    }
    if table.is_rotational() {
        return false;
    }
    let c = centre.y.atan2(centre.x);
    let spread = (radius / axis).asin() * (1.0 + 1e-9) + 1e-12;
    any_azimuth(table.c_kinks(), c - spread, c + spread)
}

fn any_azimuth(kinks: &[f64], from: f64, to: f64) -> bool {
    let turn = from.div_euclid(TAU) * TAU;
    let (low, high) = (from - turn, to - turn);
    let first = kinks.partition_point(|&kink| kink < low);
    (first < kinks.len() && kinks[first] <= high) || kinks.first().is_some_and(|kink| kink + TAU <= high)
}

/// Mean of `light` over `patch`. `relative` is the error wished for, relative to the mean.
pub(crate) fn mean(light: Light<'_>, patch: &Patch, relative: f64, scratch: &mut Scratch) -> Estimate {
    let mut panels = std::mem::take(&mut scratch.panels);
    panels.clear();
    let mut total = Estimate::default();
    match *patch {
        Patch::Parallelogram { corner, first, second } => {
            // The inner integral bends where a kink leaves through a side, and where a cone touches a line.
            breaks(light.table, corner, second, &mut scratch.breaks);
            panels.extend_from_slice(&scratch.breaks);
            breaks(light.table, corner + first, second, &mut scratch.breaks);
            panels.extend_from_slice(&scratch.breaks);
            tangents(light.table, corner, first, second, 0.0, &mut panels);
            thin(&mut panels);
            let pair = if angular(patch) < 0.2 { K7 } else { K15 };
            let mut line = |t: f64| line_mean(light, corner + t * second, first, &mut scratch.breaks);
            let tolerance = relative * line(0.5).abs();
            for window in panels.windows(2) {
                if window[1] - window[0] > 1e-13 {
                    total.add(rules::adaptive(&mut line, pair, window[0], window[1], tolerance, 24));
                }
            }
        }
        Patch::Disc { centre, first, second } => {
            rim(light.table, centre, first, second, &mut panels);
            tangents(light.table, centre, first, second, -1.0, &mut panels);
            thin(&mut panels);
            let mut chord = |y: f64| {
                let half = (1.0 - y * y).max(0.0).sqrt();
                2.0 * half / PI
                    * line_mean(
                        light,
                        centre + y * second - half * first,
                        2.0 * half * first,
                        &mut scratch.breaks,
                    )
            };
            let tolerance = relative * chord(0.0).abs();
            for window in panels.windows(2) {
                let (from, width) = (window[0], window[1] - window[0]);
                if width > 1e-13 {
                    // Roots at the ends of a panel (the rim, a touching cone) become polynomials in s.
                    let mut panel =
                        |s: f64| 6.0 * s * (1.0 - s) * width * chord(from + width * s * s * (3.0 - 2.0 * s));
                    total.add(rules::adaptive(&mut panel, K15, 0.0, 1.0, tolerance, 24));
                }
            }
        }
    }
    scratch.panels = panels;
    total
}

/// Sorts the panels. A fine table has many weak kinks: halving then costs less than a panel for each.
fn thin(panels: &mut Vec<f64>) {
    panels.sort_by(f64::total_cmp);
    let excess = panels.len() / 48;
    if excess > 0 {
        let last = panels.len() - 1;
        let mut index = 0;
        panels.retain(|_| {
            index += 1;
            (index - 1) % (excess * 4) == 0 || index - 1 == last
        });
    }
}

/// −1, 1 and every y at which a kink crosses the rim of the disc, or the chord passes the pole. The disc lies in a plane
/// z = const, so that both kinds of kink are α + β·cos φ + δ·sin φ = 0 along the rim.
fn rim(table: &Table, centre: DVec3, first: DVec3, second: DVec3, out: &mut Vec<f64>) {
    out.extend([-1.0, 1.0]);
    push_between(
        out,
        -centre.truncate().dot(second.truncate()) / second.length_squared(),
        -1.0,
    );
    let mut solve = |alpha: f64, beta: f64, delta: f64| {
        let size = beta.hypot(delta);
        if alpha.abs() < size {
            let (phase, half) = (delta.atan2(beta), (-alpha / size).acos());
            push_between(out, (phase + half).sin(), -1.0);
            push_between(out, (phase - half).sin(), -1.0);
        }
    };
    for &kink in table.c_kinks() {
        let (sin, cos) = kink.sin_cos();
        let across = |v: DVec3| v.x * sin - v.y * cos;
        solve(across(centre), across(first), across(second));
    }
    let square = centre.length_squared() + first.length_squared();
    for &kink in table.gamma_kinks() {
        let cosine = kink.cos() * kink.cos();
        solve(
            cosine * square - centre.z * centre.z,
            2.0 * cosine * centre.dot(first),
            2.0 * cosine * centre.dot(second),
        );
    }
}

/// Size of the patch against its distance from the emitter and from the pole axis: what decides the rules' order.
fn angular(patch: &Patch) -> f64 {
    let centre = patch.centre();
    let radius = patch.radius();
    2.0 * radius / (centre.length() - radius).max(1e-300)
}

/// Mean of `light` along a + u·b, u in [0, 1].
fn line_mean(light: Light<'_>, a: DVec3, b: DVec3, scratch: &mut Vec<f64>) -> f64 {
    breaks(light.table, a, b, scratch);
    let mut sum = 0.0;
    for window in scratch.windows(2) {
        if window[1] > window[0] {
            sum += segment(light, a, b, window[0], window[1], 40);
        }
    }
    sum
}

/// ∫ over u in [from, to] with a Gauss rule that suits the distance to the nearest singularity: the emitter itself and,
/// because azimuth and polar angle are not smooth there, the pole axis.
fn segment(light: Light<'_>, a: DVec3, b: DVec3, from: f64, to: f64, depth: u32) -> f64 {
    let length = (to - from) * b.length();
    let nearest = |square: f64, product: f64| {
        if square > 0.0 {
            (-product / square).clamp(from, to)
        } else {
            from
        }
    };
    let to_emitter = (a + nearest(b.length_squared(), a.dot(b)) * b).length();
    let (axy, bxy) = (a.truncate(), b.truncate());
    let to_axis = (axy + nearest(bxy.length_squared(), axy.dot(bxy)) * bxy).length();
    let ratio = length / to_emitter.min(to_axis).max(1e-300);
    if ratio > 1.0 && depth > 0 {
        let middle = 0.5 * (from + to);
        return segment(light, a, b, from, middle, depth - 1) + segment(light, a, b, middle, to, depth - 1);
    }
    let order = match ratio {
        r if r < 0.01 => 2,
        r if r < 0.06 => 3,
        r if r < 0.2 => 4,
        r if r < 0.5 => 6,
        _ => 9,
    };
    let width = to - from;
    width
        * rules::gauss(order)
            .iter()
            .map(|&(u, w)| w * light.at(a + (from + width * u) * b))
            .sum::<f64>()
}

/// 0, every u in (0, 1) at which the interpolant bends along a + u·b, and 1; rising.
fn breaks(table: &Table, a: DVec3, b: DVec3, out: &mut Vec<f64>) {
    out.clear();
    out.push(0.0);
    let end = a + b;
    let square = b.x * b.x + b.y * b.y;
    if square > 0.0 {
        // Closest to the pole axis, where azimuth turns fastest.
        push(out, -(a.x * b.x + a.y * b.y) / square);
    }
    if !table.c_kinks().is_empty() {
        let from = a.y.atan2(a.x);
        let mut turn = end.y.atan2(end.x) - from;
        if turn > PI {
            turn -= TAU;
        } else if turn < -PI {
            turn += TAU;
        }
        let (low, high) = if turn < 0.0 {
            (from + turn, from)
        } else {
            (from, from + turn)
        };
        each_azimuth(table.c_kinks(), low, high, |kink| {
            let (sin, cos) = kink.sin_cos();
            let slope = b.x * sin - b.y * cos;
            if slope != 0.0 {
                push(out, -(a.x * sin - a.y * cos) / slope);
            }
        });
    }
    let kinks = table.gamma_kinks();
    if !kinks.is_empty() {
        let gamma = |u: f64| {
            let v = a + u * b;
            v.x.hypot(v.y).atan2(v.z)
        };
        // γ along a straight line has one extremum.
        let (ab, aa, bb) = (a.dot(b), a.length_squared(), b.length_squared());
        let turning = (b.z * aa - a.z * ab) / (a.z * bb - b.z * ab);
        let middle = if turning > 0.0 && turning < 1.0 { turning } else { 1.0 };
        push(out, middle);
        for (from, to) in [(0.0, middle), (middle, 1.0)] {
            if to > from {
                let (g0, g1) = (gamma(from), gamma(to));
                let first = kinks.partition_point(|&kink| kink <= g0.min(g1));
                for &kink in kinks[first..].iter().take_while(|&&kink| kink < g0.max(g1)) {
                    push(out, crossing(a, b, kink.cos(), from, to));
                }
            }
        }
    }
    out.push(1.0);
    out.sort_by(f64::total_cmp);
}

fn push(out: &mut Vec<f64>, u: f64) {
    push_between(out, u, 0.0);
}

/// Keeps `u` if it lies between `low` and 1.
fn push_between(out: &mut Vec<f64>, u: f64, low: f64) {
    if u > low && u < 1.0 {
        out.push(u);
    }
}

fn each_azimuth(kinks: &[f64], from: f64, to: f64, mut found: impl FnMut(f64)) {
    let turn = from.div_euclid(TAU) * TAU;
    let (low, high) = (from - turn, to - turn);
    let first = kinks.partition_point(|&kink| kink < low);
    for &kink in kinks[first..].iter().take_while(|&&kink| kink <= high) {
        found(kink);
    }
    for &kink in kinks.iter().take_while(|&&kink| kink + TAU <= high) {
        found(kink);
    }
}

/// The u in [from, to] at which v = a + u·b has cos γ = `cosine`; γ is monotone there. Newton kept inside a bracket.
fn crossing(a: DVec3, b: DVec3, cosine: f64, from: f64, to: f64) -> f64 {
    let above = |u: f64| {
        let v = a + u * b;
        let length = v.length();
        (v.z - cosine * length, b.z - cosine * v.dot(b) / length)
    };
    let (mut low, mut high) = (from, to);
    let rising = above(low).0 < 0.0;
    let mut u = 0.5 * (low + high);
    for _ in 0..60 {
        let (value, slope) = above(u);
        if (value < 0.0) == rising {
            low = u;
        } else {
            high = u;
        }
        let newton = u - value / slope;
        let next = if newton > low && newton < high {
            newton
        } else {
            0.5 * (low + high)
        };
        if (next - u).abs() < 1e-15 || high - low < 1e-15 {
            return next;
        }
        u = next;
    }
    u
}

/// The t in (low, 1) at which the line corner + t·second + s·first touches a cone γ = γ_j: the plane through the emitter and
/// the line has the normal N = (corner + t·second) × first, and touches the cone where N_z² = sin²γ |N|².
fn tangents(table: &Table, corner: DVec3, first: DVec3, second: DVec3, low: f64, out: &mut Vec<f64>) {
    let (n0, n1) = (corner.cross(first), second.cross(first));
    for &kink in table.gamma_kinks() {
        let sine = kink.sin() * kink.sin();
        let a = n1.z * n1.z - sine * n1.length_squared();
        let b = n0.z * n1.z - sine * n0.dot(n1);
        let c = n0.z * n0.z - sine * n0.length_squared();
        let root = b * b - a * c;
        if root >= 0.0 {
            let q = -(b + root.sqrt().copysign(b));
            for t in [q / a, c / q] {
                push_between(out, t, low);
            }
        }
    }
}
