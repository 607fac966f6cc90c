//! Where sweeps have light.

use std::collections::HashMap;

use isolux_record::Run;
use isolux_record::plan::{Block, Pass, Way};
use isolux_record::sweeps::SweepRecord;

use crate::conversions::conversions;
use crate::sweeps::step_deg;

/// The widest way without light, in those between most conversions: a curve bridges one that is lost.
const BRIDGED: f64 = 2.5;
/// Steps of γ that a further sweep reaches to both sides of its gaps: a curve is held from both sides.
const MARGIN: usize = 8;

/// By block and half-plane: what its sweeps have light at.
#[derive(Debug, Default)]
pub(super) struct Coverage {
    planes: HashMap<(String, u64), Plane>,
}

#[derive(Debug, Default)]
struct Plane {
    /// γ of the plan at which a sweep has light, by their number in the block.
    illuminated: Vec<bool>,
    /// The nearest conversion to each of them: how far off, degrees, and what it said, lx.
    nearest: Vec<Option<(f64, f64)>>,
    /// Sweeps of it so far.
    count: u32,
    /// Direction of the last one.
    sign: f64,
}

impl Coverage {
    /// What the sweeps of `resumed` have.
    pub fn of(resumed: Option<&Run>) -> Self {
        let mut coverage = Self::default();
        if let Some(run) = resumed {
            for block in run.header.plan.blocks() {
                let of_block = run.sweeps.iter().filter(|sweep| sweep.of.block == block.name);
                of_block.for_each(|sweep| coverage.add(block, sweep));
            }
        }
        coverage
    }

    /// Takes account of one more sweep.
    pub fn add(&mut self, block: &Block, sweep: &SweepRecord) {
        let way = sweep.of.way();
        if way.half_plane_deg().is_none() {
            // A ring is no result: where it has gaps it shows less.
            return;
        }
        let key = (block.name.clone(), sweep.of.c_target_deg.to_bits());
        let plane = self.planes.entry(key).or_default();
        plane.illuminated.resize(block.gamma_deg.len(), false);
        plane.count += 1;
        plane.sign = way.sign();
        let conversions = conversions(sweep);
        plane.nearest.resize(block.gamma_deg.len(), None);
        for (nearest, gamma_deg) in plane.nearest.iter_mut().zip(&block.gamma_deg) {
            let off = |at: &(f64, f64)| ((at.0 - gamma_deg).abs(), at.1);
            let here = conversions.iter().map(off).min_by(|a, b| a.0.total_cmp(&b.0));
            *nearest = nearest.iter().copied().chain(here).min_by(|a, b| a.0.total_cmp(&b.0));
        }
        let lit_deg: Vec<f64> = conversions.iter().map(|at| at.0).collect();
        let mut between: Vec<f64> = lit_deg.windows(2).map(|pair| pair[1] - pair[0]).collect();
        between.sort_by(f64::total_cmp);
        let usual_deg = between.get(between.len() / 2).copied().unwrap_or(f64::INFINITY);
        let allowed_deg = step_deg(block).max(BRIDGED * usual_deg);
        for (illuminated, gamma_deg) in plane.illuminated.iter_mut().zip(&block.gamma_deg) {
            let next = lit_deg.partition_point(|at| at < gamma_deg);
            let gap_deg = match (next.checked_sub(1).map(|before| lit_deg[before]), lit_deg.get(next)) {
                (Some(before), Some(after)) => after - before,
                // At its ends a curve is held from one side.
                (Some(one), None) => 1.5 * (gamma_deg - one),
                (None, Some(one)) => 1.5 * (one - gamma_deg),
                (None, None) => f64::INFINITY,
            };
            *illuminated |= gap_deg <= allowed_deg;
        }
    }

    /// C, γ in degrees and roughly the light in lx, of every direction of `block` that has any, in the order of the
    /// plan.
    pub fn light(&self, block: &Block) -> Vec<(f64, f64, f64)> {
        let of_plane = |c_deg: &f64| {
            let plane = self.planes.get(&(block.name.clone(), c_deg.to_bits()))?;
            let near = block.gamma_deg.iter().zip(&plane.nearest);
            let cells = near.filter_map(|(gamma_deg, nearest)| Some((*c_deg, *gamma_deg, nearest.as_ref()?.1)));
            Some(cells.collect::<Vec<_>>())
        };
        block.c_deg.iter().filter_map(of_plane).flatten().collect()
    }

    /// Whether a half-plane of `block` that was swept has no light somewhere.
    pub fn lacks(&self, block: &Block) -> bool {
        self.lacking(block).is_some()
    }

    /// The sweep that would fill the gaps of a half-plane of `block`: of those, the one that was swept least often.
    pub fn lacking(&self, block: &Block) -> Option<Pass> {
        let speed_deg_s = block.sweep_deg_s?;
        let lacking = |c_deg: &f64| {
            let plane = self.planes.get(&(block.name.clone(), c_deg.to_bits()))?;
            let first = plane.illuminated.iter().position(|illuminated| !illuminated)?;
            let last = plane.illuminated.iter().rposition(|illuminated| !illuminated)?;
            let low = block.gamma_deg[first.saturating_sub(MARGIN)];
            let high = block.gamma_deg[(last + MARGIN).min(block.gamma_deg.len() - 1)];
            let gamma_deg = if plane.sign > 0.0 { [high, low] } else { [low, high] };
            let pass = Pass {
                way: Way::HalfPlane {
                    c_deg: *c_deg,
                    gamma_deg,
                },
                speed_deg_s,
                range: None,
            };
            Some((plane.count, pass))
        };
        let passes = block.c_deg.iter().filter_map(lacking);
        passes.min_by_key(|(count, _)| *count).map(|(_, pass)| pass)
    }

    /// The half-planes of `block` with their first γ without light, as words.
    pub fn words(&self, block: &Block) -> String {
        let of = |c_deg: &f64| {
            let plane = self.planes.get(&(block.name.clone(), c_deg.to_bits()))?;
            let first = plane.illuminated.iter().position(|illuminated| !illuminated)?;
            Some(format!("C {c_deg}° near γ {}°", block.gamma_deg[first]))
        };
        block.c_deg.iter().filter_map(of).collect::<Vec<String>>().join(", ")
    }
}
