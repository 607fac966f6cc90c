//! `virtual capture`: what a camera in the virtual darkroom records.

use std::fmt::Write as _;

use camino::Utf8Path;
use isolux_darkroom::camera::Unit;
use isolux_darkroom::{Darkroom, MapPose, Room, SensorFrame};
use isolux_record::document::{Fault, Source, read_text};
use isolux_record::observation::{MapSet, Need, OneOrTwo};
use serde::Deserialize;

use crate::Failure;
use crate::files::{self, Overwrite};
use crate::progress::{Event, Pace, Progress};

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

/// What was recorded.
#[derive(Debug, Clone, PartialEq)]
pub struct Captured {
    /// Names of the maps.
    pub maps: Vec<String>,
    /// Bins along x and y.
    pub bins: [usize; 2],
    /// Unit as the file names it.
    pub unit: &'static str,
    /// Mean signal of each map.
    pub mean: Vec<f64>,
}

/// Bins that one map may have: a file of values for people and programs, not an image archive.
const MOST_BINS: usize = 1024;

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
struct Shot {
    name: String,
    pose: MapPose,
    held_out: bool,
}

/// Records `scene` (a scene, or a `maps.toml` whose poses are taken) in the room of `darkroom`, as `out` and a CSV
/// beside it.
///
/// # Errors
/// Bad input (exit 2) with file and line; exit 3 when the disk refuses.
pub fn capture(
    darkroom: &Utf8Path,
    scene: &Utf8Path,
    out: &Utf8Path,
    options: &Options,
    progress: &dyn Progress,
) -> Result<Captured, Failure> {
    let values = out.with_extension("csv");
    files::refuse_existing(out, options.overwrite)?;
    files::refuse_existing(&values, options.overwrite)?;
    if out == values {
        return Err(Failure::bad_input(format!(
            "{out}: the maps' poses go to a .toml, their values to a .csv beside it"
        ))
        .help("give --out maps.toml"));
    }
    let room = Room::new(document(darkroom, progress)?);
    let (frame, shots, unit) = shots(scene, options, progress)?;
    if frame.bins.iter().any(|bins| *bins > MOST_BINS) {
        let message = format!(
            "{} × {} bins are more than {MOST_BINS} a side",
            frame.bins[0], frame.bins[1]
        );
        return Err(Failure::bad_input(message).help("give fewer with --bins; a bin is the mean over its area"));
    }
    progress.event(Event::Began {
        step: "capture",
        total: Some(shots.len() as u64),
    });
    let darkroom_unit = match unit {
        CaptureUnit::Relative => Unit::Relative,
        CaptureUnit::Lux => Unit::Lux,
        CaptureUnit::WattPerSquareMetre => Unit::WattPerSquareMetre,
    };
    let mut table = csv::Writer::from_writer(Vec::new());
    table
        .write_record(["map", "iy", "ix", "signal", "u"])
        .map_err(Failure::instrument)?;
    let mut mean = Vec::new();
    let pace = Pace::of(shots.len());
    for (number, shot) in shots.iter().enumerate() {
        progress.event(Event::At {
            done: number as u64,
            what: &pace.words(&shot.name, number),
        });
        let map = room.capture(&frame, &shot.pose, darkroom_unit, number as u64);
        for (bin, (signal, u)) in map.signal.iter().zip(&map.u).enumerate() {
            let (iy, ix) = (bin / frame.bins[0], bin % frame.bins[0]);
            let (signal, u) = (significant(*signal, 8), significant(*u, 5));
            let numbers = [iy.to_string(), ix.to_string(), signal.to_string(), u.to_string()];
            let row = std::iter::once(shot.name.as_str()).chain(numbers.iter().map(String::as_str));
            table.write_record(row).map_err(Failure::instrument)?;
        }
        mean.push(map.signal.iter().sum::<f64>() / map.signal.len() as f64);
    }
    progress.event(Event::Ended(&format!(
        "{} maps of {} × {} bins",
        shots.len(),
        frame.bins[0],
        frame.bins[1]
    )));
    let full_scale = match unit {
        CaptureUnit::Relative => Some(1.0),
        CaptureUnit::Lux => Some(room.document().camera.full_scale_lx),
        CaptureUnit::WattPerSquareMetre => Some(room.document().camera.full_scale_lx * room.spectrum().watt_per_lux()),
    };
    let table = table.into_inner().map_err(Failure::instrument)?;
    files::write(&values, &table, options.overwrite)?;
    files::write(
        out,
        poses(&frame, unit, full_scale, &shots).as_bytes(),
        options.overwrite,
    )?;
    Ok(Captured {
        maps: shots.into_iter().map(|shot| shot.name).collect(),
        bins: frame.bins,
        unit: name_of(unit),
        mean,
    })
}

/// Reads a `darkroom.toml`, and says which keys the built-in room completed.
///
/// # Errors
/// Bad input (exit 2) with file and line.
pub fn document(path: &Utf8Path, progress: &dyn Progress) -> Result<Darkroom, Failure> {
    let text = read_text(path).map_err(Failure::bad_input)?;
    // A value of a wrong type is told in words first.
    if let Err(error) = toml::from_str::<Darkroom>(&text) {
        let source = Source {
            file: path,
            text: &text,
        };
        return Err(Failure::bad_input(source.toml_error(&error)));
    }
    let (room, completed) = Darkroom::complete(&text).map_err(|error| match error.line {
        Some(line) => Failure::bad_input(format!("{path}:{line}: {}", error.message)),
        None => Failure::bad_input(format!("{path}: {}", error.message)),
    })?;
    if !completed.is_empty() {
        progress.event(Event::Note(&format!("{path}: {completed}")));
    }
    Ok(room)
}

fn shots(
    scene: &Utf8Path,
    options: &Options,
    progress: &dyn Progress,
) -> Result<(SensorFrame, Vec<Shot>, CaptureUnit), Failure> {
    let text = read_text(scene).map_err(Failure::bad_input)?;
    let is_scene = toml::from_str::<toml::Table>(&text).is_ok_and(|table| table.contains_key("format"));
    if is_scene || !text.contains("[[map]]") {
        let (frame, shots) = of_scene(
            Source {
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
    source: Source<'_>,
    options: &Options,
    progress: &dyn Progress,
) -> Result<(SensorFrame, Vec<Shot>), Failure> {
    let document: SceneDocument = source.parse("isolux-scene/1").map_err(Failure::bad_input)?;
    let sensor = &document.sensor;
    let (size_mm, pixels) = (sensor.size_mm.both(), sensor.pixels.both());
    let within = |key: &str, value: f64, low: f64, high: f64| {
        if (low..=high).contains(&value) {
            return Ok(());
        }
        Err(Failure::bad_input(source.locate(&Fault {
            path: format!("sensor.{key}"),
            message: format!("{value} is not within {low} to {high}"),
        })))
    };
    for (size_mm, pixels) in size_mm.into_iter().zip(pixels) {
        within("size_mm", size_mm, 1e-4, 1e5)?;
        within("pixels", pixels as f64, 1.0, 1e6)?;
    }
    let [x, y] = sensor.offset_mm;
    for (key, value, low, high) in [
        ("distance_mm", sensor.distance_mm, 1e-3, 1e6),
        ("tilt_x_deg", sensor.tilt_x_deg, -360.0, 360.0),
        ("tilt_y_deg", sensor.tilt_y_deg, -360.0, 360.0),
        ("rot_z_deg", sensor.rot_z_deg, -360.0, 360.0),
        ("offset_mm", x, -1e6, 1e6),
        ("offset_mm", y, -1e6, 1e6),
        ("time_s", sensor.time_s.unwrap_or(0.0), 0.0, 1e9),
    ] {
        within(key, value, low, high)?;
    }
    if !(1e-9..=1e9).contains(&options.exposure) {
        return Err(Failure::bad_input(format!(
            "exposure {} is not within 1e-9 to 1e9",
            options.exposure
        )));
    }
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

const fn name_of(unit: CaptureUnit) -> &'static str {
    match unit {
        CaptureUnit::Relative => "relative",
        CaptureUnit::Lux => "lx",
        CaptureUnit::WattPerSquareMetre => "W/m2",
    }
}

/// Text of `maps.toml`.
fn poses(frame: &SensorFrame, unit: CaptureUnit, full_scale: Option<f64>, shots: &[Shot]) -> String {
    let [width, height] = frame.size_mm;
    let [nx, ny] = frame.bins;
    let mut text = format!(
        "sensor_mm = [{width:?}, {height:?}]\nbins = [{nx}, {ny}]\nunit = \"{}\"\n",
        name_of(unit)
    );
    if let Some(full_scale) = full_scale {
        let _ = writeln!(text, "full_scale = {full_scale:?}");
    }
    for Shot { name, pose, held_out } in shots {
        let _ = write!(
            text,
            "\n[[map]]\nname = {name:?}\ndistance_mm = {:?}\ntilt_x_deg = {:?}\ntilt_y_deg = {:?}\nrot_z_deg = {:?}\n\
             offset_mm = [{:?}, {:?}]\nexposure = {:?}\nlamp = {}\ncapped = {}\n",
            pose.distance_mm,
            pose.tilt_x_deg,
            pose.tilt_y_deg,
            pose.rot_z_deg,
            pose.offset_mm[0],
            pose.offset_mm[1],
            pose.exposure,
            pose.lamp,
            pose.capped,
        );
        if let Some(time_s) = pose.time_s {
            let _ = writeln!(text, "time_s = {time_s:?}");
        }
        if *held_out {
            text.push_str("held_out = true\n");
        }
    }
    text
}

/// `value` rounded to `digits` significant decimal digits.
fn significant(value: f64, digits: usize) -> f64 {
    format!("{value:.*e}", digits - 1).parse().unwrap_or(value)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::progress::Silent;
    use camino::Utf8PathBuf;

    const SCENE: &str = "format = \"isolux-scene/1\"\nmodel = \"ring.model.toml\"\n[sensor]\nsize_mm = [24.576, 24.576]\n\
                         pixels = [2048, 2048]\ndistance_mm = 500.0\n";

    fn asked() -> Options {
        Options {
            unit: CaptureUnit::Lux,
            bins: Some([6, 4]),
            series: Series::Designed,
            exposure: 1.0,
            overwrite: Overwrite::Never,
        }
    }

    fn folder(scene: &str, darkroom: &str) -> (tempfile::TempDir, Utf8PathBuf) {
        let folder = tempfile::tempdir().unwrap();
        let path = Utf8PathBuf::try_from(folder.path().to_owned()).unwrap();
        std::fs::write(path.join("scene.toml"), scene).unwrap();
        std::fs::write(path.join("darkroom.toml"), darkroom).unwrap();
        (folder, path)
    }

    fn run(path: &Utf8Path, scene: &str, out: &str, options: &Options) -> Result<Captured, Failure> {
        capture(
            &path.join("darkroom.toml"),
            &path.join(scene),
            &path.join(out),
            options,
            &Silent,
        )
    }

    #[test]
    fn a_scene_becomes_maps_that_read_back() {
        let (_keep, path) = folder(SCENE, "seed = 3\n[flaws]\nonly = true\n");
        let captured = run(&path, "scene.toml", "maps.toml", &asked()).unwrap();
        assert_eq!(captured.maps.len(), 9);
        assert!((captured.mean[0] - 1330.0).abs() < 20.0, "{:?}", captured.mean);
        let maps = MapSet::open(&path.join("maps.toml"), Need::Values).unwrap();
        assert_eq!(maps.cells().len(), 9 * 24);
        assert_eq!(maps.maps()[3].distance_mm, 150.0);
        // The poses of a maps.toml can be taken again; the same room gives the same bytes.
        let again = Options { bins: None, ..asked() };
        run(&path, "maps.toml", "again.toml", &again).unwrap();
        let named = std::fs::read_to_string(path.join("maps.toml")).unwrap();
        std::fs::write(path.join("named.toml"), named.replace("\"full\"", "\"x,y\"")).unwrap();
        run(&path, "named.toml", "comma.toml", &again).unwrap();
        let maps = MapSet::open(&path.join("comma.toml"), Need::Values).unwrap();
        assert_eq!(maps.maps()[0].name, "x,y");
        let bytes = |name: &str| std::fs::read(path.join(name)).unwrap();
        assert_eq!(bytes("maps.csv"), bytes("again.csv"));
        assert!(
            run(&path, "scene.toml", "maps.toml", &asked()).is_err(),
            "nothing is overwritten"
        );
    }

    #[test]
    fn faults_name_file_and_line_and_write_nothing() {
        for (scene, darkroom, words) in [
            (SCENE.replace("500.0", "-500.0"), String::new(), "scene.toml:6"),
            (SCENE.replace("pixels", "pixel"), String::new(), "scene.toml:5"),
            (SCENE.to_owned(), "[lamp]\nflux = 1.0\n".to_owned(), "darkroom.toml:2"),
        ] {
            let (_keep, path) = folder(&scene, &darkroom);
            let failure = run(&path, "scene.toml", "maps.toml", &asked()).unwrap_err();
            assert_eq!(failure.kind, crate::FailureKind::BadInput);
            assert!(failure.message.contains(words), "{}", failure.message);
            assert!(!path.join("maps.toml").exists() && !path.join("maps.csv").exists());
        }
    }
}
