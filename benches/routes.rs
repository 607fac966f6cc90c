//! What each route of the inverse solver is for: the time without it over the time with all of them, in one run.
//!
//!     cargo bench -p isolux-sim --bench routes -- [GENERATED]
//!
//! Three groups: the published scene (337 lm, sensor 24.576 mm at 500 mm, 2048² pixels); lamps of the kind that the
//! virtual darkroom has, before a camera near and far; GENERATED (40) scenes of the test of the bounds. A route counts
//! in the scenes whose map is another without it: elsewhere it was not taken. Below the table of either accuracy stand
//! the pixels that miss what is allowed without a route, which time does not show.

#![expect(clippy::print_stdout, reason = "a program to run by hand")]

use std::hint::black_box;
use std::sync::Arc;
use std::time::Instant;

use camino::Utf8Path;
use glam::DVec3;
use isolux_model::{Emitter, Luminaire, Model, Scene, Spectral};
use isolux_photometry::IntensityDistribution;
use isolux_sim::inverse::{self, Accuracy, Routes};
use isolux_sim::random::{Purpose, Random};
use isolux_sim::sensor::{Pose, Sensor};
use isolux_sim::setup::Setup;
use isolux_sim::source::{LightSource, Shape};
use isolux_sim::table::IntensityTable;

#[expect(dead_code, reason = "tests take more of it")]
#[path = "../crates/sim/tests/suite/generated.rs"]
mod generated;

/// What a group of scenes is called, and the scenes.
type Group = (&'static str, Vec<(String, LightSource, Sensor)>);
type Failure = Box<dyn std::error::Error>;

fn main() -> Result<(), Failure> {
    let given = std::env::args().skip(1).find(|word| !word.starts_with("--"));
    let generated: u64 = given.map_or(Ok(40), |word| word.parse())?;
    let others = (0..generated).map(|number| {
        let (source, sensor) = generated::scene(number);
        (format!("generated {number}"), source, sensor)
    });
    let groups: [Group; 3] = [
        ("published scene", published()?),
        ("lamps", lamps()?),
        ("generated", others.collect()),
    ];
    for (name, accuracy) in [("standard", Accuracy::Standard), ("reference", Accuracy::Reference)] {
        println!("{name}: median gain of a route (largest; scenes that take it, of all)");
        let mut missed = Vec::new();
        for (group, scenes) in &groups {
            // Quick rules are of no use there, and every route is slow.
            let scenes = match accuracy {
                Accuracy::Standard => scenes.as_slice(),
                Accuracy::Reference if *group == "generated" => &scenes[..scenes.len() / 4],
                Accuracy::Reference => continue,
            };
            let found: Vec<Vec<Gain>> = scenes.iter().map(|scene| gains(scene, accuracy)).collect();
            for (k, (route, _)) in without().iter().enumerate() {
                let taken: Vec<&Gain> = found.iter().map(|gains| &gains[k]).filter(|gain| gain.taken).collect();
                let mut ratios: Vec<(f64, &str)> = taken.iter().map(|gain| (gain.ratio, gain.scene.as_str())).collect();
                ratios.sort_by(|a, b| a.0.total_cmp(&b.0));
                let (least, median) = (ratios.first(), ratios.get(ratios.len() / 2));
                let most = ratios.last();
                println!(
                    "  {group:16} {route:16} {:8.2} ({:8.2} {:14}; least {:5.2} {:14}; {:2} of {})",
                    median.map_or(f64::NAN, |(ratio, _)| *ratio),
                    most.map_or(f64::NAN, |(ratio, _)| *ratio),
                    most.map_or("", |(_, scene)| *scene),
                    least.map_or(f64::NAN, |(ratio, _)| *ratio),
                    least.map_or("", |(_, scene)| *scene),
                    taken.len(),
                    scenes.len(),
                );
                missed.extend(
                    taken
                        .iter()
                        .filter(|gain| gain.of_allowed[1] > gain.of_allowed[0].max(1.0))
                        .map(|gain| {
                            let [with, without] = gain.of_allowed;
                            format!(
                                "  {} without {route}: {without:.2} of what is allowed, {with:.2} with it",
                                gain.scene
                            )
                        }),
                );
            }
        }
        for line in missed {
            println!("{line}");
        }
    }
    Ok(())
}

/// Pixels along a side of the corner of a sensor on which product rules, and the routes of single pixels, are timed:
/// what takes their place may be a thousand times slower.
const CORNERS: [usize; 2] = [64, 3];

/// Every route by itself left out.
fn without() -> [(&'static str, Routes); 7] {
    let all = Routes::ALL;
    [
        (
            "polynomials",
            Routes {
                polynomials: false,
                ..all
            },
        ),
        (
            "common rules",
            Routes {
                common_rules: false,
                ..all
            },
        ),
        (
            "product rules",
            Routes {
                product_rules: false,
                common_rules: false,
                ..all
            },
        ),
        (
            "few points",
            Routes {
                few_points: false,
                ..all
            },
        ),
        ("outlines", Routes { outlines: false, ..all }),
        (
            "four points",
            Routes {
                four_points: false,
                ..all
            },
        ),
        ("leaves", Routes { leaves: false, ..all }),
    ]
}

struct Gain {
    scene: String,
    /// Time without the route over that with it.
    ratio: f64,
    taken: bool,
    /// Largest stated error over what is allowed, with and without.
    of_allowed: [f64; 2],
}

fn gains((name, source, sensor): &(String, LightSource, Sensor), accuracy: Accuracy) -> Vec<Gain> {
    let corner = |side: usize| Sensor {
        nx: sensor.nx.min(side),
        ny: sensor.ny.min(side),
        ..*sensor
    };
    let sensors = [*sensor, corner(CORNERS[0]), corner(CORNERS[1])];
    let all = sensors.map(|sensor| timed(source, &sensor, accuracy, Routes::ALL));
    without()
        .into_iter()
        .map(|(_, routes)| {
            let size = match routes {
                Routes {
                    few_points: true,
                    outlines: true,
                    four_points: true,
                    leaves: true,
                    ..
                } => usize::from(!routes.product_rules),
                _ => 2,
            };
            let with = &all[size];
            let without = timed(source, &sensors[size], accuracy, routes);
            Gain {
                scene: name.clone(),
                ratio: without.seconds / with.seconds,
                taken: without.map != with.map,
                of_allowed: [with, &without].map(|timed| timed.bound.of_allowed),
            }
        })
        .collect()
}

struct Timed {
    map: Vec<f64>,
    bound: inverse::Bound,
    seconds: f64,
}

/// The map and its time: quick ones are repeated, and the least disturbed turn counts.
fn timed(source: &LightSource, sensor: &Sensor, accuracy: Accuracy, routes: Routes) -> Timed {
    let mut map = vec![0.0; sensor.pixels()];
    let (mut all, mut least) = (0.0, f64::INFINITY);
    loop {
        let start = Instant::now();
        let bound = black_box(inverse::solve_by(source, sensor, accuracy, routes, &mut map));
        let seconds = start.elapsed().as_secs_f64();
        (all, least) = (all + seconds, least.min(seconds));
        if all > 0.05 {
            let seconds = least;
            return Timed { map, bound, seconds };
        }
    }
}

/// A smooth lamp and one as a goniophotometer measures it, each as a point and as a disc of 1 mm.
fn published() -> Result<Vec<(String, LightSource, Sensor)>, Failure> {
    let sensor = Sensor::new(&Pose {
        size_mm: [24.576; 2],
        pixels: [2048; 2],
        distance_mm: 500.0,
        tilt_x_deg: 0.0,
        tilt_y_deg: 0.0,
        rot_z_deg: 0.0,
        offset_mm: [0.0; 2],
    })?;
    let mut scenes = Vec::new();
    for (name, rough) in [("smooth", 0.0), ("measured", 0.002)] {
        let table = Arc::new(IntensityTable::new(&distribution(5.25, rough)?));
        let centre = DVec3::ZERO;
        for (what, shape) in [
            ("point", Shape::Point(centre)),
            ("disc", Shape::Disc { centre, radius: 0.5 }),
        ] {
            scenes.push((
                format!("{name} {what}"),
                LightSource::single(Arc::clone(&table), shape),
                sensor,
            ));
        }
    }
    Ok(scenes)
}

/// Every kind of emitter, smooth and measured, near and far, before a camera's pixels and a few large ones.
fn lamps() -> Result<Vec<(String, LightSource, Sensor)>, Failure> {
    let leds = Emitter::Leds {
        position_mm: vec![],
        weight: vec![],
        radius_mm: vec![22.0, 28.0, 34.0],
        count: vec![20, 20, 20],
        aim_deg: 0.0,
    };
    let emitters = [
        ("leds", leds),
        ("disc", Emitter::Disc { diameter_mm: 60.0 }),
        (
            "ring",
            Emitter::Ring {
                inner_diameter_mm: 44.0,
                outer_diameter_mm: 68.0,
            },
        ),
        ("rectangle", Emitter::Rectangle { size_mm: [60.0, 20.0] }),
        ("chip", Emitter::Disc { diameter_mm: 1.0 }),
    ];
    let mut scenes = Vec::new();
    for (name, emitter) in emitters {
        for (place, size_mm, pixels, distance_mm) in [
            ("near", 12.8, 50, 100.0),
            ("far", 6.4, 64, 500.0),
            ("coarse", 25.0, 5, 150.0),
        ] {
            let model = Model::of(Luminaire::new(
                distribution(5.3, 0.002)?,
                emitter.clone(),
                Spectral::None,
            ));
            let text = format!(
                "format = \"isolux-scene/1\"\nmodel = \"lamp.model.toml\"\n[sensor]\nsize_mm = [{size_mm:?}, {size_mm:?}]\n\
                 pixels = [{pixels}, {pixels}]\ndistance_mm = {distance_mm:.1}\ntilt_x_deg = 7.0\n"
            );
            let setup = Setup::new(&Scene::parse_with(Utf8Path::new("scene.toml"), &text, &model)?)?;
            scenes.push((format!("{name} {place}"), setup.source, setup.sensor));
        }
    }
    Ok(scenes)
}

/// cosⁿγ of 337 lm, every 15° of C and 1° of γ, with seeded readings `rough` relative and lopsided by 1 % where
/// it is.
fn distribution(exponent: f64, rough: f64) -> Result<IntensityDistribution, Failure> {
    let c_deg: Vec<f64> = (0..24).map(|k| 15.0 * f64::from(k)).collect();
    let gamma_deg: Vec<f64> = (0..=90).map(f64::from).collect();
    let mut noise = Random::new(1, Purpose::Trial).sequence(0);
    let mut intensity_cd = Vec::new();
    for c in &c_deg {
        for gamma in &gamma_deg {
            let (sin, cos) = gamma.to_radians().sin_cos();
            let reading = if rough > 0.0 && *gamma > 0.0 {
                1.0 + rough * noise.normal() + 0.01 * sin * c.to_radians().cos()
            } else {
                1.0
            };
            intensity_cd.push(cos.max(0.0).powf(exponent) * reading);
        }
    }
    Ok(IntensityDistribution::new(c_deg, gamma_deg, intensity_cd)?.scaled_to_flux_lm(337.0)?)
}
