//! What a slit takes out of a spectrum: light as an instrument of no bandpass would see it.
//!
//! A triangular bandpass of the width b makes of S the spectrum M = S + b²/12·S″ + b⁴/360·S⁗ + …, so that
//! S = M − b²/12·M″ + b⁴/240·M⁗ − … (Woolliams, Baribeau, Bialek and Cox, Metrologia 48, 164, 2011). With differences
//! over steps of b this is, over three points, what Stearns and Stearns give (Color Res. Appl. 13, 257, 1988), and over
//! five a term more: derivatives of sixth order are left.

/// Weights at 0 and ± b of the formula over three points.
const THREE: [f64; 2] = [1.0 + 2.0 / 12.0, -1.0 / 12.0];
/// Weights at 0, ± b and ± 2b of the formula over five: M″ to fourth order, and M⁗.
const FIVE: [f64; 3] = [1.0 + 1.0 / 6.0 + 6.0 / 90.0, -1.0 / 12.0 - 4.0 / 90.0, 1.0 / 90.0];

/// For every pixel, which pixels its value without the bandpass is made of, and by which weights; linear between
/// pixels. Nearer to an end than `fwhm_nm` nothing is corrected.
pub fn weights(wavelength_nm: &[f64], fwhm_nm: f64) -> Vec<Vec<(usize, f64)>> {
    let count = wavelength_nm.len();
    let ends = wavelength_nm.first().zip(wavelength_nm.last());
    (0..count)
        .map(|pixel| {
            let here = wavelength_nm[pixel];
            let reach = ends.map_or(0.0, |(first, last)| (here - first).min(last - here));
            // A step that ends on the last pixel is within.
            let reaches = |steps: f64| steps * fwhm_nm <= reach * (1.0 + 1e-9);
            let rule: &[f64] = if reaches(2.0) {
                &FIVE
            } else if reaches(1.0) {
                &THREE
            } else {
                &[1.0]
            };
            let mut weights: Vec<(usize, f64)> = Vec::new();
            let mut add = |pixel: usize, weight: f64| match weights.iter_mut().find(|(known, _)| *known == pixel) {
                Some((_, sum)) => *sum += weight,
                None => weights.push((pixel, weight)),
            };
            add(pixel, rule[0]);
            for (step, weight) in rule.iter().enumerate().skip(1) {
                for side in [-1.0, 1.0] {
                    let at = here + side * step as f64 * fwhm_nm;
                    let above = wavelength_nm.partition_point(|nm| *nm < at).clamp(1, count - 1);
                    let (low, high) = (wavelength_nm[above - 1], wavelength_nm[above]);
                    let share = ((at - low) / (high - low)).clamp(0.0, 1.0);
                    add(above - 1, weight * (1.0 - share));
                    add(above, weight * share);
                }
            }
            weights
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::weights;

    fn applied(nm: &[f64], value: &[f64], fwhm_nm: f64) -> Vec<f64> {
        let of = |weights: Vec<(usize, f64)>| weights.iter().map(|(pixel, weight)| weight * value[*pixel]).sum();
        weights(nm, fwhm_nm).into_iter().map(of).collect()
    }

    /// What stands at 5 nm behind a triangle of 5 nm, and what `bandpass_correction_Stearns1988` of colour-science
    /// 0.4.7 makes of it; it goes from left to right and takes the value on the left as corrected already.
    const STEARNS: [(f64, f64, f64); 5] = [
        (440.0, 0.544_786, 0.537_250),
        (450.0, 1.074_431, 1.082_678),
        (455.0, 1.261_055, 1.277_751),
        (460.0, 1.238_275, 1.253_061),
        (470.0, 0.735_420, 0.730_347),
    ];

    fn truth(nm: f64) -> f64 {
        (-0.5 * ((nm - 457.0) / 10.0).powi(2)).exp() + 0.3
    }

    /// The mean of the truth over a triangle, by a sum.
    fn seen(nm: f64, fwhm_nm: f64) -> f64 {
        let parts = (0..2000).map(|k| (f64::from(k) + 0.5) / 1000.0 - 1.0);
        let (sum, weights) = parts.fold((0.0, 0.0), |(sum, weights), t| {
            let weight = 1.0 - t.abs();
            (sum + weight * truth(nm + fwhm_nm * t), weights + weight)
        });
        sum / weights
    }

    #[test]
    fn it_is_what_colour_science_makes_of_it_and_nearer_to_the_truth() {
        for (nm, measured, stearns) in STEARNS {
            assert!((seen(nm, 5.0) - measured).abs() < 1e-6);
            // Five points reach only three where there are no more.
            let at: Vec<f64> = (-1..=1).map(|step| nm + 5.0 * f64::from(step)).collect();
            let value: Vec<f64> = at.iter().map(|nm| seen(*nm, 5.0)).collect();
            let three = applied(&at, &value, 5.0)[1];
            // A twelfth of the correction is what the corrected neighbour is to it.
            assert!(
                (three - stearns).abs() < 0.12 * (stearns - measured).abs(),
                "{nm}: {three} {stearns}"
            );
            let at: Vec<f64> = (-2..=2).map(|step| nm + 5.0 * f64::from(step)).collect();
            let value: Vec<f64> = at.iter().map(|nm| seen(*nm, 5.0)).collect();
            let five = applied(&at, &value, 5.0)[2];
            let off = |value: f64| (value - truth(nm)).abs();
            assert!(
                off(five) < 0.4 * off(three) && off(three) < 0.2 * off(measured),
                "{nm}: {five} {three}"
            );
        }
    }

    #[test]
    fn pixels_finer_than_the_bandpass_are_corrected_as_well_and_light_is_kept() {
        let at: Vec<f64> = (0..400).map(|pixel| 390.0 + 0.37 * f64::from(pixel)).collect();
        let value: Vec<f64> = at.iter().map(|nm| seen(*nm, 2.5)).collect();
        let corrected = applied(&at, &value, 2.5);
        for (place, nm) in at.iter().enumerate() {
            assert!((weights(&at, 2.5)[place].iter().map(|(_, weight)| weight).sum::<f64>() - 1.0).abs() < 1e-12);
            if (410.0..500.0).contains(nm) {
                let (before, after) = (value[place] - truth(*nm), corrected[place] - truth(*nm));
                assert!(after.abs() < 0.02 * before.abs() + 1e-4, "{nm}: {before} {after}");
            }
        }
    }
}
