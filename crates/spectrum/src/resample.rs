//! Resampling: Sprague's fifth-order osculating polynomial for even spacing, as CIE 167 recommends, and straight lines.

use crate::Spectrum;

/// Why a spectrum cannot be resampled.
#[derive(Debug, Clone, Copy, PartialEq, thiserror::Error)]
pub enum ResampleError {
    /// Sprague's formula needs even spacing.
    #[error("the spacing is not even: {step_nm} nm after {at_nm} nm, {first_nm} nm at the beginning")]
    Uneven {
        /// The odd step.
        step_nm: f64,
        /// Where it begins.
        at_nm: f64,
        /// The first step.
        first_nm: f64,
    },
    /// Sprague's formula needs six points.
    #[error("{points} points; the interpolation needs six")]
    TooFew {
        /// Number of points.
        points: usize,
    },
    /// A step that is not above zero, or more than a million points.
    #[error("a step of {step_nm} nm is not possible here")]
    Step {
        /// The wanted step.
        step_nm: f64,
    },
}

impl Spectrum {
    /// The spectrum at every `step_nm` from its first wavelength, by Sprague's interpolation (CIE 167:2005, 9.2.1).
    ///
    /// # Errors
    /// [`ResampleError`] for uneven spacing (to 1e-3 of a step), fewer than six points, or an impossible step.
    pub fn resampled_sprague(&self, step_nm: f64) -> Result<Self, ResampleError> {
        let (w, y) = (self.wavelength_nm(), self.value());
        let n = w.len();
        if n < 6 {
            return Err(ResampleError::TooFew { points: n });
        }
        let first_nm = w[1] - w[0];
        for pair in w.windows(2) {
            let step = pair[1] - pair[0];
            if (step - first_nm).abs() > 1e-3 * first_nm {
                return Err(ResampleError::Uneven {
                    step_nm: step,
                    at_nm: pair[0],
                    first_nm,
                });
            }
        }
        let wavelength_nm = grid(w[0], w[n - 1], step_nm)?;
        let h = (w[n - 1] - w[0]) / (n - 1) as f64;
        let padded = padded(y);
        let value = wavelength_nm
            .iter()
            .map(|&nm| {
                let position = ((nm - w[0]) / h).clamp(0.0, (n - 1) as f64);
                let k = (position as usize).min(n - 2);
                sprague(&padded[k..k + 6], position - k as f64)
            })
            .collect();
        Self::new(wavelength_nm, value).map_err(|_| ResampleError::Step { step_nm })
    }

    /// The spectrum at every multiple of `step_nm` inside its range, on straight lines between its points.
    ///
    /// # Errors
    /// [`ResampleError::Step`] for an impossible step.
    pub fn resampled_linear(&self, step_nm: f64) -> Result<Self, ResampleError> {
        let (first, last) = (
            self.wavelength_nm()[0],
            self.wavelength_nm()[self.wavelength_nm().len() - 1],
        );
        let from = (first / step_nm * (1.0 - 1e-12)).ceil() * step_nm;
        let wavelength_nm = grid(from, last, step_nm)?;
        let value = wavelength_nm
            .iter()
            .map(|&nm| self.at_nm(nm.clamp(first, last)))
            .collect();
        Self::new(wavelength_nm, value).map_err(|_| ResampleError::Step { step_nm })
    }
}

/// Every `step_nm` from `first` to `last`, at least two points and at most a million.
fn grid(first: f64, last: f64, step_nm: f64) -> Result<Vec<f64>, ResampleError> {
    let count = ((last - first) / step_nm * (1.0 + 1e-12)).floor();
    if !(step_nm > 0.0 && (1.0..1e6).contains(&count)) {
        return Err(ResampleError::Step { step_nm });
    }
    // Twelve digits hide the dust of a product such as 3·0.1.
    let clean = |nm: f64| format!("{nm:.11e}").parse().unwrap_or(nm);
    Ok((0..=count as usize)
        .map(|i| clean(first + i as f64 * step_nm))
        .collect())
}

/// Two points more at each end by CIE 167's boundary coefficients.
fn padded(y: &[f64]) -> Vec<f64> {
    const OUTER: [f64; 6] = [884.0, -1960.0, 3033.0, -2648.0, 1080.0, -180.0];
    const INNER: [f64; 6] = [508.0, -540.0, 488.0, -367.0, 144.0, -24.0];
    let n = y.len();
    let end = |c: &[f64; 6], at: &dyn Fn(usize) -> f64| (0..6).map(|i| c[i] * at(i)).sum::<f64>() / 209.0;
    let (front, back) = (|i: usize| y[i], |i: usize| y[n - 1 - i]);
    let mut out = vec![end(&OUTER, &front), end(&INNER, &front)];
    out.extend_from_slice(y);
    out.extend([end(&INNER, &back), end(&OUTER, &back)]);
    out
}

/// Between the third and the fourth of six even points.
fn sprague(r: &[f64], x: f64) -> f64 {
    let a = [
        r[2],
        (2.0 * r[0] - 16.0 * r[1] + 16.0 * r[3] - 2.0 * r[4]) / 24.0,
        (-r[0] + 16.0 * r[1] - 30.0 * r[2] + 16.0 * r[3] - r[4]) / 24.0,
        (-9.0 * r[0] + 39.0 * r[1] - 70.0 * r[2] + 66.0 * r[3] - 33.0 * r[4] + 7.0 * r[5]) / 24.0,
        (13.0 * r[0] - 64.0 * r[1] + 126.0 * r[2] - 124.0 * r[3] + 61.0 * r[4] - 12.0 * r[5]) / 24.0,
        (-5.0 * r[0] + 25.0 * r[1] - 50.0 * r[2] + 50.0 * r[3] - 25.0 * r[4] + 5.0 * r[5]) / 24.0,
    ];
    a.iter().rev().fold(0.0, |sum, a| sum * x + a)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_cubic_is_kept_exactly_inside() {
        let f = |x: f64| 1.0 + 0.3 * x - 0.02 * x * x + 0.001 * x * x * x;
        let nm: Vec<f64> = (0..20).map(|i| 400.0 + 5.0 * i as f64).collect();
        let s = Spectrum::new(nm.clone(), nm.iter().map(|w| f((w - 400.0) / 5.0)).collect()).unwrap();
        let fine = s.resampled_sprague(1.0).unwrap();
        assert_eq!(fine.wavelength_nm().len(), 96);
        for (w, v) in fine.wavelength_nm().iter().zip(fine.value()).skip(10).take(70) {
            assert!((v - f((w - 400.0) / 5.0)).abs() < 1e-9, "{w}");
        }
    }

    #[test]
    fn straight_lines_take_any_spacing() {
        let s = Spectrum::new(vec![400.3, 401.1, 404.0], vec![0.0, 0.8, 3.7]).unwrap();
        let even = s.resampled_linear(1.0).unwrap();
        assert_eq!(even.wavelength_nm(), [401.0, 402.0, 403.0, 404.0]);
        for (w, v) in even.wavelength_nm().iter().zip(even.value()) {
            assert!((v - (w - 400.3)).abs() < 1e-12, "{w}: {v}");
        }
        for step in [0.0, -1.0, f64::NAN, 1e-9, 50.0] {
            assert!(
                matches!(s.resampled_linear(step), Err(ResampleError::Step { .. })),
                "{step}"
            );
        }
    }

    #[test]
    fn the_given_points_are_kept_and_uneven_spacing_is_refused() {
        let nm: Vec<f64> = (0..8).map(|i| 400.0 + 10.0 * i as f64).collect();
        let v = vec![0.1, 0.5, 0.2, 0.9, 1.0, 0.3, 0.2, 0.4];
        let s = Spectrum::new(nm.clone(), v.clone()).unwrap();
        let fine = s.resampled_sprague(5.0).unwrap();
        for (i, v) in v.iter().enumerate() {
            assert!((fine.value()[2 * i] - v).abs() < 1e-12);
        }
        let mut uneven = nm;
        uneven[3] += 1.0;
        let s = Spectrum::new(uneven, v).unwrap();
        assert!(matches!(s.resampled_sprague(1.0), Err(ResampleError::Uneven { .. })));
        assert!(matches!(
            Spectrum::new(vec![1.0], vec![1.0]).unwrap().resampled_sprague(1.0),
            Err(ResampleError::TooFew { points: 1 })
        ));
    }
}
