//! An effect that the model's file has already, and that another day changes.

use camino::Utf8Path;
use isolux_diagnose::assumed::{AssumedModel, Part};
use isolux_diagnose::forward::{Forward as _, Hypothesis, Searchable};
use isolux_model::Model;
use isolux_record::ReadingKind;
use isolux_record::observation::ReadingCoordinates;

fn assumed(effects: &str) -> AssumedModel {
    let folder = tempfile::tempdir().unwrap();
    let folder = Utf8Path::from_path(folder.path()).unwrap();
    let distribution = "gamma_deg,intensity_cd\n0,100\n45,60\n90,0\n";
    std::fs::write(folder.join("distribution.csv"), distribution).unwrap();
    let model = format!(
        "format = \"isolux-model/1\"\n[luminaire]\ndistribution = \"distribution.csv\"\n\
         emitter = {{ shape = \"disc\", diameter_mm = 1.0 }}\n{effects}"
    );
    std::fs::write(folder.join("m.toml"), model).unwrap();
    let at = |time_s: f64| ReadingCoordinates {
        kind: ReadingKind::Lit,
        time_s: Some(time_s),
        lamp_s: Some(time_s),
        c_deg: 0.0,
        gamma_deg: 0.0,
        distance_mm: 2000.0,
        travel: 0,
        range: None,
        ambient_c: None,
        head: 0,
    };
    let readings = (0..20).map(|k| at(300.0 * f64::from(k))).collect();
    AssumedModel::new(
        Model::load(&folder.join("m.toml")).unwrap(),
        vec![Part::Readings(readings)],
    )
}

fn drift(assumed: &AssumedModel) -> usize {
    let is_drift = |effect: &Searchable| effect.name == "lamp_drift";
    assumed.effects().iter().position(is_drift).expect("lamp_drift")
}

#[test]
fn a_changed_drift_counts_from_a_time_of_its_own() {
    let known = assumed("[[effect]]\nname = \"lamp_drift\"\nrate_per_h = 0.002\nreference_s = 5000.0\n");
    let effect = drift(&known);
    assert_eq!(known.effects()[effect].shapes, [[0.0], [7200.0]]);
    let (more_per_h, from_s) = (0.01, 1200.0);
    let values = known.values(&Hypothesis {
        effect,
        linear: vec![more_per_h],
        shape: vec![from_s],
    });
    for time_s in [0.0, 1800.0, 7000.0] {
        let both = 0.002 * (time_s - 5000.0) + more_per_h * (time_s - from_s);
        assert!((values[0] * (time_s - values[1]) - both).abs() < 1e-9, "{values:?}");
    }
    // Two drifts that cancel are no drift, and no time.
    let none = known.values(&Hypothesis {
        effect,
        linear: vec![-0.002],
        shape: vec![5000.0],
    });
    assert!(none[0].abs() < 1e-15 && none[1].is_finite(), "{none:?}");
    // Where the file has no drift its level is the lamp's own.
    let without = assumed("");
    assert!(without.effects()[drift(&without)].shapes.iter().all(Vec::is_empty));
}
