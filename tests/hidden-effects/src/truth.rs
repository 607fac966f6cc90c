//! The clean truth of a plan: what the darkroom would show without noise, and what an effect changes.

use isolux_darkroom::camera::Unit;
use isolux_darkroom::{Darkroom, Observation, Room, SensorFrame};
use nalgebra::{DMatrix, DVector};

use crate::plan::{Frame, Step};

/// One hidden effect with its values: the strength's key first.
#[derive(Debug, Clone)]
pub struct Setting {
    /// Its name.
    pub name: &'static str,
    /// Keys and values.
    pub values: Vec<(&'static str, f64)>,
}

/// A darkroom of one lamp at a point, without injected effects, asymmetric by `ellipticity_rel`.
pub fn clean_room(ellipticity_rel: f64) -> Darkroom {
    let mut room = Darkroom::default();
    room.lamp.flux_spread_rel = 0.0;
    room.lamp.aim_spread_deg = 0.0;
    room.lamp.aim_deg = 0.0;
    room.lamp.ring_diameter_mm = vec![0.0];
    room.lamp.leds_per_ring = vec![1];
    room.lamp.ellipticity_rel = ellipticity_rel;
    room.luxmeter.gain_error_rel = 0.0;
    room
}

/// The room with these effects.
///
/// # Panics
/// Where the darkroom has no such injected effect: a mistake in the recipes.
pub fn with_effects(mut room: Darkroom, effects: &[Setting]) -> Darkroom {
    for effect in effects {
        for &(key, value) in &effect.values {
            match (effect.name, key) {
                ("near_field", "radius_mm") => {
                    // Two rings, so that no single radius is the truth.
                    room.lamp.ring_diameter_mm = vec![1.7 * value, 2.3 * value];
                    room.lamp.leds_per_ring = vec![24, 30];
                }
                ("near_field", "aim_deg") => room.lamp.aim_deg = value,
                ("dead_sector", _) => {}
                (name, key) => assert!(
                    room.injected_effects.set(name, key, value),
                    "the darkroom has no {name}.{key}"
                ),
            }
        }
    }
    room
}

/// Noise-free readings, lx.
pub fn readings(room: Darkroom, effects: &[Setting], steps: &[Step]) -> Vec<f64> {
    let dead: Vec<[f64; 4]> = effects
        .iter()
        .filter(|effect| effect.name == "dead_sector")
        .map(|effect| [0, 1, 2, 3].map(|k| effect.values[k].1))
        .collect();
    let room = Room::new(room);
    steps
        .iter()
        .map(|step| {
            let shade =
                |[depth, azimuth, width, aim]: &[f64; 4]| 1.0 - depth * dimmed(&step.at, *azimuth, *width, *aim);
            room.indicated_lx(&step.at) * dead.iter().map(shade).product::<f64>()
        })
        .collect()
}

/// Share of the light towards a reading that comes from the LEDs of one sector of a ring whose LEDs lean outwards by
/// `aim`.
fn dimmed(at: &Observation, azimuth_deg: f64, width_deg: f64, aim_deg: f64) -> f64 {
    const LEDS: u32 = 48;
    let direction = |c_deg: f64, gamma_deg: f64| {
        let ((sc, cc), (sg, cg)) = (c_deg.to_radians().sin_cos(), gamma_deg.to_radians().sin_cos());
        [sg * cc, sg * sc, cg]
    };
    let towards = direction(at.c_deg, at.gamma_deg);
    let (mut all, mut gone) = (0.0, 0.0);
    for led in 0..LEDS {
        let place = 360.0 * f64::from(led) / f64::from(LEDS);
        let axis = direction(place, aim_deg);
        let cosine: f64 = axis.iter().zip(&towards).map(|(a, b)| a * b).sum();
        let light = cosine.max(0.0).powf(5.3);
        let apart = ((place - azimuth_deg + 540.0).rem_euclid(360.0) - 180.0).abs();
        all += light;
        gone += if apart < 0.5 * width_deg { light } else { 0.0 };
    }
    gone / all.max(1e-12)
}

/// Noise-free maps, relative signal, map after map.
pub fn maps(room: Darkroom, frames: &[Frame], bins: usize) -> Vec<f64> {
    let room = Room::new(room);
    let frame = SensorFrame {
        size_mm: [24.576, 24.576],
        bins: [bins, bins],
    };
    frames
        .iter()
        .flat_map(|f| room.sensor_map(&frame, &f.pose, Unit::Relative))
        .collect()
}

/// Directions that any analyst must fit on readings: nine even Chebyshev terms of ln I, and cos 2C·sin²γ.
pub fn reading_nuisance(steps: &[Step], clean: &[f64]) -> DMatrix<f64> {
    DMatrix::from_fn(steps.len(), 10, |i, k| {
        let gamma = steps[i].at.gamma_deg.to_radians();
        if k < 9 {
            let x = steps[i].at.gamma_deg / 90.0;
            clean[i] * (2.0 * k as f64 * x.acos()).cos()
        } else {
            clean[i] * (2.0 * steps[i].at.c_deg.to_radians()).cos() * gamma.sin().powi(2)
        }
    })
}

/// Directions that any analyst must fit on maps: a gain, tan²γ, tan⁴γ.
pub fn map_nuisance(frames: &[Frame], bins: usize, clean: &[f64]) -> DMatrix<f64> {
    let cells = bins * bins;
    DMatrix::from_fn(clean.len(), 3, |i, k| {
        clean[i] * tan_square(&frames[i / cells], bins, i % cells).powi(k as i32)
    })
}

fn tan_square(frame: &Frame, bins: usize, cell: usize) -> f64 {
    let pitch = 24.576 / bins as f64;
    let x = ((cell % bins) as f64 + 0.5) * pitch - 12.288;
    let y = ((cell / bins) as f64 + 0.5) * pitch - 12.288;
    let pose = &frame.pose;
    let (sx, cx) = pose.tilt_x_deg.to_radians().sin_cos();
    let (sy, cy) = pose.tilt_y_deg.to_radians().sin_cos();
    let (sz, cz) = pose.rot_z_deg.to_radians().sin_cos();
    let (x1, y1) = (cz * x - sz * y, sz * x + cz * y);
    let (x2, z2) = (cy * x1, -sy * x1);
    let (y3, z3) = (cx * y1 - sx * z2, sx * y1 + cx * z2);
    let z = z3 + pose.distance_mm;
    (x2 * x2 + y3 * y3) / (z * z)
}

/// Total significance of a change in σ: its length after the analyst's directions are projected out.
pub fn significance(change: &[f64], sigma: &[f64], nuisance: &DMatrix<f64>) -> f64 {
    let mut scaled = nuisance.clone();
    for (i, s) in sigma.iter().enumerate() {
        scaled.row_mut(i).scale_mut(1.0 / s);
    }
    for mut column in scaled.column_iter_mut() {
        let norm = column.norm().max(1e-300);
        column.scale_mut(1.0 / norm);
    }
    let mut rest = DVector::from_iterator(change.len(), change.iter().zip(sigma).map(|(d, s)| d / s));
    let svd = scaled.svd(true, false);
    if let Some(u) = svd.u {
        for (k, value) in svd.singular_values.iter().enumerate() {
            if *value > 1e-9 {
                let part = u.column(k).dot(&rest);
                rest.axpy(-part, &u.column(k), 1.0);
            }
        }
    }
    rest.norm()
}
