//! The routes by which a pixel is computed, quickest first: product rules, outlines, lines and chords.

use glam::DVec3;

use super::prepared::Item;
use super::tolerance::{DARK, UNSEEN};
use crate::crossings::{self, Scratch};
use crate::cubature::{self, WorkLimit};
use crate::patch::Patch;
use crate::product::Rule;
use crate::rules::Estimate;
use crate::strips;

/// An emitter below this share of the pixel is a few points, each seen by lines across the pixel.
const FEW_POINTS: f64 = 0.15;

/// An emitter below this share of the pixel is left to chords: seen over the pixel its outline is sharp.
const SMALL_EMITTER: f64 = 0.3;

/// Share of the difference to the pixel's middle that four points miss, where the light bends so little that it is
/// allowed.
const STRAIGHT: f64 = 0.2;

/// Radii of the pixel that it has to be above the emitter's plane for that.
const CLEAR: f64 = 8.0;

/// Largest share of the emitter that such a pixel has: a larger one meets the ends of kinks, which the emitter blurs
/// over its own size, between its five points.
const WITHIN: f64 = 0.1;

/// When an integral over the pixel is left to chords.
const OUTLINE: WorkLimit = WorkLimit {
    cells: 600,
    hopeless: 1e4,
};

/// The same where more is asked for than a map needs.
const PATIENT: WorkLimit = WorkLimit {
    cells: 800,
    hopeless: f64::INFINITY,
};

/// Largest share of the distance that a product rule reaches.
const WIDEST: f64 = 0.3;

impl Item<'_> {
    /// Mean over the window shifted by `shift`, lx.
    pub fn over(&self, shift: DVec3, scratch: &mut Scratch) -> Estimate {
        let pixel = self.window.shifted(shift);
        let sight = self.sight(shift);
        let reach = pixel.radius() + self.emitter.as_ref().map_or(0.0, Patch::radius);
        let tolerances = self.tolerances;
        if let Some(found) = self.product(sight, reach, scratch) {
            return tolerances.product.stated(found, self.cancel, 0.0);
        }
        if let Some(below) = &self.below
            && sight.z < 0.0
        {
            return below.over(DVec3::new(shift.x, shift.y, -shift.z), scratch);
        }
        let light = self.light;
        let distance = sight.length();
        let height = (light.toward.dot(sight).abs() + reach).min(distance);
        let brightest = 1e6 * light.table.peak_cd() * height / (distance * distance * distance);
        let scale = self.cancel * self.requested;
        let unseen = UNSEEN * self.requested * brightest;
        let dark = self.dim_lx.max(DARK * brightest);
        let Some(emitter) = &self.emitter else {
            let aim = tolerances.lines.aim * scale;
            let found = crossings::mean(light, pixel.corner_and_sides(), aim, aim * dark, scratch);
            return tolerances.lines.stated(found, scale, unseen);
        };
        let aim = tolerances.lines.aim * scale;
        if let Some(found) = self.spots(&pixel, emitter, aim, aim * dark, scratch) {
            return tolerances.lines.stated(found, scale, unseen);
        }
        let aim = tolerances.outlines.aim * scale;
        if let Some(found) = self.outlined(&pixel, emitter, aim, aim * dark, scratch) {
            return tolerances.outlines.stated(found, scale, unseen);
        }
        let aim = tolerances.chords.aim * scale;
        let leaves = self.routes.leaves;
        let found = strips::mean(light, &pixel, emitter, [aim, aim * dark], leaves, scratch);
        tolerances.chords.stated(found, scale, unseen)
    }

    /// A product rule, where the bound of its error meets the tolerance.
    fn product(&self, sight: DVec3, reach: f64, scratch: &mut Scratch) -> Option<Estimate> {
        let (rule, error) = self.rule(sight, reach, 0.0)?;
        Some(Estimate {
            value: rule.mean(self.light, sight, &mut scratch.sights),
            error,
        })
    }

    /// The product rule for every window within `half` pixels, and the bound of what is stated of it, lx.
    pub fn common(&self, shift: DVec3, half: f64) -> Option<(&Rule, f64)> {
        let reach = self.window.radius() + self.emitter.as_ref().map_or(0.0, Patch::radius);
        let around = half * (self.step_x.length() + self.step_y.length());
        let sight = self.sight(shift);
        let (rule, error) = self.rule(sight, reach, around)?;
        let value = self.light.at(sight);
        let stated = self
            .tolerances
            .product
            .stated(Estimate { value, error }, self.cancel, 0.0);
        Some((rule, stated.error))
    }

    /// Nodes of the product rule of the window shifted by `shift` alone, as many as the vector units take.
    pub fn own_nodes(&self, shift: DVec3) -> Option<usize> {
        let reach = self.window.radius() + self.emitter.as_ref().map_or(0.0, Patch::radius);
        let (rule, _) = self.rule(self.sight(shift), reach, 0.0)?;
        Some(rule.lanes())
    }

    /// The first product rule whose bound meets the tolerance for lines of sight that end within `around` of `sight`,
    /// and that bound, lx. `reach`: radii of pixel and emitter.
    fn rule(&self, sight: DVec3, reach: f64, around: f64) -> Option<(&Rule, f64)> {
        let (light, all) = (self.light, reach + around);
        let (distance, axis) = (sight.length(), sight.x.hypot(sight.y));
        let height = light.toward.dot(sight);
        if self.rules.is_empty() || height <= all || all > WIDEST * distance {
            return None;
        }
        // Near the pole what holds for many windows says little of each.
        if around > 0.0 && axis < 2.0 * all && !light.table.is_rotational() {
            return None;
        }
        let bends = light.table.bends(sight, all);
        // Changes of slope times the reach: of one window, which is a share of all that they reach.
        let alone = if around == 0.0 {
            1.0
        } else {
            let (near, far) = (axis - around, distance - around);
            let c = if near > reach {
                (reach / near) / (all / axis)
            } else {
                1.0
            };
            c.max((reach / far) / (all / distance)).min(1.0)
        };
        let per_cd = 1e6 * height / (distance * distance * distance);
        let cd = light.table.toward(sight).abs();
        let tolerance = self.tolerances.product.aim * self.cancel * cd.max(self.dim_lx / per_cd);
        let near = (axis - around).max(1e-300);
        let bound = |rule: &Rule| {
            let bent = bends.lines * rule.ramp + bends.pole * rule.about(reach / near);
            alone * bent + cd * rule.smooth(reach / (distance - around))
        };
        let rule = self.rules.iter().find(|rule| bound(rule) <= tolerance)?;
        Some((rule, per_cd * bound(rule)))
    }

    /// An emitter that is small against the pixel as a few points: over the pixel its kinks are blurred by more than
    /// the emitter's size, so that the pixel's mean is smooth over the emitter. `None` where it is not.
    fn spots(
        &self,
        pixel: &Patch,
        emitter: &Patch,
        relative: f64,
        floor: f64,
        scratch: &mut Scratch,
    ) -> Option<Estimate> {
        let share = emitter.radius() / pixel.radius();
        let [corner, first, second] = pixel.corner_and_sides();
        let lowest = [corner, corner + first, corner + second, corner + first + second]
            .map(|end| self.light.toward.dot(end + emitter.centre()))
            .into_iter()
            .fold(f64::INFINITY, f64::min);
        if !self.routes.few_points || share > FEW_POINTS || lowest < emitter.radius() {
            return None;
        }
        let mut nodes = Vec::new();
        let mut before = 0.0;
        for (points, trusted) in [(0, 0.0), (1, share), (2, share)] {
            nodes.clear();
            if points == 0 {
                nodes.push((DVec3::ZERO, 1.0));
            } else {
                emitter.nodes(points, &mut nodes);
            }
            let mut found = Estimate::default();
            for &(spot, weight) in &nodes {
                let seen = [corner + emitter.centre() + spot, first, second];
                let one = crossings::mean(self.light, seen, relative, floor, scratch);
                found.value += weight * one.value;
                found.error += weight * one.error;
            }
            // Each rule is exact to two degrees more than the one before, and what it misses is smaller by the square
            // of the share.
            let missed = trusted * (found.value - before).abs();
            if points > 0 && missed <= floor.max(relative * found.value.abs()) {
                found.error += missed;
                return Some(found);
            }
            before = found.value;
        }
        None
    }

    /// The emitter by its outline from each point of the pixel, and an adaptive rule over the pixel; `None` where the
    /// pixel reaches behind the emitter's plane, or the bound is not met.
    fn outlined(
        &self,
        pixel: &Patch,
        emitter: &Patch,
        relative: f64,
        floor: f64,
        scratch: &mut Scratch,
    ) -> Option<Estimate> {
        let polar = self.polar.as_ref()?;
        if emitter.radius() < SMALL_EMITTER * pixel.radius() {
            return None;
        }
        let [corner, first, second] = pixel.corner_and_sides();
        let toward = self.light.toward;
        let corners =
            [corner, corner + first, corner + second, corner + first + second].map(|end| end + emitter.centre());
        let lowest = |of: &dyn Fn(DVec3) -> f64| corners.iter().map(|end| of(*end)).fold(f64::INFINITY, f64::min);
        let above = lowest(&|end| end.z);
        if above <= 0.0 {
            return None;
        }
        let per_area = 1e6 / emitter.area();
        // Too near to the horizon is no number, and neither is what it enters.
        let mut at = |[s, t]: [f64; 2]| {
            let seen = emitter.shifted(corner + s * first + t * second);
            per_area * polar.integral(&seen, toward, &mut scratch.cuts).unwrap_or(f64::NAN)
        };
        let more = self.requested < 1.0;
        // A pixel over which the light hardly bends: four points, exact to degree 3, beside one.
        let clear = pixel.radius() < WITHIN * emitter.radius()
            && above > CLEAR * pixel.radius()
            && lowest(&|end| toward.dot(end)) > emitter.radius();
        if self.routes.four_points && !more && clear {
            let [low, high] = [0.5 - 0.5 / 3.0_f64.sqrt(), 0.5 + 0.5 / 3.0_f64.sqrt()];
            let corners = [[low, low], [low, high], [high, low], [high, high]];
            let value = 0.25 * corners.into_iter().map(&mut at).sum::<f64>();
            let error = STRAIGHT * (value - at([0.5; 2])).abs();
            if error <= floor.max(relative * value.abs()) {
                return Some(Estimate { value, error });
            }
        }
        let work_limit = if more { PATIENT } else { OUTLINE };
        let found = cubature::integral(&[[[0.0, 1.0], [0.0, 1.0]]], relative, floor, work_limit, |_, place| {
            at(place)
        });
        let met = more || found.error <= floor.max(4.0 * relative * found.value.abs());
        (!found.value.is_nan() && met).then_some(found)
    }
}
