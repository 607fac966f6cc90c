//! What the file of a model states of its own uncertainty, as models that are off by it: the errors that all
//! predictions from one luminaire share.
//!
//! The noise of single directions is in [`crate::DirectionError`]; here is what many directions have in common. What is
//! stated of an effect (`[effect.u]`) counts too. Where a measured luminaire does not state its level or its γ, they
//! are taken as wide as a careless measurement leaves them, and [`KnownError::assumed`] says so.

mod emitter;
mod lamp;
mod spectrum;

use isolux_photometry::IntensityDistribution;

use crate::model::Model;
use crate::refined::Refined;

pub use emitter::luminous_area_rel;
pub use spectrum::SpectrumError;

/// Relative standard uncertainty of the level where a measured luminaire does not state it.
const LEVEL_REL: f64 = 0.1;
/// The same of γ, in degrees.
const GAMMA_DEG: f64 = 0.5;

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
    /// One standard uncertainty changes a prediction by the sum of what these models predict, each times its factor. The
    /// factors make 0.
    pub change: Vec<(f64, Model)>,
}

impl KnownError {
    /// What one standard uncertainty changes, where `predict` is what a model predicts; none where it predicts nothing.
    pub fn change_of<P>(&self, predict: impl Fn(&Model) -> Option<P>) -> Option<P>
    where
        P: std::ops::Mul<f64, Output = P> + std::ops::Add<P, Output = P>,
    {
        let terms = self
            .change
            .iter()
            .map(|(factor, model)| Some(predict(model)? * *factor));
        terms.reduce(|sum, term| Some(sum? + term?)).flatten()
    }
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
            change: vec![(1.0, off), (-1.0, direct.clone())],
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
        known.extend(direct.warm_up_errors());
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
        Some(self.with_luminaire(self.luminaire().with_grid(moved)))
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
            head: 0,
        }
    }

    /// What one standard uncertainty of each entry changes, relative to the prediction.
    fn change_rel(model: &Model, what: &str, at: &ReadingCoordinates) -> Vec<f64> {
        let known = model.known_errors();
        let of = known.iter().filter(|one| one.what.contains(what));
        of.map(|one| one.change_of(|off| Some(off.predict_reading(at))).unwrap() / model.predict_reading(at))
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
            let shares = change_rel(&model, "share", at);
            let aim = change_rel(&model, "aim", at);
            shares.iter().chain(&aim).map(|x| x * x).sum::<f64>().sqrt()
        };
        let expected = luminous_area_rel(60.0, f64::from(N), 300.0);
        assert!(
            (total(&near) / expected - 1.0).abs() < 0.15,
            "{} {expected}",
            total(&near)
        );
        let expected = luminous_area_rel(60.0, f64::from(N), 10_000.0);
        assert!(
            (total(&far) / expected - 1.0).abs() < 0.15,
            "{} {expected}",
            total(&far)
        );
    }

    #[test]
    fn where_the_light_was_measured_no_emitter_changes_it() {
        const U: &str = "interpolation = \"smooth\"\n[luminaire.u]\nluminous_diameter_mm = 60.0\n";
        let (unstated, stated) = (model(U), model(&format!("{U}measured_at_mm = 3700.0\n")));
        for what in ["inward aim", "share"] {
            let most = |model: &Model, at: &ReadingCoordinates| {
                let changes = change_rel(model, what, at);
                changes.into_iter().map(f64::abs).fold(0.0, f64::max)
            };
            // Between two directions of the file, too.
            let (there, near) = (at(21.0, 3700.0), at(21.0, 500.0));
            assert!(
                most(&stated, &there) < 0.1 * most(&unstated, &there),
                "{what}: {} of {}",
                most(&stated, &there),
                most(&unstated, &there)
            );
            assert!(most(&unstated, &there) > 1e-5, "{what}: {}", most(&unstated, &there));
            assert!(most(&stated, &near) > 1e-3, "{what}: {}", most(&stated, &near));
        }
    }

    /// Half-planes that were read at different ages of the lamp.
    #[test]
    fn a_half_plane_that_is_read_again_at_the_same_age_has_the_same_drift() {
        const AGES_S: [f64; 4] = [2000.0, 3800.0, 5600.0, 7400.0];
        let keep = tempfile::tempdir().unwrap();
        let path = Utf8PathBuf::try_from(keep.path().join("lamp.model.toml")).unwrap();
        let gammas: Vec<String> = (0..=90).map(|gamma| gamma.to_string()).collect();
        let plane: Vec<String> = (0..=90)
            .map(|gamma| (300.0 * f64::from(gamma).to_radians().cos().powi(N)).to_string())
            .collect();
        let planes = [
            plane.join(" "),
            plane.join(" "),
            plane.join(" "),
            plane.join(" "),
            plane.join(" "),
        ];
        let file = format!(
            "IESNA:LM-63-2002\n[TEST] 1\n[TESTLAB] a\n[ISSUEDATE] b\n[MANUFAC] c\nTILT=NONE\n1 -1 1 91 5 1 2 0.1 0.1 0\n1 1 0\n\
             {}\n0 90 180 270 360\n{}\n",
            gammas.join(" "),
            planes.join("\n")
        );
        std::fs::write(keep.path().join("lamp.ies"), file).unwrap();
        let text = format!(
            "format = \"isolux-model/1\"\n[luminaire]\ndistribution = \"lamp.ies\"\n\
             [luminaire.u]\nintensity_rel = 0.004\nhalf_plane_lamp_s = {AGES_S:?}\n\
             [[effect]]\nname = \"lamp_drift\"\nrate_per_h = -0.001\nreference_s = 4700.0\nu = {{ rate_per_h = 0.0003 }}\n"
        );
        let model = Model::parse(&path, &text).unwrap();
        let read = |plane: usize, lamp_s: f64| ReadingCoordinates {
            c_deg: 90.0 * plane as f64,
            lamp_s: Some(lamp_s),
            ..at(40.0, 3700.0)
        };
        for (plane, age_s) in AGES_S.into_iter().enumerate() {
            let same = change_rel(&model, "rate_per_h", &read(plane, age_s))[0];
            assert!(same.abs() < 1e-6, "{plane}: {same}");
            let later = change_rel(&model, "rate_per_h", &read(plane, age_s + 3600.0))[0];
            assert!((later / 0.0003 - 1.0).abs() < 0.01, "{plane}: {later}");
        }
        // Of the warm-up the straight line that was taken for drift stays: with both exponentials it is steeper at first.
        let first = change_rel(&model, "warm-up", &read(0, 2000.0));
        let excess = 0.02 * (-2000.0_f64 / 600.0).exp();
        assert!(
            first[0] > 0.2 * excess && first[0] < 0.8 * excess,
            "{first:?} of {excess}"
        );
        let wrong = text.replace("7400.0]", "7400.0, 9000.0]");
        let error = Model::parse(&path, &wrong).unwrap_err().to_string();
        assert!(error.contains("5 ages for 4 half-planes"), "{error}");
    }

    #[test]
    fn the_rest_of_a_warm_up_is_a_tenth_of_a_per_cent_after_half_an_hour() {
        let model = model("[luminaire.u]\nintensity_rel = 0.004\n");
        let warm = ReadingCoordinates {
            lamp_s: Some(1800.0),
            ..at(20.0, 3700.0)
        };
        for change in change_rel(&model, "warm-up", &warm) {
            assert!((change / 1e-3 - 1.0).abs() < 0.15, "{change}");
        }
        let own = "[luminaire.u]\nintensity_rel = 0.004\n[[effect]]\nname = \"lamp_warmup\"\n\
                   amplitude_rel = 0.03\ntime_constant_s = 400.0\n";
        assert!(change_rel(&self::model(own), "warm-up", &warm).is_empty());
    }
}
