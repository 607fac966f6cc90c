//! `scene.toml`: a model and a sensor before it.

use std::f64::consts::TAU;

use camino::{Utf8Path, Utf8PathBuf};
use glam::{DVec2, DVec3};
use isolux_photometry::polar_deg;
use isolux_record::document::{DocumentError, SourceText, read_text};

use crate::document::{Accuracy, SCENE_FORMAT, SceneDocument, effect_from_table};
use crate::model::Model;
use crate::optics::{self, Optics, Tables};
use crate::pose::SensorPose;
use crate::reader::Reader;

/// Most pixels of a sensor: a map of this size and what is computed beside it takes about 10 GB.
const MOST_PIXELS: usize = 400_000_000;

/// A flat sensor of equal pixels.
#[derive(Debug, Clone, PartialEq)]
pub struct Sensor {
    /// Width and height.
    pub size_mm: [f64; 2],
    /// Pixels along x and y.
    pub pixels: [usize; 2],
    /// Where it stands.
    pub pose: SensorPose,
    /// Seconds since the lamp was switched on; without it warm-up is complete.
    pub time_s: Option<f64>,
    /// File of `wavelength_nm,qe`, where it is.
    pub responsivity: Option<Utf8PathBuf>,
    /// Uniform hall light on the sensor.
    pub background_w_m2: f64,
}

impl Sensor {
    /// Centre of pixel (ix, iy) in the sensor's own axes.
    pub fn pixel_centre_mm(&self, ix: usize, iy: usize) -> DVec2 {
        let at = |index: usize, axis: usize| {
            let pitch = self.size_mm[axis] / self.pixels[axis] as f64;
            (index as f64 + 0.5) * pitch - self.size_mm[axis] / 2.0
        };
        DVec2::new(at(ix, 0), at(iy, 1))
    }
}

/// A model and a sensor.
#[derive(Debug, Clone)]
pub struct Scene {
    /// The luminaire and its effects.
    pub model: Model,
    /// The sensor.
    pub sensor: Sensor,
    /// What stands beside the direct path.
    pub optics: Optics,
    /// How the inverse method computes it.
    pub accuracy: Accuracy,
}

/// Points of the rim of an emitter, and along each edge of a sensor, between which rays are drawn.
const RIM: usize = 24;
const EDGE: usize = 5;

impl Scene {
    /// The smallest and the largest γ of the rays from the emitter, as a disc of its extent, to the sensor: to 25
    /// places of it, its edges among them. Degrees.
    pub fn gamma_range_deg(&self) -> [f64; 2] {
        let radius_mm = self.model.emitter().extent_mm();
        let along = |k: usize, size: f64| (k as f64 / (EDGE - 1) as f64 - 0.5) * size;
        let [width, height] = self.sensor.size_mm;
        let places = (0..EDGE * EDGE).map(|k| DVec2::new(along(k % EDGE, width), along(k / EDGE, height)));
        let rays = places.flat_map(|place| {
            let to = self.sensor.pose.lamp_from_sensor(place);
            let rim = (0..RIM).map(move |k| {
                let (sin, cos) = (TAU * k as f64 / RIM as f64).sin_cos();
                to - DVec3::new(radius_mm * cos, radius_mm * sin, 0.0)
            });
            rim.chain(std::iter::once(to))
        });
        rays.map(polar_deg).fold([180.0, 0.0], |[low, high], gamma: f64| {
            [low.min(gamma), high.max(gamma)]
        })
    }

    /// The scene of a `scene.toml`, with its model from the file that it names or from its own `[luminaire]`.
    ///
    /// # Errors
    /// [`DocumentError`] with file and line of the first thing that is wrong.
    pub fn load(path: &Utf8Path) -> Result<Self, DocumentError> {
        Self::parse(path, &read_text(path)?)
    }

    /// The scene of `text`, which stands or would stand at `path`.
    ///
    /// # Errors
    /// As [`Scene::load`].
    pub fn parse(path: &Utf8Path, text: &str) -> Result<Self, DocumentError> {
        Self::build(SourceText { file: path, text }, None)
    }

    /// The same scene with `model` in place of the model or luminaire that it names, which need not be there.
    ///
    /// # Errors
    /// As [`Scene::load`].
    pub fn parse_with(path: &Utf8Path, text: &str, model: &Model) -> Result<Self, DocumentError> {
        Self::build(SourceText { file: path, text }, Some(model))
    }

    fn build(source: SourceText<'_>, model: Option<&Model>) -> Result<Self, DocumentError> {
        let document: SceneDocument = source.parse(SCENE_FORMAT)?;
        let reader = Reader { source };
        let model = lit_by(&reader, &document, model)?;
        let given = &document.sensor;
        let size_mm = given.size_mm.both();
        let pixels = given.pixels.both();
        let within =
            |key: &str, value: f64, low: f64, high: f64| reader.within(&format!("sensor.{key}"), value, low, high);
        for (size_mm, pixels) in size_mm.into_iter().zip(pixels) {
            within("size_mm", size_mm, 1e-4, 1e5)?;
            within("pixels", pixels as f64, 1.0, MOST_PIXELS as f64)?;
        }
        if pixels[0].saturating_mul(pixels[1]) > MOST_PIXELS {
            let message = format!(
                "{} × {} pixels; at most {MOST_PIXELS} fit into memory",
                pixels[0], pixels[1]
            );
            return Err(reader.fault("sensor.pixels", &message));
        }
        within("distance_mm", given.distance_mm, 1e-3, 1e6)?;
        let [x, y] = given.offset_mm;
        for (key, value, low, high) in [
            ("tilt_x_deg", given.tilt_x_deg, -360.0, 360.0),
            ("tilt_y_deg", given.tilt_y_deg, -360.0, 360.0),
            ("rot_z_deg", given.rot_z_deg, -360.0, 360.0),
            ("offset_mm", x, -1e6, 1e6),
            ("offset_mm", y, -1e6, 1e6),
            ("time_s", given.time_s.unwrap_or(0.0), 0.0, 1e9),
            ("background_w_m2", given.background_w_m2, 0.0, 1e6),
        ] {
            within(key, value, low, high)?;
        }
        let pose = SensorPose {
            tilt_x_deg: given.tilt_x_deg,
            tilt_y_deg: given.tilt_y_deg,
            rot_z_deg: given.rot_z_deg,
            offset_mm: DVec2::new(x, y),
            ..SensorPose::facing(given.distance_mm)
        };
        let responsivity = match &given.responsivity {
            Some(file) => {
                // Electrons are counted at the end; a file that is not there is said at the beginning.
                reader.spectrum("sensor.responsivity", file)?;
                Some(reader.path(file))
            }
            None => None,
        };
        let tables = Tables {
            window: &document.window,
            vapour: document.vapour.as_ref(),
            target: document.target.as_ref(),
            lens: document.lens,
            colour: &document.colour,
            camera: given.camera,
        };
        let mut optics = optics::read(source, &tables)?;
        optics.colour = optics.colour.or_else(|| model.colour().cloned());
        if optics.camera.is_some() && responsivity.is_none() {
            return Err(reader.fault(
                "sensor.camera",
                "electrons need sensor.responsivity, a file of wavelength_nm,qe",
            ));
        }
        let (time_s, background_w_m2) = (given.time_s, given.background_w_m2);
        Ok(Self {
            model,
            sensor: Sensor {
                size_mm,
                pixels,
                pose,
                time_s,
                responsivity,
                background_w_m2,
            },
            optics,
            accuracy: document.simulation.accuracy,
        })
    }
}

/// The model that a scene is lit by: `model`, or the one that its file names, or its own luminaire.
fn lit_by(reader: &Reader<'_>, document: &SceneDocument, model: Option<&Model>) -> Result<Model, DocumentError> {
    let loaded;
    let model = match (model, &document.model, &document.luminaire) {
        (Some(model), ..) => model,
        (None, Some(file), None) => {
            let path = reader.path(file);
            loaded = Model::load(&path).map_err(|error| {
                // What is wrong inside a model has its own place; a model that is not there is this scene's fault.
                if path.is_file() {
                    error
                } else {
                    reader.fault("model", &error.to_string())
                }
            })?;
            &loaded
        }
        (None, None, Some(luminaire)) => {
            return Model::build(reader.source, luminaire.clone(), document.noise, &document.effect);
        }
        (None, Some(_), Some(_)) => return Err(reader.fault("luminaire", "give either model or [luminaire], not both")),
        (None, None, None) => {
            return Err(reader.fault("model", "a scene needs model = \"…\" or a [luminaire] of its own"));
        }
    };
    let mut effects = model.effects().to_vec();
    let of_model = effects.len();
    for (index, table) in document.effect.iter().enumerate() {
        let effect = effect_from_table(table)
            .map_err(|wrong| reader.fault(&format!("effect.{index}.{}", wrong.key), &wrong.message))?;
        effects.push(effect);
    }
    let model = model.with_effects(effects);
    model
        .refuse_two_emitters()
        .map_err(|(index, message)| reader.fault(&format!("effect.{}", index.saturating_sub(of_model)), &message))?;
    Ok(model)
}
