//! Records of any shape: what reads a record, a reduction, a report, the page, gives a clear answer or a clear error of
//! each, and the order of its rows changes nothing.

use camino::{Utf8Path, Utf8PathBuf};
use isolux_record::readings::Readings;
use isolux_record::run::{Run, RunHeader};
use isolux_record::{Plan, Quality, Reading, ReadingKind, Role, Station};

/// The changes that [`change`] knows.
pub const CHANGES: u64 = 27;

/// Round `round` of records: the numbers of its changes, each alone first and then with another, and its rows.
pub fn rows(round: u64, random: &mut Random) -> (Vec<u64>, Vec<Reading>) {
    let mut rows = run(whole()).readings.rows;
    let mut changes = vec![round % CHANGES, (random.uniform() * CHANGES as f64) as u64];
    changes.truncate(1 + usize::from(round >= CHANGES));
    for &what in &changes {
        change(&mut rows, what, random);
    }
    (changes, rows)
}

/// The run with these rows as they are.
pub fn run_as_is(rows: Vec<Reading>) -> Run {
    let mut run = run(Vec::new());
    run.readings.rows = rows;
    run
}

/// Eight half-planes, back and forth, visits to the reference point, dark and baffled readings.
pub fn whole() -> Vec<Reading> {
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
pub fn change(rows: &mut Vec<Reading>, what: u64, random: &mut Random) {
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

/// The rows in another order.
pub fn shuffled(mut rows: Vec<Reading>, random: &mut Random) -> Vec<Reading> {
    for last in (1..rows.len()).rev() {
        rows.swap(last, (random.uniform() * (last + 1) as f64) as usize);
    }
    rows
}

/// A bench whose lux meter stands 10 m away.
pub const STATION: &str = r#"format = "isolux-station/1"
[bench]
type = "turning_luminaire"
distance_mm = 10000.0
u_distance_mm = 5.0
u_gamma_deg = 0.05
[axis.c]
open = "fake:c"
counts_per_deg = "1000/1"
zero_deg = 0.0
sense = 1
limit_deg = [-5.0, 365.0]
speed_deg_s = 20.0
accel_deg_s2 = 40.0
[axis.gamma]
open = "fake:gamma"
counts_per_deg = "1000/1"
zero_deg = 0.0
sense = 1
limit_deg = [-185.0, 185.0]
speed_deg_s = 20.0
accel_deg_s2 = 40.0
[luxmeter]
open = "fake:lux"
calibration_factor = 1.0
u_rel = 0.008
"#;

/// One point.
pub const PLAN: &str =
    "format = \"isolux-plan/1\"\n[[block]]\nname = \"lit\"\nkind = \"lit\"\nc_deg = 0\ngamma_deg = 0\n";

/// A run with these rows, which are numbered as they stand.
///
/// # Panics
/// Never: station and plan are those of this file.
pub fn run(mut rows: Vec<Reading>) -> Run {
    rows.iter_mut()
        .enumerate()
        .for_each(|(index, row)| row.index = index as u64);
    Run {
        path: Utf8PathBuf::from("run"),
        header: RunHeader::new(
            "test".to_owned(),
            "2026-01-01T00:00:00Z".to_owned(),
            Vec::new(),
            None,
            Station::parse(Utf8Path::new("s.toml"), STATION).expect("a station and a plan"),
            Plan::parse(Utf8Path::new("p.toml"), PLAN).expect("a station and a plan"),
        ),
        readings: Readings::of(rows),
        notices: Vec::new(),
        spectra: Vec::new(),
        sweeps: Vec::new(),
    }
}

/// I = 337·cos γ·(1 + 0.02·cos 2C·sin²γ) cd in front, nothing behind: flux 337·π lm.
pub fn lamp(c_deg: f64, gamma_deg: f64) -> f64 {
    let (gamma, c) = (gamma_deg.to_radians(), c_deg.to_radians());
    337.0 * gamma.cos().max(0.0) * (1.0 + 0.02 * (2.0 * c).cos() * gamma.sin().powi(2))
}

/// SplitMix64: uniform and normal numbers.
pub struct Random(pub u64);

impl Random {
    /// In [0, 1).
    pub fn uniform(&mut self) -> f64 {
        self.0 = self.0.wrapping_add(0x9E37_79B9_7F4A_7C15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
        ((z ^ (z >> 31)) >> 11) as f64 / (1u64 << 53) as f64
    }

    /// Of the standard normal distribution.
    pub fn normal(&mut self) -> f64 {
        (-2.0 * (1.0 - self.uniform()).ln()).sqrt() * (std::f64::consts::TAU * self.uniform()).cos()
    }
}

/// A lit reading at 10 m with a digit of 0.01 lx.
pub fn reading(c_deg: f64, gamma_deg: f64, illuminance_lx: f64) -> Reading {
    Reading {
        index: 0,
        block: "lit".to_owned(),
        kind: ReadingKind::Lit,
        time_s: Some(2000.0),
        c_deg,
        gamma_deg,
        distance_mm: 10_000.0,
        travel: 1,
        range: 1,
        ambient_c: Some(25.0),
        illuminance_lx: Some(illuminance_lx),
        u_lx: Some(0.01 / 12.0_f64.sqrt()),
        quality: Quality::Ok,
        role: Role::Point,
        point: 0,
        repeat: 0,
        c_target_deg: c_deg,
        gamma_target_deg: gamma_deg,
        digit_lx: Some(0.01),
        integration_s: Some(0.5),
        raw: String::new(),
        session: 0,
        burning: None,
        lamp_s: None,
        electrical: isolux_record::Electrical::default(),
    }
}
