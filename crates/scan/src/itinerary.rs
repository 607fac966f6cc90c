//! Plan → the sequence of visits that the engine makes.

use isolux_record::Role;
use isolux_record::plan::{Block, Order, Pass, Plan};

/// One visit: a pose to drive to, and why.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Visit {
    /// Number of the block in the plan.
    pub block: usize,
    /// A point of the plan, or the reference point.
    pub role: Role,
    /// Number of the plan's point over all blocks, from 0. A reference visit carries the number of the point that
    /// follows, or, at the end of a block, one past its last.
    pub point: u64,
    /// Target C in degrees.
    pub c_deg: f64,
    /// Target γ in degrees; where a sweep begins to be read.
    pub gamma_deg: f64,
    /// The sweep, where the visit is one.
    pub pass: Option<Pass>,
    /// A sweep beside those of the plan, because no sweep of its half-plane has light everywhere.
    pub again: bool,
}

impl Visit {
    /// Where the axes stand after it, (C, γ) in degrees, run-out aside.
    pub fn stands_deg(&self) -> (f64, f64) {
        self.pass.map_or((self.c_deg, self.gamma_deg), |pass| pass.to_deg())
    }
}

/// The reference point: C 0°, γ 0°.
pub const REFERENCE_DEG: (f64, f64) = (0.0, 0.0);

/// Every visit of a plan in order. With `reference_every = n` a block begins and ends at the reference point and
/// returns to it after every n points. Of a block whose half-planes are chosen these are all that may be swept; between
/// them the engine returns to the reference point itself.
pub fn visits(plan: &Plan) -> Vec<Visit> {
    let mut visits = Vec::new();
    let mut point = 0;
    for (index, block) in plan.blocks().iter().enumerate() {
        let reference = |point| Visit {
            block: index,
            role: Role::Reference,
            point,
            c_deg: REFERENCE_DEG.0,
            gamma_deg: REFERENCE_DEG.1,
            pass: None,
            again: false,
        };
        let mut since_reference = 0;
        if block.reference_every.is_some() {
            visits.push(reference(point));
        }
        for (c_deg, gamma_deg, pass) in poses(block) {
            if block.target.is_none() && block.reference_every.is_some_and(|every| since_reference == every) {
                visits.push(reference(point));
                since_reference = 0;
            }
            visits.push(Visit {
                block: index,
                role: Role::Point,
                point,
                c_deg,
                gamma_deg,
                pass,
                again: false,
            });
            point += 1;
            since_reference += 1;
        }
        if block.reference_every.is_some() {
            visits.push(reference(point));
        }
    }
    visits
}

impl Visit {
    /// Whether it is made only where its half-plane, or its ring, is chosen.
    pub fn is_to_be_chosen(&self, block: &Block) -> bool {
        let first = block.c_deg.first().copied();
        block.target.is_some() && self.pass.is_some_and(|pass| pass.way.half_plane_deg() != first)
    }
}

/// Whether the visit at `place` is the last sweep of its block.
pub fn is_last_sweep(visits: &[Visit], place: usize) -> bool {
    let Some(visit) = visits.get(place) else { return false };
    let is_sweep = |later: &Visit| later.block == visit.block && later.pass.is_some();
    is_sweep(visit) && !visits[place + 1..].iter().any(is_sweep)
}

/// Target C and γ of every point, with the sweep where it is one.
fn poses(block: &Block) -> Vec<(f64, f64, Option<Pass>)> {
    if block.sweep_deg_s.is_some() {
        let passes = block.passes().into_iter();
        let pose = |pass: Pass| (pass.from_deg().0, pass.from_deg().1, Some(pass));
        return passes.map(pose).collect();
    }
    let mut poses = Vec::with_capacity(block.c_deg.len() * block.gamma_deg.len());
    for (plane, &c) in block.c_deg.iter().enumerate() {
        let forward = block.gamma_deg.iter().map(|&gamma| (c, gamma, None));
        let reverse = block.gamma_deg.iter().rev().map(|&gamma| (c, gamma, None));
        let falling = block.order == Order::Reverse || block.order == Order::Serpentine && plane % 2 == 1;
        match block.order {
            Order::Both => poses.extend(forward.chain(reverse)),
            _ if falling => poses.extend(reverse),
            _ => poses.extend(forward),
        }
    }
    poses
}

#[cfg(test)]
mod tests {
    use super::*;
    use camino::Utf8Path;

    fn plan(extra: &str) -> Plan {
        let text = format!(
            "format = \"isolux-plan/1\"\n[[block]]\nname = \"a\"\nkind = \"lit\"\nc_deg = [0, 90]\ngamma_deg = [0, 10, 20]\n{extra}\n"
        );
        Plan::parse(Utf8Path::new("p.toml"), &text).unwrap()
    }

    fn gammas(extra: &str) -> Vec<f64> {
        visits(&plan(extra))
            .iter()
            .filter(|visit| visit.role == Role::Point)
            .map(|visit| visit.gamma_deg)
            .collect()
    }

    #[test]
    fn orders_are_what_they_are_called() {
        assert_eq!(gammas(""), [0.0, 10.0, 20.0, 0.0, 10.0, 20.0]);
        assert_eq!(gammas("order = \"reverse\""), [20.0, 10.0, 0.0, 20.0, 10.0, 0.0]);
        assert_eq!(gammas("order = \"serpentine\""), [0.0, 10.0, 20.0, 20.0, 10.0, 0.0]);
        assert_eq!(gammas("order = \"both\"").len(), 12);
    }

    #[test]
    fn the_reference_is_visited_first_between_and_last() {
        let visits = visits(&plan("reference_every = 4"));
        let roles: Vec<_> = visits
            .iter()
            .map(|visit| (visit.role == Role::Reference, visit.point))
            .collect();
        assert_eq!(roles[0], (true, 0));
        assert_eq!(roles[5], (true, 4));
        assert_eq!(roles[8], (true, 6));
        assert_eq!(roles.len(), 9);
        assert_eq!(
            visits
                .iter()
                .filter(|v| v.role == Role::Point)
                .map(|v| v.point)
                .collect::<Vec<_>>(),
            [0, 1, 2, 3, 4, 5]
        );
    }
}
