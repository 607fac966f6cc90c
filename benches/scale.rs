//! How the time and the memory of each step grow with the readings of a scan: the program itself, on runs that it makes
//! in the virtual darkroom, whose instruments answer at once.
//!
//!     cargo bench --bench scale -- [READINGS …]
//!
//! READINGS are `2k`, `13k`, `52k`, `260k` and `1M`; without any, the first three. The runs are made in memory where
//! the system has `/dev/shm` (1 GB for `1M`), so that no disk is waited for; `ISOLUX_SCALE_FOLDER` names another folder,
//! in which runs that are there already are used again.
//!
//! | column | what |
//! |---|---|
//! | scan | the whole scan ÷ readings: engine, drivers, twins and record, in virtual time |
//! | resume | `scan --resume` of the finished run: from the start to where the next reading would be taken, and the end |
//! | reduce | `reduce` |
//! | diagnose | `diagnose` of the model that it made against the run |
//! | report | `report` |
//! | page | `serve` until a browser has the page, its scripts and the first events of the run |
//!
//! Each with seconds and the peak of its memory, where the system says it.

#![expect(clippy::print_stdout, reason = "a program to run by hand")]

use std::error::Error;
use std::io::{BufRead as _, BufReader, Read as _, Write as _};
use std::net::TcpStream;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};
use std::thread::sleep;
use std::time::{Duration, Instant};

type Outcome<T> = Result<T, Box<dyn Error>>;

/// A grid of the sphere: its name, half-planes without the closing one, γ.
const SIZES: [(&str, usize, usize); 5] = [
    ("2k", 24, 91),
    ("13k", 72, 181),
    ("52k", 144, 361),
    ("260k", 360, 721),
    ("1M", 720, 1441),
];
/// Sizes that a plain run takes.
const USUAL: usize = 3;
/// How often a step is asked for its memory.
const BETWEEN_LOOKS: Duration = Duration::from_millis(5);

fn main() -> Outcome<()> {
    let given: Vec<String> = std::env::args()
        .skip(1)
        .filter(|word| !word.starts_with("--"))
        .collect();
    let mut sizes: Vec<(&str, usize, usize)> = SIZES[..USUAL].to_vec();
    if !given.is_empty() {
        let known = |word: &String| SIZES.into_iter().find(|size| size.0 == word);
        let unknown = |word: &String| format!("{word} is no size; there are 2k, 13k, 52k, 260k and 1M");
        sizes = given
            .iter()
            .map(|word| known(word).ok_or_else(|| unknown(word)))
            .collect::<Result<_, _>>()?;
    }
    let kept = std::env::var_os("ISOLUX_SCALE_FOLDER").map(PathBuf::from);
    println!(
        "{:>9} {:>11} {:>18} {:>18} {:>18} {:>18} {:>18}",
        "readings", "scan", "resume", "reduce", "diagnose", "report", "page"
    );
    for (name, planes, gammas) in sizes {
        let memory = Path::new("/dev/shm");
        let place = if memory.is_dir() {
            memory.to_owned()
        } else {
            std::env::temp_dir()
        };
        let folder = tempfile::tempdir_in(place)?;
        let folder = kept
            .as_ref()
            .map_or_else(|| folder.path().to_owned(), |kept| kept.join(name));
        size(&folder, planes, gammas)?;
    }
    Ok(())
}

/// The row of one size.
fn size(folder: &Path, planes: usize, gammas: usize) -> Outcome<()> {
    let isolux = |words: &[&str]| Step::of(folder, words);
    let mut scan = None;
    if !folder.join("run/run.toml").is_file() {
        std::fs::create_dir_all(folder)?;
        isolux(&["init", "bench"])?.expect(0)?;
        std::fs::write(folder.join("bench/plan.toml"), plan(planes, gammas))?;
        scan = Some(isolux(&["scan", "bench/station.toml", "bench/plan.toml", "--out", "run"])?.expect(0)?);
    }
    let readings = std::fs::read_to_string(folder.join("run/readings.csv"))?
        .lines()
        .count()
        - 1;
    print!("{readings:>9} ");
    match scan {
        Some(scan) => print!("{:>8.0} µs", 1e6 * scan.seconds / readings as f64),
        None => print!("{:>11}", "kept"),
    }
    let resume = ["scan", "bench/station.toml", "bench/plan.toml", "--resume", "run"];
    isolux(&resume)?.expect(0)?.print()?;
    isolux(&["reduce", "run", "--force"])?.expect(0)?.print()?;
    let model = "run/results/luminaire.model.toml";
    // Exit 1 is an answer too: something is left that no effect explains.
    isolux(&["diagnose", model, "run", "--out", "diagnosis", "--force"])?.print()?;
    isolux(&["report", "run", "--out", "report.html", "--force"])?
        .expect(0)?
        .print()?;
    first_paint(folder)?.print()?;
    println!();
    Ok(())
}

/// The distribution, and what the reduction takes from it, at 3.7 m.
fn plan(planes: usize, gammas: usize) -> String {
    let (c_step, gamma_step) = (360.0 / planes as f64, 180.0 / (gammas - 1) as f64);
    let around = |name: &str, kind: &str, gamma: &str| {
        format!(
            "[[block]]\nname = \"{name}\"\nkind = \"{kind}\"\ndistance_mm = 3700.0\nc_deg = 0\n{gamma}\nrepeats = 10\n"
        )
    };
    format!(
        "format = \"isolux-plan/1\"\nname = \"{planes} half-planes, {gammas} γ\"\n[limits]\ndrift_rel = 0.5\n\
         [[block]]\nname = \"distribution\"\nkind = \"lit\"\ndistance_mm = 3700.0\nc_range = [0, 360, {c_step}]\n\
         gamma_range = [0, 180, {gamma_step}]\norder = \"serpentine\"\nreference_every = {gammas}\n"
    ) + &around("baffled", "baffled", "gamma_range = [0, 180, 10]")
        + "[[block]]\nname = \"spectrum\"\nkind = \"lit\"\ninstrument = \"spectroradiometer\"\nc_deg = 0\ngamma_deg = 0\n\
           repeats = 10\n"
        + &around("capped", "capped", "gamma_deg = 0")
        + &around("lamp off", "lamp_off", "gamma_deg = 0")
}

/// A step that was carried out.
struct Step {
    words: String,
    code: Option<i32>,
    stderr: String,
    seconds: f64,
    /// None where the system does not say it.
    peak_mib: Option<f64>,
}

impl Step {
    /// Runs the program to its end.
    fn of(folder: &Path, words: &[&str]) -> Outcome<Self> {
        let log = folder.join("stderr.txt");
        let start = Instant::now();
        let mut child = Command::new(env!("CARGO_BIN_EXE_isolux"))
            .args(words)
            .current_dir(folder)
            .stdin(Stdio::null())
            .stdout(Stdio::null())
            .stderr(std::fs::File::create(&log)?)
            .spawn()?;
        let mut peak_mib = None;
        let status = loop {
            peak_mib = memory_mib(&child).or(peak_mib);
            if let Some(status) = child.try_wait()? {
                break status;
            }
            sleep(BETWEEN_LOOKS);
        };
        Ok(Self {
            words: words.join(" "),
            code: status.code(),
            seconds: start.elapsed().as_secs_f64(),
            stderr: std::fs::read_to_string(&log)?,
            peak_mib,
        })
    }

    fn expect(self, code: i32) -> Outcome<Self> {
        if self.code == Some(code) {
            return Ok(self);
        }
        Err(format!("isolux {}: exit {:?}\n{}", self.words, self.code, self.stderr).into())
    }

    fn print(&self) -> Outcome<()> {
        let memory = self
            .peak_mib
            .map_or_else(|| "?".to_owned(), |peak| format!("{peak:.0}"));
        print!(" {:>8.2} s {memory:>4} MiB", self.seconds);
        Ok(std::io::stdout().flush()?)
    }
}

/// The most memory that a process had at once, in MiB.
fn memory_mib(child: &Child) -> Option<f64> {
    let status = std::fs::read_to_string(format!("/proc/{}/status", child.id())).ok()?;
    let line = status.lines().find_map(|line| line.strip_prefix("VmHWM:"))?;
    let kib: f64 = line.trim().strip_suffix("kB")?.trim().parse().ok()?;
    Some(kib / 1024.0)
}

/// Serves the folder until a browser would show the run.
fn first_paint(folder: &Path) -> Outcome<Step> {
    let start = Instant::now();
    let mut child = Command::new(env!("CARGO_BIN_EXE_isolux"))
        .args(["serve", ".", "--no-browser"])
        .current_dir(folder)
        .stdin(Stdio::null())
        .stdout(Stdio::piped())
        .stderr(Stdio::null())
        .spawn()?;
    let painted = paint(&mut child);
    let seconds = start.elapsed().as_secs_f64();
    let peak_mib = memory_mib(&child);
    child.kill()?;
    child.wait()?;
    painted?;
    Ok(Step {
        words: "serve".to_owned(),
        code: Some(0),
        stderr: String::new(),
        seconds,
        peak_mib,
    })
}

/// What a browser asks for, one after the other, until it has the first readings of the run.
fn paint(child: &mut Child) -> Outcome<()> {
    let stdout = child.stdout.take().ok_or("no output")?;
    let mut line = String::new();
    BufReader::new(stdout).read_line(&mut line)?;
    let url = line.split("http://").nth(1).ok_or("no address")?.trim();
    let (host, path) = url.split_once('/').ok_or("no path")?;
    let answer = get(host, &format!("/{path}"), "")?;
    let cookie = answer
        .lines()
        .find_map(|line| line.strip_prefix("set-cookie: "))
        .and_then(|cookie| cookie.split(';').next())
        .ok_or("no cookie")?;
    for file in ["/", "/page.css", "/app.js"] {
        get(host, file, cookie)?;
    }
    while !get(host, "/api/events", cookie)?.contains("\"reading\"") {
        sleep(BETWEEN_LOOKS);
    }
    Ok(())
}

/// The whole answer, headers and all.
fn get(host: &str, path: &str, cookie: &str) -> Outcome<String> {
    let mut stream = TcpStream::connect(host)?;
    write!(
        stream,
        "GET {path} HTTP/1.1\r\nHost: {host}\r\nCookie: {cookie}\r\nConnection: close\r\n\r\n"
    )?;
    let mut answer = Vec::new();
    stream.read_to_end(&mut answer)?;
    let answer = String::from_utf8_lossy(&answer).into_owned();
    match answer.split_whitespace().nth(1) {
        Some("200" | "303") => Ok(answer),
        _ => Err(format!("GET {path}: {}", answer.lines().next().unwrap_or_default()).into()),
    }
}
