//! A source before a sensor with everything that does not depend on the pixel.

use std::sync::Arc;

use glam::DVec3;
use isolux_model::Accuracy;

use super::routes::Routes;
use super::tolerance::Tolerances;
use crate::angles::Lanes;
use crate::bound::Allowed;
use crate::crossings::{self, Scratch};
use crate::patch::{Light, Patch};
use crate::polar::Polar;
use crate::product::{self, Rule};
use crate::rules::Estimate;
use crate::sensor::Sensor;
use crate::source::{LightSource, Shape};
use crate::table::IntensityTable;

/// Share of the map's largest pixel below which the error that an accuracy allows no longer falls with the pixel.
pub const DIM: f64 = 1e-3;

/// Nodes of a tile's common rule per node of its middle pixel's own, above which pixels take their own rules: far from
/// a kink that others of the tile are near, a few nodes are enough.
const COMMON_NODES: f64 = 2.0;

/// Radii of the emitter over which a kink counts as sharp.
const KINK_BLUR: f64 = 4.0;

/// Share of a bend by which a polynomial of degree 7 misses it, less a margin.
const BEND_MISSED: f64 = 0.02;

/// Places along each side of the sensor at which its brightest light is looked for, and the share of it that the
/// largest pixel is not below.
const LOOKS: usize = 9;
const LOOKED: f64 = 0.8;

/// A source before a sensor, with everything that does not depend on the pixel.
pub(super) struct Prepared<'a> {
    items: Vec<Item<'a>>,
    pub source: &'a LightSource,
    pub tolerances: &'static Tolerances,
    pub allowed: Allowed,
    pub routes: Routes,
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
    /// Share of a map's own errors that is asked for.
    pub requested: f64,
    pub routes: Routes,
    /// Light below which errors no longer fall with it, lx.
    pub dim_lx: f64,
    pub tolerances: &'static Tolerances,
    /// The same upside down, for pixels behind the plane of a flat emitter.
    pub below: Option<Box<Item<'a>>>,
}

impl<'a> Prepared<'a> {
    pub fn new(source: &'a LightSource, sensor: &Sensor, accuracy: Accuracy, routes: Routes, requested: f64) -> Self {
        let tolerances = Tolerances::of(accuracy);
        let mut items = Vec::new();
        // Parallel LEDs share their rules.
        let mut of_points: Option<Arc<Vec<Rule>>> = None;
        for part in source.parts() {
            let own = |v: DVec3| part.aim.map_or(v, |aim| aim.transpose() * v);
            let make = |window: &Patch, emitter: Option<&Patch>| {
                Arc::new(if routes.product_rules {
                    product::rules(window, emitter)
                } else {
                    Vec::new()
                })
            };
            let (step_x, step_y) = (own(sensor.step_x), own(sensor.step_y));
            let item = Item {
                light: Light {
                    table: &part.table,
                    toward: own(sensor.toward),
                    extinction_per_mm: source.extinction_per_mm(),
                },
                share: part.share,
                window: Patch::Parallelogram {
                    corner: own(sensor.corner),
                    first: step_x,
                    second: step_y,
                },
                step_x,
                step_y,
                emitter: None,
                rules: Arc::default(),
                polar: None,
                cancel: 1.0,
                requested,
                routes,
                dim_lx: 0.0,
                tolerances,
                below: None,
            };
            if let Shape::Point(centre) = part.shape {
                let rules = match (&of_points, part.aim) {
                    (Some(rules), None) => Arc::clone(rules),
                    (_, None) => Arc::clone(of_points.insert(make(&item.window, None))),
                    _ => make(&item.window, None),
                };
                items.push(Item {
                    window: item.window.shifted(-own(centre)),
                    rules,
                    ..item
                });
                continue;
            }
            let flat = part.aim.is_none() && source.extinction_per_mm() == 0.0 && routes.outlines;
            let polar = |table: &'a IntensityTable| flat.then(|| Polar::new(table)).flatten().map(Arc::new);
            let (above, behind) = (polar(&part.table), flat && sensor.lowest() < part.shape.centre().z);
            let under = if behind { polar(part.table.upside_down()) } else { None };
            let patches = part.shape.patches();
            let cancel = 1.0 / patches.iter().map(|(_, share)| share.abs()).sum::<f64>();
            for (emitter, share) in patches {
                let emitter = emitter.mapped(own);
                let item = Item {
                    share: part.share * share,
                    rules: make(&item.window, Some(&emitter)),
                    emitter: Some(emitter),
                    polar: above.clone(),
                    cancel,
                    below: None,
                    ..item
                };
                let below = behind.then(|| Box::new(item.upside_down(part.table.upside_down(), under.clone())));
                items.push(Item { below, ..item });
            }
        }
        let brightest = brightest(&items, sensor);
        let dim_lx = DIM * LOOKED * brightest;
        if accuracy == Accuracy::Standard {
            for item in &mut items {
                item.dim_lx = dim_lx;
                if let Some(below) = &mut item.below {
                    below.dim_lx = dim_lx;
                }
            }
        }
        let allowed = Allowed {
            relative: tolerances.allowed,
            dim_lx,
        };
        Self {
            items,
            source,
            tolerances,
            allowed,
            routes,
        }
    }

    /// Whether no kink that is sharp on the scale of the square of `half` pixels round (x, y) crosses it.
    pub fn is_smooth(&self, x: f64, y: f64, half: f64) -> bool {
        self.items.iter().all(|item| {
            let blur = item.emitter.as_ref().map_or(0.0, Patch::radius);
            let radius = half * (item.step_x.length() + item.step_y.length());
            if radius < KINK_BLUR * blur {
                return true;
            }
            let pixel = item.window.shifted((x - 0.5) * item.step_x + (y - 0.5) * item.step_y);
            let sight = pixel.centre() + item.emitter.as_ref().map_or(DVec3::ZERO, Patch::centre);
            let table = item.light.table;
            let bend = crossings::bend_within(table, sight, radius + blur + pixel.radius());
            BEND_MISSED * bend <= self.tolerances.polynomial * table.toward(sight).abs()
        })
    }

    /// Mean illuminance in lx over the pixel-sized window centred at (x, y) in pixels, from the whole emitter.
    pub fn pixel(&self, x: f64, y: f64, scratch: &mut Scratch) -> Estimate {
        let mut total = Estimate::default();
        for item in &self.items {
            let found = item.over((x - 0.5) * item.step_x + (y - 0.5) * item.step_y, scratch);
            total.value += item.share * found.value;
            total.error += item.share.abs() * found.error;
        }
        total
    }

    /// For each part the product rule that serves every pixel within `half` pixels of (x, y), and the bound of its
    /// error in lx for all of them together; `None` where some part has none, or where pixels are quicker by rules of
    /// their own.
    pub fn common(&self, x: f64, y: f64, half: f64) -> Option<(Vec<&Rule>, f64)> {
        if !self.routes.common_rules {
            return None;
        }
        let mut error = 0.0;
        let mut rules = Vec::with_capacity(self.items.len());
        let (mut nodes, mut own) = (0, 0);
        for item in &self.items {
            let shift = (x - 0.5) * item.step_x + (y - 0.5) * item.step_y;
            let (rule, bound) = item.common(shift, half)?;
            error += item.share.abs() * bound;
            nodes += rule.nodes.len();
            own += item.own_nodes(shift)?;
            rules.push(rule);
        }
        (nodes as f64 <= COMMON_NODES * own as f64).then_some((rules, error))
    }

    /// Mean illuminance in lx over the windows centred at (`x`, `y`) by the rules of [`Prepared::common`].
    pub fn several(&self, rules: &[&Rule], x: &Lanes, y: &Lanes) -> Lanes {
        let mut total = Lanes::default();
        for (item, rule) in self.items.iter().zip(rules) {
            let steps = [item.step_x, item.step_y];
            let first = item.sight(-0.5 * (item.step_x + item.step_y));
            let found = rule.means(item.light, first, steps, x, y);
            for (total, value) in total.iter_mut().zip(found) {
                *total += item.share * value;
            }
        }
        total
    }
}

impl<'a> Item<'a> {
    /// The line of sight between the middles of the emitter and of the window shifted by `shift`.
    pub fn sight(&self, shift: DVec3) -> DVec3 {
        self.window.centre() + shift + self.emitter.as_ref().map_or(DVec3::ZERO, Patch::centre)
    }

    /// Light of the table's largest intensity on a face at the sensor's middle, lx.
    fn most(&self, sensor: &Sensor) -> f64 {
        let [x, y] = [sensor.nx, sensor.ny].map(|pixels| 0.5 * pixels as f64 - 0.5);
        let square = self.sight(x * self.step_x + y * self.step_y).length_squared();
        1e6 * self.light.table.peak_cd() / square
    }

    /// Seen in a mirror at z = 0.
    fn upside_down(&self, table: &'a IntensityTable, polar: Option<Arc<Polar<'a>>>) -> Self {
        let turned = |v: DVec3| DVec3::new(v.x, v.y, -v.z);
        let emitter = self.emitter.as_ref().map(|emitter| emitter.mapped(turned));
        Self {
            light: Light {
                table,
                toward: turned(self.light.toward),
                ..self.light
            },
            window: self.window.mapped(turned),
            step_x: turned(self.step_x),
            step_y: turned(self.step_y),
            rules: Arc::default(),
            emitter,
            polar,
            below: None,
            ..*self
        }
    }
}

/// The brightest of a few places of the sensor, lx.
fn brightest(items: &[Item<'_>], sensor: &Sensor) -> f64 {
    let mut spots: Vec<Vec<(DVec3, f64)>> = Vec::with_capacity(items.len());
    for item in items {
        let mut nodes = vec![(DVec3::ZERO, 1.0)];
        if let Some(emitter) = &item.emitter {
            emitter.nodes(2, &mut nodes);
        }
        spots.push(nodes);
    }
    let place = |k: usize, pixels: usize| (k as f64 + 0.5) / LOOKS as f64 * pixels as f64 - 0.5;
    // Where all of them are dark, a pixel between them may not be.
    let mut most = 1e-6
        * items
            .iter()
            .map(|item| item.share.abs() * item.most(sensor))
            .sum::<f64>();
    for iy in 0..LOOKS {
        for ix in 0..LOOKS {
            let (x, y) = (place(ix, sensor.nx), place(iy, sensor.ny));
            let light = |item: &Item<'_>, spots: &[(DVec3, f64)]| -> f64 {
                let sight = item.sight(x * item.step_x + y * item.step_y);
                let seen = spots.iter().map(|&(spot, w)| w * item.light.at(sight + spot));
                item.share * seen.sum::<f64>()
            };
            let sum: f64 = items.iter().zip(&spots).map(|(item, spots)| light(item, spots)).sum();
            most = most.max(sum.abs());
        }
    }
    most
}

#[cfg(test)]
mod tests {
    use isolux_photometry::IntensityDistribution;

    use super::*;
    use crate::sensor::Pose;

    #[test]
    fn pixels_have_a_rule_in_common_only_where_their_own_are_not_far_smaller() {
        // Bent at one cone, and next to nowhere else.
        let gamma_deg: Vec<f64> = (0..=18).map(|k| 5.0 * f64::from(k)).collect();
        let cd = |gamma: &f64| 1000.0 - 0.01 * gamma + if *gamma > 10.0 { 15.0 * (gamma - 10.0) } else { 0.0 };
        let intensity_cd = gamma_deg.iter().map(cd).collect();
        let table = IntensityTable::new(&IntensityDistribution::new(vec![0.0], gamma_deg, intensity_cd).unwrap());
        let source = LightSource::single(Arc::new(table), Shape::Point(DVec3::ZERO));
        let sensor = Sensor::new(&Pose {
            size_mm: [100.0; 2],
            pixels: [400; 2],
            distance_mm: 300.0,
            tilt_x_deg: 0.0,
            tilt_y_deg: 0.0,
            rot_z_deg: 0.0,
            offset_mm: [50.0, 0.0],
        })
        .unwrap();
        let prepared = Prepared::new(&source, &sensor, Accuracy::Standard, Routes::ALL, 1.0);
        let item = &prepared.items[0];
        let (mut taken, mut left) = (0, 0);
        for place in 0..66 {
            let (x, y, half) = (6.0 * f64::from(place), 200.0, 6.0);
            let shift = (x - 0.5) * item.step_x + (y - 0.5) * item.step_y;
            let (Some((rule, _)), Some(own)) = (item.common(shift, half), item.own_nodes(shift)) else {
                continue;
            };
            let larger = rule.nodes.len() > 2 * own;
            assert_eq!(
                prepared.common(x, y, half).is_none(),
                larger,
                "{x}: {} {own}",
                rule.nodes.len()
            );
            *(if larger { &mut left } else { &mut taken }) += 1;
        }
        assert!(taken > 0 && left > 0, "{taken} with a common rule, {left} without");
    }
}
