//! Disturbances of a bench that were written down after the test of the noise was finished: known to nobody but this
//! file.

use isolux_darkroom::Kind;

use crate::plan::Step;
use crate::random::Draws;

mod fourth;
mod third;

pub use fourth::FOURTH;
pub use third::THIRD;

/// Kinds that were drawn while the test stood as it is in commit e8ad4a5.
pub const FIRST: &[&str] = &[
    "microphonics",
    "cable_pulls_beyond_c",
    "condensation_burst",
    "sticking_relay",
    "door_with_jitter",
    "spikes_of_one_sign",
    "missing_codes",
    "wandering_arc",
    "light_hysteresis",
    "lost_steps",
    "gear_error",
    "contact_bounce",
];

/// Kinds that were drawn after the first had been measured.
pub const SECOND: &[&str] = &[
    "slipping_c_axis",
    "moth_at_the_lamp",
    "lift_bursts",
    "afterglow",
    "curtain_side",
    "loud_range",
    "wire_across",
    "ringing_arm",
];

/// Whether a name is one of these kinds.
pub fn has(name: &str) -> bool {
    [FIRST, SECOND, THIRD, FOURTH].iter().any(|kinds| kinds.contains(&name))
}

/// Noise of about the size that a meter has at so much light.
fn rough(lx: f64) -> f64 {
    (0.004 * lx).hypot(0.009)
}

/// Number of the stay on one half-plane, reference or dark to which each step belongs.
fn stays(steps: &[Step]) -> Vec<usize> {
    let mut stays = vec![0; steps.len()];
    for i in 1..steps.len() {
        let (a, b) = (&steps[i - 1], &steps[i]);
        let same =
            (a.block, a.at.kind, a.at.c_deg) == (b.block, b.at.kind, b.at.c_deg) && b.at.time_s - a.at.time_s < 10.0;
        stays[i] = stays[i - 1] + usize::from(!same);
    }
    stays
}

/// Change of the light from the step before to the step after within one stay, in lx for a degree of γ.
fn slope(steps: &[Step], clean: &[f64], stays: &[usize], i: usize) -> f64 {
    let from = if i > 0 && stays[i - 1] == stays[i] { i - 1 } else { i };
    let to = if stays.get(i + 1) == Some(&stays[i]) { i + 1 } else { i };
    let degrees = steps[to].at.gamma_deg - steps[from].at.gamma_deg;
    if degrees == 0.0 {
        0.0
    } else {
        (clean[to] - clean[from]) / degrees
    }
}

/// Change of every clean reading at strength 1, in lx.
pub fn gonio(name: &str, steps: &[Step], clean: &[f64], draws: &mut Draws) -> Vec<f64> {
    let turn = std::f64::consts::TAU;
    let stays = stays(steps);
    let illuminated: Vec<bool> = steps.iter().map(|step| step.at.kind == Kind::Lit).collect();
    let on = |i: usize| f64::from(illuminated[i]);
    let rises = |i: usize| slope(steps, clean, &stays, i) * steps[i].at.travel;
    let top = clean.iter().copied().fold(0.0, f64::max);
    let (first, last) = (steps[0].at.time_s, steps[steps.len() - 1].at.time_s);
    let all = || 0..steps.len();
    match name {
        // The amplifier picks up the motor: so many degrees a period, another phase after each start.
        "microphonics" => {
            let period_deg = draws.between(13.0, 45.0);
            let phases: Vec<f64> = all().map(|_| draws.between(0.0, turn)).collect();
            let hum = |i: usize| (turn * steps[i].at.gamma_deg / period_deg + phases[stays[i]]).sin();
            all()
                .map(|i| 0.01 * on(i) * hum(i) * steps[i].at.travel.abs())
                .collect()
        }
        // Beyond some C the cable is taut and shifts the zero of the head.
        "cable_pulls_beyond_c" => {
            let edge = draws.between(35.0, 140.0);
            let taut = |i: usize| f64::from(steps[i].at.c_deg > edge);
            all().map(|i| 0.01 * taut(i)).collect()
        }
        // The window of the head fogs at once and dries.
        "condensation_burst" => {
            let from = first + draws.between(0.1, 0.8) * (last - first);
            let dries_s = draws.between(60.0, 240.0);
            let fog = |i: usize| {
                let since = steps[i].at.time_s - from;
                if since < 0.0 { 0.0 } else { (-since / dries_s).exp() }
            };
            all().map(|i| -clean[i] * fog(i)).collect()
        }
        // A relay that the light switches at one level sticks every second time.
        "sticking_relay" => {
            let level = top * draws.decades(0.05, 0.5);
            let mut times = 0_u32;
            let mut stuck = Vec::with_capacity(steps.len());
            for i in all() {
                if i > 0 && illuminated[i] && clean[i] > level && clean[i - 1] <= level {
                    times += 1;
                }
                stuck.push(times % 2 == 1);
            }
            all().map(|i| on(i) * clean[i] * f64::from(stuck[i])).collect()
        }
        // Somebody comes about as often, and shuts the door after some readings.
        "door_with_jitter" => {
            let every_s = draws.between(140.0, 400.0);
            let open_s = draws.between(10.0, 30.0);
            let mut at = first + every_s * draws.between(0.0, 1.0);
            let mut doors = Vec::new();
            while at < last {
                doors.push((at, at + open_s * draws.between(0.7, 1.4)));
                at += every_s * draws.between(0.65, 1.35);
            }
            let open = |i: usize| {
                let t = steps[i].at.time_s;
                doors.iter().any(|(from, to)| t >= *from && t < *to)
            };
            let sees = |i: usize| f64::from(steps[i].at.kind != Kind::Capped);
            all().map(|i| 0.01 * sees(i) * f64::from(open(i))).collect()
        }
        // Discharges in the mains, one in 25 readings, each as large as it happens to be.
        "spikes_of_one_sign" => all()
            .map(|i| {
                let (hit, size) = (draws.between(0.0, 1.0) < 0.04, draws.between(0.6, 1.6));
                rough(clean[i]) * f64::from(hit) * size
            })
            .collect(),
        // Of each so many codes of the converter some are missing: what falls there shows the next.
        "missing_codes" => {
            let share = draws.between(0.25, 0.5);
            let codes = draws.between(9.0, 24.0);
            let start = draws.between(0.0, 1.0);
            let missing = |i: usize| {
                let full = [0.0, 3.0, 20.0, 200.0][usize::from(steps[i].at.range).min(3)];
                let place = (clean[i] / full * codes + start).fract();
                if place < share {
                    (share - place) * full / codes
                } else {
                    0.0
                }
            };
            all().map(|i| on(i) * missing(i)).collect()
        }
        // The arc of the lamp leans to a side that wanders.
        "wandering_arc" => {
            let mut side = draws.between(0.0, turn);
            all()
                .map(|i| {
                    side += 0.35 * draws.normal();
                    let at = &steps[i].at;
                    let towards = at.gamma_deg.to_radians().sin() * (at.c_deg.to_radians() - side).cos();
                    on(i) * clean[i] * towards
                })
                .collect()
        }
        // The head shows more while the light falls than while it rises.
        "light_hysteresis" => all()
            .map(|i| {
                let rises = rises(i);
                let side = if rises == 0.0 { 0.0 } else { -rises.signum() };
                on(i) * side * clean[i] * (1.0 - clean[i] / top)
            })
            .collect(),
        // On some half-planes the motor loses steps: from there to the end of the stay γ is off.
        "lost_steps" => {
            let planes: Vec<usize> = (1..steps.len())
                .filter(|&i| {
                    illuminated[i] && stays[i] != stays[i - 1] && steps[i].at.travel != 0.0 && !steps[i].held_out
                })
                .collect();
            let mut off = vec![0.0; steps.len()];
            for _ in 0..4 {
                let start = *draws.pick(&planes);
                let from = start + draws.between(1.0, 14.0) as usize;
                for i in (from..steps.len()).take_while(|&i| stays[i] == stays[start]) {
                    off[i] = steps[i].at.travel;
                }
            }
            all().map(|i| off[i] * slope(steps, clean, &stays, i)).collect()
        }
        // The wheel of the γ axis is not round.
        "gear_error" => {
            let period_deg = draws.between(12.0, 36.0);
            let phase = draws.between(0.0, turn);
            let off = |i: usize| (turn * steps[i].at.gamma_deg / period_deg + phase).sin();
            all().map(|i| on(i) * off(i) * slope(steps, clean, &stays, i)).collect()
        }
        // The first reading after a change of the range is taken while the contacts still bounce.
        "contact_bounce" => all()
            .map(|i| {
                let changed = i > 0 && steps[i].at.range != steps[i - 1].at.range;
                let bounce = draws.normal();
                on(i) * rough(clean[i]) * f64::from(changed) * bounce
            })
            .collect(),
        _ => second(name, steps, clean, draws),
    }
}

/// The same for the kinds that were drawn second.
fn second(name: &str, steps: &[Step], clean: &[f64], draws: &mut Draws) -> Vec<f64> {
    let turn = std::f64::consts::TAU;
    let stays = stays(steps);
    let on = |i: usize| f64::from(steps[i].at.kind == Kind::Lit);
    let top = clean.iter().copied().fold(0.0, f64::max);
    let (first, last) = (steps[0].at.time_s, steps[steps.len() - 1].at.time_s);
    let all = || 0..steps.len();
    // Places of the readings of each stay, counted from its begin.
    let mut since = vec![0; steps.len()];
    for i in 1..steps.len() {
        since[i] = if stays[i] == stays[i - 1] { since[i - 1] + 1 } else { 0 };
    }
    match name {
        // The C axis stops a little beside each plane, and the lamp is not round.
        "slipping_c_axis" => {
            let beside: Vec<f64> = all().map(|_| draws.normal()).collect();
            let of = |i: usize| {
                let at = &steps[i].at;
                (2.0 * at.c_deg.to_radians()).cos() * at.gamma_deg.to_radians().sin().powi(2) * beside[stays[i]]
            };
            all().map(|i| on(i) * clean[i] * of(i)).collect()
        }
        // It comes some times, stays for a few readings, and takes as much light as it happens to.
        "moth_at_the_lamp" => {
            let mut takes = vec![0.0; steps.len()];
            for _ in 0..14 {
                let from = draws.between(0.0, steps.len() as f64) as usize;
                let stays = draws.between(2.0, 5.0) as usize;
                for i in (from..steps.len()).take(stays) {
                    takes[i] = draws.between(0.4, 1.0);
                }
            }
            all().map(|i| -on(i) * clean[i] * takes[i]).collect()
        }
        // While the lift runs the mains hum gets into the amplifier.
        "lift_bursts" => {
            let period_s = draws.between(9.0, 30.0);
            let runs: Vec<(f64, f64, f64)> = (0..9)
                .map(|_| {
                    let from = draws.between(first, last);
                    (from, from + draws.between(40.0, 110.0), draws.between(0.0, turn))
                })
                .collect();
            let hum = |i: usize| {
                let t = steps[i].at.time_s;
                let one = |(from, to, phase): &(f64, f64, f64)| {
                    f64::from(t >= *from && t < *to) * (turn * t / period_s + phase).sin()
                };
                runs.iter().map(one).sum::<f64>()
            };
            all().map(|i| 0.01 * hum(i)).collect()
        }
        // A cover glows after the brightest direction of each stay.
        "afterglow" => {
            let glows_s = draws.between(15.0, 60.0);
            let (mut glow, mut last_s) = (0.0_f64, first);
            all()
                .map(|i| {
                    let t = steps[i].at.time_s;
                    glow *= (-(t - last_s) / glows_s).exp();
                    last_s = t;
                    let before = glow;
                    glow = glow.max(if on(i) > 0.0 { clean[i] / top } else { 0.0 });
                    0.01 * on(i) * before
                })
                .collect()
        }
        // Clouds pass a window that the head sees at γ of one sign.
        "curtain_side" => {
            let (period_s, phase) = (draws.between(500.0, 1400.0), draws.between(0.0, turn));
            let side = draws.sign();
            let sees = |i: usize| f64::from(steps[i].at.gamma_deg * side > 20.0);
            let light = |i: usize| 1.0 + (turn * steps[i].at.time_s / period_s + phase).sin();
            all().map(|i| 0.01 * sees(i) * on(i) * light(i)).collect()
        }
        // One range of the meter is noisier than the others.
        "loud_range" => {
            let loud = *draws.pick(&[1, 2]);
            let noise = |i: usize| rough(clean[i]) * f64::from(steps[i].at.range == loud);
            all().map(|i| on(i) * noise(i) * draws.normal()).collect()
        }
        // A wire between lamp and head: directions near one great circle lose light.
        "wire_across" => {
            let (tilt, azimuth) = (draws.between(20.0, 70.0).to_radians(), draws.between(0.0, turn));
            let width = draws.between(3.0, 7.0).to_radians();
            let off = |i: usize| {
                let at = &steps[i].at;
                let (gamma, c) = (at.gamma_deg.to_radians(), at.c_deg.to_radians());
                tilt.cos() * gamma.cos() + tilt.sin() * gamma.sin() * (c - azimuth).cos()
            };
            let hidden = |i: usize| f64::from(off(i).abs().asin() < width);
            all().map(|i| -on(i) * clean[i] * hidden(i)).collect()
        }
        // The arm swings after each start, and the swing dies out.
        "ringing_arm" => {
            let (period, dies) = (draws.between(2.3, 6.0), draws.between(3.0, 8.0));
            let phase = draws.between(0.0, turn);
            let swing = |i: usize| {
                let k = f64::from(since[i]);
                (-k / dies).exp() * (turn * k / period + phase).sin() * steps[i].at.travel.abs()
            };
            all().map(|i| on(i) * clean[i] * swing(i)).collect()
        }
        _ => third::gonio(name, steps, clean, draws),
    }
}
