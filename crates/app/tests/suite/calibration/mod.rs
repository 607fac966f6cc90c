//! Calibrations with a standard lamp in seeded rooms: the factors agree with the room within their U, what the
//! certificate does not cover is refused, and a run that was killed goes on.
//!
//! A few rooms are a test. The campaign, of as many as `ISOLUX_CALIBRATIONS` says (100), is for a person:
//!
//! ```text
//! ISOLUX_CALIBRATIONS=100 cargo test --release -p isolux-app --test suite calibration -- --ignored --nocapture
//! ```

#![allow(clippy::print_stdout, reason = "the campaign prints what it counts")]

mod campaign;
mod covariance;
mod lab;
mod refused;
mod spectrometer;

use isolux_app::FailureKind;
use isolux_app::calibration::{Instrument, Outcome};
use isolux_app::files::{Overwrite, read_json};
use isolux_app::front_end::control::Control;
use isolux_record::spectra::parse_calibration;

use lab::{Lab, spectral};

#[test]
fn a_factor_file_is_written_that_the_station_reads_and_the_same_comes_again() {
    let lab = Lab::new(1, |_| {});
    let done = lab.calibrate(Instrument::Spectroradiometer).unwrap();
    let factors = spectral(&done);
    let file = done.folder.join("spectroradiometer.csv");
    let text = std::fs::read_to_string(&file).unwrap();
    let curve = parse_calibration(&file, &text).unwrap();
    assert_eq!(curve.len(), factors.factor_w_m2_nm.len());
    for expected in [
        &done.calibration.record_sha256,
        &done.calibration.due,
        &factors.conditions.certificate_sha256,
    ] {
        assert!(text.contains(expected.as_str()), "{expected}");
    }
    // The former factors are those of the room's maker, 0.3 % high; the certificate has its own error.
    let drift = factors.drift.illuminance_rel.unwrap();
    assert!(drift.abs() < 2.0 * factors.u_rel.hypot(0.004), "{drift}");
    let picture = std::fs::read_to_string(done.folder.join("drift.svg")).unwrap();
    assert!(picture.starts_with("<svg"));
    let json: isolux_app::calibration::Calibration = read_json(&done.folder.join("calibration.json")).unwrap();
    assert_eq!(json, done.calibration);
    // A complete record is computed again, and nothing moves.
    let before = std::fs::read(lab.run(Instrument::Spectroradiometer).join("run.toml")).unwrap();
    let again = lab.calibrate(Instrument::Spectroradiometer).unwrap();
    assert_eq!(again.calibration, done.calibration);
    let after = std::fs::read(lab.run(Instrument::Spectroradiometer).join("run.toml")).unwrap();
    assert_eq!(before, after);
    // The diary has it once; a line that is none is named.
    let diary = isolux_app::history::read(&lab.station()).unwrap();
    assert_eq!(diary.len(), 3);
    assert!(
        diary
            .iter()
            .all(|entry| entry.record_sha256 == done.calibration.record_sha256)
    );
    let (charts, written) = isolux_app::history::charts(&lab.station(), None, Overwrite::Never).unwrap();
    assert!(charts.len() == 3 && written.is_empty() && charts.iter().all(|chart| !chart.out_of_control));
    let diary = isolux_app::history::file(&lab.station());
    let whole = std::fs::read_to_string(&diary).unwrap();
    std::fs::write(&diary, whole.clone() + "{}\n").unwrap();
    let refused = isolux_app::history::read(&lab.station()).unwrap_err();
    assert!(refused.message.contains("history.jsonl:4: "), "{refused}");
    std::fs::write(&diary, whole).unwrap();
    // The lines that are printed make a station that can be used.
    lab.paste(&done);
    isolux_app::instruments::bench::StationFiles::load(&lab.station()).unwrap();
}

#[test]
fn the_factor_of_the_lux_meter_undoes_its_error_within_u() {
    let lab = Lab::new(2, |room| room.luxmeter.gain_error_rel = 0.02);
    let done = lab.calibrate(Instrument::Luxmeter).unwrap();
    let Outcome::Luxmeter(factor) = &done.calibration.outcome else {
        panic!("{done:?}");
    };
    // The meter shows 2 % too much.
    let truth = 1.0 / 1.02;
    let off = factor.calibration_factor / truth - 1.0;
    assert!(off.abs() < 2.0 * factor.u_rel, "{off} {}", factor.u_rel);
    assert!((0.003..0.008).contains(&factor.u_rel), "{}", factor.u_rel);
    assert!((factor.drift_rel - off).abs() < 0.03 && factor.drift_rel < -0.01);
}

#[test]
fn a_meter_that_is_warm_gets_the_factor_of_the_temperature_that_its_station_states() {
    let lab = Lab::new(2, |room| {
        room.luxmeter.gain_error_rel = 0.0;
        room.room.temperature_c = 31.0;
        room.injected_effects.temp_coefficient.coefficient_per_k = -0.004;
        room.injected_effects.temp_coefficient.reference_c = 23.0;
    });
    let station = std::fs::read_to_string(lab.station()).unwrap()
        + "[luxmeter.temperature]\ncoefficient_per_k = -0.004\nu_coefficient_per_k = 0.0002\nreference_c = 23.0\n\
           u_temperature_k = 0.3\n";
    std::fs::write(lab.station(), station).unwrap();
    let done = lab.calibrate(Instrument::Luxmeter).unwrap();
    let Outcome::Luxmeter(factor) = &done.calibration.outcome else {
        panic!("{done:?}");
    };
    // Eight kelvin are 3.2 % of every reading, and none of the factor.
    let off = factor.calibration_factor - 1.0;
    assert!(
        off.abs() < 2.0 * factor.u_rel && factor.u_rel < 0.008,
        "{off} {}",
        factor.u_rel
    );
    assert!(
        factor
            .parts_rel
            .iter()
            .any(|(name, u)| name == "temperature" && *u > 0.001)
    );
}

#[test]
fn a_calibration_that_was_ended_goes_on_with_the_same_command() {
    let lab = Lab::new(3, |_| {});
    let control = Control::default();
    let counting = lab::EndsAfter::readings(7, &control);
    let failure = lab
        .calibrate_with(Instrument::Spectroradiometer, &control, &counting)
        .unwrap_err();
    assert_eq!(failure.kind, FailureKind::Interrupted, "{failure}");
    let run = lab.run(Instrument::Spectroradiometer);
    assert!(!run.join("calibration").exists());
    let done = lab.calibrate(Instrument::Spectroradiometer).unwrap();
    let undisturbed = Lab::new(3, |_| {}).calibrate(Instrument::Spectroradiometer).unwrap();
    let (one, other) = (spectral(&done), spectral(&undisturbed));
    for (place, nm) in one.wavelength_nm.iter().enumerate() {
        let Ok(beside) = other.wavelength_nm.binary_search_by(|beside| beside.total_cmp(nm)) else {
            continue;
        };
        let off = one.factor_w_m2_nm[place] / other.factor_w_m2_nm[beside] - 1.0;
        assert!(off.abs() < 2.0 * one.u_rel_at(place), "{nm} nm: {off}");
    }
}
