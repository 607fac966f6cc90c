//! A lamp whose colour depends on the direction, before a sensor: watts and electrons of every pixel by the room, which
//! mixes the light of chip and phosphor LED by LED, and by a simulation of the spectra in a few directions.

#![expect(clippy::print_stdout, reason = "says how far they differ")]

use std::fmt::Write as _;

use camino::{Utf8Path, Utf8PathBuf};
use isolux_darkroom::camera::Unit;
use isolux_darkroom::{Darkroom, MapPose, Room, SensorFrame};
use isolux_model::{Model, Scene};
use isolux_record::observation::{MapSet, Need};
use isolux_sim::simulation::{Method, Simulation, simulate};

const SENSOR_MM: f64 = 24.0;
const BINS: usize = 12;

/// One LED that turns yellow to all sides, and more so to one.
fn room() -> Room {
    let mut document = Darkroom::default();
    document.lamp.ring_diameter_mm = vec![0.0];
    document.lamp.leds_per_ring = vec![1];
    document.lamp.ellipticity_rel = 0.0;
    document.lamp.aim_spread_deg = 0.0;
    document.lamp.phosphor_rise_rel = 0.6;
    document.lamp.phosphor_lean_rel = 0.12;
    document.lamp.phosphor_lean_azimuth_deg = 35.0;
    document.camera.qe_peak_nm = 520.0;
    document.camera.qe_width_nm = 70.0;
    Room::new(document)
}

fn pose() -> MapPose {
    MapPose {
        distance_mm: 40.0,
        tilt_x_deg: 12.0,
        rot_z_deg: 25.0,
        offset_mm: [9.0, -6.0],
        ..MapPose::default()
    }
}

/// The files of a model of that room's lamp: spectra in four half-planes every `step` degrees.
fn write_model(folder: &Utf8Path, room: &Room, step: usize, of_axis_alone: bool) {
    let mut distribution = String::from("gamma_deg,intensity_cd\n");
    for step in 0..=360 {
        let gamma = f64::from(step) * 0.5;
        writeln!(distribution, "{gamma},{}", room.intensity_cd(0.0, gamma)).unwrap();
    }
    std::fs::write(folder.join("lamp.csv"), distribution).unwrap();
    let mut text = String::from(
        "format = \"isolux-model/1\"\n[luminaire]\ndistribution = \"lamp.csv\"\ninterpolation = \"smooth\"\n\
         spectrum = \"c0_g0.csv\"\n",
    );
    let directions = (0..=80).step_by(step).flat_map(|gamma| {
        let planes: &[i32] = if gamma == 0 { &[0] } else { &[0, 90, 180, 270] };
        planes.iter().map(move |c| (*c, gamma))
    });
    for (c, gamma) in directions.filter(|direction| *direction == (0, 0) || !of_axis_alone) {
        let phosphor = room.phosphor(f64::from(c), gamma as f64);
        // A scale of its own, as an instrument further to the side has it.
        let mut spectrum = String::from("wavelength_nm,irradiance\n");
        for nm in 360..=830 {
            let value = 0.01 * (1.0 + gamma as f64) * room.spectrum().per_lux(f64::from(nm), phosphor);
            writeln!(spectrum, "{nm},{value:e}").unwrap();
        }
        std::fs::write(folder.join(format!("c{c}_g{gamma}.csv")), spectrum).unwrap();
        writeln!(
            text,
            "[[luminaire.colour]]\nc_deg = {c}.0\ngamma_deg = {gamma}.0\nspectrum = \"c{c}_g{gamma}.csv\""
        )
        .unwrap();
    }
    std::fs::write(folder.join("lamp.model.toml"), text).unwrap();
    let qe: String = (360..=830).fold(String::from("wavelength_nm,qe\n"), |text, nm| {
        text + &format!(
            "{nm},{:e}\n",
            0.8 * (-0.5 * ((f64::from(nm) - 520.0) / 70.0).powi(2)).exp()
        )
    });
    std::fs::write(folder.join("camera.csv"), qe).unwrap();
}

fn simulated(room: &Room, step: usize, of_axis_alone: bool) -> Simulation {
    let keep = tempfile::tempdir().unwrap();
    let folder = Utf8PathBuf::try_from(keep.path().to_owned()).unwrap();
    write_model(&folder, room, step, of_axis_alone);
    let pose = pose();
    // So many electrons that their noise is below 10⁻⁴.
    let text = format!(
        "format = \"isolux-scene/1\"\nmodel = \"lamp.model.toml\"\n[sensor]\nsize_mm = {SENSOR_MM:?}\npixels = {BINS}\n\
         distance_mm = {:?}\ntilt_x_deg = {:?}\nrot_z_deg = {:?}\noffset_mm = {:?}\nresponsivity = \"camera.csv\"\n\
         [sensor.camera]\nexposure_s = 2.5e-7\nfull_well_electrons = 1e9\ngain_dn_per_electron = 5e-5\nbits = 16\n",
        pose.distance_mm, pose.tilt_x_deg, pose.rot_z_deg, pose.offset_mm
    );
    let scene = Scene::parse(&folder.join("scene.toml"), &text).unwrap();
    simulate(&scene, Method::Inverse, &|| 0.0).unwrap()
}

/// Prediction of a map in W/m², by which a diagnosis judges a camera.
#[test]
fn a_map_in_watts_is_predicted_with_the_colour_of_each_direction() {
    let room = room();
    let keep = tempfile::tempdir().unwrap();
    let folder = Utf8PathBuf::try_from(keep.path().to_owned()).unwrap();
    let pose = pose();
    let maps = format!(
        "sensor_mm = [{SENSOR_MM:?}, {SENSOR_MM:?}]\nbins = [{BINS}, {BINS}]\nunit = \"W/m2\"\n[[map]]\n\
         name = \"tilted\"\n\
         distance_mm = {:?}\ntilt_x_deg = {:?}\nrot_z_deg = {:?}\noffset_mm = {:?}\n",
        pose.distance_mm, pose.tilt_x_deg, pose.rot_z_deg, pose.offset_mm
    );
    std::fs::write(folder.join("maps.toml"), maps).unwrap();
    let maps = MapSet::open(&folder.join("maps.toml"), Need::Coordinates).unwrap();
    let frame = SensorFrame {
        size_mm: [SENSOR_MM; 2],
        bins: [BINS; 2],
    };
    let watts = room.sensor_map(&frame, &pose, Unit::WattPerSquareMetre);
    let differs = |of_axis_alone: bool| {
        write_model(&folder, &room, 10, of_axis_alone);
        let model = Model::load(&folder.join("lamp.model.toml")).unwrap();
        let found = model.predict_maps(&maps);
        let pairs = found.iter().zip(&watts);
        pairs
            .map(|(found, watts)| (found / watts - 1.0).abs())
            .fold(0.0, f64::max)
    };
    let (coloured, grey) = (differs(false), differs(true));
    println!("predicted: {coloured:.1e}; by the axis alone {grey:.1e}");
    assert!(coloured < 2e-3 && grey > 2e-2, "{coloured} {grey}");
}

#[test]
fn watts_and_electrons_of_every_pixel_are_those_of_its_own_colour() {
    let room = room();
    let frame = SensorFrame {
        size_mm: [SENSOR_MM; 2],
        bins: [BINS; 2],
    };
    let watts = room.sensor_map(&frame, &pose(), Unit::WattPerSquareMetre);
    let signal = room.sensor_map(&frame, &pose(), Unit::Relative);
    // Largest relative difference of the map in W/m², and of the electrons relative to their mean.
    let differs = |found: &Simulation| {
        let map = found.map.iter().zip(&watts);
        let map = map.map(|(map, watts)| (f64::from(*map) / watts - 1.0).abs());
        let dn: Vec<f64> = found
            .signal_dn
            .as_ref()
            .unwrap()
            .iter()
            .map(|dn| f64::from(*dn))
            .collect();
        assert!(dn.iter().all(|dn| (5e3..6.5e4).contains(dn)), "{dn:?}");
        let per_signal = dn.iter().sum::<f64>() / signal.iter().sum::<f64>();
        let electrons = dn.iter().zip(&signal);
        let electrons = electrons.map(|(dn, signal)| (dn / (per_signal * signal) - 1.0).abs());
        (map.fold(0.0, f64::max), electrons.fold(0.0, f64::max))
    };
    let fine = simulated(&room, 5, false);
    let (map, electrons) = differs(&fine);
    println!("every 5°: map {map:.1e}, electrons {electrons:.1e}");
    assert!(map < 6e-4 && electrons < 6e-4, "{map} {electrons}");
    let (map, electrons) = differs(&simulated(&room, 10, false));
    println!("every 10°: map {map:.1e}, electrons {electrons:.1e}");
    assert!(map < 1.5e-3 && electrons < 2.5e-3, "{map} {electrons}");
    let (map, electrons) = differs(&simulated(&room, 10, true));
    println!("the axis alone: map {map:.1e}, electrons {electrons:.1e}");
    assert!(
        map > 5e-3 && electrons > 5e-3,
        "{map} {electrons}: the colour matters here"
    );

    // The spectrum on the sensor is the mean of its pixels: its lux are those of the room.
    let lux = room.sensor_map(&frame, &pose(), Unit::WattPerSquareMetre).len() as f64;
    let grey = Room::new(Darkroom {
        camera: isolux_darkroom::parts::Camera {
            qe_peak_nm: 0.0,
            ..room.document().camera.clone()
        },
        ..room.document().clone()
    });
    let lux = grey.sensor_map(&frame, &pose(), Unit::Lux).iter().sum::<f64>() / lux;
    assert!(
        (fine.facts.illuminance_lx / lux - 1.0).abs() < 5e-4,
        "{} {lux}",
        fine.facts.illuminance_lx
    );
    let colour = fine.facts.colour.as_ref().unwrap();
    assert!(colour.delta_u_prime_v_prime > 0.005, "{colour:?}");
}
