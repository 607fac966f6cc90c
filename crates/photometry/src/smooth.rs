//! Smooth interpolation: a finer grid, between whose points straight lines are as good as the smooth surface.
//!
//! A straight line between two directions of a convex part lies above the light, below it on a concave one: by
//! h²·I''/8 in the middle of a step h. The smooth surface is a limited cubic (`curve`) around the circle of C at every γ
//! of the grid, then along γ in every half-plane. Where γ reaches a pole the curve goes on into the opposite half-plane,
//! so that the pole is a smooth place of the surface with one value, the mean over C.

use crate::IntensityDistribution;
use crate::curve::{BEYOND, Curve};

/// What a straight line of the finer grid may be off the curve, along γ and in C each, relative to the intensity.
const OFF_REL: f64 = 5e-5;
/// Intensities below this share of the largest count as this share: less light needs no finer grid.
const SHARE: f64 = 0.01;
/// Share of the standard uncertainty of one direction that a straight line may be off the curve where that is more: nothing
/// is known better between directions than at them, and bends of their noise need no finer grid.
const OF_U: f64 = 0.05;
/// Most steps into which one of the grid is cut.
const MOST_PARTS: f64 = 20.0;

impl IntensityDistribution {
    /// The same light on a finer grid, whose bilinear interpolant is the smooth one of this grid to 0.01 % where there
    /// is more than 1 % of the largest intensity, or to a tenth of `u_cd`, the standard uncertainty in cd of a direction
    /// of so many cd, where that is more (0 where it is not known).
    ///
    /// At the directions of this grid the intensities are its own (at a pole their mean over C). Between them no largest
    /// or smallest value comes about that the directions do not show, and none below zero between two that are not.
    /// Angles of this grid are angles of the finer one.
    #[must_use]
    pub fn on_smooth_grid(&self, u_cd: &dyn Fn(f64) -> f64) -> Self {
        let surface = Surface::of(self, u_cd);
        let c_deg = surface.finer_c();
        let meridians: Vec<Curve> = c_deg.iter().map(|c| surface.meridian(*c)).collect();
        let gamma_deg = surface.finer_gamma(&meridians);
        let intensity_cd = meridians
            .iter()
            .flat_map(|meridian| gamma_deg.iter().map(|gamma| meridian.at(*gamma)))
            .collect();
        // The angles rise as this grid's do; only an intensity near the largest number of all could overflow.
        Self::new(c_deg, gamma_deg, intensity_cd).unwrap_or_else(|_| self.clone())
    }
}

/// A distribution as curves around the circle.
struct Surface<'d> {
    c_deg: &'d [f64],
    gamma_deg: &'d [f64],
    /// One a γ, in degrees of C; none where a single half-plane stands for all.
    rings: Vec<Curve>,
    /// That half-plane.
    only: &'d [f64],
    least_cd: f64,
    u_cd: &'d dyn Fn(f64) -> f64,
}

impl<'d> Surface<'d> {
    fn of(distribution: &'d IntensityDistribution, u_cd: &'d dyn Fn(f64) -> f64) -> Self {
        let (c_deg, gamma_deg) = (distribution.c_deg(), distribution.gamma_deg());
        let ring = |ig: usize| {
            let gamma = gamma_deg[ig];
            let at_pole = (gamma == 0.0 || gamma == 180.0).then(|| distribution.pole_cd(gamma));
            let value = |plane: usize| at_pole.unwrap_or_else(|| distribution.row(plane)[ig]);
            let count = c_deg.len() as isize;
            let beyond = BEYOND as isize;
            (-beyond..count + beyond)
                .map(|k| {
                    let plane = k.rem_euclid(count) as usize;
                    (c_deg[plane] + 360.0 * k.div_euclid(count) as f64, value(plane))
                })
                .unzip()
        };
        let rings = if distribution.is_rotational() {
            Vec::new()
        } else {
            (0..gamma_deg.len())
                .map(ring)
                .map(|(c, intensity): (Vec<f64>, Vec<f64>)| Curve::through(c, intensity))
                .collect()
        };
        Self {
            c_deg,
            gamma_deg,
            rings,
            only: distribution.row(0),
            least_cd: SHARE * distribution.peak().intensity_cd,
            u_cd,
        }
    }

    fn at(&self, c_deg: f64, ig: usize) -> f64 {
        let Some(ring) = self.rings.get(ig) else {
            return self.only[ig];
        };
        let first = self.c_deg[0];
        ring.at(first + (c_deg - first).rem_euclid(360.0))
    }

    /// The half-plane C, beyond a pole the opposite one.
    fn meridian(&self, c_deg: f64) -> Curve {
        let gamma = self.gamma_deg;
        let last = gamma.len() - 1;
        let beyond = BEYOND.min(last);
        let mut points: Vec<(f64, f64)> = Vec::with_capacity(gamma.len() + 2 * beyond);
        if gamma[0] == 0.0 {
            let opposite = (1..=beyond).rev().map(|ig| (-gamma[ig], self.at(c_deg + 180.0, ig)));
            points.extend(opposite);
        }
        points.extend((0..=last).map(|ig| (gamma[ig], self.at(c_deg, ig))));
        if gamma[last] == 180.0 {
            let opposite = (last - beyond..last).rev();
            points.extend(opposite.map(|ig| (360.0 - gamma[ig], self.at(c_deg + 180.0, ig))));
        }
        let (x, y) = points.into_iter().unzip();
        Curve::through(x, y)
    }

    /// Half-planes so close that straight lines between them are good enough at every γ; evenly apart if the grid's are.
    fn finer_c(&self) -> Vec<f64> {
        let count = self.c_deg.len();
        let gap = |plane: usize| (self.c_deg[(plane + 1) % count] - self.c_deg[plane]).rem_euclid(360.0);
        let step = (0..self.rings.len())
            .flat_map(|ig| (0..count).map(move |plane| (ig, plane)))
            .map(|(ig, plane)| gap(plane) / self.parts(&self.rings[ig], BEYOND + plane))
            .fold(360.0, f64::min);
        let finer = (0..count).flat_map(|plane| cut(self.c_deg[plane], gap(plane), (gap(plane) / step - 1e-9).ceil()));
        // With a first plane that is not C0, the cuts of the last gap reach beyond the full turn.
        let mut finer: Vec<f64> = finer.map(|c| if c >= 360.0 { c - 360.0 } else { c }).collect();
        finer.sort_by(f64::total_cmp);
        finer
    }

    /// The same along γ, each step of the grid cut as often as the half-plane needs that needs most.
    fn finer_gamma(&self, meridians: &[Curve]) -> Vec<f64> {
        let gamma = self.gamma_deg;
        let last = gamma.len() - 1;
        let first = if gamma[0] == 0.0 { BEYOND.min(last) } else { 0 };
        let mut finer: Vec<f64> = (0..last)
            .flat_map(|ig| {
                let parts = meridians.iter().map(|meridian| self.parts(meridian, first + ig));
                cut(gamma[ig], gamma[ig + 1] - gamma[ig], parts.fold(1.0, f64::max))
            })
            .collect();
        finer.push(gamma[last]);
        finer
    }

    /// Into how many parts the step of `curve` after point `from` is to be cut: the line over a part of width w is off
    /// by at most w²·|I''|/8.
    fn parts(&self, curve: &Curve, from: usize) -> f64 {
        let [low, high] = curve.ends(from);
        let cd = low.1.abs().min(high.1.abs());
        let allowed_cd = (OFF_REL * cd.max(self.least_cd)).max(OF_U * (self.u_cd)(cd));
        if allowed_cd <= 0.0 {
            return 1.0;
        }
        let parts = (high.0 - low.0) * (curve.largest_bend(from) / (8.0 * allowed_cd)).sqrt();
        parts.ceil().clamp(1.0, MOST_PARTS)
    }
}

/// `from` and the angles that cut the `width` after it into `parts`, at least one.
fn cut(from: f64, width: f64, parts: f64) -> impl Iterator<Item = f64> {
    let parts = parts.max(1.0);
    (0..parts as usize).map(move |part| from + width * (part as f64 / parts))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::direction;
    use proptest::prelude::*;

    const EXACT: fn(f64) -> f64 = |_| 0.0;

    fn every(step: f64, end: f64) -> Vec<f64> {
        (0..=(end / step) as i32)
            .map(|i| f64::from(i) * step)
            .filter(|at| *at < end)
            .collect()
    }

    fn sampled(c_deg: Vec<f64>, gamma_deg: Vec<f64>, f: impl Fn(f64, f64) -> f64) -> IntensityDistribution {
        let values = c_deg
            .iter()
            .flat_map(|c| gamma_deg.iter().map(|gamma| f(*c, *gamma)).collect::<Vec<_>>());
        let values = values.collect();
        IntensityDistribution::new(c_deg, gamma_deg, values).unwrap()
    }

    /// cosⁿ about an axis that leans by 3° towards C40, wider towards C0: neither the maximum nor the symmetry lies on
    /// the grid.
    fn lamp(c_deg: f64, gamma_deg: f64) -> f64 {
        let d = direction(c_deg, gamma_deg);
        let cosine = direction(40.0, 3.0).dot(d).max(0.0);
        1000.0 * cosine.powf(5.3) * (1.0 + 0.02 * (d.x * d.x - d.y * d.y))
    }

    fn largest_error(of: &IntensityDistribution, f: impl Fn(f64, f64) -> f64) -> f64 {
        let mut largest: f64 = 0.0;
        for i in 0..4000 {
            let (c, gamma) = (f64::from(i) * 77.313 % 360.0, f64::from(i) * 0.0225);
            let truth = f(c, gamma);
            if truth > 10.0 {
                largest = largest.max((of.intensity_cd_at(c, gamma) / truth - 1.0).abs());
            }
        }
        largest
    }

    #[test]
    fn a_lamp_between_its_directions() {
        let gamma = |step: f64| [every(step, 90.0), vec![90.0]].concat();
        let coarse = sampled(every(15.0, 360.0), gamma(2.0), lamp);
        let smooth = coarse.on_smooth_grid(&EXACT);
        assert!(largest_error(&coarse, lamp) > 5e-3);
        assert!(largest_error(&smooth, lamp) < 2e-4, "{}", largest_error(&smooth, lamp));
        let truth = sampled(every(1.0, 360.0), gamma(0.05), lamp).flux_lm();
        let off = [&coarse, &smooth].map(|d| d.flux_lm() / truth - 1.0);
        assert!(off[0] > 5e-4 && off[1].abs() < 1e-5, "{off:?}");
    }

    #[test]
    fn a_rotational_lamp_is_smooth_too() {
        let lobe = |_: f64, gamma: f64| 1000.0 * gamma.to_radians().cos().powi(3);
        let coarse = sampled(vec![0.0], [every(2.0, 90.0), vec![90.0]].concat(), lobe);
        let smooth = coarse.on_smooth_grid(&EXACT);
        assert!(smooth.is_rotational());
        let [coarse, smooth] = [&coarse, &smooth].map(|d| largest_error(d, lobe));
        assert!(coarse > 1e-2 && smooth < 2e-4, "{coarse} {smooth}");
    }

    #[test]
    fn the_directions_of_the_grid_keep_their_values() {
        let c = vec![3.0, 40.0, 100.0, 200.0, 222.0];
        let given = sampled(c, vec![0.0, 5.0, 9.0, 30.0, 31.0, 90.0, 150.0, 180.0], |c, gamma| {
            if gamma == 0.0 || gamma == 180.0 {
                7.0
            } else {
                f64::from((c * gamma) as i32 % 97)
            }
        });
        let smooth = given.on_smooth_grid(&EXACT);
        for c in given.c_deg() {
            let plane = smooth.plane_at(*c).unwrap();
            for gamma in given.gamma_deg() {
                let ig = smooth.gamma_deg().iter().position(|at| at == gamma).unwrap();
                assert_eq!(
                    smooth.row(plane)[ig],
                    given.intensity_cd_at(*c, *gamma),
                    "C{c} γ{gamma}"
                );
            }
        }
    }

    #[test]
    fn a_pole_has_one_value_and_no_tip() {
        let uneven = |c: f64, gamma: f64| lamp(c, gamma) + if gamma == 0.0 { 8.0 * (c / 90.0 - 1.5) } else { 0.0 };
        let given = sampled(vec![0.0, 90.0, 180.0, 270.0], every(2.0, 91.0), uneven);
        let smooth = given.on_smooth_grid(&EXACT);
        let mean = given.pole_cd(0.0);
        assert!((0..smooth.c_deg().len()).all(|plane| smooth.row(plane)[0] == mean));
        // Along the meridian C0–C180 the lamp bends evenly; straight lines have twice its bend at half a step.
        let bend = |of: &dyn Fn(f64, f64) -> f64| of(0.0, 1.0) + of(180.0, 1.0) - 2.0 * mean;
        let [straight, found] = [&given, &smooth].map(|d| bend(&|c, gamma| d.intensity_cd_at(c, gamma)));
        let (truth, allowed) = (bend(&lamp), 2.0 * OFF_REL * mean);
        assert!((found - truth).abs() < allowed, "{found} for {truth}");
        assert!((straight - truth).abs() > 10.0 * allowed, "{straight} for {truth}");
    }

    #[test]
    fn a_beam_with_a_sharp_edge_does_not_overshoot() {
        let edge = |c: f64, gamma: f64| match gamma {
            30.0 => 500.0 + c,
            gamma if gamma < 30.0 => 1000.0,
            _ => 0.0,
        };
        let smooth = sampled(every(30.0, 360.0), every(10.0, 91.0), edge).on_smooth_grid(&EXACT);
        for gamma in every(0.1, 90.0) {
            for c in every(7.0, 360.0) {
                let value = smooth.intensity_cd_at(c, gamma);
                assert!((0.0..=1000.0).contains(&value), "C{c} γ{gamma}: {value}");
                assert!(gamma > 20.0 || value == 1000.0, "C{c} γ{gamma}: {value}");
                assert!(gamma < 40.0 || value == 0.0, "C{c} γ{gamma}: {value}");
            }
        }
    }

    /// The scatter of readings bends curves as no light does.
    #[test]
    fn scatter_needs_no_finer_grid_than_it_is_uncertain() {
        let (u_cd, grid) = (0.1, |step: f64, end: f64| every(step, end));
        let scatter = |c: f64, gamma: f64| u_cd * ((c * 7.0 + gamma * 131.0).sin() * 4e4).sin();
        let read = sampled(grid(15.0, 360.0), grid(2.0, 181.0), |c, gamma| {
            lamp(c, gamma) + scatter(c, gamma)
        });
        let (exact, known) = (read.on_smooth_grid(&EXACT), read.on_smooth_grid(&|_| u_cd));
        let size = |of: &IntensityDistribution| of.intensity_cd().len();
        assert!(4 * size(&known) < size(&exact), "{} {}", size(&known), size(&exact));
        let mut largest: f64 = 0.0;
        for i in 0..4000 {
            let (c, gamma) = (f64::from(i) * 77.313 % 360.0, f64::from(i) * 0.045);
            let [known, exact] = [&known, &exact].map(|of| of.intensity_cd_at(c, gamma));
            let allowed = (2.0 * OF_U * u_cd).max(2.0 * OFF_REL * exact) + 2.0 * OFF_REL * exact.max(10.0);
            largest = largest.max((known - exact).abs() / allowed);
        }
        assert!((0.1..1.0).contains(&largest), "{largest}");
    }

    #[test]
    fn straight_light_needs_no_finer_grid() {
        let flat = sampled(every(90.0, 360.0), vec![10.0, 90.0, 120.0], |_, _| 5.0);
        assert_eq!(flat.on_smooth_grid(&EXACT), flat);
        let dark = sampled(vec![0.0], vec![0.0, 90.0], |_, _| 0.0);
        assert_eq!(dark.on_smooth_grid(&EXACT), dark);
    }

    proptest! {
        #[test]
        fn any_grid_has_a_finer_one(values in prop::collection::vec(-5.0..50.0f64, 15), first in 0.0..30.0f64) {
            let d = IntensityDistribution::new(vec![first, 40.0, 200.0], vec![0.0, 10.0, 30.0, 110.0, 180.0], values).unwrap();
            let smooth = d.on_smooth_grid(&EXACT);
            prop_assert!(smooth.c_deg().len() > 3 && smooth.gamma_deg().len() > 5);
            prop_assert!(smooth.c_deg().contains(&first) && smooth.gamma_deg().contains(&110.0));
        }
    }
}
