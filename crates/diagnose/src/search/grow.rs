//! Members: the best name, or the best pair, and further names while the scan still disagrees.

use std::ops::Range;

use nalgebra::{DMatrix, DVector};
use rayon::prelude::*;

use crate::basis::product;
use crate::calibration::{FITTED, FURTHER_GAIN, MOST_MEMBERS, PAIR_GAIN};
use crate::evidence::ln_bayes_factor;
use crate::fit::Fit;
use crate::forward::Hypothesis;
use crate::scan::{Found, Scan, Who};

use super::estimate::Estimate;
use super::outcome::Names;

impl Estimate<'_, '_> {
    /// The first members: the best single effect, or the best pair where two explain what one cannot.
    pub(super) fn grow(self, scan: &Scan, first: &[Found], baseline: &Fit) -> (Self, Names) {
        let singles = self.name_evidence(first);
        if singles.is_empty() {
            return (self, Names::none(baseline));
        }
        // Full fits of the few best: a tangent can mislead where an effect is strong.
        let tried: Vec<Fit> = singles
            .par_iter()
            .take(FITTED)
            .filter_map(|&(effect, _)| self.fit(&[self.guess(baseline, first, effect)?.0]))
            .collect();
        let Some(fitted) = tried.into_iter().min_by(|a, b| a.chi2.total_cmp(&b.chi2)) else {
            return (self, Names::none(baseline));
        };
        let variance = self.noise.scale.powi(2);
        let single_explained = (baseline.chi2 - fitted.chi2) / variance;
        let least_gain = 2.0 * (self.problem.forward.effects().len() as f64).ln() + PAIR_GAIN;
        if let Some((pair, pair_fit)) = self.best_pair(scan, first, baseline, least_gain) {
            let pair_explained = (baseline.chi2 - pair_fit.chi2) / variance;
            let gain = pair_explained - single_explained;
            let weaker = (0..2)
                .map(|i| self.explained_by(&pair, &pair_fit, i))
                .fold(f64::INFINITY, f64::min);
            let stronger = (0..2)
                .map(|i| self.explained_by(&pair, &pair_fit, i))
                .fold(0.0, f64::max);
            let needed = least_gain
                .max(self.problem.settings.further(stronger))
                .max((self.problem.settings.model_form).powi(2) * stronger + FURTHER_GAIN);
            if gain > needed && weaker > needed {
                let estimate = self.again(&pair_fit);
                if let Some(refitted) = estimate.fit(&pair) {
                    return estimate.extend(Names::of(refitted));
                }
                return estimate.again(&fitted).with_one(fitted);
            }
        }
        self.again(&fitted).with_one(fitted)
    }

    /// The best single name and what else the scan asks for.
    fn with_one(self, fitted: Fit) -> (Self, Names) {
        match self.fit(&fitted.hypotheses) {
            Some(refitted) => self.extend(Names::of(refitted)),
            None => (self, Names::of(fitted)),
        }
    }

    /// Further named effects while the scan of what is left asks for one and one answers.
    pub(super) fn extend(mut self, names: Names) -> (Self, Names) {
        let Names {
            mut members,
            fit: mut fitted,
        } = names;
        while members.len() < MOST_MEMBERS {
            let scan = self.scan(&fitted, &members, None);
            let found = scan.look();
            if !self.disagrees(&found) {
                break;
            }
            let Some(&(effect, _)) = self.name_evidence(&found).first() else {
                break;
            };
            let Some((start, _)) = self.guess(&fitted, &found, effect) else {
                break;
            };
            let mut grown = members.clone();
            grown.push(start);
            let Some(next) = self.fit(&grown) else { break };
            let strongest = (0..members.len())
                .map(|i| self.explained_by(&members, &fitted, i))
                .fold(0.0, f64::max);
            let gained = (fitted.chi2 - next.chi2) / self.noise.scale.powi(2);
            if gained < self.problem.settings.further(strongest) || gained < FURTHER_GAIN {
                break;
            }
            members.clone_from(&next.hypotheses);
            self = self.again(&next);
            let Some(refitted) = self.fit(&members) else { break };
            fitted = refitted;
            members.clone_from(&fitted.hypotheses);
        }
        (self, Names { members, fit: fitted })
    }

    /// The pair of named effects that explains most, from the Gram matrix of the scan's directions; none where the
    /// tangents of no pair gain `least_gain` (σ²) over those of the best name.
    pub(super) fn best_pair(
        &self,
        scan: &Scan,
        first: &[Found],
        baseline: &Fit,
        least_gain: f64,
    ) -> Option<(Vec<Hypothesis>, Fit)> {
        // All shapes of every effect; of a search through frequencies only the best few.
        let mut by_effect: Vec<Vec<usize>> = vec![Vec::new(); self.problem.forward.effects().len()];
        for (place, seen) in scan.seen.iter().enumerate() {
            if let Who::Named { effect, .. } = seen.who {
                by_effect[effect].push(place);
            }
        }
        for places in &mut by_effect {
            places.sort_by(|&a, &b| first[b].explained.total_cmp(&first[a].explained));
            places.truncate(12);
        }
        let places: Vec<(usize, usize)> = by_effect
            .iter()
            .enumerate()
            .flat_map(|(effect, places)| places.iter().map(move |&place| (effect, place)))
            .collect();
        let whitened = |numbers: &[usize]| self.whitened(numbers);
        let numbers: Vec<usize> = places.iter().map(|&(_, place)| place).collect();
        let (blocks, z): (Vec<DMatrix<f64>>, Vec<DVector<f64>>) = scan.of(&whitened, &numbers).into_iter().unzip();
        let mut own: Vec<Range<usize>> = Vec::with_capacity(blocks.len());
        let mut columns = Vec::new();
        for block in blocks {
            let start = columns.len();
            columns.extend(block.column_iter().map(nalgebra::Matrix::into_owned));
            own.push(start..columns.len());
        }
        if columns.is_empty() {
            return None;
        }
        let columns = DMatrix::from_columns(&columns);
        let gram = product(&columns, &columns);
        let single = z.iter().map(nalgebra::Matrix::norm_squared).fold(0.0, f64::max);
        // A pair that gains less would not be taken, and its refits cost the most.
        let enough = single + least_gain.max(0.5 * self.problem.settings.further(single));
        let mut best: Vec<(f64, usize, usize)> = (0..places.len())
            .into_par_iter()
            .flat_map_iter(|a| {
                let (gram, own, z, places) = (&gram, &own, &z, &places);
                ((a + 1)..places.len())
                    .filter(move |&b| places[a].0 != places[b].0)
                    .filter_map(move |b| {
                        let cross = gram.view((own[a].start, own[b].start), (own[a].len(), own[b].len()));
                        let left = &z[b] - cross.tr_mul(&z[a]);
                        let inner = DMatrix::identity(left.len(), left.len()) - cross.tr_mul(&cross);
                        // Nearly the same pattern twice is no pair.
                        let inverse = inner.clone().try_inverse()?;
                        if inner.determinant() < 1e-3 {
                            return None;
                        }
                        let gained = left.dot(&(inverse * &left));
                        let explained = z[a].norm_squared() + gained;
                        (explained >= enough).then(|| (ln_bayes_factor(explained, z[a].len() + z[b].len()), a, b))
                    })
            })
            .collect();
        best.sort_by(|x, y| y.0.total_cmp(&x.0));
        // Refine the best of several different pairs of names.
        let mut names: Vec<(usize, usize)> = Vec::new();
        let mut starts: Vec<[Hypothesis; 2]> = Vec::new();
        for &(_, a, b) in best.iter().take(400) {
            let pair = (places[a].0.min(places[b].0), places[a].0.max(places[b].0));
            if names.contains(&pair) {
                continue;
            }
            names.push(pair);
            let start = |place: usize| {
                let who = scan.seen[place].who;
                let Who::Named { shape, .. } = who else { return None };
                self.hypothesis(baseline, who, shape)
            };
            if let (Some(one), Some(two)) = (start(places[a].1), start(places[b].1)) {
                starts.push([one, two]);
            }
            if names.len() >= 4 {
                break;
            }
        }
        let fits: Vec<Fit> = starts.into_par_iter().filter_map(|pair| self.fit(&pair)).collect();
        let fitted = fits.into_iter().min_by(|a, b| a.chi2.total_cmp(&b.chi2))?;
        Some((fitted.hypotheses.clone(), fitted))
    }
}
