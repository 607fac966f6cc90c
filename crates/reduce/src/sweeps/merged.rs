//! Which sweep gives which direction: where one has no light, another one of its half-plane gives it.

use std::rc::Rc;

use isolux_record::{Reading, Role};

use super::curve::Window;
use super::delay::Shift;
use super::swept::{Along, Swept};

/// The widest way without light from which a direction is given where no sweep has less, in those that are bridged
/// anyway: as many as are bridged where two conversions in a row are left out.
const WIDEST: f64 = 1.5;

/// A sweep whose light is displaced to where it belongs.
pub struct Fitted<'a> {
    pub one: &'a Swept<'a>,
    pub shift: Shift,
    pub along: Along,
    /// What the sweeps of this speed and range leave open together.
    smoothing: Rc<Smoothing>,
}

/// Root mean square over sweeps of one speed and range of what their smoothing leaves open, by γ: whether a sweep sees a kink of
/// the light depends on where its conversions happen to lie, and half-planes have their kinks at the same γ.
struct Smoothing(Vec<(f64, f64)>);

impl Smoothing {
    fn of(alongs: &[&Along], gamma_deg: &[f64]) -> Self {
        let at = |gamma: &f64| {
            let there = alongs.iter().filter(|along| along.nodes.contains(gamma));
            let squares: Vec<f64> = there.map(|along| along.curve.u_smoothing(*gamma).powi(2)).collect();
            let mean = squares.iter().sum::<f64>() / squares.len().max(1) as f64;
            (*gamma, mean.sqrt())
        };
        Self(gamma_deg.iter().map(at).collect())
    }

    fn at(&self, gamma_deg: f64) -> f64 {
        let off = |node: &&(f64, f64)| (node.0 - gamma_deg).abs();
        self.0
            .iter()
            .min_by(|a, b| off(a).total_cmp(&off(b)))
            .map_or(0.0, |node| node.1)
    }
}

impl<'a> Fitted<'a> {
    /// Of the sweeps of a block with the light along them.
    pub fn all(swept: Vec<(&'a Swept<'a>, Shift, Along)>, gamma_deg: &[f64]) -> Vec<Self> {
        // Whose conversions are as wide, and as fine.
        let kind = |one: &Swept<'_>, shift: &Shift| (shift.speed_deg_s, one.record.of.range);
        let mut of_kinds: Vec<((f64, i32), Rc<Smoothing>)> = Vec::new();
        for (one, shift, _) in &swept {
            let own = kind(one, shift);
            if of_kinds.iter().all(|(known, _)| *known != own) {
                let same = swept.iter().filter(|(one, shift, _)| kind(one, shift) == own);
                let alongs: Vec<&Along> = same.map(|(_, _, along)| along).collect();
                of_kinds.push((own, Rc::new(Smoothing::of(&alongs, gamma_deg))));
            }
        }
        let smoothing = |of: (f64, i32)| {
            let own = of_kinds.iter().find(|(known, _)| *known == of);
            own.map_or_else(|| Rc::new(Smoothing(Vec::new())), |(_, smoothing)| Rc::clone(smoothing))
        };
        let fitted = swept.into_iter().map(|(one, shift, along)| Self {
            smoothing: smoothing(kind(one, &shift)),
            one,
            shift,
            along,
        });
        fitted.collect()
    }
}

impl Fitted<'_> {
    /// Half-plane of the plan, degrees.
    pub fn c_target_deg(&self) -> f64 {
        self.one.record.of.c_target_deg
    }

    /// Whether the light at γ lies between conversions as near to each other as most.
    pub fn covers(&self, gamma_deg: f64) -> bool {
        self.along.ways.gap_deg(gamma_deg) <= self.along.ways.bridged_deg()
    }

    /// The largest light at a direction.
    pub fn largest(&self) -> f64 {
        let at = |gamma: &f64| self.along.curve.at(*gamma);
        self.along.nodes.iter().map(at).fold(0.0, f64::max)
    }

    /// Standard uncertainty of the light at γ: by noise, by the displacement, by the smoothing.
    pub fn parts(&self, gamma_deg: f64) -> [f64; 3] {
        let curve = &self.along.curve;
        [
            curve.u_noise(gamma_deg),
            self.shift.u_deg.hypot(self.one.u_place_deg()) * curve.slope(gamma_deg).abs(),
            curve.u_smoothing(gamma_deg).max(self.smoothing.at(gamma_deg)),
        ]
    }

    /// What it counts for at γ beside other sweeps: the inverse of its variance, 1/lx².
    pub fn weight(&self, gamma_deg: f64) -> f64 {
        let of_digit = self.digit_lx(gamma_deg) / 12.0_f64.sqrt();
        let parts = self.parts(gamma_deg).into_iter().chain([of_digit]);
        1.0 / parts.map(|part| part * part).sum::<f64>().max(f64::MIN_POSITIVE)
    }

    /// One digit of the display where the light at γ is so even that all conversions around are rounded alike, lx; 0
    /// where noise or the way of the light spreads them over the digit.
    pub fn digit_lx(&self, gamma_deg: f64) -> f64 {
        let from = |window: &&Window| (window.middle_deg() - gamma_deg).abs();
        let nearest = self.one.windows.iter().min_by(|a, b| from(a).total_cmp(&from(b)));
        let digit_lx = self.one.digit_lx;
        let spread_lx = nearest.map_or(0.0, |window| {
            let noise_lx = (window.sigma.powi(2) - digit_lx * digit_lx / 12.0).max(0.0).sqrt();
            let change_lx = self.along.curve.slope(gamma_deg) * (window.to_deg - window.from_deg);
            noise_lx.hypot(change_lx)
        });
        if spread_lx < 0.5 * digit_lx { digit_lx } else { 0.0 }
    }

    /// Seconds of the run at which it read the light at γ.
    pub fn time_s(&self, gamma_deg: f64) -> f64 {
        let displaced_deg = self.one.sign() * self.shift.shift_deg;
        self.one.track.time_s(gamma_deg - displaced_deg)
    }

    /// The reading at a direction of the plan.
    pub fn reading(&self, role: Role, (c_deg, gamma_deg): (f64, f64), u_lx: f64) -> Reading {
        let time_s = self.time_s(gamma_deg);
        let digit_lx = self.digit_lx(gamma_deg);
        let u_lx = u_lx.hypot(digit_lx / 12.0_f64.sqrt());
        let light = (self.along.curve.at(gamma_deg), u_lx);
        Reading {
            digit_lx: Some(digit_lx),
            ..self.one.reading(role, (c_deg, gamma_deg), time_s, light)
        }
    }
}

/// The sweeps of a half-plane that give the light at γ: all that have light there, and of these no one that ends there
/// where another one goes on; else the one with the narrowest way without; none where that is too wide.
pub fn giving<'f, 'a>(of_plane: &[&'f Fitted<'a>], gamma_deg: f64) -> Vec<&'f Fitted<'a>> {
    let reach = |sweep: &&&Fitted<'_>| sweep.along.nodes.contains(&gamma_deg);
    let there: Vec<&Fitted<'_>> = of_plane.iter().filter(reach).copied().collect();
    let whole: Vec<&Fitted<'_>> = there.iter().filter(|sweep| sweep.covers(gamma_deg)).copied().collect();
    let goes_on = |sweep: &&Fitted<'_>| sweep.along.ways.goes_on(gamma_deg);
    let (going_on, ending): (Vec<_>, Vec<_>) = whole.into_iter().partition(goes_on);
    if let Some(whole) = [going_on, ending].into_iter().find(|sweeps| !sweeps.is_empty()) {
        return whole;
    }
    let gap = |sweep: &&Fitted<'_>| sweep.along.ways.gap_deg(gamma_deg);
    let narrowest = there.into_iter().min_by(|a, b| gap(a).total_cmp(&gap(b)));
    let fits = |sweep: &&Fitted<'_>| gap(sweep) <= WIDEST * sweep.along.ways.bridged_deg();
    narrowest.filter(fits).into_iter().collect()
}
