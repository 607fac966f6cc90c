//! From a scene (what the operator believes, and a sensor) to what the solvers take.

use std::sync::Arc;

use glam::DVec3;
use isolux_model::effects::Pixel;
use isolux_model::{Emitter, Model, Node, Scene, Sectors, Spectral};
use isolux_photometry::{DistributionError, IntensityDistribution, angles_deg, direction};

use crate::sensor::{Sensor, SensorError};
use crate::source::{LightSource, Part, Shape};
use crate::station::{Station, StationError};
use crate::table::IntensityTable;

/// Why a scene cannot be simulated.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum SetupError {
    /// The sensor's own numbers.
    #[error(transparent)]
    Sensor(#[from] SensorError),
    /// The distribution with its effects.
    #[error("the distribution with its effects: {0}")]
    Distribution(#[from] DistributionError),
    /// The sensor turns its back.
    #[error(
        "the sensor's face looks away from the source: its normal and the light make {angle_deg:.1}°, so that no light \
         reaches it"
    )]
    Behind {
        /// Between the direction of light at the sensor's centre and the reversed normal.
        angle_deg: f64,
    },
    /// Source and sensor share a place.
    #[error(
        "the sensor cuts through the source: it comes within {distance_mm:.3} mm of an emitter of radius {radius_mm:.3} mm"
    )]
    Through {
        /// Nearest distance of the sensor from the middle of a part.
        distance_mm: f64,
        /// Radius of that part.
        radius_mm: f64,
    },
    /// The distribution says nothing about the directions of the sensor.
    #[error(
        "no light reaches the sensor: the distribution covers γ from {first_deg}° to {last_deg}°, the sensor lies between \
         γ = {from_deg:.1}° and {to_deg:.1}°"
    )]
    Outside {
        /// First γ of the distribution.
        first_deg: f64,
        /// Last γ.
        last_deg: f64,
        /// Smallest γ of the sensor.
        from_deg: f64,
        /// Largest γ of the sensor.
        to_deg: f64,
    },
    /// Parts of the scene that do not fit its lamp.
    #[error(transparent)]
    Station(#[from] StationError),
    /// Hall light in W/m² on a map in lx.
    #[error("background_w_m2 = {background_w_m2} needs the model's spectrum or ler_lm_per_w: the map would be in lx")]
    Background {
        /// What the scene gives.
        background_w_m2: f64,
    },
}

/// A scene made ready: the source's parts, the sensor's place, and factors that do not depend on the emitter's extent.
#[derive(Debug, Clone)]
pub struct Setup {
    /// What emits.
    pub source: LightSource,
    /// What is lit.
    pub sensor: Sensor,
    /// Factor of the lamp at the scene's time.
    pub lamp: f64,
    /// Factor of the sensor's own effects on each pixel; `None` where it has none.
    pub pixel_factor: Option<Vec<f64>>,
    /// Uniform light on the sensor in lx.
    pub background_lx: f64,
    /// Spread to neighbours, standard deviation in pixels.
    pub blur_px: f64,
    /// Luminous efficacy of radiation in lm/W; without it results stay in lx.
    pub ler_lm_per_w: Option<f64>,
    /// What stands beside the direct path.
    pub station: Option<Station>,
    /// What the operator should know.
    pub findings: Vec<String>,
}

impl Setup {
    /// What one lux is in the unit of the map: W/m² where the lamp's efficacy is known.
    pub fn per_unit(&self) -> f64 {
        self.ler_lm_per_w.unwrap_or(1.0).recip()
    }

    /// Prepares `scene`.
    ///
    /// # Errors
    /// [`SetupError`] names what makes the scene impossible.
    pub fn new(scene: &Scene) -> Result<Self, SetupError> {
        let (model, given) = (&scene.model, &scene.sensor);
        let placement = model.placement(given.pose);
        let turn = placement.luminaire_from_room;
        let rotation = turn * placement.pose.rotation();
        let centre = turn * placement.pose.centre_mm();
        let spectrum = match model.luminaire().spectral() {
            Spectral::Spectrum(spectrum) => Some(spectrum),
            _ => None,
        };
        let ler_lm_per_w = model.ler_lm_per_w();
        let station = Station::new(&scene.optics, spectrum, ler_lm_per_w.is_some())?;
        // Through plates the light seems nearer; the plates are parallel to the sensor.
        let apparent_shift_mm = station.as_ref().map_or(0.0, Station::apparent_shift_mm);
        let centre = centre - rotation * DVec3::Z * apparent_shift_mm;
        let sensor = Sensor::place(given.size_mm, given.pixels, rotation, centre)?;
        let mut findings = Vec::new();
        let distribution = model.distribution()?;
        if distribution.intensity_cd().iter().any(|value| *value < 0.0) {
            findings.push("the distribution has values below zero; rays carry none of them".to_owned());
        }
        let source = source(scene, &distribution);
        refuse_impossible(&source, &sensor)?;
        range(&distribution, &sensor, &mut findings)?;
        if apparent_shift_mm > 0.0 {
            widest(&sensor, apparent_shift_mm, &mut findings);
        }
        let hall = match (given.background_w_m2, ler_lm_per_w) {
            (0.0, _) => 0.0,
            (background, Some(ler)) => background * ler,
            (background_w_m2, None) => return Err(SetupError::Background { background_w_m2 }),
        };
        let effects = model.background_lx().ok_or(SetupError::Background {
            background_w_m2: f64::NAN,
        })?;
        // Beer–Lambert: one coefficient serves every length.
        let path = model.path_factor(1000.0);
        let extinction_per_mm = if path > 0.0 { -path.ln() / 1000.0 } else { f64::INFINITY };
        let mut pixel_factor = pixel_factor(scene, &sensor);
        if let Some(station) = &station {
            let mut factors = station.factors(&sensor);
            if let Some(effects) = &pixel_factor {
                factors
                    .iter_mut()
                    .zip(effects)
                    .for_each(|(factor, effect)| *factor *= effect);
            }
            pixel_factor = Some(factors);
        }
        Ok(Self {
            source: source.in_medium(extinction_per_mm),
            sensor,
            lamp: model.lamp_factor(given.time_s),
            pixel_factor,
            background_lx: hall + effects,
            blur_px: model.blur_px(),
            ler_lm_per_w,
            station,
            findings,
        })
    }
}

/// A finding where the refraction in plates is no longer that of light near the normal: its shift grows with the angle.
fn widest(sensor: &Sensor, apparent_shift_mm: f64, findings: &mut Vec<String>) {
    let (nx, ny) = (sensor.nx as f64, sensor.ny as f64);
    let cosine = [[0.0, 0.0], [nx, 0.0], [nx, ny], [0.0, ny]]
        .map(|[x, y]| sensor.point(x, y))
        .iter()
        .map(|place| place.dot(sensor.toward) / place.length())
        .fold(1.0_f64, f64::min);
    // With n = 1.5 the shift at angle θ is larger than on the axis by about 0.67·sin²θ; E follows twice the
    // relative shift of distance.
    let error = 2.0 * 0.67 * (1.0 - cosine * cosine) * apparent_shift_mm / sensor.centre().length();
    if error > 1e-4 {
        findings.push(format!(
            "the windows' shift of {apparent_shift_mm:.3} mm is that of light near their normal; at the corners, {:.1}° from it, the map may be low by {:.2} %",
            cosine.clamp(-1.0, 1.0).acos().to_degrees(),
            100.0 * error
        ));
    }
}

/// Nodes over an area, in each direction, whose parts give unequally.
const UNEQUAL_NODES: usize = 6;

/// The parts of the model's emitter.
fn source(scene: &Scene, distribution: &IntensityDistribution) -> LightSource {
    let model = &scene.model;
    let emitter = model.emitter();
    if let Some(sectors) = model.sectors().filter(|_| emitter.extent_mm() > 0.0) {
        return unequal(model, &emitter, &sectors, distribution);
    }
    let table = Arc::new(IntensityTable::new(distribution));
    let centre = DVec3::ZERO;
    match &emitter {
        Emitter::Point {} | Emitter::Disc { diameter_mm: 0.0 } | Emitter::Rectangle { size_mm: [0.0, 0.0] } => {
            LightSource::single(table, Shape::Point(centre))
        }
        Emitter::Disc { diameter_mm } => LightSource::single(
            table,
            Shape::Disc {
                centre,
                radius: 0.5 * diameter_mm,
            },
        ),
        Emitter::Ring {
            inner_diameter_mm,
            outer_diameter_mm,
        } => LightSource::single(
            table,
            Shape::Ring {
                centre,
                inner: 0.5 * inner_diameter_mm,
                outer: 0.5 * outer_diameter_mm,
            },
        ),
        Emitter::Rectangle { size_mm: [x, y] } => LightSource::single(
            table,
            Shape::Rectangle {
                centre,
                half: [0.5 * x, 0.5 * y],
            },
        ),
        Emitter::Leds { .. } => {
            let lobe = model.lobe();
            let parts = emitter.nodes(1).into_iter().map(|node| {
                let table = match &lobe {
                    Some(lobe) => Arc::new(IntensityTable::new(&shared(distribution, |to| {
                        lobe.share(node.axis, to)
                    }))),
                    None => Arc::clone(&table),
                };
                Part {
                    share: node.weight,
                    shape: Shape::Point(node.position_mm),
                    table,
                    aim: None,
                }
            });
            LightSource::new(parts.collect())
        }
    }
}

/// The parts of an emitter some of which give less. `distribution` has the loss of the far field: LEDs, whose axes are
/// known, carry the whole far field each by its own; the nodes of an area carry what is left, so unequally that their
/// middle moves as far as that of the ring which stands for LEDs.
fn unequal(model: &Model, emitter: &Emitter, sectors: &Sectors, distribution: &IntensityDistribution) -> LightSource {
    let leds = matches!(emitter, Emitter::Leds { .. });
    let mut nodes = emitter.nodes(UNEQUAL_NODES);
    let given_at = |node: &Node| model.given_at(angles_deg(node.position_mm).0);
    let distance = |node: &Node| node.weight * node.position_mm.truncate().length();
    let given: f64 = nodes.iter().map(|node| node.weight * given_at(node)).sum();
    let farther = if leds {
        1.0
    } else {
        sectors.radius_mm() / nodes.iter().map(distance).sum::<f64>()
    };
    for node in &mut nodes {
        node.weight *= (1.0 + farther * (given_at(node) / given - 1.0)).max(0.0);
    }
    let lobe = model.lobe();
    let table = Arc::new(IntensityTable::new(distribution));
    let part = |node: Node| {
        let whole = |to: DVec3| {
            let left = sectors.left_towards(to);
            if left > 0.0 { given / left } else { 0.0 }
        };
        let share = |to: DVec3| lobe.as_ref().map_or(1.0, |lobe| lobe.share(node.axis, to)) * whole(to);
        Part {
            share: node.weight,
            shape: Shape::Point(node.position_mm),
            table: if leds {
                Arc::new(IntensityTable::new(&shared(distribution, share)))
            } else {
                Arc::clone(&table)
            },
            aim: None,
        }
    };
    LightSource::new(nodes.into_iter().map(part).collect())
}

/// The distribution times a smooth share, on a grid fine enough for it.
fn shared(distribution: &IntensityDistribution, share: impl Fn(DVec3) -> f64) -> IntensityDistribution {
    let fill = |grid: &[f64], end: f64, step: f64| -> Vec<f64> {
        let mut out = Vec::new();
        for (k, &from) in grid.iter().enumerate() {
            let to = grid.get(k + 1).copied().unwrap_or(end);
            let parts = ((to - from) / step).ceil().max(1.0);
            out.extend((0..parts as usize).map(|part| from + (to - from) * part as f64 / parts));
        }
        out.dedup();
        out
    };
    let gamma = distribution.gamma_deg();
    let last = gamma[gamma.len() - 1];
    let gamma_deg = fill(gamma, last, 1.0);
    let c_deg = fill(distribution.c_deg(), distribution.c_deg()[0] + 360.0, 5.0);
    let mut intensity_cd = Vec::with_capacity(c_deg.len() * gamma_deg.len());
    for c in &c_deg {
        for g in &gamma_deg {
            intensity_cd.push(distribution.intensity_cd_at(*c, *g) * share(direction(*c, *g)));
        }
    }
    // The grid rises as the file's does, and shares are finite.
    IntensityDistribution::new(c_deg, gamma_deg, intensity_cd).unwrap_or_else(|_| distribution.clone())
}

/// A face that looks away, or a sensor in the emitter.
fn refuse_impossible(source: &LightSource, sensor: &Sensor) -> Result<(), SetupError> {
    let mut illuminated = false;
    for part in source.parts() {
        let (centre, radius) = (part.shape.centre(), part.shape.radius());
        let height = (sensor.corner - centre).dot(sensor.toward);
        let slope = (1.0 - sensor.toward.z * sensor.toward.z).max(0.0).sqrt();
        illuminated |= height + radius * slope > 0.0;
        let distance = nearest(sensor, centre);
        if distance <= radius * (1.0 + 1e-9) && height.abs() <= radius * slope + 1e-9 || distance < 1e-6 {
            return Err(SetupError::Through {
                distance_mm: distance,
                radius_mm: radius,
            });
        }
    }
    if illuminated {
        return Ok(());
    }
    let cosine = sensor.toward.dot(sensor.centre().normalize_or(DVec3::Z));
    Err(SetupError::Behind {
        angle_deg: cosine.clamp(-1.0, 1.0).acos().to_degrees(),
    })
}

/// Distance in mm from a point to the sensor's rectangle.
fn nearest(sensor: &Sensor, point: DVec3) -> f64 {
    let away = point - sensor.corner;
    let along = |step: DVec3, pixels: usize| (away.dot(step) / step.length_squared()).clamp(0.0, pixels as f64);
    let at = sensor.point(along(sensor.step_x, sensor.nx), along(sensor.step_y, sensor.ny));
    (point - at).length()
}

/// Points along each side of the sensor that are looked at.
const SIDE: usize = 65;

/// An error where the whole sensor lies beyond the distribution's γ, a finding where part of it does.
fn range(distribution: &IntensityDistribution, sensor: &Sensor, findings: &mut Vec<String>) -> Result<(), SetupError> {
    let gamma = distribution.gamma_deg();
    let (first_deg, last_deg) = (gamma[0], gamma[gamma.len() - 1]);
    let (mut from_deg, mut to_deg, mut outside) = (180.0_f64, 0.0_f64, 0);
    for iy in 0..SIDE {
        for ix in 0..SIDE {
            let share = |k: usize, pixels: usize| k as f64 / (SIDE - 1) as f64 * pixels as f64;
            let at = sensor.point(share(ix, sensor.nx), share(iy, sensor.ny));
            let gamma = at.x.hypot(at.y).atan2(at.z).to_degrees();
            from_deg = from_deg.min(gamma);
            to_deg = to_deg.max(gamma);
            outside += usize::from(gamma > last_deg || gamma < first_deg);
        }
    }
    if outside == SIDE * SIDE {
        return Err(SetupError::Outside {
            first_deg,
            last_deg,
            from_deg,
            to_deg,
        });
    }
    if outside > 0 {
        let share = 100.0 * outside as f64 / (SIDE * SIDE) as f64;
        findings.push(format!(
            "about {share:.1} % of the sensor lies outside the distribution's γ range ({first_deg}° to {last_deg}°) and is dark"
        ));
    }
    Ok(())
}

/// Factor of the sensor's effects, mean over 2 × 2 Gauss points of each pixel.
fn pixel_factor(scene: &Scene, sensor: &Sensor) -> Option<Vec<f64>> {
    if scene.model.effects().is_empty() {
        return None;
    }
    let in_watts = scene.model.ler_lm_per_w().is_some();
    let [width, height] = scene.sensor.size_mm;
    let (pitch_x, pitch_y) = (width / sensor.nx as f64, height / sensor.ny as f64);
    let at = |x: f64, y: f64| {
        let place = sensor.point(x, y);
        let watts = if in_watts {
            scene.model.watts_of_a_lumen(place.z / place.length())
        } else {
            1.0
        };
        watts
            * scene.model.pixel_factor(&Pixel {
                x_mm: x * pitch_x - 0.5 * width,
                y_mm: y * pitch_y - 0.5 * height,
                half_width_mm: 0.5 * width,
                cos_incidence: place.dot(sensor.toward) / place.length(),
            })
    };
    let (nx, ny) = (sensor.nx as f64, sensor.ny as f64);
    if [
        at(0.0, 0.0),
        at(nx, 0.31 * ny),
        at(0.4 * nx, ny),
        at(0.7 * nx, 0.2 * ny),
    ]
    .iter()
    .all(|factor| *factor == 1.0)
    {
        return None;
    }
    let g = 0.5 / 3.0_f64.sqrt();
    let factors = (0..sensor.pixels())
        .map(|index| {
            let (x, y) = ((index % sensor.nx) as f64 + 0.5, (index / sensor.nx) as f64 + 0.5);
            0.25 * (at(x - g, y - g) + at(x + g, y - g) + at(x - g, y + g) + at(x + g, y + g))
        })
        .collect();
    Some(factors)
}
