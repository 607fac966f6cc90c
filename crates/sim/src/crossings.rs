//! The mean of the light over a parallelogram of lines of sight, exact across the kinks of the interpolant.
//!
//! Along a straight line of v the bilinear interpolant bends where the line crosses a half-plane C = C_i (a linear
//! equation) or a cone γ = γ_j (a monotone one, once the line is cut at its extremum of γ). Between the crossings
//! the integrand is analytic and a short Gauss rule is exact to rounding; the integral over the lines is adaptive.

use std::f64::consts::{PI, TAU};

use glam::DVec3;

use crate::angles::Sights;
use crate::patch::Light;
use crate::rules::{self, Estimate, K7, K15};
use crate::table::IntensityTable;

/// Working memory of the line splitter; one a thread.
#[derive(Debug, Default)]
pub(crate) struct Scratch {
    breaks: Vec<f64>,
    panels: Vec<f64>,
    pub sights: Vec<Sights>,
    pub cuts: Vec<f64>,
}

/// The most, in candela, that kinks of the table can make a line through the ball of `radius` round `centre` bend.
pub(crate) fn bend_within(table: &IntensityTable, centre: DVec3, radius: f64) -> f64 {
    let (distance, axis) = (centre.length(), centre.x.hypot(centre.y));
    if radius >= distance {
        return f64::INFINITY;
    }
    let gamma = axis.atan2(centre.z);
    let spread = (radius / distance).asin();
    let spread_c = if radius < axis { (radius / axis).asin() } else { PI };
    table.bend(gamma, spread, centre.y.atan2(centre.x), spread_c)
}

/// Mean of `light` over the parallelogram corner + s·first + t·second, with an error below `relative` of it or below
/// `floor` (lx) on each panel.
pub(crate) fn mean(
    light: Light<'_>,
    [corner, first, second]: [DVec3; 3],
    relative: f64,
    floor: f64,
    scratch: &mut Scratch,
) -> Estimate {
    let mut panels = std::mem::take(&mut scratch.panels);
    panels.clear();
    // The inner integral bends where a kink leaves through a side, and where a cone touches a line.
    breaks(light, corner, second, &mut scratch.breaks);
    panels.extend_from_slice(&scratch.breaks);
    breaks(light, corner + first, second, &mut scratch.breaks);
    panels.extend_from_slice(&scratch.breaks);
    tangents(light.table, corner, first, second, &mut panels);
    thin(&mut panels);
    let middle = corner + 0.5 * (first + second);
    let angular = (first.length() + second.length()) / middle.length().max(1e-300);
    let pair = if angular < 0.2 { K7 } else { K15 };
    let mut line = |t: f64| line_mean(light, corner + t * second, first, &mut scratch.breaks);
    let total = rules::adaptive(&mut line, pair, &panels, relative, floor, 24);
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

/// Mean of `light` along a + u·b, u in [0, 1].
fn line_mean(light: Light<'_>, a: DVec3, b: DVec3, scratch: &mut Vec<f64>) -> f64 {
    breaks(light, a, b, scratch);
    let mut sum = 0.0;
    for window in scratch.windows(2) {
        if window[1] > window[0] {
            sum += segment(light, a, b, [window[0], window[1]], &|_| 1.0, 40);
        }
    }
    sum
}

/// ∫ light·w dx along origin + x·along (a unit vector), where w rises from 0 at corners[0] with slope 1 to
/// corners[1], is even to corners[2] and falls to 0 at corners[3].
pub(crate) fn trapezoid(
    light: Light<'_>,
    origin: DVec3,
    along: DVec3,
    corners: [f64; 4],
    scratch: &mut Scratch,
) -> f64 {
    let length = corners[3] - corners[0];
    if length <= 0.0 {
        return 0.0;
    }
    let (a, b) = (origin + corners[0] * along, length * along);
    let [rise, fall] = [1, 2].map(|k: usize| (corners[k] - corners[0]) / length);
    breaks(light, a, b, &mut scratch.breaks);
    push(&mut scratch.breaks, rise);
    push(&mut scratch.breaks, fall);
    scratch.breaks.sort_by(f64::total_cmp);
    let weight = |u: f64| length * u.min(rise).min(1.0 - u);
    let mut sum = 0.0;
    for window in scratch.breaks.windows(2) {
        if window[1] > window[0] {
            sum += segment(light, a, b, [window[0], window[1]], &weight, 40);
        }
    }
    length * sum
}

/// ∫ weight·light over u in [from, to] with a Gauss rule that suits the distance to the nearest singularity: the
/// emitter itself and, because azimuth and polar angle are not smooth there, the pole axis.
fn segment(
    light: Light<'_>,
    a: DVec3,
    b: DVec3,
    [from, to]: [f64; 2],
    weight: &impl Fn(f64) -> f64,
    depth: u32,
) -> f64 {
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
        return segment(light, a, b, [from, middle], weight, depth - 1)
            + segment(light, a, b, [middle, to], weight, depth - 1);
    }
    let order = match ratio {
        r if r < 0.02 => 2,
        r if r < 0.1 => 3,
        r if r < 0.3 => 4,
        r if r < 0.7 => 6,
        _ => 9,
    };
    let width = to - from;
    width
        * rules::gauss(order)
            .iter()
            .map(|&(s, w)| {
                let u = from + width * s;
                w * weight(u) * light.at(a + u * b)
            })
            .sum::<f64>()
}

/// 0, every u in (0, 1) at which the interpolant bends along a + u·b, and 1; rising.
fn breaks(light: Light<'_>, a: DVec3, b: DVec3, out: &mut Vec<f64>) {
    let table = light.table;
    out.clear();
    out.push(0.0);
    // Light from behind the sensor's plane is none.
    let rise = light.toward.dot(b);
    if rise != 0.0 {
        push(out, -light.toward.dot(a) / rise);
    }
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

/// Keeps `u` if it lies between 0 and 1.
fn push(out: &mut Vec<f64>, u: f64) {
    if u > 0.0 && u < 1.0 {
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

/// The t in (0, 1) at which the line corner + t·second + s·first touches a cone γ = γ_j: the plane through the
/// emitter and the line has the normal N = (corner + t·second) × first, and touches the cone where N_z² = sin²γ
/// |N|².
pub(crate) fn tangents(table: &IntensityTable, corner: DVec3, first: DVec3, second: DVec3, out: &mut Vec<f64>) {
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
                push(out, t);
            }
        }
    }
}
