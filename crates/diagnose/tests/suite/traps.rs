//! Mistakes that a diagnosis can make, one test each, on a bench of a few lines with a known law.

use isolux_diagnose::alternatives::alternatives;
use isolux_diagnose::forward::{Forward, Hypothesis, Searchable, Spread};
use isolux_diagnose::reference::Errors;
use isolux_diagnose::search::{Label, Outcome, Settings, search};
use isolux_diagnose::table::{Light, ObservationKind, Row};
use nalgebra::DVector;
use rand::{RngExt as _, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rand_distr::StandardNormal;

/// A lamp of intensity cos γ at 1 m; half-planes scanned one after the other, dark readings at both ends.
struct Toy {
    rows: Vec<Row>,
    effects: Vec<Searchable>,
    /// The warm-up of the truth is not the formula of the effect: a share of it is slower.
    true_second: f64,
    /// What the noise of the model's own distribution does to the rows, where it is stated.
    errors: Errors,
}

const DRIFT: usize = 0;
const WARMUP: usize = 1;
const OFFSET: usize = 2;
const STRAY: usize = 3;
const ZERO: usize = 4;
const BACKLASH: usize = 5;

fn searchable(name: &'static str, step: f64, plausible: f64, one_sided: bool, shapes: Vec<Vec<f64>>) -> Searchable {
    let k = shapes[0].len();
    Searchable {
        name,
        step: vec![step],
        step_share: Vec::new(),
        least: 0.0,
        plausible: vec![plausible],
        limits: vec![(if one_sided { 0.0 } else { f64::NEG_INFINITY }, f64::INFINITY)],
        turns: false,
        one_by_one: false,
        period_of_signal: false,
        chosen_from: 0,
        one_sided,
        never_negative: false,
        bounds: vec![(30.0, 3000.0); k],
        assumed: vec![Spread::over(60.0, 1800.0); k],
        shape_step: vec![1.0; k],
        fixed: vec![false; k],
        oscillates: None,
        shapes,
    }
}

impl Toy {
    fn new(planes: u32, two_ways: bool, capped: bool) -> Self {
        let mut rows = Vec::new();
        let mut time_s = 100.0;
        let dark = |rows: &mut Vec<Row>, time_s: &mut f64| {
            for light in [Light::LampOff, Light::Capped] {
                for _ in 0..if capped { 6 } else { 0 } {
                    *time_s += 4.0;
                    rows.push(Row {
                        light,
                        time_s: *time_s,
                        ..Row::bare(ObservationKind::Reading, 0.0, 0.05)
                    });
                }
            }
        };
        dark(&mut rows, &mut time_s);
        for plane in 0..planes {
            let travel = if two_ways && plane % 2 == 1 { -1.0 } else { 1.0 };
            time_s += 20.0;
            for k in 0..29 {
                time_s += 4.0;
                let gamma_deg = travel * (5.0 * f64::from(k) - 70.0);
                let c_deg = 15.0 * f64::from(plane);
                rows.push(Row {
                    time_s,
                    c_deg,
                    gamma_deg,
                    travel,
                    ..Row::bare(ObservationKind::Reading, 0.0, 0.0)
                });
            }
        }
        dark(&mut rows, &mut time_s);
        let effects = vec![
            searchable("drift", 0.01, 0.02, false, vec![vec![]]),
            searchable("warmup", 0.01, 0.1, true, vec![vec![150.0], vec![400.0], vec![1000.0]]),
            searchable("offset", 0.1, 1.0, false, vec![vec![]]),
            searchable("stray", 0.1, 1.0, true, vec![vec![]]),
            searchable("zero", 0.05, 0.5, false, vec![vec![]]),
            searchable("backlash", 0.05, 0.3, false, vec![vec![]]),
        ];
        let mut toy = Self {
            rows,
            effects,
            true_second: 0.0,
            errors: Errors::new(),
        };
        let clean = toy.signal(&[], 0.0);
        for (row, lx) in toy.rows.iter_mut().zip(clean) {
            row.u = (0.004 * lx).hypot(0.05);
        }
        toy
    }

    fn signal(&self, hypotheses: &[Hypothesis], second: f64) -> Vec<f64> {
        let of = |effect: usize| hypotheses.iter().find(|h| h.effect == effect);
        let amount = |effect: usize| of(effect).map_or(0.0, |h| h.linear[0]);
        self.rows
            .iter()
            .map(|row| {
                let gamma = row.gamma_deg + amount(ZERO) + 0.5 * amount(BACKLASH) * row.travel;
                let mut lx = 100.0 * gamma.to_radians().cos().max(0.0).powi(3);
                lx *= 1.0 + amount(DRIFT) * row.time_s / 3600.0;
                if let Some(h) = of(WARMUP) {
                    let tau = h.shape[0];
                    let law = (1.0 - second) * (-row.time_s / tau).exp() + second * (-row.time_s / (4.0 * tau)).exp();
                    lx *= 1.0 + h.linear[0] * law;
                }
                let lamp = f64::from(row.light == Light::Lit);
                let room = f64::from(row.light != Light::Capped);
                let direct = if lx.is_finite() { lamp * lx.max(0.0) } else { 0.0 };
                direct + amount(STRAY) * room + amount(OFFSET)
            })
            .collect()
    }

    /// Rows with the hidden effects and AR(1) noise, in units of the stated uncertainty.
    fn measured(&self, hidden: &[Hypothesis], rho: f64, seed: u64) -> Vec<Row> {
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        let mut last: f64 = rng.sample(StandardNormal);
        let truth = self.signal(hidden, self.true_second);
        self.rows
            .iter()
            .zip(truth)
            .map(|(row, lx)| {
                let noise = last;
                let fresh: f64 = rng.sample(StandardNormal);
                last = rho * last + (1.0 - rho * rho).sqrt() * fresh;
                Row {
                    measured: lx + row.u * noise,
                    ..*row
                }
            })
            .collect()
    }

    fn diagnose(&self, rows: &[Row]) -> Outcome {
        search(
            self,
            rows,
            &Settings {
                nulls: 500,
                ..Settings::default()
            },
        )
        .expect("the toy predicts everything")
    }
}

impl Forward for Toy {
    fn nuisances(&self) -> usize {
        3
    }

    fn common_errors(&self) -> Errors {
        self.errors.clone()
    }

    fn effects(&self) -> &[Searchable] {
        &self.effects
    }

    fn predict(&self, nuisance: &[f64], hypotheses: &[Hypothesis]) -> Option<DVector<f64>> {
        let added: f64 = [OFFSET]
            .iter()
            .filter_map(|&e| hypotheses.iter().find(|h| h.effect == e))
            .map(|h| h.linear[0])
            .sum();
        let signal = self.signal(hypotheses, 0.0);
        let values = self.rows.iter().zip(signal).map(|(row, lx)| {
            let x2 = (row.gamma_deg / 90.0).powi(2);
            let shape = if row.gamma_deg.is_finite() {
                nuisance[0] + nuisance[1] * x2 + nuisance[2] * x2 * x2
            } else {
                0.0
            };
            (lx - added) * shape.exp() + added
        });
        Some(DVector::from_iterator(
            self.rows.len(),
            values.map(|v| if v.is_finite() { v } else { 0.0 }),
        ))
    }
}

fn hidden(effect: usize, amount: f64, shape: &[f64]) -> Hypothesis {
    Hypothesis {
        effect,
        linear: vec![amount],
        shape: shape.to_vec(),
    }
}

fn names(toy: &Toy, outcome: &Outcome) -> Vec<&'static str> {
    outcome
        .after
        .hypotheses
        .iter()
        .map(|h| toy.effects[h.effect].name)
        .collect()
}

/// A noisy reading used as a coordinate finds effects in pure noise: the level must be the model's.
#[test]
fn the_level_is_the_models() {
    let toy = Toy::new(6, true, true);
    let level = toy.signal(&[], 0.0);
    let order: Vec<usize> = (0..toy.rows.len()).collect();
    let (one, two) = (toy.measured(&[], 0.0, 1), toy.measured(&[], 0.0, 2));
    let values = |rows: &[Row]| -> Vec<f64> {
        let patterns = alternatives(rows, &level, &order);
        let columns = patterns.iter().flat_map(|alternative| &alternative.columns);
        columns.flat_map(|column| column.values(rows)).collect()
    };
    assert!(values(&one) == values(&two), "no pattern depends on what was read");
}

/// Correlated noise that nobody modelled makes almost every clean scan a discovery.
#[test]
fn correlated_noise_is_no_effect() {
    let toy = Toy::new(8, true, true);
    let alarms = (0..24)
        .filter(|&seed| toy.diagnose(&toy.measured(&[], 0.5, 100 + seed)).p_global <= 0.01)
        .count();
    assert!(alarms <= 2, "{alarms} of 24 clean scans with ρ = 0.5 raised an alarm");
}

/// A reference of one reading a direction is wrong there by its noise, however often the bench looks again: that is no
/// effect of the bench.
#[test]
fn noise_of_the_reference_is_no_effect() {
    let mut toy = Toy::new(8, true, true);
    let plain = toy.signal(&[], 0.0);
    let directions: Vec<Vec<usize>> = (0..29)
        .map(|k| {
            let at = |row: &Row| row.light == Light::Lit && (row.gamma_deg - (5.0 * f64::from(k) - 70.0)).abs() < 1.0;
            (0..toy.rows.len()).filter(|&i| at(&toy.rows[i])).collect()
        })
        .collect();
    let errors: Errors = directions
        .iter()
        .map(|rows| rows.iter().map(|&i| (i, 0.005 * plain[i])).collect())
        .collect();
    let mut alarms = [0, 0];
    for seed in 0..8 {
        let mut rng = ChaCha8Rng::seed_from_u64(900 + seed);
        let mut rows = toy.measured(&[], 0.0, 700 + seed);
        for error in &errors {
            let off: f64 = rng.sample(StandardNormal);
            for &(i, u) in error {
                rows[i].measured += u * off;
            }
        }
        for (stated, alarms) in alarms.iter_mut().enumerate() {
            toy.errors = if stated == 1 { errors.clone() } else { Errors::new() };
            *alarms += usize::from(toy.diagnose(&rows).p_global <= 0.01);
        }
    }
    assert!(alarms[0] >= 6, "{} of 8 unstated", alarms[0]);
    assert!(alarms[1] <= 1, "{} of 8 stated", alarms[1]);
}

/// Two names that explain the same stay in one set, however much more is assumed of the one: no claim is surer than the
/// data.
#[test]
fn no_prior_settles_what_the_data_cannot() {
    let mut toy = Toy::new(8, false, true);
    // Backlash in one direction of travel is a zero error. Sixty shapes that are all alike, and small for what it
    // mostly is: assumed 300 times less.
    toy.effects[BACKLASH] = Searchable {
        fixed: vec![true],
        least: 10.0,
        ..searchable("backlash", 0.05, 0.3, false, vec![vec![100.0]; 60])
    };
    let outcome = toy.diagnose(&toy.measured(&[hidden(ZERO, 0.1, &[])], 0.0, 3));
    let ranked = &outcome.comparisons[0].ranked;
    let both: Vec<f64> = [ZERO, BACKLASH]
        .iter()
        .map(|&effect| {
            let one = ranked.iter().find(|one| one.label == Label::Named(effect));
            one.map_or(0.0, |one| one.posterior)
        })
        .collect();
    assert!(both.iter().all(|posterior| *posterior > 0.05), "{both:?}");
}

/// Dark readings that the model expects alike, and an effect lifts by different amounts, are rounded each in its own
/// way.
#[test]
fn rounding_goes_by_the_levels_that_were_found() {
    const DIGIT: f64 = 0.1;
    let mut toy = Toy::new(8, true, true);
    for row in toy.rows.iter_mut().filter(|row| row.light != Light::Lit) {
        (row.digit, row.u) = (DIGIT, 0.04);
    }
    let mut rows = toy.measured(&[hidden(STRAY, 0.43, &[]), hidden(OFFSET, 0.33, &[])], 0.0, 4);
    for row in rows.iter_mut().filter(|row| row.light != Light::Lit) {
        let level = if row.light == Light::Capped { 0.33 } else { 0.76 };
        row.measured = (level / DIGIT).round() * DIGIT;
    }
    let outcome = toy.diagnose(&rows);
    let place = outcome
        .after
        .hypotheses
        .iter()
        .position(|member| member.effect == STRAY);
    let first = outcome.after.nuisance.len();
    let variance = outcome.after.covariance(1.0).diagonal()[first + place.expect("stray light was found")];
    // Ambient light is the difference of two levels, each known to a digit over √12 = 0.029.
    assert!(variance.sqrt() > 0.03, "u = {}", variance.sqrt());
}

/// Thresholds on single tests raise alarms by the dozen; the whole scan's own noise does not.
#[test]
fn clean_data_stay_clean() {
    let toy = Toy::new(8, true, true);
    let alarms = (0..24)
        .filter(|&seed| toy.diagnose(&toy.measured(&[], 0.0, 200 + seed)).p_global <= 0.01)
        .count();
    assert!(alarms <= 1, "{alarms} of 24 clean scans raised an alarm");
}

/// Smooth terms follow most of what a few readings say, and a fit without them leaves it: that is no misfit.
#[test]
fn a_few_readings_are_no_misfit() {
    let mut toy = Toy::new(8, true, true);
    let mut number = 0;
    toy.rows.retain(|_| {
        number += 1;
        number % 13 == 0
    });
    let settings = Settings {
        nulls: 500,
        fit_scale: false,
        ..Settings::default()
    };
    let wrong = (0..24)
        .map(|seed| search(&toy, &toy.measured(&[], 0.0, 300 + seed), &settings).unwrap())
        .filter(|outcome| outcome.p_global > 0.01 && outcome.unexplained.is_some())
        .count();
    assert_eq!(wrong, 0, "of 24 clean scans of {} readings", toy.rows.len());
}

/// A formula that is a little wrong leaves a remainder at high significance: it is no second effect.
#[test]
fn a_rough_formula_makes_no_second_effect() {
    let toy = Toy {
        true_second: 0.1,
        ..Toy::new(8, true, true)
    };
    let outcome = toy.diagnose(&toy.measured(&[hidden(WARMUP, 0.08, &[400.0])], 0.0, 5));
    assert_eq!(names(&toy, &outcome), ["warmup"]);
    assert!(outcome.unexplained.is_none());
}

/// Opposite offsets cancel on lit readings; the dark records see both.
#[test]
fn opposite_offsets_are_both_found() {
    let toy = Toy::new(8, true, true);
    let pair = [hidden(STRAY, 0.4, &[]), hidden(OFFSET, -0.4, &[])];
    let outcome = toy.diagnose(&toy.measured(&pair, 0.0, 9));
    let mut found = names(&toy, &outcome);
    found.sort_unstable();
    assert_eq!(found, ["offset", "stray"]);
}

/// Identical twins to first order: the answer is a set, not a name.
#[test]
fn twins_make_a_set() {
    let toy = Toy::new(8, false, true);
    let outcome = toy.diagnose(&toy.measured(&[hidden(ZERO, 0.2, &[])], 0.0, 11));
    let top: Vec<usize> = outcome.comparisons[0]
        .ranked
        .iter()
        .take(2)
        .filter_map(|ranked| match ranked.label {
            Label::Named(effect) => Some(effect),
            Label::Unnamed(_) => None,
        })
        .collect();
    assert!(top.contains(&ZERO) && top.contains(&BACKLASH));
    assert!(outcome.comparisons[0].ranked[0].posterior < 0.9);
    let both_ways = Toy::new(8, true, true);
    let outcome = both_ways.diagnose(&both_ways.measured(&[hidden(ZERO, 0.2, &[])], 0.0, 11));
    assert_eq!(names(&both_ways, &outcome), ["zero"]);
    assert!(
        outcome.comparisons[0].ranked[0].posterior > 0.9,
        "two directions of travel tell them apart"
    );
}

/// A shape that the data leave open wanders to the edge of what is plausible, and beyond: that must not count against
/// its name.
#[test]
fn an_open_shape_is_no_mark_against_a_name() {
    let toy = Toy::new(6, true, true);
    for seed in 20..24 {
        let outcome = toy.diagnose(&toy.measured(&[hidden(WARMUP, 0.06, &[1700.0])], 0.0, seed));
        let posterior = |effect: usize| {
            let of = |ranked: &&isolux_diagnose::search::Ranked| ranked.label == Label::Named(effect);
            outcome.comparisons[0]
                .ranked
                .iter()
                .find(of)
                .map_or(0.0, |ranked| ranked.posterior)
        };
        assert!(
            posterior(WARMUP) > 0.05,
            "warm-up {}, drift {}",
            posterior(WARMUP),
            posterior(DRIFT)
        );
    }
}

/// What the data cannot show is listed, not silently absent.
#[test]
fn blind_spots_show() {
    let with = Toy::new(8, true, true);
    let without = Toy::new(8, true, false);
    let sigma = |toy: &Toy, effect: usize| {
        let outcome = toy.diagnose(&toy.measured(&[], 0.0, 3));
        outcome
            .visibility
            .iter()
            .find(|(e, ..)| *e == effect)
            .map_or(0.0, |(.., sigma)| *sigma)
    };
    assert!(
        sigma(&with, OFFSET) > 2.0 * sigma(&without, OFFSET),
        "dark records see an offset"
    );
}

/// Smooth terms explode where no reading holds them: nine even terms, a cone of 20° read densely and one angle far
/// out. The noise of the cone must not be blown up between the two.
#[test]
fn smooth_terms_do_not_run_away_off_the_data() {
    use isolux_diagnose::diagnosis::diagnose;
    use isolux_record::observation::{Need, open};
    use std::fmt::Write as _;

    let folder = tempfile::tempdir().unwrap();
    let path = |name: &str| camino::Utf8PathBuf::try_from(folder.path().join(name)).unwrap();
    let truth = |gamma: f64| 400.0 * gamma.to_radians().cos().max(0.0).powf(3.2);
    let mut csv = String::from("gamma_deg,intensity_cd\n");
    for gamma in 0..=90 {
        let wrong = 1.0 + 0.02 * (f64::from(gamma) / 30.0).sin();
        let _ = writeln!(csv, "{gamma},{}", wrong * truth(f64::from(gamma)));
    }
    std::fs::write(path("distribution.csv"), csv).unwrap();
    let model = "format = \"isolux-model/1\"\n[luminaire]\ndistribution = \"distribution.csv\"\n[luminaire.trust]\nshape = \"smooth\"\n";
    std::fs::write(path("model.toml"), model).unwrap();
    let mut rng = ChaCha8Rng::seed_from_u64(3);
    let mut csv = String::from(
        "index,block,kind,time_s,c_deg,gamma_deg,distance_mm,travel,range,ambient_c,illuminance_lx,u_lx\n",
    );
    for i in 0..120_u32 {
        let gamma = if i % 12 == 11 { 70.0 } else { 2.0 * f64::from(i % 12) };
        let lx = truth(gamma) / 4.0;
        let read = lx * (1.0 + 0.004 * rng.sample::<f64, _>(StandardNormal));
        let _ = writeln!(
            csv,
            "{i},A,lit,{},{},{gamma},2000,1,1,25,{read:.6},{:.6}",
            4 * i,
            15 * (i / 12),
            0.004 * lx
        );
    }
    std::fs::write(path("readings.csv"), csv).unwrap();
    let model = isolux_model::Model::load(&path("model.toml")).unwrap();
    let observations = open(&path("readings.csv"), Need::Values).unwrap();
    let settings = Settings {
        nulls: 200,
        ..Settings::default()
    };
    let found = diagnose(&model, &[observations], None, "", &settings).unwrap();
    let distribution = found.baseline.distribution().unwrap();
    for gamma in [10.0, 30.0, 40.0, 50.0, 60.0, 80.0] {
        let ratio = distribution.intensity_cd_at(0.0, gamma) / truth(gamma);
        assert!((ratio - 1.0).abs() < 0.2, "γ {gamma}: {ratio}");
    }
}
