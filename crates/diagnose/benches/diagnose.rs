//! Cost of a whole diagnosis, observations already read: `cargo bench -p isolux-diagnose`.
//!
//! Goniometer readings of 500, 2,400, 10,000 and 100,000, nine maps of 24², 256² and 333² (10⁶ pixels), each clean and
//! with an effect in it; 2,000 simulated noise-only scans each.

use std::fmt::Write as _;

use camino::Utf8PathBuf;
use isolux_diagnose::diagnosis::diagnose;
use isolux_diagnose::search::Settings;
use isolux_model::{Effect, Model};
use isolux_record::observation::{Need, Observations, open};
use rand::{RngExt as _, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rand_distr::StandardNormal;

fn main() {
    divan::main();
}

const MODEL: &str = r#"format = "isolux-model/1"
[luminaire]
distribution = "distribution.csv"
emitter = { shape = "disc", diameter_mm = 1.0 }
[luminaire.trust]
shape = "smooth"
c_harmonics = [2]
"#;

/// The model, and observations of it with `effect` and noise.
fn case(coordinates: &str, file: &str, effect: Option<Effect>) -> (Model, Observations) {
    let folder = tempfile::tempdir().unwrap();
    let path = |name: &str| Utf8PathBuf::try_from(folder.path().join(name)).unwrap();
    let mut distribution = String::from("gamma_deg,intensity_cd\n");
    for gamma in 0..=90 {
        let cosine = f64::from(gamma).to_radians().cos().max(0.0);
        let _ = writeln!(distribution, "{gamma},{}", 350.0 * cosine.powi(5));
    }
    std::fs::write(path("distribution.csv"), distribution).unwrap();
    std::fs::write(path("model.toml"), MODEL).unwrap();
    std::fs::write(path(file), coordinates).unwrap();
    let model = Model::load(&path("model.toml")).unwrap();
    let truth = model.with_effects(effect.into_iter().collect());
    let mut rng = ChaCha8Rng::seed_from_u64(5);
    let mut noisy = |value: f64, rel: f64, floor: f64| {
        let u = (rel * value).hypot(floor);
        (value + u * rng.sample::<f64, _>(StandardNormal), u)
    };
    match open(&path(file), Need::Coordinates).unwrap() {
        Observations::Readings(readings) => {
            let at: Vec<_> = readings.rows().iter().map(|row| row.at).collect();
            let mut lines = coordinates.lines();
            let mut csv = format!("{},illuminance_lx,u_lx\n", lines.next().unwrap());
            for (line, value) in lines.zip(truth.predict_readings(&at)) {
                let (value, u) = noisy(value, 0.003, 0.01);
                let _ = writeln!(csv, "{line},{value:.6},{u:.6}");
            }
            std::fs::write(path(file), csv).unwrap();
        }
        Observations::Maps(maps) => {
            let mut csv = String::from("map,iy,ix,signal,u\n");
            for (cell, value) in maps.cells().iter().zip(truth.predict_maps(&maps)) {
                let (value, u) = noisy(value, 0.003, 1e-4);
                let name = &maps.maps()[cell.map as usize].name;
                let _ = writeln!(csv, "{name},{},{},{value:.6},{u:.6}", cell.iy, cell.ix);
            }
            std::fs::write(path("maps.csv"), csv).unwrap();
        }
        Observations::Spectra(_) => unreachable!("no spectra here"),
    }
    let observations = open(&path(file), Need::Values).unwrap();
    (model, observations)
}

fn readings(count: usize) -> String {
    let mut csv = String::from("index,block,kind,time_s,c_deg,gamma_deg,distance_mm,travel,range,ambient_c\n");
    let planes = count.div_ceil(29);
    for i in 0..count {
        let (plane, k) = (i / 29, i % 29);
        let travel = if plane % 2 == 0 { 1 } else { -1 };
        let gamma = f64::from(travel) * (5.0 * k as f64 - 70.0);
        let distance = [2000, 1000, 3000][3 * plane / planes];
        let (kind, time) = if i % 50 == 0 {
            ("capped", 4 * i)
        } else {
            ("lit", 4 * i + 100)
        };
        let ambient = 24.5 + 0.5 * (time as f64 / 900.0).sin();
        let c = (plane * 15) % 360;
        let _ = writeln!(csv, "{i},A,{kind},{time},{c},{gamma},{distance},{travel},1,{ambient}");
    }
    csv
}

fn maps(bins: usize) -> String {
    let mut text = format!("sensor_mm = 24.576\nbins = {bins}\nunit = \"relative\"\n");
    for (i, (distance, tilt, exposure)) in [
        (500, 0, 1.0),
        (500, 0, 0.5),
        (300, 0, 0.36),
        (150, 0, 0.09),
        (300, 40, 0.36),
        (300, -40, 0.36),
        (300, 0, 0.36),
        (500, 0, 1.0),
        (500, 0, 1.0),
    ]
    .iter()
    .enumerate()
    {
        let _ = write!(
            text,
            "[[map]]\nname = \"m{i}\"\ndistance_mm = {distance}\ntilt_x_deg = {tilt}\nrot_z_deg = {}\nexposure = {exposure}\nlamp = {}\ncapped = {}\n",
            if i == 6 { 90 } else { 0 },
            i != 7,
            i == 8
        );
    }
    text
}

fn run(bencher: divan::Bencher<'_, '_>, (model, observations): (Model, Observations)) {
    let settings = Settings::default();
    let observations = [observations];
    bencher.bench(|| diagnose(&model, &observations, None, "", &settings).unwrap());
}

fn effect(name: &str, keys: &[(&str, f64)]) -> Effect {
    Effect::from_keys(name, keys.iter().copied()).unwrap()
}

#[divan::bench(args = [500, 2400, 10_000], sample_count = 3, sample_size = 1)]
fn clean_readings(bencher: divan::Bencher<'_, '_>, count: usize) {
    run(bencher, case(&readings(count), "readings.csv", None));
}

#[divan::bench(args = [100_000], sample_count = 1, sample_size = 1)]
fn very_many_clean_readings(bencher: divan::Bencher<'_, '_>, count: usize) {
    run(bencher, case(&readings(count), "readings.csv", None));
}

#[divan::bench(args = [500, 2400], sample_count = 3, sample_size = 1)]
fn readings_with_a_warm_up(bencher: divan::Bencher<'_, '_>, count: usize) {
    let warm_up = effect("lamp_warmup", &[("amplitude_rel", 0.03), ("time_constant_s", 400.0)]);
    run(bencher, case(&readings(count), "readings.csv", Some(warm_up)));
}

#[divan::bench(args = [24, 256, 333], sample_count = 3, sample_size = 1)]
fn nine_clean_maps(bencher: divan::Bencher<'_, '_>, bins: usize) {
    run(bencher, case(&maps(bins), "maps.toml", None));
}

#[divan::bench(args = [24, 256], sample_count = 3, sample_size = 1)]
fn nine_maps_with_a_tilt(bencher: divan::Bencher<'_, '_>, bins: usize) {
    let tilt = effect("sensor_tilt", &[("angle_deg", 0.3), ("azimuth_deg", 40.0)]);
    run(bencher, case(&maps(bins), "maps.toml", Some(tilt)));
}
