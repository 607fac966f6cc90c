//! The solvers beside their reference, in one run: times, and what each map is off by as a share of what its accuracy
//! allows.
//!
//!     cargo bench -p isolux-sim --bench light -- [REPETITIONS] [SCENE.toml …]
//!
//! Without scenes it takes the published one (337 lm, sensor 24.576 mm at 500 mm, 2048² pixels) of a smooth lamp and
//! of one as a goniophotometer measures it (lopsided by 1 %, rough by 0.2 %), as a point and as a disc of 1 mm.
//!
//! With ISOLUX_LIGHT_FOLDER set it writes the smooth lamp's table, its maps and reference rows there, for
//! `tests/peers/light.sh`, and prints the seconds of each repetition as lines of JSON.

#![expect(clippy::print_stdout, reason = "a program to run by hand")]

use std::hint::black_box;
use std::path::Path;
use std::sync::Arc;
use std::time::Instant;

use glam::DVec3;
use isolux_model::Scene;
use isolux_photometry::IntensityDistribution;
use isolux_sim::direct;
use isolux_sim::inverse::{self, Accuracy};
use isolux_sim::random::{Purpose, Random};
use isolux_sim::sensor::{Pose, Sensor};
use isolux_sim::setup::Setup;
use isolux_sim::source::{LightSource, Shape};
use isolux_sim::table::IntensityTable;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let given: Vec<String> = std::env::args()
        .skip(1)
        .filter(|word| !word.starts_with("--"))
        .collect();
    let repetitions: usize = given.first().map_or(Ok(7), |word| word.parse())?;
    let sensor = published()?;
    if let Ok(folder) = std::env::var("ISOLUX_LIGHT_FOLDER") {
        return for_peers(Path::new(&folder), &sensor, repetitions);
    }
    println!(
        "{:28} {:>9} {:>9} {:>12} {:>8} {:>8}",
        "", "ms", "cpu ms", "reference ms", "error", "stated"
    );
    for path in given.iter().skip(1) {
        let setup = Setup::new(&Scene::load(path.as_str().into())?)?;
        map(path, &setup.source, &setup.sensor, repetitions);
    }
    if given.len() > 1 {
        return Ok(());
    }
    for (name, rough) in [("smooth", 0.0), ("measured", 0.002)] {
        let table = Arc::new(IntensityTable::new(&lamp(rough)?));
        let source = |shape| LightSource::single(Arc::clone(&table), shape);
        map(&format!("{name} point"), &source(POINT), &sensor, repetitions);
        map(&format!("{name} disc"), &source(DISC), &sensor, repetitions);
        for (what, mut work) in rays(&source(DISC), &sensor) {
            let (ms, cpu_ms) = median(repetitions, &mut *work);
            println!("{:28} {ms:9.2} {cpu_ms:9.2}", format!("{name} {what}"));
        }
    }
    Ok(())
}

const POINT: Shape = Shape::Point(DVec3::ZERO);
const DISC: Shape = Shape::Disc {
    centre: DVec3::ZERO,
    radius: 0.5,
};

fn published() -> Result<Sensor, isolux_sim::sensor::SensorError> {
    Sensor::new(&Pose {
        size_mm: [24.576; 2],
        pixels: [2048; 2],
        distance_mm: 500.0,
        tilt_x_deg: 0.0,
        tilt_y_deg: 0.0,
        rot_z_deg: 0.0,
        offset_mm: [0.0; 2],
    })
}

/// Processor seconds of all threads so far, where the system says so: what other programs do changes them less than the
/// time.
fn processor_s() -> f64 {
    let threads = std::fs::read_dir("/proc/self/task").into_iter().flatten().flatten();
    let ns = threads.filter_map(|thread| {
        let text = std::fs::read_to_string(thread.path().join("schedstat")).ok()?;
        text.split_whitespace().next()?.parse::<f64>().ok()
    });
    1e-9 * ns.sum::<f64>()
}

/// Milliseconds of `work`: the median, and the mean of the processor's; one turn before them is not counted.
fn median(repetitions: usize, work: &mut dyn FnMut()) -> (f64, f64) {
    work();
    let before = processor_s();
    let mut seconds = timed(repetitions, work);
    let cpu_s = (processor_s() - before) / seconds.len() as f64;
    seconds.sort_by(f64::total_cmp);
    (1e3 * seconds[seconds.len() / 2], 1e3 * cpu_s)
}

/// Seconds of each turn.
fn timed(repetitions: usize, work: &mut dyn FnMut()) -> Vec<f64> {
    (0..repetitions.max(1))
        .map(|_| {
            let start = Instant::now();
            work();
            start.elapsed().as_secs_f64()
        })
        .collect()
}

/// One map with the standard accuracy into memory that is used again, and all of it against the reference mode.
fn map(name: &str, source: &LightSource, sensor: &Sensor, repetitions: usize) {
    let mut map = vec![0.0; sensor.pixels()];
    let mut bound = inverse::Bound::default();
    let (ms, cpu_ms) = median(repetitions, &mut || {
        bound = black_box(inverse::solve_into(source, sensor, Accuracy::Standard, &mut map));
    });
    let start = Instant::now();
    let reference = inverse::solve(source, sensor, Accuracy::Reference).illuminance_lx;
    let slow_ms = 1e3 * start.elapsed().as_secs_f64();
    let top = reference.iter().fold(0.0_f64, |top, value| top.max(value.abs()));
    let allowed = |value: f64| inverse::allowed(Accuracy::Standard) * value.abs().max(inverse::DIM * top);
    let off = map.iter().zip(&reference).map(|(a, b)| (a - b).abs() / allowed(*b));
    let error = off.fold(0.0, f64::max);
    println!(
        "{name:28} {ms:9.2} {cpu_ms:9.2} {slow_ms:12.1} {error:8.3} {:8.3}",
        bound.of_allowed
    );
}

type Work<'a> = Box<dyn FnMut() + 'a>;

/// The samplings at numbers of rays that they are made for; of expected counts the map is a part.
fn rays<'a>(source: &'a LightSource, sensor: &'a Sensor) -> [(&'static str, Work<'a>); 3] {
    let traced = || {
        black_box(direct::traced(source, sensor, 100_000_000, 1).ok());
    };
    let thinned = || {
        black_box(direct::thinned(source, sensor, 2_000_000_000, 1).ok());
    };
    let expected = || {
        let map = inverse::solve(source, sensor, Accuracy::Standard).illuminance_lx;
        black_box(direct::expected(source, sensor, &map, 2_000_000_000, 1).ok());
    };
    [
        ("traced 1e8", Box::new(traced)),
        ("thinned 2e9", Box::new(thinned)),
        ("expected 2e9", Box::new(expected)),
    ]
}

/// `table.f64` (C plane after C plane), and for point and disc the map and rows 0, 64, 128 … of every pixel by
/// itself, lx.
fn for_peers(folder: &Path, sensor: &Sensor, repetitions: usize) -> Result<(), Box<dyn std::error::Error>> {
    std::fs::create_dir_all(folder)?;
    let bytes = |values: &[f64]| -> Vec<u8> { values.iter().flat_map(|value| value.to_le_bytes()).collect() };
    let lamp = lamp(0.0)?;
    std::fs::write(folder.join("table.f64"), bytes(lamp.intensity_cd()))?;
    let table = Arc::new(IntensityTable::new(&lamp));
    let say = |name: &str, work: &mut dyn FnMut()| {
        work();
        println!("{{\"name\": \"{name}\", \"seconds\": {:?}}}", timed(repetitions, work));
    };
    let mut map = vec![0.0; sensor.pixels()];
    for (name, shape) in [("point", POINT), ("disc", DISC)] {
        let source = LightSource::single(Arc::clone(&table), shape);
        let mut bound = inverse::Bound::default();
        say(&format!("inverse {name}"), &mut || {
            bound = black_box(inverse::solve_into(&source, sensor, Accuracy::Standard, &mut map));
        });
        println!("{{\"bound\": \"{name}\", \"largest\": {:e}}}", bound.largest);
        std::fs::write(folder.join(format!("ours-{name}.f64")), bytes(&map))?;
        let mut rows = Vec::new();
        for row in (0..sensor.ny).step_by(64) {
            let line = Sensor {
                corner: sensor.point(0.0, row as f64),
                ny: 1,
                ..*sensor
            };
            rows.extend(inverse::solve_each(&source, &line).illuminance_lx);
        }
        std::fs::write(folder.join(format!("reference-{name}.f64")), bytes(&rows))?;
    }
    for (name, mut work) in rays(&LightSource::single(table, DISC), sensor) {
        say(name, &mut *work);
    }
    Ok(())
}

/// cosⁿγ of 337 lm and 995 cd/klm on the axis, every 15° of C and 1° of γ, with seeded readings `rough` relative;
/// elliptic by 2 %, and lopsided by 1 % where it is rough.
fn lamp(rough: f64) -> Result<IntensityDistribution, Box<dyn std::error::Error>> {
    let n = std::f64::consts::TAU * 0.995 - 1.0;
    let c_deg: Vec<f64> = (0..24).map(|k| 15.0 * f64::from(k)).collect();
    let gamma_deg: Vec<f64> = (0..=90).map(f64::from).collect();
    let mut noise = Random::new(1, Purpose::Trial).sequence(0);
    let mut intensity_cd = Vec::new();
    for c in &c_deg {
        for g in &gamma_deg {
            let (sin, cos) = g.to_radians().sin_cos();
            let ellipse = 1.0 + 0.02 * sin * sin * (2.0 * c.to_radians()).cos();
            let reading = if rough > 0.0 && *g > 0.0 {
                1.0 + rough * noise.normal() + 0.01 * sin * c.to_radians().cos()
            } else {
                1.0
            };
            intensity_cd.push(cos.max(0.0).powf(n) * ellipse * reading);
        }
    }
    Ok(IntensityDistribution::new(c_deg, gamma_deg, intensity_cd)?.scaled_to_flux_lm(337.0)?)
}
