//! Numbers that no bench has, in every key of a scene: each is refused with the file and the line of its key.

use camino::Utf8PathBuf;
use isolux_model::{Emitter, Luminaire, Model, Scene, Spectral, read_distribution};

/// A scene with every key that takes a number, one a line.
const SCENE: &str = r#"format = "isolux-scene/1"
[luminaire]
distribution = "d.csv"
flux_lm = 100.0
ler_lm_per_w = 300.0
[luminaire.emitter]
shape = "disc"
diameter_mm = 1.0
[luminaire.u]
intensity_rel = 0.01
flux_rel = 0.01
ler_rel = 0.01
direction_rel = 0.01
direction_cd = 0.01
[luminaire.refined]
ln_shape = [0.1]
gamma_max_deg = 90.0
map_gain = 1.0
tan2 = 0.1
tan4 = 0.1
tan_gamma_max_deg = 60.0
[[effect]]
name = "gamma_zero"
offset_deg = 0.1
[[effect]]
name = "floor_reflection"
albedo = 0.1
height_mm = 1000.0
[[effect]]
name = "lamp_warmup"
amplitude_rel = 0.1
time_constant_s = 100.0
[sensor]
size_mm = [24.0, 24.0]
pixels = [4, 2]
distance_mm = 500.0
tilt_x_deg = 1.0
tilt_y_deg = 1.0
rot_z_deg = 1.0
offset_mm = [1.0, 2.0]
time_s = 10.0
background_w_m2 = 0.1
[[window]]
index = 1.5
thickness_mm = 1.0
transmittance = 0.9
[vapour]
epsilon_l_per_mol_cm = 1.0
concentration_mol_l = 0.1
length_mm = 10.0
[target]
reflectance = 0.5
[lens]
focal_mm = 10.0
f_number = 2.0
distance_mm = 100.0
transmittance = 0.9
barrel_mm = 1.0
"#;

struct Folder(tempfile::TempDir);

impl Folder {
    fn new() -> Self {
        let folder = tempfile::tempdir().unwrap();
        std::fs::write(
            folder.path().join("d.csv"),
            "gamma_deg,intensity_cd\n0,100\n45,70\n90,0\n",
        )
        .unwrap();
        Self(folder)
    }

    fn path(&self, name: &str) -> Utf8PathBuf {
        Utf8PathBuf::try_from(self.0.path().join(name)).unwrap()
    }

    fn scene(&self, text: &str) -> Result<Scene, String> {
        let folder = self.path("");
        Scene::parse(&self.path("scene.toml"), text).map_err(|error| error.to_string().replace(folder.as_str(), ""))
    }
}

/// The value of a line's key, or none for a line without a number.
fn number(line: &str) -> Option<(&str, &str)> {
    let (key, value) = line.split_once(" = ")?;
    value
        .trim_start_matches('[')
        .starts_with(|first: char| first.is_ascii_digit())
        .then_some((key, value))
}

#[test]
fn every_number_that_cannot_be_is_refused_at_its_line() {
    let folder = Folder::new();
    folder.scene(SCENE).unwrap();
    let lines: Vec<&str> = SCENE.lines().collect();
    let mut tried = 0;
    for (index, line) in lines.iter().enumerate() {
        let Some((key, value)) = number(line) else { continue };
        // Each place of a list on its own: a rule on the sum or on the least of both would let one pass.
        let places = value.matches(',').count() + 1;
        for place in 0..places {
            for absurd in ["nan", "inf", "-inf", "1e308", "-1e308"] {
                let parts: Vec<&str> = value.trim_matches(['[', ']']).split(", ").collect();
                let changed: Vec<&str> = (0..places)
                    .map(|k| if k == place { absurd } else { parts[k] })
                    .collect();
                let changed = if value.starts_with('[') {
                    format!("[{}]", changed.join(", "))
                } else {
                    changed.join(", ")
                };
                let mut text = lines.clone();
                let changed = format!("{key} = {changed}");
                text[index] = &changed;
                let described = folder.scene(&text.join("\n"));
                let described = described
                    .map(|_| ())
                    .expect_err(&format!("line {}: {changed}", index + 1));
                // The numbers of a refit are judged together.
                let own = described.starts_with(&format!("scene.toml:{}:", index + 1));
                let together = described.contains("luminaire.refined: its numbers");
                assert!(own || together, "{changed}: {described}");
                tried += 1;
            }
        }
    }
    assert_eq!(tried, 5 * 43, "a key was added: is it in the scene above?");
}

#[test]
fn counts_beyond_memory_are_refused() {
    let folder = Folder::new();
    let described = |from: &str, to: &str| {
        assert!(SCENE.contains(from));
        folder.scene(&SCENE.replace(from, to)).unwrap_err()
    };
    let pixels = described("pixels = [4, 2]", "pixels = [50000, 50000]");
    assert!(
        pixels.contains("sensor.pixels: 50000 × 50000 pixels; at most"),
        "{pixels}"
    );
    assert!(described("pixels = [4, 2]", "pixels = 0").contains("sensor.pixels: 0 is not within 1 to"));
    let disc = "shape = \"disc\"\ndiameter_mm = 1.0";
    let leds = "shape = \"leds\"\nradius_mm = [10.0]\ncount = [4000000000]";
    assert!(described(disc, leds).contains("4000000000 LEDs; at most"));
}

#[test]
fn wrong_types_name_the_key_and_what_is_needed() {
    let folder = Folder::new();
    let described = |from: &str, to: &str| folder.scene(&SCENE.replace(from, to)).unwrap_err();
    let pixels = described("pixels = [4, 2]", "pixels = [inf, 64]");
    assert!(
        pixels.starts_with("scene.toml:35:") && pixels.contains("sensor.pixels") && pixels.contains("whole numbers"),
        "{pixels}"
    );
    let distance = described("distance_mm = 500.0", "distance_mm = \"500\"");
    assert!(
        distance.contains("`sensor.distance_mm` is the text \"500\"; a number is needed, as in distance_mm = 500"),
        "{distance}"
    );
}

#[test]
fn files_that_are_none_are_refused_where_they_are_named() {
    let folder = Folder::new();
    for (from, to, line) in [
        ("distribution = \"d.csv\"", "distribution = \"absent.ldt\"", 3),
        #[cfg(unix)]
        ("distribution = \"d.csv\"", "distribution = \"/dev/zero\"", 3),
        (
            "transmittance = 0.9\n[vapour]",
            "transmittance = \"absent.csv\"\n[vapour]",
            46,
        ),
        ("time_s = 10.0", "responsivity = \"absent.csv\"", 41),
    ] {
        let described = folder.scene(&SCENE.replace(from, to)).unwrap_err();
        assert!(
            described.starts_with(&format!("scene.toml:{line}:1: ")),
            "{to}: {described}"
        );
    }
    let elsewhere =
        "format = \"isolux-scene/1\"\nmodel = \"absent.toml\"\n[sensor]\nsize_mm = 1\npixels = 1\ndistance_mm = 1\n";
    let described = folder.scene(elsewhere).unwrap_err();
    assert!(described.starts_with("scene.toml:2:1: model: "), "{described}");
    // With a model from elsewhere the one that is named need not be there.
    let lamp = read_distribution(&folder.path("d.csv")).unwrap();
    let model = Model::of(Luminaire::new(lamp, Emitter::Point {}, Spectral::None));
    Scene::parse_with(&folder.path("scene.toml"), elsewhere, &model).unwrap();
}

#[test]
fn an_effect_that_replaces_the_emitter_twice_is_refused_wherever_the_model_stands() {
    let folder = Folder::new();
    let near = "[[effect]]\nname = \"near_field\"\nradius_mm = 20\n";
    std::fs::write(
        folder.path("m.toml"),
        format!("format = \"isolux-model/1\"\n[luminaire]\ndistribution = \"d.csv\"\n{near}"),
    )
    .unwrap();
    let text = format!(
        "format = \"isolux-scene/1\"\nmodel = \"m.toml\"\n{near}[sensor]\nsize_mm = 1\npixels = 1\ndistance_mm = 100\n"
    );
    let described = folder.scene(&text).unwrap_err();
    assert!(described.contains("`near_field` is there twice"), "{described}");
}
