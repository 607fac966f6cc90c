//! A scan that is not finished: its whole half-planes, what stands for the others, and blocks that were not read.
//!
//! A part of the sphere is no luminaire. What was measured is worth showing all the same (is the lamp the right one, is
//! it worth going on?), so the half-planes that are missing are interpolated over C between those that are whole. No
//! result of it carries an uncertainty, and every one says that it is partial.

use std::collections::{BTreeMap, BTreeSet};

use isolux_record::plan::{Block, Instrument};
use isolux_record::{Role, Run};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::direction::{once, order, target};
use crate::samples::{Sample, unsigned};

/// What was read of a scan that is not finished.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Partial {
    /// Half-planes whose every direction was read: C in degrees, rising.
    pub whole_c_deg: Vec<f64>,
    /// Half-planes that the plan asks for, without the closing one, rising.
    pub planned_c_deg: Vec<f64>,
    /// Directions that were read.
    pub directions: usize,
    /// Directions that the plan asks for.
    pub planned_directions: usize,
    /// Blocks of the plan beside the distribution (dark, baffled, spectra, …) of which not every point was read.
    pub unread_blocks: Vec<String>,
}

impl Partial {
    /// From the directions (C, γ) that the plan asks for, those of them that were read, and the other blocks that were
    /// not read to their end; none where no half-plane is whole.
    pub fn of(
        planned: &[(f64, f64)],
        is_read: impl Fn(&(f64, f64)) -> bool,
        unread_blocks: Vec<String>,
    ) -> Option<Self> {
        // By 10⁻⁶ degrees: C as a key.
        let mut planes: BTreeMap<i64, (f64, bool)> = BTreeMap::new();
        for direction in planned {
            let (c_deg, _) = unsigned(direction.0, direction.1);
            let plane = planes.entry((c_deg * 1e6).round() as i64).or_insert((c_deg, true));
            // The closing half-plane is a check of C 0°, which is whole without it.
            plane.1 &= is_read(direction) || direction.0 == 360.0;
        }
        let partial = Self {
            whole_c_deg: planes.values().filter(|plane| plane.1).map(|plane| plane.0).collect(),
            planned_c_deg: planes.values().map(|plane| plane.0).collect(),
            directions: planned.iter().filter(|direction| is_read(direction)).count(),
            planned_directions: planned.len(),
            unread_blocks,
        };
        (!partial.whole_c_deg.is_empty()).then_some(partial)
    }

    /// Whether a direction of the plan belongs to a half-plane that is whole.
    pub fn holds(&self, c_deg: f64, gamma_deg: f64) -> bool {
        let (c_deg, _) = unsigned(c_deg, gamma_deg);
        self.whole_c_deg.iter().any(|whole| (whole - c_deg).abs() < 1e-6)
    }

    /// What is missing, as every result says it.
    pub fn words(&self) -> String {
        if self.directions == self.planned_directions {
            return format!("partial: {} not read to the end", self.blocks());
        }
        format!(
            "partial: {} of {} half-planes were measured, the others are interpolated between them",
            self.whole_c_deg.len(),
            self.planned_c_deg.len()
        )
    }

    fn blocks(&self) -> String {
        let (noun, verb) = if self.unread_blocks.len() == 1 {
            ("block", "was")
        } else {
            ("blocks", "were")
        };
        format!("{noun} {} {verb}", self.unread_blocks.join(", "))
    }

    /// The sentence for people.
    pub fn note(&self) -> String {
        if self.directions == self.planned_directions {
            return format!("{}; --resume reads the rest", self.words());
        }
        format!(
            "{}; {} of {} directions of the plan were read, and --resume reads the rest",
            self.words(),
            self.directions,
            self.planned_directions
        )
    }

    /// Adds the half-planes that are missing to the samples of the others, linear in C and all round.
    pub fn fill(&self, samples: &mut Vec<Sample>) {
        let measured = std::mem::take(samples);
        let whole: Vec<&[Sample]> = measured
            .chunk_by(|a, b| (a.closing, a.c_deg) == (b.closing, b.c_deg))
            .filter(|plane| !plane[0].closing)
            .collect();
        let Some(&first) = whole.first() else { return };
        for &c_deg in &self.planned_c_deg {
            if let Some(plane) = whole.iter().find(|plane| (plane[0].c_deg - c_deg).abs() < 1e-6) {
                samples.extend(*plane);
                continue;
            }
            let behind = whole.partition_point(|plane| plane[0].c_deg < c_deg) % whole.len();
            let before = (behind + whole.len() - 1) % whole.len();
            let way = |from: f64, to: f64| (to - from).rem_euclid(360.0);
            let gap = way(whole[before][0].c_deg, whole[behind][0].c_deg);
            let share = if gap == 0.0 {
                0.0
            } else {
                way(whole[before][0].c_deg, c_deg) / gap
            };
            samples.extend(first.iter().map(|at| {
                let there = |plane: &[Sample]| {
                    let same = plane.iter().find(|sample| sample.gamma_deg == at.gamma_deg);
                    same.map_or(at.intensity_cd, |sample| sample.intensity_cd)
                };
                Sample {
                    c_deg,
                    true_c_deg: c_deg,
                    true_gamma_deg: at.gamma_deg,
                    intensity_cd: (1.0 - share) * there(whole[before]) + share * there(whole[behind]),
                    u_noise_cd: 0.0,
                    u_curve_cd: None,
                    u_digit_cd: 0.0,
                    display: None,
                    lamp_s: None,
                    ..*at
                }
            }));
        }
        samples.extend(measured.iter().filter(|sample| sample.closing));
    }
}

/// The blocks of the plan of which not every point was read, without those that `is_distribution` names.
pub fn unread_blocks(run: &Run, is_distribution: impl Fn(&str) -> bool) -> Vec<String> {
    let is_unread = |block: &&Block| {
        let planned = block
            .c_deg
            .iter()
            .flat_map(|&c| block.gamma_deg.iter().map(move |&gamma| (c, gamma)));
        match block.instrument {
            Instrument::Luxmeter => {
                let rows = run.readings.rows.iter();
                let points = rows.filter(|row| row.role == Role::Point && row.block == block.name);
                let read = once(points.map(target));
                once(planned)
                    .iter()
                    .any(|at| read.binary_search_by(|read| order(read, at)).is_err())
            }
            // A spectrum states where it was taken, not where the plan sent it.
            Instrument::Spectroradiometer => {
                let spectra = run.spectra.iter().filter(|spectrum| spectrum.block == block.name);
                let points: BTreeSet<u64> = spectra.map(|spectrum| spectrum.point).collect();
                points.len() < planned.count()
            }
        }
    };
    let blocks = run.header.plan.blocks().iter();
    let unread = blocks.filter(|block| !is_distribution(&block.name)).filter(is_unread);
    unread.map(|block| block.name.clone()).collect()
}
