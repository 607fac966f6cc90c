//! What is left out of a run or its station is never taken for zero; what does not agree gives no result.

use super::*;
use isolux_reduce::{Quantity, weighted_sum};

const STRAY: &str = "not corrected for stray light";
const AMBIENT: &str = "not corrected for ambient light";
const OFFSET: &str = "not corrected for the meter's offset";

/// The run of `rows` at a station with further keys of `[bench]`, a lamp of 73 mm and the tables `rest`.
fn run_at(rows: Vec<Reading>, bench: &str, rest: &str) -> Run {
    let mut run = run(rows);
    let text = STATION.replace("u_distance_mm = 5.0\n", &format!("u_distance_mm = 5.0\n{bench}"));
    let text = format!("{text}[lamp]\nprompt = \"switch\"\ndiameter_mm = 73.0\n{rest}");
    run.header.station = Station::parse(Utf8Path::new("s.toml"), &text).unwrap();
    run
}

fn plain(run: &Run) -> Reduction {
    reduce(run, &Options::default(), None).unwrap()
}

fn without_kinds(kinds: &[ReadingKind]) -> Vec<Reading> {
    let mut rows = day(|lux| lux, 0.0);
    rows.retain(|row| !kinds.contains(&row.kind));
    rows
}

#[test]
fn a_whole_day_at_a_station_that_says_everything_lacks_nothing() {
    let result = plain(&run_at(day(rounded, 0.0), "", ""));
    for quantity in [&result.flux, &result.i_max, &result.sensor_illuminance] {
        assert_eq!(quantity.missing, [""; 0]);
        assert!(quantity.u.unwrap() > 0.0);
    }
    assert!(result.i_max.parts["near_field"] > 0.0 && !result.flux.parts.contains_key("near_field"));
}

#[test]
fn every_direction_has_its_uncertainty_and_where_it_comes_from() {
    let table = |run: &Run| -> (Reduction, Vec<Vec<String>>) {
        let reduction = plain(run);
        let files = isolux_reduce::files(&reduction, run, &[], "isolux test").unwrap();
        let mut named = files.iter().filter(|file| file.name.ends_with("directions.csv"));
        let text = String::from_utf8(named.next().unwrap().bytes.clone()).unwrap();
        let fields = |line: &str| line.split(',').map(str::to_owned).collect();
        (reduction, text.lines().map(fields).collect())
    };
    let number = |word: &str| word.parse::<f64>().unwrap();
    let whole = run_at(day(rounded, 0.0), "", "");
    let (result, rows) = table(&whole);
    assert_eq!(
        rows[0].join(","),
        "c_deg,gamma_deg,intensity_cd,read_cd,u_own_cd,u_cd,u_between_cd,origin,missing"
    );
    let grid = &result.grid;
    assert_eq!(rows.len(), 1 + grid.sample_of.len());
    for row in rows.iter().skip(1).step_by(7) {
        // As of a sum with this direction alone.
        let weights = grid.direction_weights(number(&row[0]), number(&row[1]));
        let alone = weighted_sum(grid, &weights, &result.common, "cd");
        assert!(
            (number(&row[5]) / alone.u_of_parts - 1.0).abs() < 1e-9,
            "{row:?} {alone:?}"
        );
        assert!((number(&row[2]) / alone.value - 1.0).abs() < 1e-9, "{row:?}");
        assert!(number(&row[4]) < number(&row[5]) && row[7] == "at_rest", "{row:?}");
    }
    // Half of the circle, as of a lamp that is the same on both sides.
    let mut half = whole.clone();
    half.readings.rows.retain(|row| row.c_target_deg <= 180.0);
    let (_, rows) = table(&half);
    assert!(
        rows[1][5].is_empty() && rows[1][8].contains("a symmetry is assumed"),
        "{:?}",
        rows[1]
    );
    let origin = |c: &str, gamma: &str| &rows.iter().find(|row| row[0] == c && row[1] == gamma).unwrap()[7];
    assert_eq!(
        [origin("165", "40"), origin("195", "40"), origin("195", "0")],
        ["at_rest", "by_symmetry", "at_rest"]
    );
}

#[test]
fn a_block_that_was_left_out_takes_the_uncertainty_away_or_makes_it_larger() {
    let whole = plain(&run_at(day(|lux| lux, 0.0), "", "")).flux;
    let (baffled, off, capped) = (ReadingKind::Baffled, ReadingKind::LampOff, ReadingKind::Capped);
    // The stray light is 0.03 lx of 3.4, the ambient light 0.02 lx, the offset 0.05 lx.
    let bounds = "stray_max_rel = 0.012\nambient_max_lx = 0.04\ndark_max_lx = 0.1\n";
    for (left_out, missing) in [
        (&[baffled][..], &[STRAY][..]),
        (&[baffled, capped], &[STRAY]),
        (&[baffled, off], &[AMBIENT, STRAY]),
        (&[baffled, off, capped], &[OFFSET, AMBIENT, STRAY]),
    ] {
        let lacking = plain(&run_at(without_kinds(left_out), "", ""));
        for quantity in [&lacking.flux, &lacking.i_max, &lacking.sensor_illuminance] {
            assert_eq!(quantity.u, None);
            assert_eq!(quantity.missing, missing);
        }
        let bounded = plain(&run_at(without_kinds(left_out), bounds, "")).flux;
        let off = bounded.value - std::f64::consts::PI * 337.0;
        let u = bounded.u.unwrap();
        assert!(u > 2.0 * whole.u.unwrap(), "{bounded:?}");
        assert!(off.abs() < 2.0 * u && off.abs() > whole.u.unwrap(), "{off} ± {u}");
    }
    // A correction that is switched off is as good as one that was not measured.
    for (correction, missing) in [
        (Correction::Stray, STRAY),
        (Correction::Ambient, AMBIENT),
        (Correction::Dark, OFFSET),
    ] {
        let options = Options {
            without: [correction].into(),
            accept_drift: None,
        };
        let run = run_at(day(|lux| lux, 0.0), "", "");
        assert_eq!(reduce(&run, &options, None).unwrap().flux.missing, [missing]);
    }
}

#[test]
fn baffled_readings_at_one_gamma_say_nothing_of_the_others() {
    let mut rows = day(|lux| lux, 0.0);
    rows.retain(|row| row.kind != ReadingKind::Baffled || row.gamma_target_deg == 0.0);
    let flux = plain(&run_at(rows, "", "")).flux;
    assert_eq!(flux.missing, ["the stray light was measured at 1 γ alone"]);
}

#[test]
fn what_the_station_does_not_state_is_named() {
    let rows = || day(rounded, 0.0);
    // No lamp.diameter_mm: the flux does not need it.
    let result = plain(&run(rows()));
    assert_eq!((result.flux.missing.len(), result.i_max.missing.len()), (0, 1));
    for key in ["u_distance_mm = 5.0\n", "u_gamma_deg = 0.05\n"] {
        let mut nowhere = run_at(rows(), "", "");
        let text = STATION.replace(key, "");
        nowhere.header.station = Station::parse(Utf8Path::new("s.toml"), &text).unwrap();
        let result = plain(&nowhere);
        let name = key.split(' ').next().unwrap();
        for quantity in [&result.flux, &result.i_max, &result.sensor_illuminance] {
            assert!(
                quantity.u.is_none() && quantity.missing[0].contains(name),
                "{quantity:?}"
            );
        }
    }
}

#[test]
fn a_drift_that_nobody_looked_at_is_what_a_stable_lamp_may_do() {
    let mut rows = day(|lux| lux, 0.0);
    rows.retain(|row| row.role == Role::Point);
    let seconds = rows
        .iter()
        .filter(|row| row.kind == ReadingKind::Lit)
        .filter_map(|row| row.time_s);
    let length = seconds.fold(0.0, f64::max) - 1804.0;
    let of = |rest: &str| {
        let flux = plain(&run_at(rows.clone(), "", rest)).flux;
        flux.parts["drift"] / flux.value
    };
    assert!((of("") - 0.0025 * length / 900.0 / 3.0_f64.sqrt()).abs() < 1e-9);
    let strict = "[lamp.stable]\nleast_s = 60.0\nwindow_s = 3600.0\nspread_rel = 0.001\n";
    assert!((of(strict) - 0.0005 * length / 3600.0 / 3.0_f64.sqrt()).abs() < 1e-9);
}

#[test]
fn coarse_steps_cost_what_they_lose() {
    let of = |c_step: f64, gamma_step: f64| {
        let rows = scan(&every(0.0, 360.0 - c_step, c_step), &every(0.0, 180.0, gamma_step));
        plain(&run_at(
            rows,
            "stray_max_rel = 0\nambient_max_lx = 0\ndark_max_lx = 0\n",
            "",
        ))
        .flux
    };
    let mut last = 0.0;
    for step in [2.0, 5.0, 15.0, 30.0] {
        let flux = of(15.0, step);
        let part = flux.parts["interpolation"];
        let off = (flux.value - std::f64::consts::PI * 337.0).abs();
        assert!(part > 2.0 * last, "{step}°: {part} after {last}");
        assert!(off < 2.0 * part, "{step}°: {off}, u = {part}");
        last = part;
    }
    assert!(
        of(90.0, 2.0).missing[0].contains("steps of C"),
        "four half-planes may miss a square luminaire"
    );
}

#[test]
fn what_is_missing_stands_in_every_file_and_no_plus_minus_does() {
    let run = run_at(without_kinds(&[ReadingKind::Baffled]), "", "");
    let files = isolux_reduce::files(&plain(&run), &run, &[], "isolux test").unwrap();
    let text = |name: &str| {
        let file = files.iter().find(|file| file.name == name).unwrap();
        String::from_utf8_lossy(&file.bytes).into_owned()
    };
    for name in [
        "luminaire.ldt",
        "luminaire.ies",
        "luminaire.xml",
        "luminaire.model.toml",
        "budget.json",
        "provenance.json",
    ] {
        assert!(text(name).contains(STRAY), "{name}");
    }
    assert!(!text("luminaire.ies").contains("expanded uncertainty") && !text("luminaire.xml").contains("expanded"));
    assert!(
        !text("luminaire.model.toml").contains("flux_rel") && !text("luminaire.model.toml").contains("intensity_rel")
    );
    let budget: serde_json::Value = serde_json::from_str(&text("budget.json")).unwrap();
    assert!(budget["flux"]["u"].is_null() && budget["flux"]["u_of_parts"].as_f64().unwrap() > 0.0);
}

/// The day of the issue: the shutter was closed during one visit to the reference point.
fn dark_visit() -> Vec<Reading> {
    let mut rows = day(rounded, 0.0);
    let visit = rows
        .iter_mut()
        .filter(|row| row.role == Role::Reference)
        .nth(12)
        .unwrap();
    visit.illuminance_lx = Some(0.11);
    rows
}

#[test]
fn a_reference_in_the_dark_gives_no_result_unless_it_is_accepted() {
    let error = reduce(&run_at(dark_visit(), "", ""), &Options::default(), None).unwrap_err();
    let ReduceError::Unsteady { findings } = &error else {
        panic!("{error}");
    };
    assert!(
        findings
            .iter()
            .all(|finding| finding.rows.iter().all(|row| row.row == 12 * 92)),
        "{findings:?}"
    );
    assert!(error.to_string().contains("row 1104 at"), "{error}");

    let run = run_at(dark_visit(), "", "");
    let result = accepted(dark_visit(), &[]);
    assert_eq!(result.flux.u, None);
    assert_eq!(result.accepted.as_ref().unwrap().findings, *findings);
    for file in isolux_reduce::files(&result, &run, &[], "isolux test").unwrap() {
        let text = String::from_utf8_lossy(&file.bytes).into_owned();
        if !file.name.contains(".sp") {
            assert!(text.contains("drift beyond the limits was accepted"), "{}", file.name);
        }
    }
}

#[test]
fn a_lamp_that_fell_and_a_closing_plane_that_differs_are_refused() {
    let falling = reduce(&run(day(|lux| lux, -0.02)), &Options::default(), None).unwrap_err();
    assert!(falling.to_string().contains("limits.drift_rel 2.00 %"), "{falling}");
    // Something moved before the last half-plane: 5 % less light in it, and the visits do not show it.
    let mut rows = day(|lux| lux, 0.0);
    for row in rows
        .iter_mut()
        .filter(|row| row.role == Role::Point && row.c_target_deg == 360.0)
    {
        row.illuminance_lx = row.illuminance_lx.map(|lux| 0.1 + 0.95 * (lux - 0.1));
    }
    let error = reduce(&run(rows), &Options::default(), None).unwrap_err();
    assert!(
        matches!(&error, ReduceError::Unsteady { findings } if findings.len() == 1)
            && error.to_string().contains("C 360° differs"),
        "{error}"
    );
}

#[test]
fn a_gamma_zero_that_no_reading_shows_is_in_the_budget() {
    const OFFSET_DEG: f64 = 0.1;
    let at_zero = plain(&run_at(day(|lux| lux, 0.0), "", ""));
    let mut rows = day(|lux| lux, 0.0);
    for row in rows.iter_mut().filter(|row| row.kind == ReadingKind::Lit) {
        let lux = row.illuminance_lx.as_mut().unwrap();
        *lux += (lamp(row.c_deg, row.gamma_deg + OFFSET_DEG) - lamp(row.c_deg, row.gamma_deg)) / 100.0;
    }
    let off = plain(&run_at(rows, "", ""));
    // The station states half of the offset as u. The edge of the lobe at 90° is sharp: the chord's slope there is half
    // of that on one side, and 2 % of the change.
    let moved = |of: &Quantity, to: &Quantity| (to.value - of.value).abs() / of.parts["angle"];
    let flux = moved(&at_zero.flux, &off.flux);
    assert!((1.93..1.98).contains(&flux), "{flux}");
    let [beam, beam_off] = [&at_zero, &off].map(|of| of.angles[0].beam.as_ref().unwrap());
    let beam = moved(beam, beam_off);
    assert!((beam - 2.0).abs() < 0.05, "{beam}");
}
