//! A lamp whose colour changes over angle, hidden in the darkroom: its single LEDs shine bluer along their axes than
//! beside them. A camera that sees the blue, and a photometer head that is not V(λ), read it with curves of their own.

#![allow(clippy::print_stdout, reason = "the sentences of a sample")]

use std::fmt::Write as _;

use camino::{Utf8Path, Utf8PathBuf};
use isolux_darkroom::camera::Unit;
use isolux_darkroom::spectrum::v_lambda;
use isolux_darkroom::{Kind, MapPose, Observation, Room, SensorFrame};
use isolux_diagnose::diagnosis::diagnose;
use isolux_diagnose::document::{Document, Verdict};
use isolux_diagnose::search::Settings;
use isolux_hidden_effects::random::Draws;
use isolux_hidden_effects::truth::clean_room;
use isolux_model::Model;
use isolux_record::observation::{Need, Observations, open};

/// So wide that its rim lies at γ 31° from 500 mm.
const SENSOR_MM: f64 = 420.0;
const BINS: usize = 12;
/// Relative standard deviation of one bin and of one reading.
const NOISE_REL: f64 = 0.002;

/// A lamp whose phosphor light is so much stronger at 90° from an LED's axis, before a camera that sees blue.
fn room(phosphor_rise_rel: f64) -> Room {
    let mut document = clean_room(0.0);
    document.lamp.phosphor_rise_rel = phosphor_rise_rel;
    document.camera.qe_peak_nm = 450.0;
    document.camera.qe_width_nm = 20.0;
    Room::new(document)
}

/// The folder with the model of a lamp: its intensities are known to 0.1 % of each direction and 1 % of all, its
/// efficacy is that of the light on the axis.
struct Folder {
    _keep: tempfile::TempDir,
    path: Utf8PathBuf,
}

impl Folder {
    fn with_model_of(room: &Room) -> Self {
        let keep = tempfile::tempdir().unwrap();
        let path = Utf8PathBuf::try_from(keep.path().to_owned()).unwrap();
        let mut csv = String::from("gamma_deg,intensity_cd\n");
        for gamma in (0..=90).map(f64::from) {
            let _ = writeln!(csv, "{gamma},{:.6}", room.intensity_cd(0.0, gamma));
        }
        std::fs::write(path.join("distribution.csv"), csv).unwrap();
        let ler = 1.0 / room.spectrum().watt_per_lux(room.phosphor(0.0, 0.0));
        let model = format!(
            "format = \"isolux-model/1\"\n[luminaire]\ndistribution = \"distribution.csv\"\ninterpolation = \
             \"smooth\"\nler_lm_per_w = {ler:?}\nemitter = {{ shape = \"disc\", diameter_mm = 1.0 }}\n\
             [luminaire.u]\nintensity_rel = 0.01\ndirection_rel = 0.001\n[noise]\nu_scale = \"stated\"\n"
        );
        std::fs::write(path.join("model.toml"), model).unwrap();
        Self { _keep: keep, path }
    }

    fn diagnosed(&self, files: &[&str]) -> Document {
        let model = Model::load(&self.path.join("model.toml")).unwrap();
        let sets: Vec<Observations> = files
            .iter()
            .map(|file| open(&self.path.join(file), Need::Values).unwrap())
            .collect();
        let settings = Settings {
            nulls: 300,
            ..Settings::default()
        };
        diagnose(&model, &sets, None, "", &settings).unwrap().document
    }
}

/// Maps of a camera at four poses.
fn maps(room: &Room, folder: &Utf8Path, unit: Unit, seed: u64) {
    let mut draws = Draws::new(seed, 1);
    let frame = SensorFrame {
        size_mm: [SENSOR_MM; 2],
        bins: [BINS; 2],
    };
    let word = match unit {
        Unit::Relative => "relative",
        Unit::Lux => "lx",
        Unit::WattPerSquareMetre => "W/m2",
    };
    let mut toml = format!("sensor_mm = {SENSOR_MM:?}\nbins = {BINS}\nunit = \"{word}\"\n");
    let mut csv = String::from("map,iy,ix,signal,u\n");
    for (name, distance_mm, tilt_x_deg) in [
        ("near", 400.0, 0.0),
        ("middle", 500.0, 0.0),
        ("far", 900.0, 0.0),
        ("tilted", 500.0, 25.0),
    ] {
        let pose = MapPose {
            distance_mm,
            tilt_x_deg,
            ..MapPose::default()
        };
        let _ = writeln!(
            toml,
            "\n[[map]]\nname = \"{name}\"\ndistance_mm = {distance_mm:?}\ntilt_x_deg = {tilt_x_deg:?}"
        );
        for (cell, truth) in room.sensor_map(&frame, &pose, unit).into_iter().enumerate() {
            let u = NOISE_REL * truth;
            let signal = truth + u * draws.normal();
            let _ = writeln!(csv, "{name},{},{},{signal:e},{u:e}", cell / BINS, cell % BINS);
        }
    }
    std::fs::write(folder.join("maps.toml"), toml).unwrap();
    std::fs::write(folder.join("maps.csv"), csv).unwrap();
}

/// What a sensor of this curve makes of one lux of the light in one direction.
fn weighed(room: &Room, curve: &dyn Fn(f64) -> f64, c_deg: f64, gamma_deg: f64) -> f64 {
    let phosphor = room.phosphor(c_deg, gamma_deg);
    let power = |nm: f64| room.spectrum().per_lux(nm, phosphor) * curve(nm);
    (360..=830).map(|nm| power(f64::from(nm))).sum()
}

/// What a head whose curve is V(λ) moved by `moved_nm` reads of the light in one direction, over what it would read of
/// the same illuminance on the axis.
fn head_reads(room: &Room, moved_nm: f64, c_deg: f64, gamma_deg: f64) -> f64 {
    let curve = |nm: f64| v_lambda(nm - moved_nm);
    weighed(room, &curve, c_deg, gamma_deg) / weighed(room, &curve, 0.0, 0.0)
}

/// Twelve half-planes at two distances, by each of `heads`: its number, how far its curve is moved, its gain, and its
/// own slope over |γ|.
fn readings(room: &Room, file: &Utf8Path, heads: &[(u32, f64, f64, f64)], seed: u64) {
    let mut draws = Draws::new(seed, 2);
    let mut csv = String::from(
        "index,block,kind,time_s,c_deg,gamma_deg,distance_mm,travel,range,ambient_c,head,illuminance_lx,u_lx\n",
    );
    let mut index = 0;
    for &(head, moved_nm, gain, slope_per_deg) in heads {
        for distance_mm in [2000.0, 3000.0] {
            for c_deg in (0..12).map(|k| 15.0 * f64::from(k)) {
                for gamma_deg in (-14..=14).map(|k| 5.0 * f64::from(k)) {
                    let time_s = 4.0 * f64::from(index);
                    let at = Observation {
                        kind: Kind::Lit,
                        time_s: 1e6 + time_s,
                        c_deg,
                        gamma_deg,
                        distance_mm,
                        travel: 1.0,
                        range: 1,
                        ambient_c: 25.0,
                    };
                    // The darkroom's own meter is V(λ).
                    let (c, gamma) = if gamma_deg < 0.0 {
                        (c_deg + 180.0, -gamma_deg)
                    } else {
                        (c_deg, gamma_deg)
                    };
                    let colour = if moved_nm == 0.0 {
                        1.0
                    } else {
                        head_reads(room, moved_nm, c, gamma)
                    };
                    let truth = room.indicated_lx(&at) * colour * gain * (1.0 + slope_per_deg * gamma);
                    let u = (NOISE_REL * truth).hypot(0.002);
                    let lx = truth + u * draws.normal();
                    let _ = writeln!(
                        csv,
                        "{index},A,lit,{time_s},{c_deg},{gamma_deg},{distance_mm},1,1,25.0,{head},{lx:.6},{u:.6}"
                    );
                    index += 1;
                }
            }
        }
    }
    std::fs::write(file, csv).unwrap();
}

fn names(document: &Document) -> Vec<&str> {
    document.effects.iter().map(|effect| &*effect.name).collect()
}

fn in_the_set(document: &Document, name: &str) -> bool {
    let holds = |others: &[String]| others.iter().any(|other| other == name);
    document
        .effects
        .iter()
        .any(|effect| effect.name == name || holds(&effect.equivalents))
}

/// A value that was found lies within a tenth of the truth: the form of the effect is not that of the room.
fn assert_near(document: &Document, key: &str, truth: f64) {
    let found = document.effects[0].parameters[key].value;
    println!("{key}: {found} of {truth}");
    assert!((found / truth - 1.0).abs() < 0.1, "{key}: {found} of {truth}");
}

#[test]
fn maps_and_readings_name_the_colour() {
    let room = room(0.4);
    let folder = Folder::with_model_of(&room);
    readings(&room, &folder.path.join("readings.csv"), &[(0, 0.0, 1.0, 0.0)], 1);
    for unit in [Unit::Relative, Unit::WattPerSquareMetre] {
        maps(&room, &folder.path, unit, 2);
        let document = folder.diagnosed(&["readings.csv", "maps.toml"]);
        println!("{unit:?}: {}", document.sentence);
        assert_eq!(document.verdict, Verdict::Named, "{}", document.sentence);
        assert_eq!(names(&document), ["colour_over_angle"], "{}", document.sentence);
        let blue = |nm: f64| nm * (-0.5 * ((nm - 450.0) / 20.0).powi(2)).exp();
        let sensor: &dyn Fn(f64) -> f64 = if unit == Unit::Relative { &blue } else { &|_| 1.0 };
        let at_30 = weighed(&room, sensor, 0.0, 30.0) / weighed(&room, sensor, 0.0, 0.0);
        assert_near(&document, "sensor_rel", 4.0 * (at_30 - 1.0));
    }
}

#[test]
fn maps_alone_have_it_in_the_set() {
    let room = room(0.4);
    let folder = Folder::with_model_of(&room);
    maps(&room, &folder.path, Unit::WattPerSquareMetre, 3);
    let document = folder.diagnosed(&["maps.toml"]);
    println!("{}", document.sentence);
    assert!(in_the_set(&document, "colour_over_angle"), "{}", document.sentence);
}

#[test]
fn two_heads_name_the_colour_and_the_other_alone_has_it_in_the_set() {
    let room = room(0.8);
    let folder = Folder::with_model_of(&room);
    let file = folder.path.join("readings.csv");
    let other = (1, 25.0, 1.013, 0.0);
    readings(&room, &file, &[(0, 0.0, 1.0, 0.0), other], 4);
    let document = folder.diagnosed(&["readings.csv"]);
    println!("both: {}", document.sentence);
    assert_eq!(names(&document), ["colour_over_angle"], "{}", document.sentence);
    let at_60 = head_reads(&room, 25.0, 0.0, 60.0);
    assert_near(&document, "head_rel", 4.0 / 3.0 * (at_60 - 1.0));
    readings(&room, &file, &[other], 5);
    let document = folder.diagnosed(&["readings.csv"]);
    println!("one: {}", document.sentence);
    assert!(in_the_set(&document, "colour_over_angle"), "{}", document.sentence);
}

#[test]
fn a_mismatch_of_both_heads_is_not_called_colour() {
    let room = room(0.0);
    let folder = Folder::with_model_of(&room);
    let file = folder.path.join("readings.csv");
    readings(&room, &file, &[(0, 0.0, 1.0, 2e-4), (1, 0.0, 1.013, 2e-4)], 6);
    let document = folder.diagnosed(&["readings.csv"]);
    println!("{}", document.sentence);
    assert!(
        !names(&document).contains(&"colour_over_angle"),
        "{}",
        document.sentence
    );
    assert!(in_the_set(&document, "spectral_mismatch"), "{}", document.sentence);
}

#[test]
fn a_lamp_of_one_colour_is_consistent() {
    let room = room(0.0);
    let folder = Folder::with_model_of(&room);
    let file = folder.path.join("readings.csv");
    readings(&room, &file, &[(0, 0.0, 1.0, 0.0), (1, 8.0, 1.013, 0.0)], 7);
    maps(&room, &folder.path, Unit::Relative, 8);
    let document = folder.diagnosed(&["readings.csv", "maps.toml"]);
    assert_eq!(document.verdict, Verdict::Consistent, "{}", document.sentence);
}
