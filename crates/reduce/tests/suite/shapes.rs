//! Records of any shape: whatever its rows are, a reduction answers or says why not, and their order changes nothing.

use isolux_any_record::{CHANGES, Random, run, run_as_is, shuffled, whole};
use isolux_record::{Reading, ReadingKind};

use isolux_reduce::{Drift, Options, reduce};

/// What a reduction says, to the last bit.
fn stated(rows: Vec<Reading>, options: &Options) -> String {
    match reduce(&run_as_is(rows), options, None) {
        Ok(reduction) => format!("{reduction:?}"),
        Err(error) => error.to_string(),
    }
}

#[test]
fn any_record_is_answered_and_its_order_changes_nothing() {
    let mut answered = 0;
    for round in 0..4 * CHANGES {
        let mut random = Random(round);
        let (changes, rows) = isolux_any_record::rows(round, &mut random);
        for accept_drift in [None, Some("any".to_owned())] {
            let options = Options {
                accept_drift,
                ..Options::default()
            };
            let first = stated(rows.clone(), &options);
            let again = stated(shuffled(rows.clone(), &mut random), &options);
            assert!(first == again, "{changes:?}:\n{first}\n\n{again}");
            answered += u32::from(first.starts_with("Reduction"));
        }
    }
    assert!(answered > 40, "{answered} records have a distribution");
}

/// What is lost of a record by a kill is read again, and the lamp comes back as it was: the numbers of the two burnings
/// are those of one.
#[test]
fn a_lamp_that_comes_back_as_it_was_is_followed_by_its_age() {
    let fading = |rows: &mut Vec<Reading>| {
        for row in rows.iter_mut().filter(|row| row.kind == ReadingKind::Lit) {
            let level = 1.0 + 0.004 * (row.lamp_s.unwrap() - 1800.0) / 600.0;
            row.illuminance_lx = row.illuminance_lx.map(|lux| lux * level);
            (row.u_lx, row.digit_lx) = (Some(0.001), None);
        }
    };
    let mut once = run(whole()).readings.rows;
    fading(&mut once);
    let mut twice = run(whole()).readings.rows;
    let (relit, half) = (twice.len() / 2, twice.len() / 2);
    for (k, row) in twice.iter_mut().enumerate().filter(|(k, _)| *k >= half) {
        let since = row.lamp_s.unwrap() - 1800.0;
        row.lamp_s = Some(1800.0 + since - 3.0 * relit as f64);
        row.time_s = row.time_s.map(|time_s| time_s + 86_400.0);
        (row.session, row.burning) = (1, Some(2));
        assert!(k >= half);
    }
    fading(&mut twice);
    let of = |rows: Vec<Reading>| reduce(&run_as_is(rows), &Options::default(), None).unwrap();
    let (once, twice) = (of(once), of(twice));
    for reduction in [&once, &twice] {
        assert!(
            matches!(reduction.drift, Drift::Linear { rate_per_h, .. } if (rate_per_h - 0.024).abs() < 0.001),
            "{:?}",
            reduction.drift
        );
    }
    let note = |words: &str| twice.notes.iter().any(|note| note.contains(words));
    assert!(note("came back as it was"), "{:?}", twice.notes);
    // The factor is 1 at another age of the lamp; what is left is that.
    let background = once.flux.value / twice.flux.value;
    let centres = [&once, &twice].map(|reduction| reduction.drift.factor(0, 1800.0));
    assert!(
        (background / (centres[1] / centres[0]) - 1.0).abs() < 1e-4,
        "{background} {centres:?}"
    );
}
