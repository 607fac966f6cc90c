//! A lamp of one spectrum with the effect `colour_over_angle` on a wide sensor: watts by the closed form.

use camino::Utf8PathBuf;
use isolux_model::Scene;
use isolux_sim::simulation::{Method, simulate};

/// The map of a sensor of 400 mm before a point source of 100 cd in all directions.
fn map(effect: &str) -> (Vec<f64>, Vec<&'static str>) {
    let keep = tempfile::tempdir().unwrap();
    let folder = Utf8PathBuf::try_from(keep.path().to_owned()).unwrap();
    std::fs::write(
        folder.join("even.csv"),
        "gamma_deg,intensity_cd\n0,100\n90,100\n180,100\n",
    )
    .unwrap();
    let model = format!(
        "format = \"isolux-model/1\"\n[luminaire]\ndistribution = \"even.csv\"\nler_lm_per_w = 300.0\n\
         emitter = {{ shape = \"point\" }}\n{effect}"
    );
    std::fs::write(folder.join("model.toml"), model).unwrap();
    let text = "format = \"isolux-scene/1\"\nmodel = \"model.toml\"\n[sensor]\nsize_mm = 400.0\npixels = 41\n\
                distance_mm = 500.0\n";
    let scene = Scene::parse(&folder.join("scene.toml"), text).unwrap();
    let applied = scene.model.in_simulation().applied;
    let simulation = simulate(&scene, Method::Inverse, &|| 0.0).unwrap();
    (simulation.map.iter().map(|value| f64::from(*value)).collect(), applied)
}

#[test]
fn a_lumen_has_other_watts_away_from_the_axis() {
    let effect = "[[effect]]\nname = \"colour_over_angle\"\nsensor_rel = 0.2\n";
    let ((changed, applied), (plain, _)) = (map(effect), map(""));
    assert_eq!(applied, ["colour_over_angle"]);
    for pixel in [0, 20, 20 * 41 + 20, 7 * 41 + 31] {
        let place = |k: usize| (k as f64 - 20.0) * 400.0 / 41.0;
        let square = place(pixel % 41).powi(2) + place(pixel / 41).powi(2);
        let expected = 1.0 + 0.2 * square / (square + 500.0 * 500.0);
        let found = changed[pixel] / plain[pixel];
        assert!((found / expected - 1.0).abs() < 1e-4, "{pixel}: {found}, {expected}");
    }
}
