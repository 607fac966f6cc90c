//! What profiles of lux meters have in common: units of illuminance, the range, `[timing]`.

use std::time::Duration;

use isolux_profile::{Spanned, Wrong, seconds, wrong};
use serde::Deserialize;

/// A footcandle is a lumen per square foot; a foot is 0.3048 m.
const FOOTCANDLE_LX: f64 = 1.0 / (0.3048 * 0.3048);

/// A unit of illuminance, as a profile names it.
#[derive(Debug, Clone, Copy, Deserialize)]
#[serde(rename_all = "lowercase")]
pub(crate) enum Unit {
    Lx,
    Klx,
    Fc,
}

impl Unit {
    /// One of it in lx.
    pub const fn lx(self) -> f64 {
        match self {
            Self::Lx => 1.0,
            Self::Klx => 1000.0,
            Self::Fc => FOOTCANDLE_LX,
        }
    }
}

/// The range of a reading.
///
/// # Errors
/// [`Wrong`] where it is none.
pub(crate) fn range(range: &Spanned<[f64; 2]>) -> Result<[f64; 2], Wrong> {
    let [low, high] = *range.get_ref();
    if low.is_finite() && high.is_finite() && low < high && high > 0.0 {
        Ok([low, high])
    } else {
        let reason = "range must be [lowest, highest] in the unit of the reading";
        Err(wrong(range.span(), reason))
    }
}

/// `[timing]`.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct Timing {
    update_interval_s: Spanned<f64>,
    integration_s: Spanned<f64>,
}

impl Timing {
    /// A new value appears this often.
    ///
    /// # Errors
    /// [`Wrong`] for no such time.
    pub fn update_interval(&self) -> Result<Duration, Wrong> {
        seconds("update_interval_s", &self.update_interval_s)
    }

    /// Each value integrates the light of so long.
    ///
    /// # Errors
    /// As [`update_interval`](Self::update_interval).
    pub fn integration(&self) -> Result<Duration, Wrong> {
        seconds("integration_s", &self.integration_s)
    }
}
