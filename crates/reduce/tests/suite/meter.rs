//! What a lux meter does to light is taken out where its station states it; left out it stands in the budget.

use super::*;

/// Offset of the meter in [`day`].
const OFFSET_LX: f64 = 0.05;

/// The run of `rows` at a station with these tables of its lux meter and a lamp of this size.
fn run_with(rows: Vec<Reading>, tables: &str, diameter_mm: f64) -> Run {
    let mut run = run(rows);
    let text = format!("{STATION}{tables}[lamp]\nprompt = \"switch\"\ndiameter_mm = {diameter_mm}\n");
    run.header.station = Station::parse(Utf8Path::new("s.toml"), &text).unwrap();
    run
}

/// A day whose meter makes `of` of the light of each reading.
fn distorted(mut of: impl FnMut(&Reading, f64) -> f64) -> Vec<Reading> {
    let mut rows = day(|lux| lux, 0.0);
    for row in &mut rows {
        let light = row.illuminance_lx.unwrap() - OFFSET_LX;
        if row.kind != ReadingKind::Capped {
            row.illuminance_lx = Some(OFFSET_LX + of(row, light));
        }
    }
    rows
}

/// As they were read, without smoothing; `without` beside it.
fn raw(run: &Run, without: &[Correction]) -> Reduction {
    let options = Options {
        without: without.iter().copied().chain([Correction::Smoothing]).collect(),
        accept_drift: Some("a test".to_owned()),
    };
    reduce(run, &options, None).unwrap()
}

/// That with the tables the flux is that of a meter without the property, and without the correction, with its part of
/// the budget, that of the readings.
fn comes_home(rows: Vec<Reading>, tables: &str, correction: Correction, near: f64) -> Reduction {
    let truth = raw(&run(day(|lux| lux, 0.0)), &[]).flux.value;
    let plain = raw(&run(rows.clone()), &[]).flux.value;
    assert!((plain / truth - 1.0).abs() > 50.0 * near, "{plain} {truth}");
    let stated = run_with(rows, tables, 73.0);
    let corrected = raw(&stated, &[]);
    assert!(
        (corrected.flux.value / truth - 1.0).abs() < near,
        "{} {truth}",
        corrected.flux.value
    );
    let left_out = raw(&stated, &[correction]);
    assert!(
        (left_out.flux.value / plain - 1.0).abs() < 1e-12,
        "{}",
        left_out.flux.value
    );
    let part = |of: &Reduction| of.flux.parts[correction.as_str()] / of.flux.value;
    assert!(
        part(&left_out) > (plain / truth - 1.0).abs(),
        "{} {plain} {truth}",
        part(&left_out)
    );
    assert!(part(&corrected) > 0.0 && part(&corrected) < part(&left_out));
    assert!(
        left_out
            .notes
            .contains(&format!("correction {correction} is switched off"))
    );
    corrected
}

#[test]
fn a_warm_meter_reads_as_one_at_the_temperature_of_its_calibration() {
    let warm = |row: &Reading| 27.0 + row.time_s.unwrap() / 9000.0;
    let mut rows = distorted(|row, light| light * (1.0 - 0.002 * (warm(row) - 23.0)));
    for row in &mut rows {
        row.ambient_c = Some(warm(row));
    }
    let tables = "[luxmeter.temperature]\ncoefficient_per_k = -0.002\nu_coefficient_per_k = 0.0003\n\
                  reference_c = 23.0\nu_temperature_k = 0.5\n";
    let found = comes_home(rows, tables, Correction::Temperature, 1e-9);
    assert!(
        found
            .bench_effects
            .iter()
            .any(|effect| effect.contains("coefficient_per_k = -0.002"))
    );
}

#[test]
fn a_meter_that_saturates_reads_in_proportion() {
    let k = 0.004;
    let rows = distorted(|_, light| light / (1.0 + k * light));
    let shown: Vec<f64> = (0..=200)
        .map(|step| 0.001 * 10f64.powf(f64::from(step) / 50.0))
        .collect();
    let factor: Vec<f64> = shown.iter().map(|shown| 1.0 / (1.0 - k * shown)).collect();
    let tables = format!("[luxmeter.linearity]\nilluminance_lx = {shown:?}\nfactor = {factor:?}\nu_rel = 0.0005\n");
    let found = comes_home(rows, &tables, Correction::Linearity, 1e-5);
    assert!(
        found.luxmeter.linearity.unwrap().factor[1] > 1.01,
        "{:?}",
        found.luxmeter
    );
}

#[test]
fn a_meter_that_tires_reads_as_a_rested_one() {
    let (mut loss, mut end, mut before): (f64, f64, Option<f64>) = (0.0, 0.0, None);
    let rows = distorted(|row, light| {
        let time_s = row.time_s.unwrap();
        loss = match before {
            Some(before) => end + (loss - end) * (-(time_s - before) / 900.0_f64).exp(),
            None => 0.0,
        };
        (before, end) = (Some(time_s), 0.01 * light);
        light * (1.0 - loss)
    });
    let tables = "[luxmeter.fatigue]\nloss_rel = 0.01\nu_loss_rel = 0.002\nat_lx = 1.0\ntime_constant_s = 900.0\n";
    comes_home(rows, tables, Correction::Fatigue, 2e-4);
}

#[test]
fn the_edge_of_a_large_lamp_comes_at_a_slant() {
    let tables =
        "[luxmeter.cosine]\nangle_deg = [0, 20, 40]\nresponse_rel = [1, 0.9, 0.8]\nu_rel = [0, 0.002, 0.004]\n";
    let rows = day(|lux| lux, 0.0);
    let plain = raw(&run(rows.clone()), &[]);
    // Angles of up to 11.3° from the normal: 0.5 % a degree, 2/3 of that in the mean.
    let large = raw(&run_with(rows.clone(), tables, 4000.0), &[]);
    let gain = large.i_max.value / plain.i_max.value;
    assert!((1.0 / gain - (1.0 - 0.005 * 11.31 * 2.0 / 3.0)).abs() < 5e-4, "{gain}");
    // Across the axis the disc is seen as a line.
    assert!(large.flux.value / plain.flux.value < gain);
    let part = large.flux.parts["cosine"] / large.flux.value;
    assert!(
        (part - 0.0011_f64.hypot((gain - 1.0) / 3.0_f64.sqrt())).abs() < 1e-3,
        "{part} {gain}"
    );
    assert!(
        large
            .bench_effects
            .iter()
            .any(|effect| effect.starts_with("name = \"cosine_f2\""))
    );
    let left_out = raw(&run_with(rows.clone(), tables, 4000.0), &[Correction::Cosine]);
    assert!((left_out.flux.value / plain.flux.value - 1.0).abs() < 1e-12);
    assert!(left_out.flux.parts["cosine"] / left_out.flux.value > gain - 1.0);
    let small = raw(&run_with(rows.clone(), tables, 1.0), &[]);
    assert!((small.flux.value / plain.flux.value - 1.0).abs() < 1e-4);
    let mut unknown = run(rows);
    unknown.header.station = Station::parse(Utf8Path::new("s.toml"), &format!("{STATION}{tables}")).unwrap();
    let unknown = raw(&unknown, &[]);
    assert!(unknown.flux.u.is_none() && unknown.flux.missing.iter().any(|what| what.contains("diameter_mm")));
}
