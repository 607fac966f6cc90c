//! What the file of a model states of its own uncertainty, as models that are off by it: the errors that all
//! predictions from one luminaire share.
//!
//! The noise of single directions is in [`crate::DirectionError`]; here is what many directions have in common. What is
//! stated of an effect (`[effect.u]`) counts too. Where a measured luminaire does not state its level or its γ, they
//! are taken as wide as a careless measurement leaves them, and [`KnownError::assumed`] says so.

use isolux_photometry::IntensityDistribution;

use crate::effect::Effect;
use crate::effects::Role;
use crate::emitter::Emitter;
use crate::luminaire::Luminaire;
use crate::model::Model;
use crate::refined::Refined;

/// Relative standard uncertainty of the level where a measured luminaire does not state it.
const LEVEL_REL: f64 = 0.1;
/// The same of γ, in degrees.
const GAMMA_DEG: f64 = 0.5;
/// Rings of equal width into which a luminous area of stated diameter is divided. Their shares of the light are drawn
/// by a Dirichlet law whose mean is an even area and whose concentration is this: a thin ring and a point in the middle
/// lie two standard uncertainties away from it ([`luminous_area_rel`]).
const RINGS: usize = 4;
const CONCENTRATION: f64 = 0.5;
/// LEDs that stand for a ring.
const LEDS: usize = 24;
/// Standard uncertainty of the inward aim of the parts of a luminous area.
const AIM_DEG: f64 = 1.0;
/// Relative amplitude of the light around the luminous area, in each of the first orders: sixty LEDs whose flux differs
/// by 5 %.
const AROUND_REL: f64 = 0.01;
const AROUND_ORDERS: [f64; 2] = [1.0, 2.0];

/// Relative standard uncertainty of the light on the axis at `distance_mm` from a luminous area of which the diameter
/// alone is known, for a lobe of exponent n. The axis sees −½(n + 3)·r²/d², r² being the mean square radius; by the law
/// of the shares it is R²/2 with a standard deviation of R²/√(12·(1 + concentration)).
pub fn luminous_area_rel(diameter_mm: f64, lobe_exponent: f64, distance_mm: f64) -> f64 {
    let square = (0.5 * diameter_mm / distance_mm).powi(2);
    0.5 * (lobe_exponent + 3.0) * square / (12.0 * (1.0 + CONCENTRATION)).sqrt()
}

/// One thing that the model knows with a standard uncertainty, and what it changes.
#[derive(Debug, Clone)]
pub struct KnownError {
    /// What, in words.
    pub what: String,
    /// Its standard uncertainty.
    pub u: f64,
    /// The unit of that; empty for a ratio.
    pub unit: &'static str,
    /// Whether the file does not state it and it was taken as wide as usual.
    pub assumed: bool,
    /// One standard uncertainty changes a prediction by `per_u` times what `off` predicts more than `from`.
    pub off: Model,
    /// The model that `off` is compared with.
    pub from: Model,
    /// Factor of that difference.
    pub per_u: f64,
}

impl Model {
    /// What the model's file states of its own uncertainty, one entry for each independent error. Nothing for a
    /// luminaire without `[luminaire.u]`.
    pub fn known_errors(&self) -> Vec<KnownError> {
        let mut known = Vec::new();
        // The floor's light is small: its errors are those of the direct light, and it takes long to compute.
        let direct = self.with_effects(
            self.effects()
                .iter()
                .filter(|effect| effect.spec().takes_over() != Some(isolux_record::ReadingKind::Baffled))
                .cloned()
                .collect(),
        );
        let entry = |what: &str, u: f64, unit: &'static str, off: Model| KnownError {
            what: what.to_owned(),
            u,
            unit,
            assumed: false,
            off,
            from: direct.clone(),
            per_u: 1.0,
        };
        if let Some(u) = self.uncertainty() {
            if !self.refits_shape() {
                let level = u.intensity_rel.unwrap_or(LEVEL_REL);
                let mut refined: Refined = direct.refined().clone();
                refined.ln_shape.resize(refined.ln_shape.len().max(1), 0.0);
                refined.ln_shape[0] += level;
                known.push(KnownError {
                    assumed: u.intensity_rel.is_none(),
                    ..entry("the level of the light", level, "", direct.with_refined(refined))
                });
                let gamma = u.gamma_deg.unwrap_or(GAMMA_DEG);
                known.extend(direct.with_gamma_moved(gamma).map(|off| KnownError {
                    assumed: u.gamma_deg.is_none(),
                    ..entry("γ", gamma, "°", off)
                }));
            }
            if let Some(common) = u.common_cd.filter(|common| *common > 0.0) {
                known.extend(
                    direct
                        .with_level_added(common)
                        .map(|off| entry("an intensity in all directions", common, "cd", off)),
                );
            }
            if let Some(diameter_mm) = u.luminous_diameter_mm.filter(|diameter| *diameter > 0.0) {
                known.extend(direct.emitter_errors(diameter_mm));
            }
        }
        known.extend(self.effect_errors());
        known
    }

    /// Every direction's intensity is that of γ + `by_deg`, on the grid between whose directions the light is linear.
    fn with_gamma_moved(&self, by_deg: f64) -> Option<Self> {
        let distribution = self.luminaire().grid();
        let last = *distribution.gamma_deg().last()?;
        self.with_intensities(|c_deg, gamma_deg, _| {
            self.luminaire().intensity_cd(c_deg, (gamma_deg + by_deg).min(last))
        })
    }

    fn with_level_added(&self, more_cd: f64) -> Option<Self> {
        self.with_intensities(|_, _, intensity_cd| intensity_cd + more_cd)
    }

    fn with_intensities(&self, law: impl Fn(f64, f64, f64) -> f64) -> Option<Self> {
        let distribution = self.luminaire().grid();
        let (cs, gammas) = (distribution.c_deg(), distribution.gamma_deg());
        let directions = cs.iter().flat_map(|c| gammas.iter().map(move |gamma| (*c, *gamma)));
        let values = directions
            .zip(distribution.intensity_cd())
            .map(|((c, gamma), cd)| law(c, gamma, *cd))
            .collect();
        let moved = IntensityDistribution::new(cs.to_vec(), gammas.to_vec(), values).ok()?;
        let luminaire = self.luminaire();
        let (emitter, spectral) = (luminaire.emitter().clone(), luminaire.spectral().clone());
        Some(self.with_luminaire(Luminaire::new(moved, emitter, spectral)))
    }

    fn with_emitter(&self, emitter: Emitter) -> Self {
        let luminaire = self.luminaire();
        let (distribution, spectral) = (luminaire.grid().clone(), luminaire.spectral().clone());
        self.with_luminaire(Luminaire::new(distribution, emitter, spectral))
    }

    /// Where in a luminous area of this diameter the light leaves, how its parts are aimed and how evenly they are lit:
    /// what a measurement from far away does not see. Nothing where the model has single LEDs, a ring or a rectangle:
    /// then somebody said where they are.
    fn emitter_errors(&self, diameter_mm: f64) -> Vec<KnownError> {
        if self.effective_emitter().is_some()
            || !matches!(self.luminaire().emitter(), Emitter::Point {} | Emitter::Disc { .. })
        {
            return Vec::new();
        }
        let of = |what: &str, u: f64, unit: &'static str, off: Self, from: Self, per_u: f64| KnownError {
            what: what.to_owned(),
            u,
            unit,
            assumed: true,
            off,
            from,
            per_u,
        };
        let mut known = Vec::new();
        for ring in 0..RINGS {
            let edge_mm = |k: usize| diameter_mm * k as f64 / RINGS as f64;
            let share = (edge_mm(ring + 1).powi(2) - edge_mm(ring).powi(2)) / diameter_mm.powi(2);
            let emitter = if ring == 0 {
                Emitter::Disc {
                    diameter_mm: edge_mm(1),
                }
            } else {
                Emitter::Ring {
                    inner_diameter_mm: edge_mm(ring),
                    outer_diameter_mm: edge_mm(ring + 1),
                }
            };
            let per_u = (share / (1.0 + CONCENTRATION)).sqrt();
            let u_share = (share * (1.0 - share) / (1.0 + CONCENTRATION)).sqrt();
            known.push(of(
                &format!(
                    "the share of the light from {:.0} to {:.0} mm of radius",
                    0.5 * edge_mm(ring),
                    0.5 * edge_mm(ring + 1)
                ),
                u_share,
                "",
                self.with_emitter(emitter),
                self.clone(),
                per_u,
            ));
        }
        // The ring with the mean square radius of the whole area.
        let radius_mm = diameter_mm / 8_f64.sqrt();
        let aimed = |aim_deg: f64| {
            self.with_emitter(Emitter::Leds {
                position_mm: Vec::new(),
                weight: Vec::new(),
                radius_mm: vec![radius_mm],
                count: vec![LEDS],
                aim_deg,
            })
        };
        let even = aimed(0.0);
        known.push(of(
            "the inward aim of the parts",
            AIM_DEG,
            "°",
            aimed(AIM_DEG),
            even.clone(),
            1.0,
        ));
        let places: Vec<(f64, Vec<f64>)> = (0..LEDS)
            .map(|led| {
                let azimuth = std::f64::consts::TAU * led as f64 / LEDS as f64;
                (azimuth, vec![radius_mm * azimuth.cos(), radius_mm * azimuth.sin()])
            })
            .collect();
        for order in AROUND_ORDERS {
            for wave in [f64::cos, f64::sin] {
                let emitter = Emitter::Leds {
                    position_mm: places.iter().map(|(_, place)| place.clone()).collect(),
                    weight: places
                        .iter()
                        .map(|(azimuth, _)| 1.0 + AROUND_REL * wave(order * azimuth))
                        .collect(),
                    radius_mm: Vec::new(),
                    count: Vec::new(),
                    aim_deg: 0.0,
                };
                known.push(of(
                    "how even the luminous area is",
                    AROUND_REL,
                    "",
                    self.with_emitter(emitter),
                    even.clone(),
                    1.0,
                ));
            }
        }
        known
    }

    /// Amplitudes of effects that state their uncertainty.
    fn effect_errors(&self) -> Vec<KnownError> {
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
                known.push(KnownError {
                    what: format!("{} of {}", parameter.key, effect.name()),
                    u: stated,
                    unit: parameter.unit,
                    assumed: false,
                    off: self.with_effects(effects),
                    from: self.clone(),
                    per_u: 1.0,
                });
            }
        }
        known
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use camino::Utf8PathBuf;
    use isolux_record::ReadingKind;
    use isolux_record::observation::ReadingCoordinates;

    const N: i32 = 4;

    fn model(luminaire: &str) -> Model {
        let keep = tempfile::tempdir().unwrap();
        let path = Utf8PathBuf::try_from(keep.path().join("lamp.model.toml")).unwrap();
        let mut table = String::from("gamma_deg,intensity_cd\n");
        for gamma in 0..=90 {
            let cd = 300.0 * f64::from(gamma).to_radians().cos().powi(N);
            table += &format!("{gamma},{cd}\n");
        }
        std::fs::write(keep.path().join("lamp.csv"), table).unwrap();
        let text = format!(
            "format = \"isolux-model/1\"\n[luminaire]\ndistribution = \"lamp.csv\"\n\
             emitter = {{ shape = \"disc\", diameter_mm = 60.0 }}\n{luminaire}"
        );
        Model::parse(&path, &text).unwrap()
    }

    fn at(gamma_deg: f64, distance_mm: f64) -> ReadingCoordinates {
        ReadingCoordinates {
            kind: ReadingKind::Lit,
            time_s: Some(3600.0),
            lamp_s: Some(3600.0),
            c_deg: 0.0,
            gamma_deg,
            distance_mm,
            travel: 0,
            range: None,
            ambient_c: None,
        }
    }

    /// What one standard uncertainty of each entry changes, relative to the prediction.
    fn change_rel(model: &Model, what: &str, at: &ReadingCoordinates) -> Vec<f64> {
        let known = model.known_errors();
        let of = known.iter().filter(|one| one.what.contains(what));
        of.map(|one| {
            let difference = one.off.predict_reading(at) - one.from.predict_reading(at);
            one.per_u * difference / model.predict_reading(at)
        })
        .collect()
    }

    #[test]
    fn nothing_is_known_of_a_file_that_states_nothing() {
        assert!(model("").known_errors().is_empty());
    }

    #[test]
    fn level_gamma_and_drift_change_what_they_should() {
        let model = model(
            "[luminaire.u]\nintensity_rel = 0.004\ngamma_deg = 0.05\ncommon_cd = 0.3\n\
             [[effect]]\nname = \"lamp_drift\"\nrate_per_h = -0.001\nreference_s = 0.0\nu = { rate_per_h = 0.0002 }\n",
        );
        let here = at(40.0, 10_000.0);
        let close = |found: Vec<f64>, expected: f64| {
            assert!(
                found.len() == 1 && (found[0] / expected - 1.0).abs() < 0.02,
                "{found:?} for {expected}"
            );
        };
        close(change_rel(&model, "level", &here), 0.004);
        close(
            change_rel(&model, "γ", &here),
            -f64::from(N) * 40_f64.to_radians().tan() * 0.05_f64.to_radians(),
        );
        let there_cd = 300.0 * 40_f64.to_radians().cos().powi(N);
        close(change_rel(&model, "all directions", &here), 0.3 / there_cd);
        close(change_rel(&model, "rate_per_h", &here), 0.0002);
    }

    #[test]
    fn a_luminous_area_is_known_by_its_diameter_alone() {
        let model = model("[luminaire.u]\nintensity_rel = 0.004\ngamma_deg = 0.05\nluminous_diameter_mm = 60.0\n");
        let (near, far) = (at(0.0, 300.0), at(0.0, 10_000.0));
        let total = |at| {
            change_rel(&model, "share", at)
                .iter()
                .map(|x| x * x)
                .sum::<f64>()
                .sqrt()
        };
        let expected = luminous_area_rel(60.0, f64::from(N), 300.0);
        assert!(
            (total(&near) / expected - 1.0).abs() < 0.15,
            "{} {expected}",
            total(&near)
        );
        assert!(total(&far) < 1e-4);
    }
}
