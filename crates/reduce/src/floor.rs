//! The floor whose diffuse reflection explains what the lux meter reads behind its baffle.

use isolux_model::{Effect, Emitter, Luminaire, Model, Spectral};
use isolux_record::observation::ReadingCoordinates;
use isolux_record::{ReadingKind, Run};

use crate::Reduction;
use crate::background::Level;
use crate::bench::table;

/// The reduced distribution as a point source.
pub fn far_field(reduction: &Reduction) -> Model {
    let distribution = reduction.grid.distribution.clone();
    Model::of(Luminaire::new(distribution, Emitter::Point {}, Spectral::None))
}

/// The floor whose diffuse reflection explains the baffled readings.
pub struct Floor {
    pub effect: Effect,
    u_albedo: f64,
}

impl Floor {
    /// The albedo fitted to baffled − lamp_off over γ, at the height that the station gives; nothing where there is
    /// no such reading, where the fit is no floor (albedo below zero) or where a reading is further from it than four
    /// times its uncertainty: that stray light comes another way.
    pub fn of(run: &Run, reduction: &Reduction) -> Option<Self> {
        const TRIAL_ALBEDO: f64 = 0.1;
        // Of twenty γ one is more than three times its uncertainty away in 5 % of the days, more than four in 0.1 %.
        const WITHIN_U: f64 = 4.0;
        let height_mm = run.header.station.bench().floor_mm?;
        let background = &reduction.background;
        let off = background.lamp_off.or(background.capped)?;
        if background.baffled.is_empty() || !reduction.subtract.stray {
            return None;
        }
        let at: Vec<ReadingCoordinates> = background
            .baffled
            .iter()
            .map(|(gamma_deg, _)| ReadingCoordinates {
                kind: ReadingKind::Baffled,
                time_s: None,
                lamp_s: None,
                c_deg: 0.0,
                gamma_deg: *gamma_deg,
                distance_mm: reduction.distance_mm,
                travel: 0,
                range: None,
                ambient_c: None,
                head: 0,
            })
            .collect();
        let of_albedo = |albedo| Effect::of_floor(albedo, height_mm);
        let per_trial = far_field(reduction)
            .with_effects(vec![of_albedo(TRIAL_ALBEDO).ok()?])
            .predict_readings(&at);
        // A few repeats at one γ scatter by chance much less than they are uncertain: what all γ scatter by counts.
        let squared = |(_, level): &(f64, Level)| level.u_noise_lx * level.u_noise_lx;
        let noise_lx = (background.baffled.iter().map(squared).sum::<f64>() / background.baffled.len() as f64).sqrt();
        let of_level = |level: &Level| noise_lx.hypot(level.u_digit_lx).hypot(off.u_lx());
        let stray: Vec<(f64, f64)> = background
            .baffled
            .iter()
            .map(|(_, level)| (level.mean_lx - off.mean_lx, of_level(level)))
            .collect();
        let squares: f64 = per_trial.iter().map(|lux| lux * lux).sum();
        let product: f64 = per_trial.iter().zip(&stray).map(|(lux, (stray, _))| lux * stray).sum();
        let share = product / squares;
        let explained = per_trial
            .iter()
            .zip(&stray)
            .all(|(lux, (stray, u))| (stray - share * lux).abs() <= WITHIN_U * u);
        if !(share > 0.0 && explained) {
            return None;
        }
        // The rounding is the same at every γ, so it does not average out over them.
        let u_lx = stray.iter().fold(0.0_f64, |largest, (_, u)| largest.max(*u));
        Some(Self {
            effect: of_albedo(TRIAL_ALBEDO * share).ok()?,
            u_albedo: TRIAL_ALBEDO * per_trial.iter().sum::<f64>() * u_lx / squares,
        })
    }

    /// Its table of a model file, without the heading.
    pub fn table(&self) -> String {
        let key = self.effect.spec().parameters[0].key;
        format!("{}\n[effect.u]\n{key} = {:.6}\n", table(&self.effect), self.u_albedo)
    }
}
