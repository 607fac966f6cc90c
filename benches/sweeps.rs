//! Scans in motion against the light of the lamp, beside scans at rest: photometric files → `init --lamp` → a virtual
//! room whose meter has a latency, a lag and a clock of its own → scan → reduction → truth, in virtual time.
//!
//!     cargo bench -p isolux-app --bench sweeps -- [FILE or FOLDER …] [--seeds 10] [--at-rest 10] [--speed 15]
//!         [--beam 3] [--dim 20] [--target 0.02] [--meter konica-t10a] [--proposed] [--cases] [--only NAME]
//!         [--keep FOLDER]
//!
//! Files are `.ldt` and `.ies`; without any, a dozen luminaires that this program makes. `--seeds` rooms a lamp, of
//! which `--at-rest` are read at rest too; `--speed` of γ in °/s in place of what `init --sweep` proposes; `--beam` the
//! speed of a second sweep within the beam; `--dim` the digits below which light is swept again more sensitively;
//! `--target` u of the map, relative, for which half-planes are chosen from 72 in place of 24; `--proposed` the
//! half-planes, γ and second sweeps that `init` proposes for the lamp in place of 24 × 2°; `--meter` another lux meter
//! than the P-9710; `--cases` a line a scan; `--only` lamps with NAME in theirs; `--keep` leaves files and runs in
//! FOLDER. A lamp that `init` refuses is named and left out.
//!
//! | column | what |
//! |---|---|
//! | time | from the stable lamp to the last direction of the distribution, its ten checks at rest included, s |
//! | node | largest error of a direction that was read, % of the peak |
//! | map | largest error of the written distribution anywhere, by 2.5° × 0.5°, % of the peak |
//! | flux | error of the flux, % |
//! | beam | largest error of the beam angle of a half-plane, ° |
//! | in U | directions whose error is below their own U (k = 2), %; error ÷ U of the worst |
//! | map in U | the same of the places of `map`, with what straight lines between directions miss |
//! | U | largest U of a direction, % of the peak: what the scan announces |
//! | refused | scans that the ten directions read at rest refuse |
//!
//! The truth is the light at the distance of the scan: what a large lamp shows there is not its far field, in motion or
//! at rest. The calibration of the meter, which all readings share, is taken out of all of them, and the lamp's output
//! is that in the middle of the scan. `node`, `map`, `flux` and `beam` are medians over the seeds, then the largest.

#![expect(clippy::print_stdout, clippy::print_stderr, reason = "a program to run by hand")]

use std::collections::BTreeMap;
use std::error::Error;
use std::sync::Mutex;
use std::sync::atomic::{AtomicUsize, Ordering};

use camino::{Utf8Path, Utf8PathBuf};
use isolux_app::files::Overwrite;
use isolux_app::front_end::control::Control;
use isolux_app::front_end::progress::Silent;
use isolux_app::init::{self, Instruments};
use isolux_app::instruments::bench::StationFiles;
use isolux_app::scan::{Place, ScanJob, Target};
use isolux_darkroom::output::relative_output;
use isolux_darkroom::{Darkroom, Instrument, Kind, Observation, Room};
use isolux_formats::eulumdat::{self, Header, LampSet};
use isolux_photometry::IntensityDistribution;
use isolux_record::document::SourceText;
use isolux_record::{Event, Plan, Run, Subject};
use isolux_reduce::{Options, ReduceError, Reduction, straight_lines_miss_cd};
use isolux_virtual::twins::{Choice, TWINS, TwinKind};
use rand::{RngExt as _, SeedableRng as _};
use rand_chacha::ChaCha8Rng;
use toml::{Table, Value};

type Outcome<T> = Result<T, Box<dyn Error + Send + Sync>>;

/// What all readings share beside the calibration, the correction of drift among it, relative.
const SHARED_REL: f64 = 0.001;

/// What is asked for.
struct Wanted {
    files: Vec<Utf8PathBuf>,
    seeds: u64,
    at_rest: u64,
    speed_deg_s: Option<f64>,
    beam_deg_s: Option<f64>,
    dim_digits: Option<f64>,
    target: Option<f64>,
    meter: String,
    proposed: bool,
    cases: bool,
    only: Option<String>,
    keep: Option<Utf8PathBuf>,
}

/// How a distribution is read.
#[derive(Clone, Copy, PartialEq, Eq)]
enum How {
    InMotion,
    AtRest,
}

/// One scan and what came of it.
struct Case {
    lamp: usize,
    how: How,
    seed: u64,
    figures: Figures,
    /// Why, where it is.
    refused: Option<String>,
}

/// What one scan is judged by.
#[derive(Clone, Copy)]
struct Figures {
    time_s: f64,
    node: f64,
    map: f64,
    flux: f64,
    beam_deg: f64,
    covered: f64,
    worst_of_u: f64,
    most_u: f64,
    map_covered: f64,
    map_worst_of_u: f64,
    /// C and γ of the largest error of a direction, degrees.
    at_deg: (f64, f64),
}

fn main() -> Outcome<()> {
    let wanted = wanted()?;
    let keep = tempfile::tempdir()?;
    let own = Utf8Path::from_path(keep.path()).ok_or("the temporary folder has no UTF-8 name")?;
    let mut lamps = lamps(&wanted.files)?;
    if lamps.is_empty() {
        lamps = made(own)?;
    }
    if let Some(only) = &wanted.only {
        lamps.retain(|file| file.file_stem().is_some_and(|name| name.contains(only.as_str())));
    }
    let jobs: Vec<(usize, u64, How)> = (0..lamps.len())
        .flat_map(|lamp| (1..=wanted.seeds).map(move |seed| (lamp, seed)))
        .flat_map(|(lamp, seed)| [(lamp, seed, How::InMotion), (lamp, seed, How::AtRest)])
        .filter(|(_, seed, how)| *how == How::InMotion || *seed <= wanted.at_rest)
        .collect();
    let (next, found) = (AtomicUsize::new(0), Mutex::new(Vec::new()));
    let threads = std::thread::available_parallelism().map_or(1, usize::from);
    std::thread::scope(|scope| {
        for _ in 0..threads {
            scope.spawn(|| {
                while let Some(&(lamp, seed, how)) = jobs.get(next.fetch_add(1, Ordering::Relaxed)) {
                    let case = played(&wanted, &lamps[lamp], lamp, seed, how);
                    if let (Ok(case), true) = (&case, wanted.cases) {
                        println!("{}", line(&lamps[lamp], case));
                    }
                    if let Ok(mut found) = found.lock() {
                        found.push((lamp, seed, how, case));
                        eprint!("\r{} of {} scans", found.len(), jobs.len());
                    }
                }
            });
        }
    });
    eprintln!();
    let found = found.into_inner().map_err(|_| "a thread ended early")?;
    print_table(&lamps, found);
    Ok(())
}

fn wanted() -> Outcome<Wanted> {
    let mut wanted = Wanted {
        files: Vec::new(),
        seeds: 10,
        at_rest: 10,
        speed_deg_s: None,
        beam_deg_s: None,
        dim_digits: None,
        target: None,
        meter: "gigahertz-p9710".to_owned(),
        proposed: false,
        cases: false,
        only: None,
        keep: None,
    };
    let mut words = std::env::args().skip(1);
    while let Some(word) = words.next() {
        let mut value = || words.next().ok_or_else(|| format!("{word} needs a value"));
        match word.as_str() {
            "--bench" => {}
            "--seeds" => wanted.seeds = value()?.parse()?,
            "--at-rest" => wanted.at_rest = value()?.parse()?,
            "--speed" => wanted.speed_deg_s = Some(value()?.parse()?),
            "--beam" => wanted.beam_deg_s = Some(value()?.parse()?),
            "--dim" => wanted.dim_digits = Some(value()?.parse()?),
            "--target" => wanted.target = Some(value()?.parse()?),
            "--meter" => wanted.meter = value()?,
            "--proposed" => wanted.proposed = true,
            "--cases" => wanted.cases = true,
            "--only" => wanted.only = Some(value()?),
            "--keep" => wanted.keep = Some(value()?.into()),
            option if option.starts_with("--") => return Err(format!("{option} is no option").into()),
            file => wanted.files.push(file.into()),
        }
    }
    Ok(wanted)
}

/// The files, and those of the folders, by name.
fn lamps(given: &[Utf8PathBuf]) -> Outcome<Vec<Utf8PathBuf>> {
    let mut files = Vec::new();
    for path in given {
        if !path.is_dir() {
            files.push(path.clone());
            continue;
        }
        let mut of_folder = Vec::new();
        for entry in path.read_dir_utf8()? {
            of_folder.push(entry?.into_path());
        }
        of_folder.retain(|file| {
            let ending = file.extension().unwrap_or_default().to_lowercase();
            ["ldt", "ies"].contains(&ending.as_str())
        });
        of_folder.sort();
        files.extend(of_folder);
    }
    Ok(files)
}

/// One scan of the lamp of `file` in the room of `seed`.
fn played(wanted: &Wanted, file: &Utf8Path, lamp: usize, seed: u64, how: How) -> Outcome<Case> {
    let keep = tempfile::tempdir()?;
    let temporary = Utf8Path::from_path(keep.path()).ok_or("the temporary folder has no UTF-8 name")?;
    let name = format!("{}-{seed}-{}", file.file_stem().unwrap_or_default(), how.word());
    let folder = &wanted
        .keep
        .as_ref()
        .map_or_else(|| temporary.to_owned(), |kept| kept.join(name));
    let instruments = Instruments {
        luxmeter: Some(wanted.meter.clone()),
        in_motion: how == How::InMotion,
        ..Instruments::default()
    };
    init::for_lamp(
        folder,
        file,
        &instruments,
        &Subject::default(),
        Overwrite::Never,
        &Silent,
    )?;
    disturb(&folder.join("room.toml"), seed)?;
    let plan_file = folder.join("plan.toml");
    let mut choice = Choice::default();
    choice.choose(Instrument::Luxmeter, &wanted.meter)?;
    let speed_deg_s = wanted.speed_deg_s.unwrap_or_else(|| init::sweep_deg_s(2.0, &choice));
    let plan_text = planned(&std::fs::read_to_string(&plan_file)?, wanted, how, speed_deg_s);
    let plan = Plan::parse(&plan_file, &plan_text)?;
    let source = StationFiles::load(&folder.join("station.toml"))?;
    let run_folder = folder.join("run");
    let control = Control::default();
    let job = ScanJob {
        source: &source,
        plan: &plan,
        place: Place::take(Target::New(&run_folder), false)?,
        force: None,
        operator: None,
        control: &control,
        progress: &Silent,
    };
    job.execute()?;
    let run = Run::read(&run_folder)?;
    let (reduction, refused) = match isolux_reduce::reduce(&run, &Options::default(), None) {
        Err(error @ ReduceError::Unsteady { .. }) => {
            let accept_drift = Some("to see its errors".to_owned());
            let accepting = Options {
                accept_drift,
                ..Options::default()
            };
            (isolux_reduce::reduce(&run, &accepting, None)?, Some(error.to_string()))
        }
        reduced => (reduced?, None),
    };
    let text = std::fs::read_to_string(folder.join("room.toml"))?;
    let room = SourceText {
        file: Utf8Path::new("room.toml"),
        text: &text,
    };
    let beside = |name: &str| std::fs::read_to_string(folder.join(name)).map_err(|error| error.to_string());
    let room = Room::new(Darkroom::complete(room, &beside)?.0);
    let gain = gain(&wanted.meter, room.document());
    let figures = judged(&reduction, &room, gain, time_s(&run_folder)?)?;
    Ok(Case {
        lamp,
        how,
        seed,
        figures,
        refused,
    })
}

/// Gives the room its seed, and its instruments what no station file says of them.
fn disturb(file: &Utf8Path, seed: u64) -> Outcome<()> {
    let mut draws = ChaCha8Rng::seed_from_u64(seed);
    let mut room: Table = std::fs::read_to_string(file)?.parse()?;
    room.insert("seed".to_owned(), Value::Integer(i64::try_from(seed)?));
    let mut set = |table: &[&str], key: &str, value: f64| -> Outcome<()> {
        let mut inner = &mut room;
        for name in table {
            let entry = inner.entry(*name).or_insert_with(|| Table::new().into());
            inner = match entry {
                Value::Table(table) => table,
                _ => return Err(format!("{file}: {name} is no table").into()),
            };
        }
        inner.insert(key.to_owned(), Value::Float(value));
        Ok(())
    };
    set(&["luxmeter"], "latency_s", draws.random_range(0.02..0.12))?;
    set(&["luxmeter"], "latency_jitter_s", draws.random_range(0.001..0.005))?;
    set(&["luxmeter"], "lag_s", draws.random_range(0.005..0.03))?;
    set(&["luxmeter"], "clock_ppm", draws.random_range(-200.0..200.0))?;
    set(&["lamp"], "flicker_rel", draws.random_range(0.0..0.05))?;
    set(&["axis", "gamma"], "wobble_deg", draws.random_range(0.0..0.03))?;
    let effects = "injected_effects";
    set(&[effects, "backlash"], "width_deg", draws.random_range(0.0..0.3))?;
    set(&["luxmeter"], "clock_phase_s", draws.random_range(0.0..0.5))?;
    // Both kinds of scan know these by their corrections alike, or not at all.
    set(&[effects, "floor_reflection"], "albedo", 0.0)?;
    set(&[effects, "distance_offset"], "offset_mm", 0.0)?;
    std::fs::write(file, room.to_string())?;
    Ok(())
}

/// The plan that `init` wrote, with what is asked of it.
fn planned(text: &str, wanted: &Wanted, how: How, speed_deg_s: f64) -> String {
    let mut block = 0;
    let line = |line: &str| {
        block += usize::from(line == "[[block]]");
        let key = line.split([' ', '=']).next().unwrap_or("");
        match (key, how) {
            ("c_range", How::InMotion)
                if block == 1
                    && let Some(target) = wanted.target =>
            {
                format!("c_range = [0, 175, 5]\ntarget = {{ u_map_rel = {target} }}\n")
            }
            ("c_range", How::InMotion) if block == 1 && !wanted.proposed => "c_range = [0, 165, 15]\n".to_owned(),
            ("c_range", How::AtRest) if block == 1 && !wanted.proposed => "c_range = [0, 360, 15]\n".to_owned(),
            ("gamma_range", How::InMotion) if block == 1 && !wanted.proposed => {
                "gamma_range = [-180, 180, 2]\n".to_owned()
            }
            ("gamma_range", How::AtRest) if block == 1 && !wanted.proposed => "gamma_range = [0, 180, 2]\n".to_owned(),
            ("reference_every", How::AtRest) if block == 1 && !wanted.proposed => "reference_every = 91\n".to_owned(),
            ("speed_deg_s", How::InMotion) if wanted.speed_deg_s.is_some() || !wanted.proposed => {
                format!("speed_deg_s = {speed_deg_s:?}\n")
            }
            // Second sweeps are those that are asked for, or with the grid that is proposed.
            ("beam_speed_deg_s", _) if wanted.beam_deg_s.is_some() || !wanted.proposed => String::new(),
            ("dim_digits", _) if wanted.dim_digits.is_some() || !wanted.proposed => String::new(),
            ("mode", How::InMotion) if block == 1 => {
                let set = |key: &str, value: Option<f64>| value.map(|value| format!("{key} = {value:?}\n"));
                let second = [
                    set("beam_speed_deg_s", wanted.beam_deg_s),
                    set("dim_digits", wanted.dim_digits),
                ];
                format!("{line}\n") + &second.into_iter().flatten().collect::<String>()
            }
            _ => format!("{line}\n"),
        }
    };
    text.lines().map(line).collect()
}

/// Seconds from the stable lamp to the end of the first block.
fn time_s(run: &Utf8Path) -> Outcome<f64> {
    let mut stable = None;
    let mut blocks = Vec::new();
    for line in std::fs::read_to_string(run.join("events.jsonl"))?.lines() {
        let logged: isolux_record::Logged = serde_json::from_str(line)?;
        let at: jiff::Timestamp = logged.time_utc.parse()?;
        match logged.event {
            Event::Stable { .. } => stable = stable.or(Some(at)),
            Event::Block { .. } => blocks.push(at),
            _ => {}
        }
    }
    let (stable, end) = stable.zip(blocks.get(1)).ok_or("no stable lamp, or one block alone")?;
    Ok(end.duration_since(stable).as_secs_f64())
}

/// What the lux meter that speaks to `driver` reads of a lux: a spectroradiometer in its place has an error of its own.
fn gain(driver: &str, document: &Darkroom) -> f64 {
    let plays = |twin: &&TwinKind| twin.driver == driver && twin.instrument == Instrument::Spectroradiometer;
    1.0 + if TWINS.iter().any(|twin| plays(&twin)) {
        document.spectroradiometer.gain_error_rel
    } else {
        document.luxmeter.gain_error_rel
    }
}

/// The reduction against the light of the room's lamp at the distance of the scan, by a meter that reads `gain` times
/// it.
fn judged(reduction: &Reduction, room: &Room, gain: f64, time_s: f64) -> Outcome<Figures> {
    let read = &reduction.grid.distribution;
    let ages: Vec<f64> = reduction.grid.nodes.iter().filter_map(|node| node.lamp_s).collect();
    let middle_s = ages.iter().sum::<f64>() / ages.len().max(1) as f64;
    let document = room.document();
    let gain = gain * relative_output(&document.injected_effects, middle_s, 0.5);
    let distance_mm = reduction.distance_mm;
    let truth = |c_deg: f64, gamma_deg: f64| {
        let at = Observation {
            kind: Kind::Lit,
            time_s: middle_s,
            c_deg,
            gamma_deg,
            distance_mm,
            travel: 0.0,
            range: 0,
            ambient_c: 25.0,
        };
        gain * room.direct_lx(&at) * (1e-3 * distance_mm).powi(2)
    };
    let fine = |step_c: f64, step_gamma: f64| {
        let steps = |whole: f64, step: f64| (0..=(whole / step).round() as usize).map(move |k| k as f64 * step);
        let c_deg: Vec<f64> = steps(360.0 - step_c, step_c).collect();
        let gamma_deg: Vec<f64> = steps(180.0, step_gamma).collect();
        let of = |c: &f64| gamma_deg.iter().map(|gamma| truth(*c, *gamma)).collect::<Vec<_>>();
        let intensity_cd = c_deg.iter().flat_map(of).collect();
        IntensityDistribution::new(c_deg.clone(), gamma_deg.clone(), intensity_cd)
    };
    let exact = fine(2.5, 0.5)?;
    let peak = exact.peak().intensity_cd;
    let slopes = reduction.grid.gamma_slopes_cd_per_deg();
    let expanded_cd = |place: usize| {
        let sample = &reduction.grid.nodes[reduction.grid.sample_of[place]];
        let shared = (SHARED_REL * sample.intensity_cd).hypot(slopes[place] * reduction.common.gamma_deg);
        2.0 * sample.u_own_cd().hypot(shared)
    };
    let (mut node, mut at_deg, mut inside, mut worst_of_u, mut most_u) = (0.0f64, (0.0, 0.0), 0, 0.0f64, 0.0f64);
    for (plane, c_deg) in read.c_deg().iter().enumerate() {
        for (column, gamma_deg) in read.gamma_deg().iter().enumerate() {
            let error = (read.row(plane)[column] - truth(*c_deg, *gamma_deg)).abs();
            let place = plane * read.gamma_deg().len() + column;
            let expanded = expanded_cd(place);
            if error / peak > node {
                (node, at_deg) = (error / peak, (*c_deg, *gamma_deg));
            }
            inside += usize::from(error <= expanded);
            most_u = most_u.max(expanded / peak);
            worst_of_u = worst_of_u.max(error / expanded.max(1e-4 * peak));
        }
    }
    let missed_cd = straight_lines_miss_cd(read);
    let (mut map, mut map_inside, mut map_worst_of_u) = (0.0f64, 0, 0.0f64);
    for (plane, c_deg) in exact.c_deg().iter().enumerate() {
        for (gamma_deg, cd) in exact.gamma_deg().iter().zip(exact.row(plane)) {
            let error = (read.intensity_cd_at(*c_deg, *gamma_deg) - cd).abs();
            map = map.max(error / peak);
            let nearest = |of: &[f64], at: f64| {
                let apart = |there: f64| 180.0 - ((there - at).rem_euclid(360.0) - 180.0).abs();
                (0..of.len()).min_by(|a, b| apart(of[*a]).total_cmp(&apart(of[*b])))
            };
            let nearest = nearest(read.c_deg(), *c_deg).zip(nearest(read.gamma_deg(), *gamma_deg));
            let (plane, column) = nearest.ok_or("a distribution without directions")?;
            let place = plane * read.gamma_deg().len() + column;
            let expanded = expanded_cd(place).hypot(2.0 * missed_cd[place]);
            map_inside += usize::from(error <= expanded);
            map_worst_of_u = map_worst_of_u.max(error / expanded.max(1e-4 * peak));
        }
    }
    let beam = |of: &IntensityDistribution, c_deg: f64| {
        let plane = of.plane_at(c_deg)?;
        Some(of.beam_angle(plane)?.full_angle_deg())
    };
    let beams = read
        .c_deg()
        .iter()
        .filter_map(|c| Some((beam(read, *c)? - beam(&exact, *c)?).abs()));
    Ok(Figures {
        time_s,
        node: 100.0 * node,
        map: 100.0 * map,
        flux: 100.0 * (reduction.flux.value / (gain * document.lamp.flux_lm) - 1.0).abs(),
        beam_deg: beams.fold(0.0, f64::max),
        covered: 100.0 * inside as f64 / read.intensity_cd().len() as f64,
        worst_of_u,
        most_u: 100.0 * most_u,
        map_covered: 100.0 * map_inside as f64 / exact.intensity_cd().len() as f64,
        map_worst_of_u,
        at_deg,
    })
}

impl Figures {
    fn numbers(self) -> [f64; 10] {
        [
            self.time_s,
            self.node,
            self.map,
            self.flux,
            self.beam_deg,
            self.covered,
            self.worst_of_u,
            self.most_u,
            self.map_covered,
            self.map_worst_of_u,
        ]
    }
}

impl How {
    fn word(self) -> &'static str {
        match self {
            Self::InMotion => "in motion",
            Self::AtRest => "at rest",
        }
    }
}

fn line(file: &Utf8Path, case: &Case) -> String {
    let [
        time,
        node,
        map,
        flux,
        beam,
        covered,
        of_u,
        most_u,
        map_covered,
        map_of_u,
    ] = case.figures.numbers();
    format!(
        "{} seed {} {}: {time:.0} s; node {node:.2} % at C {}° γ {}°, map {map:.2} %, flux {flux:.3} %, beam {beam:.2}°, in U {covered:.1} %, \
         worst {of_u:.2} U, largest U {most_u:.2} %, map in U {map_covered:.1} %, worst {map_of_u:.2} U{}",
        file.file_stem().unwrap_or_default(),
        case.seed,
        case.how.word(),
        case.figures.at_deg.0,
        case.figures.at_deg.1,
        case.refused
            .as_ref()
            .map_or_else(String::new, |why| format!(", refused: {why}"))
    )
}

type Found = (usize, u64, How, Outcome<Case>);

fn print_table(lamps: &[Utf8PathBuf], found: Vec<Found>) {
    let mut cases = Vec::new();
    let mut left_out: BTreeMap<String, Vec<u64>> = BTreeMap::new();
    for (lamp, seed, how, case) in found {
        match case {
            Ok(case) => cases.push(case),
            Err(error) => left_out
                .entry(format!("{} {}: {error}", lamps[lamp], how.word()))
                .or_default()
                .push(seed),
        }
    }
    for (why, seeds) in &left_out {
        println!("left out, seeds {seeds:?}: {why}");
    }
    for how in [How::InMotion, How::AtRest] {
        println!(
            "\n{}: median, largest\n\n| lamp | time/s | node/% | map/% | flux/% | beam/° | in U/% | worst/U | U/% \
             | map in U/% | worst/U | refused |",
            how.word()
        );
        println!("|{}", "---|".repeat(12));
        for (lamp, file) in lamps.iter().enumerate() {
            let of_lamp: Vec<&Case> = cases
                .iter()
                .filter(|case| (case.lamp, case.how) == (lamp, how))
                .collect();
            if of_lamp.is_empty() {
                continue;
            }
            let numbers = |place: usize| sorted(of_lamp.iter().map(|case| case.figures.numbers()[place]));
            let cell = |place: usize, digits: usize| {
                let all = numbers(place);
                format!("{:.digits$}, {:.digits$}", all[all.len() / 2], all[all.len() - 1])
            };
            // The least last: of a share the smallest is the worst.
            let share = |place: usize| {
                let all = numbers(place);
                format!("{:.1}, {:.1}", all[all.len() / 2], all[0])
            };
            println!(
                "| {} | {} | {} | {} | {} | {} | {} | {} | {} | {} | {} | {} of {} |",
                file.file_stem().unwrap_or_default(),
                cell(0, 0),
                cell(1, 2),
                cell(2, 2),
                cell(3, 3),
                cell(4, 2),
                share(5),
                cell(6, 2),
                cell(7, 2),
                share(8),
                cell(9, 2),
                of_lamp.iter().filter(|case| case.refused.is_some()).count(),
                of_lamp.len()
            );
        }
        let of_how: Vec<&Case> = cases.iter().filter(|case| case.how == how).collect();
        let all = |place: usize| sorted(of_how.iter().map(|case| case.figures.numbers()[place]));
        for (name, place) in [
            ("time, s", 0),
            ("node, %", 1),
            ("map, %", 2),
            ("flux, %", 3),
            ("beam, °", 4),
        ] {
            let all = all(place);
            if let (Some(middle), Some(largest)) = (all.get(all.len() / 2), all.last()) {
                println!("{name}: median {middle:.3}, largest {largest:.3}");
            }
        }
    }
}

fn sorted(values: impl Iterator<Item = f64>) -> Vec<f64> {
    let mut values: Vec<f64> = values.collect();
    values.sort_by(f64::total_cmp);
    values
}

/// A luminaire by a formula: its name, its intensity in cd by C and γ, its steps of C and γ.
type Formula = (&'static str, fn(f64, f64) -> f64, f64, f64);

/// Half-width at half height, of a lobe around γ = 0.
fn lobe(gamma: f64, half_deg: f64) -> f64 {
    0.5f64.powf((gamma / half_deg).powi(2))
}

fn cosine(degrees: f64, times: f64) -> f64 {
    (times * degrees.to_radians()).cos()
}

/// A cosine to the power n down to the horizon.
fn below(gamma: f64, n: f64) -> f64 {
    cosine(gamma, 1.0).max(0.0).powf(n)
}

/// 1 below an edge at `at`, 0 above it, over `width` degrees.
fn edge(gamma: f64, at: f64, width: f64) -> f64 {
    let t = ((at + 0.5 * width - gamma) / width).clamp(0.0, 1.0);
    t * t * (3.0 - 2.0 * t)
}

const MADE: [Formula; 12] = [
    ("Lambertian", |_, g| 300.0 * below(g, 1.0), 90.0, 5.0),
    ("downlight 60°", |_, g| 1200.0 * lobe(g, 30.0), 90.0, 2.5),
    (
        "spot 15°",
        |_, g| 9000.0 * lobe(g, 7.5) + 20.0 * below(g, 1.0),
        90.0,
        0.5,
    ),
    (
        "oval 20° by 40°",
        |c, g| 5000.0 * lobe(g, 15.0 - 5.0 * cosine(c, 2.0)),
        5.0,
        1.0,
    ),
    (
        "batwing",
        |c, g| {
            400.0 * below(g, 0.8) * (1.0 + 1.6 * (-((g - 38.0) / 16.0).powi(2)).exp() * (0.6 + 0.4 * cosine(c, 2.0)))
        },
        5.0,
        2.5,
    ),
    (
        "street light",
        |c, g| {
            let ahead =
                (-((g - 62.0) / 9.0).powi(2)).exp() * (-((90.0 - (c - 180.0).abs()).abs() / 28.0).powi(2)).exp();
            220.0 * below(g, 0.6) + 900.0 * ahead * edge(g, 80.0, 12.0)
        },
        5.0,
        1.0,
    ),
    (
        "wall washer",
        |c, g| 300.0 * below(g, 1.2) * (1.0 + 1.5 * (g / 60.0).min(1.5) * cosine(c, 1.0)).max(0.05),
        5.0,
        2.5,
    ),
    (
        "linear",
        |c, g| 800.0 * below(g, 1.0 + 2.0 * (0.5 + 0.5 * cosine(c, 2.0))),
        5.0,
        2.5,
    ),
    (
        "cut-off 1°",
        |_, g| 900.0 * edge(g, 45.3, 1.0) * below(g, 0.3),
        90.0,
        0.25,
    ),
    (
        "no symmetry",
        |c, g| {
            let off =
                (-((g - 25.0) / 14.0).powi(2)).exp() * (-(((c - 137.0 + 540.0) % 360.0 - 180.0) / 40.0).powi(2)).exp();
            let lean = 1.0 + 0.2 * cosine(c - 40.0, 1.0) * (g / 45.0).min(1.0);
            // At the pole all half-planes are one.
            500.0 * below(g, 1.5) * lean + 400.0 * off * (1.0 - lobe(g, 8.0))
        },
        5.0,
        1.0,
    ),
    (
        "globe",
        |_, g| 120.0 * (1.0 - 0.4 * edge(180.0 - g, 25.0, 20.0)),
        90.0,
        5.0,
    ),
    (
        "up and down",
        |_, g| 500.0 * below(g, 2.0) + 350.0 * below(180.0 - g, 1.0),
        90.0,
        2.5,
    ),
];

/// Files of these luminaires.
fn made(folder: &Utf8Path) -> Outcome<Vec<Utf8PathBuf>> {
    let mut files = Vec::new();
    for (name, of, step_c, step_gamma) in MADE {
        let c_deg: Vec<f64> = (0..(360.0 / step_c) as usize).map(|k| k as f64 * step_c).collect();
        let gamma_deg: Vec<f64> = (0..=(180.0 / step_gamma) as usize)
            .map(|k| k as f64 * step_gamma)
            .collect();
        let intensity_cd = c_deg.iter().flat_map(|c| gamma_deg.iter().map(|gamma| of(*c, *gamma)));
        let light = IntensityDistribution::new(c_deg.clone(), gamma_deg.clone(), intensity_cd.collect())?;
        let header = Header {
            name: name.to_owned(),
            luminous_length_mm: Some(60.0),
            lamp_sets: vec![LampSet {
                count: Some(1.0),
                flux_lm: Some(light.flux_lm()),
                ..LampSet::default()
            }],
            ..Header::default()
        };
        let written = eulumdat::write(&light, &header).map_err(|finding| finding.message.to_string())?;
        let file = folder.join(format!("{name}.ldt"));
        std::fs::write(&file, written.bytes)?;
        files.push(file);
    }
    Ok(files)
}
