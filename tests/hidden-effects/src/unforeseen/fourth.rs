//! Kinds that were drawn while the test of the noise stood as it is in the commit before this file's first.

use isolux_darkroom::Kind;

use super::{rough, slope, stays};
use crate::plan::Step;
use crate::random::Draws;

/// Their names.
pub const FOURTH: &[&str] = &[
    "scratch_on_the_mirror",
    "film_on_the_cover",
    "zero_taken_again",
    "supply_falls_back",
    "damp_head",
    "people_walk_by",
    "stuck_bit",
    "swaying_arm",
    "worm_off_centre",
    "tape_on_the_arm",
    "status_lamp_blinks",
    "held_values",
];

/// Change of every clean reading at strength 1, in lx.
pub(super) fn gonio(name: &str, steps: &[Step], clean: &[f64], draws: &mut Draws) -> Vec<f64> {
    let turn = std::f64::consts::TAU;
    let stays = stays(steps);
    let on = |i: usize| f64::from(steps[i].at.kind == Kind::Lit);
    let (first, last) = (steps[0].at.time_s, steps[steps.len() - 1].at.time_s);
    let all = || 0..steps.len();
    match name {
        // It throws light into the directions about one.
        "scratch_on_the_mirror" => {
            let (tilt, azimuth) = (draws.between(15.0, 60.0).to_radians(), draws.between(0.0, turn));
            let width = draws.between(4.0, 9.0).to_radians();
            let near = |i: usize| {
                let at = &steps[i].at;
                let (gamma, c) = (at.gamma_deg.to_radians(), at.c_deg.to_radians());
                let towards = tilt.cos() * gamma.cos() + tilt.sin() * gamma.sin() * (c - azimuth).cos();
                (-0.5 * (towards.clamp(-1.0, 1.0).acos() / width).powi(2)).exp()
            };
            all().map(|i| on(i) * clean[i] * near(i)).collect()
        }
        // Interference in a thin film: rings over the angle of incidence.
        "film_on_the_cover" => {
            let (order, phase) = (draws.between(12.0, 40.0), draws.between(0.0, turn));
            let rings = |i: usize| (turn * order * steps[i].at.gamma_deg.to_radians().cos() + phase).sin();
            all().map(|i| on(i) * clean[i] * rings(i)).collect()
        }
        // The meter takes its zero again every so often, each a little wrong.
        "zero_taken_again" => {
            let period_s = draws.between(60.0, 150.0);
            let zeros: Vec<f64> = (0..=((last - first) / period_s) as usize)
                .map(|_| draws.normal())
                .collect();
            all()
                .map(|i| 0.01 * zeros[((steps[i].at.time_s - first) / period_s) as usize])
                .collect()
        }
        // The supply falls back to another current for some minutes.
        "supply_falls_back" => {
            let mut lower = vec![0.0; steps.len()];
            for _ in 0..4 {
                let from = draws.between(0.0, steps.len() as f64) as usize;
                let length = draws.between(15.0, 45.0) as usize;
                for lower in lower.iter_mut().skip(from).take(length) {
                    *lower = 1.0;
                }
            }
            all().map(|i| -on(i) * clean[i] * lower[i]).collect()
        }
        // Noise that grows through the day.
        "damp_head" => {
            let grows = |i: usize| ((steps[i].at.time_s - first) / (last - first)).powi(3);
            all().map(|i| rough(clean[i]) * grows(i) * draws.normal()).collect()
        }
        // Some of the light on the wall is theirs for a moment.
        "people_walk_by" => {
            let mut theirs = vec![0.0; steps.len()];
            for _ in 0..10 {
                let from = draws.between(0.0, steps.len() as f64) as usize;
                let length = draws.between(3.0, 7.0) as usize;
                for (k, theirs) in theirs.iter_mut().skip(from).take(length).enumerate() {
                    *theirs = ((k as f64 + 0.5) / length as f64 * 0.5 * turn).sin().powi(2);
                }
            }
            all().map(|i| -0.01 * on(i) * theirs[i]).collect()
        }
        // One bit of the converter is always set.
        "stuck_bit" => {
            let bits = draws.between(4.0, 8.0).floor();
            let start = draws.between(0.0, 1.0);
            let bit = |i: usize| {
                let full = [0.0, 3.0, 20.0, 200.0][usize::from(steps[i].at.range).min(3)];
                let weight = full / 2.0_f64.powf(bits);
                let set = weight > 0.0 && (clean[i] / weight + start).floor().rem_euclid(2.0) > 0.5;
                if set { 0.0 } else { weight }
            };
            all().map(|i| on(i) * bit(i)).collect()
        }
        // The arm sways slowly, whatever it is asked for.
        "swaying_arm" => {
            let (period_s, phase) = (draws.between(40.0, 160.0), draws.between(0.0, turn));
            let sways = |i: usize| (turn * steps[i].at.time_s / period_s + phase).sin();
            all()
                .map(|i| on(i) * sways(i) * slope(steps, clean, &stays, i))
                .collect()
        }
        // The worm of the γ axis runs off its centre.
        "worm_off_centre" => {
            let (pitch_deg, phase) = (draws.between(12.0, 35.0), draws.between(0.0, turn));
            let off = |i: usize| (turn * steps[i].at.gamma_deg / pitch_deg + phase).sin();
            all().map(|i| on(i) * off(i) * slope(steps, clean, &stays, i)).collect()
        }
        // A loose end of tape shows at some angles when the arm turns one way.
        "tape_on_the_arm" => {
            let (from_deg, way) = (draws.between(-50.0, 40.0), draws.sign());
            let to_deg = from_deg + draws.between(10.0, 20.0);
            let shows = |i: usize| {
                let at = &steps[i].at;
                f64::from(at.travel * way > 0.0 && at.gamma_deg >= from_deg && at.gamma_deg < to_deg)
            };
            all().map(|i| -on(i) * clean[i] * shows(i)).collect()
        }
        // A device on the arm blinks; every so many readings fall into it.
        "status_lamp_blinks" => {
            let (every, start) = (
                draws.between(3.0, 9.0).floor() as usize,
                draws.between(0.0, 9.0) as usize,
            );
            all()
                .map(|i| 0.01 * on(i) * f64::from(u8::from((i + start) % every == 0)))
                .collect()
        }
        // Now and then the meter shows the value before once more.
        "held_values" => {
            let held: Vec<f64> = all()
                .map(|_| f64::from(u8::from(draws.between(0.0, 1.0) < 0.06)))
                .collect();
            let before = |i: usize| clean[i.max(1) - 1];
            all().map(|i| on(i) * held[i] * (before(i) - clean[i])).collect()
        }
        _ => vec![0.0; steps.len()],
    }
}
