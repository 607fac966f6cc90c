//! The exposures that a capture makes: of a scene, or those of a `maps.toml`.

use std::ops::RangeInclusive;

use camino::Utf8Path;
use isolux_darkroom::{MapPose, SensorFrame};
use isolux_record::document::bounds::within;
use isolux_record::document::{SourceText, read_text};
use isolux_record::observation::{MapSet, Need, OneOrTwo};
use serde::Deserialize;

use crate::Failure;
use crate::files::Overwrite;
use crate::front_end::progress::{Event, Progress};

/// What is wanted of a capture.
#[derive(Debug, Clone, PartialEq)]
pub struct Options {
    /// Unit of the maps.
    pub unit: CaptureUnit,
    /// Bins along x and y; none: as many as the scene's pixels, at most 64.
    pub bins: Option<[usize; 2]>,
    /// Which exposures to make of a scene.
    pub series: Series,
    /// Relative exposure of the scene's own pose.
    pub exposure: f64,
    /// Whether existing files may be replaced.
    pub overwrite: Overwrite,
}

/// Unit of the recorded maps.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum CaptureUnit {
    /// Relative to the camera's full scale, proportional to the exposure.
    Relative,
    /// Illuminance.
    Lux,
    /// Irradiance.
    WattPerSquareMetre,
}

/// Exposures made of one scene.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Series {
    /// The scene's pose with lamp, cap as given.
    Single {
        /// The lamp is on.
        lamp: bool,
        /// The sensor is capped.
        capped: bool,
    },
    /// The series that tells most effects apart: two exposures, three distances, two tilts, a quarter turn, lamp off,
    /// capped.
    Designed,
}

/// A scene as far as a camera needs it; what the operator believes of the lamp is not looked at.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct SceneDocument {
    #[serde(rename = "format")]
    _format: String,
    #[serde(rename = "model")]
    _model: Option<String>,
    #[serde(rename = "luminaire")]
    _luminaire: Option<toml::Table>,
    #[serde(rename = "noise")]
    _noise: Option<toml::Table>,
    #[serde(default, rename = "effect")]
    _effect: Vec<toml::Table>,
    sensor: SensorDocument,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct SensorDocument {
    size_mm: OneOrTwo<f64>,
    pixels: OneOrTwo<usize>,
    distance_mm: f64,
    #[serde(default)]
    tilt_x_deg: f64,
    #[serde(default)]
    tilt_y_deg: f64,
    #[serde(default)]
    rot_z_deg: f64,
    #[serde(default)]
    offset_mm: [f64; 2],
    time_s: Option<f64>,
    #[serde(rename = "responsivity")]
    _responsivity: Option<String>,
    #[serde(default)]
    background_w_m2: f64,
}

/// A named exposure.
pub struct Shot {
    pub name: String,
    pub pose: MapPose,
    pub held_out: bool,
}

pub fn shots(
    scene: &Utf8Path,
    options: &Options,
    progress: &dyn Progress,
) -> Result<(SensorFrame, Vec<Shot>, CaptureUnit), Failure> {
    let text = read_text(scene).map_err(Failure::bad_input)?;
    let is_scene = toml::from_str::<toml::Table>(&text).is_ok_and(|table| table.contains_key("format"));
    if is_scene || !text.contains("[[map]]") {
        let (frame, shots) = of_scene(
            SourceText {
                file: scene,
                text: &text,
            },
            options,
            progress,
        )?;
        return Ok((frame, shots, options.unit));
    }
    let maps = MapSet::open(scene, Need::Coordinates).map_err(Failure::bad_input)?;
    let shots = maps
        .maps()
        .iter()
        .map(|map| Shot {
            name: map.name.clone(),
            pose: MapPose {
                distance_mm: map.distance_mm,
                tilt_x_deg: map.tilt_x_deg,
                tilt_y_deg: map.tilt_y_deg,
                rot_z_deg: map.rot_z_deg,
                offset_mm: map.offset_mm,
                exposure: map.exposure,
                lamp: map.lamp,
                capped: map.capped,
                time_s: map.time_s,
            },
            held_out: map.held_out,
        })
        .collect();
    let unit = match maps.unit() {
        isolux_record::observation::MapUnit::Relative => CaptureUnit::Relative,
        isolux_record::observation::MapUnit::Lux => CaptureUnit::Lux,
        isolux_record::observation::MapUnit::WattPerSquareMetre => CaptureUnit::WattPerSquareMetre,
    };
    let frame = SensorFrame {
        size_mm: maps.sensor_mm(),
        bins: options.bins.unwrap_or_else(|| maps.bins()),
    };
    Ok((frame, shots, unit))
}

fn of_scene(
    source: SourceText<'_>,
    options: &Options,
    progress: &dyn Progress,
) -> Result<(SensorFrame, Vec<Shot>), Failure> {
    let document: SceneDocument = source.parse("isolux-scene/1").map_err(Failure::bad_input)?;
    let sensor = &document.sensor;
    let (size_mm, pixels) = (sensor.size_mm.both(), sensor.pixels.both());
    let inside = |key: &str, value: Option<f64>, range: RangeInclusive<f64>, unit: &str| {
        within(&format!("sensor.{key}"), value, range, unit).map_err(|fault| Failure::bad_input(source.locate(&fault)))
    };
    for (size_mm, pixels) in size_mm.into_iter().zip(pixels) {
        inside("size_mm", Some(size_mm), 1e-4..=1e5, " mm")?;
        inside("pixels", Some(pixels as f64), 1.0..=1e6, "")?;
    }
    inside("distance_mm", Some(sensor.distance_mm), 1e-3..=1e6, " mm")?;
    for (key, angle_deg) in [
        ("tilt_x_deg", sensor.tilt_x_deg),
        ("tilt_y_deg", sensor.tilt_y_deg),
        ("rot_z_deg", sensor.rot_z_deg),
    ] {
        inside(key, Some(angle_deg), -360.0..=360.0, "°")?;
    }
    for offset_mm in sensor.offset_mm {
        inside("offset_mm", Some(offset_mm), -1e6..=1e6, " mm")?;
    }
    inside("time_s", sensor.time_s, 0.0..=1e9, " s")?;
    within("--exposure", options.exposure, 1e-9..=1e9, "").map_err(Failure::bad_input)?;
    if sensor.background_w_m2 != 0.0 {
        progress.event(Event::Note(
            "background_w_m2 of the scene is what the simulation assumes; the camera sees the room's own ambient_light",
        ));
    }
    let pose = MapPose {
        distance_mm: sensor.distance_mm,
        tilt_x_deg: sensor.tilt_x_deg,
        tilt_y_deg: sensor.tilt_y_deg,
        rot_z_deg: sensor.rot_z_deg,
        offset_mm: sensor.offset_mm,
        exposure: options.exposure,
        lamp: true,
        capped: false,
        time_s: sensor.time_s,
    };
    let bins = options.bins.unwrap_or_else(|| pixels.map(|count| count.min(64)));
    let shots = match options.series {
        Series::Single { lamp, capped } => {
            vec![Shot {
                name: "scene".to_owned(),
                pose: MapPose { lamp, capped, ..pose },
                held_out: false,
            }]
        }
        Series::Designed => designed(&pose),
    };
    Ok((SensorFrame { size_mm, bins }, shots))
}

/// Nine exposures about `pose`; nearer ones are exposed less, as the square of the distance.
fn designed(pose: &MapPose) -> Vec<Shot> {
    let nearer = |share: f64| MapPose {
        distance_mm: share * pose.distance_mm,
        exposure: share * share * pose.exposure,
        ..pose.clone()
    };
    let middle = nearer(0.6);
    [
        ("full", pose.clone()),
        (
            "half",
            MapPose {
                exposure: 0.5 * pose.exposure,
                ..pose.clone()
            },
        ),
        ("near", middle.clone()),
        ("nearest", nearer(0.3)),
        (
            "tilt_x",
            MapPose {
                tilt_x_deg: pose.tilt_x_deg + 40.0,
                ..middle.clone()
            },
        ),
        (
            "tilt_y",
            MapPose {
                tilt_y_deg: pose.tilt_y_deg - 40.0,
                ..middle.clone()
            },
        ),
        (
            "turned",
            MapPose {
                rot_z_deg: pose.rot_z_deg + 90.0,
                ..middle
            },
        ),
        (
            "lamp_off",
            MapPose {
                lamp: false,
                ..pose.clone()
            },
        ),
        (
            "capped",
            MapPose {
                capped: true,
                ..pose.clone()
            },
        ),
    ]
    .map(|(name, pose)| Shot {
        name: name.to_owned(),
        pose,
        held_out: false,
    })
    .into()
}
