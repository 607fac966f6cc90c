//! Cost of one call of each prediction, on coordinates like those of a diagnosis.

use camino::Utf8PathBuf;
use isolux_model::{Effect, Emitter, Luminaire, Model, Spectral};
use isolux_photometry::IntensityDistribution;
use isolux_record::ReadingKind;
use isolux_record::observation::{MapSet, Need, Observations, ReadingCoordinates, open};

fn main() {
    divan::main();
}

fn model() -> Model {
    let gamma_deg: Vec<f64> = (0..=90).map(f64::from).collect();
    let intensity_cd = gamma_deg
        .iter()
        .map(|g| 350.0 * g.to_radians().cos().max(0.0).powi(5))
        .collect();
    let distribution = IntensityDistribution::new(vec![0.0], gamma_deg, intensity_cd).unwrap();
    Model::of(Luminaire::new(
        distribution,
        Emitter::Disc { diameter_mm: 1.0 },
        Spectral::None,
    ))
}

fn readings() -> Vec<ReadingCoordinates> {
    (0..500)
        .map(|i| ReadingCoordinates {
            kind: ReadingKind::Lit,
            time_s: Some(4.0 * f64::from(i)),
            lamp_s: None,
            c_deg: 15.0 * f64::from(i / 29 % 24),
            gamma_deg: -70.0 + 5.0 * f64::from(i % 29),
            distance_mm: [2000.0, 1000.0, 3000.0][(i / 170) as usize],
            travel: 1,
            range: Some(1),
            ambient_c: Some(24.0),
            head: 0,
        })
        .collect()
}

fn maps() -> MapSet {
    let folder = tempfile::tempdir().unwrap();
    let path = Utf8PathBuf::try_from(folder.path().join("maps.toml")).unwrap();
    let mut text = "sensor_mm = 24.576\nbins = 24\nunit = \"relative\"\n".to_owned();
    for (i, distance) in [500, 500, 300, 150, 300, 300, 300, 500, 500].iter().enumerate() {
        let tilt = if i == 4 { 40 } else { 0 };
        text += &format!("[[map]]\nname = \"{i}\"\ndistance_mm = {distance}\ntilt_x_deg = {tilt}\n");
    }
    std::fs::write(&path, text).unwrap();
    match open(&path, Need::Coordinates).unwrap() {
        Observations::Maps(maps) => maps,
        other => panic!("{other:?}"),
    }
}

fn with(name: &str, keys: &[(&str, f64)]) -> Model {
    model().with_effects(vec![Effect::from_keys(name, keys.iter().copied()).unwrap()])
}

const CASES: [&str; 5] = [
    "none",
    "gamma_zero",
    "near_field",
    "near_field_aimed",
    "floor_reflection",
];

fn case(name: &str) -> Model {
    match name {
        "gamma_zero" => with(name, &[("offset_deg", 0.1)]),
        "near_field" => with(name, &[("radius_mm", 28.0)]),
        "near_field_aimed" => with("near_field", &[("radius_mm", 28.0), ("aim_deg", 5.0)]),
        "floor_reflection" => with(name, &[("albedo", 0.3), ("height_mm", 1200.0)]),
        _ => model(),
    }
}

#[divan::bench(args = CASES)]
fn five_hundred_readings(bencher: divan::Bencher<'_, '_>, name: &str) {
    let (model, readings) = (case(name), readings());
    bencher.bench(|| model.predict_readings(&readings));
}

#[divan::bench(args = ["none", "near_field", "near_field_aimed"])]
fn nine_maps_of_24_by_24(bencher: divan::Bencher<'_, '_>, name: &str) {
    let (model, maps) = (case(name), maps());
    bencher.bench(|| model.predict_maps(&maps));
}
