//! The closing half-plane at C 360°, a check of the one at C 0°.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::samples::Sample;

/// Closing half-plane against the first.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Closing {
    /// Directions compared.
    pub directions: usize,
    /// Root mean square of the differences, in candela.
    pub rms_cd: f64,
    /// Largest difference (closing − first), in candela.
    pub max_cd: f64,
    /// At this γ.
    pub max_gamma_deg: f64,
    /// Mean of (difference ÷ its standard uncertainty)²: about 1 where nothing changed in between.
    pub chi2_per_direction: f64,
}

impl Closing {
    /// The comparison of the closing samples with those of C 0°; none where the plan has no closing half-plane.
    pub fn of(samples: &[Sample]) -> Option<Self> {
        let pairs: Vec<(&Sample, &Sample)> = samples
            .iter()
            .filter(|sample| sample.closing)
            .filter_map(|last| {
                let first = samples
                    .iter()
                    .find(|first| !first.closing && first.c_deg == 0.0 && first.gamma_deg == last.gamma_deg)?;
                Some((first, last))
            })
            .collect();
        let n = pairs.len() as f64;
        let difference = |(first, last): &(&Sample, &Sample)| last.intensity_cd - first.intensity_cd;
        let worst = pairs
            .iter()
            .max_by(|a, b| difference(a).abs().total_cmp(&difference(b).abs()))?;
        let u2 = |sample: &Sample| sample.u_own_cd().powi(2);
        Some(Self {
            directions: pairs.len(),
            rms_cd: (pairs.iter().map(|pair| difference(pair).powi(2)).sum::<f64>() / n).sqrt(),
            max_cd: difference(worst),
            max_gamma_deg: worst.1.gamma_deg,
            chi2_per_direction: pairs
                .iter()
                .map(|pair| difference(pair).powi(2) / (u2(pair.0) + u2(pair.1)).max(f64::MIN_POSITIVE))
                .sum::<f64>()
                / n,
        })
    }
}
