//! A bench whose instruments live in a process of their own, the program run against it, and what its runs hold.

use std::collections::BTreeMap;
use std::io::{BufRead, BufReader, Write};
use std::net::TcpStream;
use std::ops::Deref;
use std::process::{Child, Command, Output, Stdio};
use std::sync::atomic::{AtomicU64, Ordering};
use std::time::{Duration, Instant};

use rand::{RngExt as _, SeedableRng as _};
use rand_chacha::ChaCha8Rng;
use tokio::signal::unix::SignalKind;

use crate::folder::Folder;

/// Fast axes, and a lamp whose distribution is known in closed form: flux (n + 1) ÷ 2π · cosⁿ γ at every C.
const ROOM: &str = r#"format = "isolux-darkroom/1"
[injected_effects]
only = true
[bench]
distance_mm = 1000.0
[lamp]
ring_diameter_mm = [0.0]
leds_per_ring = [1]
exponent = 5.0
flux_lm = 337.0
ellipticity_rel = 0.0
flux_spread_rel = 0.0
aim_spread_deg = 0.0
[luxmeter]
gain_error_rel = 0.0
[axis.c]
speed_deg_s = 400.0
accel_deg_s2 = 2000.0
[axis.gamma]
speed_deg_s = 400.0
accel_deg_s2 = 2000.0
"#;

/// Six points and four visits to the reference point: half a minute in real time.
pub const PLAN: &str = r#"format = "isolux-plan/1"
[[block]]
name = "lit"
kind = "lit"
c_range = [0, 90, 90]
gamma_range = [0, 40, 20]
reference_every = 2
"#;

/// More points than are read in ten minutes, five times as long as [`wait_until`] waits: whatever else the machine
/// does, a scan of them still runs when it is disturbed.
pub const LONG_PLAN: &str = r#"format = "isolux-plan/1"
[[block]]
name = "lit"
kind = "lit"
c_range = [0, 355, 5]
gamma_range = [0, 40, 5]
reference_every = 2
"#;

/// Points of [`PLAN`].
const POINTS: usize = 6;

/// A folder with `station.toml` and `plan.toml`, and the process that serves its instruments; ends with it.
pub struct Bench {
    folder: Folder,
    twins: Child,
}

impl Deref for Bench {
    type Target = Folder;

    fn deref(&self) -> &Folder {
        &self.folder
    }
}

impl Drop for Bench {
    fn drop(&mut self) {
        let _ = self.twins.kill();
        let _ = self.twins.wait();
    }
}

impl Bench {
    /// The quick room.
    pub fn new() -> Self {
        Self::with("")
    }

    /// The quick room with these further tables in its `darkroom.toml`.
    pub fn with(tables: &str) -> Self {
        Self::playing(tables, &[])
    }

    /// The quick room with a meter that converts on request, ten times a second.
    pub fn on_request() -> Self {
        let bench = Self::playing("", &["--luxmeter", "gigahertz-p9710"]);
        let station = bench.read("station.toml");
        let sensitivity = "?a_per_lx=3e-10";
        assert!(station.contains(sensitivity), "{station}");
        let station = station.replace(sensitivity, &format!("{sensitivity}&integration_ms=100"));
        bench.write("station.toml", &station);
        bench
    }

    /// The room of [`with`](Self::with), with these further arguments of `virtual darkroom`.
    pub fn playing(tables: &str, arguments: &[&str]) -> Self {
        let folder = Folder::in_memory();
        folder.write("room.toml", &format!("{ROOM}{tables}"));
        folder.write("plan.toml", PLAN);
        let serve = [
            "virtual",
            "darkroom",
            "room.toml",
            "--tcp",
            "0",
            "--station-out",
            "station.toml",
            "--json",
        ];
        let mut twins = folder
            .command(&serve)
            .args(arguments)
            .stdout(Stdio::piped())
            .spawn()
            .unwrap();
        // The lines are printed when everything can be reached.
        let mut lines = BufReader::new(twins.stdout.take().unwrap()).lines();
        for _ in 0..3 {
            lines.next().unwrap().unwrap();
        }
        let station = folder.read("station.toml");
        let lamp = "diameter_mm = 5.0\n";
        assert!(station.contains(lamp), "{station}");
        // Half an hour of warming up is left out: the lamp of this room is constant from its first moment.
        let stable = "\nstable = { least_s = 2.0, window_s = 2.0, spread_rel = 0.05 }";
        folder.write("station.toml", &station.replace(lamp, &format!("{lamp}{stable}")));
        Self { folder, twins }
    }

    /// Starts a scan: `how` is `--out` or `--resume`.
    pub fn scan(&self, how: &str, run: &str) -> Child {
        self.start(&["scan", "station.toml", "plan.toml", how, run])
    }

    /// `host:port` of an instrument of the station: `zaber`, `konica-t10a` or `ocean-ooi`.
    pub fn peer(&self, driver: &str) -> String {
        let station = self.read("station.toml");
        let (_, rest) = station.split_once(&format!("{driver}:tcp://")).unwrap();
        rest.split(['"', '?']).next().unwrap().to_owned()
    }

    /// Sends one command to the axes' controller beside the program, and gives its answer: the hands of somebody else.
    pub fn tell_axes(&self, command: &str) -> String {
        let mut stream = TcpStream::connect(self.peer("zaber")).unwrap();
        stream.set_read_timeout(Some(Duration::from_secs(10))).unwrap();
        stream.write_all(format!("/{command}\n").as_bytes()).unwrap();
        let mut answer = String::new();
        BufReader::new(stream).read_line(&mut answer).unwrap();
        answer
    }

    /// Whether an axis (1: C, 2: γ) moves, asked of its controller without the program.
    pub fn moves(&self, axis: u8) -> bool {
        let answer = self.tell_axes(&format!("1 {axis} get pos"));
        assert!(answer.contains(" OK "), "{answer}");
        answer.contains(" BUSY ")
    }

    /// Both axes rest, by the word of their controller.
    pub fn assert_at_rest(&self) {
        for axis in [1, 2] {
            assert!(!self.moves(axis), "axis {axis} moves");
        }
    }

    /// Waits until the run holds this many rows.
    pub fn wait_for_rows(&self, run: &str, count: usize) {
        wait_until(&format!("{count} rows in {run}"), || self.rows(run).len() >= count);
    }

    /// The whole rows of the run, column by name; none where there is no run yet.
    pub fn rows(&self, run: &str) -> Vec<BTreeMap<String, String>> {
        let text = std::fs::read_to_string(self.path(run).join("readings.csv")).unwrap_or_default();
        let mut lines = text.split_inclusive('\n').filter(|line| line.ends_with('\n'));
        let head: Vec<&str> = lines.next().unwrap_or_default().trim_end().split(',').collect();
        lines
            .map(|line| line.trim_end().split(',').map(str::to_owned))
            .map(|row| head.iter().map(ToString::to_string).zip(row).collect())
            .collect()
    }

    /// Every point of [`PLAN`] is in the run once, and the run says that it is completed.
    pub fn assert_complete(&self, run: &str) {
        assert_eq!(self.assert_once(run), POINTS);
        self.assert_stopped(run, "completed");
    }

    /// Every point that is in the run is in it once. Returns how many are.
    pub fn assert_once(&self, run: &str) -> usize {
        let mut found = BTreeMap::new();
        for row in self.rows(run).iter().filter(|row| row["role"] == "point") {
            *found.entry((row["point"].clone(), row["repeat"].clone())).or_insert(0) += 1;
        }
        assert!(found.values().all(|times| *times == 1), "{found:?}");
        found.len()
    }

    /// The run says that it ended like this, and with the axes at rest.
    pub fn assert_stopped(&self, run: &str, how: &str) {
        let header = self.read(&format!("{run}/run.toml"));
        assert!(header.contains(&format!("how = \"{how}\"")), "{header}");
        assert!(header.contains("axes_at_rest = true"), "{header}");
    }

    /// Every row that calls itself `ok` has the light of the angle that the plan asked for, within 1 %.
    pub fn assert_true(&self, run: &str) {
        let rows = self.rows(run);
        assert!(!rows.is_empty());
        for row in rows.iter().filter(|row| row["quality"] == "ok") {
            let number = |column: &str| row[column].parse::<f64>().unwrap();
            let cosine = number("gamma_target_deg").to_radians().cos();
            let expected = 337.0 * 6.0 / std::f64::consts::TAU * cosine.powi(5);
            let found = number("illuminance_lx");
            assert!(
                (found / expected - 1.0).abs() < 0.01,
                "{found} lx for {expected} lx: {row:?}"
            );
        }
    }
}

/// Waits until `is_so`.
pub fn wait_until(what: &str, mut is_so: impl FnMut() -> bool) {
    let deadline = Instant::now() + Duration::from_mins(2);
    while !is_so() {
        assert!(Instant::now() < deadline, "two minutes, and not yet: {what}");
        std::thread::sleep(Duration::from_millis(2));
    }
}

/// Sends a signal by its name: `TERM`, `KILL`, `STOP`.
pub fn signal(child: &Child, name: &str) {
    let kill = format!("kill -{name} {}", child.id());
    assert!(Command::new("sh").args(["-c", &kill]).status().unwrap().success());
}

/// Waits for the end of a program that was asked to end, and not for that of its plan.
pub fn ended(mut child: Child) -> Output {
    wait_until("the program ends", || child.try_wait().unwrap().is_some());
    child.wait_with_output().unwrap()
}

/// Programs that are started from now on hear SIGHUP, also where the tests themselves were started with it ignored
/// (`nohup`): a signal that this process handles is at its default in those that it starts.
pub fn hear_hangups() {
    let runtime = tokio::runtime::Builder::new_current_thread().enable_all().build();
    let runtime = runtime.unwrap();
    let _inside = runtime.enter();
    // The handler stays for as long as the process runs.
    drop(tokio::signal::unix::signal(SignalKind::hangup()).unwrap());
}

/// `ISOLUX_ATTACK_ROUNDS`, or this many.
pub fn rounds(short: u64) -> u64 {
    number("ISOLUX_ATTACK_ROUNDS").unwrap_or(short)
}

/// What each round of `count` counts, summed; up to six run side by side: they wait more than they compute.
pub fn side_by_side(count: u64, one_round: impl Fn(u64) -> u64 + Sync) -> u64 {
    const MOST: u64 = 6;
    let (next, sum) = (AtomicU64::new(0), AtomicU64::new(0));
    std::thread::scope(|scope| {
        for _ in 0..MOST.min(count) {
            scope.spawn(|| {
                loop {
                    let round = next.fetch_add(1, Ordering::Relaxed);
                    if round >= count {
                        return;
                    }
                    sum.fetch_add(one_round(round), Ordering::Relaxed);
                }
            });
        }
    });
    sum.into_inner()
}

/// Random numbers of one round, from `ISOLUX_ATTACK_SEED`.
pub fn random(round: u64) -> ChaCha8Rng {
    let mut random = ChaCha8Rng::seed_from_u64(number("ISOLUX_ATTACK_SEED").unwrap_or(1));
    random.set_stream(round);
    random
}

/// A moment between `from` and `to`.
pub fn moment(random: &mut ChaCha8Rng, from: Duration, to: Duration) -> Duration {
    Duration::from_secs_f64(random.random_range(from.as_secs_f64()..to.as_secs_f64()))
}

fn number(variable: &str) -> Option<u64> {
    let text = std::env::var(variable).ok()?;
    Some(
        text.parse()
            .unwrap_or_else(|_| panic!("{variable}={text} is no whole number")),
    )
}
