//! Azimuth and polar angle in the vector units: arc tangents without a call or a branch, in f64.

use std::f64::consts::{FRAC_PI_2, FRAC_PI_4, PI};

use glam::DVec3;

/// Numbers side by side in the vector units (eight f64 fill AVX-512).
pub(crate) const LANES: usize = 8;

/// A number for each lane.
pub(crate) type Lanes = [f64; LANES];

/// tan(π/8): above it the quotient is turned by π/4.
const FAR: f64 = 0.414_213_562_373_095_03;

/// arctan(t)/t in t² on |t| ≤ tan(π/8): Chebyshev fit of degree 9, relative error 2e-15.
const SERIES: [f64; 10] = [
    0.999_999_999_999_998_3,
    -0.333_333_333_331_883_53,
    0.199_999_999_748_375_76,
    -0.142_857_124_913_742_4,
    0.111_110_444_742_678_45,
    -0.090_894_641_400_933_17,
    0.076_729_395_053_082_84,
    -0.065_027_831_575_594_04,
    0.050_153_798_808_679_76,
    -0.025_200_771_920_771_1,
];

/// The angle of (x, y) in [−π, π], absolute error below 1e-15; 0 at the origin.
#[inline(always)]
#[expect(
    clippy::inline_always,
    reason = "inside multiversioned loops, or they would not be vectorised"
)]
pub(crate) fn atan2(y: f64, x: f64) -> f64 {
    let (up, along) = (y.abs(), x.abs());
    let steep = up > along;
    let (low, high) = if steep { (along, up) } else { (up, along) };
    let far = low > FAR * high;
    let (above, below) = if far { (low - high, low + high) } else { (low, high) };
    let t = above / if below > 1e-300 { below } else { 1e-300 };
    let z = t * t;
    // Even and odd powers apart: two short chains of operations instead of a long one.
    let w = z * z;
    let (mut even, mut odd) = (SERIES[8], SERIES[9]);
    for k in (0..4).rev() {
        even = even * w + SERIES[2 * k];
        odd = odd * w + SERIES[2 * k + 1];
    }
    let series = even + z * odd;
    let octant = t * series + if far { FRAC_PI_4 } else { 0.0 };
    let quarter = if steep { FRAC_PI_2 - octant } else { octant };
    let half = if x < 0.0 { PI - quarter } else { quarter };
    if y < 0.0 { -half } else { half }
}

/// Lines of sight along a straight line.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Sights {
    /// Polar angles.
    pub gamma: Lanes,
    /// Azimuths in [−π, π].
    pub c: Lanes,
    /// 1e6·cos α / R², 1/m² for lengths in mm.
    pub per_cd: Lanes,
    /// R in mm.
    pub length: Lanes,
}

/// Angles of v = a + x·b + y·c, and what one candela makes there on a face towards `toward`.
#[multiversion::multiversion(targets(
    "x86_64+avx512f+avx512dq+avx512bw+avx512vl+avx2+fma",
    "x86_64+avx2+fma",
    "aarch64+neon"
))]
pub(crate) fn across(a: DVec3, [b, c]: [DVec3; 2], toward: DVec3, x: &Lanes, y: &Lanes) -> Sights {
    let mut out = Sights {
        gamma: [0.0; LANES],
        c: [0.0; LANES],
        per_cd: [0.0; LANES],
        length: [0.0; LANES],
    };
    let (a, b, c, toward) = (a.to_array(), b.to_array(), c.to_array(), toward.to_array());
    for lane in 0..LANES {
        let vx = a[0] + x[lane] * b[0] + y[lane] * c[0];
        let vy = a[1] + x[lane] * b[1] + y[lane] * c[1];
        let vz = a[2] + x[lane] * b[2] + y[lane] * c[2];
        let across = vx * vx + vy * vy;
        let square = across + vz * vz;
        let length = square.sqrt();
        let projected = toward[0] * vx + toward[1] * vy + toward[2] * vz;
        out.gamma[lane] = atan2(across.sqrt(), vz);
        out.c[lane] = atan2(vy, vx);
        out.length[lane] = length;
        out.per_cd[lane] = 1e6 * (if projected > 0.0 { projected } else { 0.0 }) / (square * length);
    }
    out
}

/// Angles of v = sight + offset, and weight·1e6·cos α / R² on a face towards `toward`, lane by lane.
#[multiversion::multiversion(targets(
    "x86_64+avx512f+avx512dq+avx512bw+avx512vl+avx2+fma",
    "x86_64+avx2+fma",
    "aarch64+neon"
))]
pub(crate) fn around(sight: DVec3, offsets: [&[Lanes]; 3], weights: &[Lanes], toward: DVec3, out: &mut Vec<Sights>) {
    let (sight, toward) = (sight.to_array(), toward.to_array());
    out.clear();
    for (((xs, ys), zs), ws) in offsets[0].iter().zip(offsets[1]).zip(offsets[2]).zip(weights) {
        let mut sights = Sights {
            gamma: [0.0; LANES],
            c: [0.0; LANES],
            per_cd: [0.0; LANES],
            length: [0.0; LANES],
        };
        for lane in 0..LANES {
            let (x, y, z) = (sight[0] + xs[lane], sight[1] + ys[lane], sight[2] + zs[lane]);
            let across = x * x + y * y;
            let square = across + z * z;
            let length = square.sqrt();
            let projected = toward[0] * x + toward[1] * y + toward[2] * z;
            sights.gamma[lane] = atan2(across.sqrt(), z);
            sights.c[lane] = atan2(y, x);
            sights.length[lane] = length;
            sights.per_cd[lane] = ws[lane] * 1e6 * (if projected > 0.0 { projected } else { 0.0 }) / (square * length);
        }
        out.push(sights);
    }
}

#[cfg(test)]
mod tests {
    use std::f64::consts::TAU;

    use super::*;

    #[test]
    fn the_arc_tangent_is_that_of_the_library_in_every_quadrant() {
        for k in 0..=4000 {
            let (sin, cos) = (TAU * f64::from(k) / 4000.0 - PI).sin_cos();
            for radius in [1e-6, 1.0, 1e6] {
                let (y, x) = (radius * sin, radius * cos);
                assert!((atan2(y, x) - y.atan2(x)).abs() < 2e-15, "{y} {x}");
            }
        }
        assert_eq!(atan2(0.0, 0.0), 0.0);
    }
}
