//! `virtual capture`: what a camera in the virtual darkroom records.

mod shots;

use std::fmt::Write as _;

use camino::Utf8Path;
use isolux_darkroom::camera::Unit;
use isolux_darkroom::{Darkroom, Room, SensorFrame};
use isolux_record::document::{SourceText, read_text};
use isolux_units::digits::shortest;

pub use shots::{CaptureUnit, Options, Series};
use shots::{Shot, shots};

use crate::Failure;
use crate::files;
use crate::front_end::progress::{Event, Pace, Progress};

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
            let numbers = [iy.to_string(), ix.to_string(), shortest(*signal, 8), shortest(*u, 5)];
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
        CaptureUnit::WattPerSquareMetre => {
            Some(room.document().camera.full_scale_lx * room.spectrum().watt_per_lux(1.0))
        }
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
    let (file, text) = (path, text.as_str());
    let folder = path.parent().unwrap_or(Utf8Path::new(""));
    let beside = |name: &str| read_text(&folder.join(name)).map_err(|error| error.to_string());
    let (room, completed) = Darkroom::complete(SourceText { file, text }, &beside).map_err(Failure::bad_input)?;
    if !completed.is_empty() {
        progress.event(Event::Note(&format!("{path}: {completed}")));
    }
    Ok(room)
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::files::Overwrite;
    use crate::front_end::progress::Silent;
    use camino::Utf8PathBuf;
    use isolux_record::observation::{MapSet, Need};

    const SCENE: &str = "format = \"isolux-scene/1\"\nmodel = \"ring.model.toml\"\n[sensor]\nsize_mm = [24.576, 24.576]\n\
                         pixels = [2048, 2048]\ndistance_mm = 500.0\n";

    fn requested() -> Options {
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
        let (_keep, path) = folder(SCENE, "seed = 3\n[injected_effects]\nonly = true\n");
        let captured = run(&path, "scene.toml", "maps.toml", &requested()).unwrap();
        assert_eq!(captured.maps.len(), 9);
        assert!((captured.mean[0] - 1330.0).abs() < 20.0, "{:?}", captured.mean);
        let maps = MapSet::open(&path.join("maps.toml"), Need::Values).unwrap();
        assert_eq!(maps.cells().len(), 9 * 24);
        assert_eq!(maps.maps()[3].distance_mm, 150.0);
        // The poses of a maps.toml can be taken again; the same room gives the same bytes.
        let again = Options {
            bins: None,
            ..requested()
        };
        run(&path, "maps.toml", "again.toml", &again).unwrap();
        let named = std::fs::read_to_string(path.join("maps.toml")).unwrap();
        std::fs::write(path.join("named.toml"), named.replace("\"full\"", "\"x,y\"")).unwrap();
        run(&path, "named.toml", "comma.toml", &again).unwrap();
        let maps = MapSet::open(&path.join("comma.toml"), Need::Values).unwrap();
        assert_eq!(maps.maps()[0].name, "x,y");
        let bytes = |name: &str| std::fs::read(path.join(name)).unwrap();
        assert_eq!(bytes("maps.csv"), bytes("again.csv"));
        assert!(
            run(&path, "scene.toml", "maps.toml", &requested()).is_err(),
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
            let failure = run(&path, "scene.toml", "maps.toml", &requested()).unwrap_err();
            assert_eq!(failure.kind, crate::FailureKind::BadInput);
            assert!(failure.message.contains(words), "{}", failure.message);
            assert!(!path.join("maps.toml").exists() && !path.join("maps.csv").exists());
        }
    }
}
