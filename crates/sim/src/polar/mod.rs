//! Flat emitters of any size, from one point of the sensor: one integral along the emitter's outline.
//!
//! In polar coordinates (ρ, C) about the foot of the sensor point on the emitter's plane at height h, ρ = h·tan γ,
//! so that the half-planes and cones of the distribution's grid are the coordinate lines, and ρ dρ/R³ = sin γ
//! dγ/h. The integral over γ from the foot outwards,
//!
//! G(γ, C) = t_z ∫ I sin γ dγ + (t_x cos C + t_y sin C) ∫ I tan γ sin γ dγ   (t: the sensor's facing),
//!
//! is tabulated along each half-plane of the grid and linear in C between two of them. By Green's theorem the
//! illuminance is then ∮ G dC along the outline over the emitter's area, and along the outline G is analytic between
//! crossings of grid lines, all of which have closed forms.

mod outline;
mod tables;

use std::f64::consts::{FRAC_PI_2, TAU};

use glam::{DVec2, DVec3};

use self::outline::Sight;
pub(crate) use self::tables::Polar;
use self::tables::{POWERS, Run, Strip};
use crate::angles::atan2;
use crate::patch::Patch;
use crate::polynomial::{self, Fit, TERMS};
use crate::table::{IntensityTable, Search};

/// Widest interval of γ over which sin γ is one polynomial, rad.
const WIDEST: f64 = 0.1;
/// The same for tan γ·sin γ, as a share of the distance from 90°.
const NEAR_HORIZON: f64 = 0.15;
/// Angle from the emitter's plane below which the tables end, rad.
const HORIZON: f64 = 1e-3;

impl<'a> Polar<'a> {
    /// `None` for a table without light below 90°.
    pub fn new(table: &'a IntensityTable) -> Option<Self> {
        let end = FRAC_PI_2 - HORIZON;
        let lines = &table.gamma_rad;
        let last = *lines.last()?;
        let mut gamma = Vec::new();
        for pair in lines.windows(2) {
            let mut at = pair[0];
            let to = pair[1].min(end);
            while at < to - 1e-12 {
                gamma.push(at);
                let step = WIDEST.min(NEAR_HORIZON * (FRAC_PI_2 - at));
                // Even parts of what is left, so that no sliver remains.
                let parts = ((to - at) / step).ceil().max(1.0);
                at += (to - at) / parts;
            }
            if pair[1] >= end {
                break;
            }
        }
        gamma.push(last.min(end));
        if gamma.len() < 2 {
            return None;
        }
        let strips: Vec<Strip> = gamma.windows(2).map(|pair| Strip::new(pair[0], pair[1])).collect();
        let mut runs = Vec::with_capacity(table.c_rad.len() * strips.len());
        for row in 0..table.c_rad.len() {
            let mut run = Run::default();
            for (pair, strip) in gamma.windows(2).zip(&strips) {
                let (cd, slope) = table.along(row, 0.5 * (pair[0] + pair[1]));
                run.slope = slope;
                run.cd = cd - slope * 0.5 * (pair[1] - pair[0]);
                runs.push(run);
                let whole = |k: usize| strip.of.iter().map(|power| power[k]).sum::<f64>();
                run.sine += run.cd * whole(0) + slope * whole(1);
                run.tangent += run.cd * whole(2) + slope * whole(3);
            }
        }
        let kinks = table.gamma_kinks().iter().filter(|kink| **kink < end && **kink > 0.0);
        Some(Self {
            table,
            search: Search::over(&gamma),
            strips,
            runs,
            dark_beyond: last < end,
            cones: kinks.map(|kink| kink.tan().powi(2)).collect(),
            planes: table.c_kinks().iter().map(|kink| DVec2::from_angle(*kink)).collect(),
            gamma,
        })
    }

    /// ∫ I·cos α/R² over the lines of sight `patch` (flat, z = const above zero) as seen on a face towards
    /// `toward`, cd. `None` where the patch reaches too near to the horizon.
    pub fn integral(&self, patch: &Patch, toward: DVec3, scratch: &mut Vec<f64>) -> Option<f64> {
        let height = patch.centre().z;
        // Seen from outside, what lies between the foot and the patch cancels along the outline: it is left out from
        // the start.
        let sight = |nearest: f64| {
            let gamma = atan2(nearest, height);
            let base = if gamma > self.gamma[0] {
                self.search.interval(&self.gamma, gamma)
            } else {
                0
            };
            Sight {
                polar: self,
                height,
                toward,
                base,
            }
        };
        match *patch {
            Patch::Disc { centre, first, .. } => {
                let (centre, radius) = (centre.truncate(), first.length());
                let sight = sight(centre.length() - radius);
                // Light from behind the face is none: the part of the circle that the face sees, and its chord.
                let (facing, height) = (toward.truncate(), toward.dot(centre.extend(height)));
                let cosine = -height / (radius * facing.length());
                if cosine >= 1.0 {
                    return Some(0.0);
                }
                if facing.length() == 0.0 || cosine <= -1.0 {
                    return sight.arc(centre, radius, [0.0, TAU], scratch);
                }
                let (middle, half) = (atan2(facing.y, facing.x), cosine.acos());
                let end = |angle: f64| centre + radius * DVec2::from_angle(angle);
                let arc = sight.arc(centre, radius, [middle - half, middle + half], scratch)?;
                Some(arc + sight.edge(end(middle + half), end(middle - half), scratch)?)
            }
            Patch::Parallelogram { corner, first, second } => {
                let (a, first, second) = (corner.truncate(), first.truncate(), second.truncate());
                let turn = first.perp_dot(second).signum();
                let corners = [a, a + first, a + first + second, a + second];
                let mut inside = true;
                let mut nearest = f64::INFINITY;
                for k in 0..4 {
                    let (from, along) = (corners[k], corners[(k + 1) % 4] - corners[k]);
                    inside &= turn * from.perp_dot(along) > 0.0;
                    let u = (-from.dot(along) / along.length_squared()).clamp(0.0, 1.0);
                    nearest = nearest.min((from + u * along).length());
                }
                let nearest = if inside { 0.0 } else { nearest };
                let sight = sight(nearest);
                let (seen, count) = seen(&corners, height, toward);
                let mut sum = 0.0;
                for k in 0..count {
                    sum += sight.edge(seen[k], seen[(k + 1) % count], scratch)?;
                }
                Some(turn * sum)
            }
        }
    }

    /// G at (x, y, height), from strip `base` on.
    #[inline]
    fn at(&self, at: DVec2, height: f64, toward: DVec3, base: usize) -> Option<f64> {
        let axis = at.length();
        let gamma = atan2(axis, height);
        let strips = self.strips.len();
        let (k, s) = if gamma < self.gamma[0] {
            return Some(0.0);
        } else if gamma > self.gamma[strips] {
            if !self.dark_beyond {
                return None;
            }
            (strips - 1, 1.0)
        } else {
            let k = self.search.interval(&self.gamma, gamma);
            (k, (gamma - self.gamma[k]) * self.strips[k].per_gamma - 1.0)
        };
        let strip = &self.strips[k];
        let run = |row: usize| {
            let (run, before) = (self.runs[row * strips + k], self.runs[row * strips + base]);
            Run {
                sine: run.sine - before.sine,
                tangent: run.tangent - before.tangent,
                ..run
            }
        };
        let run = if self.table.is_rotational() {
            run(0)
        } else {
            let (row, share) = self.table.between(atan2(at.y, at.x));
            let (low, high) = (run(row), run(row + 1));
            let mix = |a: f64, b: f64| a + share * (b - a);
            Run {
                sine: mix(low.sine, high.sine),
                tangent: mix(low.tangent, high.tangent),
                cd: mix(low.cd, high.cd),
                slope: mix(low.slope, high.slope),
            }
        };
        // Four polynomials side by side.
        let (mut of, mut odd) = (strip.of[POWERS - 2], strip.of[POWERS - 1]);
        let square = s * s;
        for pair in strip.of[..POWERS - 2].chunks_exact(2).rev() {
            for k in 0..4 {
                of[k] = of[k] * square + pair[0][k];
                odd[k] = odd[k] * square + pair[1][k];
            }
        }
        for (sum, odd) in of.iter_mut().zip(odd) {
            *sum += s * odd;
        }
        let mut sum = toward.z * (run.sine + run.cd * of[0] + run.slope * of[1]);
        let across = toward.x * at.x + toward.y * at.y;
        if across != 0.0 {
            sum += across / axis * (run.tangent + run.cd * of[2] + run.slope * of[3]);
        }
        Some(sum)
    }
}

/// The part of a four-cornered outline at `height` from which light reaches a face towards `toward`.
fn seen(corners: &[DVec2; 4], height: f64, toward: DVec3) -> ([DVec2; 8], usize) {
    let (mut seen, mut count) = ([DVec2::ZERO; 8], 0);
    let mut push = |at: DVec2| {
        seen[count] = at;
        count += 1;
    };
    for k in 0..4 {
        let (from, to) = (corners[k], corners[(k + 1) % 4]);
        let [a, b] = [from, to].map(|at| toward.dot(at.extend(height)));
        if a >= 0.0 {
            push(from);
        }
        if (a >= 0.0) != (b >= 0.0) {
            push(from + (to - from) * (a / (a - b)));
        }
    }
    (seen, count)
}

impl Strip {
    fn new(from: f64, to: f64) -> Self {
        let (fit, half) = (Fit::new(), 0.5 * (to - from));
        let of = |f: &dyn Fn(f64) -> f64, times_x: bool| {
            let values = polynomial::nodes().map(|s| f(from + half * (1.0 + s)));
            let (c, _) = fit.polynomial(&values);
            // x = half·(1 + s).
            let mut terms = [0.0; POWERS];
            for k in 0..TERMS {
                if times_x {
                    terms[k] += half * c[k];
                    terms[k + 1] += half * c[k];
                } else {
                    terms[k] += c[k];
                }
            }
            let mut sum = [0.0; POWERS];
            for k in 1..POWERS {
                sum[k] = half * terms[k - 1] / k as f64;
                sum[0] -= if k % 2 == 0 { sum[k] } else { -sum[k] };
            }
            sum
        };
        let steep = |gamma: f64| gamma.tan() * gamma.sin();
        let functions = [
            of(&f64::sin, false),
            of(&f64::sin, true),
            of(&steep, false),
            of(&steep, true),
        ];
        Self {
            per_gamma: half.recip(),
            of: std::array::from_fn(|power| functions.map(|function| function[power])),
        }
    }
}

#[cfg(test)]
mod tests {
    use std::f64::consts::PI;

    use isolux_photometry::IntensityDistribution;

    use super::*;
    use crate::crossings::{self, Scratch};
    use crate::patch::Light;

    /// Uneven, without symmetry, equal at the pole, dark beyond `end`.
    fn table(end: f64) -> IntensityTable {
        let c_deg = vec![0.0, 20.0, 65.0, 90.0, 150.0, 210.0, 275.0, 330.0];
        let mut gamma_deg = vec![0.0, 2.0, 5.0, 11.0, 20.0, 33.0, 50.0, 71.0];
        gamma_deg.extend(
            [end, end + 20.0]
                .into_iter()
                .take_while(|gamma| *gamma <= 90.0 || end > 90.0),
        );
        let intensity_cd = c_deg
            .iter()
            .flat_map(|c: &f64| {
                gamma_deg.iter().map(|g: &f64| {
                    300.0 + 700.0 * (-(g / 30.0).powi(2)).exp() * (1.0 + 0.02 * g * (c.to_radians() + g / 20.0).cos())
                })
            })
            .collect();
        IntensityTable::new(&IntensityDistribution::new(c_deg, gamma_deg, intensity_cd).unwrap())
    }

    fn facings() -> [DVec3; 3] {
        [
            DVec3::Z,
            DVec3::new(0.3, -0.4, 1.0).normalize(),
            // Half of a wide emitter lies behind this face.
            DVec3::new(0.9, 0.3, 0.2).normalize(),
        ]
    }

    #[test]
    fn a_parallelogram_is_that_of_lines_cut_at_every_bend() {
        for end in [80.0, 110.0] {
            let table = table(end);
            let polar = Polar::new(&table).unwrap();
            for toward in facings() {
                // The foot inside, outside, far outside, near a side.
                for corner in [
                    DVec3::new(-7.0, -9.0, 20.0),
                    DVec3::new(5.0, 3.0, 20.0),
                    DVec3::new(60.0, -90.0, 50.0),
                    DVec3::new(-1e-3, -4.0, 15.0),
                ] {
                    let (first, second) = (DVec3::new(18.0, 3.0, 0.0), DVec3::new(2.0, 24.0, 0.0));
                    for (first, second) in [(first, second), (second, first)] {
                        let patch = Patch::Parallelogram { corner, first, second };
                        let light = Light {
                            table: &table,
                            toward,
                            extinction_per_mm: 0.0,
                        };
                        let mean =
                            crossings::mean(light, [corner, first, second], 1e-10, 1e-9, &mut Scratch::default());
                        let found = 1e6 * polar.integral(&patch, toward, &mut Vec::new()).unwrap() / patch.area();
                        assert!(
                            (found - mean.value).abs() < 1e-7 * mean.value.abs() + 1e-6,
                            "{corner} {toward} to {end}°: {found} {}",
                            mean.value
                        );
                    }
                }
            }
        }
    }

    #[test]
    fn a_disc_is_a_polygon_of_many_corners() {
        let table = table(110.0);
        let polar = Polar::new(&table).unwrap();
        let radius = 15.0;
        for toward in facings() {
            for centre in [
                DVec3::new(0.0, 0.0, 20.0),
                DVec3::new(4.0, -7.0, 12.0),
                DVec3::new(15.0, 0.0, 30.0),
                DVec3::new(-40.0, 33.0, 25.0),
            ] {
                let disc = Patch::Disc {
                    centre,
                    first: radius * DVec3::X,
                    second: radius * DVec3::Y,
                };
                let found = polar.integral(&disc, toward, &mut Vec::new()).unwrap();
                // Slices of the disc as thin parallelograms of the same area.
                let slices = 3000;
                let mut sum = 0.0;
                for k in 0..slices {
                    let [low, high] = [k, k + 1].map(|k: i32| PI * f64::from(k) / f64::from(slices));
                    let area = radius * radius * (0.5 * (high - low) - 0.25 * ((2.0 * high).sin() - (2.0 * low).sin()));
                    let (left, right) = (-radius * low.cos(), -radius * high.cos());
                    let half = area / (right - left);
                    let slice = Patch::Parallelogram {
                        corner: centre + DVec3::new(left, -half, 0.0),
                        first: DVec3::X * (right - left),
                        second: DVec3::Y * 2.0 * half,
                    };
                    sum += polar.integral(&slice, toward, &mut Vec::new()).unwrap();
                }
                assert!((found - sum).abs() <= 3e-7 * sum, "{centre} {toward}: {found} {sum}");
            }
        }
    }
}
