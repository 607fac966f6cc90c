//! Answers of a meter that converts by its own clock, whose phase no one says, against that clock.

use super::*;
use crate::sweeps::tests::sweep;

const PERIOD_S: f64 = 0.500_06;
const PHASE_S: f64 = 0.337;
/// From a request to the moment at which the meter takes its last conversion.
const TAKEN_S: f64 = 0.015;
const DIGIT_LX: f64 = 0.1;

/// When the conversion that is complete at `at_s` ended, of a clock that is `slip_s` late from 30 s on.
fn ended_s(at_s: f64, slip_s: f64) -> f64 {
    let end_s = |late_s: f64| PHASE_S + late_s + ((at_s - PHASE_S - late_s) / PERIOD_S).floor() * PERIOD_S;
    let late_s = end_s(slip_s);
    if late_s > 30.0 { late_s } else { end_s(0.0).min(30.0) }
}

/// A sweep of a minute with answers at `asked_s`, of light that is `light` at the end of a conversion.
fn answers(asked_s: impl Iterator<Item = f64>, slip_s: f64, light: impl Fn(f64) -> f64) -> SweepRecord {
    let mut record = sweep(0);
    (record.of.integration_s, record.of.update_interval_s) = (0.5, Some(0.5));
    let sample = |asked_s: f64| LightSample {
        asked_s,
        answered_s: asked_s + 0.05,
        illuminance_lx: Some((light(ended_s(asked_s + TAKEN_S, slip_s)) / DIGIT_LX).round() * DIGIT_LX),
        digit_lx: DIGIT_LX,
        raw: String::new(),
    };
    record.light = asked_s.map(sample).collect();
    record
}

/// Requests every `every_s`, not quite evenly.
fn requests(every_s: f64) -> impl Iterator<Item = f64> {
    let count = (60.0 / every_s) as u32;
    (0..count).map(move |k| f64::from(k) * every_s + 0.004 * (f64::from(k) * 78.233).sin())
}

/// Light over most of a minute.
fn bell(at_s: f64) -> f64 {
    180.0 * (-((at_s - 30.0) / 12.0).powi(2)).exp()
}

/// By how much the ends of its conversions are wrong, s.
fn errors_s(own: &ByOwnClock, slip_s: f64) -> Vec<f64> {
    let error = |conversion: &Conversion| conversion.to_s + TAKEN_S - ended_s(conversion.to_s + TAKEN_S + 0.25, slip_s);
    own.conversions.iter().map(error).collect()
}

#[test]
fn the_clock_is_found_to_what_its_uncertainty_says() {
    for every_s in [0.049, 0.064, 0.11, 0.171, 0.19] {
        let own = ByOwnClock::of(&answers(requests(every_s), 0.0, bell)).unwrap();
        let OwnClock { period_s, u_s, .. } = own.clock;
        assert!((period_s - PERIOD_S).abs() < 2e-4, "{every_s}: {period_s}");
        assert!(u_s < 0.08 * every_s, "{every_s}: {u_s}");
        let errors = errors_s(&own, 0.0);
        let worst = errors.iter().fold(0.0_f64, |worst, error| worst.max(error.abs()));
        assert!(worst < 2.5 * u_s, "{every_s}: {worst} of {u_s}");
        assert!(errors.len() > 110 && own.unclear == 0, "{every_s}: {}", errors.len());
        for conversion in &own.conversions {
            assert!((conversion.illuminance_lx - bell(conversion.to_s + TAKEN_S)).abs() < 0.51 * DIGIT_LX + 0.1);
            assert!((conversion.to_s - conversion.from_s - period_s).abs() < 1e-9);
        }
    }
}

#[test]
fn requests_in_step_with_the_meter_leave_its_phase_open() {
    // Each conversion is seen to end between the same two of five requests: anywhere between them.
    let even = (0..600).map(|k| f64::from(k) * PERIOD_S / 5.0);
    let own = ByOwnClock::of(&answers(even, 0.0, bell)).unwrap();
    assert!(own.clock.u_s > 0.9 * 0.1 / 12.0_f64.sqrt(), "{:?}", own.clock);
    let worst = errors_s(&own, 0.0)
        .into_iter()
        .fold(0.0_f64, |worst, error| worst.max(error.abs()));
    assert!(worst < 2.0 * own.clock.u_s, "{worst} {:?}", own.clock);
}

#[test]
fn a_clock_that_slips_gives_no_conversion_of_another_moment() {
    for slip_s in [0.08, 0.15, 0.25, 0.4] {
        let own = ByOwnClock::of(&answers(requests(0.064), slip_s, bell)).unwrap();
        assert!(own.unclear > 5 || slip_s < 0.2, "{slip_s}: {}", own.unclear);
        // A small slip is taken for another period, as long as no end lies farther from its requests than this.
        let allowed_s = 0.06;
        // Where the light changes from one conversion to the next; far out one is as good as the other.
        for (conversion, error_s) in own.conversions.iter().zip(errors_s(&own, slip_s)) {
            let change = (bell(conversion.to_s) - bell(conversion.to_s + PERIOD_S)).abs();
            assert!(
                change < 2.0 * DIGIT_LX || error_s.abs() < allowed_s,
                "{slip_s}: {conversion:?} {error_s}"
            );
        }
    }
}

#[test]
fn one_answer_with_a_wrong_digit_is_no_conversion() {
    let mut record = answers(requests(0.064), 0.0, bell);
    for place in (5..record.light.len()).step_by(37) {
        record.light[place].illuminance_lx = Some(99.9);
    }
    let own = ByOwnClock::of(&record).unwrap();
    assert!(
        own.conversions
            .iter()
            .all(|conversion| conversion.illuminance_lx != 99.9)
    );
    assert!(own.conversions.len() > 100, "{}", own.conversions.len());
}

#[test]
fn light_that_does_not_change_shows_no_phase() {
    let own = ByOwnClock::of(&answers(requests(0.064), 0.0, |_| 42.0)).unwrap();
    assert_eq!(own.clock.u_s, 0.5 / 12.0_f64.sqrt());
    assert!(
        own.conversions.len() > 115
            && own
                .conversions
                .iter()
                .all(|conversion| conversion.illuminance_lx == 42.0)
    );
    assert_eq!(ByOwnClock::of(&sweep(0)), None, "it converts on request");
}
