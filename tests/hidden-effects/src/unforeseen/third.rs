//! Kinds that were drawn after the first two lists had been measured.

use isolux_darkroom::Kind;

use super::{fourth, rough, slope, stays};
use crate::plan::Step;
use crate::random::Draws;

/// Their names.
pub const THIRD: &[&str] = &[
    "heater_cycles",
    "dust_falls",
    "belt_joint",
    "flickering_led",
    "range_memory",
    "microstep_error",
    "sunbeam_through_slit",
    "polled_by_another",
    "gusts",
    "bearing_wobble",
    "loose_baffle",
    "leaking_capacitor",
];

/// Change of every clean reading at strength 1, in lx.
pub(super) fn gonio(name: &str, steps: &[Step], clean: &[f64], draws: &mut Draws) -> Vec<f64> {
    let turn = std::f64::consts::TAU;
    let stays = stays(steps);
    let on = |i: usize| f64::from(steps[i].at.kind == Kind::Lit);
    let (first, last) = (steps[0].at.time_s, steps[steps.len() - 1].at.time_s);
    let all = || 0..steps.len();
    // Seconds since the begin of each stay.
    let mut since = vec![0.0; steps.len()];
    for i in 1..steps.len() {
        let step_s = steps[i].at.time_s - steps[i - 1].at.time_s;
        since[i] = if stays[i] == stays[i - 1] {
            since[i - 1] + step_s
        } else {
            0.0
        };
    }
    match name {
        // A thermostat heats the head by turns; its gain follows.
        "heater_cycles" => {
            let (period_s, duty) = (draws.between(200.0, 700.0), draws.between(0.25, 0.6));
            let (lag_s, begin) = (draws.between(20.0, 90.0), draws.between(0.0, 1.0));
            let (mut warm, mut before_s) = (duty, first);
            all()
                .map(|i| {
                    let t = steps[i].at.time_s;
                    let heats = f64::from(((t - first) / period_s + begin).fract() < duty);
                    warm = heats + (warm - heats) * (-(t - before_s) / lag_s).exp();
                    before_s = t;
                    on(i) * clean[i] * (warm - duty)
                })
                .collect()
        }
        // Now and then something falls on the head and stays there.
        "dust_falls" => {
            let falls: Vec<(f64, f64)> = (0..6)
                .map(|_| (draws.between(first, last), draws.between(0.2, 1.0)))
                .collect();
            let lies = |t: f64| {
                falls
                    .iter()
                    .filter(|(at, _)| t >= *at)
                    .map(|(_, size)| size)
                    .sum::<f64>()
            };
            all().map(|i| -on(i) * clean[i] * lies(steps[i].at.time_s)).collect()
        }
        // The joint of the belt passes its wheel at one γ, pulled one way or the other.
        "belt_joint" => {
            let (at_deg, width_deg) = (draws.between(15.0, 55.0) * draws.sign(), draws.between(3.0, 8.0));
            let hop = |i: usize| {
                let off = (steps[i].at.gamma_deg - at_deg) / width_deg;
                steps[i].at.travel * (-0.5 * off * off).exp()
            };
            all().map(|i| on(i) * hop(i) * slope(steps, clean, &stays, i)).collect()
        }
        // One LED of many has a loose contact; it shines to one side.
        "flickering_led" => {
            let (azimuth, tilt) = (draws.between(0.0, turn), draws.between(20.0, 50.0).to_radians());
            let dwell = draws.between(4.0, 20.0);
            let mut off = false;
            all()
                .map(|i| {
                    off ^= draws.between(0.0, 1.0) < 1.0 / dwell;
                    let at = &steps[i].at;
                    let (gamma, c) = (at.gamma_deg.to_radians(), at.c_deg.to_radians());
                    let towards = tilt.cos() * gamma.cos() + tilt.sin() * gamma.sin() * (c - azimuth).cos();
                    -on(i) * clean[i] * f64::from(off) * towards.max(0.0).powi(6)
                })
                .collect()
        }
        // After a change of range the amplifier keeps some of the other one's charge.
        "range_memory" => {
            let fades = draws.between(1.5, 4.0);
            let mut kept = 0.0_f64;
            all()
                .map(|i| {
                    kept *= (-1.0 / fades).exp();
                    if i > 0 && steps[i].at.range != steps[i - 1].at.range {
                        kept = f64::from(steps[i - 1].at.range) - f64::from(steps[i].at.range);
                    }
                    on(i) * clean[i] * kept
                })
                .collect()
        }
        // The motor stops between its full steps a little beside.
        "microstep_error" => {
            let (pitch_deg, start) = (draws.between(1.1, 7.3), draws.between(0.0, 1.0));
            let off = |i: usize| (steps[i].at.gamma_deg / pitch_deg + start).rem_euclid(1.0) - 0.5;
            all().map(|i| on(i) * off(i) * slope(steps, clean, &stays, i)).collect()
        }
        // For a while the sun shines through a slit, onto the arm on one side.
        "sunbeam_through_slit" => {
            let from = draws.between(first, last - 0.4 * (last - first));
            let length_s = draws.between(0.15, 0.4) * (last - first);
            let (centre, width) = (draws.between(-50.0, 50.0), draws.between(8.0, 20.0));
            let beam = |i: usize| {
                let at = &steps[i].at;
                let inside = f64::from(at.time_s >= from && at.time_s < from + length_s);
                let off = (at.gamma_deg - centre) / width;
                inside * (1.0 - off * off).max(0.0)
            };
            let sees = |i: usize| f64::from(steps[i].at.kind != Kind::Capped);
            all().map(|i| 0.01 * sees(i) * beam(i)).collect()
        }
        // Another computer asks the meter every so often; what is read then is the mean with the reading before.
        "polled_by_another" => {
            let (period_s, begin) = (draws.between(17.0, 41.0), draws.between(0.0, 1.0));
            let polled = |i: usize| {
                let turns = (steps[i].at.time_s - first) / period_s + begin;
                turns.fract() * period_s < 4.0
            };
            let before = |i: usize| clean[i.max(1) - 1];
            all()
                .map(|i| on(i) * f64::from(polled(i)) * (before(i) - clean[i]))
                .collect()
        }
        // Gusts shake the lamp: for some readings at a time all scatter more.
        "gusts" => {
            let mut shaken = vec![0.0; steps.len()];
            for _ in 0..9 {
                let from = draws.between(0.0, steps.len() as f64) as usize;
                let length = draws.between(4.0, 10.0) as usize;
                for shaken in shaken.iter_mut().skip(from).take(length) {
                    *shaken = draws.normal();
                }
            }
            all().map(|i| on(i) * rough(clean[i]) * shaken[i]).collect()
        }
        // The bearing of C is not round: γ is off by the plane, twice a turn and thrice.
        "bearing_wobble" => {
            let phases = [draws.between(0.0, turn), draws.between(0.0, turn)];
            let off = |i: usize| {
                let c = steps[i].at.c_deg.to_radians();
                (4.0 * c + phases[0]).sin() + 0.7 * (6.0 * c + phases[1]).sin()
            };
            all().map(|i| on(i) * off(i) * slope(steps, clean, &stays, i)).collect()
        }
        // A baffle hangs loose: on some half-planes it lets light past, on one side.
        "loose_baffle" => {
            let lets: Vec<f64> = all().map(|_| f64::from(draws.between(0.0, 1.0) < 0.4)).collect();
            let side = draws.sign();
            let past = |i: usize| (side * steps[i].at.gamma_deg.to_radians()).sin().max(0.0);
            all().map(|i| 0.01 * on(i) * lets[stays[i]] * past(i)).collect()
        }
        // The zero creeps back after each start of a stay, fast at first and then ever slower.
        "leaking_capacitor" => {
            let after_s = draws.between(3.0, 12.0);
            all().map(|i| 0.01 * (1.0 + since[i] / after_s).recip()).collect()
        }
        _ => fourth::gonio(name, steps, clean, draws),
    }
}
