//! What was found, as the document lists it: effects, rankings, places, blind spots.

use std::borrow::Cow;
use std::collections::BTreeMap;

use isolux_model::Role;
use nalgebra::{DMatrix, DVector};

use crate::assumed::AssumedModel;
use crate::calibration::{OUTSIDE_CATALOGUE, PLACE_SIGMA, SET, SIGNIFICANCE};
use crate::document::{
    BlindSpot, EffectEntry, EvidenceEntry, NoiseFindingEntry, NoiseTestEntry, ParameterEntry, PeakEntry, PlaceEntry,
    RankedEntry,
};
use crate::forward::{Forward, Hypothesis};
use crate::noise::NoiseTest;
use crate::search::{Comparison, Label, Outcome, Ranked};

/// What stands in a set where something that is not in the catalogue is as likely.
pub(super) const OUTSIDE: &str = "outside the catalogue";

/// So far beyond its plausible range, in widths of it, a value counts as at its end.
const BARELY: f64 = 0.05;

/// Odds of something outside the catalogue against a name whose values lie beyond what is plausible: before any data
/// [`OUTSIDE_CATALOGUE`], and more by as much as the values are unlikely. None within the plausible range, nor where
/// the data hardly tell the values from its end: depth and width of a sector that make the same light.
fn outside_odds(assumed: &AssumedModel, member: &Hypothesis, covariance: &DMatrix<f64>) -> Option<f64> {
    let searchable = &assumed.effects()[member.effect];
    // Beyond the range in its widths, and that in standard uncertainties.
    let apart = |beyond: f64, width: f64, place: usize| {
        let u = covariance[(place, place)].max(f64::MIN_POSITIVE).sqrt();
        beyond.min(beyond * width / u)
    };
    let amplitudes = searchable.beyond(&member.linear).into_iter().enumerate();
    let amplitudes = amplitudes.map(|(k, (share, _))| apart(share, searchable.plausible[k], k));
    let fixed = searchable.fixed.iter().enumerate().filter(|(_, fixed)| !**fixed);
    let shapes = fixed.enumerate().map(|(free, (shape, _))| {
        let spread = &searchable.assumed[shape];
        apart(
            spread.beyond(member.shape[shape]),
            spread.width,
            member.linear.len() + free,
        )
    });
    let square: f64 = amplitudes.chain(shapes).map(|beyond| beyond * beyond).sum();
    (square > BARELY.powi(2)).then(|| OUTSIDE_CATALOGUE / (1.0 - OUTSIDE_CATALOGUE) * (0.5 * square).min(50.0).exp())
}

/// Members of the 95 % set of each effect: its own name left out.
pub(super) fn effect_entries(assumed: &AssumedModel, outcome: &Outcome) -> Vec<EffectEntry> {
    let covariance = outcome.after.covariance(outcome.noise.scale);
    let mut place = outcome.after.nuisance.len();
    let mut entries = Vec::new();
    for (member, comparison) in outcome.after.hypotheses.iter().zip(&outcome.comparisons) {
        let spec = assumed.spec(member.effect);
        let free = member.linear.len()
            + assumed.effects()[member.effect]
                .fixed
                .iter()
                .filter(|fixed| !**fixed)
                .count();
        let own = covariance.view((place, place), (free, free)).into_owned();
        place += free;
        let mut equivalents = Vec::new();
        // The set is among those that could make it: what belongs to "nothing" asks for no further names.
        let limit = SET * comparison.ranked.iter().map(|ranked| ranked.posterior).sum::<f64>();
        let mut sum = 0.0;
        let mut posterior = 0.0;
        let mut sigma = 0.0;
        for ranked in &comparison.ranked {
            let is_own = ranked.label == Label::Named(member.effect);
            if is_own {
                posterior = ranked.posterior;
                sigma = ranked.sigma;
            }
            if sum < limit && !is_own {
                equivalents.push(label(assumed, ranked.label));
            }
            sum += ranked.posterior;
        }
        if let Some(odds) = outside_odds(assumed, member, &own) {
            posterior /= 1.0 + odds;
            equivalents.push(OUTSIDE.to_owned());
        }
        entries.push(EffectEntry {
            name: spec.name.into(),
            standard_name: spec.standard_name.into(),
            equivalents,
            parameters: parameters(assumed, member, &own),
            evidence: EvidenceEntry {
                ln_bayes_factor: comparison.ln_bayes_factor,
                p_value: comparison.p_value,
                posterior,
                significance_sigma: sigma,
            },
        });
    }
    entries
}

fn label(assumed: &AssumedModel, label: Label) -> String {
    match label {
        Label::Named(effect) => assumed.spec(effect).name.to_owned(),
        Label::Unnamed(coordinate) => format!("unnamed:{}", coordinate.name()),
    }
}

/// Values of the keys that a fit moves, with the uncertainty that the fit's covariance leaves them.
fn parameters(
    assumed: &AssumedModel,
    member: &Hypothesis,
    covariance: &DMatrix<f64>,
) -> BTreeMap<Cow<'static, str>, ParameterEntry> {
    let searchable = &assumed.effects()[member.effect];
    let values = assumed.values(member);
    let free_shapes: Vec<usize> = (0..member.shape.len()).filter(|&j| !searchable.fixed[j]).collect();
    let columns: Vec<Vec<f64>> = (0..covariance.nrows())
        .map(|k| {
            let mut moved = member.clone();
            let step = covariance[(k, k)].max(0.0).sqrt().max(1e-12) * 1e-2;
            match k.checked_sub(member.linear.len()) {
                None => moved.linear[k] += step,
                Some(j) => moved.shape[free_shapes[j]] += step,
            }
            assumed
                .values(&moved)
                .iter()
                .zip(&values)
                .map(|(a, b)| wrapped(a - b) / step)
                .collect()
        })
        .collect();
    let spec = assumed.spec(member.effect);
    assumed
        .moved_keys(member.effect)
        .into_iter()
        .map(|key| {
            let parameter = &spec.parameters[key];
            let slope = DVector::from_iterator(columns.len(), columns.iter().map(|column| column[key]));
            let variance = slope.dot(&(covariance * &slope));
            let (low, high) = parameter.plausible;
            let u = variance.max(0.0).sqrt();
            let entry = ParameterEntry {
                value: values[key],
                u,
                unit: parameter.unit.into(),
                plausible: [low, high],
                before: assumed.known(member.effect).map(|before| before[key]),
                implausible: parameter.role == Role::Amplitude && !(low - u..=high + u).contains(&values[key]),
            };
            (parameter.key.into(), entry)
        })
        .collect()
}

/// A difference of angles that jumped by a turn is a small one.
fn wrapped(difference: f64) -> f64 {
    if difference > 180.0 {
        difference - 360.0
    } else if difference < -180.0 {
        difference + 360.0
    } else {
        difference
    }
}

pub(super) fn ranked(assumed: &AssumedModel, outcome: &Outcome) -> Vec<Vec<RankedEntry>> {
    let is_unnamed = |ranked: &&Ranked| matches!(ranked.label, Label::Unnamed(_));
    let of_one = |comparison: &Comparison| {
        let listed = |(rank, ranked): &(usize, &Ranked)| *rank < 8 || ranked.posterior >= 0.01;
        let rows = comparison.ranked.iter().enumerate().filter(listed);
        let mut rows: Vec<&Ranked> = rows.map(|(_, ranked)| ranked).collect();
        // The row without a name is always there.
        if !rows.iter().any(is_unnamed) {
            rows.extend(comparison.ranked.iter().find(is_unnamed));
        }
        let entry = |ranked: &Ranked| RankedEntry {
            name: label(assumed, ranked.label),
            posterior: ranked.posterior,
            significance_sigma: ranked.sigma,
            ln_evidence: ranked.ln_evidence,
        };
        rows.into_iter().map(entry).collect()
    };
    outcome.comparisons.iter().map(of_one).collect()
}

/// The test of the noise.
pub(super) fn noise_test(test: &NoiseTest) -> NoiseTestEntry {
    NoiseTestEntry {
        p_value: test.p_value,
        scatter: test.scatter,
        scatter_limit: test.limit,
        repeats_scatter: test.repeats.map(|(scatter, _)| scatter),
        findings: test
            .findings
            .iter()
            .map(|finding| NoiseFindingEntry {
                test: finding.kind,
                coordinate: finding.coordinate.name().into(),
                range: finding.range,
                period: finding.period,
                significance_sigma: finding.sigma,
                p_value: finding.p_value,
                note: finding.note.clone(),
            })
            .collect(),
        spectrum: test
            .spectrum
            .iter()
            .map(|peak| PeakEntry {
                coordinate: peak.coordinate.name().into(),
                period: peak.period,
                significance_sigma: peak.sigma,
            })
            .collect(),
    }
}

pub(super) fn places(outcome: &Outcome) -> Vec<PlaceEntry> {
    let found = outcome.noise_test.iter().flat_map(|test| &test.findings);
    let of_noise = found.map(|finding| PlaceEntry {
        coordinate: finding.coordinate.name().into(),
        significance_sigma: finding.explained.sqrt(),
        range: finding.range,
        note: finding.note.clone(),
    });
    let mut entries: Vec<PlaceEntry> = outcome
        .places
        .iter()
        .filter(|place| place.sigma >= PLACE_SIGMA)
        .map(|place| PlaceEntry {
            coordinate: place.coordinate.name().into(),
            significance_sigma: place.sigma,
            range: place.range,
            note: place.note.clone(),
        })
        .collect();
    if outcome.p_global > SIGNIFICANCE && outcome.after.hypotheses.is_empty() && outcome.unexplained.is_none() {
        entries.clear();
    }
    // The scan sees little of what is no noise where it is the disagreement.
    let only_noise = outcome.p_global > SIGNIFICANCE;
    let at = if only_noise { 0 } else { entries.len() };
    entries.splice(at..at, of_noise);
    entries
}

pub(super) fn blind_spots(assumed: &AssumedModel, outcome: &Outcome) -> Vec<BlindSpot> {
    let mut spots: Vec<BlindSpot> = Vec::new();
    for &(effect, component, sigma) in &outcome.visibility {
        if component > 0 {
            continue;
        }
        let spec = assumed.spec(effect);
        let Some(key) = assumed.moved_keys(effect).first().copied() else {
            continue;
        };
        let parameter = &spec.parameters[key];
        let plausible_max = (parameter.plausible.1 - parameter.null)
            .abs()
            .max((parameter.plausible.0 - parameter.null).abs());
        let amplitude = (sigma > 1e-9)
            .then(|| plausible_max * (5.0 / sigma).powf(1.0 / f64::from(spec.amplitude_power)))
            .filter(|amplitude| *amplitude < 1e4 * plausible_max);
        spots.push(BlindSpot {
            effect: spec.name.into(),
            parameter: parameter.key.into(),
            amplitude_at_5_sigma: amplitude,
            plausible_max,
            blind: amplitude.is_none_or(|amplitude| amplitude > plausible_max),
        });
    }
    spots
}
