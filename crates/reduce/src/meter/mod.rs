//! What the lux meter itself makes of light: corrected where its station states it, and its part of the uncertainty.

mod cosine;
mod fatigue;
mod found;
mod head;
mod heads;
mod linearity;
mod response;
mod spectral;
mod temperature;

use isolux_record::Run;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

pub use self::found::MeterFactors;
pub(crate) use self::head::waves;
pub use self::response::Response;
pub use self::spectral::SpectralMismatch;

use self::cosine::Directional;
use self::found::{Found, is_lit};
use self::spectral::SpectralMatch;
use crate::Options;
use crate::bench::Bench;
use crate::budget::Common;
use crate::correction::Correction;
use crate::error::ReduceError;

/// The effect of a model that takes the directional response out.
const COSINE_EFFECT: &str = "cosine_f2";

/// What is known of the lux meter's own response, `luxmeter` of `budget.json`.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize, JsonSchema)]
pub struct MeterFacts {
    /// Its spectral mismatch for the lamp, where the head's responsivity and a spectrum are known.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub spectral_mismatch: Option<SpectralMismatch>,
    /// By its linearity.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub linearity: Option<MeterFactors>,
    /// By its temperature.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub temperature: Option<MeterFactors>,
    /// By its directional response to the size of the lamp.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub cosine: Option<MeterFactors>,
    /// By its fatigue.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub fatigue: Option<MeterFactors>,
}

impl MeterFacts {
    /// Whether nothing is known.
    pub fn is_empty(&self) -> bool {
        *self == Self::default()
    }

    /// Whether there was something for this correction to take out; of those that are not the meter's always.
    pub fn has(&self, correction: Correction) -> bool {
        match correction {
            Correction::SpectralMismatch => self.spectral_mismatch.is_some(),
            Correction::Linearity => self.linearity.is_some(),
            Correction::Temperature => self.temperature.is_some(),
            Correction::Cosine => self.cosine.is_some(),
            Correction::Fatigue => self.fatigue.is_some(),
            _ => true,
        }
    }

    /// The parts of a budget that a draw of the record's inputs shows: corrected by a factor of what was read.
    pub(crate) fn corrected(&self) -> Vec<&'static str> {
        let factors = |name, found: Option<MeterFactors>| found.is_some_and(|found| found.corrected).then_some(name);
        let spectral = self.spectral_mismatch.as_ref().is_some_and(|found| found.corrected);
        let spectral = spectral.then_some("spectral_mismatch");
        let others = [
            factors("linearity", self.linearity),
            factors("temperature", self.temperature),
        ];
        spectral.into_iter().chain(others.into_iter().flatten()).collect()
    }
}

/// The response of a run's lux meter.
#[derive(Debug, Clone)]
pub struct Meter<'a> {
    response: &'a Response,
    spectral: SpectralMatch,
    /// None where it is not corrected.
    directional: Option<Directional>,
    cosine: Found,
}

impl<'a> Meter<'a> {
    /// Of the readings of `run`, after `response`, with the effects of `bench` taken out.
    ///
    /// # Errors
    /// What makes counts no irradiance, where the station states the head's responsivity.
    pub fn of(
        run: &Run,
        options: &Options,
        bench: Option<&Bench>,
        response: &'a Response,
    ) -> Result<Self, ReduceError> {
        let (directional, cosine) = cosine(run, options, bench);
        Ok(Self {
            response,
            spectral: SpectralMatch::of(run, options, bench)?,
            directional,
            cosine,
        })
    }

    /// By what a reading of the lamp's light towards (C, γ) from this distance is multiplied; γ may be signed.
    pub fn factor(&self, c_deg: f64, gamma_deg: f64, distance_mm: f64) -> f64 {
        let directional = self.directional.as_ref();
        let directional = directional.map_or(1.0, |directional| directional.factor(gamma_deg, distance_mm).0);
        directional * self.spectral.factor(c_deg, gamma_deg)
    }

    /// The uncertainties that all readings share by it.
    pub fn shared(&self, common: Common) -> Common {
        Common {
            spectral_mismatch_rel: self.spectral.u_rel,
            linearity_rel: self.response.linearity.u_rel,
            temperature_rel: self.response.temperature.u_rel,
            cosine_rel: self.cosine.u_rel,
            fatigue_rel: self.response.fatigue.u_rel,
            ..common
        }
    }

    /// What was found of it, the spectral mismatch apart.
    fn found(&self) -> impl Iterator<Item = &Found> {
        self.response.found().into_iter().chain([&self.cosine])
    }

    /// What no part says.
    pub fn missing(&self) -> Vec<String> {
        let others = self.found().filter_map(|found| found.missing.clone());
        self.spectral.missing.iter().cloned().chain(others).collect()
    }

    /// What a person should know.
    pub fn notes(&self) -> Vec<String> {
        let others = self.found().filter_map(|found| found.note.clone());
        self.spectral.note.iter().cloned().chain(others).collect()
    }

    /// Tables of effects for a model whose predictions are readings of this meter.
    pub fn effects(&self) -> Vec<String> {
        let others = self.found().filter_map(|found| found.effect.clone());
        self.spectral.effect().into_iter().chain(others).collect()
    }

    /// What is known.
    pub fn facts(&self) -> MeterFacts {
        MeterFacts {
            spectral_mismatch: self.spectral.facts.clone(),
            linearity: self.response.linearity.facts,
            temperature: self.response.temperature.facts,
            cosine: self.cosine.facts,
            fatigue: self.response.fatigue.facts,
        }
    }
}

/// What the directional response does to the readings of the lamp, and what corrects it.
fn cosine(run: &Run, options: &Options, bench: Option<&Bench>) -> (Option<Directional>, Found) {
    let station = &run.header.station;
    let Some(stated) = &station.luxmeter().cosine else {
        return (None, Found::default());
    };
    if bench.is_some_and(|bench| bench.takes_out(COSINE_EFFECT)) {
        return (None, Found::default());
    }
    let Some(directional) = Directional::new(stated, station.lamp()) else {
        let what = "the lux meter's directional response is not corrected: the station states no lamp.diameter_mm";
        return (None, Found::unknown(what.to_owned()));
    };
    let corrected = !options.without.contains(&Correction::Cosine);
    let rows = &run.readings.rows;
    let (mut u_table, mut largest) = (0.0_f64, 0.0_f64);
    let factors = rows.iter().map(|row| {
        if !is_lit(row) {
            return 1.0;
        }
        let (factor, u) = directional.factor(row.gamma_deg, row.distance_mm);
        u_table = u_table.max(u);
        largest = largest.max((factor - 1.0).abs());
        factor
    });
    let factors: Vec<f64> = factors.collect();
    // How bright which part of the lamp is, is not known: from its middle alone to its edge alone.
    let u_rel = u_table.hypot(largest / 3.0_f64.sqrt());
    let found = Found {
        effect: corrected.then(|| directional.effect(COSINE_EFFECT)).flatten(),
        ..Found::of(rows, factors, u_rel, corrected)
    };
    (corrected.then_some(directional), found)
}
