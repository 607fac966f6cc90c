//! `plan --for`: only the directions from which light reaches the sensor of a scene, as many half-planes, γ and repeats
//! as its irradiance needs for an uncertainty.
//!
//! What a grid loses between its directions is computed on the lamp that is known: the model of the scene, or the lobe
//! of the station's flux and peak. What readings cannot make smaller (calibration, distance) is stated beside it.

mod lamp;

use std::fmt;

use camino::Utf8Path;
use isolux_model::{Scene, Spectral};
use isolux_photometry::IntensityDistribution;
use isolux_record::plan::{Block, BlockDocument, Mode, Order, PlanDocument};
use isolux_record::{Plan, ReadingKind, Station};
use isolux_scan::{distance_mm, distribution_block, dry_run};
use isolux_sim::simulation::Method;
use serde::Serialize;

use self::lamp::lit_scene;
use crate::Failure;
use crate::instruments::bench::StationFiles;
use crate::scan::plan;
use crate::simulation::{sensor_so_far, simulate};

/// Half-planes of the grids that are tried: the reduction states no uncertainty over more than 45°.
const HALF_PLANES: [usize; 4] = [8, 12, 24, 36];
/// Steps of γ from the axis to the edge of what the sensor sees: fewer γ resolve no lobe.
const STEPS: [usize; 5] = [4, 6, 8, 12, 16];
/// γ at which stray light is read, at least.
const STRAY_GAMMAS: usize = 3;
/// Readings a direction.
const REPEATS: [u32; 5] = [1, 2, 3, 5, 10];

/// A plan for one sensor, and what it will give.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct ForSensor {
    /// The plan, as a file.
    pub text: String,
    /// The largest γ from which light of the lamp reaches the sensor, degrees.
    pub reach_deg: f64,
    /// Half-planes.
    pub half_planes: usize,
    /// γ of each, from one side to the other.
    pub gammas: usize,
    /// Step of γ, degrees.
    pub gamma_step_deg: f64,
    /// Readings a direction.
    pub repeats: u32,
    /// From the stable lamp to the end, s: this plan, and the one that it is made of.
    pub from_stable_s: [f64; 2],
    /// Standard uncertainty (k = 1) of the sensor's mean illuminance, relative, by its parts.
    pub u_mean: Parts,
    /// The same of its most uncertain place.
    pub u_place: Parts,
    /// What was asked for.
    pub wanted_rel: f64,
    /// What the lamp is taken to be.
    pub lamp: String,
    /// What the station does not say, and has no part in the uncertainties.
    pub unknown: [Option<&'static str>; 3],
}

/// Parts of a relative standard uncertainty.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Parts {
    /// Calibration of the lux meter.
    pub calibration: f64,
    /// Distance of the readings.
    pub distance: f64,
    /// Scatter and digits of the readings.
    pub readings: f64,
    /// What the grid loses between its directions.
    pub grid: f64,
}

impl Parts {
    /// All of them.
    pub fn u_rel(&self) -> f64 {
        self.fixed().hypot(self.readings).hypot(self.grid)
    }

    /// Those that no reading makes smaller.
    fn fixed(&self) -> f64 {
        self.calibration.hypot(self.distance)
    }
}

impl fmt::Display for Parts {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let parts = [self.u_rel(), self.calibration, self.distance, self.readings, self.grid];
        let [all, calibration, distance, readings, grid] = parts.map(|part| format!("{:.2} %", 100.0 * part));
        write!(
            f,
            "{all} = calibration {calibration} + distance {distance} + readings {readings} + grid {grid}, in squares"
        )
    }
}

impl ForSensor {
    /// What a person should know, a sentence each.
    pub fn sentences(&self) -> Vec<String> {
        let [own, whole] = self.from_stable_s.map(super::duration);
        let mut lines = vec![
            format!(
                "light reaches the sensor from γ 0° to {:.1}°: {} half-planes × {} γ by {}°, {} a direction",
                self.reach_deg,
                self.half_planes,
                self.gammas,
                self.gamma_step_deg,
                match self.repeats {
                    1 => "one reading".to_owned(),
                    count => format!("{count} readings"),
                }
            ),
            format!("from the stable lamp: {own} in place of {whole}"),
            format!("u of the mean illuminance (k = 1): {}", self.u_mean),
            format!("u of its most uncertain place: {}", self.u_place),
            format!("what is lost between directions is that of {}", self.lamp),
        ];
        let unknown: Vec<&str> = self.unknown.into_iter().flatten().collect();
        if !unknown.is_empty() {
            lines.push(format!("not known, and no part of that: {}", unknown.join(", ")));
        }
        if self.u_rel() > self.wanted_rel {
            lines.push(format!(
                "{:.2} % is out of reach: calibration and distance alone are {:.2} %; this is the plan that comes \
                 nearest",
                100.0 * self.wanted_rel,
                100.0 * self.u_mean.fixed()
            ));
        }
        lines.push(
            "the file that comes out holds this zone alone: it is no photometric distribution of the lamp".to_owned(),
        );
        lines
    }

    /// The larger of both uncertainties.
    fn u_rel(&self) -> f64 {
        self.u_mean.u_rel().max(self.u_place.u_rel())
    }

    /// Sooner where both reach what is wanted, else more certain.
    fn is_better_than(&self, other: &Self) -> bool {
        match [self, other].map(|one| one.u_rel() <= self.wanted_rel) {
            [true, true] => self.from_stable_s[0] < other.from_stable_s[0],
            [own, others] if own != others => own,
            // A hundredth of its uncertainty is worth no more time.
            _ => self.u_rel() < 0.99 * other.u_rel(),
        }
    }
}

/// The soonest plan, made of `plan_file`, that brings the sensor of `scene_file` to `wanted_rel`; the most certain one
/// where none does.
///
/// # Errors
/// Bad input (exit 2): a plan without a distribution, a lamp of which nothing is known, a sensor that sees no light.
pub fn propose(
    station: &Utf8Path,
    plan_file: &Utf8Path,
    scene_file: &Utf8Path,
    wanted_rel: f64,
) -> Result<ForSensor, Failure> {
    let StationFiles { station, file, .. } = StationFiles::load(station)?;
    let (whole, text) = plan::load(plan_file)?;
    let planned_s = |plan: &Plan| -> Result<f64, Failure> {
        let run = dry_run(&station, plan).map_err(|fault| plan::located(plan_file, &text, &fault))?;
        Ok(run.total_s - run.warm_up_s)
    };
    let block = distribution_block(&whole).ok_or_else(|| {
        Failure::bad_input(format!(
            "{plan_file}: has no lit block of the lux meter with directions"
        ))
    })?;
    let (scene, lamp) = lit_scene(&station, scene_file)?;
    let [_, reach_deg] = scene.gamma_range_deg();
    if reach_deg >= 90.0 {
        return Err(Failure::bad_input(format!(
            "{scene_file}: the sensor sees the lamp from γ up to {reach_deg:.0}°; the whole distribution is needed"
        )));
    }
    let light = scene.model.luminaire().distribution();
    let exact = on_sensor(&scene, light.clone())?;
    let whole_s = planned_s(&whole)?;
    let mut best: Option<ForSensor> = None;
    for (half_planes, steps) in HALF_PLANES
        .into_iter()
        .flat_map(|planes| STEPS.map(|steps| (planes, steps)))
    {
        let step_deg = (10.0 * reach_deg / steps as f64).ceil() / 10.0;
        let grid = sampled(light, half_planes, steps, step_deg)?;
        let readings = Readings::of(&station, &file, block, grid.peak().intensity_cd);
        let lost = exact.compared(&on_sensor(&scene, grid)?);
        for repeats in REPEATS {
            let own = document(&whole, block, (half_planes, steps, step_deg), repeats);
            let text = written(&own, plan_file, scene_file)?;
            let made = Plan::parse(plan_file, &text).map_err(Failure::bad_input)?;
            let one = ForSensor {
                text,
                reach_deg,
                half_planes,
                gammas: 2 * steps + 1,
                gamma_step_deg: step_deg,
                repeats,
                from_stable_s: [planned_s(&made)?, whole_s],
                // Every half-plane counts at least once in the mean.
                u_mean: readings.parts(f64::from(repeats) * half_planes as f64, lost[0]),
                u_place: readings.parts(f64::from(repeats), lost[1]),
                wanted_rel,
                lamp: lamp.clone(),
                unknown: readings.unknown,
            };
            best = match best {
                Some(other) if !one.is_better_than(&other) => Some(other),
                _ => Some(one),
            };
        }
    }
    best.ok_or_else(|| Failure::bad_input(format!("{plan_file}: no grid was tried")))
}

/// What is known of the readings before they are taken, relative to the largest light of the zone.
#[derive(Debug, Clone, Copy)]
struct Readings {
    calibration: f64,
    distance: f64,
    noise: f64,
    digit: f64,
    /// Keys of the station that would say more.
    unknown: [Option<&'static str>; 3],
}

impl Readings {
    fn of(station: &Station, file: &Utf8Path, block: &Block, largest_cd: f64) -> Self {
        let meter = station.luxmeter();
        let read_mm = distance_mm(station, block);
        let largest_lx = largest_cd / (read_mm * 1e-3).powi(2);
        let u_distance = station.bench().u_distance_mm.map(|u_mm| 2.0 * u_mm / read_mm);
        let noise = meter.noise_rel.zip(meter.noise_lx);
        let noise = noise.map(|(rel, lux)| rel.hypot(lux / largest_lx));
        let digit_lx = plan::display(station, file)
            .and_then(|ranges| ranges.into_iter().find(|range| largest_lx <= range.full_scale_lx))
            .map(|range| range.digit_lx);
        Self {
            calibration: meter.u_rel,
            distance: u_distance.unwrap_or(0.0),
            noise: noise.unwrap_or(0.0),
            digit: digit_lx.map_or(0.0, |digit_lx| digit_lx / 12.0_f64.sqrt() / largest_lx),
            unknown: [
                u_distance.is_none().then_some("[bench] u_distance_mm"),
                noise.is_none().then_some("[luxmeter] noise_rel and noise_lx"),
                digit_lx.is_none().then_some("the meter's ranges"),
            ],
        }
    }

    /// Of the mean of so many readings. Digits do not become less by their number.
    fn parts(&self, count: f64, grid: f64) -> Parts {
        Parts {
            calibration: self.calibration,
            distance: self.distance,
            readings: (self.noise / count.sqrt()).hypot(self.digit),
            grid,
        }
    }
}

/// The light at the directions of a grid, and nothing beyond.
fn sampled(
    light: &IntensityDistribution,
    half_planes: usize,
    steps: usize,
    step_deg: f64,
) -> Result<IntensityDistribution, Failure> {
    let c_deg: Vec<f64> = (0..half_planes)
        .map(|k| 360.0 * k as f64 / half_planes as f64)
        .collect();
    let gamma_deg: Vec<f64> = (0..=steps).map(|k| k as f64 * step_deg).collect();
    let plane = |c: &f64| {
        gamma_deg
            .iter()
            .map(|gamma| light.intensity_cd_at(*c, *gamma))
            .collect::<Vec<_>>()
    };
    let intensity_cd = c_deg.iter().flat_map(plane).collect();
    IntensityDistribution::new(c_deg.clone(), gamma_deg.clone(), intensity_cd).map_err(Failure::bad_input)
}

/// The sensor in one light.
struct Seen {
    mean: f64,
    map: Vec<f32>,
}

impl Seen {
    /// What another one differs by: of the mean, and of the pixel that differs most, relative to the mean.
    fn compared(&self, other: &Self) -> [f64; 2] {
        let differences = self.map.iter().zip(&other.map).map(|(a, b)| f64::from((a - b).abs()));
        [(self.mean - other.mean).abs(), differences.fold(0.0, f64::max)].map(|difference| difference / self.mean)
    }
}

fn on_sensor(scene: &Scene, light: IntensityDistribution) -> Result<Seen, Failure> {
    let emitter = scene.model.emitter();
    let mut scene = scene.clone();
    scene.model = sensor_so_far::model(light, emitter, Spectral::None);
    let solved = simulate::solve(&scene, Method::Inverse)?;
    if solved.facts.mean <= 0.0 {
        return Err(Failure::bad_input("no light of the lamp reaches the sensor"));
    }
    Ok(Seen {
        mean: solved.facts.mean,
        map: solved.map.to_vec(),
    })
}

/// The plan with the block of its distribution on this grid, and blocked readings no farther out than it.
fn document(
    whole: &Plan,
    distribution: &Block,
    (half_planes, steps, step_deg): (usize, usize, f64),
    repeats: u32,
) -> PlanDocument {
    let mut document = whole.document().clone();
    let (step_c, most) = (360.0 / half_planes as f64, steps as f64 * step_deg);
    for (index, block) in document.block.iter_mut().enumerate() {
        if block.name == distribution.name {
            *block = BlockDocument {
                c_deg: None,
                c_range: Some([0.0, 180.0 - step_c, step_c]),
                gamma_deg: None,
                gamma_range: Some([-most, most, step_deg]),
                order: Order::Serpentine,
                mode: Mode::Step,
                speed_deg_s: None,
                repeats: (repeats > 1).then_some(repeats),
                u_rel: None,
                reference_every: Some((half_planes / 2 * (2 * steps + 1)) as u32),
                ..block.clone()
            };
        } else if block.kind == ReadingKind::Baffled
            && let Some(planned) = whole.blocks().get(index)
        {
            // Stray light at fewer γ is not known over γ.
            let mut near = planned.gamma_deg.clone();
            near.sort_by(|a, b| a.abs().total_cmp(&b.abs()));
            let inside = near.iter().filter(|gamma| gamma.abs() <= most).count();
            near.truncate(inside.max(STRAY_GAMMAS));
            block.gamma_range = None;
            block.gamma_deg = Some(near);
        }
    }
    document
}

fn written(document: &PlanDocument, plan: &Utf8Path, scene: &Utf8Path) -> Result<String, Failure> {
    let text = toml::to_string(document).map_err(Failure::bad_input)?;
    Ok(format!(
        "# {plan} for the sensor of {scene} alone: `isolux plan --for`.\n\
         # What comes out is no photometric distribution.\n{text}"
    ))
}
