use super::*;
use crate::testing::reading;
use isolux_record::Role;

/// Visits every 300 s whose values are `value(n)`.
fn visited(count: u64, value: impl Fn(f64) -> f64) -> (Reference, Vec<Reading>) {
    let rows: Vec<Reading> = (0..count)
        .map(|n| Reading {
            index: n,
            role: Role::Reference,
            time_s: Some(1800.0 + 300.0 * n as f64),
            ..reading(0.0, 0.0, value(n as f64))
        })
        .collect();
    let visits = rows
        .iter()
        .map(|row| Visit {
            row: row.index,
            lamp_s: row.time_s.unwrap(),
            value: row.illuminance_lx.unwrap() * 100.0,
            u: 0.3,
            digit: 1.0,
        })
        .collect();
    let seen = crate::drift::Seen {
        first_row: 0,
        visits,
        unknown_rel: 0.0,
    };
    (Reference { burnings: vec![seen] }, rows)
}

fn findings(count: u64, value: impl Fn(f64) -> f64) -> Vec<Finding> {
    let (reference, rows) = visited(count, value);
    of_reference(&reference, &Limits::default(), &rows)
}

#[test]
fn a_stable_lamp_passes_and_a_dark_visit_is_named() {
    assert_eq!(findings(26, |_| 3.41), []);
    assert_eq!(findings(26, |n| ((3.41 - 0.002 * n) * 100.0).round() / 100.0), []);
    // A shutter that another process closed during one visit.
    let dark = findings(26, |n| if n == 12.0 { 0.01 } else { 3.41 });
    assert_eq!(dark.len(), 2, "{dark:?}");
    for finding in &dark {
        assert_eq!(finding.rows.iter().map(|row| row.row).collect::<Vec<_>>(), [12]);
        let text = finding.to_string();
        assert!(text.contains("row 12 at 5400 s, C 0° γ 0°, 0.01 lx"), "{text}");
    }
}

#[test]
fn drift_and_scatter_have_each_their_limit_and_the_digit_on_top() {
    // ± 3 % in a straight line: a drift, no scatter.
    let drift = findings(13, |n| 3.0 * (1.0 - 0.005 * n));
    assert_eq!(drift.len(), 1);
    assert!(drift[0].what.contains("drift_rel 2.00 %"), "{}", drift[0].what);
    // ± 1.1 %, in turns: jumps, no drift.
    let jumps = findings(13, |n| 3.0 * (1.0 + 0.011 * (-1.0_f64).powf(n)));
    assert_eq!(jumps.len(), 1);
    assert!(jumps[0].what.contains("reference_rel 1.00 %"), "{}", jumps[0].what);
    // At 0.3 lx one digit is 3 %, and a visit that shows the next digit says nothing.
    assert_eq!(findings(13, |n| if n == 5.0 { 0.31 } else { 0.30 }), []);
}

#[test]
fn whatever_the_scan_went_on_with_is_no_finding() {
    let limits = Limits::default();
    // Slow drifts of many forms, straight and bent, from 0.1 % to 4 % in all and back, and noise on some.
    let (mut accepted, mut ended) = (0, 0);
    for form in 0..200_u32 {
        let size = 0.001 + 0.0004 * f64::from(form % 100);
        let value = |n: f64| {
            let along = n / 60.0;
            let shape = match form % 4 {
                0 => along,
                1 => 1.0 - (-3.0 * along).exp(),
                2 => (std::f64::consts::TAU * along).sin() / 2.0,
                _ => along + 0.02 * (17.0 * n).sin(),
            };
            ((30.0 * (1.0 + size * shape)) * 100.0).round() / 100.0
        };
        // As the engine does: every visit against those before.
        let mut followed = Steadiness::default();
        let goes_on = (0..61).all(|n| {
            let next = Seen {
                illuminance_lx: value(f64::from(n)),
                digit_lx: 0.01,
            };
            followed.drifted(next, &limits).is_none() && followed.follow(next, &limits)
        });
        let found = findings(61, value);
        if goes_on {
            accepted += 1;
            assert_eq!(found, [], "form {form}");
        } else {
            ended += 1;
        }
    }
    assert!(accepted > 100 && ended > 5, "{accepted} accepted, {ended} ended");
}
