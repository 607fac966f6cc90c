//! How far apart two names would lie with a block measured besides.

use nalgebra::{DMatrix, DVector};

use super::block::Block;
use crate::assumed::AssumedModel;
use crate::basis::Basis;
use crate::fit::{fit, nuisance_tangents};
use crate::forward::{Forward, Hypothesis};
use crate::rounding::Rounding;
use crate::search::Outcome;
use crate::table::Row;
use crate::whitener::Whitener;
use crate::whitening::Sequence;

/// How far apart, in σ, the two predictions lie over old and new rows together, after the second is refitted to the
/// first.
pub(super) fn separation(
    assumed: &AssumedModel,
    outcome: &Outcome,
    rows: &[Row],
    block: &Block,
    others: &[Hypothesis],
    pair: &[Hypothesis; 2],
) -> Option<f64> {
    let scale = outcome.noise.scale;
    let all_sigma: Vec<f64> = rows
        .iter()
        .map(|row| scale * row.u)
        .chain(block.sigma.iter().copied())
        .collect();
    let predict = |nuisance: &[f64], members: &[Hypothesis]| -> Option<DVector<f64>> {
        let old = assumed.predict(nuisance, members)?;
        let model = assumed.model(nuisance, members)?;
        let new = block.part.predict(&model)?;
        let values = old
            .iter()
            .copied()
            .chain(new)
            .zip(&all_sigma)
            .map(|(value, sigma)| value / sigma);
        Some(DVector::from_iterator(all_sigma.len(), values))
    };
    let with = |alternative: &Hypothesis| {
        let mut members = others.to_vec();
        members.push(alternative.clone());
        members
    };
    let nuisance = &outcome.after.nuisance;
    let (first, second) = (with(&pair[0]), with(&pair[1]));
    let base = predict(nuisance, &second)?;
    let mut difference = predict(nuisance, &first)? - &base;
    let mut columns: Vec<DVector<f64>> = Vec::new();
    for k in 0..nuisance.len() {
        let mut moved = nuisance.clone();
        moved[k] += 1e-4;
        columns.push(predict(&moved, &second)? - &base);
    }
    for (i, member) in second.iter().enumerate() {
        let searchable = &assumed.effects()[member.effect];
        for j in 0..member.linear.len() {
            let mut moved = second.clone();
            moved[i].linear[j] += 0.1 * searchable.step[j];
            columns.push(predict(nuisance, &moved)? - &base);
        }
        for j in (0..member.shape.len()).filter(|&j| !searchable.fixed[j]) {
            let mut moved = second.clone();
            moved[i].shape[j] += searchable.shape_step[j];
            columns.push(predict(nuisance, &moved)? - &base);
        }
    }
    let columns = if columns.is_empty() {
        DMatrix::zeros(base.len(), 0)
    } else {
        DMatrix::from_columns(&columns)
    };
    Basis::spanning(&columns, 1e-8).project_out_vector(&mut difference);
    Some(difference.norm())
}

/// As [`separation`], the smaller of both ways, each name refitted in full to what the other predicts. Needs new rows
/// that bring no other refitted terms.
pub(super) fn refitted_separation(
    assumed: &AssumedModel,
    outcome: &Outcome,
    rows: &[Row],
    block: &Block,
    others: &[Hypothesis],
    pair: &[Hypothesis; 2],
) -> Option<f64> {
    let together = assumed.with_part(block.part.clone());
    if together.nuisances() != assumed.nuisances() || together.effects().len() != assumed.effects().len() {
        return None;
    }
    let nuisance = &outcome.after.nuisance;
    let old = rows.iter().map(|row| 1.0 / (outcome.noise.scale * row.u));
    let row_scale = DVector::from_vec(old.chain(block.sigma.iter().map(|sigma| 1.0 / sigma)).collect());
    let sequence = Sequence::by_time(&vec![0; row_scale.len()], &vec![f64::NAN; row_scale.len()]);
    let (rounding, errors) = (Rounding::default(), together.common_errors());
    let whitener = Whitener::new(&sequence, &rounding, row_scale, 0.0, &errors);
    let tangents = nuisance_tangents(&together, nuisance)?;
    let with = |alternative: &Hypothesis| [others, std::slice::from_ref(alternative)].concat();
    let left = |truth: &Hypothesis, tried: &Hypothesis| {
        let expected = together.predict(nuisance, &with(truth))?;
        let fitted = fit(&together, &expected, &whitener, nuisance, &tangents, &with(tried))?;
        Some(fitted.chi2.sqrt())
    };
    Some(left(&pair[0], &pair[1])?.min(left(&pair[1], &pair[0])?))
}
