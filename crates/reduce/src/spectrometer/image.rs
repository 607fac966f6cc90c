//! The image of a line on the pixels: where it lies and how wide it is.

use nalgebra::{DMatrix, DVector};

/// A pixel near a line.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Sample {
    /// Wavelength that the instrument states.
    pub stated_nm: f64,
    /// Width of the pixel.
    pub pixel_nm: f64,
    /// Linear counts a second.
    pub per_s: f64,
    /// Their standard uncertainty.
    pub u_per_s: f64,
}

/// What a slit makes of a line.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Shape {
    /// The image of a slit on a slit.
    Triangle,
    /// What aberrations and diffraction make of it.
    Gaussian,
}

/// A line and its image.
pub(super) struct Found {
    pub wavelength_nm: f64,
    pub image: Image,
    /// Of noise, of what is beside it, and of the difference between both shapes.
    pub u_nm: f64,
    /// What the shape leaves open of its width.
    pub u_fwhm_nm: f64,
}

/// A line found.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Image {
    /// Where it lies on the stated scale.
    pub centre_nm: f64,
    /// Standard uncertainty of that, from noise and from what the shape leaves over.
    pub u_nm: f64,
    /// Full width at half maximum of the triangle with the variance of the image.
    pub fwhm_nm: f64,
    /// Standard uncertainty of that, likewise.
    pub u_fwhm_nm: f64,
    /// Σ of the squared differences over their variances.
    pub chi2: f64,
    /// Its highest pixel above the background, over that pixel's uncertainty.
    pub signal_to_noise: f64,
}

/// No image has exactly the shape that it is taken for: this share of its peak is no noise of it.
const SHAPE_REL: f64 = 0.005;
/// A fit that needs more steps finds nothing.
const MOST_STEPS: usize = 40;

impl Shape {
    /// Mean over a pixel of an image of unit area and variance `fwhm²/6`, `off_nm` from its centre, per nm.
    fn mean(self, off_nm: f64, pixel_nm: f64, fwhm_nm: f64) -> f64 {
        let below = |edge_nm: f64| self.share_below(edge_nm, fwhm_nm);
        (below(off_nm + 0.5 * pixel_nm) - below(off_nm - 0.5 * pixel_nm)) / pixel_nm
    }

    fn share_below(self, edge_nm: f64, fwhm_nm: f64) -> f64 {
        match self {
            Self::Triangle => {
                let x = (edge_nm / fwhm_nm).clamp(-1.0, 1.0);
                if x < 0.0 {
                    0.5 * (1.0 + x).powi(2)
                } else {
                    1.0 - 0.5 * (1.0 - x).powi(2)
                }
            }
            Self::Gaussian => {
                // The error function by Abramowitz and Stegun 7.1.26, good to 1.5·10⁻⁷.
                let z = edge_nm / (fwhm_nm / 6.0_f64.sqrt()) / 2.0_f64.sqrt();
                let t = 1.0 / (1.0 + 0.327_591_1 * z.abs());
                let series = [
                    1.061_405_429,
                    -1.453_152_027,
                    1.421_413_741,
                    -0.284_496_736,
                    0.254_829_592,
                ];
                let erf = 1.0 - series.iter().fold(0.0, |sum, c| (sum + c) * t) * (-z * z).exp();
                0.5 * (1.0 + erf.copysign(z))
            }
        }
    }
}

/// The image of a line near `start_nm` in `samples`. `beside` are the lines of the lamp that lie near it, by their
/// distance from it and their strength against it: they are images of the same shape.
///
/// None where the fit does not come to rest within the samples.
pub fn fit(
    samples: &[Sample],
    beside: &[(f64, f64)],
    start_nm: f64,
    start_fwhm_nm: f64,
    shape: Shape,
) -> Option<Image> {
    let highest = samples.iter().max_by(|a, b| a.per_s.total_cmp(&b.per_s))?;
    let lowest = samples.iter().map(|sample| sample.per_s).fold(f64::INFINITY, f64::min);
    let peak = highest.per_s - lowest;
    let sigma = |sample: &Sample| sample.u_per_s.hypot(SHAPE_REL * peak).max(f64::MIN_POSITIVE);
    // Centre, width, light, background.
    let model = |of: &[f64; 4], sample: &Sample| {
        let image = |off_nm: f64| shape.mean(sample.stated_nm - of[0] - off_nm, sample.pixel_nm, of[1]);
        let others: f64 = beside.iter().map(|(off_nm, strength)| strength * image(*off_nm)).sum();
        of[2] * (image(0.0) + others) + of[3]
    };
    let chi2 = |of: &[f64; 4]| -> f64 {
        let terms = samples.iter();
        terms
            .map(|sample| ((sample.per_s - model(of, sample)) / sigma(sample)).powi(2))
            .sum()
    };
    let steps = |of: &[f64; 4]| [1e-3 * of[1], 1e-3 * of[1], 1e-3 * peak * of[1], 1e-3 * peak];
    let mut of = [start_nm, start_fwhm_nm, peak * start_fwhm_nm, lowest];
    let mut here = chi2(&of);
    let mut damping = 1e-3;
    let mut curvature = DMatrix::zeros(4, 4);
    for step in 0..=MOST_STEPS {
        let mut jacobian = DMatrix::zeros(samples.len(), 4);
        for (column, step) in steps(&of).into_iter().enumerate() {
            let mut moved = of;
            moved[column] += step;
            for (row, sample) in samples.iter().enumerate() {
                jacobian[(row, column)] = (model(&moved, sample) - model(&of, sample)) / step / sigma(sample);
            }
        }
        let left = samples
            .iter()
            .map(|sample| (sample.per_s - model(&of, sample)) / sigma(sample));
        let left = DVector::from_iterator(samples.len(), left);
        curvature = jacobian.transpose() * &jacobian;
        let gradient = jacobian.transpose() * left;
        let mut damped = curvature.clone();
        for place in 0..4 {
            damped[(place, place)] *= 1.0 + damping;
        }
        let change = damped.lu().solve(&gradient)?;
        let next: [f64; 4] = std::array::from_fn(|place| of[place] + change[place]);
        let there = if next[1] > 0.0 { chi2(&next) } else { f64::INFINITY };
        if there <= here {
            // A whole standard uncertainty changes it by 1.
            let still = here - there < 1e-4;
            (of, here, damping) = (next, there, damping * 0.1);
            if still {
                break;
            }
        } else {
            damping *= 10.0;
            if damping > 1e9 {
                break;
            }
        }
        if step == MOST_STEPS {
            return None;
        }
    }
    let covariance = curvature.try_inverse()?;
    let (first, last) = (samples.first()?, samples.last()?);
    let within = (first.stated_nm..=last.stated_nm).contains(&of[0]) && of[2] > 0.0 && here.is_finite();
    let pixel_nm = highest.pixel_nm;
    within.then(|| Image {
        centre_nm: of[0],
        u_nm: covariance[(0, 0)].max(0.0).sqrt(),
        // The pixel widens the image of a line, and every other light as well.
        fwhm_nm: (of[1] * of[1] + 0.5 * pixel_nm * pixel_nm).sqrt(),
        u_fwhm_nm: covariance[(1, 1)].max(0.0).sqrt(),
        chi2: here,
        signal_to_noise: (highest.per_s - of[3]) / highest.u_per_s.max(f64::MIN_POSITIVE),
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Sums over a fine grid, without the formulas above.
    fn image(shape: Shape, centre_nm: f64, fwhm_nm: f64) -> Vec<Sample> {
        let density = |off_nm: f64| match shape {
            Shape::Triangle => (1.0 - (off_nm / fwhm_nm).abs()).max(0.0) / fwhm_nm,
            Shape::Gaussian => {
                let sigma = fwhm_nm / 6.0_f64.sqrt();
                (-0.5 * (off_nm / sigma).powi(2)).exp() / sigma / std::f64::consts::TAU.sqrt()
            }
        };
        (0..20)
            .map(|pixel| 542.6 + 0.37 * f64::from(pixel))
            .map(|stated_nm| {
                let parts = (0..100).map(|k| stated_nm + 0.37 * ((f64::from(k) + 0.5) / 100.0 - 0.5));
                let mean = parts.map(|nm| density(nm - centre_nm)).sum::<f64>() / 100.0;
                Sample {
                    stated_nm,
                    pixel_nm: 0.37,
                    per_s: 1e5 * mean + 30.0,
                    u_per_s: 5.0,
                }
            })
            .collect()
    }

    #[test]
    fn centre_and_width_of_either_shape_are_found() {
        for (shape, other) in [(Shape::Triangle, Shape::Gaussian), (Shape::Gaussian, Shape::Triangle)] {
            let samples = image(shape, 545.81, 2.5);
            let found = fit(&samples, &[], 546.1, 2.0, shape).unwrap();
            assert!((found.centre_nm - 545.81).abs() < 2e-3, "{shape:?} {found:?}");
            let expected: f64 = (2.5f64.powi(2) + 0.5 * 0.37f64.powi(2)).sqrt();
            assert!((found.fwhm_nm - expected).abs() < 0.01, "{shape:?} {found:?}");
            let wrong = fit(&samples, &[], 546.1, 2.0, other).unwrap();
            assert!(wrong.chi2 > 3.0 * found.chi2, "{found:?} {wrong:?}");
            // A wrong shape does not move a symmetric image.
            assert!((wrong.centre_nm - 545.81).abs() < 3.0 * wrong.u_nm, "{wrong:?}");
        }
    }

    #[test]
    fn a_line_is_found_wherever_it_lies_on_its_pixels() {
        for shape in [Shape::Triangle, Shape::Gaussian] {
            for step in 0..40 {
                let centre_nm = 545.6 + 0.013 * f64::from(step);
                let samples = image(shape, centre_nm, 2.0);
                for tried in [Shape::Triangle, Shape::Gaussian] {
                    let found = fit(&samples, &[], centre_nm + 0.4, 2.3, tried);
                    let found = found.unwrap_or_else(|| panic!("{shape:?} as {tried:?} at {centre_nm}"));
                    assert!((found.centre_nm - centre_nm).abs() < 0.01, "{centre_nm} {found:?}");
                }
            }
        }
    }

    #[test]
    fn a_weak_line_beside_a_strong_one_is_taken_into_account() {
        let both: Vec<Sample> = image(Shape::Triangle, 545.81, 2.5)
            .into_iter()
            .zip(image(Shape::Triangle, 544.81, 2.5))
            .map(|(strong, weak)| Sample {
                per_s: strong.per_s + 0.05 * weak.per_s,
                ..strong
            })
            .collect();
        let with = fit(&both, &[(-1.0, 0.05)], 546.0, 2.0, Shape::Triangle).unwrap();
        let without = fit(&both, &[], 546.0, 2.0, Shape::Triangle).unwrap();
        assert!((with.centre_nm - 545.81).abs() < 2e-3, "{with:?}");
        assert!(without.centre_nm < 545.78, "{without:?}");
    }
}
