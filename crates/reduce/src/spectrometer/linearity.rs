//! What is left of the non-linearity of a spectroradiometer, from the same light at several integration times.

use isolux_record::spectra::{LINEARITY_FORMAT, Linearity, SpectralCorrections, SpectrumRecord};
use isolux_record::{ReadingKind, Run};
use nalgebra::{DMatrix, DVector};

use super::error::InstrumentError;
use super::{Spectra, made, steady};
use crate::instrument::{Chain, Linear};

/// Pixels by their counts at the longest integration time, in shares of full scale.
const CLASSES: [f64; 10] = [0.02, 0.05, 0.1, 0.15, 0.2, 0.3, 0.4, 0.5, 0.6, 1.0];
/// Powers of the counts that are fitted.
const POWERS: usize = 2;
/// Peaks that the spectra have at least between them, in shares of full scale.
const PEAKS_REL: [f64; 2] = [0.15, 0.5];
/// What a polynomial may leave over beside noise and drift, relative.
const LEFT_REL: f64 = 0.002;

/// A class of pixels in a darker spectrum beside the brightest.
struct Ratio {
    /// Rate of the darker over that of the brighter one, less 1.
    difference_rel: f64,
    u_rel: f64,
    /// Counts over full scale of either.
    short: f64,
    long: f64,
    short_s: f64,
}

/// The brightest spectra, their mean pixel by pixel.
struct Bright {
    per_s: Vec<f64>,
    u_per_s: Vec<f64>,
    integration_s: f64,
}

/// The polynomial that makes rates at all integration times of a run the same.
///
/// # Errors
/// [`InstrumentError`]: saturated, unsteady, rates that no polynomial of the counts explains.
pub fn linearity(run: &Run) -> Result<Linearity, InstrumentError> {
    let Spectra { calibration, records } = Spectra::of(run, ReadingKind::Lit, "the same light at integration times")?;
    // What is to be found is not corrected for, and scattered light is proportional to all other.
    let mut own = calibration.clone();
    own.corrections = SpectralCorrections::default();
    let full = calibration.full_scale_counts;
    let longest_s = records.iter().map(|record| record.integration_s).fold(0.0, f64::max);
    let is_long = |record: &&SpectrumRecord| record.integration_s > 0.95 * longest_s;
    let (long, short): (Vec<&SpectrumRecord>, Vec<_>) = records.iter().copied().partition(is_long);
    let change_rel = steady(&long, &own, run.header.plan.limits().reference_rel())?;
    let linear = long.iter().map(|record| Linear::of(record, &own, Chain::ALL));
    let bright = Bright::of(&linear.collect::<Result<Vec<_>, _>>()?, longest_s);
    let mut peaks = vec![bright.per_s.iter().copied().fold(0.0, f64::max) * longest_s / full];
    let mut ratios = Vec::new();
    for record in short {
        let dim = Linear::of(record, &own, Chain::ALL)?;
        let peak = dim.per_s.iter().flatten().copied().fold(0.0, f64::max);
        peaks.push(peak * record.integration_s / full);
        ratios.extend(bright.beside(&dim, record.integration_s, full));
    }
    let low_rel = peaks.iter().copied().fold(f64::INFINITY, f64::min);
    let high_rel = peaks.iter().copied().fold(0.0, f64::max);
    if low_rel > PEAKS_REL[0] || high_rel < PEAKS_REL[1] || ratios.len() <= POWERS {
        return Err(InstrumentError::NoLevels { low_rel, high_rel });
    }
    let (coefficient, covariance) = fitted(&ratios, change_rel.abs() / 12.0_f64.sqrt());
    let found = Linearity {
        format: LINEARITY_FORMAT.to_owned(),
        coefficient,
        covariance,
        range_rel: [CLASSES[0] * low_rel / high_rel, high_rel],
        made: made(run, "the same light at several integration times"),
    };
    for ratio in &ratios {
        let expected = found.divisor(ratio.short) / found.divisor(ratio.long) - 1.0;
        let difference_rel = ratio.difference_rel - expected;
        let allowed_rel = 3.0 * ratio.u_rel + change_rel.abs() + LEFT_REL;
        if difference_rel.abs() > allowed_rel {
            return Err(InstrumentError::NotOfCounts {
                short_s: ratio.short_s,
                long_s: longest_s,
                difference_rel,
                allowed_rel,
            });
        }
    }
    Ok(found)
}

impl Bright {
    fn of(all: &[Linear], integration_s: f64) -> Self {
        let n = all.len() as f64;
        let pixels = 0..all.first().map_or(0, |of| of.per_s.len());
        let mean = |place: usize| all.iter().filter_map(|of| of.per_s[place]).sum::<f64>() / n;
        let u = |place: usize| all.iter().map(|of| of.u_per_s[place].powi(2)).sum::<f64>().sqrt() / n;
        Self {
            per_s: pixels.clone().map(mean).collect(),
            u_per_s: pixels.map(u).collect(),
            integration_s,
        }
    }

    /// The classes of pixels of a spectrum at another integration time.
    fn beside(&self, dim: &Linear, short_s: f64, full: f64) -> Vec<Ratio> {
        let of_class = |edges: &[f64]| {
            let mut sums = [0.0; 4];
            for (place, bright) in self.per_s.iter().enumerate() {
                let long = bright * self.integration_s / full;
                let Some(rate) = dim.per_s[place].filter(|_| (edges[0]..edges[1]).contains(&long)) else {
                    continue;
                };
                let ratio = rate / bright;
                let u = (dim.u_per_s[place] / bright).hypot(ratio * self.u_per_s[place] / bright);
                let weight = u.powi(-2);
                let terms = [1.0, ratio - 1.0, rate * short_s / full, long];
                sums.iter_mut().zip(terms).for_each(|(sum, term)| *sum += weight * term);
            }
            (sums[0] > 0.0).then(|| Ratio {
                difference_rel: sums[1] / sums[0],
                u_rel: sums[0].sqrt().recip(),
                short: sums[2] / sums[0],
                long: sums[3] / sums[0],
                short_s,
            })
        };
        CLASSES.windows(2).filter_map(of_class).collect()
    }
}

/// The coefficients and their covariance: noise of the classes, and a drift that all classes of a spectrum share.
fn fitted(ratios: &[Ratio], drift_rel: f64) -> (Vec<f64>, Vec<Vec<f64>>) {
    let count = ratios.len();
    // Rate over rate is near 1 + Σ c·(x_shortᵏ − x_longᵏ): linear in c where they are small.
    let matrix = DMatrix::from_fn(count, POWERS, |row, column| {
        let power = column as i32 + 1;
        ratios[row].short.powi(power) - ratios[row].long.powi(power)
    });
    let covariance = DMatrix::from_fn(count, count, |row, column| {
        let (one, other) = (&ratios[row], &ratios[column]);
        let shared = if one.short_s == other.short_s {
            drift_rel * drift_rel
        } else {
            0.0
        };
        let own = if row == column {
            one.u_rel.powi(2) + (0.1 * LEFT_REL).powi(2)
        } else {
            0.0
        };
        shared + own
    });
    // Its diagonal makes it regular, and classes of several counts the normal matrix.
    let weights = covariance
        .try_inverse()
        .unwrap_or_else(|| DMatrix::identity(count, count));
    let normal = (matrix.transpose() * &weights * &matrix).try_inverse();
    let normal = normal.unwrap_or_else(|| DMatrix::zeros(POWERS, POWERS));
    let mut coefficient = vec![0.0; POWERS];
    let divisor = |of: &[f64], x: f64| 1.0 + x * of.iter().rev().fold(0.0, |sum, c| sum * x + c);
    // Of a few per cent some repetitions leave a millionth.
    for _ in 0..5 {
        let left = ratios.iter().map(|ratio| {
            let expected = divisor(&coefficient, ratio.short) / divisor(&coefficient, ratio.long) - 1.0;
            ratio.difference_rel - expected
        });
        let change = &normal * (matrix.transpose() * &weights * DVector::from_iterator(count, left));
        coefficient
            .iter_mut()
            .zip(change.iter())
            .for_each(|(c, change)| *c += change);
    }
    let rows = (0..POWERS).map(|row| (0..POWERS).map(|column| normal[(row, column)]).collect());
    (coefficient, rows.collect())
}
