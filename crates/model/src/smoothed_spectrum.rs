//! The spectrum of a model with less of its noise, for the comparison with another one.
//!
//! What an instrument does to light (a bandpass, stray light) it does not do to the noise of an earlier measurement: a
//! model with all its noise would fit better with any effect that takes some of that away. Each value becomes that of a
//! parabola fitted to its neighbours, as many on either side as agree: the widest window whose result lies within
//! [`AGREE`] standard uncertainties of every narrower one's (intersection of confidence intervals, Goldenshluger and
//! Nemirovski 1997). A line keeps its own values.

use isolux_spectrum::Spectrum;

use crate::document::SpectrumUncertainty;

/// Half widths of the windows that are tried, in nm.
const HALF_WIDTHS_NM: [f64; 6] = [0.0, 2.0, 4.0, 8.0, 16.0, 32.0];
/// Standard uncertainties around a result that count as agreeing with it.
const AGREE: f64 = 1.2;

/// A spectrum with its noise averaged, and how.
#[derive(Debug, Clone)]
pub(crate) struct SmoothedSpectrum {
    pub spectrum: Spectrum,
    /// For each wavelength of the spectrum: which values of the measured one it is the sum of, with their weights.
    pub weights: Vec<Vec<(usize, f64)>>,
    /// Noise of each measured value.
    pub noise: Vec<f64>,
}

impl SmoothedSpectrum {
    /// None where the result is no spectrum.
    pub fn new(measured: &Spectrum, u: &SpectrumUncertainty) -> Option<Self> {
        let (nm, value) = (measured.wavelength_nm(), measured.value());
        let noise: Vec<f64> = nm.iter().map(|nm| u.noise_at(*nm)).collect();
        let weights: Vec<Vec<(usize, f64)>> = (0..nm.len()).map(|at| window(nm, value, &noise, at)).collect();
        let sum = |weights: &Vec<(usize, f64)>| weights.iter().map(|(at, weight)| weight * value[*at]).sum();
        let spectrum = Spectrum::new(nm.to_vec(), weights.iter().map(sum).collect()).ok()?;
        Some(Self {
            spectrum,
            weights,
            noise,
        })
    }

    /// What one standard uncertainty of each measured value changes at `wavelength_nm`: its number and how much.
    pub fn errors_at(&self, wavelength_nm: f64) -> Vec<(usize, f64)> {
        let nm = self.spectrum.wavelength_nm();
        let above = nm.partition_point(|at| *at < wavelength_nm);
        let ends = match (above.checked_sub(1), nm.get(above)) {
            (_, Some(at)) if *at == wavelength_nm => vec![(above, 1.0)],
            (Some(below), Some(at)) => {
                let share = (wavelength_nm - nm[below]) / (at - nm[below]);
                vec![(below, 1.0 - share), (above, share)]
            }
            _ => Vec::new(),
        };
        let mut errors: Vec<(usize, f64)> = Vec::new();
        for (place, share) in ends {
            for (number, weight) in &self.weights[place] {
                let value = share * weight * self.noise[*number];
                match errors.iter_mut().find(|(known, _)| known == number) {
                    Some((_, sum)) => *sum += value,
                    None => errors.push((*number, value)),
                }
            }
        }
        errors
    }
}

/// Weights of the values around number `at` in the widest window that agrees with the narrower ones.
fn window(nm: &[f64], value: &[f64], noise: &[f64], at: usize) -> Vec<(usize, f64)> {
    let (mut low, mut high) = (f64::NEG_INFINITY, f64::INFINITY);
    let mut widest = vec![(at, 1.0)];
    for half_nm in HALF_WIDTHS_NM {
        let from = nm.partition_point(|other| *other < nm[at] - half_nm - 1e-9);
        let to = nm.partition_point(|other| *other <= nm[at] + half_nm + 1e-9);
        let Some(weights) = parabola(nm, at, from..to) else {
            continue;
        };
        let result: f64 = weights.iter().map(|(k, weight)| weight * value[*k]).sum();
        let square: f64 = weights.iter().map(|(k, weight)| (weight * noise[*k]).powi(2)).sum();
        let reach = AGREE * square.sqrt();
        (low, high) = (low.max(result - reach), high.min(result + reach));
        if low > high {
            break;
        }
        widest = weights;
    }
    widest
}

/// Weights with which values make that of their parabola at number `at` (Savitzky and Golay 1964, for any distances);
/// of fewer than five values that of the one itself.
fn parabola(nm: &[f64], at: usize, range: std::ops::Range<usize>) -> Option<Vec<(usize, f64)>> {
    if range.len() < 5 {
        return Some(vec![(at, 1.0)]);
    }
    let reach = (nm[range.end - 1] - nm[range.start]).max(f64::MIN_POSITIVE);
    let powers = |k: usize| {
        let x = (nm[k] - nm[at]) / reach;
        glam::DVec3::new(1.0, x, x * x)
    };
    let mut normal = glam::DMat3::ZERO;
    for k in range.clone() {
        let p = powers(k);
        normal += glam::DMat3::from_cols(p * p.x, p * p.y, p * p.z);
    }
    let determinant = normal.determinant();
    if !(determinant.is_finite() && determinant > 0.0) {
        return None;
    }
    // The value at the place itself is the first coefficient.
    let first = normal.inverse().row(0);
    Some(range.map(|k| (k, first.dot(powers(k)))).collect())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn u(noise: f64) -> SpectrumUncertainty {
        SpectrumUncertainty {
            wavelength_nm: vec![500.0],
            noise: vec![noise],
            ..SpectrumUncertainty::default()
        }
    }

    /// The same ± 1 as any noise has at random, of mean 0 and square 1.
    fn scatter(k: usize) -> f64 {
        const OF: [f64; 7] = [1.3, -0.4, -1.5, 0.9, 0.2, -1.1, 0.6];
        OF[k * 3 % 7] * if (k / 7).is_multiple_of(2) { 1.0 } else { -1.0 }
    }

    #[test]
    fn noise_is_averaged_where_nothing_is_and_a_line_stays() {
        let nm: Vec<f64> = (400..=700).map(f64::from).collect();
        let clean = |nm: f64| (-((nm - 600.0) / 60.0).powi(2)).exp() + if nm == 546.0 { 3.0 } else { 0.0 };
        let value = nm
            .iter()
            .enumerate()
            .map(|(k, nm)| clean(*nm) + 0.01 * scatter(k))
            .collect();
        let measured = Spectrum::new(nm.clone(), value).unwrap();
        let smoothed = SmoothedSpectrum::new(&measured, &u(0.01)).unwrap();
        let off = |range: std::ops::Range<usize>, of: &Spectrum| {
            let count = range.len() as f64;
            let square: f64 = range.map(|k| (of.value()[k] - clean(nm[k])).powi(2)).sum();
            (square / count).sqrt()
        };
        for quiet in [20..100, 200..280] {
            let (before, after) = (off(quiet.clone(), &measured), off(quiet, &smoothed.spectrum));
            assert!(after < 0.5 * before, "{before} {after}");
        }
        // The line itself, and what lies beside it.
        assert!(off(140..153, &smoothed.spectrum) < 0.015);
        // A parabola is kept whatever the window.
        for (at, weights) in smoothed.weights.iter().enumerate() {
            let of = |law: fn(f64) -> f64| -> f64 { weights.iter().map(|(k, w)| w * law(nm[*k] - nm[at])).sum() };
            assert!((of(|_| 1.0) - 1.0).abs() < 1e-9 && of(|x| x).abs() < 1e-7 && of(|x| x * x).abs() < 1e-5);
        }
    }

    #[test]
    fn an_error_of_one_value_goes_to_its_neighbours() {
        let nm: Vec<f64> = (400..=500).map(f64::from).collect();
        let measured = Spectrum::new(nm.clone(), vec![0.0; nm.len()]).unwrap();
        let smoothed = SmoothedSpectrum::new(&measured, &u(0.01)).unwrap();
        let at = 450.5;
        let changed = |number: usize| {
            let mut value = vec![0.0; nm.len()];
            value[number] = 0.01;
            let sum = |weights: &Vec<(usize, f64)>| weights.iter().map(|(k, w)| w * value[*k]).sum();
            let values = smoothed.weights.iter().map(sum).collect();
            Spectrum::new(nm.clone(), values).unwrap().at_nm(at)
        };
        let errors = smoothed.errors_at(at);
        assert!(errors.len() > 60);
        for (number, value) in errors {
            assert!((value - changed(number)).abs() < 1e-12);
        }
    }
}
