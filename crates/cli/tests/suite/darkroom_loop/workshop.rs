//! A folder with a healthy room, its scan and the operator's model, and the two loops.

use std::fmt::Write as _;
use std::ops::Deref;
use std::path::Path;

use serde_json::Value;

use crate::darkroom_loop::cases::Case;
use crate::darkroom_loop::maps;
use crate::folder::{Folder, stated};

/// An ordinary room: a lamp of binned LEDs that warms up and is steady then. At 3.6 m its axis has four digits of the
/// lux meter, and the near field of its rings is 0.03 %.
const ROOM: &str = "\
format = \"isolux-darkroom/1\"
seed = SEED
[bench]
distance_mm = 3600.0
[lamp]
ellipticity_rel = 0.05
flux_spread_rel = 0.003
[luxmeter]
gain_error_rel = 0.002
[injected_effects]
only = true
";

/// Injected effects of every room here, healthy or not.
const ORDINARY: &[(&str, &str, f64)] = &[
    ("lamp_warmup", "amplitude_rel", 0.045),
    ("lamp_warmup", "time_constant_s", 300.0),
    ("lamp_warmup", "second_share", 0.0),
];

/// A distribution with all that `reduce` takes out, in rooms whose lamps may drift by more than a sound one.
const DISTRIBUTION: &str = r#"
format = "isolux-plan/1"
[limits]
reference_rel = 0.05
drift_rel = 0.05
closing_rel = 0.05
[[block]]
name = "distribution"
kind = "lit"
c_range = [0, C_LAST, C_STEP]
gamma_range = [0, 90, 2]
reference_every = 46
repeats = REPEATS
[[block]]
name = "baffled"
kind = "baffled"
c_deg = 0
gamma_range = [0, 80, 10]
repeats = 3
[[block]]
name = "capped"
kind = "capped"
c_deg = 0
gamma_deg = 0
repeats = 20
[[block]]
name = "lamp off"
kind = "lamp_off"
c_deg = 0
gamma_deg = 0
repeats = 20
"#;

/// What tells effects apart: signed γ, both directions, three distances, baffle, cap, lamp off. Beyond 48° a far
/// distribution has no digits left for the near distances.
const TELLING: &str = r#"
format = "isolux-plan/1"
[[block]]
name = "far"
kind = "lit"
c_deg = PLANES
gamma_range = [-48, 48, 8]
order = "both"
[[block]]
name = "nearer"
kind = "lit"
c_deg = PLANES
gamma_range = [-48, 48, 8]
order = "both"
distance_mm = 1150.0
[[block]]
name = "nearest"
kind = "lit"
c_deg = PLANES
gamma_range = [-48, 48, 8]
order = "both"
distance_mm = 600.0
[[block]]
name = "baffled"
kind = "baffled"
c_deg = 0
gamma_range = [0, 80, 20]
repeats = 4
[[block]]
name = "capped"
kind = "capped"
c_deg = 0
gamma_deg = 0
repeats = 10
[[block]]
name = "lamp off"
kind = "lamp_off"
c_deg = 0
gamma_deg = 0
repeats = 10
"#;

/// A screen so wide and near that the shape of the distribution shows.
const SCREEN: &str = r#"
sensor_mm = 300.0
bins = 24
unit = "lx"
[[map]]
name = "d500"
distance_mm = 500.0
[[map]]
name = "turned"
distance_mm = 400.0
rot_z_deg = 45.0
offset_mm = [40.0, -20.0]
"#;

/// A camera's sensor.
const SCENE: &str = r#"
format = "isolux-scene/1"
model = "unused.toml"
[sensor]
size_mm = [24.576, 24.576]
pixels = [BINS, BINS]
distance_mm = 500.0
"#;

/// Poses that no diagnosis sees.
const HELD_OUT: &str = r#"
sensor_mm = 24.576
bins = BINS
unit = "relative"
[[map]]
name = "further"
distance_mm = 420.0
exposure = 0.7
[[map]]
name = "leaning"
distance_mm = 260.0
tilt_x_deg = -30.0
tilt_y_deg = 15.0
rot_z_deg = 180.0
exposure = 0.25
"#;

/// How much is measured.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Thoroughness {
    /// Enough for one strong effect, in seconds.
    Quick,
    /// Five half-planes, a reference of ten readings a point.
    Full,
}

pub const HEADING: &str = "\
effect            verdict      named (and what cannot be told from it)      parameters                              \
held out        maps in the room";

pub struct Workshop(Folder);

impl Deref for Workshop {
    type Target = Folder;

    fn deref(&self) -> &Folder {
        &self.0
    }
}

/// What one loop found.
pub struct Found {
    verdict: String,
    effects: Vec<(String, Vec<String>)>,
    parameters: String,
    held_out: Option<[f64; 3]>,
    maps: [f64; 2],
}

impl Workshop {
    /// Scans the healthy room and makes the operator's model of it: the reduced distribution and the lamp's three
    /// rings, as its drawing has them.
    pub fn open(thoroughness: Thoroughness) -> Self {
        let (planes, bins, c_step, repeats) = match thoroughness {
            Thoroughness::Quick => ("[0, 100]", "12", "20", "4"),
            Thoroughness::Full => ("[0, 60, 100, 200, 290]", "16", "10", "10"),
        };
        let workshop = Self(Folder::in_memory());
        let distribution = |step: &str, repeats: &str| {
            let last = (360 - step.parse::<i32>().expect("a number")).to_string();
            DISTRIBUTION
                .replace("C_LAST", &last)
                .replace("C_STEP", step)
                .replace("REPEATS", repeats)
        };
        for (name, text) in [
            // A reference is measured with care, so that its own noise is not what a diagnosis sees.
            ("reference.plan.toml", distribution(c_step, repeats)),
            ("distribution.plan.toml", distribution("20", "1")),
            ("telling.plan.toml", TELLING.replace("PLANES", planes)),
            ("screen.toml", SCREEN.to_owned()),
            ("scene.toml", SCENE.replace("BINS", bins)),
            ("held-out.toml", HELD_OUT.replace("BINS", bins)),
        ] {
            workshop.write(name, &text);
        }
        workshop.room("healthy", 7, None);
        workshop.scan("healthy", "reference.plan.toml", "run");
        workshop.isolux(&["reduce", "healthy/run"], 0);
        workshop.drawn("healthy/run/results/luminaire.model.toml", "reference.model.toml");
        workshop
    }

    /// The loop over the bench: scan, diagnose; reduce another scan without and with what was named, and compare what
    /// both predict with what the camera records.
    pub fn bench(&self, case: &Case) -> Found {
        let name = case.name;
        self.room(name, 8, Some(case));
        self.scan(name, "telling.plan.toml", "telling");
        let out = format!("{name}/diagnosis");
        self.diagnose(&format!("{name}/telling"), &out);

        self.scan(name, "distribution.plan.toml", "run");
        let (run, after) = (format!("{name}/run"), format!("{out}/model.after.toml"));
        self.isolux(&["reduce", &run], 0);
        self.isolux(
            &["reduce", &run, "--with", &after, "--out", &format!("{name}/corrected")],
            0,
        );
        self.capture(name, "screen.toml", "screen", &[]);
        let gaps = [format!("{run}/results"), format!("{name}/corrected")].map(|results| {
            let model = format!("{results}/drawn.model.toml");
            self.drawn(&format!("{results}/luminaire.model.toml"), &model);
            self.gap(&model, "screen.toml", &format!("{name}/screen.csv"))
        });
        self.found(&out, gaps)
    }

    /// The loop over the camera: nine exposures, diagnose, predict poses that the diagnosis has not seen.
    pub fn camera(&self, case: &Case) -> Found {
        let name = format!("camera-{}", case.name);
        self.room(&name, 8, Some(case));
        self.capture(&name, "scene.toml", "maps", &["--designed"]);
        self.capture(&name, "held-out.toml", "held", &[]);
        let out = format!("{name}/diagnosis");
        self.diagnose(&format!("{name}/maps.toml"), &out);
        let gaps = ["baseline", "after"].map(|which| {
            let model = format!("{out}/model.{which}.toml");
            self.gap(&model, "held-out.toml", &format!("{name}/held.csv"))
        });
        self.found(&out, gaps)
    }

    /// What a camera in the room `name` records at `poses`.
    fn capture(&self, name: &str, poses: &str, to: &str, more: &[&str]) {
        let (room, out) = (format!("{name}/darkroom.toml"), format!("{name}/{to}.toml"));
        self.isolux(
            &[&["virtual", "capture", &room, poses, "--out", &out], more].concat(),
            0,
        );
    }

    /// How far what `model` predicts at `poses` is from what was recorded there, in the camera's noise.
    fn gap(&self, model: &str, poses: &str, recorded: &str) -> f64 {
        let predicted = format!("{model}.predicted.csv");
        self.isolux(&["predict", model, poses, "--out", &predicted], 0);
        maps::gap(&self.path(recorded), &self.path(&predicted)).0
    }

    /// Runs `by` on each case and asserts its verdict and that the gap shrank to the noise.
    pub fn hold(&self, cases: &[&Case], by: impl Fn(&Self, &Case) -> Found) {
        println!("{HEADING}");
        let failures = self.table(cases, by);
        assert!(failures.is_empty(), "{failures:#?}");
    }

    /// Runs `by` on each case and prints a line for it; what does not hold.
    pub fn table(&self, cases: &[&Case], by: impl Fn(&Self, &Case) -> Found) -> Vec<String> {
        let mut failures = Vec::new();
        for case in cases {
            let found = by(self, case);
            println!("{}", found.line(case));
            failures.extend(found.wrong(case).map(|what| format!("{}: {what}", case.name)));
        }
        failures
    }

    fn found(&self, diagnosis: &str, maps: [f64; 2]) -> Found {
        let document = self.json(&format!("{diagnosis}/diagnosis.json"));
        let word = |value: &Value| value.as_str().unwrap_or_default().to_owned();
        let mut parameters = String::new();
        let effects = document["effects"].as_array().expect("effects");
        for effect in effects {
            for (key, value) in effect["parameters"].as_object().expect("parameters") {
                let number = |key: &str| value[key].as_f64().unwrap_or(f64::NAN);
                let (value, u) = (number("value"), number("u"));
                let _ = if value.abs() < 0.01 {
                    write!(parameters, "{key} {value:.3e}±{u:.1e} ")
                } else {
                    write!(parameters, "{key} {value:.4}±{u:.4} ")
                };
            }
        }
        let held = &document["gap"]["held_out"];
        let number = |key: &str| held[key].as_f64();
        Found {
            verdict: word(&document["verdict"]),
            effects: effects
                .iter()
                .map(|effect| {
                    let twins = effect["equivalents"].as_array().expect("equivalents");
                    (word(&effect["name"]), twins.iter().map(word).collect())
                })
                .collect(),
            parameters,
            held_out: number("before").and_then(|before| Some([before, number("after")?, number("floor")?])),
            maps,
        }
    }

    /// Scans the room `name`.
    fn scan(&self, name: &str, plan: &str, run: &str) {
        let station = format!("{name}/station.toml");
        self.isolux(&["scan", &station, plan, "--out", &format!("{name}/{run}")], 0);
    }

    /// A room with one injected effect more than every room has, and the station in it.
    fn room(&self, name: &str, seed: u32, case: Option<&Case>) {
        let mut text = ROOM.replace("SEED", &seed.to_string());
        let ordinary = ORDINARY
            .iter()
            .copied()
            .filter(|(effect, ..)| case.is_none_or(|case| case.name != *effect));
        let own = case
            .into_iter()
            .flat_map(|case| case.keys.iter().map(move |&(key, value)| (case.name, key, value)));
        let mut table = "";
        for (effect, key, value) in ordinary.chain(own) {
            if table != effect {
                table = effect;
                let _ = writeln!(text, "[injected_effects.{effect}]");
            }
            let _ = writeln!(text, "{key} = {value:?}");
        }
        std::fs::create_dir_all(self.path(name)).expect("a folder");
        let (room, station) = (format!("{name}/darkroom.toml"), format!("{name}/station.toml"));
        self.write(&room, &text);
        self.isolux(
            &["virtual", "darkroom", &room, "--in-memory", "--station-out", &station],
            0,
        );
    }

    /// The model `from` with the rings of the lamp's drawing in place of its disc, its files named from the new place.
    fn drawn(&self, from: &str, to: &str) {
        let text = self.read(from);
        let beside = Path::new(from)
            .parent()
            .filter(|folder| Path::new(to).parent() != Some(folder));
        let rings =
            "emitter = { shape = \"leds\", radius_mm = [22.0, 28.0, 34.0], count = [20, 20, 20], aim_deg = 0.0 }";
        let emitter = text
            .lines()
            .find(|line| line.starts_with("emitter = "))
            .unwrap_or("no emitter");
        let mut text = text.replace(emitter, rings);
        assert!(text.contains("\"leds\""), "{from}: {text}");
        if let Some(folder) = beside {
            for key in ["distribution", "spectrum"] {
                text = text.replace(&format!("{key} = \""), &format!("{key} = \"{}/", folder.display()));
            }
        }
        self.write(to, &text);
    }

    /// Diagnoses `record` against the healthy model; an honest no is an answer as well.
    fn diagnose(&self, record: &str, out: &str) {
        let diagnose = ["diagnose", "reference.model.toml", record, "--out", out];
        let output = self.start(&diagnose).wait_with_output().expect("the program runs");
        let no = output.status.code() == Some(1);
        stated(output, Some(i32::from(no)));
    }
}

impl Found {
    fn line(&self, case: &Case) -> String {
        let named: Vec<String> = self
            .effects
            .iter()
            .map(|(name, twins)| {
                if twins.is_empty() {
                    name.clone()
                } else {
                    format!("{name} (or {})", twins.join(", "))
                }
            })
            .collect();
        let held = self.held_out.map_or_else(
            || "–".to_owned(),
            |[before, after, floor]| format!("{before:.2}→{after:.2} ({floor:.2})"),
        );
        format!(
            "{:17} {:12} {:43} {:45} {:22} {:.2}→{:.2}",
            case.name,
            self.verdict,
            named.join(" + "),
            self.parameters,
            held,
            self.maps[0],
            self.maps[1]
        )
    }

    /// What an honest diagnosis of this injected effect may not look like.
    fn wrong(&self, case: &Case) -> Option<String> {
        let set = |name: &str, twins: &[String]| name == case.name || twins.iter().any(|twin| twin == case.name);
        let Some((name, twins)) = self.effects.iter().find(|(name, twins)| set(name, twins)) else {
            return Some(format!("{} is not among what was found: {:?}", case.name, self.effects));
        };
        if self.effects.len() > 1 {
            return Some(format!("more than was done: {:?}", self.effects));
        }
        let allowed = |other: &&String| other.as_str() != case.name && !case.twins.contains(&other.as_str());
        if let Some(other) = std::iter::once(name).chain(twins).find(allowed) {
            return Some(format!("{other} can be told from it, and was not"));
        }
        (self.maps[1] > 1.3 && self.maps[1] > 0.5 * self.maps[0])
            .then(|| format!("the maps in the room stay {:.2} σ away", self.maps[1]))
    }
}
