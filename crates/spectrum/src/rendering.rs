//! Colour rendering indices R1–R15 and Ra (CIE 13.3; sample 15 of the Japanese complexion after JIS Z 8726).

use std::sync::OnceLock;

use crate::cct::{self, Cct};
use crate::tables::TEST_COLOURS;
use crate::{Chromaticity, Spectrum, Tristimulus, illuminant};

/// Colour rendering indices.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Rendering {
    /// General index Ra, mean of R1–R8.
    pub ra: f64,
    /// Special indices R1–R15.
    pub r: [f64; 15],
}

/// Indices of a source against the Planckian radiator (below 5000 K) or the daylight of its own colour temperature;
/// none where no such reference exists (no light, no colour temperature, or above 25 000 K).
pub fn rendering(source: &Spectrum) -> Option<Rendering> {
    let test = source.per_nm();
    let nearest = cct::nearest_planckian(Tristimulus::of_1_nm(&test).chromaticity()?)?;
    rendering_of(&test, nearest)
}

/// The same of the values at 360, 361, … 830 nm of a source whose nearest Planckian radiator is known.
pub fn rendering_of(test: &[f64; 471], nearest: Cct) -> Option<Rendering> {
    let t = nearest.meaningful()?.cct_k;
    let reference = if t < 5000.0 {
        illuminant::planck(t)
    } else {
        illuminant::daylight(t)?
    };
    let [white, reference_white] = [test, &reference].map(Tristimulus::of_1_nm);
    let adapt_to = reference_white.chromaticity()?;
    let r = samples()
        .iter()
        .map(|sample| {
            let a = uvw(test, white, sample, Some(adapt_to))?;
            let b = uvw(&reference, reference_white, sample, None)?;
            let distance = a.iter().zip(&b).map(|(a, b)| (a - b).powi(2)).sum::<f64>().sqrt();
            Some(100.0 - 4.6 * distance)
        })
        .collect::<Option<Vec<f64>>>()?;
    Some(Rendering {
        ra: r[..8].iter().sum::<f64>() / 8.0,
        r: r.try_into().ok()?,
    })
}

/// U*V*W* of 1964 of a sample under a light that is `white`, adapted (von Kries in c, d; CIE 13.3, 5.7) to another
/// white if given.
fn uvw(
    light: &[f64; 471],
    white: Tristimulus,
    sample: &[f64; 471],
    adapt_to: Option<Chromaticity>,
) -> Option<[f64; 3]> {
    let reflected: [f64; 471] = std::array::from_fn(|i| light[i] * sample[i]);
    let seen = Tristimulus::of_1_nm(&reflected).scaled(100.0 / white.y);
    let (u_white, v_white) = white.chromaticity()?.uv_1960();
    let (mut u, mut v) = seen.chromaticity()?.uv_1960();
    let (mut u_zero, mut v_zero) = (u_white, v_white);
    if let Some(target) = adapt_to {
        (u_zero, v_zero) = target.uv_1960();
        let c = |u: f64, v: f64| (4.0 - u - 10.0 * v) / v;
        let d = |u: f64, v: f64| (1.708 * v + 0.404 - 1.481 * u) / v;
        let cc = c(u_zero, v_zero) / c(u_white, v_white) * c(u, v);
        let dd = d(u_zero, v_zero) / d(u_white, v_white) * d(u, v);
        let under = 16.518 + 1.481 * cc - dd;
        (u, v) = ((10.872 + 0.404 * cc - 4.0 * dd) / under, 5.520 / under);
    }
    let w = 25.0 * seen.y.cbrt() - 17.0;
    let out = [13.0 * w * (u - u_zero), 13.0 * w * (v - v_zero), w];
    out.iter().all(|v| v.is_finite()).then_some(out)
}

/// The samples at 1 nm.
fn samples() -> &'static [[f64; 471]] {
    static SAMPLES: OnceLock<Vec<[f64; 471]>> = OnceLock::new();
    SAMPLES.get_or_init(|| {
        TEST_COLOURS
            .iter()
            .map(|table| {
                std::array::from_fn(|i| {
                    let (k, part) = (i / 5, (i % 5) as f64 / 5.0);
                    table[k] + part * (table.get(k + 1).unwrap_or(&table[k]) - table[k])
                })
            })
            .collect()
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_reference_renders_like_itself() {
        for light in [illuminant::planck(2700.0), illuminant::daylight(6500.0).unwrap()] {
            let r = rendering(&Spectrum::from_1_nm(&light).unwrap()).unwrap();
            assert!(r.r.iter().all(|r| *r > 99.5) && r.ra > 99.8, "{r:?}");
        }
    }
}
