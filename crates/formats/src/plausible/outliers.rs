//! Single intensities that do not belong where they stand: two numbers swapped, a digit lost or changed.
//!
//! Light varies smoothly with direction at the resolution of a photometric file, and where it does not (a cut-off), it
//! does not in the neighbouring planes either. A value is compared with the cubic through its four neighbours along γ.
//! One wrong value leaves a known pattern in the residuals of its neighbours; the value is suspect when changing it
//! alone removes (almost) all of that pattern, when the pattern is far above what the surroundings show, and when, in
//! files of several planes, the neighbouring planes agree with the change. Thresholds are calibrated on files by many
//! hands so that good ones stay quiet; see `tests/damage.rs`.

use super::{Stored, at, standout};
use crate::finding::{Finding, Findings};

/// Share of the residual pattern that may remain after a change.
const REMAINS: f64 = 0.05;
/// How far above the typical residual of the surroundings the change must be.
const ABOVE_TYPICAL: f64 = 12.0;
/// How far above the larger residuals of the surroundings.
const ABOVE_LARGEST: f64 = 6.0;
/// Least change, relative to the largest of the value and its neighbours.
const RELATIVE: f64 = 0.02;
/// Least change, in units of the last decimal that the file uses.
const DIGITS: f64 = 3.0;
/// A pair put right makes a step within this factor of its neighbours.
const EVEN: f64 = 0.5;
/// Fewest angles for a meaningful comparison.
const FEWEST: usize = 9;
/// More suspects than these, and than one in a hundred: the light itself is rough, and single values say nothing.
const FEW: usize = 6;
const ROUGH: usize = 100;

pub(super) fn check(stored: &Stored<'_>, findings: &mut Findings) {
    let Some(grid) = Grid::new(stored) else { return };
    let mut suspects = grid.suspects();
    suspects.dedup_by_key(|suspect| (suspect.plane, suspect.angle));
    if suspects.len() > FEW.max(stored.values.len() / ROUGH) {
        suspects.clear();
    }
    for found in standout::find(stored, grid.step) {
        let near = |known: &Suspect| known.plane == found.plane && known.angle.abs_diff(found.angle) <= 2;
        if !suspects.iter().any(near) {
            suspects.push(Suspect {
                plane: found.plane,
                angle: found.angle,
                change: found.change,
                swapped: found.pair,
            });
        }
    }
    for suspect in suspects {
        let index = suspect.plane * grid.ng + suspect.angle;
        let expected = stored.values[index] + suspect.change;
        let (message, fix) = if suspect.swapped {
            (
                format!(
                    "this intensity and the next one (γ = {}°) fit their neighbours only the other way round",
                    stored.angles_deg[suspect.angle]
                ),
                "compare both with the source; they may be swapped",
            )
        } else {
            (
                format!(
                    "this intensity (γ = {}°) does not fit its neighbours, which suggest about {expected:.4}",
                    stored.angles_deg[suspect.angle]
                ),
                "compare it with the source; a digit may be wrong, or two numbers swapped",
            )
        };
        findings.push(
            at(
                stored,
                index,
                Finding::warning("intensity-outlier", message).assumed("the value as it stands"),
            )
            .fix(fix),
        );
    }
}

#[derive(Debug, Clone, Copy)]
struct Suspect {
    plane: usize,
    angle: usize,
    change: f64,
    swapped: bool,
}

struct Grid<'s> {
    planes: usize,
    ng: usize,
    values: &'s [f64],
    /// Residual of each value against the cubic through its four neighbours along γ; zero where there are fewer.
    residual: Vec<f64>,
    /// Weight of value `i + k − 2` in the residual of angle `i`.
    weight: Vec<[f64; 5]>,
    /// The same across planes, where there are enough of them.
    across: Option<Vec<[f64; 5]>>,
    step: f64,
    peak: f64,
    grazing: Vec<bool>,
}

impl<'s> Grid<'s> {
    fn new(stored: &'s Stored<'_>) -> Option<Self> {
        let (planes, ng) = (stored.planes_deg.len(), stored.angles_deg.len());
        if ng < FEWEST || stored.values.len() != planes * ng {
            return None;
        }
        let peak = stored.values.iter().fold(0.0_f64, |most, value| most.max(value.abs()));
        if peak == 0.0 {
            return None;
        }
        let weight = weights(stored.angles_deg);
        let rising = stored.planes_deg.windows(2).all(|pair| pair[1] > pair[0]);
        let across = (planes >= 5).then(|| {
            if rising {
                weights(stored.planes_deg)
            } else {
                weights(&(0..planes).map(|plane| plane as f64).collect::<Vec<_>>())
            }
        });
        let mut residual = vec![0.0; planes * ng];
        for plane in 0..planes {
            for angle in 2..ng - 2 {
                let row = &stored.values[plane * ng..];
                residual[plane * ng + angle] = (0..5).map(|k| weight[angle][k] * row[angle + k - 2]).sum();
            }
        }
        let grazing = stored
            .angles_deg
            .iter()
            .map(|angle| (angle - 90.0).abs() <= 5.0)
            .collect();
        let step = 10f64.powi(-decimals(stored));
        Some(Self {
            planes,
            ng,
            values: stored.values,
            residual,
            weight,
            across,
            step,
            peak,
            grazing,
        })
    }

    fn value(&self, plane: usize, angle: usize) -> f64 {
        self.values[plane * self.ng + angle]
    }

    fn suspects(&self) -> Vec<Suspect> {
        let mut found = Vec::new();
        for plane in 0..self.planes {
            let mut row: Vec<Suspect> = Vec::new();
            for angle in 1..self.ng - 2 {
                if angle > 1 {
                    row.extend(self.single(plane, angle));
                }
                row.extend(self.swapped(plane, angle));
            }
            // Neighbours of a wrong value can look wrong too: the largest change of a group speaks for it.
            row.sort_by(|a, b| b.change.abs().total_cmp(&a.change.abs()));
            let mut kept: Vec<Suspect> = Vec::new();
            for suspect in row {
                if kept.iter().all(|other| other.angle.abs_diff(suspect.angle) > 2) {
                    kept.push(suspect);
                }
            }
            kept.sort_by_key(|suspect| suspect.angle);
            found.extend(kept);
        }
        found
    }

    /// Residuals within `reach` of the changed angles, and how much each falls with a unit of change.
    fn pattern(&self, plane: usize, from: usize, to: usize, column: impl Fn(usize) -> f64) -> (f64, f64, f64) {
        let (mut before, mut product, mut norm) = (0.0, 0.0, 0.0);
        for angle in from..to {
            let (residual, weight) = (self.residual[plane * self.ng + angle], column(angle));
            before += residual * residual;
            product += residual * weight;
            norm += weight * weight;
        }
        (before, product, norm)
    }

    /// How much the residual of `angle` changes with the value at `source`.
    fn column(&self, angle: usize, source: usize) -> f64 {
        (source + 2)
            .checked_sub(angle)
            .filter(|&k| k < 5)
            .map_or(0.0, |k| self.weight[angle][k])
    }

    /// A low and a middling residual around, beyond the reach of the change. Another wrong value nearby, or the
    /// horizon at 90°, must not hide this one: the upper half is left out.
    fn surroundings(&self, plane: usize, from: usize, to: usize) -> (f64, f64) {
        let row = &self.residual[plane * self.ng..(plane + 1) * self.ng];
        let before = from.saturating_sub(6).max(2)..from;
        let after = to..(to + 6).min(self.ng - 2);
        let mut around: Vec<f64> = before.chain(after).map(|angle| row[angle].abs()).collect();
        around.sort_by(f64::total_cmp);
        let at = |index: usize| around.get(index).copied().unwrap_or(0.0).max(self.step);
        (at(around.len() / 3), at(around.len() / 2))
    }

    fn far_enough(&self, plane: usize, angle: usize, change: f64, (typical, largest): (f64, f64)) -> bool {
        let near = (angle - 1..=angle + 1)
            .map(|angle| self.value(plane, angle).abs())
            .fold(0.002 * self.peak, f64::max);
        change.abs() > DIGITS * self.step
            && change.abs() > RELATIVE * near
            && change.abs() > ABOVE_TYPICAL * typical
            && change.abs() > ABOVE_LARGEST * largest
    }

    fn single(&self, plane: usize, angle: usize) -> Option<Suspect> {
        let (from, to) = (angle.saturating_sub(2).max(2), (angle + 3).min(self.ng - 2));
        let (before, product, norm) = self.pattern(plane, from, to, |other| self.column(other, angle));
        if before <= 0.0 || to - from < 3 {
            return None;
        }
        let change = -product / norm;
        let after = before - product * product / norm;
        if after > REMAINS * before || !self.far_enough(plane, angle, change, self.surroundings(plane, from, to)) {
            return None;
        }
        // Light that grazes the luminaire's edge breaks off at 90°; a single plane cannot tell that from damage.
        if self.across.is_none() && self.grazing[angle] {
            return None;
        }
        if let Some(change_across) = self.change_across(plane, angle)
            && (change_across - change).abs() > 0.5 * change.abs()
        {
            return None;
        }
        Some(Suspect {
            plane,
            angle,
            change,
            swapped: false,
        })
    }

    /// The change that the neighbouring planes suggest.
    fn change_across(&self, plane: usize, angle: usize) -> Option<f64> {
        let weights = self.across.as_ref()?;
        let (from, to) = (plane.saturating_sub(2).max(2), (plane + 3).min(self.planes - 2));
        let (mut product, mut norm) = (0.0, 0.0);
        for (other, weights) in weights.iter().enumerate().take(to).skip(from) {
            let residual: f64 = (0..5).map(|k| weights[k] * self.value(other + k - 2, angle)).sum();
            let weight = (plane + 2)
                .checked_sub(other)
                .filter(|&k| k < 5)
                .map_or(0.0, |k| weights[k]);
            product += residual * weight;
            norm += weight * weight;
        }
        (norm > 0.0).then(|| -product / norm)
    }

    fn swapped(&self, plane: usize, angle: usize) -> Option<Suspect> {
        if angle + 3 >= self.ng {
            return None;
        }
        let change = self.value(plane, angle + 1) - self.value(plane, angle);
        let (from, to) = (angle.saturating_sub(2).max(2), (angle + 4).min(self.ng - 2));
        let column = |other: usize| self.column(other, angle) - self.column(other, angle + 1);
        let (before, product, norm) = self.pattern(plane, from, to, column);
        let after = before + 2.0 * change * product + change * change * norm;
        if change == 0.0 || before <= 0.0 {
            return None;
        }
        let smooth =
            after <= REMAINS * before && self.far_enough(plane, angle, change, self.surroundings(plane, from, to));
        let agree = |angle: usize, change: f64| {
            self.change_across(plane, angle)
                .is_none_or(|across| (across - change).abs() <= 0.5 * change.abs())
        };
        let smooth = smooth && agree(angle, change) && agree(angle + 1, -change);
        (smooth || self.only_reversal(plane, angle, change)).then_some(Suspect {
            plane,
            angle,
            change,
            swapped: true,
        })
    }

    /// The pair is the only step against the slope around it, and as large as its neighbours: put right, the values
    /// fall (or rise) evenly.
    fn only_reversal(&self, plane: usize, angle: usize, change: f64) -> bool {
        let (from, to) = (angle.saturating_sub(3), (angle + 4).min(self.ng - 1));
        if angle == 0
            || to - from < 5
            || change.abs() <= DIGITS * self.step
            || change.abs() < RELATIVE * self.value(plane, angle).abs()
        {
            return false;
        }
        let right = |at: usize| match at {
            _ if at == angle => self.value(plane, angle + 1),
            _ if at == angle + 1 => self.value(plane, angle),
            _ => self.value(plane, at),
        };
        // `change` is the second value minus the first as they stand; put right, the step there is −change.
        let slope = -change.signum();
        let steps: Vec<f64> = (from..to).map(|at| (right(at + 1) - right(at)) * slope).collect();
        let at = angle - from;
        let (low, high) = (steps[at - 1].min(steps[at + 1]), steps[at - 1].max(steps[at + 1]));
        let falls = low > 0.0 && steps.iter().all(|&step| step >= 0.0);
        let beside = [plane.checked_sub(1), (plane + 1 < self.planes).then_some(plane + 1)];
        let planes_fall = beside
            .into_iter()
            .flatten()
            .all(|other| (self.value(other, angle + 1) - self.value(other, angle)) * slope > 0.0);
        falls && planes_fall && steps[at] > EVEN * low && steps[at] < high / EVEN
    }
}

/// Weights of the five values around each grid point in its residual: one for itself, minus the cubic through the
/// other four. Zero near the ends.
fn weights(grid: &[f64]) -> Vec<[f64; 5]> {
    let mut weights = vec![[0.0; 5]; grid.len()];
    for centre in 2..grid.len().saturating_sub(2) {
        for k in [0usize, 1, 3, 4] {
            let at = |k: usize| grid[centre + k - 2];
            let others = [0usize, 1, 3, 4].into_iter().filter(|&other| other != k);
            weights[centre][k] = -others
                .map(|other| (at(2) - at(other)) / (at(k) - at(other)))
                .product::<f64>();
        }
        weights[centre][2] = 1.0;
    }
    weights
}

/// The largest number of decimals among the first values.
fn decimals(stored: &Stored<'_>) -> i32 {
    let count = |index: usize| {
        (stored.raw)(index)
            .trim()
            .split_once('.')
            .map_or(0, |(_, digits)| digits.len())
    };
    (0..stored.values.len().min(2000)).map(count).max().unwrap_or(0).min(12) as i32
}

#[cfg(test)]
mod tests {
    use super::*;

    fn findings(values: &[f64], planes: usize) -> Vec<Finding> {
        let ng = values.len() / planes;
        let planes_deg: Vec<f64> = (0..planes).map(|plane| plane as f64 * 15.0).collect();
        let angles_deg: Vec<f64> = (0..ng).map(|angle| angle as f64 * 2.5).collect();
        let places: Vec<(usize, usize)> = (0..values.len()).map(|index| (index + 1, 1)).collect();
        let stored = Stored {
            planes_deg: &planes_deg,
            angles_deg: &angles_deg,
            values,
            places: &places,
            raw: &|_| "1.00",
            poles: true,
            ends_with_newline: true,
        };
        let mut findings = Findings::new();
        check(&stored, &mut findings);
        findings.into_vec()
    }

    const NG: usize = 37;

    fn lobe(planes: usize) -> Vec<f64> {
        let cosine = |index: usize| ((index % NG) as f64 * 2.5).to_radians().cos().max(0.0);
        (0..planes * NG).map(|index| 500.0 * cosine(index).powf(1.5)).collect()
    }

    fn lines(values: &[f64], planes: usize) -> Vec<usize> {
        findings(values, planes)
            .iter()
            .filter_map(|finding| finding.line)
            .collect()
    }

    #[test]
    fn smooth_light_is_quiet_and_a_wrong_value_is_named() {
        assert!(findings(&lobe(1), 1).is_empty());
        let mut swapped = lobe(1);
        swapped.swap(8, 25);
        assert_eq!(lines(&swapped, 1), [9, 26]);
        let mut neighbours = lobe(7);
        neighbours.swap(2 * NG + 18, 2 * NG + 19);
        assert_eq!(lines(&neighbours, 7), [2 * NG + 19]);
    }

    #[test]
    fn a_cut_off_in_all_planes_is_light() {
        let values: Vec<f64> = (0..7 * NG)
            .map(|index| if index % NG < 9 { 400.0 } else { 0.0 })
            .collect();
        assert!(findings(&values, 7).is_empty());
    }
}
