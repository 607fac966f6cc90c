//! What the model of a scan says between its directions, against the light that the room's lamp gives there: by the
//! whole chain of twins, record, reduction and files.

use camino::{Utf8Path, Utf8PathBuf};
use isolux_darkroom::{Darkroom, Room};
use isolux_model::Model;
use isolux_record::observation::ReadingCoordinates;
use isolux_record::{Plan, ReadingKind};
use isolux_reduce::Options;

const DISTANCE_MM: f64 = 3700.0;

/// The distribution of a day, to the horizontal, and its levels.
fn plan() -> Plan {
    let text = format!(
        "format = \"isolux-plan/1\"\n\
         [[block]]\nname = \"lit\"\nkind = \"lit\"\nc_range = [0, 345, 15]\ngamma_range = [0, 90, 2]\n\
         distance_mm = {DISTANCE_MM:?}\nreference_every = 91\n\
         [[block]]\nname = \"baffled\"\nkind = \"baffled\"\nc_deg = 0\ngamma_range = [0, 180, 10]\nrepeats = 3\n\
         distance_mm = {DISTANCE_MM:?}\n\
         [[block]]\nname = \"capped\"\nkind = \"capped\"\nc_deg = 0\ngamma_deg = 0\nrepeats = 20\n\
         distance_mm = {DISTANCE_MM:?}\n\
         [[block]]\nname = \"off\"\nkind = \"lamp_off\"\nc_deg = 0\ngamma_deg = 0\nrepeats = 20\n\
         distance_mm = {DISTANCE_MM:?}\n"
    );
    Plan::parse(Utf8Path::new("plan.toml"), &text).unwrap()
}

/// Root mean square of the relative errors of the intensities that `model` predicts where there is more than a tenth of
/// the largest, after the factor that all have alike: calibration and distance.
fn rms_rel(model: &Model, room: &Room, at: impl Iterator<Item = (f64, f64)>) -> f64 {
    let least_cd = 0.1 * room.intensity_cd(0.0, 0.0);
    let illuminated: Vec<(f64, f64)> = at
        .filter(|(c, gamma)| room.intensity_cd(*c, *gamma) > least_cd)
        .collect();
    let readings: Vec<ReadingCoordinates> = illuminated
        .iter()
        .map(|(c_deg, gamma_deg)| ReadingCoordinates {
            kind: ReadingKind::Lit,
            time_s: None,
            lamp_s: None,
            c_deg: *c_deg,
            gamma_deg: *gamma_deg,
            distance_mm: DISTANCE_MM,
            travel: 1,
            range: None,
            ambient_c: None,
            head: 0,
        })
        .collect();
    let predicted_lx = model.predict_readings(&readings);
    let logarithms: Vec<f64> = illuminated
        .iter()
        .zip(predicted_lx)
        .map(|((c, gamma), lx)| (lx / room.intensity_cd(*c, *gamma)).ln())
        .collect();
    let count = logarithms.len() as f64;
    let mean = logarithms.iter().sum::<f64>() / count;
    (logarithms.iter().map(|value| (value - mean).powi(2)).sum::<f64>() / count).sqrt()
}

#[test]
fn between_the_directions_of_a_scan_is_the_light_that_it_measured() {
    let document = Darkroom::default();
    let run = crate::in_room::scanned(document.clone(), &plan());
    let room = Room::new(document);
    let reduction = isolux_reduce::reduce(&run, &Options::default(), None).unwrap();
    let folder = tempfile::tempdir().unwrap();
    let path = Utf8PathBuf::try_from(folder.path().to_owned()).unwrap();
    for file in isolux_reduce::files(&reduction, &run, &[], "test").unwrap() {
        std::fs::write(path.join(file.name), file.bytes).unwrap();
    }
    let file = path.join("luminaire.model.toml");
    // The lamp's light, without what the bench adds to a reading.
    let smooth = Model::load(&file).unwrap().with_effects(Vec::new());
    let text = std::fs::read_to_string(&file).unwrap();
    let linear = Model::parse(
        &file,
        &text
            .replace("\"smooth\"", "\"linear\"")
            .replace("shape = \"linear\"", ""),
    )
    .unwrap();
    let linear = linear.with_effects(Vec::new());

    let directions = || (0..24).flat_map(|c| (0..46).map(move |gamma| (15.0 * f64::from(c), 2.0 * f64::from(gamma))));
    let middles = || directions().map(|(c, gamma)| (c + 7.5, gamma + 1.0));
    let read = rms_rel(&smooth, &room, directions());
    let [smooth, linear] = [smooth, linear].map(|model| rms_rel(&model, &room, middles()));
    // The smoothing of the readings has taken what noise neighbours do not share, so that none is left to average out:
    // between directions the light is known as at them. Straight lines are off by more than that.
    assert!(
        (smooth / read - 1.0).abs() < 0.02,
        "{smooth} between directions, {read} at them"
    );
    assert!(linear > 2.0 * read, "{linear} between directions, {read} at them");
}
