//! One case: what the operator has, and what is hidden in it.

use std::fmt::Write as _;
use std::path::Path;

use isolux_darkroom::{Darkroom, Kind, Room};

use crate::outside;
use crate::plan::{self, Frame, Plan, Step};
use crate::random::Draws;
use crate::recipe::{self, Recipe};
use crate::truth::{self, Setting};

/// What is wanted of a case.
#[derive(Debug, Clone)]
pub struct Order {
    /// Maps instead of readings.
    pub sensor: bool,
    /// The plan.
    pub plan: Plan,
    /// Names and total significances in σ; nothing: a clean case.
    pub hidden: Vec<(&'static str, f64)>,
    /// Serial correlation of the noise.
    pub rho: f64,
    /// Share of readings whose noise is five times as wide.
    pub outliers: f64,
    /// Seed of everything.
    pub seed: u64,
}

/// A finished case.
#[derive(Debug)]
pub struct Case {
    /// What was ordered.
    pub order: Order,
    /// Files for the operator: name and content.
    pub files: Vec<(&'static str, String)>,
    /// Held-out coordinates: file name and content.
    pub held_out: (&'static str, String),
    /// Noise-free truth of the held-out rows and their true standard deviation.
    pub truth: Vec<(f64, f64)>,
    /// Strength of each hidden effect over its plausible maximum (0 outside the catalogue).
    pub strength: Vec<f64>,
}

/// Makes a case; none where an effect cannot reach the ordered significance within four times its plausible range.
pub fn make(order: &Order) -> Option<Case> {
    if order.sensor { sensor(order) } else { gonio(order) }
}

impl Case {
    /// Writes the operator's files into a folder.
    ///
    /// # Errors
    /// What the operating system says.
    pub fn write(&self, folder: &Path) -> std::io::Result<()> {
        std::fs::create_dir_all(folder)?;
        for (name, content) in self.files.iter().chain([&self.held_out]) {
            std::fs::write(folder.join(name), content)?;
        }
        Ok(())
    }
}

const MODEL: &str = r#"format = "isolux-model/1"

[luminaire]
distribution = "distribution.csv"
flux_lm = 337.0
emitter = { shape = "disc", diameter_mm = 1.0 }

[luminaire.trust]
shape = "smooth"
c_harmonics = [2]

[noise]
u_scale = "fit"
"#;

/// A strength of `recipe` that reaches `wanted` σ, by secant steps.
fn strength_for(wanted: f64, recipe: &Recipe, sign: f64, significance: impl Fn(f64) -> f64) -> Option<f64> {
    let mut strength = 0.2 * recipe.plausible;
    let power = if recipe.name == "near_field" { 0.5 } else { 1.0 };
    for _ in 0..12 {
        let reached = significance(sign * strength);
        if reached.is_nan() || reached <= 1e-6 {
            return None;
        }
        let factor = (wanted / reached).powf(power).clamp(0.1, 10.0);
        strength *= factor;
        if strength > 4.0 * recipe.plausible {
            return None;
        }
        if (factor - 1.0).abs() < 0.01 {
            return Some(sign * strength);
        }
    }
    None
}

/// The effects of an order: settings of the room, a change from outside the catalogue, strengths.
struct Hidden {
    settings: Vec<Setting>,
    added: Vec<f64>,
    strengths: Vec<f64>,
}

fn hide(
    order: &Order,
    list: &'static [Recipe],
    draws: &mut Draws,
    rows: usize,
    significance: impl Fn(&[f64]) -> f64,
    change_by: impl Fn(&Setting) -> Vec<f64>,
    outside: impl Fn(&str, &mut Draws) -> Vec<f64>,
) -> Option<Hidden> {
    let mut hidden = Hidden {
        settings: Vec::new(),
        added: vec![0.0; rows],
        strengths: Vec::new(),
    };
    for &(name, wanted) in &order.hidden {
        if let Some(recipe) = recipe::find(list, name) {
            let (sign, extra) = recipe.draw(draws);
            let setting = |strength: f64| {
                let mut values = vec![(recipe.key, strength)];
                values.extend(extra.iter().copied());
                Setting {
                    name: recipe.name,
                    values,
                }
            };
            let strength = strength_for(wanted, recipe, sign, |s| significance(&change_by(&setting(s))))?;
            hidden.strengths.push((strength / recipe.plausible).abs());
            hidden.settings.push(setting(strength));
        } else {
            let change = outside(name, draws);
            let unit = significance(&change);
            if unit.is_nan() || unit <= 1e-6 {
                return None;
            }
            let one_way = matches!(name, "pole_shadow" | "door_opened" | "dust" | "reflex" | "settling_lag");
            let sign = if one_way { 1.0 } else { draws.sign() };
            hidden
                .added
                .iter_mut()
                .zip(&change)
                .for_each(|(sum, c)| *sum += sign * wanted / unit * c);
            hidden.strengths.push(0.0);
        }
    }
    Some(hidden)
}

fn gonio(order: &Order) -> Option<Case> {
    let mut draws = Draws::new(order.seed, 1);
    let mut steps = plan::gonio(order.plan, &mut draws);
    let room = truth::clean_room(draws.between(0.01, 0.03));
    climate(&mut steps, &mut draws);
    // The meter changes its range by the light that is there.
    let plain = truth::readings(room.clone(), &[], &steps);
    for (step, lx) in steps.iter_mut().zip(&plain) {
        step.at.range = if *lx < 3.0 {
            1
        } else if *lx < 20.0 {
            2
        } else {
            3
        };
    }
    let (rel, floor) = (draws.between(0.002, 0.006), draws.between(0.004, 0.014));
    let sigma: Vec<f64> = plain.iter().map(|lx| (rel * lx).hypot(floor)).collect();
    // Only what the operator sees makes the significance.
    let seen: Vec<usize> = (0..steps.len()).filter(|&i| !steps[i].held_out).collect();
    let part = |values: &[f64]| seen.iter().map(|&i| values[i]).collect::<Vec<_>>();
    let sigma_seen = part(&sigma);
    let nuisance = truth::reading_nuisance(&steps, &plain).select_rows(&seen);
    let hidden = hide(
        order,
        recipe::GONIO,
        &mut draws,
        steps.len(),
        |change| truth::significance(&part(change), &sigma_seen, &nuisance),
        |setting| {
            let setting = std::slice::from_ref(setting);
            let changed = truth::readings(truth::with_effects(room.clone(), setting), setting, &steps);
            changed.iter().zip(&plain).map(|(a, b)| a - b).collect()
        },
        |name, draws| outside::gonio(name, &steps, &plain, draws),
    )?;
    let mut clean = truth::readings(
        truth::with_effects(room.clone(), &hidden.settings),
        &hidden.settings,
        &steps,
    );
    clean.iter_mut().zip(&hidden.added).for_each(|(lx, more)| *lx += more);

    let ratio = draws.between(0.85, 1.2);
    let noise = noise(steps.len(), order, &mut draws);
    let header = "index,block,kind,time_s,c_deg,gamma_deg,distance_mm,travel,range,ambient_c";
    let (mut seen_csv, mut held_csv) = (format!("{header},illuminance_lx,u_lx\n"), format!("{header}\n"));
    let mut held_truth = Vec::new();
    for (i, step) in steps.iter().enumerate() {
        let at = &step.at;
        let kind = match at.kind {
            Kind::Lit => "lit",
            Kind::Baffled => "baffled",
            Kind::LampOff => "lamp_off",
            Kind::Capped => "capped",
        };
        let ambient = at.ambient_c + 0.02 * draws.normal();
        let place = format!(
            "{i},{},{kind},{:.1},{:.1},{:.1},{:.1},{},{},{ambient:.2}",
            step.block, at.time_s, at.c_deg, at.gamma_deg, at.distance_mm, at.travel, at.range
        );
        if step.held_out {
            let _ = writeln!(held_csv, "{place}");
            held_truth.push((clean[i], sigma[i]));
        } else {
            let _ = writeln!(
                seen_csv,
                "{place},{:.6},{:.6}",
                clean[i] + sigma[i] * noise[i],
                ratio * sigma[i]
            );
        }
    }
    Some(Case {
        order: order.clone(),
        files: vec![
            ("model.toml", MODEL.to_owned()),
            ("distribution.csv", believed(&room, &mut draws)),
            ("readings.csv", seen_csv),
        ],
        held_out: ("held-out.csv", held_csv),
        truth: held_truth,
        strength: hidden.strengths,
    })
}

/// The operator's distribution: rotational, with a smooth error of its shape.
fn believed(room: &Darkroom, draws: &mut Draws) -> String {
    let room = Room::new(room.clone());
    let error: Vec<f64> = (0..7)
        .map(|k| 0.01 / (1.0 + 0.5 * f64::from(k)) * draws.normal())
        .collect();
    let mut csv = String::from("gamma_deg,intensity_cd\n");
    for gamma in 0..=90 {
        let gamma = f64::from(gamma);
        let x: f64 = gamma / 90.0;
        let ln: f64 = error
            .iter()
            .enumerate()
            .map(|(k, a)| a * (2.0 * k as f64 * x.acos()).cos())
            .sum();
        let mean = (0..36)
            .map(|k| room.intensity_cd(10.0 * f64::from(k), gamma))
            .sum::<f64>()
            / 36.0;
        let _ = writeln!(csv, "{gamma},{:.4}", mean * ln.exp());
    }
    csv
}

fn climate(steps: &mut [Step], draws: &mut Draws) {
    let (mean, swing) = (draws.between(24.2, 25.4), draws.between(0.3, 0.7));
    let (period, phase, slope) = (
        draws.between(1800.0, 3600.0),
        draws.between(0.0, std::f64::consts::TAU),
        draws.between(-0.4, 0.4),
    );
    for step in steps {
        let t = step.at.time_s;
        step.at.ambient_c = mean + swing * (std::f64::consts::TAU * t / period + phase).sin() + slope * t / 3600.0;
    }
}

/// Unit noise: AR(1), with a share of wide ones.
fn noise(n: usize, order: &Order, draws: &mut Draws) -> Vec<f64> {
    let mut last = draws.normal();
    (0..n)
        .map(|_| {
            let value = last;
            last = order.rho * last + (1.0 - order.rho * order.rho).sqrt() * draws.normal();
            let wide = draws.between(0.0, 1.0) < order.outliers;
            if wide { 5.0 * value } else { value }
        })
        .collect()
}

const BINS: usize = 24;

fn sensor(order: &Order) -> Option<Case> {
    let mut draws = Draws::new(order.seed, 2);
    let frames = plan::sensor(order.plan);
    let room = truth::clean_room(0.0);
    let plain = truth::maps(room.clone(), &frames, BINS);
    let (rel, floor) = (draws.between(0.0015, 0.004), draws.between(4e-5, 1.5e-4));
    let sigma: Vec<f64> = plain.iter().map(|signal| (rel * signal).hypot(floor)).collect();
    let cells = BINS * BINS;
    let seen: Vec<usize> = (0..plain.len()).filter(|&i| !frames[i / cells].held_out).collect();
    let part = |values: &[f64]| seen.iter().map(|&i| values[i]).collect::<Vec<_>>();
    let sigma_seen = part(&sigma);
    let nuisance = truth::map_nuisance(&frames, BINS, &plain).select_rows(&seen);
    let hidden = hide(
        order,
        recipe::SENSOR,
        &mut draws,
        plain.len(),
        |change| truth::significance(&part(change), &sigma_seen, &nuisance),
        |setting| {
            let changed = truth::maps(
                truth::with_effects(room.clone(), std::slice::from_ref(setting)),
                &frames,
                BINS,
            );
            changed.iter().zip(&plain).map(|(a, b)| a - b).collect()
        },
        |name, draws| outside::sensor(name, &frames, BINS, &plain, draws),
    )?;
    let mut clean = truth::maps(truth::with_effects(room.clone(), &hidden.settings), &frames, BINS);
    clean
        .iter_mut()
        .zip(&hidden.added)
        .for_each(|(signal, more)| *signal += more);
    let ratio = draws.between(0.85, 1.2);
    let noise = noise(plain.len(), order, &mut draws);
    let mut toml = format!("sensor_mm = 24.576\nbins = {BINS}\nunit = \"relative\"\n");
    let mut held_toml = toml.clone();
    let mut csv = String::from("map,iy,ix,signal,u\n");
    let mut held_truth = Vec::new();
    for (m, frame) in frames.iter().enumerate() {
        pose(if frame.held_out { &mut held_toml } else { &mut toml }, frame);
        for cell in 0..cells {
            let i = m * cells + cell;
            if frame.held_out {
                held_truth.push((clean[i], sigma[i]));
            } else {
                let (iy, ix) = (cell / BINS, cell % BINS);
                let (signal, u) = (clean[i] + sigma[i] * noise[i], (ratio * sigma[i]).max(1e-6));
                let _ = writeln!(csv, "{},{iy},{ix},{signal:.6},{u:.6}", frame.name);
            }
        }
    }
    Some(Case {
        order: order.clone(),
        files: vec![
            ("model.toml", MODEL.to_owned()),
            ("distribution.csv", believed(&room, &mut draws)),
            ("maps.toml", toml),
            ("maps.csv", csv),
        ],
        held_out: ("held-out.maps.toml", held_toml),
        truth: held_truth,
        strength: hidden.strengths,
    })
}

fn pose(toml: &mut String, frame: &Frame) {
    let pose = &frame.pose;
    let _ = writeln!(
        toml,
        "\n[[map]]\nname = \"{}\"\ndistance_mm = {:.1}",
        frame.name, pose.distance_mm
    );
    let _ = writeln!(
        toml,
        "tilt_x_deg = {:.1}\ntilt_y_deg = {:.1}",
        pose.tilt_x_deg, pose.tilt_y_deg
    );
    let _ = writeln!(toml, "rot_z_deg = {:.1}\nexposure = {}", pose.rot_z_deg, pose.exposure);
    let _ = writeln!(toml, "lamp = {}\ncapped = {}", pose.lamp, pose.capped);
}
