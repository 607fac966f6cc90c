//! What is known of the light between the half-planes that were swept, as the choice of the next one has it.

use isolux_photometry::{
    AroundSpline, MissedOfRing, OF_LEFT_OUT, ReadHalfPlanes, Ring, left_out, u_between, u_beyond_rings,
};
use isolux_record::plan::{Block, Pass, PlaneTarget, RINGS, Way};

use super::{Chosen, Next, by_gap, whole};

/// The light around the circle by the half-planes that were swept, and what a spline between them leaves open.
#[derive(Debug, Clone, PartialEq)]
pub struct Known {
    /// Half-planes that were swept, in [0, 360), rising, degrees.
    pub read_c_deg: Vec<f64>,
    /// γ of the block, unsigned, rising, degrees.
    pub gamma_deg: Vec<f64>,
    /// The largest light of all, lx.
    pub largest_lx: f64,
    /// What the target of the block is held against: standard uncertainty (k = 1) of any direction in shares of the
    /// largest light, or of the flux, relative.
    pub u_rel: f64,
    /// By γ: roughly the light in each half-plane that was swept, lx.
    lux: Vec<Vec<f64>>,
    /// By γ: standard uncertainty of the spline from each half-plane to the next, lx.
    u_lx: Vec<Vec<f64>>,
}

/// The half-planes that were swept, at every γ but the poles.
pub(super) struct Read {
    pub c_deg: Vec<f64>,
    pub gamma_deg: Vec<f64>,
    /// By γ and half-plane, lx.
    pub lux: Vec<Vec<f64>>,
}

/// Half-planes from which on one can be left out.
const LEAST: usize = 4;

impl Read {
    /// What the spline through the others misses of each half-plane, relative: anywhere, or what it makes of the flux.
    /// None where there are too few.
    pub fn left_out(&self, target: PlaneTarget, largest_lx: f64) -> Option<Vec<f64>> {
        let count = self.c_deg.len();
        if count < LEAST {
            return None;
        }
        let sine = |gamma: &f64| gamma.to_radians().sin();
        let rows = self.gamma_deg.iter().zip(&self.lux);
        let flux: f64 = rows
            .map(|(gamma, lux)| sine(gamma) * lux.iter().sum::<f64>() / count as f64)
            .sum();
        let errors: Vec<Vec<f64>> = self.lux.iter().map(|lux| left_out(&self.c_deg, lux)).collect();
        let missed = |out: usize| match target {
            PlaneTarget::UMapRel(_) => {
                let largest = errors.iter().map(|row| row[out].abs()).fold(0.0, f64::max);
                largest / largest_lx
            }
            PlaneTarget::UFluxRel(_) => {
                let wide = (self.c_deg[(out + 1) % count] - self.c_deg[(out + count - 1) % count]).rem_euclid(360.0);
                let rows = self.gamma_deg.iter().zip(&errors);
                let sum: f64 = rows.map(|(gamma, row)| sine(gamma) * row[out]).sum();
                sum.abs() / flux * wide / 360.0
            }
        };
        Some((0..count).map(missed).collect())
    }
}

impl Chosen {
    /// What was swept, at every γ but the poles.
    pub(super) fn read(&self, block: &Block) -> Read {
        let halves = self.halves(block);
        let shift_deg = self.shift_deg(block);
        let inside = |gamma: &f64| *gamma > 0.0 && *gamma < 180.0;
        let gamma_deg: Vec<f64> = block.gamma_deg.iter().copied().filter(inside).collect();
        let at = |gamma: &f64| halves.iter().map(|half| half.at(*gamma, shift_deg)).collect();
        Read {
            c_deg: halves.iter().map(|half| half.c_deg).collect(),
            lux: gamma_deg.iter().map(at).collect(),
            gamma_deg,
        }
    }

    /// What is known between the half-planes of a block with a target; none before all rings are swept.
    pub fn known(&self, block: &Block) -> Option<Known> {
        let target = block.target?;
        let rings: Vec<&Ring> = self.rings.iter().map(|(ring, _)| ring).collect();
        let read = self.read(block);
        if rings.len() < RINGS {
            return None;
        }
        let largest_lx = self.largest();
        let left_out = read.left_out(target, largest_lx)?;
        let by_rings = whole(&by_gap(&rings, &read.c_deg, target, largest_lx), target);
        let by_left_out = left_out.into_iter().fold(0.0, f64::max);
        let mut missed: Vec<MissedOfRing> = rings
            .iter()
            .map(|ring| MissedOfRing {
                gamma_deg: ring.gamma_deg,
                largest: ring.missed(&read.c_deg).iter().map(|gap| gap.largest).collect(),
            })
            .collect();
        missed.sort_by(|a, b| a.gamma_deg.total_cmp(&b.gamma_deg));
        let half_planes = ReadHalfPlanes {
            c_deg: &read.c_deg,
            gamma_deg: &read.gamma_deg,
            light: &read.lux,
        };
        let u_lx = u_between(&half_planes, &missed);
        let u_rel = u_beyond_rings(by_rings).max(OF_LEFT_OUT * by_left_out);
        Some(self.with_poles(block, read, u_lx, (largest_lx, u_rel)))
    }

    /// At a pole all half-planes read one direction, and nothing lies between them.
    fn with_poles(&self, block: &Block, read: Read, u_lx: Vec<Vec<f64>>, (largest_lx, u_rel): (f64, f64)) -> Known {
        let (halves, shift_deg) = (self.halves(block), self.shift_deg(block));
        let count = halves.len();
        let mut rows: Vec<(f64, Vec<f64>, Vec<f64>)> = read
            .gamma_deg
            .into_iter()
            .zip(read.lux)
            .zip(u_lx)
            .map(|((gamma, lux), u_lx)| (gamma, lux, u_lx))
            .collect();
        for pole in [0.0, 180.0] {
            if block.gamma_deg.contains(&pole) {
                let mean = halves.iter().map(|half| half.at(pole, shift_deg)).sum::<f64>() / count as f64;
                rows.push((pole, vec![mean; count], vec![0.0; count]));
            }
        }
        rows.sort_by(|a, b| a.0.total_cmp(&b.0));
        Known {
            read_c_deg: read.c_deg,
            gamma_deg: rows.iter().map(|row| row.0).collect(),
            largest_lx,
            u_rel,
            lux: rows.iter().map(|row| row.1.clone()).collect(),
            u_lx: rows.into_iter().map(|row| row.2).collect(),
        }
    }

    /// The sweep that follows, before second sweeps and those around gaps: by the plan as long as it says so, then by
    /// what is known.
    pub fn follows(&self, block: &Block) -> Option<Next> {
        let first = block.c_deg.first().copied();
        let of_plan = |pass: &Pass| block.target.is_none() || pass.way.half_plane_deg() == first;
        let mut planned = block.passes().into_iter().filter(of_plan);
        let Some(mut pass) = planned.nth(self.made.len()) else {
            return self.next(block);
        };
        if let Way::Ring { gamma_deg, .. } = &mut pass.way {
            let gammas = self.ring_gammas(block);
            *gamma_deg = gammas.get(self.rings.len()).copied().unwrap_or(*gamma_deg);
        }
        let reason = match pass.way {
            Way::Ring { .. } => "rings show whether the symmetry of the plan holds",
            Way::HalfPlane { c_deg, .. } if Some(c_deg) == first => {
                "the first half-plane is swept both ways: that shows by how much motion displaces the light"
            }
            Way::HalfPlane { .. } => "the plan has the half-planes in this order",
        };
        Some(Next {
            pass,
            c_deg: Vec::new(),
            reason: reason.to_owned(),
        })
    }
}

impl Known {
    /// Light and standard uncertainty of the interpolation in a half-plane at each γ, lx; the latter is 0 where it was
    /// swept.
    pub fn at(&self, c_deg: f64) -> Vec<(f64, f64)> {
        let of_read = self.read_c_deg.iter().position(|read| (read - c_deg).abs() < 1e-6);
        let count = self.read_c_deg.len();
        let gap = (self.read_c_deg.partition_point(|read| *read <= c_deg) + count - 1) % count;
        let rows = self.lux.iter().zip(&self.u_lx);
        rows.map(|(lux, u_lx)| match of_read {
            Some(half) => (lux[half], 0.0),
            None => (AroundSpline::through(&self.read_c_deg, lux).at(c_deg), u_lx[gap]),
        })
        .collect()
    }
}

#[cfg(test)]
mod tests {
    use super::super::tests::{block, lobe, scan};
    use super::*;

    fn three_lobes(c: f64, gamma: f64) -> f64 {
        lobe(gamma) * (1.0 + 0.3 * gamma.to_radians().sin() * (3.0 * c.to_radians()).cos())
    }

    #[test]
    fn what_is_not_known_falls_with_the_half_planes_until_the_target_is_reached() {
        for (target, wanted) in [("u_map_rel = 0.02", 0.02), ("u_flux_rel = 0.002", 0.002)] {
            let block = block(target);
            let (records, said) = scan(&block, &three_lobes);
            let (mut chosen, mut history) = (Chosen::default(), Vec::new());
            for record in &records {
                chosen.add(&block, record);
                history.push(chosen.known(&block).map(|known| known.u_rel));
            }
            // The first half-plane in four sweeps, the one across, the rings.
            let first = 4 + 1 + RINGS - 1;
            assert!(history[..first].iter().all(Option::is_none), "{history:?}");
            let known: Vec<f64> = history[first..].iter().copied().flatten().collect();
            assert_eq!(known.len(), records.len() - first, "{target}");
            assert!(known.len() > 3 && known[0] > wanted, "{known:?}");
            assert_eq!(chosen.next(&block), None);
            let (last, before) = known.split_last().unwrap();
            assert!(*last <= wanted && before.iter().all(|u| u > last), "{known:?}");
            // What is shown as the next sweep is what was swept next.
            let planned = block.passes();
            for made in 0..records.len() {
                let follows = Chosen::of(&block, records[..made].iter()).follows(&block).unwrap();
                assert_eq!(follows.pass.way, records[made].of.way(), "after {made}");
                match made.checked_sub(4) {
                    Some(chosen) => assert_eq!(follows, said[chosen]),
                    None => assert_eq!(follows.pass, planned[made]),
                }
            }
        }
    }

    #[test]
    fn a_half_plane_that_was_swept_is_itself_and_the_others_are_missed_by_what_is_said() {
        let block = block("u_map_rel = 0.02");
        let (records, _) = scan(&block, &three_lobes);
        let chosen = Chosen::of(&block, records.iter());
        let known = chosen.known(&block).unwrap();
        assert_eq!((known.gamma_deg[0], known.gamma_deg.len()), (0.0, 46));
        let (mut most, mut outside, mut count) = (0.0_f64, 0, 0);
        for c in block.half_planes_deg(&block.c_deg) {
            let is_read = known.read_c_deg.contains(&c);
            for (gamma, (lux, u_lx)) in known.gamma_deg.iter().zip(known.at(c)) {
                let error = (lux - three_lobes(c, *gamma)).abs();
                most = most.max(u_lx / known.largest_lx);
                if is_read || *gamma == 0.0 {
                    assert!(
                        u_lx == 0.0 && error < 0.02 * known.largest_lx,
                        "C {c}° γ {gamma}°: {error}"
                    );
                } else {
                    // Noise of 0.2 % beside it.
                    outside += usize::from(error > 2.0 * u_lx + 0.006 * known.largest_lx);
                    count += 1;
                }
            }
        }
        assert!(count > 1000 && outside * 50 < count, "{outside} of {count}");
        assert!(most > 0.0 && most <= known.u_rel, "{most} {}", known.u_rel);
    }

    #[test]
    fn without_a_target_the_plan_says_what_follows() {
        let mut block = block("u_map_rel = 0.02");
        block.target = None;
        let (records, said) = scan(&block, &three_lobes);
        assert_eq!((records.len(), said.len()), (4, 0));
        let chosen = Chosen::of(&block, records.iter());
        assert_eq!(chosen.known(&block), None);
        let follows = chosen.follows(&block).unwrap();
        assert_eq!(follows.pass, block.passes()[4]);
        assert!(follows.reason.contains("in this order"), "{}", follows.reason);
    }
}
