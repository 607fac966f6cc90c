//! Effects that no catalogue has: changes of the clean readings, known to nobody but this file.

use isolux_darkroom::Kind;

use crate::plan::{Frame, Step};
use crate::random::Draws;

/// Names of the effects on readings.
pub const GONIO: &[&str] = &[
    "pole_shadow",
    "door_opened",
    "mains_dip",
    "settling_lag",
    "lamp_mode_hop",
    "detector_fatigue",
    "reflex",
    "range_offset",
    "dark_drift",
    "one_plane",
    "daylight",
    "short_distance_glare",
];

/// Names of the effects on maps.
pub const SENSOR: &[&str] = &[
    "tap_mismatch",
    "bad_band",
    "amp_glow",
    "dust",
    "afterimage",
    "odd_columns",
    "shutter_slip",
    "veiling_glare",
    "quadrant_gain",
];

/// Change of every clean reading at strength 1, in lx: add `strength ·` this.
pub fn gonio(name: &str, steps: &[Step], clean: &[f64], draws: &mut Draws) -> Vec<f64> {
    let top = clean.iter().copied().fold(0.0, f64::max);
    let (first, last) = (steps[0].at.time_s, steps[steps.len() - 1].at.time_s);
    let centre = draws.between(0.15, 0.85);
    let from = first + centre * (last - first);
    let length = draws.between(0.04, 0.15) * (last - first);
    let angle = draws.between(15.0, 50.0) * draws.sign();
    let width = draws.between(4.0, 9.0);
    let plane = steps
        .iter()
        .filter(|step| step.block == "A" && !step.held_out)
        .map(|step| step.at.c_deg)
        .collect::<Vec<_>>();
    let plane = *draws.pick(&plane);
    let period = draws.between(0.25, 0.8) * (last - first);
    let fatigue_s = draws.between(60.0, 300.0);
    let range = *draws.pick(&[1, 2]);
    let mut memory = 0.0;
    let mut result = Vec::with_capacity(steps.len());
    for (i, (step, &lx)) in steps.iter().zip(clean).enumerate() {
        let at = &step.at;
        let inside = f64::from(at.time_s >= from && at.time_s < from + length);
        let sees_room = f64::from(at.kind != Kind::Capped);
        let spot = (-((at.gamma_deg - angle) / width).powi(2)).exp() * f64::from(at.kind == Kind::Lit);
        let gap = if i == 0 {
            0.0
        } else {
            at.time_s - steps[i - 1].at.time_s
        };
        let previous = if i == 0 { lx } else { clean[i - 1] };
        memory = if i == 0 {
            0.0
        } else {
            memory * (-gap / fatigue_s).exp() + (1.0 - (-gap / fatigue_s).exp()) * previous
        };
        result.push(match name {
            "pole_shadow" => -lx * spot,
            "door_opened" => 0.01 * top * inside * sees_room,
            "mains_dip" => -lx * inside,
            "settling_lag" => (previous - lx) * (-gap / 4.0).exp() * 2.7,
            "lamp_mode_hop" => lx * f64::from(at.time_s >= from),
            "detector_fatigue" => -lx * memory / top,
            "reflex" => 0.01 * top * spot,
            "range_offset" => 0.01 * top * f64::from(at.range == range),
            "dark_drift" => 0.01 * top * (at.time_s - first) / (last - first),
            "one_plane" => lx * f64::from(at.c_deg == plane && step.block == "A"),
            "daylight" => {
                let turn = std::f64::consts::TAU * (at.time_s - first) / period;
                0.01 * top * (turn + centre * 6.0).sin() * sees_room
            }
            "short_distance_glare" => lx * f64::from(at.distance_mm < 1200.0) * (at.gamma_deg / 70.0).powi(2),
            _ => 0.0,
        });
    }
    result
}

/// Change of every clean map at strength 1, map after map, `[iy][ix]`.
pub fn sensor(name: &str, frames: &[Frame], bins: usize, clean: &[f64], draws: &mut Draws) -> Vec<f64> {
    let middle = 0.5 * bins as f64;
    let edge = (draws.between(0.3, 0.7) * bins as f64).round();
    let (px, py) = (
        draws.between(0.2, 0.8) * bins as f64,
        draws.between(0.2, 0.8) * bins as f64,
    );
    let width = draws.between(1.5, 4.0);
    let vertical = draws.sign() > 0.0;
    let illuminated: Vec<usize> = (0..frames.len())
        .filter(|&m| frames[m].pose.lamp && !frames[m].pose.capped && !frames[m].held_out)
        .collect();
    let slipped = *draws.pick(&illuminated);
    let cells = bins * bins;
    let mean = |m: usize| clean[m * cells..(m + 1) * cells].iter().sum::<f64>() / cells as f64;
    let mut result = Vec::with_capacity(clean.len());
    for m in 0..frames.len() {
        for cell in 0..cells {
            let (ix, iy) = ((cell % bins) as f64 + 0.5, (cell / bins) as f64 + 0.5);
            let signal = clean[m * cells + cell];
            let along = if vertical { ix } else { iy };
            result.push(match name {
                "tap_mismatch" => signal * if along > middle { 0.5 } else { -0.5 },
                "bad_band" => signal * f64::from((along - edge).abs() < 1.0),
                "amp_glow" => 0.01 * (-(ix.hypot(iy)) / 5.0).exp() * frames[m].pose.exposure.max(0.2),
                "dust" => -signal * (-((ix - px).powi(2) + (iy - py).powi(2)) / (width * width)).exp(),
                "afterimage" => 0.01 * if m == 0 { 0.0 } else { clean[(m - 1) * cells + cell] },
                "odd_columns" => signal * if (cell % bins).is_multiple_of(2) { 0.5 } else { -0.5 },
                "shutter_slip" => signal * f64::from(m == slipped),
                "veiling_glare" => 0.01 * mean(m),
                "quadrant_gain" => signal * f64::from(ix > middle && iy > middle),
                _ => 0.0,
            });
        }
    }
    result
}
