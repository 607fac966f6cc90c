//! Records of any shape: whatever its rows are, a reduction answers or says why not, and their order changes nothing.

use isolux_record::{Quality, Reading, ReadingKind, Role};

use super::{lamp, run};
use crate::testing::{Random, reading};
use crate::{Options, reduce};

/// Eight half-planes, back and forth, visits to the reference point, dark and baffled readings.
fn whole() -> Vec<Reading> {
    let mut rows = Vec::new();
    let mut time_s = 1800.0;
    let mut read = |kind: ReadingKind, role: Role, c_deg: f64, gamma_deg: f64, lux: f64| {
        time_s += 3.0;
        rows.push(Reading {
            block: kind.to_string(),
            kind,
            role,
            time_s: Some(time_s + 12.0),
            lamp_s: Some(time_s),
            burning: Some(1),
            point: rows.len() as u64,
            ..reading(c_deg, gamma_deg, lux)
        });
    };
    for plane in 0..=8 {
        let c_deg = 45.0 * f64::from(plane);
        read(ReadingKind::Lit, Role::Reference, 0.0, 0.0, lamp(0.0, 0.0) / 100.0);
        for step in 0..=18 {
            let gamma_deg = 10.0 * f64::from(step);
            let lux = 0.03 + lamp(c_deg, gamma_deg) / 100.0;
            read(ReadingKind::Lit, Role::Point, c_deg, gamma_deg, lux);
        }
    }
    for gamma_deg in [0.0, 60.0, 120.0, 180.0] {
        read(ReadingKind::Baffled, Role::Point, 0.0, gamma_deg, 0.03);
    }
    for _ in 0..6 {
        read(ReadingKind::LampOff, Role::Point, 0.0, 0.0, 0.02);
        read(ReadingKind::Capped, Role::Point, 0.0, 0.0, 0.01);
    }
    rows
}

/// One thing that a record can be. Numbers that no file can hold (NaN, ∞) are refused when it is read.
fn change(rows: &mut Vec<Reading>, what: u64, random: &mut Random) {
    let mut some = |share: f64| random.uniform() < share;
    let count = rows.len().max(1);
    match what {
        // Rows left out, some of them or all but one kind, one direction, one reading.
        0 => rows.retain(|_| some(0.7)),
        1 => rows.retain(|_| some(0.03)),
        2 => rows.retain(|row| row.kind == ReadingKind::Lit),
        3 => rows.retain(|row| row.kind != ReadingKind::Lit),
        4 => rows.retain(|row| row.kind == ReadingKind::Capped),
        5 => rows.retain(|row| row.role == Role::Reference),
        6 => rows.retain(|row| row.c_target_deg == 90.0 && row.gamma_target_deg == 40.0),
        7 => rows.truncate(1),
        8 => rows.clear(),
        // Doubled, as copies and as other rows.
        9 => rows.extend(rows.clone()),
        10 => rows.extend(rows.clone().into_iter().map(|row| Reading {
            illuminance_lx: row.illuminance_lx.map(|lux| lux * 1.01),
            ..row
        })),
        // Times that restart, stand still, jump by a week, run backwards, are not known or are of no record.
        11..=17 => {
            for (k, row) in rows.iter_mut().enumerate() {
                let of = |time_s: f64| match what {
                    11 => Some(if 2 * k < count { time_s } else { time_s - 1000.0 }),
                    12 => Some(2000.0),
                    13 => Some(if 2 * k < count { time_s } else { time_s + 604_800.0 }),
                    14 => Some(-time_s),
                    15 => None,
                    16 => Some(if k % 7 == 0 { 1e300 } else { time_s }),
                    _ => Some(time_s * 1e-320),
                };
                row.time_s = row.time_s.and_then(of);
                row.lamp_s = row.lamp_s.and_then(of);
                row.burning = Some(1 + u32::from(what == 11 && 2 * k >= count));
            }
        }
        // Zeros, negatives, uncertainties and digits of any size, no number at all.
        _ => {
            for row in rows {
                match what {
                    18 => row.illuminance_lx = Some(0.0),
                    19 => row.illuminance_lx = row.illuminance_lx.map(|lux| -lux),
                    20 => row.u_lx = Some(1e-12),
                    21 => row.u_lx = Some(1e9),
                    22 => row.digit_lx = None,
                    23 => row.illuminance_lx = row.illuminance_lx.map(|lux| lux * 1e300),
                    24 if some(0.2) => {
                        row.quality = Quality::OverRange;
                        row.illuminance_lx = None;
                        row.u_lx = None;
                    }
                    25 => row.u_lx = None,
                    26 if row.role == Role::Reference => row.illuminance_lx = Some(if some(0.5) { 3.0 } else { 0.0 }),
                    _ => {}
                }
            }
        }
    }
}

const CHANGES: u64 = 27;

/// What a reduction says, to the last bit.
fn said(rows: Vec<Reading>, options: &Options) -> String {
    let mut of = run(Vec::new());
    of.readings.rows = rows;
    match reduce(&of, options, None) {
        Ok(reduction) => format!("{reduction:?}"),
        Err(error) => error.to_string(),
    }
}

fn shuffled(mut rows: Vec<Reading>, random: &mut Random) -> Vec<Reading> {
    for last in (1..rows.len()).rev() {
        rows.swap(last, (random.uniform() * (last + 1) as f64) as usize);
    }
    rows
}

#[test]
fn any_record_is_answered_and_its_order_changes_nothing() {
    let mut answered = 0;
    for round in 0..4 * CHANGES {
        let mut random = Random(round);
        let mut rows = run(whole()).readings.rows;
        let changes = [round % CHANGES, (random.uniform() * CHANGES as f64) as u64];
        // Each alone first, then with another.
        for &what in &changes[..=usize::from(round >= CHANGES)] {
            change(&mut rows, what, &mut random);
        }
        for accept_drift in [None, Some("any".to_owned())] {
            let options = Options {
                accept_drift,
                ..Options::default()
            };
            let first = said(rows.clone(), &options);
            let again = said(shuffled(rows.clone(), &mut random), &options);
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
    let of = |rows: Vec<Reading>| {
        let mut of = run(Vec::new());
        of.readings.rows = rows;
        reduce(&of, &Options::default(), None).unwrap()
    };
    let (once, twice) = (of(once), of(twice));
    for reduction in [&once, &twice] {
        assert!(
            matches!(reduction.drift, crate::Drift::Linear { rate_per_h, .. } if (rate_per_h - 0.024).abs() < 0.001),
            "{:?}",
            reduction.drift
        );
    }
    let note = |words: &str| twice.notes.iter().any(|note| note.contains(words));
    assert!(note("came back as it was"), "{:?}", twice.notes);
    // The factor is 1 at another age of the lamp; what is left is that.
    let levels = once.flux.value / twice.flux.value;
    let centres = [&once, &twice].map(|reduction| reduction.drift.factor(0, 1800.0));
    assert!(
        (levels / (centres[1] / centres[0]) - 1.0).abs() < 1e-4,
        "{levels} {centres:?}"
    );
}
