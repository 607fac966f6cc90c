//! Uncertainty of what is summed from many readings: independent parts add in squares, common parts in full.

use std::collections::HashMap;

use isolux_units::json::nan_if_null;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::grid::{Grid, is_pole};
use crate::quantity::Quantity;

/// Relative and absolute standard uncertainties (k = 1) that all readings share.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize, JsonSchema)]
pub struct Common {
    /// What was subtracted from every reading (offset, ambient, stray): its scatter, in candela.
    pub dark_noise_cd: f64,
    /// And its rounding, in candela.
    pub dark_digit_cd: f64,
    /// The meter's offset where it was not subtracted, from its bound, in candela.
    pub offset_cd: f64,
    /// Ambient light likewise.
    pub ambient_cd: f64,
    /// Stray light made by the lamp likewise, and where its measurement leaves it open.
    pub stray_cd: f64,
    /// Distance: 2·u(d)/d.
    pub distance_rel: f64,
    /// Calibration of the lux meter.
    pub calibration_rel: f64,
    /// Drift.
    #[serde(deserialize_with = "nan_if_null")]
    #[schemars(with = "Option<f64>")]
    pub drift_rel: f64,
    /// γ.
    pub gamma_deg: f64,
    /// Spectral mismatch of the lux meter.
    #[serde(default)]
    pub spectral_mismatch_rel: f64,
    /// Its linearity.
    #[serde(default)]
    pub linearity_rel: f64,
    /// Its temperature.
    #[serde(default)]
    pub temperature_rel: f64,
    /// Its directional response.
    #[serde(default)]
    pub cosine_rel: f64,
    /// Its fatigue.
    #[serde(default)]
    pub fatigue_rel: f64,
}

/// Parts of the lux meter's own response: where there is nothing of them they are no part.
pub const OF_METER: [&str; 5] = ["spectral_mismatch", "linearity", "temperature", "cosine", "fatigue"];

impl Common {
    /// What adds to every intensity alike, cd.
    pub fn added_cd(&self) -> f64 {
        let parts = [
            self.dark_noise_cd,
            self.dark_digit_cd,
            self.offset_cd,
            self.ambient_cd,
            self.stray_cd,
        ];
        parts.iter().map(|part| part * part).sum::<f64>().sqrt()
    }

    /// What they make of a weighted sum Σ w·I: of its value, of the sum of its weights, and of its slope over γ per
    /// degree.
    fn parts(&self, value: f64, weights: f64, per_deg: f64) -> [(&'static str, f64); 14] {
        [
            ("dark_noise", weights * self.dark_noise_cd),
            ("dark_digit", weights * self.dark_digit_cd),
            ("offset", weights * self.offset_cd),
            ("ambient", weights * self.ambient_cd),
            ("stray", weights * self.stray_cd),
            ("distance", value * self.distance_rel),
            ("calibration", value * self.calibration_rel),
            ("drift", value * self.drift_rel),
            // All readings stand at a γ that is wrong by the same angle.
            ("angle", per_deg * self.gamma_deg),
            ("spectral_mismatch", value * self.spectral_mismatch_rel),
            ("linearity", value * self.linearity_rel),
            ("temperature", value * self.temperature_rel),
            ("cosine", value * self.cosine_rel),
            ("fatigue", value * self.fatigue_rel),
        ]
    }
}

/// A weighted sum Σ w·I of the intensities of a grid.
///
/// The noise of each point is independent of every other. The rounding of a point is the same as that of every other
/// point with the same display: behind the lamp, where every reading shows the same digits, all are wrong by the same
/// amount.
pub fn weighted_sum(grid: &Grid, weights: &[f64], common: &Common, unit: &'static str) -> Quantity {
    let intensity = grid.distribution.intensity_cd();
    let value: f64 = intensity.iter().zip(weights).map(|(cd, weight)| cd * weight).sum();
    let total: f64 = weights.iter().sum();
    let mut noise2 = 0.0;
    let mut alone2 = 0.0;
    let mut alike: HashMap<i64, f64> = HashMap::new();
    // Images of one reading are wrong with it: their weights add before they are squared.
    let mut on_samples = vec![0.0; grid.nodes.len()];
    for (&sample, weight) in grid.sample_of.iter().zip(weights) {
        on_samples[sample] += weight;
    }
    for (sample, weight) in grid.nodes.iter().zip(on_samples).filter(|(_, weight)| *weight != 0.0) {
        noise2 += (weight * sample.u_noise_cd.hypot(sample.u_curve_cd.unwrap_or(0.0))).powi(2);
        match sample.display {
            Some(display) => *alike.entry(display).or_default() += weight * sample.u_digit_cd,
            None => alone2 += (weight * sample.u_digit_cd).powi(2),
        }
    }
    // Sorted, so that the sum of squares has the same last bit in every process.
    let mut groups: Vec<(i64, f64)> = alike.into_iter().collect();
    groups.sort_by_key(|(display, _)| *display);
    let digit2 = alone2 + groups.iter().map(|(_, sum)| sum * sum).sum::<f64>();
    // Where light lies inside the intervals of its readings is not known better than by what smoothing moves it.
    let smoothing = grid.smoothed.as_ref().map(|(raw, _)| {
        let raw: f64 = raw
            .intensity_cd()
            .iter()
            .zip(weights)
            .map(|(cd, weight)| cd * weight)
            .sum();
        ("smoothing", value - raw)
    });
    let slopes = grid.gamma_slopes_cd_per_deg();
    let per_deg: f64 = slopes.iter().zip(weights).map(|(slope, weight)| slope * weight).sum();
    let own = [("noise", noise2.sqrt()), ("digit", digit2.sqrt())];
    let parts = own.into_iter().chain(common.parts(value, total, per_deg));
    // Bounds of what was measured are no part of it.
    let bounds = ["offset", "ambient", "stray"];
    let no_part = |name: &str| bounds.contains(&name) || OF_METER.contains(&name);
    Quantity::new(
        value,
        unit,
        parts
            .filter(|(name, part)| *part != 0.0 || !no_part(name))
            .chain(smoothing),
    )
}

/// Standard uncertainty of the intensity in every direction `[ic * ng + ig]`, cd: all that is known of it.
pub fn of_directions_cd(grid: &Grid, common: &Common) -> Vec<f64> {
    let (distribution, gammas) = (&grid.distribution, grid.distribution.gamma_deg());
    let raw = grid.as_read().intensity_cd();
    let slopes = grid.gamma_slopes_cd_per_deg();
    // All half-planes together made the one value of a pole.
    let poles: Vec<Option<f64>> = gammas
        .iter()
        .map(|gamma| {
            let weights = || grid.direction_weights(0.0, *gamma);
            is_pole(*gamma).then(|| weighted_sum(grid, &weights(), common, "cd").u_of_parts)
        })
        .collect();
    let of = |(place, value): (usize, &f64)| {
        poles[place % gammas.len()].unwrap_or_else(|| {
            let own = grid.nodes[grid.sample_of[place]].u_own_cd();
            let shared = common.parts(*value, 1.0, slopes[place]);
            let squares: f64 = shared.iter().map(|(_, part)| part * part).sum();
            (own * own + squares + (value - raw[place]).powi(2)).sqrt()
        })
    };
    distribution.intensity_cd().iter().enumerate().map(of).collect()
}

/// What the intensity of each direction is uncertain by on its own (scatter and rounding of its readings): relative,
/// and in candela, adding in squares.
///
/// The law that fits the directions' own uncertainties best, in relative terms: Σ ((a² + b²·I²)/u² − 1)² least, a² and
/// b² not negative.
pub fn noise_of_directions(grid: &Grid) -> (f64, f64) {
    let (mut aa, mut ab, mut bb, mut a1, mut b1) = (0.0, 0.0, 0.0, 0.0, 0.0);
    for sample in &grid.nodes {
        let variance = sample.u_own_cd().powi(2);
        if variance > 0.0 {
            let (a, b) = (1.0 / variance, sample.intensity_cd.powi(2) / variance);
            aa += a * a;
            ab += a * b;
            bb += b * b;
            a1 += a;
            b1 += b;
        }
    }
    let alone = |square: f64, sum: f64| if square > 0.0 { sum / square } else { 0.0 };
    let determinant = aa * bb - ab * ab;
    let (mut floor, mut slope) = (0.0, 0.0);
    if determinant > 1e-12 * aa * bb {
        (floor, slope) = ((bb * a1 - ab * b1) / determinant, (aa * b1 - ab * a1) / determinant);
    }
    if slope <= 0.0 {
        (floor, slope) = (alone(aa, a1), 0.0);
    } else if floor < 0.0 {
        (floor, slope) = (0.0, alone(bb, b1));
    }
    (slope.sqrt(), floor.sqrt())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::samples::Sample;
    use crate::testing::sample;
    use std::f64::consts::{PI, TAU};

    #[test]
    fn the_noise_of_directions_has_a_floor_and_a_share() {
        let law = |floor_cd: f64, share: f64| {
            let nodes: Vec<Sample> = (0..=35)
                .map(|i| {
                    let gamma_deg = 2.0 * f64::from(i);
                    let intensity_cd = 300.0 * gamma_deg.to_radians().cos().powi(5);
                    Sample {
                        u_noise_cd: (share * intensity_cd).hypot(0.8 * floor_cd),
                        u_digit_cd: 0.6 * floor_cd,
                        ..sample(0.0, gamma_deg, intensity_cd)
                    }
                })
                .collect();
            noise_of_directions(&Grid::new(&nodes).unwrap())
        };
        for (floor_cd, share) in [(0.02, 0.001), (0.02, 0.0), (0.0, 0.001)] {
            let (found_share, found_floor) = law(floor_cd, share);
            assert!((found_share - share).abs() < 1e-6, "{found_share}");
            assert!((found_floor - floor_cd).abs() < 2e-4 * 0.02, "{found_floor}");
        }
    }

    #[test]
    fn a_wrong_gamma_changes_the_flux_by_its_integral() {
        let lobe = |gamma_deg: f64| 300.0 * gamma_deg.to_radians().cos().max(0.0).powi(3);
        let gammas = (0..=180).map(f64::from);
        let nodes: Vec<Sample> = gammas.map(|gamma| sample(0.0, gamma, lobe(gamma))).collect();
        let grid = Grid::new(&nodes).unwrap();
        let common = Common {
            gamma_deg: 0.1,
            ..Common::default()
        };
        let flux = weighted_sum(&grid, &grid.flux_weights_sr(), &common, "lm");
        // Φ(δ) = 2π·I₀ ∫ cosⁿ(γ + δ)·sin γ dγ, so that dΦ/dδ = −2π·I₀ ∫ cosⁿ⁺¹ γ dγ = −2π·I₀·3π/16 for n = 3.
        let exact = TAU * 300.0 * 3.0 * PI / 16.0 * 0.1_f64.to_radians();
        assert!((flux.parts["angle"] / exact - 1.0).abs() < 1e-3, "{flux:?} {exact}");
    }
}
