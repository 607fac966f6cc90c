//! Change of the lamp during the scan, from visits to the reference point.

use nalgebra::{DMatrix, DVector};

/// Relative level of the lamp over time: a polynomial through the reference readings, 1 at the first visit.
#[derive(Debug, Clone, PartialEq)]
pub struct Drift {
    /// Time of the first and the last visit, in s.
    pub span_s: (f64, f64),
    /// Coefficients of τ⁰, τ¹, …; τ runs from −1 to 1 over the span; the level before it is divided by that at the first visit.
    coefficients: Vec<f64>,
    /// Columns of a square root of the coefficients' covariance.
    covariance_root: Vec<Vec<f64>>,
    /// Visits used.
    pub visits: usize,
    /// Root mean square of the visits about the polynomial, relative.
    pub residual_rel: f64,
    /// Each visit: time in s, level relative to the polynomial's at the first visit, its standard uncertainty.
    pub levels: Vec<(f64, f64, f64)>,
}

impl Drift {
    /// Fits visits (time in s, illuminance in lx, standard uncertainty in lx). None with fewer than two visits at different
    /// times, or without light.
    ///
    /// Two or three visits give a straight line; with more a curvature is added where it improves χ² by more than 9 (3σ).
    pub(crate) fn fit(visits: &[(f64, f64, f64)]) -> Option<Self> {
        let first = visits.first()?.0;
        let last = visits.last()?.0;
        let mean = visits.iter().map(|visit| visit.1).sum::<f64>() / visits.len() as f64;
        if last <= first || mean <= 0.0 {
            return None;
        }
        let relative: Vec<(f64, f64, f64)> = visits
            .iter()
            .map(|&(t, e, u)| (tau(t, (first, last)), e / mean, (u / mean).max(1e-9)))
            .collect();
        let line = solve(&relative, 2)?;
        let curve = if relative.len() >= 6 { solve(&relative, 3) } else { None };
        let best = match curve {
            Some(curve) if line.chi2 - curve.chi2 > 9.0 => curve,
            _ => line,
        };
        let degrees = relative.len().saturating_sub(best.coefficients.len());
        // Visits that scatter more than stated count as they scatter.
        let scale = if degrees > 0 {
            (best.chi2 / degrees as f64).sqrt().max(1.0)
        } else {
            1.0
        };
        let residual = |&(t, level, _): &(f64, f64, f64)| level - polynomial(&best.coefficients, t);
        let residual_rel = (relative.iter().map(|v| residual(v).powi(2)).sum::<f64>() / relative.len() as f64).sqrt();
        let start = polynomial(&best.coefficients, -1.0);
        let levels = visits
            .iter()
            .map(|&(t, e, u)| (t, e / mean / start, u / mean / start))
            .collect();
        Some(Self {
            span_s: (first, last),
            covariance_root: best
                .root
                .into_iter()
                .map(|column| column.iter().map(|x| x * scale).collect())
                .collect(),
            coefficients: best.coefficients,
            visits: relative.len(),
            residual_rel,
            levels,
        })
    }

    /// Level of the lamp at a time, relative to the first visit; constant outside the span.
    pub fn level(&self, time_s: f64) -> f64 {
        polynomial(&self.coefficients, tau(time_s, self.span_s)) / polynomial(&self.coefficients, -1.0)
    }

    /// Relative change from the first to the last visit.
    pub fn change_rel(&self) -> f64 {
        self.level(self.span_s.1) - 1.0
    }

    /// Effect of each independent uncertainty of the fit on the relative level at a time.
    pub(crate) fn effects(&self, time_s: f64) -> Vec<f64> {
        let t = tau(time_s, self.span_s);
        let start = polynomial(&self.coefficients, -1.0);
        let level = self.level(time_s);
        self.covariance_root
            .iter()
            .map(|column| (polynomial(column, t) - level * polynomial(column, -1.0)) / start)
            .collect()
    }
}

struct Fit {
    coefficients: Vec<f64>,
    root: Vec<Vec<f64>>,
    chi2: f64,
}

fn solve(visits: &[(f64, f64, f64)], terms: usize) -> Option<Fit> {
    if visits.len() < terms {
        return None;
    }
    let design = DMatrix::from_fn(visits.len(), terms, |row, column| {
        visits[row].0.powi(column as i32) / visits[row].2
    });
    let target = DVector::from_iterator(visits.len(), visits.iter().map(|visit| visit.1 / visit.2));
    let covariance = (design.transpose() * &design).try_inverse()?;
    let coefficients = &covariance * design.transpose() * &target;
    let chi2 = (&design * &coefficients - target).norm_squared();
    let root = covariance.cholesky()?.l();
    Some(Fit {
        coefficients: coefficients.iter().copied().collect(),
        root: root
            .column_iter()
            .map(|column| column.iter().copied().collect())
            .collect(),
        chi2,
    })
}

fn polynomial(coefficients: &[f64], t: f64) -> f64 {
    coefficients.iter().rev().fold(0.0, |sum, c| sum * t + c)
}

fn tau(time_s: f64, span_s: (f64, f64)) -> f64 {
    (2.0 * (time_s - span_s.0) / (span_s.1 - span_s.0) - 1.0).clamp(-1.0, 1.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_straight_drift_is_found_and_normalised_to_its_start() {
        let visits: Vec<_> = (0..10)
            .map(|i| (100.0 + 60.0 * f64::from(i), 3.4 * (1.0 - 0.001 * f64::from(i)), 0.001))
            .collect();
        let drift = Drift::fit(&visits).unwrap();
        assert!((drift.level(100.0) - 1.0).abs() < 1e-12);
        assert!((drift.change_rel() + 0.009).abs() < 1e-9);
        assert!(
            (drift.level(1e9) - drift.level(640.0)).abs() < 1e-12,
            "no extrapolation"
        );
    }

    #[test]
    fn the_first_visit_is_exact_and_the_last_carries_the_slope() {
        let visits: Vec<_> = (0..20).map(|i| (f64::from(i), 1.0, 0.01)).collect();
        let drift = Drift::fit(&visits).unwrap();
        let u = |t: f64| drift.effects(t).iter().map(|e| e * e).sum::<f64>().sqrt();
        assert!(u(0.0) < 1e-12);
        // slope of 20 visits: u = 0.01·√(12/(n·(n²−1)))·19
        let slope = 0.01 * (12.0 / (20.0 * 399.0f64)).sqrt() * 19.0;
        assert!((u(19.0) - slope).abs() < 1e-4, "{} {slope}", u(19.0));
    }

    #[test]
    fn one_visit_is_no_drift() {
        assert_eq!(Drift::fit(&[(0.0, 3.4, 0.01)]), None);
        assert_eq!(Drift::fit(&[(5.0, 3.4, 0.01), (5.0, 3.4, 0.01)]), None);
    }
}
