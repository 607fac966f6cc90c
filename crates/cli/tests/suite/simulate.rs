//! `simulate` through the program: accuracies, their bounds, and what is refused.

use std::path::{Path, PathBuf};
use std::process::{Command, Output};

const LAMP: &str = "IESNA:LM-63-2002\n[TEST] 1\n[TESTLAB] a\n[ISSUEDATE] b\n[MANUFAC] c\nTILT=NONE\n1 1000 1 7 5 1 2 0 0 0\n1 1 10\n\
0 10 20 30 45 60 90\n0 22.5 45 67.5 90\n\
1000 960 850 690 430 200 0\n1000 955 845 680 420 190 0\n1000 950 840 670 410 185 0\n1000 945 830 660 405 180 0\n1000 940 820 650 400 175 0\n";

const SCENE: &str = r#"format = "isolux-scene/1"
[luminaire]
distribution = "lamp.ies"
ler_lm_per_w = 320.0
[sensor]
size_mm = [60.0, 60.0]
pixels = [96, 64]
distance_mm = 150.0
tilt_x_deg = 12.0
offset_mm = [15.0, -4.0]
"#;

struct Folder(tempfile::TempDir);

impl Folder {
    fn new() -> Self {
        let folder = Self(tempfile::tempdir().unwrap());
        std::fs::write(folder.path("lamp.ies"), LAMP).unwrap();
        folder.scene("scene.toml", SCENE);
        folder
    }

    fn path(&self, name: &str) -> PathBuf {
        self.0.path().join(name)
    }

    fn scene(&self, name: &str, text: &str) {
        std::fs::write(self.path(name), text).unwrap();
    }

    fn isolux(&self, arguments: &[&str]) -> Output {
        Command::new(env!("CARGO_BIN_EXE_isolux"))
            .args(arguments)
            .current_dir(self.0.path())
            .output()
            .unwrap()
    }

    fn simulate(&self, scene: &str, out: &str, more: &[&str]) -> SimulateOutput {
        let mut arguments = vec!["simulate", scene, "--out", out];
        arguments.extend(more);
        let done = self.isolux(&arguments);
        assert!(done.status.success(), "{}", String::from_utf8_lossy(&done.stderr));
        SimulateOutput::read(&self.path(out))
    }
}

/// What a simulation wrote.
struct SimulateOutput {
    map: Vec<f32>,
    result: serde_json::Value,
    files: Vec<String>,
}

impl SimulateOutput {
    fn read(folder: &Path) -> Self {
        let bytes = std::fs::read(folder.join("irradiance.npy")).unwrap();
        let header = 10 + usize::from(u16::from_le_bytes([bytes[8], bytes[9]]));
        let mut files: Vec<String> = std::fs::read_dir(folder)
            .unwrap()
            .map(|entry| entry.unwrap().file_name().into_string().unwrap())
            .collect();
        files.sort();
        Self {
            map: bytes[header..]
                .chunks_exact(4)
                .map(|four| f32::from_le_bytes([four[0], four[1], four[2], four[3]]))
                .collect(),
            result: serde_json::from_slice(&std::fs::read(folder.join("result.json")).unwrap()).unwrap(),
            files,
        }
    }

    fn relative_bound(&self) -> f64 {
        self.result["pixel_error_bound"]["relative"].as_f64().unwrap()
    }
}

#[test]
fn both_accuracies_agree_within_what_they_allow() {
    let folder = Folder::new();
    folder.scene(
        "exact.toml",
        &format!("{SCENE}[simulation]\naccuracy = \"reference\"\n"),
    );
    let extended = SCENE.replace(
        "[sensor]",
        "[luminaire.emitter]\nshape = \"disc\"\ndiameter_mm = 4.0\n[sensor]",
    );
    folder.scene("disc.toml", &extended);
    for scene in ["scene.toml", "disc.toml"] {
        let quick = folder.simulate(scene, &format!("{scene}-standard"), &[]);
        let exact = folder.simulate(scene, &format!("{scene}-reference"), &["--accuracy", "reference"]);
        assert_eq!(quick.result["accuracy"]["name"], "standard");
        assert_eq!(quick.result["accuracy"]["relative"], 1e-5);
        assert_eq!(exact.result["accuracy"]["name"], "reference");
        assert_eq!(quick.files, exact.files);
        assert!(quick.result["accuracy"]["of_allowed"].as_f64().unwrap() <= 1.0);
        assert!(exact.relative_bound() < quick.relative_bound(), "{scene}");
        // The file holds f32: half its last digit.
        let stated = quick.relative_bound() + exact.relative_bound() + 6e-8;
        assert_eq!(quick.map.len(), 96 * 64);
        for (a, b) in quick.map.iter().zip(&exact.map) {
            let off = f64::from((a / b - 1.0).abs());
            assert!(
                *b > 0.0 && off <= stated.min(1e-5),
                "{scene}: {a} {b} differ by {off:e}, stated {stated:e}"
            );
        }
        let bound = quick.result["pixel_error_bound"]["absolute"].as_f64().unwrap();
        let mean = quick.result["u_mean_numeric"].as_f64().unwrap();
        assert!(mean <= bound && mean > 0.0, "{mean} {bound}");
    }
    // The key of the scene does what the option does, and the option has the last word.
    let by_key = folder.simulate("exact.toml", "by-key", &[]);
    let by_option = SimulateOutput::read(&folder.path("scene.toml-reference"));
    assert_eq!(by_key.result["accuracy"]["name"], "reference");
    assert_eq!(by_key.map, by_option.map);
    let back = folder.simulate("exact.toml", "back", &["--accuracy", "standard"]);
    assert_eq!(back.result["accuracy"]["name"], "standard");
}

#[test]
fn an_accuracy_is_the_inverse_methods_and_one_of_two() {
    let folder = Folder::new();
    let rays = folder.simulate("scene.toml", "rays", &["--method", "direct", "--rays", "1e5"]);
    assert!(rays.result["accuracy"].is_null() && rays.result["pixel_error_bound"].is_null());

    folder.scene("bad.toml", &format!("{SCENE}[simulation]\naccuracy = \"fine\"\n"));
    let refused = folder.isolux(&["simulate", "bad.toml", "--out", "bad"]);
    let stated = String::from_utf8_lossy(&refused.stderr).into_owned();
    assert_eq!(refused.status.code(), Some(2), "{stated}");
    assert!(stated.contains("bad.toml:12") && stated.contains("fine"), "{stated}");
    assert!(!folder.path("bad").exists());
}

#[test]
fn a_folder_that_may_not_be_written_is_refused_before_the_light_is_computed() {
    let folder = Folder::new();
    folder.scene("file", "");
    std::fs::create_dir(folder.path("full")).unwrap();
    folder.scene("full/old", "");
    // This sensor looks away, which the solver would say.
    let away = ["simulate", "scene.toml", "--set", "sensor.tilt_x_deg=180", "--out"];
    for (out, more, why) in [
        ("file", &["--force"][..], "file is a file, not a folder"),
        ("full", &[], "full is not empty"),
        ("full", &["--force"], "looks away"),
    ] {
        let refused = folder.isolux(&[&away[..], &[out], more].concat());
        let stated = String::from_utf8_lossy(&refused.stderr).into_owned();
        assert!(
            refused.status.code() == Some(2) && stated.contains(why),
            "{out} {more:?}: {stated}"
        );
    }
}

#[test]
fn a_folder_holds_the_files_of_one_simulation() {
    let folder = Folder::new();
    folder.simulate("scene.toml", "lit", &["--tiff", "--csv", "--html"]);
    let plain = folder.simulate("scene.toml", "lit", &["--force", "--set", "sensor.distance_mm=300"]);
    assert_eq!(plain.files, ["irradiance.npy", "irradiance.png", "result.json"]);
}

#[test]
fn what_would_be_left_aside_is_refused() {
    let folder = Folder::new();
    let model = "format = \"isolux-model/1\"\n[luminaire]\ndistribution = \"lamp.ies\"\n";
    folder.scene("model.toml", model);
    folder.scene(
        "misspelt.toml",
        &format!("{model}[[efect]]\nname = \"vignetting\"\ncoefficient_rel = 0.05\n"),
    );
    folder.scene("other.toml", &model.replace("model/1", "model/9"));
    for name in ["misspelt", "other"] {
        let sensor = SCENE.split_once("[sensor]").unwrap().1;
        let scene = format!("format = \"isolux-scene/1\"\nmodel = \"{name}.toml\"\n[sensor]{sensor}");
        folder.scene(&format!("{name}.scene.toml"), &scene);
    }
    let ler = ["--set", "luminaire.ler_lm_per_w=300.0"];
    let effect = "effect=[{ name = \"vignetting\", coefficient_rel = 0.05 }]";
    let refused: [(&str, &[&str], &str); 9] = [
        ("scene.toml", &["--pixels", "2048x1024"], "comma: 2048,1024"),
        ("scene.toml", &["--sensor-mm", "24.5 × 12"], "comma: 24.5,12"),
        ("scene.toml", &["--rays", "1e5"], "--rays"),
        ("scene.toml", &["--seed", "1"], "--seed"),
        ("scene.toml", &["--sampling", "traced"], "--sampling"),
        ("scene.toml", &["--set", effect, "--set", "effect.0=5"], "effect.0"),
        ("misspelt.toml", &ler, "efect"),
        ("misspelt.scene.toml", &ler, "efect"),
        ("other.scene.toml", &ler, "isolux-model/1"),
    ];
    for (input, more, words) in refused {
        let arguments = [&["simulate", input, "--out", "out"], more].concat();
        let done = folder.isolux(&arguments);
        let stated = String::from_utf8_lossy(&done.stderr);
        assert_eq!(done.status.code(), Some(2), "{arguments:?}: {stated}");
        assert!(stated.contains(words), "{arguments:?}: {stated}");
        assert!(!folder.path("out").exists(), "{arguments:?}");
    }
    folder.simulate("model.toml", "out", &[&ler[..], &["--pixels", "8"]].concat());
}

#[test]
fn the_luminous_area_is_read_whatever_the_file_ends_its_lines_with() {
    let folder = Folder::new();
    std::fs::write(folder.path("wide.ies"), LAMP.replace("1 2 0 0 0", "1 2 0.02 0.03 0")).unwrap();
    let converted = folder.isolux(&["convert", "wide.ies", "lines.ldt"]);
    assert!(
        converted.status.success(),
        "{}",
        String::from_utf8_lossy(&converted.stderr)
    );
    let text = String::from_utf8(std::fs::read(folder.path("lines.ldt")).unwrap()).unwrap();
    std::fs::write(folder.path("cr.ldt"), text.replace("\r\n", "\n").replace('\n', "\r")).unwrap();
    let utf16 = text.encode_utf16().flat_map(u16::to_le_bytes);
    std::fs::write(
        folder.path("utf16.ldt"),
        [0xFF, 0xFE].into_iter().chain(utf16).collect::<Vec<u8>>(),
    )
    .unwrap();
    let near = ["--distance-mm", "60", "--pixels", "16"];
    let mean =
        |name: &str, more: &[&str]| folder.simulate(name, name.trim_end_matches(".ldt"), more).result["mean"].clone();
    let area = [&near[..], &["--luminous-area"]].concat();
    let point = folder.simulate("lines.ldt", "point", &near).result["mean"].clone();
    let wide = mean("lines.ldt", &area);
    assert_ne!(point, wide);
    for name in ["cr.ldt", "utf16.ldt"] {
        assert_eq!(mean(name, &area), wide, "{name}");
    }
}

#[test]
fn ray_files_are_inspected_and_damage_is_named_with_its_bytes() {
    let folder = Folder::new();
    folder.simulate("scene.toml", "rays", &["--rays-out", "lamp.tm25ray", "500"]);
    let bytes = std::fs::read(folder.path("lamp.tm25ray")).unwrap();
    let inspect = |name: &str, bytes: &[u8]| {
        std::fs::write(folder.path(name), bytes).unwrap();
        let done = folder.isolux(&["inspect", name, "--json"]);
        let stated: serde_json::Value = serde_json::from_slice(&done.stdout).unwrap();
        (stated, done.status.code())
    };
    // By content, whatever the name.
    let (good, code) = inspect("lamp.bin", &bytes);
    assert_eq!(
        (&good["format"], &good["kind"], code),
        (&"tm25".into(), &"rays".into(), Some(0))
    );
    assert_eq!(good["findings"], serde_json::json!([]));
    let of = &good["quantities"];
    assert_eq!(
        (of["rays"].as_u64(), of["spectral"].as_str()),
        (Some(500), Some("none"))
    );
    let result = SimulateOutput::read(&folder.path("rays")).result;
    let on_sensor_lm = result["illuminance_lx"].as_f64().unwrap() * 0.06 * 0.06;
    assert!((of["luminous_flux_lm"].as_f64().unwrap() / on_sensor_lm - 1.0).abs() < 1e-5);
    // A point source.
    assert_eq!(of["centroid_mm"], serde_json::json!([0.0, 0.0, 0.0]));

    let (header, ray) = (36_288, 28);
    let cut = &bytes[..bytes.len() - 10];
    let with = |at: usize, new: &[u8]| {
        let mut damaged = bytes.clone();
        damaged[at..at + new.len()].copy_from_slice(new);
        damaged
    };
    let third = header + 2 * ray;
    let end = bytes.len();
    for (name, damaged, finding, span) in [
        ("cut", cut.to_vec(), "tm25-length", [end - 10, end]),
        ("head", bytes[..1000].to_vec(), "tm25-truncated", [1000, header]),
        ("magic.tm25ray", with(0, b"TN"), "tm25-magic", [0, 4]),
        ("flag", with(256, &[3]), "tm25-field", [256, 260]),
        (
            "nan",
            with(third, &f32::NAN.to_le_bytes()),
            "tm25-not-finite",
            [third, third + ray],
        ),
        (
            "zero",
            with(third + 12, &[0; 12]),
            "tm25-no-direction",
            [third, third + ray],
        ),
        (
            "negative",
            with(third + 24, &(-1.0_f32).to_le_bytes()),
            "tm25-negative-flux",
            [third, third + ray],
        ),
    ] {
        let (stated, code) = inspect(name, &damaged);
        let found = stated["findings"]
            .as_array()
            .unwrap()
            .iter()
            .find(|one| one["code"] == finding);
        let found = found.unwrap_or_else(|| panic!("{name}: {stated}"));
        assert_eq!((&found["bytes"], code), (&serde_json::json!(span), Some(1)), "{name}");
        assert_eq!(found["severity"], "error", "{name}");
    }
    // Neither distribution nor spectrum: convert says what to do instead.
    let refused = folder.isolux(&["convert", "lamp.tm25ray", "lamp.ldt"]);
    let stated = String::from_utf8_lossy(&refused.stderr).into_owned() + &String::from_utf8_lossy(&refused.stdout);
    assert!(!refused.status.success() && stated.contains("tm25-rays"), "{stated}");
}
