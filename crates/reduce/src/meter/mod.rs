//! What the lux meter itself makes of light: corrected where its station states it, and its part of the uncertainty.

mod heads;
mod spectral;

use isolux_record::Run;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

pub use self::spectral::SpectralMismatch;

use self::spectral::SpectralMatch;
use crate::Options;
use crate::bench::Bench;
use crate::budget::Common;
use crate::error::ReduceError;

/// What is known of the lux meter's own response, `luxmeter` of `budget.json`.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize, JsonSchema)]
pub struct MeterFacts {
    /// Its spectral mismatch for the lamp, where the head's responsivity and a spectrum are known.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub spectral_mismatch: Option<SpectralMismatch>,
}

impl MeterFacts {
    /// Whether nothing is known.
    pub fn is_empty(&self) -> bool {
        self.spectral_mismatch.is_none()
    }
}

/// The response of a run's lux meter.
#[derive(Debug, Clone, Default)]
pub struct Meter {
    spectral: SpectralMatch,
}

impl Meter {
    /// Of the readings of `run`, with the effects of `bench` taken out.
    ///
    /// # Errors
    /// What makes counts no irradiance, where the station states the head's responsivity.
    pub fn of(run: &Run, options: &Options, bench: Option<&Bench>) -> Result<Self, ReduceError> {
        Ok(Self {
            spectral: SpectralMatch::of(run, options, bench)?,
        })
    }

    /// By what a reading of the lamp's light towards (C, γ) is multiplied; γ may be signed.
    pub fn factor(&self, c_deg: f64, gamma_deg: f64) -> f64 {
        self.spectral.factor(c_deg, gamma_deg)
    }

    /// The uncertainties that all readings share by it.
    pub fn shared(&self, common: Common) -> Common {
        Common {
            spectral_mismatch_rel: self.spectral.u_rel,
            ..common
        }
    }

    /// What no part says.
    pub fn missing(&self) -> Vec<String> {
        self.spectral.missing.clone()
    }

    /// What a person should know.
    pub fn notes(&self) -> Vec<String> {
        self.spectral.note.iter().cloned().collect()
    }

    /// Tables of effects for a model whose predictions are readings of this meter.
    pub fn effects(&self) -> Vec<String> {
        self.spectral.effect().into_iter().collect()
    }

    /// What is known.
    pub fn facts(&self) -> MeterFacts {
        MeterFacts {
            spectral_mismatch: self.spectral.facts.clone(),
        }
    }
}
