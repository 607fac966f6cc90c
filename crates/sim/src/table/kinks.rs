//! Where the interpolant bends, and by how much within reach of a direction.

use std::f64::consts::{PI, TAU};

use glam::DVec3;

use super::IntensityTable;
use super::rough::Rough;

/// What may lead a rule astray within reach of a direction, candela.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Bends {
    /// Changes of slope times the reach.
    pub lines: f64,
    /// Slopes about the pole axis times the reach: the tip of a cone where the axis is in reach, a smooth bend beside
    /// it.
    pub pole: f64,
}

impl IntensityTable {
    /// Bound, candela, on how far the interpolant bends within `spread` of `gamma` and `spread_c` of `c` (radians):
    /// change of slope at each grid line in reach times the reach. Infinite at an end of the range that is no pole.
    pub(crate) fn bend(&self, gamma: f64, spread: f64, c: f64, spread_c: f64) -> f64 {
        let n = self.gamma_rad.len();
        let (low, high) = (gamma - spread, gamma + spread);
        if low < self.gamma_rad[0] && self.gamma_rad[0] > 1e-9
            || high > self.gamma_rad[n - 1] && self.gamma_rad[n - 1] < PI - 1e-9
            || n < 2
        {
            return f64::INFINITY;
        }
        let from = self.gamma_rad.partition_point(|line| *line < low);
        let to = self.gamma_rad.partition_point(|line| *line <= high);
        let planes = if self.is_rotational() { 1 } else { self.c_rad.len() - 1 };
        let at = |ic: usize, ig: usize| self.intensity_cd[ic % planes * n + ig];
        let slope =
            |ic: usize, ig: usize| (at(ic, ig + 1) - at(ic, ig)) / (self.gamma_rad[ig + 1] - self.gamma_rad[ig]);
        let mut along: f64 = 0.0;
        for ig in from.max(1)..to.min(n - 1) {
            along += (0..planes)
                .map(|ic| (slope(ic, ig) - slope(ic, ig - 1)).abs())
                .fold(0.0, f64::max);
        }
        if low < 0.0 {
            // The pole is the tip of a cone.
            along += (0..planes).map(|ic| slope(ic, 0).abs()).fold(0.0, f64::max);
        }
        if high > PI {
            along += (0..planes).map(|ic| slope(ic, n - 2).abs()).fold(0.0, f64::max);
        }
        let mut across = 0.0;
        if planes > 1 {
            let rows = [low, gamma, high].map(|g| g.clamp(self.gamma_rad[0], self.gamma_rad[n - 1]));
            let value = |ic: usize, g: f64| self.at_rad(self.c_rad[ic % planes], g);
            for ic in 0..planes {
                let away = (self.c_rad[ic] - c + PI).rem_euclid(TAU) - PI;
                if away.abs() > spread_c {
                    continue;
                }
                let before = (ic + planes - 1) % planes;
                let widths = [
                    (self.c_rad[ic] - self.c_rad[before]).rem_euclid(TAU),
                    self.c_rad[ic + 1] - self.c_rad[ic],
                ];
                across += rows
                    .iter()
                    .map(|&g| {
                        let [left, mid, right] = [before, ic, ic + 1].map(|k| value(k, g));
                        ((right - mid) / widths[1] - (mid - left) / widths[0]).abs()
                    })
                    .fold(0.0, f64::max);
            }
        }
        along * spread + across * spread_c
    }

    /// Bounds on what lies within `reach` of the end of the line of sight `sight`; infinite at an end of the range that
    /// is no pole.
    pub(crate) fn bends(&self, sight: DVec3, reach: f64) -> Bends {
        const NONE: Bends = Bends {
            lines: f64::INFINITY,
            pole: f64::INFINITY,
        };
        let n = self.gamma_rad.len();
        let (distance, axis) = (sight.length(), sight.x.hypot(sight.y));
        if reach >= distance || n < 2 {
            return NONE;
        }
        let gamma = axis.atan2(sight.z);
        let spread = 1.02 * (reach / distance).asin();
        let (low, high) = (gamma - spread, gamma + spread);
        if low < self.gamma_rad[0] && self.gamma_rad[0] > 1e-9
            || high > self.gamma_rad[n - 1] && self.gamma_rad[n - 1] < PI - 1e-9
        {
            return NONE;
        }
        let from = self.gamma_rad.partition_point(|line| *line < low);
        let to = self.gamma_rad.partition_point(|line| *line <= high).max(from);
        let mut lines: f64 = self.rough[from..to].iter().map(|rough| rough.jump).sum::<f64>() * spread;
        // The lines round the reach as well: what holds at both ends holds between them.
        let around = &self.rough[from.max(1) - 1..(to + 1).min(n)];
        let most = |of: fn(&Rough) -> f64| around.iter().map(of).fold(0.0, f64::max);
        if !self.is_rotational() {
            // Between two lines a change of slope in C is no larger than linear between the lines' largest.
            let at = |gamma: f64, of: fn(&Rough) -> f64| {
                let gamma = gamma.clamp(self.gamma_rad[0], self.gamma_rad[n - 1]);
                let ig = self.gamma_search.interval(&self.gamma_rad, gamma);
                let t = (gamma - self.gamma_rad[ig]) / (self.gamma_rad[ig + 1] - self.gamma_rad[ig]);
                (1.0 - t) * of(&self.rough[ig]) + t * of(&self.rough[ig + 1])
            };
            let within = |of: fn(&Rough) -> f64| {
                let lines = self.rough[from..to].iter().map(of);
                lines.fold(at(low, of).max(at(high, of)), f64::max)
            };
            let round = within(|rough| rough.round);
            lines += if reach < 0.99 * axis {
                let spread_c = 1.02 * (reach / axis).asin();
                let c = sight.y.atan2(sight.x);
                let crossed = count_azimuths(&self.c_kinks, c - spread_c, c + spread_c);
                (crossed as f64 * within(|rough| rough.jump_c)).min(round) * spread_c
            } else {
                round * 0.5 * PI
            };
        }
        Bends {
            lines,
            pole: 2.0 * (most(|rough| rough.steep) + most(|rough| rough.turn)) * spread,
        }
    }

    pub(super) fn find_rough(&mut self) {
        let n = self.gamma_rad.len();
        let planes = if self.is_rotational() { 1 } else { self.c_rad.len() - 1 };
        let mut rough = vec![Rough::default(); n];
        let at = |ic: usize, ig: usize| self.intensity_cd[ic % planes * n + ig];
        let slope = |ic: usize, ig: usize| {
            if ig + 1 < n {
                (at(ic, ig + 1) - at(ic, ig)) / (self.gamma_rad[ig + 1] - self.gamma_rad[ig])
            } else {
                0.0
            }
        };
        for (ig, rough) in rough.iter_mut().enumerate() {
            let sine = self.gamma_rad[ig].sin();
            for ic in 0..planes {
                rough.steep = rough.steep.max(slope(ic, ig).abs());
                if ig > 0 && ig + 1 < n {
                    rough.jump = rough.jump.max((slope(ic, ig) - slope(ic, ig - 1)).abs());
                }
                if planes > 1 {
                    let width = |ic: usize| self.c_rad[ic % planes + 1] - self.c_rad[ic % planes];
                    let across = |ic: usize| (at(ic + 1, ig) - at(ic, ig)) / width(ic);
                    let jump = (across(ic) - across(ic + planes - 1)).abs();
                    rough.jump_c = rough.jump_c.max(jump);
                    rough.round += jump;
                    let steep = across(ic).abs();
                    if steep > 0.0 {
                        rough.turn = rough.turn.max(steep / sine.max(1e-12));
                    }
                }
            }
        }
        self.rough = rough;
    }

    /// Azimuths at which the interpolant bends, in [0, 2π), rising.
    pub(crate) fn c_kinks(&self) -> &[f64] {
        &self.c_kinks
    }

    /// Polar angles at which the interpolant bends or ends, rising.
    pub(crate) fn gamma_kinks(&self) -> &[f64] {
        &self.gamma_kinks
    }

    /// A grid line at which the slope does not change is no kink; the ends of the range are unless they are the poles.
    pub(super) fn find_kinks(&mut self) {
        let (nc, ng) = (self.c_rad.len(), self.gamma_rad.len());
        let peak = self
            .intensity_cd
            .iter()
            .fold(0.0_f64, |peak, value| peak.max(value.abs()));
        self.peak_cd = peak;
        let at = |ic: usize, ig: usize| self.intensity_cd[ic * ng + ig];
        let bends = |x: [f64; 3], y: [f64; 3]| {
            let straight = y[0] + (y[2] - y[0]) * (x[1] - x[0]) / (x[2] - x[0]);
            (y[1] - straight).abs() > 1e-13 * peak
        };
        let mut gamma_kinks = Vec::new();
        for ig in 0..ng {
            let gamma = self.gamma_rad[ig];
            let pole = !(1e-9..=PI - 1e-9).contains(&gamma);
            let end = ig == 0 || ig + 1 == ng;
            let kink = if end {
                !pole
            } else {
                let x = [self.gamma_rad[ig - 1], gamma, self.gamma_rad[ig + 1]];
                (0..nc).any(|ic| bends(x, [at(ic, ig - 1), at(ic, ig), at(ic, ig + 1)]))
            };
            if kink {
                gamma_kinks.push(gamma);
            }
        }
        let mut c_kinks = Vec::new();
        if nc > 1 {
            let planes = nc - 1;
            for ic in 0..planes {
                let (before, x0) = if ic == 0 {
                    (planes - 1, self.c_rad[planes - 1] - TAU)
                } else {
                    (ic - 1, self.c_rad[ic - 1])
                };
                let x = [x0, self.c_rad[ic], self.c_rad[ic + 1]];
                if (0..ng).any(|ig| bends(x, [at(before, ig), at(ic, ig), at(ic + 1, ig)])) {
                    c_kinks.push(self.c_rad[ic].rem_euclid(TAU));
                }
            }
            c_kinks.sort_by(f64::total_cmp);
        }
        self.c_kinks = c_kinks;
        self.gamma_kinks = gamma_kinks;
    }
}

/// How many `kinks` (in [0, 2π), rising) lie between two azimuths less than a turn apart.
fn count_azimuths(kinks: &[f64], from: f64, to: f64) -> usize {
    let turn = from.div_euclid(TAU) * TAU;
    let (low, high) = (from - turn, to - turn);
    let below = |x: f64| kinks.partition_point(|kink| *kink < x);
    below(high) - below(low) + below(high - TAU)
}
