//! The scatter against what is stated and against repeats of one pose, which know the noise whatever was stated (lack
//! of fit: Draper and Smith, Applied Regression Analysis).

use std::collections::HashMap;

use super::finding::{Finding, Kind, Strongest, digits};
use super::limits::{REPEATS, REPEATS_AT_ONCE, SCALE};
use super::residuals::Residuals;
use super::series::{Series, hold};
use crate::table::{Coordinate, Light, ObservationKind, Row};
use crate::whitening::Sequence;

/// Variance of readings that should be alike, and its degrees of freedom.
#[derive(Clone, Copy)]
struct Pure {
    variance: f64,
    freedom: f64,
}

/// What repeats of lit poses say of the noise.
pub(super) struct Repeats {
    /// Readings of a pose about their mean, whenever they were taken.
    visits: Option<Pure>,
    /// Successive readings of a pose about their own mean.
    at_once: Option<Pure>,
    /// Differences of successive readings of one pose, and of successive readings of different poses.
    successive: Option<(Pure, Pure)>,
}

impl Repeats {
    pub(super) fn of(residuals: &Residuals<'_>, series: &Series<'_>) -> Self {
        if series.source != ObservationKind::Reading {
            return Self {
                visits: None,
                at_once: None,
                successive: None,
            };
        }
        Self {
            visits: visits(residuals, series).filter(|pure| pure.freedom >= REPEATS),
            at_once: at_once(residuals, series).filter(|pure| pure.freedom >= REPEATS_AT_ONCE),
            successive: successive(residuals, series)
                .filter(|(same, other)| same.freedom >= REPEATS && other.freedom >= REPEATS),
        }
    }

    /// Scatter and degrees of freedom of the repeats.
    pub(super) fn visits(&self) -> Option<(f64, f64)> {
        self.visits.map(|pure| (pure.variance.sqrt(), pure.freedom))
    }

    /// What is more than noise by stated uncertainties and repeats, and the largest scatter that counts as noise.
    pub(super) fn compare(&self, residuals: &Residuals<'_>, series: &Series<'_>) -> (Vec<Finding>, f64) {
        let range = series.numbers();
        // Correlation beyond what counts as noise explains no scatter: the scatter is that of the correlation that
        // does. Correlated readings know their variance less well, unless their correlation is at that bound.
        let beyond = (1.0 + residuals.rho * residuals.rho - 2.0 * residuals.rho * residuals.rho_found)
            / (1.0 - residuals.rho * residuals.rho);
        let (scale, correlated) = if residuals.rho_found > residuals.rho {
            (residuals.scale * beyond.max(0.1).sqrt(), 1.0)
        } else {
            (
                residuals.scale,
                (1.0 + residuals.rho * residuals.rho) / (1.0 - residuals.rho * residuals.rho),
            )
        };
        let u_square = 2.0 * correlated / residuals.freedom.max(1.0);
        let finding = |kind: Kind, ratio: f64, u_square: f64, note: String| {
            let z = ratio.ln() / u_square.sqrt();
            let mut found = Finding::new(kind, Coordinate::Noise, range, Strongest::default(), note);
            if z > 0.0 {
                found.sigma = z;
                found.p_value = 0.5 * libm::erfc(z / std::f64::consts::SQRT_2);
                found.explained = (ratio - 1.0) * residuals.freedom;
            }
            found
        };
        let mut found = Vec::new();
        let mut limit = f64::INFINITY;
        if let Some(pure) = self.visits {
            // Readings that scatter no more than stated are no disagreement.
            limit = (SCALE * pure.variance.sqrt()).max(1.0);
            let note = format!(
                "the readings scatter {} times as much as stated and repeats of a pose {} times",
                digits(scale),
                digits(pure.variance.sqrt())
            );
            let u_square = u_square + 2.0 * correlated / pure.freedom;
            found.push(finding(Kind::Repeats, (scale / limit).powi(2), u_square, note));
        }
        // More than stated is noise only where readings of one pose that follow each other show it: what changes
        // between visits of a pose is a change in time, however large it makes their scatter.
        let shown = self.at_once.map_or(1.0, |at_once| at_once.variance);
        let stated = SCALE * shown.sqrt().max(1.0);
        let mut note = format!("the readings scatter {} times as much as stated", digits(scale));
        if let Some(at_once) = self.at_once {
            note += &format!(
                ", those of one pose that follow each other {} times",
                digits(at_once.variance.sqrt())
            );
        }
        found.push(finding(Kind::Scatter, (scale / stated).powi(2), u_square, note));
        limit = limit.min(stated);
        if let Some((same, other)) = self.successive {
            let ratio = other.variance / (SCALE * SCALE * same.variance.max(0.01));
            let note = format!(
                "successive readings of different poses differ {} times as much as those of one pose",
                digits((other.variance / same.variance.max(0.01)).sqrt())
            );
            let u_square = 2.0 / same.freedom + 2.0 / other.freedom;
            if other.variance > 1.0 {
                found.push(finding(Kind::Repeats, ratio, u_square, note));
            }
        }
        (found, limit)
    }
}

/// Rows of the series with the same pose, lit.
fn poses(series: &Series<'_>) -> Vec<Vec<usize>> {
    let mut poses: HashMap<_, Vec<usize>> = HashMap::new();
    for (i, row) in series
        .rows
        .iter()
        .enumerate()
        .filter(|(_, row)| row.light == Light::Lit)
    {
        let at = |value: f64| (value * 20.0).round() as i64;
        let pose = (
            row.file,
            at(row.c_deg),
            at(row.gamma_deg),
            at(row.distance_mm),
            row.travel as i64,
        );
        poses.entry(pose).or_default().push(i);
    }
    let mut poses: Vec<Vec<usize>> = poses.into_values().filter(|pose| pose.len() > 1).collect();
    poses.sort();
    poses
}

/// Variance of repeated readings about the mean of their pose, their serial correlation taken out.
fn visits(residuals: &Residuals<'_>, series: &Series<'_>) -> Option<Pure> {
    let poses = poses(series);
    let mut members: Vec<usize> = poses.iter().flatten().copied().collect();
    members.sort_unstable();
    if members.len() < poses.len() + REPEATS as usize {
        return None;
    }
    let runs: Vec<usize> = members.iter().map(|&i| series.rows[i].file).collect();
    let times: Vec<f64> = members.iter().map(|&i| series.rows[i].time_s).collect();
    let sequence = Sequence::by_time(&runs, &times);
    let whole: Vec<f64> = members.iter().map(|&i| residuals.plain[series.place[i]]).collect();
    let mut pose_of = vec![0; members.len()];
    for (k, pose) in poses.iter().enumerate() {
        for i in pose {
            if let Ok(place) = members.binary_search(i) {
                pose_of[place] = k;
            }
        }
    }
    let freedom = (members.len() - poses.len()) as f64;
    Some(Pure {
        variance: about_means(hold(&whole), &pose_of, poses.len(), &sequence, residuals.rho) / freedom.max(1.0),
        freedom,
    })
}

/// Squared length that values of correlation `rho` keep once the mean of each pose is fitted: least squares by
/// conjugate gradients (CGLS: Björck 1996), for a matrix of readings times poses would not fit in memory. A
/// correlation of a half makes a condition of nine at most.
fn about_means(mut residuals: Vec<f64>, pose_of: &[usize], poses: usize, sequence: &Sequence, rho: f64) -> f64 {
    const MOST: usize = 200;
    const SMALL: f64 = 1e-20;
    let whiten = sequence.whitening(rho);
    let mut share = vec![0.0_f64; poses];
    for &pose in pose_of {
        share[pose] += 1.0;
    }
    for share in &mut share {
        *share = share.max(1.0).sqrt().recip();
    }
    let to_poses = |values: &[f64]| -> Vec<f64> {
        let mut back = values.to_vec();
        sequence.whiten_transposed(rho, &mut back);
        let mut sums = vec![0.0; poses];
        for (value, &pose) in back.iter().zip(pose_of) {
            sums[pose] += value * share[pose];
        }
        sums
    };
    let square = |values: &[f64]| values.iter().map(|value| value * value).sum::<f64>();
    whiten(&mut residuals);
    let mut gradient = to_poses(&residuals);
    let mut direction = gradient.clone();
    let mut steep = square(&gradient);
    let first = steep;
    for _ in 0..MOST {
        if steep <= SMALL * first {
            break;
        }
        let mut moved: Vec<f64> = pose_of.iter().map(|&pose| direction[pose] * share[pose]).collect();
        whiten(&mut moved);
        let length = steep / square(&moved);
        for (residuals, moved) in residuals.iter_mut().zip(&moved) {
            *residuals -= length * moved;
        }
        gradient = to_poses(&residuals);
        let before = std::mem::replace(&mut steep, square(&gradient));
        for (direction, gradient) in direction.iter_mut().zip(&gradient) {
            *direction = gradient + steep / before * *direction;
        }
    }
    square(&residuals)
}

/// Whether two readings that follow each other are of one lit pose.
fn alike(a: &Row, b: &Row) -> bool {
    let near = |a: f64, b: f64| (a - b).abs() < 0.05;
    a.light == Light::Lit
        && b.light == Light::Lit
        && near(a.c_deg, b.c_deg)
        && near(a.gamma_deg, b.gamma_deg)
        && near(a.distance_mm, b.distance_mm)
}

/// Variance of successive readings of a pose about the mean of that visit, whatever their serial correlation.
fn at_once(residuals: &Residuals<'_>, series: &Series<'_>) -> Option<Pure> {
    let held = hold(&series.place.iter().map(|&i| residuals.plain[i]).collect::<Vec<_>>());
    let (mut squares, mut freedom) = (0.0, 0.0);
    let mut start = 0;
    for k in 1..=series.len() {
        if k < series.len() && series.follows[k] && alike(series.rows[k - 1], series.rows[k]) {
            continue;
        }
        let visit = &held[start..k];
        let mean = visit.iter().sum::<f64>() / visit.len() as f64;
        squares += visit.iter().map(|value| (value - mean).powi(2)).sum::<f64>();
        freedom += visit.len() as f64 - 1.0;
        start = k;
    }
    (freedom > 0.0).then(|| Pure {
        variance: squares / freedom,
        freedom,
    })
}

/// Mean squared differences of successive readings of one pose, and of different poses.
fn successive(residuals: &Residuals<'_>, series: &Series<'_>) -> Option<(Pure, Pure)> {
    let whole: Vec<f64> = series.place.iter().map(|&i| residuals.plain[i]).collect();
    let held = hold(&whole);
    let (mut same, mut other) = ((0.0, 0.0), (0.0, 0.0));
    for k in 1..series.len() {
        let (a, b) = (series.rows[k - 1], series.rows[k]);
        if !series.follows[k] || a.light != Light::Lit || b.light != Light::Lit {
            continue;
        }
        let sums = if alike(a, b) { &mut same } else { &mut other };
        sums.0 += (held[k] - held[k - 1]).powi(2);
        sums.1 += 1.0;
    }
    // Neighbouring differences share a reading: two of three are independent.
    let pure = |(sum, count): (f64, f64)| {
        (count > 0.0).then(|| Pure {
            variance: 0.5 * sum / count,
            freedom: count / 1.5,
        })
    };
    Some((pure(same)?, pure(other)?))
}

#[cfg(test)]
mod tests {
    use nalgebra::DMatrix;

    use super::*;
    use crate::basis::Basis;

    /// The same from an orthonormal basis of the whitened means.
    #[test]
    fn means_are_fitted_as_a_basis_fits_them() {
        let n = 60;
        let time: Vec<f64> = (0..n).map(|i| (4 * i + 20 * (i / 7)) as f64).collect();
        let sequence = Sequence::by_time(&vec![0; n], &time);
        let pose_of: Vec<usize> = (0..n).map(|i| if i % 3 == 0 { 0 } else { 1 + (i * i) % 9 }).collect();
        let values: Vec<f64> = (0..n).map(|i| ((i * 37) % 23) as f64 / 11.0 - 1.0).collect();
        for rho in [0.0, 0.5] {
            let mut means = DMatrix::from_fn(n, 10, |i, k| f64::from(pose_of[i] == k));
            sequence.whiten(rho, &mut means);
            let mut residuals = DMatrix::from_column_slice(n, 1, &values);
            sequence.whiten(rho, &mut residuals);
            Basis::spanning(&means, 1e-9).project_out(&mut residuals);
            let found = about_means(values.clone(), &pose_of, 10, &sequence, rho);
            assert!((found / residuals.norm_squared() - 1.0).abs() < 1e-9, "{found}");
        }
    }
}
