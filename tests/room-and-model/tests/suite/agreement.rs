//! For every effect: switch it on in the room, put the same keys into the model, and compare what each says has
//! changed.

use std::fmt::Write as _;

use camino::Utf8PathBuf;
use isolux_darkroom::camera::Unit;
use isolux_darkroom::{Darkroom, Kind, MapPose, Observation, Room, SensorFrame};
use isolux_model::{Model, catalogue};
use isolux_record::ReadingKind;
use isolux_record::observation::{MapSet, Need, ReadingCoordinates};

type Keys<'a> = &'a [(&'a str, f64)];

/// A lamp that a file of γ alone can hold: one point, no C asymmetry.
fn darkroom() -> Darkroom {
    let mut document = Darkroom::default();
    document.lamp.ring_diameter_mm = vec![0.0];
    document.lamp.leds_per_ring = vec![1];
    document.lamp.ellipticity_rel = 0.0;
    document.lamp.flux_spread_rel = 0.0;
    document.lamp.aim_spread_deg = 0.0;
    document.luxmeter.gain_error_rel = 0.0;
    document.injected_effects.lamp_warmup.second_share = 0.0;
    document
}

fn disturbed(mut document: Darkroom, effect: &str, keys: Keys<'_>) -> Room {
    for (key, value) in keys {
        // A lamp of rings is no injected effect of the room: it is the lamp.
        match (effect, *key) {
            ("near_field", "radius_mm") => {
                document.lamp.ring_diameter_mm = vec![2.0 * value];
                document.lamp.leds_per_ring = vec![48];
            }
            ("near_field", "aim_deg") => document.lamp.aim_deg = *value,
            _ => assert!(document.injected_effects.set(effect, key, *value), "{effect}.{key}"),
        }
    }
    Room::new(document)
}

/// The model of the lamp that `room` holds, with one effect.
fn model(folder: &tempfile::TempDir, room: &Room, effect: Option<(&str, Keys<'_>)>) -> Model {
    let path = Utf8PathBuf::try_from(folder.path().to_owned()).unwrap();
    let mut distribution = String::from("gamma_deg,intensity_cd\n");
    for step in 0..=360 {
        let gamma = f64::from(step) * 0.5;
        writeln!(distribution, "{gamma},{}", room.intensity_cd(0.0, gamma)).unwrap();
    }
    std::fs::write(path.join("lamp.csv"), distribution).unwrap();
    let mut text = String::from(
        "format = \"isolux-model/1\"\n[luminaire]\ndistribution = \"lamp.csv\"\nler_lm_per_w = 311.4\n\
         emitter = { shape = \"point\" }\n",
    );
    if let Some((name, keys)) = effect {
        writeln!(text, "[[effect]]\nname = {name:?}").unwrap();
        for (key, value) in keys {
            writeln!(text, "{key} = {value:?}").unwrap();
        }
    }
    std::fs::write(path.join("lamp.model.toml"), text).unwrap();
    Model::load(&path.join("lamp.model.toml")).unwrap()
}

/// A plan that shows every bench effect: three distances, signed γ, both directions, two ranges, two temperatures,
/// darks.
fn plan() -> Vec<Observation> {
    let mut plan = Vec::new();
    for (kind, distance_mm) in [
        (Kind::Lit, 3000.0),
        (Kind::Lit, 2000.0),
        (Kind::Lit, 700.0),
        (Kind::Baffled, 2000.0),
        (Kind::LampOff, 2000.0),
        (Kind::Capped, 2000.0),
    ] {
        for c_deg in [0.0, 45.0, 90.0, 200.0] {
            for gamma in (-70..=70).step_by(10) {
                let number = plan.len() as f64;
                plan.push(Observation {
                    kind,
                    time_s: 30.0 + 20.0 * number,
                    c_deg,
                    gamma_deg: f64::from(gamma),
                    distance_mm,
                    travel: if gamma % 20 == 0 { 1.0 } else { -1.0 },
                    range: if distance_mm > 2500.0 { 1 } else { 2 },
                    ambient_c: 23.0 + 0.01 * number,
                });
            }
        }
    }
    plan
}

fn coordinates(o: &Observation) -> ReadingCoordinates {
    ReadingCoordinates {
        kind: match o.kind {
            Kind::Lit => ReadingKind::Lit,
            Kind::Baffled => ReadingKind::Baffled,
            Kind::LampOff => ReadingKind::LampOff,
            Kind::Capped => ReadingKind::Capped,
        },
        time_s: Some(o.time_s),
        lamp_s: None,
        c_deg: o.c_deg,
        gamma_deg: o.gamma_deg,
        distance_mm: o.distance_mm,
        travel: o.travel as i8,
        range: Some(i32::from(o.range)),
        ambient_c: Some(o.ambient_c),
        head: 0,
    }
}

/// rms of what differs between the two changes, over the rms of the room's change. Each reading counts relative to the
/// lit reading at its distance, so that no distance drowns another.
fn disagreement(scale: &[f64], room: (&[f64], &[f64]), model: (&[f64], &[f64])) -> (f64, f64) {
    let (mut wrong, mut whole) = (0.0, 0.0);
    for (k, scale) in scale.iter().enumerate() {
        let by_room = (room.1[k] - room.0[k]) / scale;
        let by_model = (model.1[k] - model.0[k]) / scale;
        wrong += (by_model - by_room).powi(2);
        whole += by_room * by_room;
    }
    ((whole / scale.len() as f64).sqrt(), (wrong / whole).sqrt())
}

#[test]
fn readings_change_alike_in_room_and_model() {
    let folder = tempfile::tempdir().unwrap();
    let plan = plan();
    let at: Vec<ReadingCoordinates> = plan.iter().map(coordinates).collect();
    let clean_room = Room::new(darkroom());
    let read = |room: &Room| -> Vec<f64> { plan.iter().map(|o| room.indicated_lx(o)).collect() };
    let room_before = read(&clean_room);
    let model_before = model(&folder, &clean_room, None).predict_readings(&at);
    for (o, (room, model)) in plan.iter().zip(room_before.iter().zip(&model_before)) {
        assert!(
            (room - model).abs() <= 2e-4 * room.abs() + 1e-12,
            "{o:?}: {room} {model}"
        );
    }
    let scale: Vec<f64> = plan
        .iter()
        .map(|o| clean_room.intensity_cd(0.0, 0.0) * 1e6 / o.distance_mm.powi(2))
        .collect();
    let effects: &[(&str, Keys<'_>, f64)] = &[
        ("ambient_stray", &[("illuminance_lx", 0.3)], 1e-6),
        ("dark_offset", &[("offset_lx", -0.2)], 1e-6),
        ("floor_reflection", &[("albedo", 0.3), ("height_mm", 1000.0)], 0.02),
        ("distance_offset", &[("offset_mm", 8.0)], 0.01),
        ("axial_centre", &[("offset_mm", 10.0)], 0.03),
        ("lateral_centre", &[("offset_mm", 5.0), ("azimuth_deg", 30.0)], 0.03),
        ("near_field", &[("radius_mm", 20.0)], 0.03),
        ("near_field", &[("radius_mm", 20.0), ("aim_deg", 5.0)], 0.15),
        ("gamma_zero", &[("offset_deg", 0.2)], 0.01),
        ("gamma_sag", &[("amplitude_deg", 0.2)], 0.01),
        ("luminaire_tilt", &[("angle_deg", 0.4), ("azimuth_deg", 70.0)], 0.02),
        ("axis_nonperp", &[("angle_deg", 1.0)], 0.05),
        ("backlash", &[("width_deg", 0.3)], 0.01),
        ("nonlinearity", &[("inverse_scale_per_lx", 2e-5)], 0.03),
        ("range_step", &[("factor_rel", 0.01), ("range", 2.0)], 1e-6),
        ("temp_coefficient", &[("coefficient_per_k", 0.005)], 1e-6),
        (
            "lamp_warmup",
            &[("amplitude_rel", 0.05), ("time_constant_s", 600.0)],
            0.01,
        ),
        ("lamp_drift", &[("rate_per_h", 0.01)], 0.02),
        (
            "flicker_alias",
            &[("amplitude_rel", 0.02), ("period_s", 300.0), ("phase_rad", 1.0)],
            0.01,
        ),
        // A flat obstacle here, a round lobe of directions there.
        (
            "self_absorption",
            &[
                ("depth_rel", 0.1),
                ("azimuth_deg", 40.0),
                ("gamma_deg", 40.0),
                ("width_deg", 30.0),
            ],
            0.15,
        ),
        ("polarization", &[("amplitude_rel", 0.01), ("azimuth_deg", 25.0)], 1e-6),
        // A flat disc also averages cos³ε/d², which is a level and no shape: n + 3 against n of the lobe's
        // curvature.
        ("detector_aperture", &[("diameter_mm", 60.0)], 0.45),
        ("spectral_mismatch", &[("factor", 1.01), ("slope_per_deg", 1e-4)], 0.01),
        ("air_absorption", &[("coefficient_per_m", 0.01)], 0.01),
    ];
    let mut report = String::new();
    let mut failed = false;
    for (name, keys, tolerance) in effects {
        let room = disturbed(darkroom(), name, keys);
        let base = if *name == "near_field" { &room } else { &clean_room };
        let after = model(&folder, base, Some((name, keys))).predict_readings(&at);
        let before = if *name == "near_field" {
            model(&folder, base, None).predict_readings(&at)
        } else {
            model_before.clone()
        };
        // The aimed ring has a far field of its own: the change is that against a point with the same far field.
        let room_base = if *name == "near_field" {
            before.clone()
        } else {
            room_before.clone()
        };
        let (size, gap) = disagreement(&scale, (&room_base, &read(&room)), (&before, &after));
        let verdict = if gap <= *tolerance { "" } else { "  <-- apart" };
        failed |= gap > *tolerance;
        writeln!(
            report,
            "{name:20} changes by {size:.2e}, apart by {gap:.2e} of it{verdict}"
        )
        .unwrap();
    }
    assert!(!failed, "\n{report}");
}

const POSES: &str = r#"
sensor_mm = 24.576
bins = 8
unit = "relative"
full_scale = 1.0
[[map]]
name = "d500"
distance_mm = 500.0
[[map]]
name = "half"
distance_mm = 500.0
exposure = 0.5
[[map]]
name = "d150"
distance_mm = 150.0
exposure = 0.09
[[map]]
name = "tilted"
distance_mm = 300.0
tilt_x_deg = 40.0
rot_z_deg = 90.0
exposure = 0.36
[[map]]
name = "other"
distance_mm = 300.0
tilt_y_deg = -35.0
offset_mm = [10.0, -4.0]
exposure = 0.36
[[map]]
name = "off"
distance_mm = 500.0
lamp = false
[[map]]
name = "capped"
distance_mm = 500.0
capped = true
"#;

#[test]
fn maps_change_alike_in_room_and_model() {
    let folder = tempfile::tempdir().unwrap();
    let path = Utf8PathBuf::try_from(folder.path().join("maps.toml")).unwrap();
    std::fs::write(&path, POSES).unwrap();
    let maps = MapSet::open(&path, Need::Coordinates).unwrap();
    let frame = SensorFrame {
        size_mm: maps.sensor_mm(),
        bins: maps.bins(),
    };
    let record = |room: &Room| -> Vec<f64> {
        let pose = |map: &isolux_record::observation::MapPose| MapPose {
            distance_mm: map.distance_mm,
            tilt_x_deg: map.tilt_x_deg,
            tilt_y_deg: map.tilt_y_deg,
            rot_z_deg: map.rot_z_deg,
            offset_mm: map.offset_mm,
            exposure: map.exposure,
            lamp: map.lamp,
            capped: map.capped,
            time_s: map.time_s,
        };
        maps.maps()
            .iter()
            .flat_map(|map| room.sensor_map(&frame, &pose(map), Unit::Relative))
            .collect()
    };
    let clean_room = Room::new(darkroom());
    let room_before = record(&clean_room);
    let clean_model = model(&folder, &clean_room, None);
    let raw = clean_model.predict_maps(&maps);
    // One gain, common to all maps, is free.
    let gain = room_before.iter().sum::<f64>() / raw.iter().sum::<f64>();
    let predict = |model: &Model| -> Vec<f64> { model.predict_maps(&maps).iter().map(|s| s * gain).collect() };
    let model_before = predict(&clean_model);
    for (k, (room, model)) in room_before.iter().zip(&model_before).enumerate() {
        assert!((room - model).abs() < 1e-4, "bin {k}: {room} {model}");
    }
    let scale = vec![1.0; room_before.len()];
    let effects: &[(&str, Keys<'_>, f64)] = &[
        ("near_field", &[("radius_mm", 20.0)], 0.05),
        ("stage_lateral", &[("offset_mm", 2.0), ("azimuth_deg", 30.0)], 0.02),
        ("sensor_axial", &[("offset_mm", 2.0)], 0.02),
        ("sensor_tilt", &[("angle_deg", 1.0), ("azimuth_deg", 50.0)], 0.02),
        ("source_tilt", &[("angle_deg", 1.0), ("azimuth_deg", 50.0)], 0.02),
        ("pixel_angular", &[("coefficient", 0.3)], 0.02),
        ("vignetting", &[("coefficient_rel", 0.02)], 0.05),
        ("prnu_gradient", &[("gradient_rel", 0.01), ("azimuth_deg", 50.0)], 0.02),
        (
            "flicker_banding",
            &[("amplitude_rel", 0.01), ("period_mm", 12.0), ("phase_rad", 0.7)],
            0.1,
        ),
        (
            "ghost",
            &[
                ("amplitude_rel", 0.01),
                ("x_mm", 3.0),
                ("y_mm", -2.0),
                ("width_mm", 5.0),
            ],
            0.15,
        ),
        ("exposure_offset", &[("offset", 0.01)], 0.02),
        (
            "lamp_warmup",
            &[("amplitude_rel", 0.05), ("time_constant_s", 600.0)],
            0.02,
        ),
        ("air_absorption", &[("coefficient_per_m", 0.05)], 0.02),
    ];
    let mut report = String::new();
    let mut failed = false;
    for (name, keys, tolerance) in effects {
        let room = disturbed(darkroom(), name, keys);
        let model = model(&folder, &clean_room, Some((name, keys)));
        let (size, gap) = disagreement(
            &scale,
            (&room_before, &record(&room)),
            (&model_before, &predict(&model)),
        );
        // Without a time the lamp is warm in both.
        let apart = if size == 0.0 {
            predict(&model) != model_before
        } else {
            gap > *tolerance
        };
        failed |= apart;
        let verdict = if apart { "  <-- apart" } else { "" };
        writeln!(
            report,
            "{name:20} changes by {size:.2e}, apart by {gap:.2e} of it{verdict}"
        )
        .unwrap();
    }
    assert!(!failed, "\n{report}");
}

#[test]
fn every_effect_of_the_catalogue_is_a_switch_of_the_room() {
    let injected_effects = isolux_darkroom::InjectedEffects::default().values();
    for effect in catalogue() {
        // The lamp's rings, their lobe and their phosphor are [lamp], not an injected effect.
        if ["near_field", "beam_width", "colour_over_angle"].contains(&effect.name) {
            continue;
        }
        for parameter in effect.parameters {
            // The camera's ambient light is switched in lx alone.
            if (effect.name, parameter.key) == ("ambient_light", "irradiance_w_m2") {
                continue;
            }
            // How LEDs lean is [lamp], too.
            if parameter.without_leds {
                continue;
            }
            assert!(
                injected_effects
                    .iter()
                    .any(|(name, key, _)| (*name, *key) == (effect.name, parameter.key)),
                "{}.{}",
                effect.name,
                parameter.key
            );
        }
    }
}
