//! One case: what the operator has, and what is hidden in it.

use std::fmt::Write as _;
use std::path::Path;

use isolux_darkroom::{Darkroom, Kind, Room};

use crate::plan::{self, Frame, Plan, Step};
use crate::random::Draws;
use crate::recipe::{self, Recipe};
use crate::truth::{self, Setting};
use crate::{no_noise, oracle, outside, unforeseen};

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
    /// The same readings in the same noise with nothing hidden: what the refitted terms alone leave on held-out rows.
    pub without: Without,
    /// The readings without noise, their true standard deviations beside them; empty for maps.
    pub noise_free: String,
    /// Strength of each hidden effect over its plausible maximum (0 outside the catalogue).
    pub strength: Vec<f64>,
    /// Squared deviation, in σ², that even the best fit is expected to leave on the held-out readings; none for maps
    /// and for what has no name.
    pub unavoidable: Option<f64>,
}

/// A case's readings with nothing hidden.
#[derive(Debug)]
pub struct Without {
    /// In place of the last of the case's files.
    pub values: String,
    /// Noise-free truth of the held-out rows.
    pub truth: Vec<f64>,
}

/// `count` further draws, on the day of an order, of the first thing that is hidden there and has no name: its change
/// of every reading that the operator sees, in true standard deviations. None where the day cannot be made.
pub fn further_draws(order: &Order, count: u64) -> Option<Vec<Vec<f64>>> {
    let (name, _) = order.hidden.first()?;
    let day = day(order, &mut Draws::new(order.seed, 1))?;
    let draw = |k: u64| {
        let change = unnamed(name, &day.steps, &day.plain, &mut Draws::new(order.seed, 1000 + k));
        let rows = day.steps.iter().zip(change).zip(&day.plain);
        let seen = rows.filter(|((step, _), _)| !step.held_out);
        seen.map(|((_, change), lx)| change / day.noise.sigma(*lx)).collect()
    };
    Some((0..count).map(draw).collect())
}

/// What a kind that no catalogue has changes at strength 1.
fn unnamed(name: &str, steps: &[Step], plain: &[f64], draws: &mut Draws) -> Vec<f64> {
    if no_noise::has(name) {
        no_noise::gonio(name, steps, plain, draws)
    } else if unforeseen::has(name) {
        unforeseen::gonio(name, steps, plain, draws)
    } else {
        outside::gonio(name, steps, plain, draws)
    }
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
            // A dark bump is what the catalogue calls self-absorption.
            let one_way = matches!(
                name,
                "pole_shadow"
                    | "door_opened"
                    | "dust"
                    | "reflex"
                    | "settling_lag"
                    | "bright_bump"
                    | "bright_ring"
                    | "start_of_visit"
                    | "sticky_readings"
                    | "condensation_burst"
                    | "door_with_jitter"
                    | "moth_at_the_lamp"
                    | "afterglow"
                    | "curtain_side"
                    | "wire_across"
                    | "dust_falls"
                    | "flickering_led"
                    | "sunbeam_through_slit"
                    | "loose_baffle"
            );
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

/// A day at the goniometer before anything is read: the room with what is hidden in it, and its noise.
pub(crate) struct Day {
    pub(crate) steps: Vec<Step>,
    pub(crate) climate: Climate,
    pub(crate) room: Darkroom,
    pub(crate) settings: Vec<Setting>,
    strengths: Vec<f64>,
    /// Readings with nothing hidden, and with it.
    plain: Vec<f64>,
    clean: Vec<f64>,
    pub(crate) noise: Noise,
}

/// The noise of one day: relative, floor, and what is stated over what is true.
#[derive(Clone, Copy)]
pub(crate) struct Noise {
    rel: f64,
    floor: f64,
    pub(crate) ratio: f64,
}

impl Noise {
    pub(crate) fn sigma(self, signal: f64) -> f64 {
        (self.rel * signal).hypot(self.floor)
    }
}

pub(crate) fn day(order: &Order, draws: &mut Draws) -> Option<Day> {
    let mut steps = plan::gonio(order.plan, draws);
    let room = truth::clean_room(draws.between(0.01, 0.03));
    let climate = Climate::draw(draws);
    for step in &mut steps {
        step.at.ambient_c = climate.at(step.at.time_s);
    }
    let plain = truth::readings(room.clone(), &[], &steps);
    set_ranges(&mut steps, &plain);
    let (rel, floor) = (draws.between(0.002, 0.006), draws.between(0.004, 0.014));
    let mut noise = Noise { rel, floor, ratio: 1.0 };
    let sigma: Vec<f64> = plain.iter().map(|lx| noise.sigma(*lx)).collect();
    // Only what the operator sees makes the significance.
    let seen: Vec<usize> = (0..steps.len()).filter(|&i| !steps[i].held_out).collect();
    let part = |values: &[f64]| seen.iter().map(|&i| values[i]).collect::<Vec<_>>();
    let sigma_seen = part(&sigma);
    let nuisance = truth::reading_nuisance(&steps, &plain).select_rows(&seen);
    let hidden = hide(
        order,
        recipe::GONIO,
        draws,
        steps.len(),
        |change| truth::significance(&part(change), &sigma_seen, &nuisance),
        |setting| {
            let setting = std::slice::from_ref(setting);
            let changed = truth::readings(truth::with_effects(room.clone(), setting), setting, &steps);
            changed.iter().zip(&plain).map(|(a, b)| a - b).collect()
        },
        |name, draws| unnamed(name, &steps, &plain, draws),
    )?;
    let disturbed = truth::with_effects(room.clone(), &hidden.settings);
    let mut clean = truth::readings(disturbed, &hidden.settings, &steps);
    clean.iter_mut().zip(&hidden.added).for_each(|(lx, more)| *lx += more);
    noise.ratio = draws.between(0.85, 1.2);
    Some(Day {
        steps,
        climate,
        room,
        settings: hidden.settings,
        strengths: hidden.strengths,
        plain,
        clean,
        noise,
    })
}

/// The meter changes its range by the light that is there.
pub(crate) fn set_ranges(steps: &mut [Step], plain: &[f64]) {
    for (step, lx) in steps.iter_mut().zip(plain) {
        step.at.range = if *lx < 3.0 {
            1
        } else if *lx < 20.0 {
            2
        } else {
            3
        };
    }
}

pub(crate) const COLUMNS: &str = "index,block,kind,time_s,c_deg,gamma_deg,distance_mm,travel,range,ambient_c";

/// The coordinates of one reading, as its row begins.
pub(crate) fn place(index: usize, step: &Step, draws: &mut Draws) -> String {
    let at = &step.at;
    let kind = match at.kind {
        Kind::Lit => "lit",
        Kind::Baffled => "baffled",
        Kind::LampOff => "lamp_off",
        Kind::Capped => "capped",
    };
    let ambient = at.ambient_c + 0.02 * draws.normal();
    format!(
        "{index},{},{kind},{:.1},{:.1},{:.1},{:.1},{},{},{ambient:.2}",
        step.block, at.time_s, at.c_deg, at.gamma_deg, at.distance_mm, at.travel, at.range
    )
}

fn gonio(order: &Order) -> Option<Case> {
    let mut draws = Draws::new(order.seed, 1);
    let day = day(order, &mut draws)?;
    let noise = unit_noise(day.steps.len(), order, &mut draws);
    let header = format!("{COLUMNS},illuminance_lx,u_lx\n");
    let (mut seen_csv, mut without_csv, mut held_csv) = (header.clone(), header.clone(), format!("{COLUMNS}\n"));
    let mut noise_free = header;
    let mut held_truth = Vec::new();
    let mut held_plain = Vec::new();
    for (i, step) in day.steps.iter().enumerate() {
        let place = place(i, step, &mut draws);
        let sigma = day.noise.sigma(day.plain[i]);
        if step.held_out {
            let _ = writeln!(held_csv, "{place}");
            held_truth.push((day.clean[i], sigma));
            held_plain.push(day.plain[i]);
        } else {
            let (noise, u) = (sigma * noise[i], day.noise.ratio * sigma);
            let _ = writeln!(seen_csv, "{place},{:.6},{u:.6}", day.clean[i] + noise);
            let _ = writeln!(without_csv, "{place},{:.6},{u:.6}", day.plain[i] + noise);
            let _ = writeln!(noise_free, "{place},{:.9},{sigma:.9}", day.clean[i]);
        }
    }
    let named = !day.settings.is_empty() && day.settings.len() == order.hidden.len();
    let unavoidable = named.then(|| {
        let sigma: Vec<f64> = day.plain.iter().map(|lx| day.noise.sigma(*lx)).collect();
        oracle::held_out_square(&day.steps, &sigma, &day.plain, &day.settings, |settings| {
            truth::readings(truth::with_effects(day.room.clone(), settings), settings, &day.steps)
        })
    });
    Some(Case {
        order: order.clone(),
        unavoidable,
        files: vec![
            ("model.toml", MODEL.to_owned()),
            ("distribution.csv", assumed(&day.room, &mut draws)),
            ("readings.csv", seen_csv),
        ],
        held_out: ("held-out.csv", held_csv),
        truth: held_truth,
        without: Without {
            values: without_csv,
            truth: held_plain,
        },
        noise_free,
        strength: day.strengths,
    })
}

/// The operator's distribution: rotational, with a smooth error of its shape.
fn assumed(room: &Darkroom, draws: &mut Draws) -> String {
    let room = Room::new(room.clone());
    let error: Vec<f64> = (0..oracle::BELIEVED_TERMS)
        .map(|k| oracle::believed_error(k) * draws.normal())
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

/// The temperature of the room over a day.
pub(crate) struct Climate {
    mean_c: f64,
    swing_c: f64,
    period_s: f64,
    phase: f64,
    slope_c_per_h: f64,
}

impl Climate {
    fn draw(draws: &mut Draws) -> Self {
        Self {
            mean_c: draws.between(24.2, 25.4),
            swing_c: draws.between(0.3, 0.7),
            period_s: draws.between(1800.0, 3600.0),
            phase: draws.between(0.0, std::f64::consts::TAU),
            slope_c_per_h: draws.between(-0.4, 0.4),
        }
    }

    pub(crate) fn at(&self, time_s: f64) -> f64 {
        let turn = std::f64::consts::TAU * time_s / self.period_s + self.phase;
        self.mean_c + self.swing_c * turn.sin() + self.slope_c_per_h * time_s / 3600.0
    }
}

/// Unit noise: AR(1), with a share of wide ones.
pub(crate) fn unit_noise(n: usize, order: &Order, draws: &mut Draws) -> Vec<f64> {
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

pub(crate) const BINS: usize = 24;

/// A day of maps before anything is recorded.
pub(crate) struct MapDay {
    frames: Vec<Frame>,
    pub(crate) room: Darkroom,
    pub(crate) settings: Vec<Setting>,
    strengths: Vec<f64>,
    plain: Vec<f64>,
    clean: Vec<f64>,
    pub(crate) noise: Noise,
}

pub(crate) fn map_day(order: &Order, draws: &mut Draws) -> Option<MapDay> {
    let frames = plan::sensor(order.plan);
    let room = truth::clean_room(0.0);
    let plain = truth::maps(room.clone(), &frames, BINS);
    let (rel, floor) = (draws.between(0.0015, 0.004), draws.between(4e-5, 1.5e-4));
    let mut noise = Noise { rel, floor, ratio: 1.0 };
    let sigma: Vec<f64> = plain.iter().map(|signal| noise.sigma(*signal)).collect();
    let cells = BINS * BINS;
    let seen: Vec<usize> = (0..plain.len()).filter(|&i| !frames[i / cells].held_out).collect();
    let part = |values: &[f64]| seen.iter().map(|&i| values[i]).collect::<Vec<_>>();
    let sigma_seen = part(&sigma);
    let nuisance = truth::map_nuisance(&frames, BINS, &plain).select_rows(&seen);
    let hidden = hide(
        order,
        recipe::SENSOR,
        draws,
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
    noise.ratio = draws.between(0.85, 1.2);
    Some(MapDay {
        frames,
        room,
        settings: hidden.settings,
        strengths: hidden.strengths,
        plain,
        clean,
        noise,
    })
}

fn sensor(order: &Order) -> Option<Case> {
    let mut draws = Draws::new(order.seed, 2);
    let day = map_day(order, &mut draws)?;
    let noise = unit_noise(day.plain.len(), order, &mut draws);
    let cells = BINS * BINS;
    let mut toml = map_head();
    let mut held_toml = toml.clone();
    let (mut csv, mut without_csv) = (MAP_COLUMNS.to_owned(), MAP_COLUMNS.to_owned());
    let mut held_truth = Vec::new();
    let mut held_plain = Vec::new();
    for (m, frame) in day.frames.iter().enumerate() {
        pose(if frame.held_out { &mut held_toml } else { &mut toml }, frame);
        for cell in 0..cells {
            let i = m * cells + cell;
            let sigma = day.noise.sigma(day.plain[i]);
            if frame.held_out {
                held_truth.push((day.clean[i], sigma));
                held_plain.push(day.plain[i]);
            } else {
                let (iy, ix, name) = (cell / BINS, cell % BINS, frame.name);
                let (noise, u) = (sigma * noise[i], (day.noise.ratio * sigma).max(1e-6));
                let _ = writeln!(csv, "{name},{iy},{ix},{:.6},{u:.6}", day.clean[i] + noise);
                let _ = writeln!(without_csv, "{name},{iy},{ix},{:.6},{u:.6}", day.plain[i] + noise);
            }
        }
    }
    Some(Case {
        order: order.clone(),
        unavoidable: None,
        files: vec![
            ("model.toml", MODEL.to_owned()),
            ("distribution.csv", assumed(&day.room, &mut draws)),
            ("maps.toml", toml),
            ("maps.csv", csv),
        ],
        held_out: ("held-out.maps.toml", held_toml),
        truth: held_truth,
        without: Without {
            values: without_csv,
            truth: held_plain,
        },
        noise_free: String::new(),
        strength: day.strengths,
    })
}

pub(crate) const MAP_COLUMNS: &str = "map,iy,ix,signal,u\n";

pub(crate) fn map_head() -> String {
    format!("sensor_mm = 24.576\nbins = {BINS}\nunit = \"relative\"\n")
}

pub(crate) fn pose(toml: &mut String, frame: &Frame) {
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
