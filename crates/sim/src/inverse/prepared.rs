//! A source before a sensor with everything that does not depend on the pixel.

use std::sync::Arc;

use glam::DVec3;

use super::Route;
use crate::local::{self, Rule};
use crate::number::Care;
use crate::patch::{self, Light, Patch, Scratch};
use crate::polar::Polar;
use crate::rules::Estimate;
use crate::sensor::Sensor;
use crate::source::{Shape, Source};

/// Radii of the emitter over which a kink counts as sharp.
const KINK_BLUR: f64 = 4.0;

/// Share of a bend by which a polynomial of degree 7 misses it, less a margin.
const BEND_MISSED: f64 = 0.02;

/// A source before a sensor, with everything that does not depend on the pixel.
pub(super) struct Prepared<'a> {
    items: Vec<Item<'a>>,
    /// Share of a map's own errors.
    share: f64,
}

/// One part and one patch of its area, in the part's own frame, in which its table stands upright.
pub(super) struct Item<'a> {
    pub light: Light<'a>,
    pub share: f64,
    /// The pixel-sized window whose corner is the sensor's corner, seen from the part's middle.
    pub window: Patch,
    pub step_x: DVec3,
    pub step_y: DVec3,
    /// Lines of sight of the emitter, its middle included; `None` for a point.
    pub emitter: Option<Patch>,
    pub rules: Arc<Vec<Rule>>,
    /// For a flat emitter that lies in a plane z = const of its own frame.
    pub polar: Option<Arc<Polar<'a>>>,
    /// How much smaller errors must be than in the part's light: a thin ring is the small difference of two discs.
    pub cancel: f64,
}

impl<'a> Prepared<'a> {
    pub fn new(source: &'a Source, sensor: &Sensor, quick: bool) -> Self {
        Self::by(source, sensor, if quick { Route::Chosen } else { Route::Chords }, 1.0)
    }

    pub fn by(source: &'a Source, sensor: &Sensor, route: Route, share: f64) -> Self {
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
    pub fn is_smooth(&self, x: f64, y: f64, half: f64, aim: f64) -> bool {
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
    pub fn pixel(&self, x: f64, y: f64, care: Care, scratch: &mut Scratch) -> Estimate {
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
