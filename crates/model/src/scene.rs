//! `scene.toml`: a model and a sensor before it.

use camino::{Utf8Path, Utf8PathBuf};
use glam::DVec2;
use isolux_record::document::{Fault, Source, read_text};

use crate::document::{Precision, SCENE_FORMAT, SceneDocument, effect_from_table};
use crate::model::{Model, ModelError};
use crate::optics::{self, Optics, Tables};
use crate::pose::SensorPose;

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
    pub precision: Precision,
}

impl Scene {
    /// The scene of a `scene.toml`, with its model from the file that it names or from its own `[luminaire]`.
    ///
    /// # Errors
    /// [`ModelError`] with file and line of the first thing that is wrong.
    pub fn load(path: &Utf8Path) -> Result<Self, ModelError> {
        Self::parse(path, &read_text(path)?)
    }

    /// The scene of `text`, which stands or would stand at `path`.
    ///
    /// # Errors
    /// As [`Scene::load`].
    pub fn parse(path: &Utf8Path, text: &str) -> Result<Self, ModelError> {
        let source = Source { file: path, text };
        let document: SceneDocument = source.parse(SCENE_FORMAT)?;
        let fault = |path: &str, message: &str| {
            ModelError::from(source.locate(&Fault {
                path: path.to_owned(),
                message: message.to_owned(),
            }))
        };
        let model = match (&document.model, document.luminaire.clone()) {
            (Some(file), None) => {
                let model = Model::load(&path.parent().unwrap_or(Utf8Path::new("")).join(file))?;
                let mut effects = model.effects().to_vec();
                for (index, table) in document.effect.iter().enumerate() {
                    let effect = effect_from_table(table)
                        .map_err(|wrong| fault(&format!("effect.{index}.{}", wrong.key), &wrong.message))?;
                    effects.push(effect);
                }
                model.with_effects(effects)
            }
            (None, Some(luminaire)) => Model::build(source, luminaire, document.noise, &document.effect)?,
            (Some(_), Some(_)) => return Err(fault("luminaire", "give either model or [luminaire], not both")),
            (None, None) => {
                return Err(fault(
                    "model",
                    "a scene needs model = \"…\" or a [luminaire] of its own",
                ));
            }
        };
        let given = &document.sensor;
        let size_mm = given.size_mm.both();
        let pixels = given.pixels.both();
        let positive = |key: &str, value: f64| {
            if value.is_finite() && value > 0.0 {
                Ok(())
            } else {
                Err(fault(
                    &format!("sensor.{key}"),
                    &format!("{value} must be finite and above zero"),
                ))
            }
        };
        positive("size_mm", size_mm[0].min(size_mm[1]))?;
        positive("pixels", pixels[0].min(pixels[1]) as f64)?;
        positive("distance_mm", given.distance_mm)?;
        let [x, y] = given.offset_mm;
        for (key, value) in [
            ("tilt_x_deg", given.tilt_x_deg),
            ("tilt_y_deg", given.tilt_y_deg),
            ("rot_z_deg", given.rot_z_deg),
            ("offset_mm", x + y),
            ("time_s", given.time_s.unwrap_or(0.0)),
            ("background_w_m2", given.background_w_m2),
        ] {
            if !value.is_finite() {
                return Err(fault(&format!("sensor.{key}"), "must be finite"));
            }
        }
        let pose = SensorPose {
            tilt_x_deg: given.tilt_x_deg,
            tilt_y_deg: given.tilt_y_deg,
            rot_z_deg: given.rot_z_deg,
            offset_mm: DVec2::new(x, y),
            ..SensorPose::facing(given.distance_mm)
        };
        let responsivity = given
            .responsivity
            .as_ref()
            .map(|file| path.parent().unwrap_or(Utf8Path::new("")).join(file));
        let tables = Tables {
            window: &document.window,
            vapour: document.vapour.as_ref(),
            target: document.target.as_ref(),
            lens: document.lens,
            colour: &document.colour,
            camera: given.camera,
        };
        let optics = optics::read(source, &tables)?;
        if optics.camera.is_some() && responsivity.is_none() {
            return Err(fault(
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
            precision: document.simulation.precision,
        })
    }
}
