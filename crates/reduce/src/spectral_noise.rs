//! The noise of a spectroradiometer's pixels, from all of them together.
//!
//! A raw spectrum is read some ten times: the scatter of one pixel is known to a quarter of itself, and weights that go by
//! it would believe those most that scatter least by chance. What an array's pixels have in common is the law
//! u² = a + b·counts of read noise and photons (EMVA 1288, 2.2).

use isolux_record::spectra::{Pixel, SpectrumRecord};

/// Repetitions of the weighted fit: its weights are its own values.
const REPEATED: usize = 5;

/// The record with the noise that its pixels show together in place of each one's own.
pub fn with_expected_noise(record: &SpectrumRecord) -> SpectrumRecord {
    let net: Vec<f64> = record
        .pixels
        .iter()
        .map(|pixel| (pixel.counts - pixel.dark_counts).max(0.0))
        .collect();
    let of = |u: fn(&Pixel) -> f64| -> Vec<f64> { record.pixels.iter().map(|pixel| u(pixel).powi(2)).collect() };
    let (light, dark) = (of(|pixel| pixel.u_counts), of(|pixel| pixel.u_dark_counts));
    let used: Vec<bool> = record.pixels.iter().map(|pixel| !pixel.saturated).collect();
    let [read, per_count] = law(&net, &light, &used);
    let dark = dark.iter().sum::<f64>() / dark.len().max(1) as f64;
    let mut record = record.clone();
    for (pixel, net) in record.pixels.iter_mut().zip(&net) {
        pixel.u_counts = (read + per_count * net).sqrt();
        pixel.u_dark_counts = dark.sqrt();
    }
    record
}

/// a and b of variance = a + b·x, neither below zero, weighted by the scatter of a variance: itself.
fn law(x: &[f64], variance: &[f64], used: &[bool]) -> [f64; 2] {
    let points: Vec<(f64, f64)> = x
        .iter()
        .zip(variance)
        .zip(used)
        .filter(|(_, used)| **used)
        .map(|((x, variance), _)| (*x, *variance))
        .collect();
    let mean = points.iter().map(|(_, variance)| variance).sum::<f64>() / points.len().max(1) as f64;
    let mut law = [mean, 0.0];
    for _ in 0..REPEATED {
        let (mut s, mut sx, mut sxx, mut sy, mut sxy) = (0.0, 0.0, 0.0, 0.0, 0.0);
        for (x, variance) in &points {
            let expected = law[0] + law[1] * x;
            if expected <= 0.0 {
                continue;
            }
            let weight = expected.powi(-2);
            s += weight;
            sx += weight * x;
            sxx += weight * x * x;
            sy += weight * variance;
            sxy += weight * x * variance;
        }
        let determinant = s * sxx - sx * sx;
        if determinant <= 1e-12 * s * sxx {
            break;
        }
        let (read, per_count) = ((sxx * sy - sx * sxy) / determinant, (s * sxy - sx * sy) / determinant);
        law = if per_count < 0.0 {
            [sy / s, 0.0]
        } else if read < 0.0 {
            [0.0, sxy / sxx]
        } else {
            [read, per_count]
        };
    }
    law
}

#[cfg(test)]
mod tests {
    use super::law;

    #[test]
    fn read_noise_and_photons_come_out_of_the_scatter_of_a_few_scans() {
        // What a few scans make of a variance, 1 in the mean.
        const SCATTER: [f64; 5] = [0.4, 1.6, 1.0, 0.7, 1.3];
        let (read, per_count) = (40.0, 0.02);
        let x: Vec<f64> = (0..2000).map(|pixel| f64::from(pixel) * 25.0).collect();
        let seen = x.iter().zip(SCATTER.iter().cycle());
        let variance: Vec<f64> = seen.map(|(x, scatter)| (read + per_count * x) * scatter).collect();
        let [a, b] = law(&x, &variance, &vec![true; x.len()]);
        assert!(
            (a / read - 1.0).abs() < 0.02 && (b / per_count - 1.0).abs() < 0.005,
            "{a} {b}"
        );
        // Light that hardly changes shows the sum alone, dark pixels the first part alone.
        let [a, b] = law(&vec![0.0; 500], &vec![9.0; 500], &vec![true; 500]);
        assert!((a - 9.0).abs() < 1e-9 && b == 0.0, "{a} {b}");
    }
}
