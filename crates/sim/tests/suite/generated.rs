//! Seeded random luminaires, emitters and poses.

use std::sync::Arc;

use glam::DVec3;
use isolux_photometry::IntensityDistribution;
use isolux_sim::random::{Purpose, Random};
use isolux_sim::sensor::{Pose, Sensor};
use isolux_sim::source::{LightSource, Part, Shape};
use isolux_sim::table::IntensityTable;

/// Numbers of one scene.
struct Dice {
    numbers: Vec<f64>,
}

impl Dice {
    fn new(scene: u64) -> Self {
        let mut sequence = Random::new(2026, Purpose::Trial).sequence(scene);
        Self {
            numbers: (0..4000).map(|_| sequence.uniform()).collect(),
        }
    }

    fn next(&mut self) -> f64 {
        self.numbers.pop().expect("fewer numbers")
    }

    fn within(&mut self, low: f64, high: f64) -> f64 {
        low + (high - low) * self.next()
    }

    fn one<T: Copy>(&mut self, of: &[T]) -> T {
        of[(self.next() * of.len() as f64) as usize]
    }
}

/// A lobe of random width, lopsided and rough by 3 %, on a coarse, fine or uneven grid, to 90° or 180°.
fn lamp(dice: &mut Dice) -> IntensityDistribution {
    let end = dice.one(&[90.0, 90.0, 180.0]);
    let step = dice.one(&[2.5, 5.0, 10.0, 18.0]);
    let mut gamma_deg: Vec<f64> = (0..=(end / step) as i32).map(|k| f64::from(k) * step).collect();
    let uneven = dice.next() < 0.2;
    if uneven {
        gamma_deg.retain(|gamma| *gamma == 0.0 || *gamma >= 11.0);
        gamma_deg.splice(1..1, [2.0, 3.5, 7.0]);
    }
    let c_deg: Vec<f64> = match dice.one(&[0, 1, 2, 3]) {
        0 => vec![0.0],
        1 => (0..8).map(|k| 45.0 * f64::from(k)).collect(),
        2 => (0..24).map(|k| 15.0 * f64::from(k)).collect(),
        _ => vec![0.0, 7.0, 40.0, 90.0, 101.0, 180.0, 200.0, 270.0, 333.0],
    };
    let exponent = dice.one(&[1.0, 2.0, 5.3, 20.0, 150.0]);
    let (lean, phase, equal_at_pole) = (
        dice.within(0.0, 0.3),
        dice.within(0.0, std::f64::consts::TAU),
        dice.next() < 0.7,
    );
    let mut intensity_cd = Vec::new();
    for c in &c_deg {
        for gamma in &gamma_deg {
            let (sin, cos) = gamma.to_radians().sin_cos();
            let rough = if *gamma == 0.0 && equal_at_pole {
                0.0
            } else {
                dice.within(-0.03, 0.03)
            };
            let side = 1.0 + lean * sin * (c.to_radians() - phase).cos();
            intensity_cd.push(
                1000.0 * cos.max(0.0).powf(exponent) * side * (1.0 + rough) + if end > 90.0 { 20.0 } else { 0.0 },
            );
        }
    }
    IntensityDistribution::new(c_deg, gamma_deg, intensity_cd).unwrap()
}

fn shape(dice: &mut Dice) -> Shape {
    let centre = DVec3::ZERO;
    match dice.one(&[0, 1, 2, 3]) {
        0 => Shape::Point(centre),
        1 => Shape::Disc {
            centre,
            radius: dice.one(&[0.5, 2.5, 12.0]),
        },
        2 => Shape::Ring {
            centre,
            inner: dice.one(&[8.0, 13.0]),
            outer: 17.0,
        },
        _ => Shape::Rectangle {
            centre,
            half: [dice.within(1.0, 15.0), dice.within(1.0, 15.0)],
        },
    }
}

/// The luminaire and the sensor of a number.
pub fn scene(number: u64) -> (LightSource, Sensor) {
    let mut dice = Dice::new(number);
    let table = Arc::new(IntensityTable::new(&lamp(&mut dice)));
    let source = if dice.next() < 0.15 {
        let part = |k: u32| {
            let (sin, cos) = (std::f64::consts::TAU * f64::from(k) / 5.0).sin_cos();
            Part {
                share: 0.2,
                shape: Shape::Point(DVec3::new(14.0 * cos, 14.0 * sin, 0.0)),
                table: Arc::clone(&table),
                aim: None,
            }
        };
        LightSource::new((0..5).map(part).collect())
    } else {
        LightSource::single(table, shape(&mut dice))
    };
    let side = dice.within(5.0, 60.0);
    // An emitter far smaller than a pixel goes by chords both ways, and slowly.
    let radius = source.radius();
    let pixels = dice.one(&[[3, 2], [7, 5], [40, 31]]);
    let pixels = if radius > 0.0 && side / pixels[0] as f64 > 2.0 * radius {
        [(side / radius).ceil() as usize; 2]
    } else {
        pixels
    };
    let sensor = Sensor::new(&Pose {
        size_mm: [side, dice.within(0.5, 1.0) * side],
        pixels,
        distance_mm: dice.one(&[20.0, 40.0, 100.0, 300.0]),
        tilt_x_deg: dice.within(-25.0, 25.0),
        tilt_y_deg: dice.within(-25.0, 25.0),
        rot_z_deg: dice.within(0.0, 360.0),
        offset_mm: [dice.within(-8.0, 8.0), dice.within(-8.0, 8.0)],
    })
    .unwrap();
    (source, sensor)
}

/// A disc and one pixel that faces it, `size` times 0.12 to 3 radii wide and so far away that its light hardly bends.
pub fn one_pixel(number: u64, size: f64) -> (LightSource, Sensor) {
    let mut dice = Dice::new(number);
    let table = Arc::new(IntensityTable::new(&lamp(&mut dice)));
    let radius = dice.within(3.0, 20.0);
    let side = radius * dice.one(&[0.12, 0.3, 0.6, 1.0, 3.0]);
    let distance_mm = side * 10_f64.powf(dice.within(1.0, 3.0)) + radius;
    let sensor = Sensor::new(&Pose {
        size_mm: [size * side; 2],
        pixels: [1, 1],
        distance_mm,
        tilt_x_deg: 0.0,
        tilt_y_deg: 0.0,
        rot_z_deg: dice.within(0.0, 360.0),
        offset_mm: [dice.within(-100.0, 100.0), dice.within(-100.0, 100.0)],
    })
    .unwrap();
    let centre = DVec3::ZERO;
    (LightSource::single(table, Shape::Disc { centre, radius }), sensor)
}
