//! A day of the program in a virtual room whose lamp changes its colour over angle: scan, reduction, files, model and
//! simulation, against the room's own camera before the same lamp.

#![allow(clippy::print_stdout, reason = "says how far they differ")]

use camino::{Utf8Path, Utf8PathBuf};
use isolux_app::formats::inspect::{self, Quantities};
use isolux_app::init::{DayPlan, Instruments, run as init};
use isolux_darkroom::camera::Unit;
use isolux_darkroom::{Darkroom, MapPose, Room, SensorFrame};
use isolux_formats::ReadOptions;
use isolux_model::{Model, Scene};
use isolux_record::{Plan, Subject};
use isolux_reduce::{Options, reduce};
use isolux_sim::simulation::{Method, Simulation, simulate};

use crate::in_room::scanned;

/// A sensor so wide that its rim lies at γ 31°.
const SENSOR_MM: f64 = 420.0;
const BINS: usize = 12;

fn room() -> Darkroom {
    let mut document = Darkroom::built_in().unwrap();
    document.lamp.phosphor_rise_rel = 0.8;
    document.lamp.phosphor_lean_rel = 0.1;
    document.lamp.phosphor_lean_azimuth_deg = 60.0;
    // A camera that sees the blue of the chip alone.
    document.camera.qe_peak_nm = 450.0;
    document.camera.qe_width_nm = 20.0;
    document.injected_effects.dark_offset.offset_rel = 0.0;
    document
}

/// The day's plan with spectra over angle, and a distribution coarse enough for a test.
fn plan(folder: &Utf8Path) -> Plan {
    let instruments = Instruments {
        colour: true,
        ..Instruments::default()
    };
    init(
        folder,
        DayPlan::Near,
        &instruments,
        &Subject::default(),
        isolux_app::files::Overwrite::Never,
    )
    .unwrap();
    let file = folder.join("plan.toml");
    let text = std::fs::read_to_string(&file).unwrap();
    let coarse = text
        .replace("c_range = [0, 360, 15]", "c_range = [0, 330, 30]")
        .replace("gamma_range = [0, 180, 2]", "gamma_range = [0, 180, 5]")
        .replace("reference_every = 91", "reference_every = 37");
    Plan::parse(&file, &coarse).unwrap()
}

fn simulated(folder: &Utf8Path, model: &str) -> Simulation {
    let text = format!(
        "format = \"isolux-scene/1\"\nmodel = \"{model}\"\n[sensor]\nsize_mm = {SENSOR_MM:?}\npixels = {BINS}\n\
         distance_mm = 500.0\nresponsivity = \"qe.csv\"\n[sensor.camera]\nexposure_s = 1e-8\n\
         full_well_electrons = 1e9\n\
         gain_dn_per_electron = 1e-4\nbits = 16\n"
    );
    let scene = Scene::parse(&folder.join("scene.toml"), &text).unwrap();
    simulate(&scene, Method::Inverse, &|| 0.0).unwrap()
}

/// Largest difference of two patterns, each relative to its own mean.
fn differ(found: &[f64], truth: &[f64]) -> f64 {
    let mean = |of: &[f64]| of.iter().sum::<f64>() / of.len() as f64;
    let (a, b) = (mean(found), mean(truth));
    let pairs = found.iter().zip(truth);
    pairs
        .map(|(found, truth)| (found / a / (truth / b) - 1.0).abs())
        .fold(0.0, f64::max)
}

#[test]
fn every_pixel_has_the_watts_and_electrons_that_the_rooms_camera_sees() {
    let keep = tempfile::tempdir().unwrap();
    let folder = Utf8PathBuf::try_from(keep.path().to_owned()).unwrap();
    let document = room();
    let run = scanned(document.clone(), &plan(&folder.join("day")));
    let reduction = reduce(&run, &Options::default(), None).unwrap();
    let facts = &reduction.over_angle.as_ref().unwrap().facts;
    assert!(facts.directions.len() >= 29, "{:?}", facts.left_out);
    assert!(
        facts.total.colour.cct.as_ref().unwrap().u.is_some(),
        "{:?}",
        facts.total.colour.cct
    );

    let files = isolux_reduce::files(&reduction, &run, &[], "test").unwrap();
    for file in &files {
        let path = folder.join(&file.name);
        std::fs::create_dir_all(path.parent().unwrap()).unwrap();
        std::fs::write(path, &file.bytes).unwrap();
    }
    let budget: isolux_reduce::Budget =
        serde_json::from_slice(&files.iter().find(|file| file.name == "budget.json").unwrap().bytes).unwrap();
    assert_eq!(budget.colour_over_angle.as_ref(), Some(facts));
    let model = Model::load(&folder.join("luminaire.model.toml")).unwrap();
    assert_eq!(model.colour().unwrap().directions_deg().len(), facts.directions.len());
    // `inspect` integrates the spectra of the model, and of the file for other programs, by itself.
    let cct_k = facts.total.colour.cct.as_ref().unwrap().value;
    for name in ["luminaire.model.toml", "luminaire.tm33-23.xml"] {
        let seen = inspect::file(&folder.join(name), ReadOptions::default()).remove(0);
        let Quantities::Coloured(seen) = seen.quantities else {
            panic!("{name}: {:?}", seen.findings);
        };
        let colour = &seen.colour_over_angle;
        assert_eq!(colour.directions.len(), facts.directions.len(), "{name}");
        let found_k = colour.total.cct_k.unwrap();
        println!(
            "{name}: {found_k} K, reduction {cct_k} K, Δu′v′ {}",
            colour.delta_u_prime_v_prime
        );
        assert!((found_k / cct_k - 1.0).abs() < 2e-3, "{name}: {found_k} K, {cct_k} K");
        assert!(
            colour.delta_u_prime_v_prime > 0.008,
            "{name}: {}",
            colour.delta_u_prime_v_prime
        );
        let written = serde_json::to_string(&Quantities::Coloured(seen.clone())).unwrap();
        assert_eq!(
            serde_json::from_str::<Quantities>(&written).unwrap(),
            Quantities::Coloured(seen)
        );
    }
    let qe = (360..=830).fold(String::from("wavelength_nm,qe\n"), |text, nm| {
        let away = (f64::from(nm) - 450.0) / 20.0;
        text + &format!("{nm},{:e}\n", 0.7 * (-0.5 * away * away).exp())
    });
    std::fs::write(folder.join("qe.csv"), qe).unwrap();
    // The same model with the spectrum of the axis alone.
    let text = std::fs::read_to_string(folder.join("luminaire.model.toml")).unwrap();
    let (head, rest) = text.split_once("\n[[luminaire.colour]]").unwrap();
    let tail = rest.find("\n[noise]").map_or("", |at| &rest[at..]);
    std::fs::write(folder.join("axis.model.toml"), format!("{head}{tail}")).unwrap();

    let room = Room::new(document);
    let frame = SensorFrame {
        size_mm: [SENSOR_MM; 2],
        bins: [BINS; 2],
    };
    let seen = |unit| room.sensor_map(&frame, &MapPose::default(), unit);
    let (watts, signal) = (seen(Unit::WattPerSquareMetre), seen(Unit::Relative));
    let of = |found: &Simulation| {
        let map: Vec<f64> = found.map.iter().map(|value| f64::from(*value)).collect();
        let electrons: Vec<f64> = found
            .signal_dn
            .as_ref()
            .unwrap()
            .iter()
            .map(|dn| f64::from(*dn))
            .collect();
        (differ(&map, &watts), differ(&electrons, &signal))
    };
    let coloured = simulated(&folder, "luminaire.model.toml");
    let (map, electrons) = of(&coloured);
    let (grey_map, grey_electrons) = of(&simulated(&folder, "axis.model.toml"));
    println!("colours: {map:.1e}, {electrons:.1e}; the axis alone: {grey_map:.1e}, {grey_electrons:.1e}");
    assert!(map < 4e-3 && electrons < 6e-3, "{map} {electrons}");
    assert!(
        grey_map > 3.0 * map && grey_electrons > 5.0 * electrons,
        "{grey_map} {grey_electrons}"
    );
    let mean = |of: &[f64]| of.iter().sum::<f64>() / of.len() as f64;
    let level = coloured.facts.mean / mean(&watts) - 1.0;
    assert!(level.abs() < 0.015, "{level}");
}
