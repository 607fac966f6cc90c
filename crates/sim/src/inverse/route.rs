//! The routes by which a pixel is computed, quickest first: product rules, outlines, chords.

use glam::DVec3;

use super::prepared::Item;
use super::trust::{CHORDS, DARK, LINES, OUTLINES, PRODUCT, UNSEEN};
use crate::cubature::{self, Patience};
use crate::local::{Local, Rule};
use crate::number::Care;
use crate::patch::{self, Light, Patch, Scratch};
use crate::rules::Estimate;
use crate::strips;

/// Emitters smaller than this share of the pixel are left to chords: seen over the pixel they are sharp.
const SMALL_EMITTER: f64 = 0.3;

/// When an integral over the pixel is left to chords.
const OUTLINE: Patience = Patience {
    cells: 600,
    hopeless: 1e4,
};

/// The same where more is asked for than a map needs.
const PATIENT: Patience = Patience {
    cells: 800,
    hopeless: f64::INFINITY,
};

/// Share of the quick rules' tolerance that nodes of polynomials ask for.
const NODE_SHARE: f64 = 0.5;

/// The same in single precision.
const SINGLE_SHARE: f64 = 1.3;

impl Item<'_> {
    pub fn over(&self, shift: DVec3, care: Care, share: f64, scratch: &mut Scratch) -> Estimate {
        let pixel = self.window.shifted(shift);
        let middle = self.emitter.as_ref().map_or(DVec3::ZERO, Patch::centre);
        let sight = pixel.centre() + middle;
        let reach = pixel.radius() + self.emitter.as_ref().map_or(0.0, Patch::radius);
        if let Some(found) = self.quick(sight, reach, care) {
            return PRODUCT.stated(found, self.cancel, 0.0);
        }
        if let Some(found) = self.looked_up(sight, reach, care, scratch) {
            return PRODUCT.stated(found, self.cancel, 0.0);
        }
        let light = self.light;
        let distance = sight.length();
        let height = (light.toward.dot(sight).abs() + reach).min(distance);
        let brightest = 1e6 * light.table.peak_cd() * height / (distance * distance * distance);
        let scale = self.cancel * share;
        let (dark, unseen) = (DARK * brightest, UNSEEN * share * brightest);
        let aim = OUTLINES.aim * scale;
        if let Some(found) = self.outlined(&pixel, aim, aim * dark, share, scratch) {
            return OUTLINES.stated(found, scale, unseen);
        }
        let mut nearest = singular_distance(sight);
        if let Some(emitter) = &self.emitter {
            nearest = nearest.min(sensor_distance(light, sight, emitter));
        }
        if !patch::may_bend(light.table, sight, reach) && reach < 0.4 * nearest {
            // Analytic over pixel and emitter together: one product rule of each, its order from the size.
            let found = smooth(light, sight, &pixel, self.emitter.as_ref(), reach / nearest);
            return PRODUCT.stated(found, self.cancel, 0.0);
        }
        match &self.emitter {
            None => {
                let aim = LINES.aim * scale;
                let found = patch::mean(light, pixel.corner_and_sides(), aim, aim * dark, scratch);
                LINES.stated(found, scale, unseen)
            }
            Some(emitter) => {
                let aim = CHORDS.aim * scale;
                let found = strips::mean(light, &pixel, emitter, aim, aim * dark, scratch);
                CHORDS.stated(found, scale, unseen)
            }
        }
    }

    /// A product rule in the vector units, where the bound of its error meets the tolerance.
    fn quick(&self, sight: DVec3, reach: f64, care: Care) -> Option<Estimate> {
        let height = self.light.toward.dot(sight);
        if self.rules.is_empty() || height <= reach {
            return None;
        }
        let table = self.light.table;
        let local = Local::new(table, sight, reach)?;
        let distance = sight.length();
        // How far the angles turn over the patch, and what a ramp of one candela makes at the sensor.
        let axis = sight.x.hypot(sight.y);
        let (turn_gamma, turn_c) = (reach / distance, reach / axis.max(1e-300));
        let per_cd = 1e6 * height / (distance * distance * distance);
        let [bend_gamma, bend_c] = local.bend;
        let bend_c = if bend_c > 0.0 { bend_c * turn_c } else { 0.0 };
        let bend = per_cd * (bend_gamma * turn_gamma + bend_c);
        // Azimuth and polar angle are not smooth at the pole axis, by as much as the light follows them; all else at the source.
        let [steep_gamma, steep_c] = local.steep();
        let about_axis = 2.0 * (steep_gamma * turn_gamma + if steep_c > 0.0 { steep_c * turn_c } else { 0.0 });
        let tolerance = PRODUCT.aim * self.cancel * per_cd * local.middle_cd().abs();
        let bound = |rule: &Rule| {
            let smooth = local.middle_cd().abs() * rule.smooth(turn_gamma) + about_axis * rule.about(turn_c);
            bend * rule.ramp + per_cd * smooth
        };
        let wished = care.share() * tolerance;
        let rule = self
            .rules
            .iter()
            .find(|rule| bound(rule) <= wished)
            .or_else(|| self.rules.last().filter(|rule| bound(rule) <= tolerance))?;
        Some(Estimate {
            value: local.mean(self.light, sight, rule),
            error: bound(rule),
        })
    }

    /// A product rule whose nodes are looked up one by one, where many kinks of a small bend are in reach.
    fn looked_up(&self, sight: DVec3, reach: f64, care: Care, scratch: &mut Scratch) -> Option<Estimate> {
        let (table, distance) = (self.light.table, sight.length());
        let height = self.light.toward.dot(sight);
        if self.rules.is_empty() || height <= reach || reach > 0.3 * distance {
            return None;
        }
        let bends = table.bends(sight, reach);
        let cd = table.toward(sight).abs();
        let wished = PRODUCT.aim * self.cancel * care.share() * cd;
        let axis = sight.x.hypot(sight.y);
        let bound = |rule: &Rule| {
            bends.lines * rule.ramp + bends.pole * rule.about(reach / axis) + cd * rule.smooth(reach / distance)
        };
        let rule = self.rules.iter().find(|rule| bound(rule) <= wished)?;
        Some(Estimate {
            value: rule.mean(self.light, sight, &mut scratch.sights),
            error: 1e6 * height / (distance * distance * distance) * bound(rule),
        })
    }

    /// The emitter by its outline from each point of the pixel, and an adaptive rule over the pixel; `None` where the pixel reaches
    /// behind the emitter's plane, or the bound is not met.
    fn outlined(
        &self,
        pixel: &Patch,
        relative: f64,
        floor: f64,
        share: f64,
        scratch: &mut Scratch,
    ) -> Option<Estimate> {
        let (polar, emitter) = (self.polar.as_ref()?, self.emitter.as_ref()?);
        if emitter.radius() < SMALL_EMITTER * pixel.radius() {
            return None;
        }
        let [corner, first, second] = pixel.corner_and_sides();
        let toward = self.light.toward;
        let below = |end: DVec3| end.z + emitter.centre().z <= 0.0;
        if [corner, corner + first, corner + second, corner + first + second]
            .into_iter()
            .any(below)
        {
            return None;
        }
        let mut failed = false;
        let per_area = 1e6 / emitter.area();
        let patience = if share < 1.0 { PATIENT } else { OUTLINE };
        let found = cubature::integral(&[[[0.0, 1.0], [0.0, 1.0]]], relative, floor, patience, |_, [s, t]| {
            let seen = emitter.shifted(corner + s * first + t * second);
            polar.integral(&seen, toward, &mut scratch.cuts).unwrap_or_else(|| {
                failed = true;
                0.0
            }) * per_area
        });
        let met = share < 1.0 || found.error <= floor.max(4.0 * relative * found.value.abs());
        (!failed && met).then_some(found)
    }
}

impl Care {
    /// Share of the quick rules' tolerance.
    fn share(self) -> f64 {
        match self {
            Self::Node => NODE_SHARE,
            Self::Itself => 1.0,
            Self::Single => SINGLE_SHARE,
        }
    }
}

/// Distance from the end of a line of sight to the nearest singularity of the integrand: the pole axis.
fn singular_distance(sight: DVec3) -> f64 {
    sight.x.hypot(sight.y)
}

/// For a tilted sensor near an extended emitter the projection changes sign in the sensor's plane: no smooth rule across it.
fn sensor_distance(light: Light<'_>, sight: DVec3, emitter: &Patch) -> f64 {
    let height = light.toward.dot(sight);
    if height > 0.0 && height < emitter.radius() {
        height.max(1e-300)
    } else {
        f64::INFINITY
    }
}

/// Product rule over pixel and emitter where no kink is near. `ratio`: reach of both over the distance of the singularity.
fn smooth(light: Light<'_>, sight: DVec3, pixel: &Patch, emitter: Option<&Patch>, ratio: f64) -> Estimate {
    let order = match ratio {
        r if r < 0.0003 => 1,
        r if r < 0.012 => 2,
        r if r < 0.05 => 3,
        r if r < 0.12 => 4,
        r if r < 0.2 => 6,
        _ => 8,
    };
    let relative: f64 = if order == 1 {
        ratio * ratio
    } else {
        (ratio / 1.5).powi(2 * order as i32)
    };
    // A patch far smaller than the other needs fewer points.
    let of = |patch: &Patch| {
        let own = ratio * patch.radius() / (pixel.radius() + emitter.map_or(0.0, Patch::radius));
        let mut n = order;
        while n > 1 && own.powi(2 * (n as i32 - 1)) < 1e-9 * if n == 2 { 10.0 } else { 1.0 } {
            n -= 1;
        }
        n
    };
    let sum = product(light, sight, pixel, emitter, [of(pixel), emitter.map_or(1, of)]);
    Estimate {
        value: sum,
        error: sum.abs() * relative.max(1e-14),
    }
}

/// The product of a rule of each order over pixel and emitter.
fn product(light: Light<'_>, sight: DVec3, pixel: &Patch, emitter: Option<&Patch>, order: [usize; 2]) -> f64 {
    let mut nodes = Vec::new();
    let mut spots = Vec::new();
    pixel.nodes(order[0], &mut nodes);
    match emitter {
        Some(emitter) => emitter.nodes(order[1], &mut spots),
        None => spots.push((DVec3::ZERO, 1.0)),
    }
    let mut sum = 0.0;
    for &(at, w) in &nodes {
        for &(spot, ws) in &spots {
            sum += w * ws * light.at(sight + at + spot);
        }
    }
    sum
}
