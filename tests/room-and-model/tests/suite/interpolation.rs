//! What a model says between the directions of its file, against the light that the room's lamp gives there: the lamp
//! of the built-in room, measured without error at the directions of a day's plan, in a file of EULUMDAT.

use camino::Utf8PathBuf;
use isolux_darkroom::{Darkroom, Room};
use isolux_formats::eulumdat::{self, Header, LampSet};
use isolux_model::Model;
use isolux_photometry::IntensityDistribution;
use isolux_record::ReadingKind;
use isolux_record::observation::ReadingCoordinates;

const DISTANCE_MM: f64 = 3700.0;

/// Half-planes of 15°, γ in steps of 2°.
fn directions() -> (Vec<f64>, Vec<f64>) {
    let every = |count: u32, step: f64| (0..count).map(|i| f64::from(i) * step).collect();
    (every(24, 15.0), every(91, 2.0))
}

/// The day's files, without what its readings would be off.
fn model(folder: &tempfile::TempDir, room: &Room, interpolation: &str) -> Model {
    let path = Utf8PathBuf::try_from(folder.path().to_owned()).unwrap();
    let (c_deg, gamma_deg) = directions();
    let intensity_cd = c_deg
        .iter()
        .flat_map(|c| gamma_deg.iter().map(|gamma| room.intensity_cd(*c, *gamma)))
        .collect();
    let distribution = IntensityDistribution::new(c_deg, gamma_deg, intensity_cd).unwrap();
    let header = Header {
        lamp_sets: vec![LampSet {
            count: Some(-1.0),
            flux_lm: Some(distribution.flux_lm()),
            ..LampSet::default()
        }],
        ..Header::default()
    };
    let file = eulumdat::write(&distribution, &header).unwrap();
    std::fs::write(path.join("lamp.ldt"), file.bytes).unwrap();
    let text = format!(
        "format = \"isolux-model/1\"\n[luminaire]\ndistribution = \"lamp.ldt\"\ninterpolation = \"{interpolation}\"\n"
    );
    Model::parse(&path.join("lamp.model.toml"), &text).unwrap()
}

fn reading(c_deg: f64, gamma_deg: f64) -> ReadingCoordinates {
    ReadingCoordinates {
        kind: ReadingKind::Lit,
        time_s: None,
        lamp_s: None,
        c_deg,
        gamma_deg,
        distance_mm: DISTANCE_MM,
        travel: 1,
        range: None,
        ambient_c: None,
        head: 0,
    }
}

/// Largest relative error of predicted readings where there is more than 1 % of the largest intensity.
fn largest_error(model: &Model, room: &Room, at: impl Iterator<Item = (f64, f64)>) -> f64 {
    let least_cd = 0.01 * room.intensity_cd(0.0, 0.0);
    let illuminated: Vec<(f64, f64)> = at
        .filter(|(c, gamma)| room.intensity_cd(*c, *gamma) > least_cd)
        .collect();
    assert!(illuminated.len() > 500, "{}", illuminated.len());
    let readings: Vec<ReadingCoordinates> = illuminated.iter().map(|(c, gamma)| reading(*c, *gamma)).collect();
    let predicted_lx = model.predict_readings(&readings);
    let error = |((c, gamma), lx): (&(f64, f64), &f64)| {
        let truth_lx = room.intensity_cd(*c, *gamma) / (DISTANCE_MM * DISTANCE_MM) * 1e6;
        (lx / truth_lx - 1.0).abs()
    };
    illuminated.iter().zip(&predicted_lx).map(error).fold(0.0, f64::max)
}

fn between() -> impl Iterator<Item = (f64, f64)> {
    (0..20_000).map(|i| (f64::from(i) * 137.507_764 % 360.0, f64::from(i) * 0.0045))
}

#[test]
fn between_the_directions_of_the_file_is_the_light_of_the_lamp() {
    let folder = tempfile::tempdir().unwrap();
    for seed in 1..=3 {
        let room = Room::new(Darkroom {
            seed,
            ..Darkroom::default()
        });
        let [smooth, linear] = ["smooth", "linear"].map(|how| model(&folder, &room, how));
        let of = |model: &Model| largest_error(model, &room, between());
        let (c_deg, gamma_deg) = directions();
        let nodes = c_deg.iter().flat_map(|c| gamma_deg.iter().map(|gamma| (*c, *gamma)));
        let file = largest_error(&smooth, &room, nodes);
        let (smooth, linear) = (of(&smooth), of(&linear));
        assert!(smooth < 5e-4, "seed {seed}: {smooth}");
        assert!(linear > 5e-3, "seed {seed}: {linear}");
        // What EULUMDAT rounds is a hundredth of that.
        assert!(file < 5e-6, "seed {seed}: {file}");
    }
}
