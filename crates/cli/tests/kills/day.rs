//! A virtual room with its job, its undisturbed day, and the days that are killed in it.

use std::collections::BTreeSet;
use std::fmt;
use std::path::Path;
use std::time::Duration;

use rand::RngExt as _;
use rand_chacha::ChaCha8Rng;

use crate::folder::{Folder, stated};
use crate::phase::{Begun, Phase};

/// A coarser plan than that of the day, at its distance.
const COARSE: &str = r#"format = "isolux-plan/1"
[[block]]
name = "distribution"
kind = "lit"
c_range = [0, 360, 45]
gamma_range = [0, 180, 5]
reference_every = 37
distance_mm = 3700.0
[[block]]
name = "baffled"
kind = "baffled"
c_deg = 0
gamma_range = [0, 180, 30]
repeats = 3
distance_mm = 3700.0
[[block]]
name = "spectrum"
kind = "lit"
instrument = "spectroradiometer"
c_deg = 0
gamma_deg = 0
repeats = 10
[[block]]
name = "lamp off"
kind = "lamp_off"
c_deg = 0
gamma_deg = 0
repeats = 20
distance_mm = 3700.0
"#;

/// What a day says: flux, CCT and the mean on the sensor with U (k = 2), and whether its record agrees with its model.
#[derive(Debug, Clone)]
pub struct Numbers {
    pub values: [(&'static str, f64, f64); 3],
    pub consistent: bool,
}

/// A day that was killed and resumed.
pub struct Outcome {
    pub seed: u64,
    pub killed: Vec<Phase>,
    pub numbers: Numbers,
}

impl fmt::Display for Outcome {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { seed, killed, numbers } = self;
        write!(
            f,
            "seed {seed}, killed in {killed:?}: consistent {}",
            numbers.consistent
        )?;
        numbers
            .values
            .iter()
            .try_for_each(|(name, value, _)| write!(f, ", {name} {value:.5}"))
    }
}

/// The room, its job and its undisturbed day.
pub struct Bench {
    folder: Folder,
    pub undisturbed: Numbers,
    files: BTreeSet<String>,
    rows: usize,
}

impl Bench {
    /// A room with a coarse plan.
    pub fn coarse(seed: u64) -> Self {
        Self::of(seed, Some(COARSE))
    }

    /// A room with the plan of the day.
    pub fn whole(seed: u64) -> Self {
        Self::of(seed, None)
    }

    fn of(seed: u64, plan: Option<&str>) -> Self {
        let folder = Folder::in_memory();
        folder.isolux(&["init", "bench"], 0);
        if let Some(plan) = plan {
            folder.write("bench/plan.toml", plan);
        }
        let scene = folder.read("bench/scene.toml");
        folder.write("bench/scene.toml", &scene.replace("[2048, 2048]", "[64, 64]"));
        folder.write(
            "bench/room.toml",
            &format!("format = \"isolux-darkroom/1\"\nseed = {seed}\n"),
        );
        let station = folder.read("bench/station.toml");
        let named = station.replacen("name = ", "darkroom = \"room.toml\"\nname = ", 1);
        folder.write("bench/station.toml", &named);
        folder.isolux(&["run", "bench/job.toml", "--out", "undisturbed"], 0);
        let rows = folder.read("undisturbed/readings.csv").lines().count();
        let undisturbed = numbers(&folder, "undisturbed");
        let files = files(&folder.path("undisturbed"));
        Self {
            folder,
            undisturbed,
            files,
            rows,
        }
    }

    /// Begins the day of a seed or takes it up again, and kills it in a phase. False where it came to its end before.
    pub fn run_and_kill(&self, seed: u64, phase: Phase, random: &mut ChaCha8Rng) -> bool {
        let (name, day) = self.day(seed);
        let begun = Begun::now(&day);
        let mut child = self.folder.start(&self.arguments(&name));
        let share = random.random_range(0.0..1.0);
        while !begun.is_in(&day, phase, share, self.rows) {
            if child.try_wait().unwrap().is_some() {
                stated(child.wait_with_output().unwrap(), Some(0));
                return false;
            }
            std::thread::sleep(Duration::from_millis(2));
        }
        std::thread::sleep(Duration::from_secs_f64(
            random.random_range(0.0..=Begun::lasts_s(phase)),
        ));
        child.kill().unwrap();
        let output = child.wait_with_output().unwrap();
        if output.status.code().is_some() {
            stated(output, Some(0));
            return false;
        }
        true
    }

    /// Resumes the day of a seed to its end; all files are whole and nothing is left over.
    pub fn finish(&self, seed: u64, killed: &[Phase]) -> Outcome {
        let (name, day) = self.day(seed);
        self.folder.isolux(&self.arguments(&name), 0);
        assert_eq!(files(&day), self.files, "{name}, killed in {killed:?}");
        // Compares what was recorded and made with its checksums.
        let report = format!("{name}.html");
        self.folder.isolux(&["report", &name, "--out", &report], 0);
        let numbers = numbers(&self.folder, &name);
        std::fs::remove_dir_all(&day).unwrap();
        Outcome {
            seed,
            killed: killed.to_vec(),
            numbers,
        }
    }

    fn day(&self, seed: u64) -> (String, std::path::PathBuf) {
        let name = format!("day-{seed}");
        let path = self.folder.path(&name);
        (name, path)
    }

    /// A day without run.toml is begun anew, one with it is resumed.
    fn arguments<'a>(&self, name: &'a str) -> [&'a str; 4] {
        let begun = self.folder.path(name).join("run.toml").is_file();
        ["run", "bench/job.toml", if begun { "--resume" } else { "--out" }, name]
    }
}

fn numbers(folder: &Folder, day: &str) -> Numbers {
    let [budget, result, diagnosis] =
        ["budget", "result", "diagnosis"].map(|name| folder.json(&format!("{day}/results/{name}.json")));
    let of = |name: &'static str, value: &serde_json::Value, u: &serde_json::Value| {
        (name, value.as_f64().unwrap(), 2.0 * u.as_f64().unwrap())
    };
    Numbers {
        values: [
            of("flux", &budget["flux"]["value"], &budget["flux"]["u"]),
            of("CCT", &budget["cct"]["value"], &budget["cct"]["u"]),
            of("mean", &result["mean"], &result["u_mean"]),
        ],
        consistent: diagnosis["verdict"] == "consistent",
    }
}

/// Files of a day; those of the diagnosis follow its verdict.
fn files(day: &Path) -> BTreeSet<String> {
    fn list(folder: &Path, from: &Path, found: &mut BTreeSet<String>) {
        for entry in std::fs::read_dir(folder).unwrap() {
            let path = entry.unwrap().path();
            if path.is_dir() {
                list(&path, from, found);
            } else {
                found.insert(path.strip_prefix(from).unwrap().to_string_lossy().into_owned());
            }
        }
    }
    let mut found = BTreeSet::new();
    list(day, day, &mut found);
    found.retain(|name| !name.starts_with("results/diagnosis/") || name.contains(".part"));
    found
}
