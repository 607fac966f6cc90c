//! Other meters that convert on request: spectroradiometers in the place of the lux meter, and a profile that says so.

use super::*;

/// Latency, lag and play that no file says.
const DISTURBED: &str = "[luxmeter]\nlatency_s = 0.06\nlatency_jitter_s = 0.004\nlag_s = 0.02\n\
                         [injected_effects]\nbacklash = { width_deg = 0.2 }\n";

/// A scan of the lamp with wings by the meter that `driver` speaks to, which reads `gain` times its light: the run and
/// what was noted in it.
fn finds_the_light(driver: &str, gain: impl Fn(&Darkroom) -> f64, most: f64) -> (Run, Vec<String>) {
    let document = room(DISTURBED);
    let truth = Room::new(document.clone());
    let (_keep, path) = folder();
    scanned_by(driver, &document, &every_other(IN_MOTION), Target::New(&path), None).unwrap();
    let reduction = reduced(&path);
    let (worst, outside, count) = judged_by(gain(&document), &reduction, &truth);
    assert!(worst < most, "{driver}: worst {worst} of the peak, {count} directions");
    assert!(
        outside < 0.06,
        "{driver}: {outside} of {count} directions lie outside of 2 u"
    );
    let checked = checked(&reduction);
    assert!(checked.starts_with("10 directions"), "{driver}: {checked}");
    let noted = isolux_record::event::read(&path).into_iter();
    let noted = noted.filter_map(|logged| match logged.event {
        Event::Note { message } => Some(message),
        _ => None,
    });
    (Run::read(&path).unwrap(), noted.collect())
}

#[test]
fn a_spectroradiometer_reads_a_lamp_in_motion_by_its_dark_and_v_lambda() {
    for driver in ["ocean-ooi", "ocean-obp"] {
        let gain = |document: &Darkroom| 1.0 + document.spectroradiometer.gain_error_rel;
        let (run, noted) = finds_the_light(driver, gain, 0.008);
        for sweep in &run.sweeps {
            assert_eq!((sweep.of.range, sweep.of.integration_s), (1, 0.1), "{driver}");
            // Peak, sum and a part of the checksum of the counts.
            let numbers = sweep.light.iter().filter(|sample| sample.illuminance_lx.is_some());
            assert!(numbers.clone().all(|sample| sample.raw.len() == 20), "{driver}");
            assert!(numbers.count() > 100, "{driver}");
        }
        let darks = noted.iter().filter(|note| note.contains("dark of the lux meter"));
        let said = |note: &&String| note.contains("at 100ms") && note.contains("SHA-256");
        assert_eq!(darks.filter(said).count(), 1, "{driver}: {noted:?}");
    }
}

#[test]
fn a_profile_that_converts_on_request_reads_a_lamp_in_motion() {
    finds_the_light("ascii-lux", |document| 1.0 + document.luxmeter.gain_error_rel, 0.006);
}

#[test]
fn meters_that_are_too_slow_are_refused_before_motion_with_the_speed_that_would_do() {
    let document = room("");
    let refused = |driver: &str, from: &str, to: &str, word: &str| {
        let (_keep, path) = folder();
        let failure = scanned_with(
            (driver, from, to),
            &document,
            &plan(IN_MOTION),
            Target::New(&path),
            None,
        );
        let failure = failure.map(drop).unwrap_err();
        assert!(
            failure.kind == FailureKind::BadInput && failure.message.contains(word),
            "{driver}: {failure}"
        );
        assert!(Run::read(&path).unwrap().readings.rows.is_empty());
    };
    // 3° a step: 500 ms and the exchange around them.
    for driver in ["ocean-ooi", "ocean-obp"] {
        refused(
            driver,
            "integration_ms=100",
            "integration_ms=500",
            "5.6 °/s would do, or a shorter integration time",
        );
        refused(driver, "&full_scale_lx=285", "", "full_scale_lx, in `open`");
    }
    refused(
        "ascii-lux",
        "template-on-request",
        "template",
        "does not say when it converts",
    );
}

#[test]
fn light_that_fills_a_pixel_has_no_number_and_the_next_try_integrates_for_less() {
    // Full at 68 lx in 100 ms and not at the 285 lx that the station states; the lamp has 117 lx.
    let document = room("[spectroradiometer]\ncounts_per_s = 1.75e7\n[injected_effects]\n");
    let truth = Room::new(document.clone());
    let (_keep, path) = folder();
    scanned_by(
        "ocean-ooi",
        &document,
        &every_other(IN_MOTION),
        Target::New(&path),
        None,
    )
    .unwrap();
    let run = Run::read(&path).unwrap();
    let torn = run.header.sweep.iter().filter(|entry| entry.torn).count();
    assert_eq!(torn, 1, "{:?}", run.notices);
    assert!(
        run.notices
            .iter()
            .any(|notice| notice.contains("the light is over range 1")),
        "{:?}",
        run.notices
    );
    let held = run.sweeps.iter().map(|sweep| (sweep.of.range, sweep.of.integration_s));
    assert!(
        held.clone().all(|held| held == (2, 0.05)),
        "{:?}",
        held.collect::<Vec<_>>()
    );
    let gain = 1.0 + document.spectroradiometer.gain_error_rel;
    let (worst, outside, _) = judged_by(gain, &reduced(&path), &truth);
    assert!(worst < 0.006 && outside < 0.06, "{worst} {outside}");
}
