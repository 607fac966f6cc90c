//! A job of which something cannot be: refused with its place before anything moves, and nothing is written.

use crate::folder::Folder;

const PLAN: &str = r#"format = "isolux-plan/1"
[[block]]
name = "distribution"
kind = "lit"
c_range = [0, 360, 45]
gamma_range = [0, 90, 5]
[[block]]
name = "spectrum"
kind = "lit"
instrument = "spectroradiometer"
c_deg = 0
gamma_deg = 0
repeats = 3
"#;

/// A place of one of the job's files and what stands there instead.
type Change<'a> = (&'a str, &'a str, &'a str);

fn changed(changes: &[Change<'_>]) -> Folder {
    let folder = Folder::new();
    folder.isolux(&["init", "bench"], 0);
    folder.write("bench/plan.toml", PLAN);
    for (file, from, to) in changes {
        let file = format!("bench/{file}");
        let text = folder.read(&file);
        assert!(text.contains(from), "{file} has no {from}");
        folder.write(&file, &text.replacen(from, to, 1));
    }
    folder
}

#[test]
fn a_day_that_cannot_be_is_refused_before_anything_moves() {
    let scene = |from, to| ("scene.toml", from, to);
    let pixels = |to| scene("pixels = [2048, 2048]", to);
    let distance = |to| scene("distance_mm = 500.0", to);
    let plan = |from, to| ("plan.toml", from, to);
    let job = |from, to| ("job.toml", from, to);
    let diagnose = |to| job("# [diagnose]", to);
    let spectrum = &PLAN[PLAN.find("[[block]]\nname = \"spectrum\"").unwrap()..];
    let cases: &[(&[Change<'_>], &str)] = &[
        (&[pixels("pixels = [inf, 64]")], "scene.toml:8:10: `sensor.pixels`"),
        (
            &[pixels("pixels = [0, 64]")],
            "scene.toml:8:1: sensor.pixels: 0 is not within 1",
        ),
        (
            &[pixels("pixels = 30000")],
            "scene.toml:8:1: sensor.pixels: 30000 × 30000 pixels; at most",
        ),
        (
            &[scene("size_mm = [24.576, 24.576]", "size_mm = [nan, 24.0]")],
            "scene.toml:7:1: sensor.size_mm: NaN is not within",
        ),
        (
            &[distance("distance_mm = 0")],
            "scene.toml:9:1: sensor.distance_mm: 0 is not within 0.001 to 1000000",
        ),
        (
            &[distance("distance_mm = \"500\"")],
            "a number is needed, as in distance_mm = 500",
        ),
        (
            &[distance("distance_mm = 500.0\ntilt_x_deg = 180.0")],
            "scene.toml: the sensor's face looks away",
        ),
        (
            &[distance("distance_mm = 500.0\nresponsivity = \"absent.csv\"")],
            "scene.toml:10:1: sensor.responsivity",
        ),
        (
            &[distance("distance_mm = 0.3\ntilt_x_deg = 60")],
            "scene.toml: the sensor cuts through the source",
        ),
        (
            &[
                plan("[0, 90, 5]", "[0, 20, 5]"),
                distance("distance_mm = 500.0\noffset_mm = [0.0, 500.0]\ntilt_x_deg = -45.0"),
            ],
            "scene.toml: no light reaches the sensor: the distribution covers γ from 0° to 20°",
        ),
        (
            &[
                plan(spectrum, ""),
                distance("distance_mm = 500.0\nbackground_w_m2 = 0.1"),
            ],
            "background_w_m2 = 0.1 needs the model's spectrum",
        ),
        (
            &[plan("c_range = [0, 360, 45]", "c_range = [0, 200, 50]")],
            "plan.toml: the half-planes do not go round",
        ),
        (
            &[plan("kind = \"lit\"", "kind = \"capped\"")],
            "plan.toml: the run has no lit readings",
        ),
        (
            &[job("scene = \"scene.toml\"", "scene = \"absent.toml\"")],
            "job.toml:5:1: scene: ",
        ),
        (
            &[job("scene = \"scene.toml\"", "scene = \"/dev/zero\"")],
            "job.toml:5:1: scene: /dev/zero is a device",
        ),
        (
            &[diagnose(
                "[diagnose]\nmodel = \"plan.toml\"\nobservations = [\"plan.toml\"]\n#",
            )],
            "plan.toml:1:10: format is \"isolux-plan/1\", expected \"isolux-model/1\"",
        ),
        (
            &[diagnose("[diagnose]\nmodel = \"plan.toml\"\nobservations = []\n#")],
            "job.toml:9:1: diagnose.observations: a diagnosis needs at least one",
        ),
    ];
    for (changes, described) in cases {
        let folder = changed(changes);
        let stated = folder.isolux(&["run", "bench/job.toml", "--out", "day"], 2);
        assert!(stated.contains(described), "{changes:?}:\n{stated}");
        assert!(!folder.path("day").exists(), "{changes:?}: something was written");
    }
}

#[test]
fn no_number_of_a_sweep_or_of_maps_passes_that_cannot_be() {
    let folder = Folder::new();
    folder.write("lamp.csv", "gamma_deg,intensity_cd\n0,300\n30,200\n90,0\n");
    folder.write(
        "model.toml",
        "format = \"isolux-model/1\"\n[luminaire]\ndistribution = \"lamp.csv\"\n",
    );
    let maps = "sensor_mm = [24.0, 24.0]\nbins = [2, 2]\nunit = \"lx\"\n[[map]]\nname = \"a\"\ndistance_mm = 500.0\nexposure = 1.0\n";
    folder.write("maps.toml", maps);
    folder.isolux(&["predict", "model.toml", "maps.toml", "--out", "good.csv"], 0);
    for (from, to, line) in [
        ("[24.0, 24.0]", "[nan, 24.0]", 1),
        ("[24.0, 24.0]", "[24.0, nan]", 1),
        ("[24.0, 24.0]", "[24.0, 1e308]", 1),
        ("[2, 2]", "[2, 4000000]", 2),
        ("[2, 2]", "[60000, 60000]", 2),
        ("500.0", "1e308", 6),
        ("500.0", "nan", 6),
        ("exposure = 1.0", "exposure = 1e300", 7),
        ("exposure = 1.0", "tilt_x_deg = 1e9", 7),
        ("exposure = 1.0", "time_s = nan", 7),
        ("exposure = 1.0", "ambient_c = inf", 7),
        ("exposure = 1.0", "lamp = 1", 7),
    ] {
        folder.write("maps.toml", &maps.replace(from, to));
        let stated = folder.isolux(&["predict", "model.toml", "maps.toml", "--out", "bad.csv"], 2);
        assert!(stated.contains(&format!("maps.toml:{line}: ")), "{to}:\n{stated}");
        assert!(!folder.path("bad.csv").exists(), "{to}");
    }
}

#[cfg(unix)]
#[test]
fn a_device_in_place_of_a_file_is_refused_wherever_it_is_named() {
    let folder = Folder::new();
    folder.write("lamp.csv", "gamma_deg,intensity_cd\n0,300\n30,200\n90,0\n");
    folder.write(
        "zero.toml",
        "format = \"isolux-model/1\"\n[luminaire]\ndistribution = \"/dev/zero\"\n",
    );
    folder.write(
        "model.toml",
        "format = \"isolux-model/1\"\n[luminaire]\ndistribution = \"lamp.csv\"\n",
    );
    folder.isolux(
        &["virtual", "darkroom", "--in-memory", "--station-out", "station.toml"],
        0,
    );
    let pipe = std::process::Command::new("mkfifo")
        .arg(folder.path("pipe"))
        .status()
        .unwrap();
    assert!(pipe.success());
    for arguments in [
        &["diagnose", "zero.toml", "model.toml", "--out", "out"][..],
        &["diagnose", "/dev/zero", "model.toml", "--out", "out"],
        &["diagnose", "model.toml", "/dev/zero", "--out", "out"],
        &["diagnose", "model.toml", "pipe", "--out", "out"],
        &["predict", "model.toml", "/dev/zero", "--out", "out"],
        &["simulate", "/dev/zero", "--out", "out"],
        &["simulate", "model.toml", "--spectrum", "/dev/zero", "--out", "out"],
        &["simulate", "model.toml", "--spectrum", "pipe", "--out", "out"],
        &["plan", "/dev/zero", "model.toml"],
        &["plan", "pipe", "model.toml"],
        &["plan", "station.toml", "pipe"],
        &["run", "/dev/zero", "--out", "out"],
        &["sweep", "/dev/zero", "--out", "out"],
        &["sweep", "pipe", "--out", "out"],
        &["scan", "pipe", "pipe", "--out", "out"],
        &["virtual", "darkroom", "/dev/zero", "--lasts-s", "0"],
        &["virtual", "capture", "/dev/zero", "/dev/zero", "--out", "maps.toml"],
    ] {
        let stated = folder.isolux(arguments, 2);
        assert!(
            stated.contains("a device, pipe or socket") || stated.contains("pipe or device"),
            "{arguments:?}: {stated}"
        );
        assert!(!folder.path("out").exists(), "{arguments:?}");
    }
    // A device without end is read up to the limit that inspect states.
    let stated = folder.isolux(&["inspect", "/dev/zero"], 1);
    assert!(stated.contains("there is no end; more than"), "{stated}");
}
