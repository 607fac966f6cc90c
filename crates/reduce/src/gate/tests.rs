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
            time_s: row.time_s.unwrap(),
            value: row.illuminance_lx.unwrap() * 100.0,
            u: 0.3,
            digit: 1.0,
        })
        .collect();
    let seen = Seen {
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
    // ± 1.1 %, in turns: scatter, no drift.
    let scatter = findings(13, |n| 3.0 * (1.0 + 0.011 * (-1.0_f64).powf(n)));
    assert_eq!(scatter.len(), 1);
    assert!(scatter[0].what.contains("reference_rel 1.00 %"), "{}", scatter[0].what);
    // At 0.3 lx one digit is 3 %, and a visit that shows the next digit says nothing.
    assert_eq!(findings(13, |n| if n == 5.0 { 0.31 } else { 0.30 }), []);
}
