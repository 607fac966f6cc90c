//! Light below the floor of the numbers' decimals: what rounding may hide.
//!
//! A zero stands for anything below half of the last decimal, every other number for half of it to either side. Over a
//! whole file that is a bound on light that the numbers cannot show: small for most, six per cent of the flux for a
//! lamp of 114 cd in whole candela, half of it where 1 is the largest number.

use super::{Stored, at, decimals};
use crate::finding::{Finding, Findings};

/// From this part of the flux on, what rounding may hide is a note. Of 334 files by many hands 67 are above it: lamps
/// of some ten candela in whole candela, and templates of ones and zeros. Nothing in them is wrong, so it is a note.
const HIDDEN: f64 = 0.002;

/// Compares what rounding may hide with the light that is there.
pub(super) fn check(stored: &Stored<'_>, findings: &mut Findings) {
    let step = 10f64.powi(-decimals(stored));
    let peak = stored.values.iter().fold(0.0_f64, |most, value| most.max(value.abs()));
    let weights = zones(stored);
    if weights.is_empty() {
        return;
    }
    let (mut light, mut dark_weight, mut lit_weight) = (0.0, 0.0, 0.0);
    for plane in stored.values.chunks_exact(weights.len()) {
        for (value, weight) in plane.iter().zip(&weights) {
            light += weight * value.abs();
            *(if *value == 0.0 {
                &mut dark_weight
            } else {
                &mut lit_weight
            }) += weight;
        }
    }
    if light <= 0.0 {
        return;
    }
    let [zeros, others] = [dark_weight, lit_weight].map(|weight| 0.5 * step * weight / light);
    let hidden = zeros + others;
    if hidden <= HIDDEN {
        return;
    }
    let message = format!(
        "the numbers end at {step}, {:.2} % of the largest: up to {:.2} % of the light may hide in zeros, {:.2} % in the \
         rounding of the others",
        100.0 * step / peak,
        100.0 * zeros,
        100.0 * others
    );
    let zero_after_light =
        (1..stored.values.len()).find(|&at| stored.values[at] == 0.0 && stored.values[at - 1] != 0.0);
    let finding = Finding::note("intensity-floor", message).assumed("the numbers as they stand");
    findings.push(at(stored, zero_after_light.unwrap_or(0), finding).fix("ask for the data with more decimals"));
}

/// The share of the sphere that each angle of a plane stands for, up to a factor.
fn zones(stored: &Stored<'_>) -> Vec<f64> {
    let height = |angle: f64| {
        let radians = angle.to_radians();
        if stored.poles { -radians.cos() } else { radians.sin() }
    };
    let angles = stored.angles_deg;
    let mut weights = vec![0.0; angles.len()];
    for (index, pair) in angles.windows(2).enumerate() {
        let half = 0.5 * (height(pair[1]) - height(pair[0]));
        weights[index] += half;
        weights[index + 1] += half;
    }
    weights
}
