//! Runs made from closed forms, reduced.

mod meter;
mod missing;
mod partial;
mod rated;
mod shapes;

use camino::Utf8Path;
use isolux_any_record::{PLAN, STATION, lamp, reading, run};
use isolux_model::{Emitter, Luminaire, Model, Spectral};
use isolux_record::run::Run;
use isolux_record::{Plan, Quality, Reading, ReadingKind, Role, Station};

use isolux_reduce::{Correction, Drift, Options, ReduceError, Reduction, noise_of_directions, reduce};

fn rounded(lux: f64) -> f64 {
    (lux * 100.0).round() / 100.0
}

/// A grid as the day has it, with offset 0.05, ambient 0.02, stray 0.03·(1 − γ/360°) lx, and 1 %/h of drift.
fn day(display: impl Fn(f64) -> f64, drift_per_h: f64) -> Vec<Reading> {
    let mut rows = Vec::new();
    let stray = |gamma: f64| 0.03 * (1.0 - gamma / 360.0);
    let mut time = 1800.0;
    for plane in 0..=24 {
        let c = 15.0 * f64::from(plane);
        let level = |time: f64| 1.0 + drift_per_h * (time - 1800.0) / 3600.0;
        let illuminated =
            |gamma: f64, time: f64| display(0.05 + 0.02 + (stray(gamma) + lamp(c, gamma) / 100.0) * level(time));
        rows.push(Reading {
            role: Role::Reference,
            time_s: Some(time),
            c_deg: 0.0,
            c_target_deg: 0.0,
            ..reading(0.0, 0.0, illuminated(0.0, time))
        });
        for step in 0..=90 {
            time += 4.0;
            let gamma = 2.0 * f64::from(step);
            rows.push(Reading {
                time_s: Some(time),
                ..reading(c, gamma, illuminated(gamma, time))
            });
        }
    }
    for repeat in 0..20 {
        let of = |kind, lux| Reading {
            kind,
            repeat,
            time_s: Some(time),
            ..reading(0.0, 0.0, display(lux))
        };
        rows.push(of(ReadingKind::Capped, 0.05));
        rows.push(of(ReadingKind::LampOff, 0.07));
    }
    for step in 0..=18 {
        let gamma = 10.0 * f64::from(step);
        rows.push(Reading {
            kind: ReadingKind::Baffled,
            time_s: Some(time),
            ..reading(0.0, gamma, display(0.07 + stray(gamma)))
        });
    }
    rows
}

fn reduced(rows: Vec<Reading>, without: &[Correction]) -> Reduction {
    let options = Options {
        without: without.iter().copied().collect(),
        accept_drift: None,
    };
    reduce(&run(rows), &options, None).unwrap()
}

/// As [`reduced`], with a drift beyond the limits.
fn accepted(rows: Vec<Reading>, without: &[Correction]) -> Reduction {
    let options = Options {
        without: without.iter().copied().collect(),
        accept_drift: Some("a test".to_owned()),
    };
    reduce(&run(rows), &options, None).unwrap()
}

/// The model file of a reduction.
fn model_file(reduction: &Reduction, run: &Run) -> toml::Table {
    let files = isolux_reduce::files(reduction, run, &[], "isolux test").unwrap();
    let model = files.iter().find(|file| file.name == "luminaire.model.toml").unwrap();
    std::str::from_utf8(&model.bytes).unwrap().parse().unwrap()
}

#[test]
fn every_correction_brings_the_flux_home() {
    let exact = std::f64::consts::PI * 337.0;
    // Values that were not rounded need no smoothing, though they state a digit.
    let raw = Correction::Smoothing;
    let full = reduced(day(|lux| lux, 0.0), &[raw]);
    assert!((full.flux.value / exact - 1.0).abs() < 3e-4, "{}", full.flux.value);
    assert_eq!(full.grid.distribution.c_deg().len(), 24);
    let sphere_lm_per_lx = 4.0 * std::f64::consts::PI * 100.0;
    let without = |correction| reduced(day(|lux| lux, 0.0), &[raw, correction]).flux.value - full.flux.value;
    assert!((without(Correction::Dark) - 0.05 * sphere_lm_per_lx).abs() < 1e-6);
    assert!((without(Correction::Ambient) - 0.02 * sphere_lm_per_lx).abs() < 1e-6);
    assert!((without(Correction::Stray) / (0.0225 * sphere_lm_per_lx) - 1.0).abs() < 1e-9);
    let drifting = accepted(day(|lux| lux, -0.02), &[]);
    assert!(
        // 2 % of the first level are 2.05 % of the middle one, and the baffled readings did not see the drift of the
        // stray.
        matches!(drifting.drift, Drift::Linear { rate_per_h, .. } if (rate_per_h + 0.0207).abs() < 1e-4),
        "{:?}",
        drifting.drift
    );
    // The middle of the scan is the level that the result belongs to.
    let middle = 1.0 - 0.02 * 2275.0 * 4.0 / 2.0 / 3600.0;
    assert!((drifting.flux.value / (exact * middle) - 1.0).abs() < 1e-3);
    let closing = drifting.closing.unwrap();
    assert!(closing.rms_cd < 0.2, "{closing:?}");
    let uncorrected = accepted(day(|lux| lux, -0.02), &[Correction::Drift]).closing.unwrap();
    assert!(
        uncorrected.max_cd < -15.0 && uncorrected.max_gamma_deg == 0.0,
        "{uncorrected:?}"
    );
}

#[test]
fn the_digit_of_the_dark_stands_in_the_budget_of_the_flux() {
    let dark_digit_lm = 0.01 / 12.0_f64.sqrt() * 100.0 * 4.0 * std::f64::consts::PI;
    let result = reduced(day(rounded, 0.0), &[]);
    // 20 repeats of the dark and 19 of the baffled reading do not reduce it: 3.6 lm.
    assert!(
        (result.flux.parts["dark_digit"] / dark_digit_lm - 1.0).abs() < 1e-6,
        "{:?}",
        result.flux.parts
    );
    let u = result.flux.u.unwrap();
    assert!(u >= result.flux.parts["dark_digit"]);
    // On one point the same digit is 0.29 cd, on the flux it is common to all of them.
    assert!((result.i_max.parts["dark_digit"] / (0.01 / 12.0_f64.sqrt() * 100.0) - 1.0).abs() < 1e-9);
    // Behind the lamp every display is the same, so half the sphere is rounded alike.
    assert!(result.flux.parts["digit"] > 0.45 * dark_digit_lm);
    assert!((result.flux.parts["calibration"] / result.flux.value - 0.008).abs() < 1e-12);
    assert!((result.flux.parts["distance"] / result.flux.value - 0.001).abs() < 1e-12);
    let off = std::f64::consts::PI * 337.0 - result.flux.value;
    assert!(off.abs() < 3.0 * u, "{off} lm, u = {u} lm");
}

#[test]
fn the_stated_uncertainty_covers_the_scatter_of_many_days() {
    // Offset and ambient light take any value between two digits. The dark and the back of the lamp are rounded alike,
    // so that their errors partly cancel; the budget adds them as if they did not, and may not state too little.
    let mut worst = 0.0_f64;
    let mut squares = 0.0;
    let count = 60;
    for trial in 0..count {
        let shift = 0.01 * ((f64::from(trial) * 0.618_033_988_75) % 1.0) - 0.005;
        let result = reduced(day(|lux| rounded(lux + shift), 0.0), &[]);
        let u = result.flux.parts["dark_digit"].hypot(result.flux.parts["digit"]);
        let z = (result.flux.value - std::f64::consts::PI * 337.0) / u;
        worst = worst.max(z.abs());
        squares += z * z / f64::from(count);
    }
    assert!(worst < 2.0 && squares < 1.0, "worst {worst}, mean square {squares}");
    assert!(
        squares > 1e-3,
        "an error that is a thousandth of its uncertainty is no test: {squares}"
    );
}

#[test]
fn poles_have_one_value_and_displaced_readings_go_home() {
    let mut rows = day(|lux| lux, 0.0);
    for row in &mut rows {
        // The axes stand 0.2° beside the plan, and what was read is light of where they stand.
        if row.kind == ReadingKind::Lit && row.role == Role::Point {
            row.gamma_deg = row.gamma_target_deg + 0.2;
            row.illuminance_lx =
                Some(0.07 + 0.03 * (1.0 - row.gamma_deg / 360.0) + lamp(row.c_deg, row.gamma_deg) / 100.0);
        }
    }
    let result = reduced(rows, &[Correction::Smoothing]);
    let distribution = &result.grid.distribution;
    for plane in 0..24 {
        assert_eq!(distribution.row(plane)[0], distribution.row(0)[0]);
    }
    for gamma in [10.0, 30.0, 60.0, 80.0] {
        let difference = distribution.intensity_cd_at(30.0, gamma) - lamp(30.0, gamma);
        assert!(difference.abs() < 0.02, "{difference} cd at {gamma}°");
    }
}

#[test]
fn a_model_of_nothing_changes_nothing_though_the_half_planes_differ_at_the_pole() {
    let run = run(day(rounded, -0.002));
    let plain = reduce(&run, &Options::default(), None).unwrap();
    let distribution = plain.grid.distribution.clone();
    let far_field = Model::of(Luminaire::new(distribution, Emitter::Point {}, Spectral::None));
    let with = reduce(&run, &Options::default(), Some(far_field)).unwrap();
    assert!(plain.grid.pole_spread_cd[0] > 0.1, "{:?}", plain.grid.pole_spread_cd);
    for (a, b) in with
        .grid
        .distribution
        .intensity_cd()
        .iter()
        .zip(plain.grid.distribution.intensity_cd())
    {
        assert!((a - b).abs() < 1e-9 * 337.0, "{a} {b}");
    }
}

#[test]
fn a_run_with_a_hole_gives_no_file_that_looks_whole() {
    let mut rows = day(|lux| lux, 0.0);
    rows[500].quality = Quality::OverRange;
    rows[500].illuminance_lx = None;
    let error = reduce(&run(rows), &Options::default(), None).unwrap_err();
    assert!(
        matches!(
            error,
            ReduceError::Missing {
                missing: 1,
                expected: 2275,
                ..
            }
        ),
        "{error}"
    );
    let mut cut = day(|lux| lux, 0.0);
    cut.truncate(700);
    assert!(matches!(
        reduce(&run(cut), &Options::default(), None).unwrap_err(),
        ReduceError::NoGrid { .. }
    ));
    assert!(matches!(
        reduce(&run(Vec::new()), &Options::default(), None).unwrap_err(),
        ReduceError::NoLight
    ));
}

#[test]
fn the_same_run_gives_the_same_bytes_and_the_file_the_same_flux() {
    let run = run(day(rounded, 0.0));
    let make = || {
        let result = reduce(&run, &Options::default(), None).unwrap();
        let files = isolux_reduce::files(
            &result,
            &run,
            &[("readings.csv".to_owned(), vec![1, 2, 3])],
            "isolux test",
        )
        .unwrap();
        (result, files)
    };
    let (result, first) = make();
    assert_eq!(first, make().1);
    let ldt = first.iter().find(|file| file.name == "luminaire.ldt").unwrap();
    let (read, findings) = isolux_formats::Distribution::load(&ldt.bytes, "luminaire.ldt").unwrap();
    // Intensities below zero are written as zero, and the budget says what that adds.
    let budget = first.iter().find(|file| file.name == "budget.json").unwrap();
    let budget: serde_json::Value = serde_json::from_slice(&budget.bytes).unwrap();
    let written_lm = result.flux.value + budget["flux_added_by_them_lm"].as_f64().unwrap();
    assert!(
        (read.intensity.flux_lm() / written_lm - 1.0).abs() < 1e-6,
        "{findings:?}"
    );
}

#[test]
fn readings_are_intervals_and_the_raw_distribution_stays_beside_the_smoothed_one() {
    let rows = || run(day(rounded, 0.0));
    let of = |without: &[Correction]| {
        let options = Options {
            without: without.iter().copied().collect(),
            accept_drift: None,
        };
        reduce(&rows(), &options, None).unwrap()
    };
    let (smooth, raw) = (of(&[]), of(&[Correction::Smoothing]));
    let (kept, facts) = smooth.grid.smoothed.as_ref().unwrap();
    assert_eq!(kept, &raw.grid.distribution);
    assert!(raw.grid.smoothed.is_none());
    assert!(facts.rms_cd > 0.0 && facts.max_of_half_width <= 1.0, "{facts:?}");
    // The difference is a part of every number that rests on the distribution.
    for (with, without) in [
        (&smooth.flux, &raw.flux),
        (&smooth.sensor_illuminance, &raw.sensor_illuminance),
    ] {
        let moved = (with.value - without.value).abs();
        assert!((with.parts["smoothing"] - moved).abs() < 1e-9 * with.value, "{with:?}");
        assert!(!without.parts.contains_key("smoothing"));
    }
    // What each direction has on its own is not stated smaller.
    assert_eq!(noise_of_directions(&smooth.grid), noise_of_directions(&raw.grid));
    let writes_raw = |reduction: &Reduction| {
        let files = isolux_reduce::files(reduction, &rows(), &[], "isolux test").unwrap();
        files.iter().any(|file| file.name == "luminaire.raw.ldt")
    };
    assert!(writes_raw(&smooth) && !writes_raw(&raw));
}

#[test]
fn the_model_says_which_readings_its_distribution_was_made_of() {
    let mut rows = day(rounded, 0.0);
    // A direction's second reading failed, and made nothing.
    rows.insert(
        92,
        Reading {
            quality: Quality::Failed,
            illuminance_lx: None,
            ..rows[91].clone()
        },
    );
    let run = run(rows);
    let result = reduce(&run, &Options::default(), None).unwrap();
    let model = model_file(&result, &run);
    // A visit to the reference point, 91 γ, and so on; neither the closing half-plane nor what is dark.
    let first = |plane: i64| 92 * plane + if plane == 0 { 1 } else { 2 };
    let expected: Vec<toml::Value> = (0..24)
        .map(|plane| toml::Value::from(vec![first(plane), first(plane) + 90]))
        .collect();
    assert_eq!(
        model["luminaire"]["provenance"]["distribution_rows"].as_array(),
        Some(&expected)
    );
}

#[test]
fn the_drift_that_was_taken_out_stands_in_the_model() {
    let falling = run(day(rounded, -0.01));
    let result = reduce(&falling, &Options::default(), None).unwrap();
    let Drift::Linear {
        rate_per_h, centre_s, ..
    } = result.drift
    else {
        panic!("{:?}", result.drift);
    };
    let files = isolux_reduce::files(&result, &falling, &[], "isolux test").unwrap();
    let model = files.iter().find(|file| file.name == "luminaire.model.toml").unwrap();
    let text = std::str::from_utf8(&model.bytes).unwrap();
    assert!(
        text.contains(&format!(
            "name = \"lamp_drift\"\nrate_per_h = {rate_per_h:.8}\nreference_s = {centre_s:.3}\n"
        )),
        "{text}"
    );
    // A steady lamp has none, but what the visits leave open.
    let steady = run(day(rounded, 0.0));
    let result = reduce(&steady, &Options::default(), None).unwrap();
    let Drift::None { u_rate_per_h, .. } = result.drift else {
        panic!("{:?}", result.drift);
    };
    let model = model_file(&result, &steady);
    let effects = model["effect"].as_array().unwrap();
    let drift = effects
        .iter()
        .find(|effect| effect["name"].as_str() == Some("lamp_drift"))
        .unwrap();
    assert_eq!(drift["rate_per_h"].as_float(), Some(0.0));
    let u = drift["u"]["rate_per_h"].as_float().unwrap();
    assert!(u > 0.0 && (u - u_rate_per_h).abs() < 1e-8, "{u} {u_rate_per_h}");
    let ages = model["luminaire"]["u"]["half_plane_lamp_s"].as_array().unwrap();
    let ages: Vec<f64> = ages.iter().filter_map(toml::Value::as_float).collect();
    assert!(
        ages.len() == 24 && ages.windows(2).all(|pair| pair[0] < pair[1]),
        "{ages:?}"
    );
    let u = &model["luminaire"]["u"];
    let shares = u["direction_share"].as_array().unwrap();
    let of_mean = u["mean_share"].as_float().unwrap();
    // The mean of 24 half-planes is known better than each of them and keeps more of what was read.
    assert!(shares[0].as_float().unwrap() < of_mean && of_mean < 1.0, "{u:?}");
}

/// The readings of a plan of four half-planes, 3 lx each, `repeats` for every block.
fn planned(blocks: &[(&str, &str, f64, usize)]) -> Run {
    let plan = blocks.iter().fold(
        "format = \"isolux-plan/1\"\n".to_owned(),
        |text, (name, angles, distance_mm, _)| {
            text + &format!("[[block]]\nname = \"{name}\"\nkind = \"lit\"\ndistance_mm = {distance_mm:?}\n{angles}\n")
        },
    );
    let plan = Plan::parse(Utf8Path::new("p.toml"), &plan).unwrap();
    let mut rows = Vec::new();
    for (block, (name, _, distance_mm, repeats)) in plan.blocks().iter().zip(blocks) {
        for (&c, &gamma) in block
            .c_deg
            .iter()
            .flat_map(|c| block.gamma_deg.iter().map(move |gamma| (c, gamma)))
        {
            rows.extend((0..*repeats).map(|_| Reading {
                block: (*name).to_owned(),
                distance_mm: *distance_mm,
                ..reading(c, gamma, 3.0 * (10_000.0 / distance_mm).powi(2))
            }));
        }
    }
    let mut run = run(rows);
    run.header.plan = plan;
    run
}

const FOUR: &str = "c_deg = [0, 90, 180, 270]\ngamma_range = [0, 180, 10]";

#[test]
fn repeats_do_not_make_a_check_the_distribution() {
    let check = ("check", "c_deg = 0\ngamma_deg = [0, 5]", 5000.0, 200);
    let fine = ("fine", "c_deg = 0\ngamma_range = [0, 20, 1]", 10_000.0, 20);
    for other in [check, fine] {
        // Whichever was taken first.
        for blocks in [[("all", FOUR, 10_000.0, 1), other], [other, ("all", FOUR, 10_000.0, 1)]] {
            let result = reduce(&planned(&blocks), &Options::default(), None).unwrap();
            assert_eq!(result.grid.distribution.gamma_deg().len(), 19);
            assert!((result.flux.value / (1200.0 * std::f64::consts::PI) - 1.0).abs() < 1e-9);
            let note = format!("block {:?} ", other.0);
            assert!(
                result.notes.iter().any(|text| text.starts_with(&note)),
                "{:?}",
                result.notes
            );
        }
    }
}

#[test]
fn a_block_that_was_never_begun_is_missed() {
    let halves = [
        (
            "up",
            "c_deg = [0, 90, 180, 270]\ngamma_range = [0, 90, 10]",
            10_000.0,
            1,
        ),
        (
            "down",
            "c_deg = [0, 90, 180, 270]\ngamma_range = [100, 180, 10]",
            10_000.0,
            1,
        ),
        ("check", "c_deg = 0\ngamma_range = [1, 19, 2]", 10_000.0, 1),
        ("near", "c_deg = 0\ngamma_deg = 0", 1000.0, 1),
    ];
    let whole = planned(&halves);
    let result = reduce(&whole, &Options::default(), None).unwrap();
    assert_eq!(result.grid.distribution.gamma_deg().len(), 19);
    for read in [0, 3] {
        let mut cut = whole.clone();
        cut.readings.rows.truncate(40 + read);
        let error = reduce(&cut, &Options::default(), None).unwrap_err();
        assert!(
            matches!(&error, ReduceError::Unfinished { found, planned: 76 } if *found == 40 + read),
            "{error}"
        );
    }
    // Blocks beside the distribution take nothing from it.
    let mut early = whole.clone();
    early.readings.rows.truncate(76);
    let flux = reduce(&early, &Options::default(), None).unwrap().flux;
    assert!((flux.value - result.flux.value).abs() < 1e-9);
}

#[test]
fn a_signed_scan_beside_the_grid_is_left_out() {
    let rows_of = |blocks: &[(&str, &str, f64, usize)]| {
        let run = planned(blocks);
        let result = reduce(&run, &Options::default(), None).unwrap();
        let notes: Vec<String> = result
            .notes
            .iter()
            .filter(|note| note.starts_with("block "))
            .cloned()
            .collect();
        let model = model_file(&result, &run);
        let spans = model["luminaire"]["provenance"]["distribution_rows"]
            .as_array()
            .unwrap();
        let rows: i64 = spans
            .iter()
            .map(|span| 1 + span[1].as_integer().unwrap() - span[0].as_integer().unwrap())
            .sum();
        (rows, notes)
    };
    let all = ("lit", FOUR, 10_000.0, 1);
    // A repeat of the grid's own directions joins it.
    let again = ("again", "c_deg = 90\ngamma_deg = 10", 10_000.0, 1);
    assert_eq!(rows_of(&[all, again]), (77, Vec::new()));
    let signed = ("signed", "c_deg = 0\ngamma_deg = [-15, -5, 5, 15]", 10_000.0, 1);
    let (kept, notes) = rows_of(&[all, again, signed]);
    assert_eq!((kept, notes.len()), (77, 1));
    assert!(
        notes[0].starts_with("block \"signed\" (4 directions at 10000 mm)"),
        "{notes:?}"
    );
}

/// Half a grid in each of two burnings of the lamp: 3 % less light in the second, which falls by 1 %/h as the first
/// does.
fn relit(visits: impl Fn(usize) -> bool, off_between: bool, second_start_s: f64) -> Vec<Reading> {
    let mut rows = Vec::new();
    let level = |half: usize, time: f64| if half == 0 { 1.0 } else { 0.97 } * (1.0 - 0.01 * (time - 1800.0) / 3600.0);
    for (half, start_s) in [1800.0, second_start_s].into_iter().enumerate() {
        let mut time = start_s;
        for plane in 0..12 {
            let c = 180.0 * half as f64 + 15.0 * f64::from(plane);
            for step in 0..=18 {
                let gamma = 10.0 * f64::from(step);
                if step == 0 && visits(half) {
                    rows.push(Reading {
                        role: Role::Reference,
                        time_s: Some(time),
                        ..reading(0.0, 0.0, lamp(0.0, 0.0) / 100.0 * level(half, time))
                    });
                }
                time += 10.0;
                rows.push(Reading {
                    time_s: Some(time),
                    ..reading(c, gamma, lamp(c, gamma) / 100.0 * level(half, time))
                });
            }
        }
        if half == 0 && off_between {
            rows.push(Reading {
                kind: ReadingKind::LampOff,
                time_s: Some(time),
                ..reading(0.0, 0.0, 0.0)
            });
        }
    }
    rows
}

#[test]
fn a_lamp_that_was_switched_on_twice_leaves_no_step() {
    // A clock that starts again, in the resumed run and after lamp_off; and one that was read later than it ever stood
    // before.
    for (off_between, second_start_s) in [(false, 1800.0), (true, 1800.0), (true, 9000.0)] {
        // 5 % between the burnings is more than the limit. Of the distribution as it was read: smoothing moves it
        // within its digits.
        let result = accepted(relit(|_| true, off_between, second_start_s), &[Correction::Smoothing]);
        let Drift::ByBurning { burning, .. } = &result.drift else {
            panic!("{:?}", result.drift);
        };
        assert_eq!(burning.len(), 2);
        let distribution = &result.grid.distribution;
        let scale = distribution.intensity_cd_at(0.0, 20.0) / lamp(0.0, 20.0);
        for c in (0..24).map(|plane| 15.0 * f64::from(plane)) {
            let ratio = distribution.intensity_cd_at(c, 20.0) / lamp(c, 20.0) / scale;
            assert!((ratio - 1.0).abs() < 5e-4, "C {c}°: {ratio}");
        }
        assert!(
            result.notes.iter().any(|note| note.contains("switched on 2 times")),
            "{:?}",
            result.notes
        );
    }
    // The second half by no visits: its level is what it was, and that is said.
    let untied = reduced(relit(|half| half == 0, false, 1800.0), &[]);
    assert!(
        untied.notes.iter().any(|note| note.contains("from row 240 on")),
        "{:?}",
        untied.notes
    );
    let unknown = reduced(relit(|_| false, false, 1800.0), &[]);
    assert!(matches!(unknown.drift, Drift::Unknown { .. }));
    for tied_by_nothing in [&untied, &unknown] {
        assert_eq!(tied_by_nothing.flux.u, None, "{:?}", tied_by_nothing.flux);
    }
    assert!(
        unknown.notes.iter().any(|note| note.contains("no visit")),
        "{:?}",
        unknown.notes
    );
}

/// A grid of [`lamp`] over `c_deg` and `gamma_deg`, as a plan has them.
fn scan(c_deg: &[f64], gamma_deg: &[f64]) -> Vec<Reading> {
    c_deg
        .iter()
        .flat_map(|&c| gamma_deg.iter().map(move |&gamma| (c, gamma)))
        .map(|(c, gamma)| reading(c, gamma, lamp(c, gamma) / 100.0))
        .collect()
}

fn every(from: f64, to: f64, step: f64) -> Vec<f64> {
    (0..=((to - from) / step).round() as u32)
        .map(|i| from + step * f64::from(i))
        .collect()
}

#[test]
fn signed_gamma_reads_the_poles_of_all_half_planes() {
    let round = reduced(scan(&[0.0, 90.0, 180.0, 270.0], &every(0.0, 180.0, 10.0)), &[]);
    let signed = reduced(scan(&[0.0, 90.0], &every(-180.0, 180.0, 10.0)), &[]);
    assert!((signed.flux.value - round.flux.value).abs() < 1e-9);
    assert_eq!(signed.grid.distribution.c_deg(), [0.0, 90.0, 180.0, 270.0]);
    // Two readings on the axis, not four.
    let alone = |result: &Reduction| result.i_max.parts["noise"].hypot(result.i_max.parts["digit"]);
    assert!(alone(&signed) >= alone(&round));
}

#[test]
fn a_direction_that_the_plan_names_twice_is_one() {
    let angles = "c_deg = [0, 90, 180, 270, 0]\ngamma_deg = [0, 30, 60, 90, 90, 120, 150, 180]";
    let result = reduce(&planned(&[("all", angles, 10_000.0, 1)]), &Options::default(), None).unwrap();
    assert_eq!(result.grid.distribution.intensity_cd().len(), 4 * 7);
}

#[test]
fn a_quadrant_is_a_symmetric_lamp_and_says_so() {
    let gammas = every(0.0, 180.0, 5.0);
    let run = run(scan(&every(0.0, 90.0, 15.0), &gammas));
    let quadrant = reduce(&run, &Options::default(), None).unwrap();
    let round = reduced(scan(&every(0.0, 345.0, 15.0), &gammas), &[]);
    // The lamp is symmetric: what is mirrored is what would have been measured, with fewer readings behind it.
    assert!((quadrant.flux.value - round.flux.value).abs() < 1e-9);
    assert!(quadrant.flux.parts["digit"] >= round.flux.parts["digit"]);
    assert!(
        quadrant.notes.iter().any(|note| note.starts_with("symmetry assumed")),
        "{:?}",
        quadrant.notes
    );
    assert!(
        round.notes.iter().all(|note| !note.contains("symmetry")),
        "{:?}",
        round.notes
    );
    let files = isolux_reduce::files(&quadrant, &run, &[], "isolux test").unwrap();
    let text = |name: &str| {
        let file = files.iter().find(|file| file.name == name).unwrap();
        String::from_utf8_lossy(&file.bytes).into_owned()
    };
    // Isym, and the last half-plane of the file.
    assert_eq!(text("luminaire.ldt").lines().nth(2).unwrap().trim(), "4");
    assert!(text("luminaire.ldt").contains("symmetry assumed"));
    assert!(text("luminaire.ies").contains("symmetry assumed"));
    let open = reduce(
        &self::run(scan(&every(0.0, 165.0, 15.0), &gammas)),
        &Options::default(),
        None,
    )
    .unwrap_err();
    assert!(
        matches!(
            open,
            ReduceError::NotRound(isolux_photometry::NotRound {
                from_c_deg: 165.0,
                to_c_deg: 0.0
            })
        ),
        "{open}"
    );
}

#[test]
fn a_zone_without_the_axis_gives_a_model_that_can_be_read() {
    let run = planned(&[("zone", "c_range = [0, 330, 30]\ngamma_range = [5, 85, 10]", 10_000.0, 1)]);
    let result = reduce(&run, &Options::default(), None).unwrap();
    assert!(
        result.notes.iter().any(|note| note.contains("γ 5° to 85°")),
        "{:?}",
        result.notes
    );
    let files = isolux_reduce::files(&result, &run, &[], "isolux test").unwrap();
    let model = files.iter().find(|file| file.name == "luminaire.model.toml").unwrap();
    let text = std::str::from_utf8(&model.bytes).unwrap();
    assert!(
        !text.contains("NaN") && !text.contains("intensity_rel") && text.contains("measured_gamma_deg = [5.0, 85.0]"),
        "{text}"
    );
}

#[test]
fn what_the_job_states_stands_in_every_file_and_the_name_of_the_station_in_none() {
    let mut run = run(day(|lux| lux, 0.0));
    run.header.luminaire = toml::from_str(
        "maker = \"ACME\"\nname = \"Spot 12\"\ncatalogue_number = \"S-12\"\nsample = \"no. 3\"\nlight_source = \"LED 830\"\n",
    )
    .unwrap();
    run.header.report =
        toml::from_str("number = \"R-7\"\nlaboratory = \"Lab, Town\"\noperator = \"A. Person\"\ncustomer = \"B\"\n")
            .unwrap();
    let result = reduce(&run, &Options::default(), None).unwrap();
    let files = isolux_reduce::files(&result, &run, &[], "isolux test").unwrap();
    let text = |name: &str| {
        let file = files.iter().find(|file| file.name == name).unwrap();
        String::from_utf8_lossy(&file.bytes).into_owned()
    };
    let ldt = text("luminaire.ldt");
    let line = |number: usize| ldt.lines().nth(number - 1).unwrap().trim().to_owned();
    assert_eq!(
        (line(1).as_str(), line(9).as_str(), line(10).as_str()),
        ("ACME", "Spot 12", "S-12")
    );
    assert!(line(8).starts_with("R-7; isolux "), "{}", line(8));
    assert!(line(12).contains("; A. Person"), "{}", line(12));
    assert_eq!(line(28), "LED 830");
    let ies = text("luminaire.ies");
    for words in [
        "[TEST] R-7; ",
        "[TESTLAB] Lab, Town",
        "[MANUFAC] ACME",
        "[LUMCAT] S-12",
        "[LUMINAIRE] Spot 12",
        "[OTHER] sample no. 3",
    ] {
        assert!(ies.contains(words), "{words} is not in\n{ies}");
    }
    let xml = text("luminaire.xml");
    for words in [
        "<Manufacturer>ACME</Manufacturer>",
        "<CatalogNumber>S-12</CatalogNumber>",
        "<Laboratory>Lab, Town</Laboratory>",
        "<ReportNumber>R-7</ReportNumber>",
        "sample no. 3; customer B; operator A. Person",
    ] {
        assert!(xml.contains(words), "{words} is not in\n{xml}");
    }
    // TM-33 is read again as what it was.
    let (read, findings) = isolux_formats::Distribution::load(xml.as_bytes(), "luminaire.xml").unwrap();
    assert!(
        findings
            .iter()
            .all(|finding| finding.severity != isolux_formats::Severity::Error),
        "{findings:?}"
    );
    // Both files hold what is left when noise below zero is written as zero; EULUMDAT rounds cd/klm.
    let (in_ldt, _) = isolux_formats::Distribution::load(ldt.as_bytes(), "luminaire.ldt").unwrap();
    let flux = |file: &isolux_formats::Distribution| file.intensity.flux_lm();
    assert!((flux(&read) / flux(&in_ldt) - 1.0).abs() < 1e-3);
    if let Some(name) = &run.header.station.document().name {
        assert!(
            files
                .iter()
                .all(|file| !String::from_utf8_lossy(&file.bytes).contains(name.as_str()))
        );
    }
}
