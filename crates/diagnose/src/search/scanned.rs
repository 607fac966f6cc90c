//! Second stage: every candidate against what the baseline leaves. Where it disagrees, how probable that is under noise
//! alone, and what these data could show at all.

use std::ops::Range;

use nalgebra::DVector;
use rayon::prelude::*;

use super::outcome::Place;
use crate::basis::Basis;
use crate::fit::Fit;
use crate::scan::{Found, Scan, Who, p_value, statistic};

use super::estimate::{Baseline, Estimate};

/// What the scan of the baseline says.
pub(super) struct Scanned {
    pub(super) scan: Scan,
    pub(super) found: Vec<Found>,
    /// Statistics of simulated scans of noise alone, rising.
    pub(super) nulls: Vec<f64>,
    pub(super) p_global: f64,
    pub(super) places: Vec<Place>,
    /// Significance (σ) of every effect at its plausible maximum (effect, component, σ).
    pub(super) visibility: Vec<(usize, usize, f64)>,
}

pub(super) fn scan(baseline: &Baseline<'_, '_>) -> Scanned {
    let Baseline { estimate, fit } = baseline;
    let settings = estimate.problem.settings;
    let scan = estimate.scan(fit, &[], None);
    let found = scan.look();
    let whitened = |numbers: &[usize]| estimate.whitened(numbers);
    let sequence = estimate.problem.sequence;
    let nulls = scan.nulls(&whitened, settings.nulls, settings.seed, sequence, &estimate.noise);
    Scanned {
        p_global: p_value(statistic(&found), &nulls),
        places: estimate.places(&found),
        visibility: estimate.visibility(fit),
        scan,
        found,
        nulls,
    }
}

impl Estimate<'_, '_> {
    fn places(&self, found: &[Found]) -> Vec<Place> {
        let mut places: Vec<(f64, Place)> = Vec::new();
        for one in found {
            let Who::Unnamed { alternative } = one.who else {
                continue;
            };
            let alternative = &self.problem.alternatives[alternative];
            let place = Place {
                coordinate: alternative.coordinate,
                range: alternative.range,
                sigma: one.explained.sqrt(),
                note: alternative.note.clone(),
            };
            match places
                .iter_mut()
                .find(|(_, known)| known.coordinate == alternative.coordinate)
            {
                Some(known) if known.0 >= one.ln_evidence => {}
                Some(known) => *known = (one.ln_evidence, place),
                None => places.push((one.ln_evidence, place)),
            }
        }
        places.sort_by(|a, b| b.0.total_cmp(&a.0));
        places.into_iter().map(|(_, place)| place).collect()
    }

    /// Significance of every effect's plausible maximum, best shape of its grid.
    fn visibility(&self, baseline: &Fit) -> Vec<(usize, usize, f64)> {
        let out = Basis::spanning(&baseline.jacobian, 1e-9);
        let effects = self.problem.forward.effects();
        // Of a search through frequencies every sixteenth says enough.
        let named: Vec<(usize, Range<usize>)> = self
            .problem
            .dictionary
            .candidates
            .iter()
            .filter_map(|candidate| match candidate.who {
                Who::Named { effect, shape } if effects[effect].shapes.len() <= 60 || shape % 16 == 0 => {
                    Some((effect, candidate.columns.clone()))
                }
                _ => None,
            })
            .collect();
        let left: Vec<Vec<f64>> = named
            .par_iter()
            .map(|(_, columns)| {
                let columns = self.whitened(&columns.clone().collect::<Vec<_>>());
                let left = |mut column: DVector<f64>| {
                    let before = column.norm();
                    out.project_out_vector(&mut column);
                    let left = column.norm();
                    if left < 1e-9 * before { 0.0 } else { left }
                };
                columns.column_iter().map(|column| left(column.into_owned())).collect()
            })
            .collect();
        let mut best: Vec<(usize, usize, f64)> = Vec::new();
        for ((effect, _), left) in named.into_iter().zip(left) {
            for (component, left) in left.into_iter().enumerate() {
                let sigma = left / self.noise.scale * effects[effect].plausible[component];
                match best.iter_mut().find(|(e, c, _)| (*e, *c) == (effect, component)) {
                    Some(known) => known.2 = known.2.max(sigma),
                    None => best.push((effect, component, sigma)),
                }
            }
        }
        best
    }
}
