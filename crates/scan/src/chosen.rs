//! Which half-planes of a block of sweeps with a target are swept: rings show where the light changes over C, and
//! half-planes that were swept show it at every γ. A function of the record alone, so that a resumed scan goes on as
//! it would have.

mod known;

use std::collections::HashMap;

use isolux_photometry::{Asymmetry, Circle, NotRound, OF_LEFT_OUT, Ring, Symmetry, bands, u_beyond_rings};
use isolux_record::Run;
use isolux_record::plan::{Block, Pass, PlaneTarget, RINGS, Way, ring};
use isolux_record::sweeps::SweepRecord;

use crate::conversions::conversions;
pub use known::Known;

/// Rings lie where there is at least this share of the largest light.
const LIGHT: f64 = 0.05;
/// Where in the γ with light the rings lie: in the beam closer than outside.
const PLACES: [f64; RINGS] = [0.2, 0.45, 0.7, 0.95];
/// Rounds of the search for the displacement.
const ROUNDS: usize = 8;

/// What a block has been swept at.
#[derive(Debug, Default)]
pub struct Chosen {
    planes: Vec<Plane>,
    /// Each with +1 where C rose, −1 where it fell. A ring with a stretch without light is torn, and no part of a
    /// record.
    rings: Vec<(Ring, f64)>,
    /// Whether the last half-plane, and the last ring, were swept to larger angles.
    rose: [bool; 2],
    /// The light of the first half-plane the other way.
    back: Vec<(f64, f64)>,
    /// All sweeps, in their order; each with its range where this is a more sensitive one than that of the first sweep of
    /// its half-plane.
    pub(crate) made: Vec<Pass>,
}

/// The sweep of a half-plane at the speed of the block: γ as its positions have it, and the light, lx.
#[derive(Debug)]
struct Plane {
    c_deg: f64,
    sign: f64,
    light: Vec<(f64, f64)>,
    range: u8,
    digit_lx: f64,
}

/// What the first sweep of a half-plane says.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct PlaneLight {
    /// It, degrees.
    pub c_deg: f64,
    /// Roughly the light at each γ of the block, lx.
    pub lux: Vec<f64>,
    /// Range of the meter that was held, and one digit of it, lx.
    pub range: u8,
    pub digit_lx: f64,
}

/// The sweep that follows.
#[derive(Debug, Clone, PartialEq)]
pub struct Next {
    /// It.
    pub pass: Pass,
    /// Half-planes that are to be swept by what is known, this one the first; empty before any is chosen.
    pub c_deg: Vec<f64>,
    /// Why.
    pub reason: String,
}

/// One half of a plane that was swept: C in [0, 360).
struct Half<'a> {
    c_deg: f64,
    /// On which side of γ = 0° it was read.
    side: f64,
    plane: &'a Plane,
}

impl Chosen {
    /// What the sweeps of a record have.
    pub fn of<'a>(block: &Block, sweeps: impl Iterator<Item = &'a SweepRecord>) -> Self {
        let mut chosen = Self::default();
        sweeps.for_each(|sweep| chosen.add(block, sweep));
        chosen
    }

    /// What the sweeps of `resumed` have, by block.
    pub fn by_block(resumed: Option<&Run>) -> HashMap<String, Self> {
        let of_run = |run: &Run| {
            let of_block = |block: &Block| {
                let sweeps = run.sweeps.iter().filter(|sweep| sweep.of.block == block.name);
                (block.name.clone(), Self::of(block, sweeps))
            };
            run.header.plan.blocks().iter().map(of_block).collect()
        };
        resumed.map(of_run).unwrap_or_default()
    }

    /// Takes account of one more sweep.
    pub fn add(&mut self, block: &Block, sweep: &SweepRecord) {
        let light = conversions(sweep);
        let way = sweep.of.way();
        let range = u8::try_from(sweep.of.range).unwrap_or(u8::MAX);
        let held = self
            .planes
            .iter()
            .find(|plane| Some(plane.c_deg) == way.half_plane_deg());
        self.made.push(Pass {
            way,
            speed_deg_s: sweep.of.speed_deg_s,
            range: Some(range).filter(|range| held.is_some_and(|held| *range < held.range)),
        });
        let Some(c_deg) = way.half_plane_deg() else {
            self.rose[1] = way.sign() > 0.0;
            let ring = Ring::of(sweep.of.gamma_deg[0], light.into_iter());
            self.rings.extend(ring.map(|ring| (ring, way.sign())));
            return;
        };
        self.rose[0] = way.sign() > 0.0;
        // Slow sweeps reach less far, and those around gaps too.
        let whole = block.gamma_deg.first().zip(block.gamma_deg.last());
        let [from, to] = way.moving_deg();
        if whole != Some((&from.min(to), &from.max(to))) {
            return;
        }
        match self.planes.iter().find(|plane| plane.c_deg == c_deg) {
            None => self.planes.push(Plane {
                c_deg,
                sign: way.sign(),
                light,
                range,
                digit_lx: sweep.light.iter().map(|sample| sample.digit_lx).fold(0.0, f64::max),
            }),
            Some(plane) if plane.sign != way.sign() && self.back.is_empty() => self.back = light,
            Some(_) => {}
        }
    }

    /// Whether a half-plane was swept.
    pub fn has(&self, c_deg: f64) -> bool {
        self.planes.iter().any(|plane| plane.c_deg == c_deg)
    }

    /// Rings that were swept.
    pub fn rings(&self) -> usize {
        self.rings.len()
    }

    /// The sweep that follows the first half-plane; none where the target is reached or nothing is left to choose from.
    pub fn next(&self, block: &Block) -> Option<Next> {
        let (target, speed_deg_s) = (block.target?, block.sweep_deg_s?);
        let across = across(block)?;
        let plane = |c_deg: f64, planned: Vec<f64>, reason: String| {
            let (low, high) = (*block.gamma_deg.first()?, *block.gamma_deg.last()?);
            let gamma_deg = if self.rose[0] { [high, low] } else { [low, high] };
            Some(Next {
                pass: Pass {
                    way: Way::HalfPlane { c_deg, gamma_deg },
                    speed_deg_s,
                    range: None,
                },
                c_deg: planned,
                reason,
            })
        };
        if !self.has(across) {
            return plane(
                across,
                Vec::new(),
                "two half-planes show at which γ rings lie".to_owned(),
            );
        }
        if self.rings.len() < RINGS {
            let gamma_deg = self.ring_gammas(block)[self.rings.len()];
            return Some(Next {
                pass: ring(gamma_deg, !self.rose[1], speed_deg_s),
                c_deg: Vec::new(),
                reason: "rings show where the light changes over C".to_owned(),
            });
        }
        let (by_rings, reason) = self.by_rings(block, target, across);
        let left: Vec<f64> = by_rings.into_iter().filter(|c| !self.has(*c)).collect();
        if let Some(first) = left.first() {
            return plane(*first, left, reason);
        }
        let (c_deg, reason) = self.by_left_out(block, target)?;
        plane(c_deg, vec![c_deg], reason)
    }

    /// How far the rings differ from the symmetry that the half-planes of `block` assume; none before they are swept.
    pub fn asymmetry(&self, block: &Block) -> Option<(Symmetry, Asymmetry)> {
        let symmetry = assumed(block).ok()?;
        let rings: Vec<(&Ring, f64)> = self.rings.iter().map(|(ring, sign)| (ring, *sign)).collect();
        let swept = (self.rings.len() >= RINGS).then(|| Asymmetry::of(&rings, symmetry));
        Some((symmetry, swept.flatten()?))
    }

    /// γ of the rings, rising: over those at which the half-planes before them, one or two, have light.
    pub fn ring_gammas(&self, block: &Block) -> [f64; RINGS] {
        let light: Vec<(f64, f64)> = self
            .planes
            .iter()
            .take(2)
            .flat_map(|plane| plane.light.clone())
            .collect();
        let largest = light.iter().map(|at| at.1).fold(0.0, f64::max);
        let lit = light.iter().filter(|at| at.1 >= LIGHT * largest).map(|at| at.0.abs());
        let (low, high) = lit.fold((f64::INFINITY, 0.0_f64), |(low, high), gamma| {
            (low.min(gamma), high.max(gamma))
        });
        let end = block.gamma_deg.last().copied().unwrap_or(0.0);
        let (low, high) = if low < high { (low, high.min(end)) } else { (0.0, end) };
        // Whole degrees are easier to talk about.
        PLACES.map(|place| (low + place * (high - low)).round().max(1.0).min(end))
    }

    /// Half-planes that are needed by what splines miss of the rings, rising, and what that is.
    fn by_rings(&self, block: &Block, target: PlaneTarget, across: f64) -> (Vec<f64>, String) {
        let rings: Vec<&Ring> = self.rings.iter().map(|(ring, _)| ring).collect();
        let mut set = vec![block.c_deg[0], across];
        set.sort_by(f64::total_cmp);
        loop {
            let halves = block.half_planes_deg(&set);
            let gaps = by_gap(&rings, &halves, target, self.largest());
            let missed = whole(&gaps, target);
            let mut order: Vec<usize> = (0..gaps.len()).collect();
            order.sort_by(|a, b| gaps[*b].abs().total_cmp(&gaps[*a].abs()));
            let beyond = u_beyond_rings(missed) > wanted(target);
            let add = order.into_iter().find_map(|gap| {
                let wanting = match target {
                    PlaneTarget::UMapRel(wanted) => u_beyond_rings(gaps[gap]) > wanted,
                    PlaneTarget::UFluxRel(_) => gaps[gap] != 0.0,
                };
                wanting.then(|| middle(block, &set, &halves, gap)).flatten()
            });
            let Some(c_deg) = add.filter(|_| beyond) else {
                let reason = format!(
                    "{} half-planes are needed: of the {} rings a spline through them misses {:.2} % {}, which is u = \
                     {:.2} % (k = 1); wanted is {:.2} %",
                    halves.len(),
                    rings.len(),
                    100.0 * missed,
                    of_what(target),
                    100.0 * u_beyond_rings(missed),
                    100.0 * wanted(target)
                );
                return (set, reason);
            };
            set.push(c_deg);
            set.sort_by(f64::total_cmp);
        }
    }

    /// The half-plane that is wanted most by what splines miss of those that are left out in turn.
    fn by_left_out(&self, block: &Block, target: PlaneTarget) -> Option<(f64, String)> {
        let read = self.read(block);
        let swept: Vec<f64> = self.planes.iter().map(|plane| plane.c_deg).collect();
        let mut worst: Vec<(usize, f64)> = read.left_out(target, self.largest())?.into_iter().enumerate().collect();
        let centres = read.c_deg;
        worst.sort_by(|a, b| b.1.total_cmp(&a.1));
        let wanting = worst
            .into_iter()
            .filter(|(_, missed)| OF_LEFT_OUT * missed > wanted(target));
        let found = wanting.flat_map(|(out, missed)| {
            let before = (out + centres.len() - 1) % centres.len();
            let width = |gap: usize| (centres[(gap + 1) % centres.len()] - centres[gap]).rem_euclid(360.0);
            let gaps = if width(before) > width(out) {
                [before, out]
            } else {
                [out, before]
            };
            gaps.map(|gap| (out, missed, gap))
        });
        let (c_deg, out, missed) = found
            .into_iter()
            .find_map(|(out, missed, gap)| Some((middle(block, &swept, &centres, gap)?, out, missed)))?;
        let reason = format!(
            "a spline through the other {} half-planes misses the one at C {}° by {:.2} % {}; wanted is {:.2} % in \
             gaps half as wide",
            centres.len() - 1,
            centres[out],
            100.0 * missed,
            of_what(target),
            100.0 * wanted(target)
        );
        Some((c_deg, reason))
    }

    /// The largest light of all, lx.
    fn largest(&self) -> f64 {
        let planes = self.planes.iter().flat_map(|plane| &plane.light).map(|at| at.1);
        let rings = self.rings.iter().map(|(ring, _)| ring.largest());
        planes.chain(rings).fold(f64::MIN_POSITIVE, f64::max)
    }

    /// The light of every half-plane that was swept, in their order.
    pub(crate) fn light(&self, block: &Block) -> Vec<PlaneLight> {
        let shift_deg = self.shift_deg(block);
        let of_plane = |plane: &Plane| PlaneLight {
            c_deg: plane.c_deg,
            lux: block
                .gamma_deg
                .iter()
                .map(|gamma| along(&plane.light, gamma - plane.sign * shift_deg))
                .collect(),
            range: plane.range,
            digit_lx: plane.digit_lx,
        };
        self.planes.iter().map(of_plane).collect()
    }

    fn halves(&self, block: &Block) -> Vec<Half<'_>> {
        let sides: &[f64] = if goes_both_ways(block) { &[1.0, -1.0] } else { &[1.0] };
        let mut halves: Vec<Half<'_>> = self
            .planes
            .iter()
            .flat_map(|plane| sides.iter().map(move |side| (plane, *side)))
            .map(|(plane, side)| Half {
                c_deg: (plane.c_deg + if side < 0.0 { 180.0 } else { 0.0 }).rem_euclid(360.0),
                side,
                plane,
            })
            .collect();
        halves.sort_by(|a, b| a.c_deg.total_cmp(&b.c_deg));
        halves.dedup_by(|later, earlier| later.c_deg == earlier.c_deg);
        halves
    }

    /// By how much the light of a sweep to larger γ is displaced against its positions, degrees: that at which the
    /// first half-plane is the same both ways.
    fn shift_deg(&self, block: &Block) -> f64 {
        let Some(forward) = self.planes.first().filter(|_| self.back.len() > 2) else {
            return 0.0;
        };
        let mut shift = 0.0;
        for _ in 0..ROUNDS {
            let (mut square, mut product) = (0.0, 0.0);
            for gamma in &block.gamma_deg {
                let side = |by: f64| forward.sign * by;
                let there = |by: f64| along(&forward.light, gamma - side(by));
                let back = |by: f64| along(&self.back, gamma + side(by));
                let difference = there(shift) - back(shift);
                let slope = there(shift + 0.5) - back(shift + 0.5) - there(shift - 0.5) + back(shift - 0.5);
                square += slope * slope;
                product += slope * difference;
            }
            if square <= 0.0 {
                return 0.0;
            }
            shift -= product / square;
        }
        if shift.is_finite() { shift } else { 0.0 }
    }
}

impl Half<'_> {
    /// The light at an unsigned γ.
    fn at(&self, gamma_deg: f64, shift_deg: f64) -> f64 {
        along(&self.plane.light, self.side * gamma_deg - self.plane.sign * shift_deg)
    }
}

/// Straight between the conversions, the nearest one beyond them; 0 where there are none.
fn along(light: &[(f64, f64)], gamma_deg: f64) -> f64 {
    let next = light.partition_point(|at| at.0 < gamma_deg);
    match (
        next.checked_sub(1).and_then(|before| light.get(before)),
        light.get(next),
    ) {
        (Some(a), Some(b)) => a.1 + (b.1 - a.1) * (gamma_deg - a.0) / (b.0 - a.0),
        (Some(one), None) | (None, Some(one)) => one.1,
        (None, None) => 0.0,
    }
}

/// The symmetry that the half-planes of a block assume.
///
/// # Errors
/// [`NotRound`] where a part of the circle is missing that no symmetry gives.
pub fn assumed(block: &Block) -> Result<Symmetry, NotRound> {
    Circle::of(&block.half_planes_deg(&block.c_deg)).map(|circle| circle.assumed)
}

/// Whether a sweep reads the half-plane opposite, too.
fn goes_both_ways(block: &Block) -> bool {
    block.gamma_deg.first().is_some_and(|gamma| *gamma < 0.0)
}

/// The half-plane nearest to a quarter of the circle from the first.
fn across(block: &Block) -> Option<f64> {
    let first = *block.c_deg.first()?;
    let off = |c: &&f64| (**c - first - 90.0).abs();
    block
        .c_deg
        .iter()
        .skip(1)
        .min_by(|a, b| off(a).total_cmp(&off(b)))
        .copied()
}

/// The half-plane that may be swept and reads the nearest to the middle between `halves[gap]` and the next; none where
/// none lies between them that is not in `swept`.
fn middle(block: &Block, swept: &[f64], halves: &[f64], gap: usize) -> Option<f64> {
    let width = (halves[(gap + 1) % halves.len()] - halves[gap]).rem_euclid(360.0);
    let width = if width == 0.0 { 360.0 } else { width };
    let free = block.c_deg.iter().filter(|c| !swept.contains(c));
    let reads = free.flat_map(|c| block.half_planes_deg(&[*c]).into_iter().map(move |half| (*c, half)));
    let off = |half: f64| ((half - halves[gap]).rem_euclid(360.0) - 0.5 * width).abs();
    let inside = reads.filter(|(_, half)| {
        let way = (half - halves[gap]).rem_euclid(360.0);
        way > 1e-6 && way < width - 1e-6
    });
    inside.min_by(|a, b| off(a.1).total_cmp(&off(b.1))).map(|(c, _)| c)
}

/// What splines miss between each half-plane and the next, relative: the largest of all rings, or what it makes of the
/// flux.
fn by_gap(rings: &[&Ring], halves: &[f64], target: PlaneTarget, largest: f64) -> Vec<f64> {
    let missed: Vec<_> = rings.iter().map(|ring| ring.missed(halves)).collect();
    let gamma_deg: Vec<f64> = rings.iter().map(|ring| ring.gamma_deg).collect();
    let weights = bands(&gamma_deg);
    let flux: f64 = rings
        .iter()
        .zip(&weights)
        .map(|(ring, weight)| weight * ring.mean())
        .sum();
    let of_gap = |gap: usize| match target {
        PlaneTarget::UMapRel(_) => missed.iter().map(|ring| ring[gap].largest).fold(0.0, f64::max) / largest,
        PlaneTarget::UFluxRel(_) => {
            let width = (halves[(gap + 1) % halves.len()] - halves[gap]).rem_euclid(360.0) / 360.0;
            let sum: f64 = missed
                .iter()
                .zip(&weights)
                .map(|(ring, weight)| weight * ring[gap].mean)
                .sum();
            sum * width / flux.max(f64::MIN_POSITIVE)
        }
    };
    (0..halves.len()).map(of_gap).collect()
}

/// What all gaps together miss.
fn whole(gaps: &[f64], target: PlaneTarget) -> f64 {
    match target {
        PlaneTarget::UMapRel(_) => gaps.iter().copied().fold(0.0, f64::max),
        PlaneTarget::UFluxRel(_) => gaps.iter().map(|gap| gap.abs()).sum(),
    }
}

fn wanted(target: PlaneTarget) -> f64 {
    let (PlaneTarget::UMapRel(wanted) | PlaneTarget::UFluxRel(wanted)) = target;
    wanted
}

fn of_what(target: PlaneTarget) -> &'static str {
    match target {
        PlaneTarget::UMapRel(_) => "of the largest light",
        PlaneTarget::UFluxRel(_) => "of the flux",
    }
}

#[cfg(test)]
pub(crate) mod tests {
    use camino::Utf8Path;
    use isolux_photometry::AroundSpline;
    use isolux_record::plan::Plan;
    use isolux_record::sweeps::{LightSample, PositionSample, SweepOf};

    use super::*;

    pub(in crate::chosen) fn block(target: &str) -> Block {
        let text = format!(
            "format = \"isolux-plan/1\"\n[[block]]\nname = \"a\"\nkind = \"lit\"\nmode = \"sweep\"\n\
             c_range = [0, 175, 5]\ngamma_range = [-90, 90, 2]\ntarget = {{ {target} }}\n"
        );
        Plan::parse(Utf8Path::new("p.toml"), &text).unwrap().blocks()[0].clone()
    }

    /// The record of a pass over `light(C, γ)`, a conversion every 0.13 s, displaced by 0.8°, with noise of 0.2 %.
    pub(crate) fn swept(index: u64, pass: &Pass, light: &dyn Fn(f64, f64) -> f64) -> SweepRecord {
        let [from, to] = pass.way.moving_deg();
        let sign = pass.way.sign();
        let at = |time_s: f64| from + sign * pass.speed_deg_s * time_s;
        let end_s = (to - from).abs() / pass.speed_deg_s;
        let count = (end_s / 0.13) as usize;
        let (c_target_deg, gamma_from) = pass.from_deg();
        let (c_to, gamma_to) = pass.to_deg();
        let ring = pass.way.half_plane_deg().is_none();
        SweepRecord {
            of: SweepOf {
                index,
                block: "a".to_owned(),
                point: index,
                torn: None,
                c_deg: c_target_deg,
                c_target_deg,
                ring_to_c_deg: ring.then_some(c_to),
                gamma_deg: [gamma_from, gamma_to],
                speed_deg_s: pass.speed_deg_s,
                distance_mm: 3700.0,
                range: 3,
                integration_s: 0.1,
                update_interval_s: None,
                lamp_on_s: None,
                ambient_c: None,
                session: 0,
                burning: 0,
            },
            positions: (0..=(end_s / 0.05) as usize + 2)
                .map(|k| PositionSample {
                    answered_s: 0.05 * k as f64,
                    place_deg: at(0.05 * k as f64),
                })
                .collect(),
            light: (0..count)
                .map(|k| {
                    let asked_s = 0.13 * k as f64;
                    let (c, gamma) = pass.way.at_deg(at(asked_s + 0.05) + sign * 0.8);
                    let (c, gamma) = if gamma < 0.0 { (c + 180.0, -gamma) } else { (c, gamma) };
                    let noise = 1.0 + 0.003 * (78.233 * (k as f64 + 400.0 * index as f64)).sin();
                    LightSample {
                        asked_s,
                        answered_s: asked_s + 0.11,
                        illuminance_lx: Some(light(c.rem_euclid(360.0), gamma) * noise),
                        digit_lx: 0.0,
                        raw: String::new(),
                    }
                })
                .collect(),
        }
    }

    /// The whole scan: what was swept, in its order.
    pub(in crate::chosen) fn scan(block: &Block, light: &dyn Fn(f64, f64) -> f64) -> (Vec<SweepRecord>, Vec<Next>) {
        let (mut chosen, mut records, mut said) = (Chosen::default(), Vec::new(), Vec::new());
        let first = block.passes().into_iter().take(4);
        for pass in first {
            records.push(swept(records.len() as u64, &pass, light));
            chosen.add(block, &records[records.len() - 1]);
        }
        while let Some(next) = chosen.next(block) {
            records.push(swept(records.len() as u64, &next.pass, light));
            chosen.add(block, &records[records.len() - 1]);
            said.push(next);
            assert!(records.len() < 60, "it comes to an end");
        }
        (records, said)
    }

    fn planes(said: &[Next]) -> Vec<f64> {
        said.iter().filter_map(|next| next.pass.way.half_plane_deg()).collect()
    }

    pub(in crate::chosen) fn lobe(gamma: f64) -> f64 {
        100.0 * gamma.to_radians().cos().powi(3)
    }

    #[test]
    fn a_lamp_that_is_round_needs_two_half_planes_and_four_rings() {
        let (records, said) = scan(&block("u_map_rel = 0.02"), &|_, gamma| lobe(gamma));
        assert_eq!(planes(&said), [90.0]);
        assert_eq!(records.len(), 4 + 1 + RINGS);
        let rings: Vec<f64> = records
            .iter()
            .filter(|one| one.of.ring_to_c_deg.is_some())
            .map(|one| one.of.gamma_deg[0])
            .collect();
        // 5 % of a cosine to the third power are left at 68°, and the conversions stand 0.8° beside it.
        assert_eq!(rings, [14.0, 31.0, 49.0, 66.0]);
    }

    #[test]
    fn where_the_light_changes_over_c_half_planes_are_closer() {
        let light = |c: f64, gamma: f64| {
            let narrow = (-0.5 * ((c - 100.0) / 20.0).powi(2)).exp();
            lobe(gamma) * (1.0 + 0.5 * gamma.to_radians().sin() * narrow)
        };
        let (_, said) = scan(&block("u_map_rel = 0.02"), &light);
        let found = planes(&said);
        let near = found.iter().filter(|c| (**c - 100.0).abs() <= 40.0).count();
        assert!(found.len() < 16 && near >= found.len() - near, "{found:?}");
        assert!(
            said.last().unwrap().reason.contains("wanted is 2.00 %"),
            "{:?}",
            said.last()
        );
        // The splines through what was swept, against the light, everywhere.
        let mut halves: Vec<f64> = found.iter().chain([&0.0]).flat_map(|c| [*c, c + 180.0]).collect();
        halves.sort_by(f64::total_cmp);
        for gamma in (0..45).map(|k| 2.0 * f64::from(k)) {
            let there: Vec<f64> = halves.iter().map(|c| light(*c, gamma)).collect();
            let spline = AroundSpline::through(&halves, &there);
            let worst = (0..144)
                .map(|k| 2.5 * f64::from(k))
                .map(|c| (spline.at(c) - light(c, gamma)).abs());
            assert!(worst.fold(0.0, f64::max) < 2.0, "γ {gamma}");
        }
        let coarse = planes(&scan(&block("u_map_rel = 0.1"), &light).1);
        assert!(coarse.len() < found.len(), "{coarse:?} {found:?}");
        let flux = planes(&scan(&block("u_flux_rel = 0.02"), &light).1);
        assert!(flux.len() < found.len(), "{flux:?}");
    }

    #[test]
    fn what_rings_do_not_see_left_out_half_planes_do() {
        // Three blades of light at γ 80°, behind the last ring.
        let light = |c: f64, gamma: f64| {
            let blade = (-0.5 * ((gamma - 80.0) / 4.0).powi(2)).exp();
            lobe(gamma) + 40.0 * blade * (3.0 * c.to_radians()).cos().max(0.0)
        };
        let dim = |c: f64, gamma: f64| {
            if gamma > 68.0 && gamma < 88.0 {
                0.1 * light(c, gamma)
            } else {
                lobe(gamma)
            }
        };
        let block = block("u_map_rel = 0.005");
        let (records, said) = scan(&block, &dim);
        let by_left_out = said
            .iter()
            .filter(|next| next.reason.contains("through the other"))
            .count();
        assert!(by_left_out > 0, "{:?}", planes(&said));
        // And what is shown as not known holds them.
        for (made, next) in (4..).zip(&said) {
            let known = Chosen::of(&block, records[..made].iter()).known(&block);
            let u_rel = known.map_or(f64::INFINITY, |known| known.u_rel);
            assert!(
                u_rel > 0.005 || next.reason.contains("half-planes are needed"),
                "after {made}: {u_rel}"
            );
        }
    }

    #[test]
    fn a_scan_that_is_taken_up_again_goes_on_as_it_would_have() {
        let light =
            |c: f64, gamma: f64| lobe(gamma) * (1.0 + 0.3 * gamma.to_radians().sin() * (3.0 * c.to_radians()).cos());
        let block = block("u_map_rel = 0.02");
        let (records, said) = scan(&block, &light);
        for (place, next) in said.iter().enumerate() {
            let again = Chosen::of(&block, records[..4 + place].iter());
            assert_eq!(again.next(&block).as_ref(), Some(next), "after {place}");
        }
        assert_eq!(Chosen::of(&block, records.iter()).next(&block), None);
    }

    #[test]
    fn displacement_is_found_by_the_pair() {
        let block = block("u_map_rel = 0.02");
        let (records, _) = scan(&block, &|_, gamma| lobe(gamma));
        let found = Chosen::of(&block, records.iter()).shift_deg(&block);
        assert!((found - 0.8).abs() < 0.1, "{found}");
    }
}
