//! Scenes by another hand, with reference maps from high-order quadrature: frames, tilt order, symmetry, units, means.
//!
//! `ISOLUX_SCENES` names their folder; without it the tests say so and pass.

#![expect(clippy::print_stdout, reason = "a test says what it found and what it skipped")]

use camino::Utf8PathBuf;
use isolux_model::{Effect, Scene};
use isolux_record::observation::{MapSet, Need, Observations, open};

fn scenes() -> Option<Utf8PathBuf> {
    let folder = std::env::var("ISOLUX_SCENES").ok().map(Utf8PathBuf::from);
    if folder.is_none() {
        println!("skipped: ISOLUX_SCENES names no folder");
    }
    folder
}

/// The bins of a sensor as a set of one map.
fn as_maps(scene: &Scene, unit: &str) -> MapSet {
    let folder = tempfile::tempdir().unwrap();
    let path = Utf8PathBuf::try_from(folder.path().join("maps.toml")).unwrap();
    let sensor = &scene.sensor;
    let pose = &sensor.pose;
    let text = format!(
        "sensor_mm = {:?}\nbins = {:?}\nunit = \"{unit}\"\n[[map]]\nname = \"m\"\ndistance_mm = {:?}\ntilt_x_deg = {:?}\n\
         tilt_y_deg = {:?}\nrot_z_deg = {:?}\noffset_mm = [{:?}, {:?}]\n",
        sensor.size_mm,
        sensor.pixels,
        pose.distance_mm,
        pose.tilt_x_deg,
        pose.tilt_y_deg,
        pose.rot_z_deg,
        pose.offset_mm.x,
        pose.offset_mm.y
    );
    std::fs::write(&path, text).unwrap();
    match open(&path, Need::Coordinates).unwrap() {
        Observations::Maps(maps) => maps,
        other => panic!("{other:?}"),
    }
}

#[test]
fn predicted_maps_are_the_reference() {
    let Some(scenes) = scenes() else { return };
    // The interpolant has corners at the grid's angles, which one to four nodes a pixel and a disc do not meet exactly;
    // `simulate` does.
    for (name, unit, within) in [
        ("ring-paper-tilt", "W/m2", 1e-4),
        ("tilted-pose", "lx", 3e-4),
        ("isym3-45", "W/m2", 1e-3),
        ("uneven-grid", "lx", 2e-3),
    ] {
        let scene = Scene::load(&scenes.join(name).join("scene.toml")).unwrap();
        let predicted = scene.model.predict_maps(&as_maps(&scene, unit));
        let bytes = std::fs::read(scenes.join(name).join("reference.npy")).unwrap();
        let reference: Vec<f64> = bytes[bytes.len() - 8 * predicted.len()..]
            .chunks_exact(8)
            .map(|chunk| f64::from_le_bytes(chunk.try_into().unwrap()))
            .collect();
        let worst = predicted
            .iter()
            .zip(&reference)
            .map(|(p, r)| (p / r - 1.0).abs())
            .fold(0.0, f64::max);
        let mean = predicted.iter().sum::<f64>() / reference.iter().sum::<f64>() - 1.0;
        println!("{name}: worst pixel {worst:.1e}, mean {mean:.1e}");
        assert!(
            worst < within && mean.abs() < 2e-5,
            "{name}: worst {worst}, mean {mean}"
        );
    }
}

#[test]
fn a_ring_at_a_distance_is_the_file_and_near_by_it_is_not() {
    let Some(scenes) = scenes() else { return };
    let scene = Scene::load(&scenes.join("ring-paper-tilt/scene.toml")).unwrap();
    for aim_deg in [0.0, 6.0] {
        let ring = Effect::from_keys("near_field", [("radius_mm", 28.0), ("aim_deg", aim_deg)]).unwrap();
        let with_ring = scene.model.with_effects(vec![ring]);
        let mut far = scene.clone();
        far.sensor.pose.distance_mm = 1e7;
        let (point, ring) = (
            far.model.predict_maps(&as_maps(&far, "W/m2")),
            with_ring.predict_maps(&as_maps(&far, "W/m2")),
        );
        let apart = point
            .iter()
            .zip(&ring)
            .map(|(p, r)| (r / p - 1.0).abs())
            .fold(0.0, f64::max);
        // Left over is −½(n + 3)(R/d)² and, for LEDs that lean inward, (n·tan ψ)·R/d.
        assert!(apart < 3e-6, "aim {aim_deg}: {apart}");
        let point: f64 = scene.model.predict_maps(&as_maps(&scene, "W/m2")).iter().sum();
        let ring: f64 = with_ring.predict_maps(&as_maps(&scene, "W/m2")).iter().sum();
        println!("aim {aim_deg}: {:+.2} % at 500 mm", 100.0 * (ring / point - 1.0));
        assert!((ring / point - 1.0).abs() > 0.005);
    }
}
