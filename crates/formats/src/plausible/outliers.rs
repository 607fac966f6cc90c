//! Single intensities that all their neighbours contradict: a digit lost or changed, a decimal point moved, a reading
//! that failed.
//!
//! A value is looked at against its neighbours along γ, what straight and geometric lines through two of them lead to,
//! and the same direction in the planes beside. Rugged light departs in many places; a wrong number departs in one.

use super::{Stored, at};
use crate::finding::{Finding, Findings};

/// A departure counts from this part of the peak on, and from this part of the larger of value and neighbours.
const LEAST: (f64, f64) = (0.03, 0.5);
/// More places than these in a file, and its light is rugged.
const MOST: usize = 3;

/// Looks at every value that has two neighbours on either side along γ.
pub(super) fn check(stored: &Stored<'_>, findings: &mut Findings) {
    let (planes, ng) = (stored.planes_deg.len(), stored.angles_deg.len());
    let values = stored.values;
    let peak = values.iter().fold(0.0_f64, |most, value| most.max(value.abs()));
    if ng < 5 || values.len() != planes * ng {
        return;
    }
    let mut places: Vec<(usize, f64)> = Vec::new();
    for index in (0..values.len()).filter(|index| (2..ng - 2).contains(&(index % ng))) {
        let value = values[index];
        let (before, after) = (values[index - 1], values[index + 1]);
        let (low, high) = (before.min(after), before.max(after));
        let far = |bound: f64| {
            let apart = (value - bound).abs();
            apart > LEAST.0 * peak && apart > LEAST.1 * value.abs().max(bound.abs())
        };
        // A dip at the horizon, where a luminaire is seen edge on, is light.
        let edge_on = stored.poles && stored.angles_deg[index % ng] == 90.0 && value < low;
        if (low..=high).contains(&value) || !far(value.clamp(low, high)) || edge_on {
            continue;
        }
        let (left, right) = (values[index - 2], values[index + 2]);
        let beside = [index.checked_sub(ng), Some(index + ng)].into_iter().flatten();
        let beside = beside.filter_map(|index| values.get(index).copied());
        let ahead = [2.0 * before - left, 2.0 * after - right].map(|value| value.max(0.0));
        let steep = [before * before / left, after * after / right]
            .into_iter()
            .filter(|value| value.is_finite());
        let all = ahead.into_iter().chain(steep).chain(beside);
        let (low, high) = all.fold((low, high), |(low, high), value| (low.min(value), high.max(value)));
        let bound = value.clamp(low, high);
        if far(bound) {
            places.push((index, bound));
        }
    }
    if places.len() > MOST {
        return;
    }
    for (index, bound) in places {
        let angle = stored.angles_deg[index % ng];
        let message =
            format!("this intensity (γ = {angle}°) does not fit its neighbours, which suggest about {bound:.4}");
        let finding = Finding::warning("intensity-outlier", message).assumed("the value as it stands");
        findings.push(at(stored, index, finding).fix("compare it with the source; a digit may be wrong"));
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const NG: usize = 37;

    fn lines(values: &[f64], planes: usize) -> Vec<usize> {
        let ng = values.len() / planes;
        let planes_deg: Vec<f64> = (0..planes).map(|plane| plane as f64 * 15.0).collect();
        let angles_deg: Vec<f64> = (0..ng).map(|angle| angle as f64 * 2.5).collect();
        let places: Vec<(usize, usize)> = (0..values.len()).map(|index| (index + 1, 1)).collect();
        let stored = Stored {
            planes_deg: &planes_deg,
            angles_deg: &angles_deg,
            values,
            places: &places,
            raw: &|_| "1.01",
            poles: true,
        };
        let mut findings = Findings::new();
        check(&stored, &mut findings);
        findings.into_vec().iter().filter_map(|finding| finding.line).collect()
    }

    fn lobe(planes: usize) -> Vec<f64> {
        let cosine = |index: usize| ((index % NG) as f64 * 2.5).to_radians().cos().max(0.0);
        (0..planes * NG).map(|index| 500.0 * cosine(index).powf(1.5)).collect()
    }

    #[test]
    fn smooth_light_is_quiet_and_a_wrong_value_is_reported() {
        for planes in [1, 7] {
            let mut values = lobe(planes);
            assert!(lines(&values, planes).is_empty());
            let wrong = (planes - 1) * NG + 12;
            values[wrong] /= 10.0;
            assert_eq!(lines(&values, planes), [wrong + 1]);
        }
    }

    #[test]
    fn rugged_light_is_quiet() {
        // Every third direction in the shadow of a louvre.
        let values: Vec<f64> = (0..3 * NG).map(|at| if at % 3 == 0 { 60.0 } else { 400.0 }).collect();
        assert!(lines(&values, 3).is_empty());
    }

    #[test]
    fn a_dip_at_the_horizon_is_the_luminaires_edge() {
        let both = |at: usize| (2.5 * at as f64).to_radians().cos().abs();
        let mut values: Vec<f64> = (0..73).map(|at| 60.0 + 400.0 * both(at)).collect();
        values[36] = 5.0;
        assert!(lines(&values, 1).is_empty());
        values[36] = 60.0;
        values[35] = 5.0;
        assert_eq!(lines(&values, 1), [36]);
    }

    #[test]
    fn a_cut_off_in_all_planes_is_light() {
        let values: Vec<f64> = (0..7 * NG).map(|at| if at % NG < 9 { 400.0 } else { 0.0 }).collect();
        assert!(lines(&values, 7).is_empty());
    }
}
