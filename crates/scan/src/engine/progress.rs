//! What a run that is resumed holds already.

use std::collections::{HashMap, HashSet};

use isolux_record::Role;
use isolux_record::plan::{Block, Instrument, Repeats};
use isolux_record::run::Run;

use crate::itinerary::Visit;

/// Readings and spectra of an earlier session, by point.
#[derive(Default)]
pub(super) struct Progress {
    points: HashMap<u64, (u32, Vec<f64>)>,
    references: HashMap<u64, u32>,
    spectra: HashMap<u64, u32>,
    sweeps: HashSet<u64>,
    /// Block, C and γ, as bits, of directions that were read at rest after the sweeps.
    checks: HashSet<(String, u64, u64)>,
    last_point: Option<u64>,
}

impl Progress {
    /// What `resumed` holds; nothing for a new run.
    pub fn of(resumed: Option<&Run>) -> Self {
        let mut progress = Self::default();
        for reading in resumed.iter().flat_map(|run| &run.readings.rows) {
            match reading.role {
                Role::Reference => *progress.references.entry(reading.point).or_default() += 1,
                Role::Check => {
                    let (c, gamma) = (reading.c_target_deg, reading.gamma_target_deg);
                    let key = (reading.block.clone(), c.to_bits(), gamma.to_bits());
                    progress.checks.insert(key);
                }
                Role::Point => {
                    let entry = progress.points.entry(reading.point).or_default();
                    entry.0 += 1;
                    entry.1.extend(reading.illuminance_lx);
                    progress.last_point = progress.last_point.max(Some(reading.point));
                }
            }
        }
        for spectrum in resumed.iter().flat_map(|run| &run.spectra) {
            *progress.spectra.entry(spectrum.point).or_default() += 1;
        }
        for sweep in resumed.iter().flat_map(|run| &run.sweeps) {
            progress.sweeps.insert(sweep.of.point);
            progress.last_point = progress.last_point.max(Some(sweep.of.point));
        }
        progress
    }

    /// Whether a visit needs not be made any more.
    pub fn has(&self, visit: &Visit, block: &Block) -> bool {
        match (visit.role, block.instrument) {
            (Role::Check, _) => self.has_check(block, (visit.c_deg, visit.gamma_deg)),
            (Role::Reference, _) => {
                self.references.contains_key(&visit.point) || self.last_point.is_some_and(|last| last >= visit.point)
            }
            (Role::Point, _) if visit.pass.is_some() => self.sweeps.contains(&visit.point),
            (Role::Point, Instrument::Spectroradiometer) => self.spectra.contains_key(&visit.point),
            (Role::Point, Instrument::Luxmeter) => match (self.points.get(&visit.point), block.repeats) {
                (Some((taken, _)), Repeats::Exactly(count)) => *taken >= count,
                // Whether the goal was met is known once a later point was begun.
                (Some(_), Repeats::Until(_)) => self.last_point.is_some_and(|last| last > visit.point),
                (None, _) => false,
            },
        }
    }

    /// Whether a direction (C, γ) of `block`, in degrees, was read at rest after its sweeps.
    pub fn has_check(&self, block: &Block, (c_deg, gamma_deg): (f64, f64)) -> bool {
        let key = (block.name.clone(), c_deg.to_bits(), gamma_deg.to_bits());
        self.checks.contains(&key)
    }

    /// Readings of a visit that are there already: how many, and the numbers among them.
    pub fn readings(&self, visit: &Visit) -> (u32, &[f64]) {
        match (visit.role, self.points.get(&visit.point)) {
            (Role::Point, Some((taken, values))) => (*taken, values),
            _ => (0, &[]),
        }
    }
}
