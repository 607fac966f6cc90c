//! A model of the bench, turned around: takes the bench's effects out of lit readings.

use isolux_model::{BelongsTo, Effect, Model, NoInverse};
use isolux_record::observation::ReadingCoordinates;
use isolux_record::{Reading, ReadingKind};

use crate::background::Subtract;
use crate::samples::Corrected;

/// The bench effects of a model, turned around.
pub struct Bench {
    pub model: Model,
    /// Its effects were fitted to readings of the run, whose uncertainty the budget holds.
    pub measured_by_the_run: bool,
}

impl Bench {
    fn of_the_bench(&self) -> impl Iterator<Item = &Effect> {
        self.model
            .effects()
            .iter()
            .filter(|effect| effect.spec().belongs_to(BelongsTo::Bench))
    }

    /// Its effects as tables of a model file: the new model predicts the readings as they were read. The near field,
    /// which no far distribution holds, stays known too.
    pub fn tables(&self) -> Vec<String> {
        let effects = self.model.effects().iter();
        let near_field = effects.filter(|effect| effect.spec().replaces_emitter());
        self.of_the_bench().chain(near_field).map(table).collect()
    }

    /// Whether it takes out the effect of this name.
    pub fn takes_out(&self, name: &str) -> bool {
        self.of_the_bench().any(|effect| effect.name() == name)
    }

    fn has(&self, level: ReadingKind) -> bool {
        let mut effects = self.model.effects().iter();
        effects.any(|effect| effect.spec().takes_over() == Some(level))
    }

    /// For each lit reading and its illuminance: intensity, true direction, candela of one lux.
    ///
    /// # Errors
    /// The effect that has no inverse.
    pub fn correct(&self, readings: &[&Reading], illuminance_lx: &[f64]) -> Result<Vec<Corrected>, NoInverse> {
        let at: Vec<ReadingCoordinates> = readings
            .iter()
            .map(|reading| ReadingCoordinates {
                kind: reading.kind,
                time_s: reading.time_s,
                lamp_s: reading.lamp_s,
                c_deg: reading.c_deg,
                gamma_deg: reading.gamma_deg,
                distance_mm: reading.distance_mm,
                travel: reading.travel,
                range: Some(reading.range),
                ambient_c: reading.ambient_c,
                head: 0,
            })
            .collect();
        let corrected = self.model.correct_readings(&at, illuminance_lx)?;
        Ok(corrected
            .into_iter()
            .map(|light| Corrected {
                intensity_cd: light.intensity_cd,
                cd_per_lx: (light.distance_mm * 1e-3).powi(2),
                c_deg: light.c_deg,
                gamma_deg: light.gamma_deg,
            })
            .collect())
    }

    /// Which of the run's own corrections the model takes over, because it has an effect for them.
    pub fn takes_over(&self) -> Subtract {
        Subtract {
            dark: self.has(ReadingKind::Capped),
            ambient: self.has(ReadingKind::LampOff),
            stray: self.has(ReadingKind::Baffled),
        }
    }

    /// The effects that it takes out whose uncertainty the budget of the run does not hold.
    pub fn without_uncertainty(&self) -> Vec<String> {
        // Levels that the run measured itself are in its budget, whoever takes them out.
        self.of_the_bench()
            .filter(|effect| !self.measured_by_the_run && effect.spec().takes_over().is_none())
            .map(|effect| effect.name().to_owned())
            .collect()
    }

    /// What it takes out, for the provenance.
    pub fn effects(&self) -> Vec<String> {
        self.of_the_bench().map(Effect::name).map(str::to_owned).collect()
    }
}

/// An effect as a table of a model file, without its heading.
pub fn table(effect: &Effect) -> String {
    let keys = effect.spec().parameters.iter().zip(effect.values());
    keys.fold(format!("name = \"{}\"\n", effect.name()), |text, (parameter, value)| {
        text + &format!("{} = {value:?}\n", parameter.key)
    })
}
