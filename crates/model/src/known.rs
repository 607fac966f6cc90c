//! What the file of a model states of its own uncertainty, as models that are off by it: the errors that all
//! predictions from one luminaire share.
//!
//! The noise of single directions is in [`crate::DirectionError`]; here is what many directions have in common. What is
//! stated of an effect (`[effect.u]`) counts too. Where a measured luminaire does not state its level or its γ, they
//! are taken as wide as a careless measurement leaves them, and [`KnownError::assumed`] says so.

mod lamp;

use isolux_photometry::{IntensityDistribution, direction};

use crate::emitter::Emitter;
use crate::luminaire::Luminaire;
use crate::model::Model;
use crate::prepared::PreparedModel;
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
const LEDS: usize = 12;
/// Standard uncertainty of the inward aim of the parts of a luminous area: those of ring lights lean by up to some eight
/// degrees, and the far field does not show by how much.
const AIM_DEG: f64 = 4.0;
/// Standard uncertainty of the square of the aim, in squares of [`AIM_DEG`]: √3 for a normal law.
const AIM_BEND: f64 = 1.732_050_807_568_877_2;
/// The same of the aim along a diameter against that across it: twenty-four LEDs whose aims differ by 1.5°.
const AIM_UNEVEN_DEG: f64 = 0.5;
/// Steps of C and γ at which two emitters' far fields are compared: what they differ by is as smooth as their lobes.
const STEP_DEG: [f64; 2] = [15.0, 2.5];
/// Largest factor between two emitters' far fields.
const MOST_CORRECTED: f64 = 1.5;
/// Relative amplitude of the light around the luminous area, in each of the first orders: twenty-four LEDs whose flux
/// differs by 5 %.
const AROUND_REL: f64 = 0.0145;
const AROUND_ORDERS: [f64; 2] = [1.0, 2.0];

/// Relative standard uncertainty of the light on the axis at `distance_mm` from a luminous area of which the diameter
/// alone is known, for a lobe of exponent n. The axis sees −½(n + 3)·r²/d², r² being the mean square radius; by the law
/// of the shares it is R²/2 with a standard deviation of R²/√(12·(1 + concentration)). Parts at r that lean inwards by ψ
/// add n·ψ·r/d.
pub fn luminous_area_rel(diameter_mm: f64, lobe_exponent: f64, distance_mm: f64) -> f64 {
    let reach = 0.5 * diameter_mm / distance_mm;
    let shares = 0.5 * (lobe_exponent + 3.0) * reach * reach / (12.0 * (1.0 + CONCENTRATION)).sqrt();
    let aim = lobe_exponent * AIM_DEG.to_radians() * reach / 2_f64.sqrt();
    shares.hypot(aim)
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
        let luminaire = self.luminaire();
        let (emitter, spectral) = (luminaire.emitter().clone(), luminaire.spectral().clone());
        Some(self.with_luminaire(Luminaire::new(moved, emitter, spectral)))
    }

    /// The same light at the distance at which it was measured, from another emitter.
    fn with_emitter(&self, emitter: Emitter, measured: Option<&Measured>) -> Self {
        let far = self.with_luminaire(self.luminaire().with_emitter(emitter.clone(), None));
        match measured.and_then(|measured| measured.factor(&far)) {
            Some(factor) => self.with_luminaire(self.luminaire().with_emitter(emitter, Some(factor))),
            None => far,
        }
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
        let measured = Measured::of(self);
        let measured = measured.as_ref();
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
            known.push(assumed(
                &format!(
                    "the share of the light from {:.0} to {:.0} mm of radius",
                    0.5 * edge_mm(ring),
                    0.5 * edge_mm(ring + 1)
                ),
                u_share,
                "",
                vec![(per_u, self.with_emitter(emitter, measured)), (-per_u, self.clone())],
            ));
        }
        known.extend(self.aim_errors(diameter_mm, measured));
        // The ring with the mean square radius of the whole area.
        let radius_mm = diameter_mm / 8_f64.sqrt();
        for order in AROUND_ORDERS {
            for wave in [f64::cos, f64::sin] {
                let uneven = |amplitude: f64| {
                    let weight = |azimuth: f64| 1.0 + amplitude * wave(order * azimuth);
                    self.with_emitter(uneven_circle(radius_mm, weight), measured)
                };
                let change = vec![(1.0, uneven(AROUND_REL)), (-1.0, uneven(0.0))];
                known.push(assumed("how even the luminous area is", AROUND_REL, "", change));
            }
        }
        known
    }

    /// The inward aim of the parts of a luminous area: on two circles that stand for an even area together, on one of
    /// them more than on the other, its square, and otherwise along one diameter than across.
    fn aim_errors(&self, diameter_mm: f64, measured: Option<&Measured>) -> Vec<KnownError> {
        // Gauss–Legendre of order 2 in the square of the radius.
        let circle_mm = |sign: f64| 0.5 * diameter_mm * (0.5 * (1.0 + sign / 3_f64.sqrt())).sqrt();
        let (inner_mm, outer_mm) = (circle_mm(-1.0), circle_mm(1.0));
        let circle = |radius_mm: f64, aim_deg: f64| {
            let emitter = Emitter::Leds {
                position_mm: Vec::new(),
                weight: Vec::new(),
                radius_mm: vec![radius_mm],
                count: vec![LEDS],
                aim_deg,
            };
            self.with_emitter(emitter, measured)
        };
        let lean = |factor: f64, radius_mm: f64| {
            let half = 0.5 * factor;
            [(half, circle(radius_mm, AIM_DEG)), (-half, circle(radius_mm, -AIM_DEG))]
        };
        let both = |inner: f64, outer: f64| [lean(inner, inner_mm), lean(outer, outer_mm)].concat();
        let bend = vec![
            (0.5 * AIM_BEND, circle(outer_mm, AIM_DEG)),
            (0.5 * AIM_BEND, circle(outer_mm, -AIM_DEG)),
            (-AIM_BEND, circle(outer_mm, 0.0)),
        ];
        let mut errors = vec![
            assumed("the inward aim of the parts", AIM_DEG, "°", both(0.5, 0.5)),
            assumed("where the parts lean inwards", AIM_DEG, "°", both(-1.0, 1.0)),
            assumed("the square of the inward aim", AIM_DEG, "°", bend),
        ];
        for from_deg in [0.0, 45.0] {
            let pair = |at_deg: f64, aim_deg: f64| {
                let place = |turn: f64| {
                    let (sin, cos) = (at_deg + turn).to_radians().sin_cos();
                    vec![outer_mm * cos, outer_mm * sin]
                };
                let emitter = Emitter::Leds {
                    position_mm: vec![place(0.0), place(180.0)],
                    weight: Vec::new(),
                    radius_mm: Vec::new(),
                    count: Vec::new(),
                    aim_deg,
                };
                self.with_emitter(emitter, measured)
            };
            let across = from_deg + 90.0;
            let change = vec![
                (0.25, pair(from_deg, AIM_UNEVEN_DEG)),
                (-0.25, pair(from_deg, -AIM_UNEVEN_DEG)),
                (-0.25, pair(across, AIM_UNEVEN_DEG)),
                (0.25, pair(across, -AIM_UNEVEN_DEG)),
            ];
            errors.push(assumed("how evenly the parts lean", AIM_UNEVEN_DEG, "°", change));
        }
        errors
    }
}

/// An error that the file does not state.
fn assumed(what: &str, u: f64, unit: &'static str, change: Vec<(f64, Model)>) -> KnownError {
    KnownError {
        what: what.to_owned(),
        u,
        unit,
        assumed: true,
        change,
    }
}

/// What the emitter of a model shows where its intensities were measured: another emitter that is to agree with that
/// measurement has another far field.
struct Measured {
    distance_mm: f64,
    c_deg: Vec<f64>,
    gamma_deg: Vec<f64>,
    illuminance_lx: Vec<f64>,
}

impl Measured {
    /// None where the file does not say at which distance it was measured.
    fn of(model: &Model) -> Option<Self> {
        let distribution = model.luminaire().distribution();
        let gamma_deg = distribution.gamma_deg();
        let (first, last) = (gamma_deg[0], gamma_deg[gamma_deg.len() - 1]);
        let steps = ((last - first) / STEP_DEG[1]).ceil().max(1.0);
        let planes = distribution.c_deg().len().min((360.0 / STEP_DEG[0]) as usize);
        let mut measured = Self {
            distance_mm: model.uncertainty()?.measured_at_mm.filter(|mm| *mm > 0.0)?,
            c_deg: (0..planes).map(|k| 360.0 * k as f64 / planes as f64).collect(),
            gamma_deg: (0..=steps as usize)
                .map(|k| first + (last - first) * k as f64 / steps)
                .collect(),
            illuminance_lx: Vec::new(),
        };
        measured.illuminance_lx = measured.shown_lx(model);
        Some(measured)
    }

    /// The light of the luminaire alone in every direction, `[ic * ng + ig]`.
    fn shown_lx(&self, model: &Model) -> Vec<f64> {
        let bare = model.with_effects(Vec::new()).with_refined(Refined::default());
        let prepared = PreparedModel::new(&bare);
        let directions = self
            .c_deg
            .iter()
            .flat_map(|c| self.gamma_deg.iter().map(move |gamma| (c, gamma)));
        let lux = |(c_deg, gamma_deg): (&f64, &f64)| {
            let out = direction(*c_deg, *gamma_deg);
            prepared.illuminance_lx(self.distance_mm * out, out)
        };
        directions.map(lux).collect()
    }

    /// By what the far field of `other` is to be multiplied in each direction to agree; none where there is nothing to
    /// be done.
    fn factor(&self, other: &Model) -> Option<IntensityDistribution> {
        // Where there is next to no light the one is many times the other, and it does not matter.
        let factor = |(own, other): (&f64, f64)| {
            let factor = own / other;
            if (1.0 / MOST_CORRECTED..=MOST_CORRECTED).contains(&factor) {
                factor
            } else {
                1.0
            }
        };
        let factors = self
            .illuminance_lx
            .iter()
            .zip(self.shown_lx(other))
            .map(factor)
            .collect();
        IntensityDistribution::new(self.c_deg.clone(), self.gamma_deg.clone(), factors).ok()
    }
}

/// LEDs evenly on a circle, weighted by their azimuth in rad.
fn uneven_circle(radius_mm: f64, weight: impl Fn(f64) -> f64) -> Emitter {
    let azimuths: Vec<f64> = (0..LEDS)
        .map(|led| std::f64::consts::TAU * led as f64 / LEDS as f64)
        .collect();
    Emitter::Leds {
        position_mm: azimuths
            .iter()
            .map(|at| vec![radius_mm * at.cos(), radius_mm * at.sin()])
            .collect(),
        weight: azimuths.iter().map(|at| weight(*at)).collect(),
        radius_mm: Vec::new(),
        count: Vec::new(),
        aim_deg: 0.0,
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
