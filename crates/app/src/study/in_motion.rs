//! A scan in motion while it goes on: how uncertain every direction is, which sweep follows and why, and how far it is
//! from its target. All of it follows from the sweeps of the record, so that a scan that is resumed or shown again says
//! the same.

use std::collections::HashMap;

use camino::Utf8Path;
use isolux_record::Run;
use isolux_record::plan::{Block, PlaneTarget, Way};
use isolux_record::sweeps::SweepRecord;
use isolux_reduce::{ReduceError, Sample, in_motion_so_far};
use isolux_scan::{Chosen, Known, Next};
use serde::Serialize;

use crate::Failure;
use crate::run::record;
use crate::simulation::in_motion::{self, light, u_of_strongest_rel};
use crate::simulation::sensor_so_far::{Lit, SCENE};

/// Pixels along the longer edge of the sensor: each has the mean of its area, so that few have the mean of all.
const PIXELS: usize = 16;

/// What the sweeps of a scan say so far.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct InMotion {
    /// The block that is swept.
    pub block: String,
    /// Sweeps of it that were made.
    pub sweeps: usize,
    /// Half-planes of the result, in [0, 360), rising, degrees.
    pub c_deg: Vec<f64>,
    /// γ of the result, rising, degrees.
    pub gamma_deg: Vec<f64>,
    /// By half-plane and γ: standard uncertainty (k = 1) in shares of the largest light so far; none where it is not
    /// known.
    pub u_rel: Vec<Option<f64>>,
    /// Half-planes that were swept, rising, degrees.
    pub swept_c_deg: Vec<f64>,
    /// The largest light so far, E·d² and not corrected, cd; none before a half-plane was swept both ways.
    pub largest_cd: Option<f64>,
    /// The sweep that follows; none where no half-plane is left that is needed.
    pub next: Option<NextSweep>,
    /// How far the block is from its target; none where it has none.
    pub target: Option<Target>,
    /// Expanded uncertainty (k = 2) of the mean on the sensor of the job's scene, relative; none where the job has no
    /// scene.
    pub sensor: Option<Vec<After>>,
}

/// A sweep, and why it is made.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct NextSweep {
    /// In words: the half-plane or the ring.
    pub what: String,
    /// Half-planes of the result that it reads, degrees; none of a ring.
    pub c_deg: Vec<f64>,
    /// γ of a ring, degrees.
    pub ring_gamma_deg: Option<f64>,
    /// Why, as events.jsonl has it.
    pub reason: String,
    /// Half-planes that are to be swept behind it by what is known now, degrees.
    pub later_c_deg: Vec<f64>,
}

/// What the half-planes are chosen for.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Target {
    /// Of what.
    pub of: &'static str,
    /// Standard uncertainty (k = 1) that is wanted, relative.
    pub wanted_rel: f64,
    /// That after each sweep, from that on with which it is known.
    pub after: Vec<After>,
}

/// A number after so many sweeps.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct After {
    /// Sweeps that were made.
    pub sweeps: usize,
    /// The uncertainty.
    pub u_rel: f64,
}

/// What the run directory `run` says of the block that is swept; none before its first sweep is whole.
///
/// # Errors
/// Bad input (exit 2) for what is no run directory, a damaged one, or sweeps that cannot be used.
pub fn in_motion(run: &Utf8Path) -> Result<Option<InMotion>, Failure> {
    let record = record::read(run)?;
    let Some(block) = in_motion::block(&record) else {
        return Ok(None);
    };
    let sweeps = record.sweeps.iter().filter(|sweep| sweep.of.block == block.name);
    let sweeps: Vec<&SweepRecord> = sweeps.collect();
    let samples = match in_motion_so_far(&record, &block.name) {
        // No half-plane was swept both ways yet.
        Err(ReduceError::Sweeps { .. }) => Vec::new(),
        samples => samples.map_err(Failure::bad_input)?,
    };
    let (mut chosen, mut history) = (Chosen::default(), Vec::new());
    for (made, sweep) in (1..).zip(&sweeps) {
        chosen.add(block, sweep);
        history.extend(chosen.known(block).map(|known| (made, known)));
    }
    let map = Map::of(block, &samples, history.last().map(|(_, known)| known));
    let target = block.target.map(|target| {
        let (of, wanted_rel) = match target {
            PlaneTarget::UMapRel(wanted) => ("of any direction, in shares of the largest light", wanted),
            PlaneTarget::UFluxRel(wanted) => ("of the flux", wanted),
        };
        let after = |(sweeps, known): &(usize, Known)| After {
            sweeps: *sweeps,
            u_rel: known.u_rel,
        };
        Target {
            of,
            wanted_rel,
            after: history.iter().map(after).collect(),
        }
    });
    Ok(Some(InMotion {
        block: block.name.clone(),
        sweeps: sweeps.len(),
        next: chosen.follows(block).map(|next| NextSweep::of(block, &next)),
        sensor: sensor(run, &record, block, &history, u_of_strongest_rel(&samples))?,
        c_deg: map.c_deg,
        gamma_deg: map.gamma_deg,
        u_rel: map.u_rel,
        swept_c_deg: map.swept_c_deg,
        largest_cd: map.largest_cd,
        target,
    }))
}

/// U of the mean on the sensor after each sweep; none where the job has no scene.
fn sensor(
    run: &Utf8Path,
    record: &Run,
    block: &Block,
    history: &[(usize, Known)],
    u_reading_rel: f64,
) -> Result<Option<Vec<After>>, Failure> {
    if !run.join(SCENE).is_file() {
        return Ok(None);
    }
    let under = |known: &Known| light(record, block, known, u_reading_rel);
    let Some((_, first)) = history.first() else {
        return Ok(Some(Vec::new()));
    };
    let lit = Lit::of(run, record, &under(first)?, PIXELS)?;
    let mut after = Vec::new();
    for (sweeps, known) in history {
        let u_rel = lit.u_mean_rel(&under(known)?)?;
        after.extend(u_rel.map(|u_rel| After {
            sweeps: *sweeps,
            u_rel: 2.0 * u_rel,
        }));
    }
    Ok(Some(after))
}

impl NextSweep {
    fn of(block: &Block, next: &Next) -> Self {
        let (what, c_deg, ring_gamma_deg) = match next.pass.way {
            Way::HalfPlane { c_deg, .. } => {
                let reads = block.half_planes_deg(&[c_deg]);
                (format!("half-plane C {c_deg}°"), reads, None)
            }
            Way::Ring { gamma_deg, .. } => (format!("ring at γ {gamma_deg}°"), Vec::new(), Some(gamma_deg)),
        };
        Self {
            what,
            c_deg,
            ring_gamma_deg,
            reason: next.reason.clone(),
            later_c_deg: next.c_deg.get(1..).unwrap_or_default().to_vec(),
        }
    }
}

/// The uncertainty of every direction.
struct Map {
    c_deg: Vec<f64>,
    gamma_deg: Vec<f64>,
    u_rel: Vec<Option<f64>>,
    swept_c_deg: Vec<f64>,
    largest_cd: Option<f64>,
}

impl Map {
    /// Of a direction that was swept it is that of its sweeps. Between half-planes it is that of the spline, with that
    /// of the half-plane beside that is known less; before the rings are swept it is not known there.
    fn of(block: &Block, samples: &[Sample], known: Option<&Known>) -> Self {
        let c_deg = block.half_planes_deg(&block.c_deg);
        let mut gamma_deg: Vec<f64> = block.gamma_deg.iter().map(|gamma| gamma.abs()).collect();
        gamma_deg.sort_by(f64::total_cmp);
        gamma_deg.dedup();
        let largest_cd = samples.iter().map(|sample| sample.intensity_cd).reduce(f64::max);
        let mut swept_c_deg: Vec<f64> = samples.iter().map(|sample| sample.c_deg).collect();
        swept_c_deg.dedup();
        let key = |c: f64, gamma: f64| (c.to_bits(), gamma.to_bits());
        let of_samples: HashMap<(u64, u64), f64> = samples
            .iter()
            .map(|sample| (key(sample.c_deg, sample.gamma_deg), sample.u_own_cd()))
            .collect();
        let in_shares = |u_cd: f64| Some(u_cd / largest_cd?);
        let own = |c: f64, gamma: f64| of_samples.get(&key(c, gamma)).copied().and_then(in_shares);
        // All half-planes meet there.
        let of_pole = |gamma: f64| {
            let there = samples.iter().filter(|sample| sample.gamma_deg == gamma);
            there.map(Sample::u_own_cd).reduce(f64::max).and_then(in_shares)
        };
        let of_half_plane = |c: &f64| -> Vec<Option<f64>> {
            let is_swept = swept_c_deg.contains(c);
            let between = known.filter(|_| !is_swept).map(|known| (known, known.at(*c)));
            let beside = beside(&swept_c_deg, *c);
            let u = |gamma: &f64| {
                if *gamma == 0.0 || *gamma == 180.0 {
                    return of_pole(*gamma);
                }
                if is_swept {
                    return own(*c, *gamma);
                }
                let (known, cells) = between.as_ref()?;
                let place = known.gamma_deg.iter().position(|there| there == gamma)?;
                let of_planes = beside.iter().filter_map(|c| own(*c, *gamma)).reduce(f64::max)?;
                Some(of_planes.hypot(cells[place].1 / known.largest_lx))
            };
            gamma_deg.iter().map(u).collect()
        };
        Self {
            u_rel: c_deg.iter().flat_map(of_half_plane).collect(),
            c_deg,
            gamma_deg,
            swept_c_deg,
            largest_cd,
        }
    }
}

/// The half-planes of `swept`, rising, before and behind C.
fn beside(swept: &[f64], c_deg: f64) -> Vec<f64> {
    if swept.is_empty() {
        return Vec::new();
    }
    let behind = swept.partition_point(|swept| *swept < c_deg);
    let count = swept.len();
    vec![swept[(behind + count - 1) % count], swept[behind % count]]
}
