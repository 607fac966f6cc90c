//! The sensor by the scan so far: coarse, from whole half-planes, not corrected, with what the missing half-planes
//! leave open; in W/m² as soon as a spectrum on the axis is known, in lx before.

use std::collections::BTreeMap;

use camino::Utf8Path;

use isolux_model::{Emitter, Interpolation, Luminaire, Model, Scene, Spectral};
use isolux_photometry::IntensityDistribution;
use isolux_record::plan::{Block, Instrument};
use isolux_record::{Quality, ReadingKind, Role, Run};
use isolux_reduce::{Options, on_axis};
use isolux_report::map::Map;
use isolux_report::sensor;
use isolux_report::viewer::explorer::Explored;
use isolux_sim::simulation::{Method, Simulation};
use isolux_units::digits::{significant, stated};
use serde::Serialize;

use crate::Failure;
use crate::run::record;
use crate::simulation::light_so_far::LightSoFar;
use crate::simulation::{in_motion, scene, simulate};

/// The scene of the job, in a run directory.
pub(crate) const SCENE: &str = "job/scene.toml";
/// Pixels along the longer edge.
const PIXELS: usize = 64;

/// The illuminance on the sensor by the half-planes that are whole.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct SensorSoFar {
    /// Half-planes that are whole.
    pub half_planes: usize,
    /// Half-planes of the plan.
    pub planned: usize,
    /// Edges in mm.
    pub size_mm: [f64; 2],
    /// Distance of the sensor in mm.
    pub distance_mm: f64,
    /// `W/m²`, or `lx` before the first spectrum.
    pub unit: &'static str,
    /// Irradiance or illuminance in `unit`.
    pub map: Explored,
    /// Expanded uncertainty (k = 2) of each pixel in `unit`, by missing half-planes, scatter, rounding, calibration and
    /// efficacy; none from a single half-plane, which says nothing of the others.
    pub expanded: Option<Explored>,
    /// The mean with its expanded uncertainty.
    pub mean: String,
    /// Smallest pixel over mean.
    pub min_over_mean: f64,
    /// Where the sensor is taken from.
    pub scene: String,
}

/// What goes with the light of any part of a scan: spectrum, scene, and what all readings share.
pub(crate) struct Lit {
    spectral: Spectral,
    /// Calibration of the lux meter and efficacy, relative.
    u_common_rel: f64,
    scene: Scene,
    /// Where the sensor is taken from.
    named: String,
}

/// The sensor under a light, and under the other one.
struct Solved {
    best: Simulation,
    other: Option<Simulation>,
    divisor: f64,
    u_own_rel: f64,
}

impl Solved {
    /// Standard uncertainty of a value that the other light makes another one.
    fn u(&self, value: f64, other: f64) -> f64 {
        ((value - other) / self.divisor).hypot(self.u_own_rel * value)
    }

    /// That of the mean.
    fn u_mean(&self) -> Option<f64> {
        let other = self.other.as_ref()?;
        Some(self.u(self.best.facts.mean, other.facts.mean))
    }
}

impl Lit {
    /// The scene of the run directory `run`, lit by `light` for the time being, with so many pixels along its longer
    /// edge.
    pub fn of(run: &Utf8Path, record: &Run, light: &LightSoFar, pixels: usize) -> Result<Self, Failure> {
        // A spectrum that cannot be used leaves the map in lx; the reduction says why.
        let spectral = on_axis(record, &Options::default()).ok().flatten();
        let u_ler_rel = spectral.as_ref().map_or(0.0, |spectral| spectral.ler.u_of_parts_rel());
        let spectral = spectral.map_or(Spectral::None, |spectral| Spectral::Spectrum(spectral.spectrum));
        let (scene, named) = the_scene(
            run,
            model(light.best.clone(), Emitter::Point {}, spectral.clone()),
            pixels,
        )?;
        Ok(Self {
            spectral,
            u_common_rel: record.header.station.luxmeter().u_rel.hypot(u_ler_rel),
            scene,
            named,
        })
    }

    /// Standard uncertainty of the mean on the sensor under `light`, relative; none where nothing says what is not
    /// known.
    pub fn u_mean_rel(&self, light: &LightSoFar) -> Result<Option<f64>, Failure> {
        let solved = self.solve(light)?;
        Ok(solved.u_mean().map(|u| u / solved.best.facts.mean))
    }

    fn solve(&self, light: &LightSoFar) -> Result<Solved, Failure> {
        let under = |distribution: &IntensityDistribution| {
            let mut scene = self.scene.clone();
            scene.model = model(distribution.clone(), Emitter::Point {}, self.spectral.clone());
            simulate::solve(&scene, Method::Inverse)
        };
        Ok(Solved {
            best: under(&light.best)?,
            other: light.other.as_ref().map(under).transpose()?,
            divisor: light.divisor,
            u_own_rel: light.u_reading_rel.hypot(self.u_common_rel),
        })
    }
}

/// The map by what the run directory `run` holds; none before the first half-plane is whole, of a scan in motion before
/// it says what is uncertain between its half-planes.
///
/// # Errors
/// Bad input (exit 2) for what is no run directory, or a scene that cannot be lit.
pub fn sensor_so_far(run: &Utf8Path) -> Result<Option<SensorSoFar>, Failure> {
    let record = record::read(run)?;
    let light = match Planes::of(&record) {
        Some(planes) => Some(planes.light()?),
        None => in_motion::light_so_far(&record)?,
    };
    let Some(light) = light else {
        return Ok(None);
    };
    let lit = Lit::of(run, &record, &light, PIXELS)?;
    let solved = lit.solve(&light)?;
    let facts = &solved.best.facts;
    let unit = facts.unit.symbol();
    let expanded = solved.other.as_ref().map(|other| {
        let pixels = solved.best.map.iter().zip(other.map.iter());
        let of_pixel = |(a, b): (&f32, &f32)| (2.0 * solved.u(f64::from(*a), f64::from(*b))) as f32;
        let values: Vec<f32> = pixels.map(of_pixel).collect();
        let u_map = Map {
            values: &values,
            ..sensor::picture(&solved.best)
        };
        Explored::of(&u_map, 2)
    });
    let mean = match solved.u_mean() {
        Some(u) => stated(facts.mean, u, unit),
        None => format!("{} {unit}", significant(facts.mean, 3)),
    };
    let [half_planes, planned] = light.half_planes;
    Ok(Some(SensorSoFar {
        half_planes,
        planned,
        size_mm: facts.size_mm,
        distance_mm: lit.scene.sensor.pose.distance_mm,
        unit,
        mean,
        expanded,
        min_over_mean: facts.uniformity_min_over_mean,
        map: Explored::of(&sensor::picture(&solved.best), 4),
        scene: lit.named,
    }))
}

/// Between its directions as the day's own model will be.
pub(crate) fn model(distribution: IntensityDistribution, emitter: Emitter, spectral: Spectral) -> Model {
    Model::of(Luminaire::interpolated(
        distribution,
        Interpolation::Smooth,
        emitter,
        spectral,
    ))
}

/// The sensor of the day's job, or that of the published case, with few pixels.
fn the_scene(run: &Utf8Path, model: Model, most: usize) -> Result<(Scene, String), Failure> {
    let file = run.join(SCENE);
    let (mut illuminated, named) = if file.is_file() {
        (scene::lit_by(&file, &model)?, "the job's scene".to_owned())
    } else {
        (scene::of_the_published_case(&model)?, "the published case".to_owned())
    };
    let longest = illuminated.sensor.pixels[0].max(illuminated.sensor.pixels[1]).max(1);
    let few = |pixels: usize| (pixels * most / longest).clamp(1, pixels);
    if longest > most {
        illuminated.sensor.pixels = illuminated.sensor.pixels.map(few);
    }
    Ok((illuminated, named))
}

/// Half-planes of the first lit block with a grid.
struct Planes {
    planned: Vec<f64>,
    gamma_deg: Vec<f64>,
    /// Intensities by γ, by the number of the half-plane among those planned.
    whole: BTreeMap<usize, Vec<f64>>,
    /// Scatter and rounding of the strongest direction, relative.
    u_reading_rel: f64,
}

impl Planes {
    fn of(record: &Run) -> Option<Self> {
        let blocks = record.header.plan.blocks();
        let block = blocks.iter().find(|block| is_grid(block))?;
        let mut gamma_deg: Vec<f64> = block.gamma_deg.iter().copied().filter(|gamma| *gamma >= 0.0).collect();
        gamma_deg.sort_by(f64::total_cmp);
        gamma_deg.dedup();
        let mut planned: Vec<f64> = block
            .c_deg
            .iter()
            .copied()
            .filter(|c| (0.0..360.0).contains(c))
            .collect();
        planned.sort_by(f64::total_cmp);
        let (mut peak, mut u_reading_rel) = (0.0, 0.0);
        let mut sums: BTreeMap<(usize, usize), (f64, f64)> = BTreeMap::new();
        let rows = record.readings.rows.iter().filter(|row| {
            row.block == block.name
                && row.role == Role::Point
                && row.quality == Quality::Ok
                && row.kind == ReadingKind::Lit
        });
        for row in rows {
            let c = row.c_target_deg.rem_euclid(360.0);
            let at = planned.iter().position(|one| *one == c);
            let node = gamma_deg.iter().position(|one| *one == row.gamma_target_deg);
            if let (Some(at), Some(node), Some(lux)) = (at, node, row.illuminance_lx) {
                let sum = sums.entry((at, node)).or_default();
                let cd = lux * (row.distance_mm / 1000.0).powi(2);
                (sum.0, sum.1) = (sum.0 + cd, sum.1 + 1.0);
                if lux > peak {
                    (peak, u_reading_rel) = (lux, row.u_lx.unwrap_or_default() / lux);
                }
            }
        }
        let whole: BTreeMap<usize, Vec<f64>> = (0..planned.len())
            .filter_map(|at| {
                let nodes = (0..gamma_deg.len()).map(|node| sums.get(&(at, node)).map(|(sum, count)| sum / count));
                Some((at, nodes.collect::<Option<Vec<f64>>>()?))
            })
            .collect();
        (!whole.is_empty()).then_some(Self {
            planned,
            gamma_deg,
            whole,
            u_reading_rel,
        })
    }

    /// What is missing lies between its neighbours, or is the mean of all: two ways to fill it, taken as the ends of a
    /// rectangle (JCGM 100, 4.3.7, of half width |a − b|). A single half-plane says nothing of the others.
    fn light(&self) -> Result<LightSoFar, Failure> {
        let some = self.whole.len() > 1;
        Ok(LightSoFar {
            best: self.distribution(Self::interpolated)?,
            other: some.then(|| self.distribution(Self::mean)).transpose()?,
            divisor: 3.0_f64.sqrt(),
            u_reading_rel: self.u_reading_rel,
            half_planes: [self.whole.len(), self.planned.len()],
        })
    }

    /// Every half-plane of the plan; what is missing by `fill`.
    fn distribution(&self, fill: fn(&Self, usize, usize) -> f64) -> Result<IntensityDistribution, Failure> {
        let nodes = self.gamma_deg.len();
        let cd = |at: usize, node: usize| {
            self.whole
                .get(&at)
                .map_or_else(|| fill(self, at, node), |plane| plane[node])
        };
        let intensity = (0..self.planned.len()).flat_map(|at| (0..nodes).map(move |node| (at, node)));
        let intensity_cd = intensity.map(|(at, node)| cd(at, node)).collect();
        IntensityDistribution::new(self.planned.clone(), self.gamma_deg.clone(), intensity_cd)
            .map_err(Failure::bad_input)
    }

    /// Between the nearest half-planes that are whole, round the circle.
    fn interpolated(&self, at: usize, node: usize) -> f64 {
        let c = self.planned[at];
        let way = |from: f64, to: f64| (to - from).rem_euclid(360.0);
        let before = self
            .whole
            .iter()
            .min_by(|a, b| way(self.planned[*a.0], c).total_cmp(&way(self.planned[*b.0], c)));
        let after = self
            .whole
            .iter()
            .min_by(|a, b| way(c, self.planned[*a.0]).total_cmp(&way(c, self.planned[*b.0])));
        let (Some((b, before)), Some((a, after))) = (before, after) else {
            return 0.0;
        };
        let (to_before, to_after) = (way(self.planned[*b], c), way(c, self.planned[*a]));
        let share = to_before / (to_before + to_after);
        before[node] + (after[node] - before[node]) * share
    }

    /// The mean over the half-planes that are whole.
    fn mean(&self, _: usize, node: usize) -> f64 {
        self.whole.values().map(|plane| plane[node]).sum::<f64>() / self.whole.len() as f64
    }
}

fn is_grid(block: &Block) -> bool {
    block.kind == ReadingKind::Lit && block.instrument == Instrument::Luxmeter && block.gamma_deg.len() > 2
}

#[cfg(test)]
mod tests {
    use super::*;

    fn planes(whole: &[(usize, f64)]) -> Planes {
        Planes {
            planned: vec![0.0, 90.0, 180.0, 270.0],
            gamma_deg: vec![0.0, 90.0],
            whole: whole.iter().map(|(at, cd)| (*at, vec![10.0, *cd])).collect(),
            u_reading_rel: 0.0,
        }
    }

    #[test]
    fn what_is_missing_lies_between_its_neighbours_round_the_circle() {
        let some = planes(&[(0, 4.0), (1, 8.0)]);
        // C 180° is 90° behind C 90° and 180° before C 360°.
        assert!((some.interpolated(2, 1) - (8.0 - 4.0 / 3.0)).abs() < 1e-12);
        assert!((some.interpolated(3, 1) - (4.0 + 4.0 / 3.0)).abs() < 1e-12);
        assert_eq!((some.mean(2, 1), some.interpolated(2, 0)), (6.0, 10.0));
        let whole = planes(&[(0, 1.0), (1, 2.0), (2, 3.0), (3, 4.0)]);
        let both = [Planes::interpolated, Planes::mean].map(|fill| whole.distribution(fill).unwrap());
        assert_eq!(both[0], both[1], "nothing is missing");
        let one = planes(&[(1, 5.0)]);
        assert!([0, 2, 3].into_iter().all(|at| one.interpolated(at, 1) == 5.0));
    }
}
