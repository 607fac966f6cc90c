//! What is not known of the lamp's change in time, and of the amplitudes of effects.
//!
//! A model that was measured half-plane by half-plane has the same error twice: a reading is taken at another age of the
//! lamp, and each half-plane was (`half_plane_lamp_s`).

use isolux_photometry::IntensityDistribution;

use super::KnownError;
use crate::effect::Effect;
use crate::effects::{Role, by_name};
use crate::model::Model;

const WARM_UP: &str = "lamp_warmup";
const DRIFT: &str = "lamp_drift";
/// What is left of a lamp's warm-up when it counts as stable (0.5 % in 15 min at most: EN 13032-1, LM-79), as amplitudes
/// at switch-on and time constants in s: each leaves 0.1 % after half an hour.
const WARM_UP_REST: [[f64; 2]; 2] = [[0.02, 600.0], [0.003, 1800.0]];

impl Model {
    /// Amplitudes of effects that state their uncertainty.
    pub(super) fn effect_errors(&self) -> Vec<KnownError> {
        let mut known = Vec::new();
        for (place, effect) in self.effects().iter().enumerate() {
            let Some(u) = &effect.notes.u else { continue };
            for (key, parameter) in effect.spec().parameters.iter().enumerate() {
                let stated = u.get(parameter.key).and_then(toml::Value::as_float);
                let Some(stated) = stated.filter(|u| *u > 0.0 && parameter.role == Role::Amplitude) else {
                    continue;
                };
                let mut values = effect.values().to_vec();
                values[key] += stated;
                let Ok(moved) = Effect::new(effect.spec(), &values) else {
                    continue;
                };
                let mut effects = self.effects().to_vec();
                effects[place] = moved;
                let mut off = self.with_effects(effects);
                if effect.name() == DRIFT {
                    // The half-planes were brought to the reference time by the drift as the file has it.
                    let back = |lamp_s: f64| self.lamp_factor(Some(lamp_s)) / off.lamp_factor(Some(lamp_s));
                    off = off.with_half_planes(back);
                }
                known.push(KnownError {
                    what: format!("{} of {}", parameter.key, effect.name()),
                    u: stated,
                    unit: parameter.unit,
                    assumed: false,
                    change: vec![(1.0, off), (-1.0, self.clone())],
                });
            }
        }
        known
    }

    /// The rest of the warm-up of a lamp that counts as stable, where the file says how uncertain the luminaire is and has
    /// no warm-up of its own.
    pub(super) fn warm_up_errors(&self) -> Vec<KnownError> {
        if self.uncertainty().is_none() || self.effects().iter().any(|effect| effect.name() == WARM_UP) {
            return Vec::new();
        }
        let rest = |values: [f64; 2]| {
            let rest = Effect::new(by_name(WARM_UP)?, &values).ok()?;
            let warm = self.with_effects([self.effects(), &[rest]].concat());
            let excess = |lamp_s: f64| warm.lamp_factor(Some(lamp_s)) / self.lamp_factor(Some(lamp_s)) - 1.0;
            let followed = self.followed_drift(excess);
            let off = warm.with_half_planes(|lamp_s| 1.0 - (excess(lamp_s) - followed(lamp_s)));
            Some(KnownError {
                what: "the rest of the lamp's warm-up".to_owned(),
                u: values[0],
                unit: "",
                assumed: true,
                change: vec![(1.0, off), (-1.0, self.clone())],
            })
        };
        WARM_UP_REST.into_iter().filter_map(rest).collect()
    }

    /// The part of a change of the lamp that the measurement took for a drift: the straight line through it at the ages of
    /// the half-planes where the file has a drift, their mean where it has none.
    fn followed_drift(&self, change: impl Fn(f64) -> f64) -> impl Fn(f64) -> f64 {
        let ages = self.half_plane_ages();
        let count = ages.len().max(1) as f64;
        let centre_s = ages.iter().sum::<f64>() / count;
        let mean = ages.iter().map(|age| change(*age)).sum::<f64>() / count;
        let square: f64 = ages.iter().map(|age| (age - centre_s).powi(2)).sum();
        let product: f64 = ages.iter().map(|age| (age - centre_s) * change(*age)).sum();
        let has_drift = self.effects().iter().any(|effect| effect.name() == DRIFT);
        let slope = if has_drift && square > 0.0 {
            product / square
        } else {
            0.0
        };
        move |lamp_s| mean + slope * (lamp_s - centre_s)
    }

    fn half_plane_ages(&self) -> &[f64] {
        let u = self.uncertainty().and_then(|u| u.half_plane_lamp_s.as_deref());
        u.unwrap_or_default()
    }

    /// Each half-plane's light times `factor` of the age of the lamp at which it was read; the same model where that is not
    /// stated.
    fn with_half_planes(&self, factor: impl Fn(f64) -> f64) -> Self {
        let grid = self.luminaire().distribution();
        let gammas = grid.gamma_deg();
        let values: Vec<f64> = self
            .half_plane_ages()
            .iter()
            .flat_map(|age| [factor(*age); 2])
            .collect();
        let ends = vec![gammas[0], gammas[gammas.len() - 1]];
        match IntensityDistribution::new(grid.c_deg().to_vec(), ends, values) {
            Ok(factor) => self.with_luminaire(
                self.luminaire()
                    .with_emitter(self.luminaire().emitter().clone(), Some(factor)),
            ),
            Err(_) => self.clone(),
        }
    }
}
