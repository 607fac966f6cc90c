//! A virtual room with its job, its undisturbed day, and the days that are killed in it.

use std::collections::BTreeSet;
use std::fmt;
use std::path::Path;
use std::process::Child;
use std::time::Duration;

use rand::RngExt as _;
use rand_chacha::ChaCha8Rng;

use crate::folder::{Folder, stated};
use crate::killed_days::phase::{Begun, Phase, Progress};
use crate::killed_days::sweeps::{Sweep, directions, repeated, sweeps};

/// Fewer directions than those of the day.
const AT_REST: &str = "c_range = [0, 360, 45]\ngamma_range = [0, 180, 10]\nreference_every = 19";
/// Six sweeps, and the three more of the first half-plane.
const IN_MOTION: &str = "c_range = [0, 150, 30]\ngamma_range = [-180, 180, 4]\nmode = \"sweep\"";
/// Half-planes that rings and sweeps choose.
const CHOSEN: &str =
    "c_range = [0, 175, 5]\ngamma_range = [-180, 180, 4]\nmode = \"sweep\"\ntarget = { u_map_rel = 0.02 }";

/// The rest of a plan that is coarser than that of the day, at its distance.
const COARSE: &str = r#"
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

/// What a day says: flux, CCT and the mean on the sensor with U (k = 2), the intensity of each direction, and whether
/// its record agrees with its model.
#[derive(Debug, Clone)]
pub struct Numbers {
    pub values: [(&'static str, f64, f64); 3],
    pub directions: Vec<(String, f64, f64)>,
    pub consistent: bool,
}

impl Numbers {
    /// The shares of U (k = 2) of `other` by which the intensities differ, of each direction.
    pub fn differences(&self, other: &Self) -> Vec<f64> {
        let pairs = self.directions.iter().zip(&other.directions);
        let differences = pairs.map(|(one, other)| {
            assert_eq!(one.0, other.0, "the directions are the same");
            (one.1 - other.1).abs() / other.2
        });
        assert_eq!(self.directions.len(), other.directions.len());
        differences.collect()
    }
}

/// Where a day was killed, with the sweeps that it had.
pub struct Killed {
    phase: Phase,
    sweeps: Vec<Sweep>,
}

impl fmt::Debug for Killed {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{:?}", self.phase)?;
        match self.sweeps.len() {
            0 => Ok(()),
            made => write!(f, " with {made} sweeps"),
        }
    }
}

/// A day that was killed and resumed.
pub struct Outcome {
    pub seed: u64,
    pub killed: Vec<Killed>,
    /// Of sweeps that stood whole when it was killed.
    pub repeated: usize,
    pub numbers: Numbers,
}

impl fmt::Display for Outcome {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self {
            seed,
            killed,
            repeated,
            numbers,
        } = self;
        write!(
            f,
            "seed {seed}, killed in {killed:?}: {repeated} sweeps repeated, consistent {}",
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
    pub phases: &'static [Phase],
    pub undisturbed: Numbers,
    files: BTreeSet<String>,
    whole: Progress,
    sweeps: Vec<Sweep>,
}

impl Bench {
    /// A room with a coarse plan.
    pub fn coarse(seed: u64) -> Self {
        Self::of(seed, &Phase::AT_REST, Some(AT_REST)).unwrap()
    }

    /// A room with the plan of the day.
    pub fn whole(seed: u64) -> Self {
        Self::of(seed, &Phase::AT_REST, None).unwrap()
    }

    /// A room whose coarse plan is read in motion, at half-planes that are chosen or at all. None where the directions
    /// read at rest refuse its undisturbed day.
    pub fn in_motion(seed: u64, chosen: bool) -> Option<Self> {
        Self::of(seed, &Phase::IN_MOTION, Some(if chosen { CHOSEN } else { IN_MOTION }))
    }

    fn of(seed: u64, phases: &'static [Phase], distribution: Option<&str>) -> Option<Self> {
        let folder = Folder::in_memory().at_low_priority();
        let moves = phases.contains(&Phase::Sweeps);
        folder.isolux(
            if moves {
                &["init", "bench", "--sweep"]
            } else {
                &["init", "bench"]
            },
            0,
        );
        if let Some(distribution) = distribution {
            let block = "format = \"isolux-plan/1\"\n[[block]]\nname = \"distribution\"\nkind = \"lit\"";
            folder.write("bench/plan.toml", &format!("{block}\n{distribution}{COARSE}"));
        }
        let scene = folder.read("bench/scene.toml");
        folder.write("bench/scene.toml", &scene.replace("[2048, 2048]", "[64, 64]"));
        let lamp = if moves {
            "[lamp]\ntable = \"lamp.csv\"\nluminous_diameter_mm = 60.0\n"
        } else {
            ""
        };
        folder.write("bench/lamp.csv", &lamp_with_a_lobe());
        folder.write(
            "bench/room.toml",
            &format!("format = \"isolux-darkroom/1\"\nseed = {seed}\n{lamp}"),
        );
        let station = folder.read("bench/station.toml");
        let named = station.replacen("name = ", "darkroom = \"room.toml\"\nname = ", 1);
        folder.write("bench/station.toml", &named);
        if is_refused(folder.start(&["run", "bench/job.toml", "--out", "undisturbed"])) {
            return None;
        }
        let undisturbed = numbers(&folder, "undisturbed");
        let day = folder.path("undisturbed");
        Some(Self {
            folder,
            phases,
            undisturbed,
            files: files(&day),
            whole: Progress::of(&day),
            sweeps: sweeps(&day),
        })
    }

    /// Begins the day of a seed or takes it up again, and kills it in a phase. None where it came to its end before.
    pub fn run_and_kill(&self, seed: u64, phase: Phase, random: &mut ChaCha8Rng) -> Option<Killed> {
        let (name, day) = self.day(seed);
        let begun = Begun::now(&day);
        let mut child = self.folder.start(&self.arguments(&name));
        let share = random.random_range(0.0..1.0);
        while !begun.is_in(&day, phase, share, &self.whole) {
            if child.try_wait().unwrap().is_some() {
                is_refused(child);
                return None;
            }
            std::thread::sleep(Duration::from_millis(2));
        }
        std::thread::sleep(Duration::from_secs_f64(
            random.random_range(0.0..=Begun::lasts_s(phase)),
        ));
        child.kill().unwrap();
        if child.wait().unwrap().code().is_some() {
            is_refused(child);
            return None;
        }
        let sweeps = sweeps(&day);
        Some(Killed { phase, sweeps })
    }

    /// Resumes the day of a seed to its end; all files are whole and nothing is left over, the axes rest, the same is
    /// swept as in the undisturbed day, and of the sweeps that stood at a kill at most the last was made again. None
    /// where the directions read at rest refuse it.
    pub fn finish(&self, seed: u64, killed: Vec<Killed>) -> Option<Outcome> {
        let (name, day) = self.day(seed);
        if is_refused(self.folder.start(&self.arguments(&name))) {
            return None;
        }
        assert_eq!(files(&day), self.files, "{name}, killed in {killed:?}");
        // Compares what was recorded and made with its checksums.
        let report = format!("{name}.html");
        self.folder.isolux(&["report", &name, "--out", &report], 0);
        let run: String = self.folder.read(&format!("{name}/run.toml"));
        assert!(run.contains("\naxes_at_rest = true\n"), "{name}, killed in {killed:?}");
        let now = sweeps(&day);
        let ways = |sweeps: &[Sweep]| -> Vec<_> { sweeps.iter().map(|sweep| sweep.way.clone()).collect() };
        assert_eq!(ways(&now), ways(&self.sweeps), "{name}, killed in {killed:?}");
        let mut again = 0;
        for one in &killed {
            let most = one.sweeps.len().saturating_sub(1);
            assert_eq!(repeated(&one.sweeps[..most], &now), 0, "{name}, killed in {killed:?}");
            again += repeated(&one.sweeps, &now);
        }
        let numbers = numbers(&self.folder, &name);
        std::fs::remove_dir_all(&day).unwrap();
        Some(Outcome {
            seed,
            killed,
            repeated: again,
            numbers,
        })
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

/// Whether a day ended because the directions read at rest disagree with its sweeps, as those of one sound scan in
/// twenty do; else it ended well.
fn is_refused(day: Child) -> bool {
    let output = day.wait_with_output().unwrap();
    let said = String::from_utf8_lossy(&output.stderr);
    let refused = output.status.code() == Some(1) && said.contains("read at rest after the sweeps disagree");
    if !refused {
        stated(output, Some(0));
    }
    refused
}

/// The table of a lamp as bright as the built-in one with a lobe about C 130°: half-planes are chosen there.
fn lamp_with_a_lobe() -> String {
    let mut text = "c_deg,gamma_deg,intensity_cd\n".to_owned();
    for c_deg in (0..360).step_by(10).map(f64::from) {
        for gamma_deg in (0..73).map(|step| 2.5 * f64::from(step)) {
            let (sine, cosine) = gamma_deg.to_radians().sin_cos();
            let off = (c_deg - 130.0 + 180.0_f64).rem_euclid(360.0) - 180.0;
            let lobe = 0.4 * sine * (-0.5 * (off / 18.0).powi(2)).exp();
            text += &format!(
                "{c_deg},{gamma_deg},{}\n",
                340.0 * cosine.max(0.0).powi(2) * (1.0 + lobe)
            );
        }
    }
    text
}

fn numbers(folder: &Folder, day: &str) -> Numbers {
    let [budget, result, diagnosis] =
        ["budget", "result", "diagnosis"].map(|name| folder.json(&format!("{day}/results/{name}.json")));
    let of = |name: &'static str, value: &serde_json::Value, u: &serde_json::Value| {
        let numbers = value.as_f64().zip(u.as_f64());
        let (value, u) = numbers.unwrap_or_else(|| panic!("{day}: {name} is {value}, u {u}"));
        (name, value, 2.0 * u)
    };
    Numbers {
        values: [
            of("flux", &budget["flux"]["value"], &budget["flux"]["u"]),
            of("CCT", &budget["cct"]["value"], &budget["cct"]["u"]),
            of("mean", &result["mean"], &result["u_mean"]),
        ],
        directions: directions(&folder.read(&format!("{day}/results/luminaire.directions.csv"))),
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
