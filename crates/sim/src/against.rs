//! Whether two simulations differ more than their noise: an earlier `result.json` against a new one.

use crate::noise;
use crate::simulation::{Against, Facts};

/// Two maps of different quantities.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error("{folder}: its map is in {earlier}, this one in {now}: they cannot be compared")]
pub struct OtherUnit {
    folder: String,
    earlier: &'static str,
    now: &'static str,
}

/// The verdict on the means, each with its own numerical uncertainty (quadrature or counted rays; what the model knows
/// of its measurement is common to both and left out).
///
/// # Errors
/// Where one is in lx and the other in W/m².
pub fn compare(facts: &Facts, earlier: &Facts, folder: &str) -> Result<Against, OtherUnit> {
    if earlier.unit != facts.unit {
        return Err(OtherUnit {
            folder: folder.to_owned(),
            earlier: earlier.unit.symbol(),
            now: facts.unit.symbol(),
        });
    }
    let difference = noise::difference(
        (facts.mean, facts.u_mean_numeric),
        (earlier.mean, earlier.u_mean_numeric),
    );
    Ok(Against {
        folder: folder.to_owned(),
        mean: earlier.mean,
        difference: facts.mean - earlier.mean,
        u_difference: facts.u_mean_numeric.hypot(earlier.u_mean_numeric),
        sigma: difference.sigma,
        p_value: difference.p_value,
        differs: difference.p_value < noise::SIGNIFICANT,
        same_rays: facts.seed.is_some() && facts.seed == earlier.seed && facts.sampling == earlier.sampling,
    })
}
