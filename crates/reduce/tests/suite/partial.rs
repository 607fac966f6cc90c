//! Scans that ended early.

use super::*;

#[test]
fn a_scan_that_ended_early_gives_partial_results_that_say_so() {
    let mut half = run(day(|lux| lux, 0.0));
    let plan = PLAN.replace(
        "c_deg = 0\ngamma_deg = 0",
        "c_range = [0, 345, 15]\ngamma_range = [0, 180, 2]",
    );
    half.header.plan = Plan::parse(Utf8Path::new("p.toml"), &plan).unwrap();
    assert!(reduce(&half, &Options::default(), None).is_ok());
    // Six half-planes and a part of the seventh.
    let mut early = half.clone();
    early
        .readings
        .rows
        .retain(|row| row.c_target_deg < 90.0 || row.c_target_deg == 90.0 && row.gamma_target_deg < 100.0);
    let result = reduce(&early, &Options::default(), None).unwrap();
    let partial = result.partial.clone().unwrap();
    assert_eq!(partial.whole_c_deg, [0.0, 15.0, 30.0, 45.0, 60.0, 75.0]);
    assert_eq!((partial.directions, partial.planned_directions), (6 * 91 + 50, 24 * 91));
    let distribution = &result.grid.distribution;
    assert_eq!(distribution.c_deg().len(), 24);
    // Half-way round from C 75° to C 0°: the mean of the two.
    let mean = 0.5 * (lamp(75.0, 40.0) + lamp(0.0, 40.0));
    let between = 0.5 * (distribution.intensity_cd_at(210.0, 40.0) + distribution.intensity_cd_at(225.0, 40.0));
    assert!((between / mean - 1.0).abs() < 1e-3, "{between} for {mean}");
    assert!(result.grid.smoothed.is_none());
    for quantity in [&result.flux, &result.i_max, &result.sensor_illuminance] {
        assert!(
            quantity.u.is_none() && quantity.missing[0].starts_with("partial: 6 of 24 half-planes"),
            "{quantity:?}"
        );
    }
    let files = isolux_reduce::files(&result, &early, &[], "isolux test").unwrap();
    let table = files
        .iter()
        .find(|file| file.name == "luminaire.partial.directions.csv")
        .unwrap();
    let table = String::from_utf8_lossy(&table.bytes);
    let origins = |c: &str| {
        table
            .lines()
            .filter(|line| line.starts_with(c))
            .all(|line| line.contains(",interpolated,"))
    };
    assert!(origins("90,4") && origins("345,2") && !origins("75,4"), "{table}");
    for file in files {
        assert!(file.name.contains(".partial."), "{}", file.name);
        let text = String::from_utf8_lossy(&file.bytes).to_lowercase();
        assert!(text.contains("partial"), "{}", file.name);
    }
    early
        .readings
        .rows
        .retain(|row| row.c_target_deg == 0.0 && row.gamma_target_deg < 100.0);
    let error = reduce(&early, &Options::default(), None).unwrap_err();
    assert!(
        matches!(
            error,
            ReduceError::Unfinished {
                found: 50,
                planned: 2184
            }
        ),
        "{error}"
    );
}

#[test]
fn a_whole_distribution_without_the_dark_of_the_plan_is_partial_too() {
    let mut late = run(day(|lux| lux, 0.0));
    let plan = format!("{PLAN}[[block]]\nname = \"dark\"\nkind = \"capped\"\nc_deg = 0\ngamma_deg = [0, 10]\n");
    late.header.plan = Plan::parse(Utf8Path::new("p.toml"), &plan).unwrap();
    let result = reduce(&late, &Options::default(), None).unwrap();
    assert_eq!(result.partial.as_ref().unwrap().unread_blocks, ["dark"]);
    assert!(result.flux.u.is_none());
    assert_eq!(result.flux.missing[0], "partial: block dark was not read to the end");
    for gamma_deg in [0.0, 10.0] {
        late.readings.rows.push(Reading {
            kind: ReadingKind::Capped,
            role: Role::Point,
            block: "dark".to_owned(),
            c_target_deg: 0.0,
            gamma_target_deg: gamma_deg,
            ..late.readings.rows[0].clone()
        });
    }
    assert!(reduce(&late, &Options::default(), None).unwrap().partial.is_none());
}
