//! Independent and common parts of an uncertainty, and how a weighted sum of points combines them.

use serde::Serialize;

/// One cause that moves many points together: its effect on each point, in candela, for one standard uncertainty of it.
#[derive(Debug, Clone, PartialEq)]
pub struct CommonPart {
    /// Its name (`dark`, `digit`, `drift`, `distance`, `calibration`).
    pub name: &'static str,
    /// Signed effect on each point, in cd.
    pub effect_cd: Vec<f64>,
}

/// A result with its standard uncertainty (k = 1) and what it is made of.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Combined {
    /// The result.
    pub value: f64,
    /// Its combined standard uncertainty.
    pub u: f64,
    /// The parts, whose squares add up to u².
    pub parts: Vec<Part>,
}

/// One part of a combined uncertainty.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Part {
    /// `independent` (noise and rounding of each point by itself) or the name of a common part.
    pub name: &'static str,
    /// Its contribution, in the result's unit.
    pub u: f64,
}

impl Combined {
    /// The contribution of one part; 0 when there is none of this name.
    pub fn part(&self, name: &str) -> f64 {
        self.parts
            .iter()
            .find(|part| part.name == name)
            .map_or(0.0, |part| part.u)
    }
}

/// Σ wᵢ·xᵢ with its uncertainty: independent parts add in squares, each common part acts on all points at once. Common parts
/// of the same name (two parameters of one drift) are independent of each other and are shown as one.
pub(crate) fn weighted_sum(weights: &[f64], values: &[f64], independent: &[f64], common: &[CommonPart]) -> Combined {
    let value = weights.iter().zip(values).map(|(w, x)| w * x).sum();
    let alone = weights
        .iter()
        .zip(independent)
        .map(|(w, u)| (w * u).powi(2))
        .sum::<f64>()
        .sqrt();
    let mut parts = vec![Part {
        name: "independent",
        u: alone,
    }];
    for part in common {
        let together: f64 = weights.iter().zip(&part.effect_cd).map(|(w, effect)| w * effect).sum();
        match parts.iter_mut().find(|known| known.name == part.name) {
            Some(known) => known.u = known.u.hypot(together),
            None => parts.push(Part {
                name: part.name,
                u: together.abs(),
            }),
        }
    }
    let u = parts.iter().map(|part| part.u * part.u).sum::<f64>().sqrt();
    Combined { value, u, parts }
}

/// Noise and rounding of a mean of `n` readings of one quantity.
///
/// Rounding to a digit a is rectangular, a/√12 (GUM 4.3.7). Repeats reduce the noise by √n; they reduce the rounding only
/// where the noise is large enough to dither it, about half a digit: below that every repeat is rounded alike.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct MeanOfRepeats {
    /// Standard uncertainty from noise.
    pub noise: f64,
    /// Standard uncertainty from rounding.
    pub rounding: f64,
    /// Whether rounding is shared by readings of the same level, because the noise does not dither it.
    pub stuck: bool,
}

pub(crate) fn mean_of_repeats(noise_of_one: f64, digit: f64, n: usize) -> MeanOfRepeats {
    let root = (n.max(1) as f64).sqrt();
    let stuck = noise_of_one < 0.5 * digit;
    let rounding = digit / 12f64.sqrt();
    MeanOfRepeats {
        noise: noise_of_one / root,
        rounding: if stuck { rounding } else { rounding / root },
        stuck,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn common_parts_add_before_they_are_squared() {
        let common = [
            CommonPart {
                name: "dark",
                effect_cd: vec![0.1; 4],
            },
            CommonPart {
                name: "drift",
                effect_cd: vec![0.1, -0.1, 0.1, -0.1],
            },
        ];
        let sum = weighted_sum(&[1.0; 4], &[5.0; 4], &[0.1; 4], &common);
        assert_eq!(sum.value, 20.0);
        assert!((sum.part("independent") - 0.2).abs() < 1e-15, "√4·0.1");
        assert!((sum.part("dark") - 0.4).abs() < 1e-15, "4·0.1");
        assert!(sum.part("drift") < 1e-15, "what pulls both ways cancels");
        assert!((sum.u - 0.2f64.hypot(0.4)).abs() < 1e-15);
    }

    #[test]
    fn repeats_reduce_rounding_only_where_noise_dithers_it() {
        let quiet = mean_of_repeats(0.001, 0.01, 100);
        assert!(quiet.stuck && (quiet.rounding - 0.01 / 12f64.sqrt()).abs() < 1e-15 && quiet.noise == 0.0001);
        let noisy = mean_of_repeats(0.02, 0.01, 100);
        assert!(!noisy.stuck && (noisy.rounding - 0.001 / 12f64.sqrt()).abs() < 1e-15);
    }
}
