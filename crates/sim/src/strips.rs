//! Pixel and emitter, both flat and of comparable size: four dimensions made three.
//!
//! The planes of pixel and emitter share a direction (that of the line in which they meet). Cut both into chords along it:
//! over two chords the line of sight v moves along one straight line, and the density of v on it is the convolution of two
//! intervals, a trapezoid. That integral is exact across every kink of the interpolant; over the two remaining coordinates,
//! one across each patch, the trapezoid's ends have smoothed the kinks, and an adaptive rule does the rest.

use std::f64::consts::FRAC_PI_2;

use glam::DVec3;

use crate::cubature;
use crate::patch::{self, Light, Patch, Scratch};
use crate::rules::Estimate;

/// Mean of `light` over all lines of sight p + e, p over `pixel` and e over `emitter`, with an error below `relative` of it
/// or below `floor` (lx), or a bound that says by how much it is not.
pub(crate) fn mean(
    light: Light<'_>,
    pixel: &Patch,
    emitter: &Patch,
    relative: f64,
    floor: f64,
    scratch: &mut Scratch,
) -> Estimate {
    let along = common_direction(pixel, emitter);
    let sides = [Side::of(pixel, along), Side::of(emitter, along)];
    let middle = pixel.centre() + emitter.centre();
    let [first, second] =
        [0, 1].map(|k: usize| sides[k].panels(light, middle, along, sides[1 - k].radius <= sides[k].radius));
    let mut starts = Vec::with_capacity(first.len() * second.len());
    for a in first.windows(2) {
        for b in second.windows(2) {
            starts.push([[a[0], a[1]], [b[0], b[1]]]);
        }
    }
    cubature::integral(&starts, relative, floor, |u| {
        let [(y, dy, p), (z, dz, e)] = [sides[0].chord(u[0]), sides[1].chord(u[1])];
        let across = dy * dz;
        if across == 0.0 {
            return 0.0;
        }
        let [from, to] = [p[0] + e[0], p[1] + e[1]];
        let edges = [p[0] + e[1], p[1] + e[0]];
        let plateau = [edges[0].min(edges[1]), edges[0].max(edges[1])];
        let origin = middle + y * sides[0].across + z * sides[1].across;
        across * patch::trapezoid(light, origin, along, [from, plateau[0], plateau[1], to], scratch)
    })
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
    radius: f64,
}

enum Outline {
    /// Corners (along, across) from the centre, in turn, and 1 over the area.
    Corners([[f64; 2]; 4], f64),
    /// Its radius.
    Disc(f64),
}

impl Side {
    fn of(patch: &Patch, along: DVec3) -> Self {
        let (first, second) = patch.sides();
        let across = first.cross(second).cross(along).normalize();
        let outline = match patch {
            Patch::Disc { .. } => Outline::Disc(first.length()),
            Patch::Parallelogram { .. } => {
                let corner = |s: f64, t: f64| {
                    let v = s * first + t * second;
                    [v.dot(along), v.dot(across)]
                };
                Outline::Corners(
                    [
                        corner(-0.5, -0.5),
                        corner(0.5, -0.5),
                        corner(0.5, 0.5),
                        corner(-0.5, 0.5),
                    ],
                    first.cross(second).length().recip(),
                )
            }
        };
        Self {
            across,
            outline,
            radius: patch.radius(),
        }
    }

    /// At parameter u: where the chord lies across, the density of u times 1/area, and its ends along.
    fn chord(&self, u: f64) -> (f64, f64, [f64; 2]) {
        match &self.outline {
            Outline::Disc(radius) => {
                let (sin, cos) = u.sin_cos();
                let half = radius * cos;
                (
                    radius * sin,
                    half / (std::f64::consts::PI * radius * radius),
                    [-half, half],
                )
            }
            Outline::Corners(corners, density) => {
                let mut ends = [f64::INFINITY, f64::NEG_INFINITY];
                for k in 0..4 {
                    let ([x0, y0], [x1, y1]) = (corners[k], corners[(k + 1) % 4]);
                    if (y0 <= u) != (y1 <= u) {
                        let x = x0 + (x1 - x0) * (u - y0) / (y1 - y0);
                        ends = [ends[0].min(x), ends[1].max(x)];
                    }
                }
                if ends[0] > ends[1] {
                    return (u, 0.0, [0.0; 2]);
                }
                (u, *density, ends)
            }
        }
    }

    /// Parameters between which chords change smoothly, rising; with `fine` also where a kink of the table, seen from the
    /// other patch's middle, begins to cross the patch.
    fn panels(&self, light: Light<'_>, middle: DVec3, along: DVec3, fine: bool) -> Vec<f64> {
        let mut across: Vec<f64> = match &self.outline {
            Outline::Disc(radius) => vec![-radius, *radius],
            Outline::Corners(corners, _) => corners.iter().map(|corner| corner[1]).collect(),
        };
        across.sort_by(f64::total_cmp);
        let (low, high) = (across[0], across[across.len() - 1]);
        let width = high - low;
        if fine {
            let mut touching = Vec::new();
            let corner = middle + low * self.across;
            patch::tangents(light.table, corner, along, width * self.across, &mut touching);
            // The line through the pole axis.
            let (a, b) = (corner.cross(along).z, self.across.cross(along).z);
            if b != 0.0 {
                touching.push(-a / b / width);
            }
            touching.retain(|t| *t > 0.0 && *t < 1.0);
            touching.sort_by(f64::total_cmp);
            let step = touching.len().div_ceil(24).max(1);
            across.extend(touching.iter().step_by(step).map(|t| low + t * width));
            across.sort_by(f64::total_cmp);
        }
        across.dedup_by(|b, a| *b - *a < 1e-9 * width);
        // The ends stay what they are.
        if let Some(last) = across.last_mut() {
            *last = high;
        }
        if let Outline::Disc(radius) = self.outline {
            for y in &mut across {
                *y = (*y / radius).clamp(-1.0, 1.0).asin().clamp(-FRAC_PI_2, FRAC_PI_2);
            }
        }
        across
    }
}
