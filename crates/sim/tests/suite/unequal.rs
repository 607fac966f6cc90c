//! Emitters whose parts give unequally, against sums over their parts that are written down here.

use camino::Utf8Path;
use glam::DVec3;
use isolux_model::{Effect, Emitter, Luminaire, Model, Scene, Spectral};
use isolux_photometry::IntensityDistribution;
use isolux_sim::inverse::{self, Accuracy};
use isolux_sim::setup::Setup;

const RADIUS_MM: f64 = 28.0;
const DISTANCE_MM: f64 = 150.0;
const DEPTH: f64 = 0.3;
const WIDTH_DEG: f64 = 120.0;

/// LEDs of a ring: azimuth in degrees, place, axis.
fn ring(aim_deg: f64) -> impl Iterator<Item = (f64, DVec3, DVec3)> {
    (0..36).map(move |led| {
        let azimuth_deg = 10.0 * f64::from(led);
        let (sin, cos) = azimuth_deg.to_radians().sin_cos();
        let (sin_aim, cos_aim) = aim_deg.to_radians().sin_cos();
        let outward = DVec3::new(cos, sin, 0.0);
        (azimuth_deg, RADIUS_MM * outward, cos_aim * DVec3::Z - sin_aim * outward)
    })
}

/// 1000 cd of cos⁵ lobes in all, E in lx on a plane that faces the lamp; the sector at C 0° dimmed, or not.
fn illuminance_lx(point: DVec3, aim_deg: f64, depth: f64) -> f64 {
    let of_led = |(azimuth_deg, place, axis): (f64, DVec3, DVec3)| {
        let apart = (azimuth_deg + 180.0).rem_euclid(360.0) - 180.0;
        let lobe = if apart.abs() < WIDTH_DEG {
            0.5 * (1.0 + (std::f64::consts::PI * apart / WIDTH_DEG).cos())
        } else {
            0.0
        };
        let path = point - place;
        let intensity_cd = 1000.0 / 36.0 * axis.dot(path.normalize()).max(0.0).powi(5);
        (1.0 - depth * lobe) * intensity_cd * path.z / path.length().powi(3) * 1e6
    };
    ring(aim_deg).map(of_led).sum()
}

/// A lamp that is measured from far away, with all its LEDs.
fn measured(aim_deg: f64, emitter: Emitter) -> Model {
    let gamma_deg: Vec<f64> = (0..=90).map(f64::from).collect();
    let far_mm = 1e7;
    let intensity_cd = gamma_deg
        .iter()
        .map(|gamma| {
            let (sin, cos) = gamma.to_radians().sin_cos();
            let direction = DVec3::new(sin, 0.0, cos);
            let lobes = ring(aim_deg)
                .map(|(_, place, axis)| axis.dot((direction * far_mm - place).normalize()).max(0.0).powi(5));
            1000.0 / 36.0 * lobes.sum::<f64>()
        })
        .collect();
    let distribution = IntensityDistribution::new(vec![0.0], gamma_deg, intensity_cd).unwrap();
    Model::of(Luminaire::new(distribution, emitter, Spectral::None))
}

fn map_lx(model: &Model) -> Vec<f64> {
    let text = format!(
        "format = \"isolux-scene/1\"\nmodel = \"lamp.model.toml\"\n[sensor]\nsize_mm = [36.0, 36.0]\npixels = [3, 3]\n\
         distance_mm = {DISTANCE_MM:.1}\n"
    );
    let scene = Scene::parse_with(Utf8Path::new("scene.toml"), &text, model).unwrap();
    let setup = Setup::new(&scene).unwrap();
    inverse::solve(&setup.source, &setup.sensor, Accuracy::Reference).illuminance_lx
}

/// The change that the dimmed sector makes at the middle row, ratio to the whole lamp: a simulation and the sum.
fn changes(aim_deg: f64, emitter: &Emitter) -> [[f64; 3]; 2] {
    let whole = measured(aim_deg, emitter.clone());
    let keys = [
        ("depth_rel", DEPTH),
        ("azimuth_deg", 0.0),
        ("width_deg", WIDTH_DEG),
        ("aim_deg", aim_deg),
    ];
    let dimmed = whole.with_effects(vec![Effect::from_keys("dead_sector", keys).unwrap()]);
    let (whole, dimmed) = (map_lx(&whole), map_lx(&dimmed));
    let simulated = [3, 4, 5].map(|pixel| dimmed[pixel] / whole[pixel]);
    let summed = [-12.0, 0.0, 12.0].map(|x| {
        let point = DVec3::new(x, 0.0, DISTANCE_MM);
        illuminance_lx(point, aim_deg, DEPTH) / illuminance_lx(point, aim_deg, 0.0)
    });
    [simulated, summed]
}

#[test]
fn a_dimmed_sector_of_leds_darkens_its_own_side_or_the_other() {
    for aim_deg in [0.0, 6.0] {
        let emitter = Emitter::Leds {
            position_mm: vec![],
            weight: vec![],
            radius_mm: vec![RADIUS_MM],
            count: vec![36],
            aim_deg,
        };
        let [simulated, summed] = changes(aim_deg, &emitter);
        for (simulated, summed) in simulated.into_iter().zip(summed) {
            assert!(
                (simulated - summed).abs() < 3e-4,
                "aim {aim_deg}°: {simulated} for {summed}"
            );
        }
    }
}

#[test]
fn the_nodes_of_an_area_lose_what_a_sector_loses() {
    let ring = Emitter::Ring {
        inner_diameter_mm: 2.0 * RADIUS_MM - 1.0,
        outer_diameter_mm: 2.0 * RADIUS_MM + 1.0,
    };
    // LEDs at 0.84 of the radius: those of the sum.
    let disc = Emitter::Disc {
        diameter_mm: 2.0 * RADIUS_MM / 0.84,
    };
    for emitter in [ring, disc] {
        let [simulated, summed] = changes(0.0, &emitter);
        for (simulated, summed) in simulated.into_iter().zip(summed) {
            assert!(
                (simulated - summed).abs() < 3e-4,
                "{emitter:?}: {simulated} for {summed}"
            );
        }
    }
}
