//! Errors that look like noise until one looks at their time, number or place: known to nobody but this file.

use isolux_darkroom::Kind;

use crate::plan::Step;
use crate::random::Draws;

/// Kinds with which the test of the noise was developed.
pub const DEVELOPED: &[&str] = &["added_beat", "numbered_wave", "bright_patch", "loud_block"];

/// Kinds that were drawn after the first test was finished; what was missed of them led to its present form.
pub const FRESH: &[&str] = &[
    "mains_on_amplifier",
    "every_nth_off",
    "dark_patch",
    "bright_bump",
    "loud_stretch",
    "noise_with_angle",
    "telegraph",
    "ramp_in_half_plane",
    "random_walk",
    "two_numbers",
    "dropouts_together",
    "square_wave",
];

/// Kinds that were drawn after the present form was finished.
pub const LATER: &[&str] = &[
    "saw_tooth",
    "every_third_visit",
    "start_of_visit",
    "bright_ring",
    "gain_of_each_visit",
    "sticky_readings",
    "chirp",
    "spokes",
];

/// Whether a name is one of these kinds.
pub fn has(name: &str) -> bool {
    [DEVELOPED, FRESH, LATER].iter().any(|kinds| kinds.contains(&name))
}

/// Noise of about the size that a meter has at so much light.
fn rough(lx: f64) -> f64 {
    (0.004 * lx).hypot(0.009)
}

/// Angle between two directions, in degrees; γ < 0 lies opposite.
fn apart(a: (f64, f64), b: (f64, f64)) -> f64 {
    let direction = |(c_deg, gamma_deg): (f64, f64)| {
        let ((sc, cc), (sg, cg)) = (c_deg.to_radians().sin_cos(), gamma_deg.to_radians().sin_cos());
        [sg * cc, sg * sc, cg]
    };
    let (a, b) = (direction(a), direction(b));
    let cosine: f64 = a.iter().zip(&b).map(|(a, b)| a * b).sum();
    cosine.clamp(-1.0, 1.0).acos().to_degrees()
}

/// Change of every clean reading at strength 1, in lx.
pub fn gonio(name: &str, steps: &[Step], clean: &[f64], draws: &mut Draws) -> Vec<f64> {
    let phase = draws.between(0.0, std::f64::consts::TAU);
    let period_s = draws.between(11.0, 90.0);
    let readings = draws.between(2.3, 17.0);
    let illuminated: Vec<usize> = (0..steps.len())
        .filter(|&i| steps[i].at.kind == Kind::Lit && !steps[i].held_out && steps[i].at.gamma_deg.abs() > 12.0)
        .collect();
    let spot = &steps[*draws.pick(&illuminated)].at;
    let spot = (spot.c_deg, spot.gamma_deg);
    let width = draws.between(5.0, 10.0);
    let from = illuminated[(draws.between(0.0, 0.85) * illuminated.len() as f64) as usize];
    let length = draws.between(25.0, 60.0) as usize;
    let each: Vec<f64> = steps.iter().map(|_| draws.normal()).collect();
    let nth = 3 + (draws.between(0.0, 11.0) as usize);
    let remainder = (draws.between(0.0, 1.0) * nth as f64) as usize;
    let direction = |i: usize| (steps[i].at.c_deg, steps[i].at.gamma_deg);
    // A patch of a few readings: at least six that the operator sees.
    let mut wide = width;
    while illuminated
        .iter()
        .filter(|&&i| apart(direction(i), spot) < wide)
        .count()
        < 6
    {
        wide *= 1.15;
    }
    let dwell = draws.between(8.0, 25.0);
    let mut telegraph = Vec::with_capacity(steps.len());
    let mut walk = Vec::with_capacity(steps.len());
    let (mut state, mut place) = (draws.sign(), 0.0);
    for _ in steps {
        if draws.between(0.0, 1.0) < 1.0 / dwell {
            state = -state;
        }
        place += draws.normal();
        telegraph.push(state);
        walk.push(place);
    }
    let mut since = vec![0.0; steps.len()];
    for i in 1..steps.len() {
        let same = steps[i].at.time_s - steps[i - 1].at.time_s < 6.0 && steps[i].block == steps[i - 1].block;
        since[i] = if same { since[i - 1] + 1.0 } else { 0.0 };
    }
    let mut visit = vec![0_usize; steps.len()];
    for i in 1..steps.len() {
        visit[i] = visit[i - 1] + usize::from(since[i] == 0.0);
    }
    let span_s = steps[steps.len() - 1].at.time_s - steps[0].at.time_s;
    let change = |(i, (step, &lx)): (usize, (&Step, &f64))| {
        let at = &step.at;
        let on = f64::from(at.kind == Kind::Lit);
        match name {
            "added_beat" => 0.01 * (std::f64::consts::TAU * at.time_s / period_s + phase).sin(),
            "numbered_wave" => 0.01 * lx * (std::f64::consts::TAU * i as f64 / readings + phase).sin(),
            "bright_patch" => on * 0.01 * lx * f64::from(apart((at.c_deg, at.gamma_deg), spot) < width),
            "loud_block" => rough(lx) * each[i] * f64::from(i >= from && i < from + length),
            // Pick-up of the mains, rectified: every reading, dark or not, more on one half of the beat.
            "mains_on_amplifier" => {
                0.01 * (std::f64::consts::TAU * at.time_s / (0.7 * period_s) + phase)
                    .sin()
                    .max(0.0)
            }
            "every_nth_off" => lx * f64::from(i % nth == remainder),
            "dark_patch" => {
                let off = apart(direction(i), spot) / wide;
                -on * lx * (1.0 - off * off).max(0.0)
            }
            "bright_bump" => on * lx * (-0.5 * (1.8 * apart(direction(i), spot) / wide).powi(2)).exp(),
            "loud_stretch" => {
                let [start, end] = [from, (from + 2 * length).min(steps.len() - 1)].map(|k| steps[k].at.time_s);
                rough(lx) * each[i] * f64::from(at.time_s >= start && at.time_s < end)
            }
            "noise_with_angle" => on * rough(lx) * each[i] * (at.gamma_deg / 70.0).powi(2),
            "telegraph" => lx * telegraph[i],
            "ramp_in_half_plane" => on * lx * since[i],
            "random_walk" => lx * walk[i],
            // Two periods that do not fit each other, in the number.
            "two_numbers" => {
                let turn = std::f64::consts::TAU * i as f64;
                lx * ((turn / readings + phase).sin() + (turn / (1.37 * readings + 1.0)).sin())
            }
            // A loose plug: some of the readings of one stretch, at random, all low.
            "dropouts_together" => {
                let inside = i >= from && i < from + length;
                -lx * f64::from(inside && each[i] > 0.3)
            }
            // An added error that rises and falls back at once.
            "saw_tooth" => 0.01 * ((at.time_s / (2.0 * period_s)).fract() - 0.5),
            "every_third_visit" => on * lx * f64::from(visit[i] % 3 == remainder % 3),
            // The first readings after a motion of C are off.
            "start_of_visit" => -on * lx * (1.0 - since[i] / 3.0).max(0.0),
            "bright_ring" => {
                let off = (apart(direction(i), spot) - 2.0 * wide) / (0.5 * wide);
                on * lx * (-0.5 * off * off).exp()
            }
            "gain_of_each_visit" => on * lx * each[visit[i] % each.len()],
            // Some readings keep a part of the one before.
            "sticky_readings" => f64::from(each[i] > 1.0) * (clean[i.max(1) - 1] - lx),
            "chirp" => {
                let share = (at.time_s - steps[0].at.time_s) / span_s;
                lx * (share * share * std::f64::consts::PI * span_s / period_s + phase).sin()
            }
            // Spokes of the luminaire's cover.
            "spokes" => {
                let azimuth = at.c_deg + if at.gamma_deg < 0.0 { 180.0 } else { 0.0 };
                let turn = (8.0 * azimuth).to_radians() + phase;
                on * lx * turn.sin() * f64::from(at.gamma_deg.abs() > 25.0)
            }
            "square_wave" => {
                0.01 * (std::f64::consts::TAU * at.time_s / (1.5 * period_s) + phase)
                    .sin()
                    .signum()
            }
            _ => 0.0,
        }
    };
    steps.iter().zip(clean).enumerate().map(change).collect()
}
