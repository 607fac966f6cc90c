//! Chromaticity of one direction with its noise, and the numbers that follow from it alone.

use isolux_spectrum::cct::{Cct, nearest_planckian};
use isolux_spectrum::{Chromaticity, Spectrum, cie};

/// x, y, u′, v′, CCT in K, Duv; the last two none where the light has none.
pub type Numbers = [Option<f64>; COUNT];

/// How many numbers.
pub const COUNT: usize = 6;

/// Step of x and y for slopes.
const STEP: f64 = 1e-5;

/// A chromaticity whose x and y scatter together.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Point {
    /// Where it is.
    pub at: Chromaticity,
    /// Variance of x, covariance, variance of y.
    pub covariance: [f64; 3],
}

impl Point {
    /// Of a spectrum whose values have these variances; none without light.
    ///
    /// ∂x/∂S(λ) = (x̄ − x·(x̄ + ȳ + z̄))/(X + Y + Z), y likewise.
    pub fn of(spectrum: &Spectrum, variance: &[f64]) -> Option<Self> {
        let sum = spectrum.tristimulus();
        let at = sum.chromaticity()?;
        let whole = sum.x + sum.y + sum.z;
        let mut covariance = [0.0; 3];
        for (nm, variance) in spectrum.wavelength_nm().iter().zip(variance) {
            let place = nm - cie::FIRST_NM as f64;
            if !(0.0..cie::V_LAMBDA.len() as f64).contains(&place) {
                continue;
            }
            let place = place as usize;
            let (x, y, z) = (cie::X_BAR[place], cie::V_LAMBDA[place], cie::Z_BAR[place]);
            let of_x = (x - at.x * (x + y + z)) / whole;
            let of_y = (y - at.y * (x + y + z)) / whole;
            covariance[0] += of_x * of_x * variance;
            covariance[1] += of_x * of_y * variance;
            covariance[2] += of_y * of_y * variance;
        }
        Some(Self { at, covariance })
    }

    /// The mean of points with weights that add up to 1.
    pub fn mean<'a>(parts: impl Iterator<Item = (&'a Self, f64)>) -> Self {
        let mut mean = Self {
            at: Chromaticity { x: 0.0, y: 0.0 },
            covariance: [0.0; 3],
        };
        for (point, weight) in parts {
            mean.at.x += weight * point.at.x;
            mean.at.y += weight * point.at.y;
            for (sum, part) in mean.covariance.iter_mut().zip(point.covariance) {
                *sum += weight * weight * part;
            }
        }
        mean
    }

    /// Standard deviation that noise gives each of the numbers.
    pub fn noise(&self) -> [f64; COUNT] {
        let slopes = self.slopes();
        let [xx, xy, yy] = self.covariance;
        slopes.map(|[x, y]| (x * x * xx + 2.0 * x * y * xy + y * y * yy).max(0.0).sqrt())
    }

    /// Covariance of u′ and v′: variance of u′, covariance, variance of v′.
    pub fn covariance_uv(&self) -> [f64; 3] {
        let slopes = self.slopes();
        let [xx, xy, yy] = self.covariance;
        let product = |a: [f64; 2], b: [f64; 2]| a[0] * b[0] * xx + (a[0] * b[1] + a[1] * b[0]) * xy + a[1] * b[1] * yy;
        let [u, v] = [slopes[2], slopes[3]];
        [product(u, u), product(u, v), product(v, v)]
    }

    /// Change of each number with x and with y; zero where there is none.
    fn slopes(&self) -> [[f64; 2]; COUNT] {
        let along = |dx: f64, dy: f64| {
            let at = |sign: f64| Chromaticity {
                x: self.at.x + sign * dx,
                y: self.at.y + sign * dy,
            };
            let (plus, minus) = (numbers(at(1.0)), numbers(at(-1.0)));
            changes(&minus, &plus).map(|change| change / (2.0 * STEP))
        };
        let (over_x, over_y) = (along(STEP, 0.0), along(0.0, STEP));
        std::array::from_fn(|number| [over_x[number], over_y[number]])
    }
}

/// The numbers of a chromaticity.
pub fn numbers(at: Chromaticity) -> Numbers {
    let (u_prime, v_prime) = at.uv_1976();
    let nearest = nearest_planckian(at);
    [
        Some(at.x),
        Some(at.y),
        Some(u_prime),
        Some(v_prime),
        nearest.and_then(Cct::meaningful).map(|cct| cct.cct_k),
        nearest.map(|nearest| nearest.duv),
    ]
}

/// By what each number of `changed` differs; zero where one of them is none.
pub fn changes(centre: &Numbers, changed: &Numbers) -> [f64; COUNT] {
    std::array::from_fn(|number| match (centre[number], changed[number]) {
        (Some(centre), Some(changed)) => changed - centre,
        _ => 0.0,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The covariance against spectra with noise drawn, 4000 of them.
    #[test]
    fn noise_scatters_as_it_is_said_to() {
        let nm: Vec<f64> = (380..=780).map(f64::from).collect();
        let law = |nm: f64| 0.01 * (-((nm - 560.0) / 80.0).powi(2)).exp() + 0.003;
        let u = |nm: f64| 2e-5 + 2e-3 * law(nm);
        let variance: Vec<f64> = nm.iter().map(|nm| u(*nm).powi(2)).collect();
        let clean = Spectrum::new(nm.clone(), nm.iter().map(|nm| law(*nm)).collect()).unwrap();
        let point = Point::of(&clean, &variance).unwrap();
        let mut draws = crate::normal::Normal::new(7);
        let (mut sums, mut squares) = ([0.0; COUNT], [0.0; COUNT]);
        let count = 4000;
        for _ in 0..count {
            let value = nm.iter().map(|nm| law(*nm) + u(*nm) * draws.next()).collect();
            let noisy = Spectrum::new(nm.clone(), value).unwrap().chromaticity().unwrap();
            let off = changes(&numbers(point.at), &numbers(noisy));
            for number in 0..COUNT {
                sums[number] += off[number];
                squares[number] += off[number].powi(2);
            }
        }
        for (number, expected) in point.noise().into_iter().enumerate() {
            let got = (squares[number] / f64::from(count)).sqrt();
            assert!((got / expected - 1.0).abs() < 0.04, "{number}: {got} {expected}");
        }
        let [uu, _, vv] = point.covariance_uv();
        assert!(
            (uu.sqrt() / point.noise()[2] - 1.0).abs() < 1e-12 && (vv.sqrt() / point.noise()[3] - 1.0).abs() < 1e-12
        );
        // Two alike have half the variance.
        let mean = Point::mean([(&point, 0.5), (&point, 0.5)].into_iter());
        assert!((mean.noise()[0] / point.noise()[0] - 0.5f64.sqrt()).abs() < 1e-9);
    }
}
