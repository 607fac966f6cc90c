//! Inverse simulation: the irradiance of every pixel by quadrature over pixel and emitter, with a bound on its own error.

use std::sync::Arc;

use glam::DVec3;
use rayon::prelude::*;

use crate::cubature::{self, Patience};
use crate::local::{self, Local, Rule};
use crate::number::Care;
use crate::patch::{self, Light, Patch, Scratch};
use crate::polar::Polar;
use crate::rows::Rows;
use crate::sensor::Sensor;
use crate::source::{Shape, Source};
use crate::{strips, tiles};

pub use crate::bound::Bound;
pub use crate::number::Number;
pub use crate::rules::Estimate;

/// What a rule's estimate of its own error is worth. Estimates are differences of rules, and two rules can agree by chance; the
/// stated bound is `safety` times the estimate, and `slack` of the value for what an estimate does not see. Both are set by the
/// largest errors of thousands of pixels against far tighter solutions, with a margin (decision 0049).
#[derive(Debug, Clone, Copy)]
struct Trust {
    /// Relative error, by its own estimate, that the rule aims at.
    aim: f64,
    safety: f64,
    slack: f64,
}

/// Product rules over pixel and emitter.
const PRODUCT: Trust = Trust {
    aim: 1.6e-7,
    safety: 5.0,
    slack: 1e-7,
};
/// Lines across a pixel, cut at every bend, for points.
const LINES: Trust = Trust {
    aim: 9e-8,
    safety: 4.0,
    slack: 2e-7,
};
/// Outlines of emitters, and an adaptive rule over the pixel.
const OUTLINES: Trust = Trust {
    aim: 6.5e-8,
    safety: 8.0,
    slack: 1e-7,
};
/// Chords of pixel and emitter, and an adaptive rule across them: where an emitter is small against a coarse pixel, its kinks can lie
/// between all nodes.
const CHORDS: Trust = Trust {
    aim: 2.2e-7,
    safety: 25.0,
    slack: 1e-7,
};
/// What the rules inside a rule may miss of the value, however little is aimed at.
const INNER: f64 = 2e-9;

impl Trust {
    /// The estimate as a bound, where `scale` times the aim was asked for: no error is smaller than `unseen` (lx), light that no
    /// node may have met.
    fn stated(self, found: Estimate, scale: f64, unseen: f64) -> Estimate {
        let slack = (self.slack * scale).max(INNER);
        Estimate {
            value: found.value,
            error: self.safety * found.error + slack * found.value.abs() + unseen,
        }
    }
}

/// Share of the brightest light that could reach a pixel below which a pixel's error is no longer relative to itself.
const DARK: f64 = 1e-7;
/// Share of the same that adaptive rules may not meet at all: a sliver in a corner of a dark pixel.
const UNSEEN: f64 = 1e-10;

/// A map of illuminance without noise.
#[derive(Debug, Clone, PartialEq)]
pub struct Map {
    /// Mean over each pixel in lx, `[iy * nx + ix]`.
    pub illuminance_lx: Vec<f64>,
    /// Mean over the map of the bound on the error of the quadrature, lx.
    pub error_lx: f64,
}

/// The map: quick rules where their bound meets the tolerance, cuts at every kink elsewhere, polynomials over tiles where
/// the light is smooth. Independent of the number of threads.
pub fn solve(source: &Source, sensor: &Sensor) -> Map {
    let mut illuminance_lx = vec![0.0; sensor.pixels()];
    let bound = solve_into(source, sensor, &mut illuminance_lx);
    Map {
        illuminance_lx,
        error_lx: bound.mean_lx,
    }
}

/// The map in the caller's memory (`[iy * nx + ix]`, as many as the sensor has pixels), in f64 or, for half the memory
/// and time, in f32.
///
/// # Panics
/// If `map` has another length.
pub fn solve_into<N: Number>(source: &Source, sensor: &Sensor, map: &mut [N]) -> Bound {
    assert_eq!(map.len(), sensor.pixels(), "one number a pixel");
    if let Some(bound) = rows(source, sensor, map) {
        return bound;
    }
    let prepared = Prepared::new(source, sensor, true);
    tiles::fill(
        sensor,
        map,
        |x, y, care, scratch| prepared.pixel(x, y, care, scratch),
        |x, y, half| prepared.is_smooth(x, y, half, N::AIM),
    )
}

/// Row by row, where the source and the sensor allow it.
fn rows<N: Number>(source: &Source, sensor: &Sensor, map: &mut [N]) -> Option<Bound> {
    let rows = Rows::new::<N>(source, sensor)?;
    // Few maps have pixels for which their centres do not stand.
    let prepared = std::sync::OnceLock::new();
    Some(rows.fill(map, |ix, iy| {
        prepared.get_or_init(|| Prepared::new(source, sensor, true)).pixel(
            ix as f64 + 0.5,
            iy as f64 + 0.5,
            Care::Itself,
            &mut Scratch::default(),
        )
    }))
}

/// How a single pixel is computed, where that is to be checked.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Route {
    /// As in a map whose pixels are computed by themselves.
    Chosen,
    /// Flat emitters along their outline wherever that applies, no product rules.
    Outlines,
    /// Chords of pixel and emitter, or lines across the pixel for points.
    Chords,
}

/// The mean over one pixel in lx with its bound, to errors `share` times those of a map (1 is a map's own).
pub fn pixel(source: &Source, sensor: &Sensor, [ix, iy]: [usize; 2], route: Route, share: f64) -> Estimate {
    let prepared = Prepared::by(source, sensor, route, share);
    prepared.pixel(ix as f64 + 0.5, iy as f64 + 0.5, Care::Itself, &mut Scratch::default())
}

/// The reference: every pixel by itself with cuts at every kink, no quick rules, no interpolation between pixels.
pub fn solve_each(source: &Source, sensor: &Sensor) -> Map {
    let prepared = Prepared::new(source, sensor, false);
    let rows: Vec<(Vec<f64>, f64)> = (0..sensor.ny)
        .into_par_iter()
        .map_init(Scratch::default, |scratch, iy| {
            let mut error = 0.0;
            let row = (0..sensor.nx)
                .map(|ix| {
                    let found = prepared.pixel(ix as f64 + 0.5, iy as f64 + 0.5, Care::Itself, scratch);
                    error += found.error;
                    found.value
                })
                .collect();
            (row, error)
        })
        .collect();
    let error_lx = rows.iter().map(|row| row.1).sum::<f64>() / sensor.pixels() as f64;
    Map {
        illuminance_lx: rows.into_iter().flat_map(|row| row.0).collect(),
        error_lx,
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

/// Radii of the emitter over which a kink counts as sharp.
const KINK_BLUR: f64 = 4.0;

/// Share of a bend by which a polynomial of degree 7 misses it, less a margin.
const BEND_MISSED: f64 = 0.02;

/// Share of the quick rules' tolerance that nodes of polynomials ask for.
const NODE_SHARE: f64 = 0.5;

/// The same in single precision.
const SINGLE_SHARE: f64 = 1.3;

/// A source before a sensor, with everything that does not depend on the pixel.
struct Prepared<'a> {
    items: Vec<Item<'a>>,
    /// Share of a map's own errors.
    share: f64,
}

/// One part and one patch of its area, in the part's own frame, in which its table stands upright.
struct Item<'a> {
    light: Light<'a>,
    share: f64,
    /// The pixel-sized window whose corner is the sensor's corner, seen from the part's middle.
    window: Patch,
    step_x: DVec3,
    step_y: DVec3,
    /// Lines of sight of the emitter, its middle included; `None` for a point.
    emitter: Option<Patch>,
    rules: Arc<Vec<Rule>>,
    /// For a flat emitter that lies in a plane z = const of its own frame.
    polar: Option<Arc<Polar<'a>>>,
    /// How much smaller errors must be than in the part's light: a thin ring is the small difference of two discs.
    cancel: f64,
}

impl<'a> Prepared<'a> {
    fn new(source: &'a Source, sensor: &Sensor, quick: bool) -> Self {
        Self::by(source, sensor, if quick { Route::Chosen } else { Route::Chords }, 1.0)
    }

    fn by(source: &'a Source, sensor: &Sensor, route: Route, share: f64) -> Self {
        let quick = route == Route::Chosen;
        let mut items = Vec::new();
        // Parallel LEDs share their rules.
        let mut of_points: Option<Arc<Vec<Rule>>> = None;
        for part in source.parts() {
            let own = |v: DVec3| part.aim.map_or(v, |aim| aim.transpose() * v);
            let light = Light {
                table: &part.table,
                toward: own(sensor.toward),
                extinction_per_mm: source.extinction_per_mm(),
            };
            let (step_x, step_y) = (own(sensor.step_x), own(sensor.step_y));
            let window = Patch::Parallelogram {
                corner: own(sensor.corner),
                first: step_x,
                second: step_y,
            };
            let make = |emitter: Option<&Patch>| {
                Arc::new(if quick {
                    local::rules(&window, emitter)
                } else {
                    Vec::new()
                })
            };
            if let Shape::Point(centre) = part.shape {
                let rules = match (&of_points, part.aim) {
                    (Some(rules), None) => Arc::clone(rules),
                    (_, None) => Arc::clone(of_points.insert(make(None))),
                    _ => make(None),
                };
                let window = window.shifted(-own(centre));
                items.push(Item {
                    light,
                    share: part.share,
                    window,
                    step_x,
                    step_y,
                    emitter: None,
                    rules,
                    polar: None,
                    cancel: 1.0,
                });
                continue;
            }
            let flat = part.aim.is_none() && source.extinction_per_mm() == 0.0 && route != Route::Chords;
            let polar = flat.then(|| Polar::new(&part.table)).flatten().map(Arc::new);
            let patches = part.shape.patches();
            let cancel = 1.0 / patches.iter().map(|(_, share)| share.abs()).sum::<f64>();
            for (emitter, share) in patches {
                let emitter = emitter.mapped(own);
                let rules = make(Some(&emitter));
                let share = part.share * share;
                items.push(Item {
                    light,
                    share,
                    window,
                    step_x,
                    step_y,
                    emitter: Some(emitter),
                    rules,
                    polar: polar.clone(),
                    cancel,
                });
            }
        }
        Self { items, share }
    }

    /// Whether no kink that is sharp on the scale of the square of `half` pixels round (x, y) crosses it.
    fn is_smooth(&self, x: f64, y: f64, half: f64, aim: f64) -> bool {
        self.items.iter().all(|item| {
            let blur = item.emitter.as_ref().map_or(0.0, Patch::radius);
            let radius = half * (item.step_x.length() + item.step_y.length());
            if radius < KINK_BLUR * blur {
                return true;
            }
            let pixel = item.window.shifted((x - 0.5) * item.step_x + (y - 0.5) * item.step_y);
            let sight = pixel.centre() + item.emitter.as_ref().map_or(DVec3::ZERO, Patch::centre);
            let table = item.light.table;
            let bend = patch::bend_within(table, sight, radius + blur + pixel.radius());
            BEND_MISSED * bend <= aim * table.toward(sight).abs()
        })
    }

    /// Mean illuminance in lx over the pixel-sized window centred at (x, y) in pixels, from the whole emitter.
    fn pixel(&self, x: f64, y: f64, care: Care, scratch: &mut Scratch) -> Estimate {
        let mut total = Estimate::default();
        for item in &self.items {
            let found = item.over(
                (x - 0.5) * item.step_x + (y - 0.5) * item.step_y,
                care,
                self.share,
                scratch,
            );
            total.value += item.share * found.value;
            total.error += item.share.abs() * found.error;
        }
        total
    }
}

impl Item<'_> {
    fn over(&self, shift: DVec3, care: Care, share: f64, scratch: &mut Scratch) -> Estimate {
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
}

impl Item<'_> {
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
}

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

impl Item<'_> {
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
