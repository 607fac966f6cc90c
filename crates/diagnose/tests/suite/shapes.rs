//! Records of any shape: whatever its rows are, a diagnosis answers or says why not, and their order changes nothing.

use std::panic::{AssertUnwindSafe, catch_unwind};

use camino::Utf8Path;
use isolux_diagnose::diagnosis::diagnose;
use isolux_diagnose::search::Settings;
use isolux_model::Model;
use isolux_record::observation::{Need, open};
use rand::seq::SliceRandom as _;
use rand::{RngExt as _, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rand_distr::StandardNormal;

const MODEL: &str = r#"format = "isolux-model/1"
[luminaire]
distribution = "distribution.csv"
emitter = { shape = "disc", diameter_mm = 1.0 }
[luminaire.trust]
shape = "smooth"
c_harmonics = [2]
"#;

const HEADER: &str = "index,block,kind,time_s,c_deg,gamma_deg,distance_mm,travel,range,ambient_c,illuminance_lx,u_lx";

fn intensity_cd(gamma_deg: f64) -> f64 {
    350.0 * gamma_deg.to_radians().cos().max(0.0).powi(2)
}

#[derive(Clone)]
struct Reading {
    index: Option<u32>,
    kind: &'static str,
    time_s: Option<f64>,
    c_deg: f64,
    gamma_deg: f64,
    lux: f64,
    u: f64,
}

/// Six half-planes with visits to the axis, and dark readings.
fn whole(random: &mut ChaCha8Rng) -> Vec<Reading> {
    let mut rows: Vec<Reading> = Vec::new();
    let mut read = |kind: &'static str, c_deg: f64, gamma_deg: f64, lux: f64| {
        let u = (0.003 * lux).hypot(0.002);
        rows.push(Reading {
            index: Some(rows.len() as u32),
            kind,
            time_s: Some(1800.0 + 3.0 * rows.len() as f64),
            c_deg,
            gamma_deg,
            lux: lux + u * random.sample::<f64, _>(StandardNormal),
            u,
        });
    };
    for plane in 0..6 {
        read("lit", 0.0, 0.0, intensity_cd(0.0) / 4.0);
        for step in -6..=6 {
            let gamma_deg = 12.0 * f64::from(step);
            read("lit", 30.0 * f64::from(plane), gamma_deg, intensity_cd(gamma_deg) / 4.0);
        }
    }
    for _ in 0..5 {
        read("lamp_off", 0.0, 0.0, 0.0);
        read("capped", 0.0, 0.0, 0.0);
        read("baffled", 0.0, 0.0, 0.0);
    }
    rows
}

/// The changes of a record: some rows left out, kinds alone, one direction, doubled without numbers; times that
/// restart, stand still, jump by a week, run backwards, are not known, are of no record; numbers of the rows that are
/// scrambled; zeros, negatives, uncertainties of any size.
fn change(rows: &mut Vec<Reading>, what: usize, random: &mut ChaCha8Rng) {
    let count = rows.len().max(1);
    match what {
        0 => rows.retain(|_| random.random_range(0.0..1.0) < 0.6),
        1 => rows.retain(|row| row.kind == "lit"),
        2 => rows.retain(|row| row.kind == "capped"),
        3 => rows.retain(|row| row.kind != "lit"),
        4 => rows.retain(|row| row.c_deg == 0.0 && row.gamma_deg == 0.0),
        5 => rows.truncate(1),
        6 => rows.extend(rows.clone()),
        7 => rows.iter_mut().for_each(|row| row.index = None),
        8 => {
            let mut numbers: Vec<u32> = (0..count as u32).map(|number| 97 * number).collect();
            numbers.shuffle(random);
            for (row, number) in rows.iter_mut().zip(numbers) {
                row.index = Some(number);
            }
        }
        _ => {
            for (k, row) in rows.iter_mut().enumerate() {
                let late = 2 * k >= count;
                match what {
                    9 => row.time_s = row.time_s.map(|time_s| if late { time_s - 120.0 } else { time_s }),
                    10 => row.time_s = Some(2000.0),
                    11 => row.time_s = row.time_s.map(|time_s| if late { time_s + 604_800.0 } else { time_s }),
                    12 => row.time_s = row.time_s.map(|time_s| -time_s),
                    13 => row.time_s = None,
                    14 if k % 9 == 0 => row.time_s = Some(1e300),
                    15 => row.time_s = row.time_s.map(|time_s| 1e-320 * time_s),
                    16 => row.lux = 0.0,
                    17 => row.lux = -row.lux,
                    18 => row.u = 1e-12,
                    19 => row.u = 1e9,
                    20 => row.u = if k % 5 == 0 { 1e-12 } else { 1e9 },
                    21 => row.lux *= 1e200,
                    _ => {}
                }
            }
        }
    }
    if what == 6 {
        for row in rows.iter_mut() {
            row.index = None;
        }
    }
}

const CHANGES: usize = 22;

fn csv(rows: &[Reading]) -> String {
    let number = |value: Option<f64>| value.map_or_else(String::new, |value| format!("{value:e}"));
    let line = |row: &Reading| {
        let index = row.index.map_or_else(String::new, |index| index.to_string());
        format!(
            "{index},{},{},{},{},{},2000,1,1,25,{:e},{:e}\n",
            row.kind,
            row.kind,
            number(row.time_s),
            row.c_deg,
            row.gamma_deg,
            row.lux,
            row.u
        )
    };
    rows.iter()
        .map(line)
        .fold(format!("{HEADER}\n"), |text, line| text + &line)
}

/// What a diagnosis says of these rows, to the last bit, or what is wrong with them.
fn stated(folder: &Utf8Path, model: &Model, rows: &[Reading]) -> Result<String, String> {
    let file = folder.join("readings.csv");
    std::fs::write(&file, csv(rows)).unwrap();
    let observations = match open(&file, Need::Values) {
        Ok(observations) => [observations],
        Err(error) => return Err(error.to_string()),
    };
    let settings = Settings {
        nulls: 60,
        ..Settings::default()
    };
    match diagnose(model, &observations, None, "of any", &settings) {
        Ok(found) => Ok(format!("{:?}", found.document)),
        Err(error) => Err(error.to_string()),
    }
}

#[test]
fn any_record_is_answered_and_its_order_changes_nothing() {
    let keep = tempfile::tempdir().unwrap();
    let folder = Utf8Path::from_path(keep.path()).unwrap();
    let mut distribution = String::from("gamma_deg,intensity_cd\n");
    for gamma in (0..=180).step_by(6) {
        distribution += &format!("{gamma},{}\n", intensity_cd(f64::from(gamma)));
    }
    std::fs::write(folder.join("distribution.csv"), distribution).unwrap();
    std::fs::write(folder.join("m.toml"), MODEL).unwrap();
    let model = Model::load(&folder.join("m.toml")).unwrap();
    let mut answered = 0;
    for round in 0..4 * (CHANGES + 1) {
        let mut random = ChaCha8Rng::seed_from_u64(round as u64);
        let mut rows = whole(&mut random);
        // Each alone first, the last being none, then with another.
        let what = [round % (CHANGES + 1), random.random_range(0..CHANGES)];
        for &one in &what[..=usize::from(round > CHANGES)] {
            change(&mut rows, one, &mut random);
        }
        let mut other = rows.clone();
        other.shuffle(&mut random);
        let of = |rows: &[Reading]| {
            catch_unwind(AssertUnwindSafe(|| stated(folder, &model, rows)))
                .unwrap_or_else(|_| panic!("a panic in the record of changes {what:?}"))
        };
        let (first, again) = (of(&rows), of(&other));
        // The line that an error names is that of the file.
        let words = |text: String| {
            text.chars()
                .filter(|letter| !letter.is_ascii_digit())
                .collect::<String>()
        };
        let (first, again) = (first.map_err(words), again.map_err(words));
        assert!(first == again, "changes {what:?}:\n{first:?}\n\n{again:?}");
        answered += u32::from(first.is_ok());
    }
    assert!(answered > 40, "{answered} records are enough for a diagnosis");
}
