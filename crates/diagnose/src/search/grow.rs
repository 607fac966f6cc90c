//! Members: the best name, or the best pair, and further names while the scan still disagrees.

use nalgebra::{DMatrix, DVector};
use rayon::prelude::*;

use crate::evidence::{ln_bayes_factor, ln_sum_exp};
use crate::fit::Fit;
use crate::forward::{Forward, Hypothesis};
use crate::scan::{Found, Scan, Who};
use crate::search::bench::Bench;

impl<F: Forward + ?Sized> Bench<'_, F> {
    /// The first members: the best single effect, or the best pair where two explain what one cannot.
    pub(super) fn grow(&mut self, scan: &Scan, first: &[Found], baseline: &Fit) -> (Vec<Hypothesis>, Fit) {
        let singles = self.name_evidence(first);
        let Some(&(best, _)) = singles.first() else {
            return (Vec::new(), baseline.clone());
        };
        let mut tried: Vec<(f64, Vec<Hypothesis>, Fit)> = Vec::new();
        // Full fits of the few best: a tangent can mislead where an effect is strong.
        let candidates: Vec<usize> = singles
            .iter()
            .take_while(|(_, e)| *e > singles[0].1 - 12.0)
            .take(4)
            .map(|(e, _)| *e)
            .collect();
        for effect in candidates {
            let Some((start, _)) = self.start(scan, baseline, first, effect) else {
                continue;
            };
            if let Some(fitted) = self.fit(&[start]) {
                tried.push((fitted.chi2, fitted.hypotheses.clone(), fitted));
            }
        }
        let _ = best;
        tried.sort_by(|a, b| a.0.total_cmp(&b.0));
        let Some((single_chi2, members, fitted)) = tried.into_iter().next() else {
            return (Vec::new(), baseline.clone());
        };
        let variance = self.noise.scale.powi(2);
        let single_explained = (baseline.chi2 - single_chi2) / variance;
        if let Some((pair, pair_fit)) = self.best_pair(scan, first, baseline) {
            let pair_explained = (baseline.chi2 - pair_fit.chi2) / variance;
            let gain = pair_explained - single_explained;
            let weaker = (0..2)
                .map(|i| self.explained_by(&pair, &pair_fit, i))
                .fold(f64::INFINITY, f64::min);
            let stronger = (0..2)
                .map(|i| self.explained_by(&pair, &pair_fit, i))
                .fold(0.0, f64::max);
            let needed = (2.0 * (self.forward.effects().len() as f64).ln() + 8.0)
                .max(self.settings.second_share.powi(2) * stronger)
                .max((self.settings.model_form).powi(2) * stronger + 9.0);
            if gain > needed && weaker > needed {
                self.update_noise(&pair_fit);
                if let Some(fitted) = self.fit(&pair) {
                    let pair = fitted.hypotheses.clone();
                    return self.extend(pair, fitted);
                }
            }
        }
        self.update_noise(&fitted);
        match self.fit(&members) {
            Some(fitted) => {
                let members = fitted.hypotheses.clone();
                self.extend(members, fitted)
            }
            None => (members, fitted),
        }
    }

    /// Further named effects while the scan of what is left asks for one and one answers.
    pub(super) fn extend(&mut self, mut members: Vec<Hypothesis>, mut fitted: Fit) -> (Vec<Hypothesis>, Fit) {
        while members.len() < 4 {
            let scan = self.scan(&fitted, &members, None);
            let found = self.look(&scan, &fitted);
            if !self.disagrees(&found) {
                break;
            }
            let Some(&(effect, evidence)) = self.name_evidence(&found).first() else {
                break;
            };
            let unnamed = ln_sum_exp(
                &found
                    .iter()
                    .filter(|one| matches!(one.who, Who::Unnamed { .. }))
                    .map(|one| one.ln_evidence)
                    .collect::<Vec<_>>(),
            );
            if unnamed > evidence + 1.0 {
                break;
            }
            let Some((start, _)) = self.start(&scan, &fitted, &found, effect) else {
                break;
            };
            let mut grown = members.clone();
            grown.push(start);
            let Some(next) = self.fit(&grown) else { break };
            let strongest = (0..members.len())
                .map(|i| self.explained_by(&members, &fitted, i))
                .fold(0.0, f64::max);
            let gained = (fitted.chi2 - next.chi2) / self.noise.scale.powi(2);
            if gained < self.settings.second_share.powi(2) * strongest || gained < 9.0 {
                break;
            }
            members.clone_from(&next.hypotheses);
            self.update_noise(&next);
            let Some(refitted) = self.fit(&members) else { break };
            fitted = refitted;
            members.clone_from(&fitted.hypotheses);
        }
        (members, fitted)
    }

    /// The pair of named effects that explains most, from the Gram matrix of the scan's directions.
    pub(super) fn best_pair(&self, scan: &Scan, first: &[Found], baseline: &Fit) -> Option<(Vec<Hypothesis>, Fit)> {
        let residual = &baseline.residual / self.noise.scale;
        // All shapes of every effect; of a search through frequencies only the best few.
        let mut by_effect: Vec<Vec<usize>> = vec![Vec::new(); self.forward.effects().len()];
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
        let blocks: Vec<DMatrix<f64>> = places
            .iter()
            .map(|&(_, place)| scan.block(&scan.seen[place]).into_owned())
            .collect();
        let z: Vec<DVector<f64>> = blocks.iter().map(|block| block.tr_mul(&residual)).collect();
        let mut best: Vec<(f64, usize, usize)> = (0..places.len())
            .into_par_iter()
            .flat_map_iter(|a| {
                let (blocks, z, places) = (&blocks, &z, &places);
                ((a + 1)..places.len())
                    .filter(move |&b| places[a].0 != places[b].0)
                    .filter_map(move |b| {
                        let cross = blocks[a].tr_mul(&blocks[b]);
                        let left = &z[b] - cross.tr_mul(&z[a]);
                        let inner = DMatrix::identity(left.len(), left.len()) - cross.tr_mul(&cross);
                        // Nearly the same pattern twice is no pair.
                        let inverse = inner.clone().try_inverse()?;
                        if inner.determinant() < 1e-3 {
                            return None;
                        }
                        let gained = left.dot(&(inverse * &left));
                        let explained = z[a].norm_squared() + gained;
                        Some((ln_bayes_factor(explained, z[a].len() + z[b].len()), a, b))
                    })
            })
            .collect();
        best.sort_by(|x, y| y.0.total_cmp(&x.0));
        // Refine the best of several different pairs of names.
        let mut names: Vec<(usize, usize)> = Vec::new();
        let mut fits: Vec<Fit> = Vec::new();
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
                fits.extend(self.fit(&[one, two]));
            }
            if names.len() >= 4 {
                break;
            }
        }
        let fitted = fits.into_iter().min_by(|a, b| a.chi2.total_cmp(&b.chi2))?;
        Some((fitted.hypotheses.clone(), fitted))
    }
}
