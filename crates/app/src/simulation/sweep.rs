//! `sweep`: one simulation for each combination of varied keys; `merge`: shards back into one result.
//!
//! A sweep is a list of points in the order of its keys (the last one runs fastest). A shard takes every N-th point;
//! every point is computed from the scene alone with the sweep's seed, so that shards and the whole run give the same
//! bytes.

mod document;
mod results;

use std::collections::BTreeMap;

use camino::{Utf8Path, Utf8PathBuf};
use isolux_model::Scene;
use isolux_record::document::{SourceText, read_text};
use sha2::{Digest, Sha256};
use toml::{Table, Value};

use document::{Document, FORMAT, at, fault, flatten, method};
use results::{Point, Results, write};

use crate::Failure;
use crate::files::{self, Overwrite};
use crate::front_end::progress::{Event, Pace, Progress};
use crate::simulation::scene::{self, Changes};
use crate::simulation::simulate;

/// Most points of a sweep: each holds its scene until it is solved.
const MOST_POINTS: usize = 100_000;

/// Which part of the points is computed.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Shard {
    /// From 1.
    pub number: usize,
    /// Of how many.
    pub of: usize,
}

/// Runs a sweep, or one shard of it.
///
/// # Errors
/// Exit 2 for a sweep file that cannot be used; nothing is written then.
pub fn run(
    file: &Utf8Path,
    out: &Utf8Path,
    shard: Option<Shard>,
    overwrite: Overwrite,
    progress: &dyn Progress,
) -> Result<usize, Failure> {
    let text = read_text(file).map_err(Failure::bad_input)?;
    let source = SourceText { file, text: &text };
    let document: Document = source.parse(FORMAT).map_err(Failure::bad_input)?;
    let method = method(source, &document)?;
    let mut keys = Vec::new();
    let mut values: Vec<Vec<Value>> = Vec::new();
    flatten("", &document.vary, &mut keys, &mut values).map_err(|key| {
        fault(source, &format!("vary.{key}"), "a list of values is needed")
            .help("such as \"sensor.distance_mm\" = [250.0, 500.0]")
    })?;
    let points = values
        .iter()
        .fold(1, |points: usize, list| points.saturating_mul(list.len()));
    if keys.is_empty() || points == 0 {
        return Err(fault(source, "vary", "it names no values"));
    }
    if points > MOST_POINTS {
        let message = format!("{points} combinations; at most {MOST_POINTS} are computed in one sweep");
        return Err(fault(source, "vary", &message));
    }
    let scene_file = file.parent().unwrap_or(Utf8Path::new("")).join(&document.scene);
    if !scene_file.exists() {
        return Err(fault(source, "scene", &format!("{scene_file} is not there")));
    }
    let chosen: Vec<usize> = (0..points)
        .filter(|index| shard.is_none_or(|shard| index % shard.of + 1 == shard.number))
        .collect();
    // Every scene is read before the first is solved: a fault in the last point would cost the whole night.
    let scenes: Vec<Scene> = chosen
        .iter()
        .map(|&index| {
            let set: Vec<String> = keys
                .iter()
                .zip(at(&values, index))
                .map(|(key, value)| format!("{key}={value}"))
                .collect();
            let point = format!("{file}, the point {}", set.join(", "));
            let changes = Changes {
                set,
                ..Changes::default()
            };
            scene::load(&scene_file, &changes)
                .and_then(|scene| simulate::can_be_lit(&scene).map(|()| scene))
                .map_err(|failure| Failure {
                    message: format!("{point}: {}", failure.message),
                    help: Some("change the values under [vary]".to_owned()),
                    ..failure
                })
        })
        .collect::<Result<_, _>>()?;
    files::refuse_occupied(out, overwrite)?;
    // Before the first point, as its files may change while it is computed.
    let inputs_sha256 = inputs(&text, &scene_file, &document.vary)?;
    progress.event(Event::Began {
        step: "sweep",
        total: Some(chosen.len() as u64),
    });
    let mut results = Vec::new();
    let pace = Pace::of(chosen.len());
    for (done, (&index, scene)) in chosen.iter().zip(&scenes).enumerate() {
        progress.event(Event::At {
            done: done as u64,
            what: &pace.words("solving", done),
        });
        let facts = simulate::solve(scene, method)?.facts;
        let vary = at(&values, index)
            .map(|value| serde_json::to_value(value).unwrap_or_default())
            .collect();
        results.push(Point {
            index,
            vary,
            result: facts,
        });
    }
    let table = Results {
        format: "isolux-sweep-result/1".to_owned(),
        inputs_sha256,
        keys,
        points,
        results,
    };
    let folder = files::output_folder(out, overwrite)?;
    write(&folder, &table, overwrite)?;
    progress.event(Event::Ended(&format!("{} of {points} points", chosen.len())));
    Ok(chosen.len())
}

/// Puts shards together; the bytes are those of one run.
///
/// # Errors
/// Exit 2 when shards belong to different sweeps, overlap with different results, or leave points out.
pub fn merge(shards: &[Utf8PathBuf], out: &Utf8Path, overwrite: Overwrite) -> Result<usize, Failure> {
    let mut whole: Option<Results> = None;
    for folder in shards {
        let path = folder.join("sweep.json");
        let table: Results = serde_json::from_slice(&files::read(&path)?)
            .map_err(|error| Failure::bad_input(format!("{path}: {error}")))?;
        match &mut whole {
            None => whole = Some(table),
            Some(whole)
                if whole.inputs_sha256 == table.inputs_sha256
                    && whole.keys == table.keys
                    && whole.points == table.points =>
            {
                for point in table.results {
                    match whole.results.iter().find(|have| have.index == point.index) {
                        Some(have) if *have == point => {}
                        Some(_) => {
                            return Err(Failure::bad_input(format!(
                                "{path}: point {} has another result",
                                point.index
                            ))
                            .help("shards of different versions or scenes cannot be merged"));
                        }
                        None => whole.results.push(point),
                    }
                }
            }
            Some(_) => {
                return Err(Failure::bad_input(format!("{path}: belongs to another sweep"))
                    .help("its sweep file, scene or model is not that of the first shard"));
            }
        }
    }
    let Some(mut whole) = whole else {
        return Err(Failure::bad_input("no shard given"));
    };
    whole.results.sort_by_key(|point| point.index);
    if let Some(missing) =
        (0..whole.points).find(|index| whole.results.get(*index).is_none_or(|point| point.index != *index))
    {
        return Err(
            Failure::bad_input(format!("point {missing} of {} is in no shard", whole.points))
                .help("run the missing shard; an interrupted shard writes nothing"),
        );
    }
    let folder = files::output_folder(out, overwrite)?;
    write(&folder, &whole, overwrite)?;
    Ok(whole.points)
}

/// One sum over the sweep file, its scene, and every file that these and the scene's model name.
fn inputs(sweep: &str, scene: &Utf8Path, vary: &Table) -> Result<String, Failure> {
    let mut sum = Sha256::new();
    sum.update(sweep);
    if scene.is_file() {
        sum.update(files::read(scene)?);
    }
    let (at, table) = scene::table(scene, &Changes::default())?;
    let folder = at.parent().unwrap_or(Utf8Path::new(""));
    let mut read = BTreeMap::new();
    named(folder, Value::Table(table), &mut read)?;
    named(folder, Value::Table(vary.clone()), &mut read)?;
    // As lengths stand before the bytes, no two sets of files run together into the same sum.
    for (name, bytes) in &read {
        sum.update(format!("\n{name} {}\n", bytes.len()));
        sum.update(bytes);
    }
    Ok(hex::encode(sum.finalize()))
}

/// Every file in `folder` that a text of `value` names, by that name, and the files that a model among them names.
fn named(folder: &Utf8Path, mut value: Value, read: &mut BTreeMap<String, Vec<u8>>) -> Result<(), Failure> {
    let mut names = Vec::new();
    scene::each_text(&mut value, &mut |text| names.push(text.clone()));
    for name in names {
        let path = folder.join(&name);
        if read.contains_key(&name) || !path.is_file() {
            continue;
        }
        let bytes = files::read(&path)?;
        let inner = String::from_utf8_lossy(&bytes).parse::<Table>();
        read.insert(name.clone(), bytes);
        if let (Ok(inner), Some("toml")) = (inner, path.extension()) {
            let beside = path.parent().unwrap_or(Utf8Path::new(""));
            let mut of_model = BTreeMap::new();
            named(beside, Value::Table(inner), &mut of_model)?;
            read.extend(
                of_model
                    .into_iter()
                    .map(|(file, bytes)| (format!("{name}: {file}"), bytes)),
            );
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use std::cell::Cell;

    use super::*;
    use crate::front_end::progress::Silent;

    fn sweep(folder: &Utf8Path) -> Utf8PathBuf {
        std::fs::write(folder.join("lamp.csv"), "gamma_deg,intensity_cd\n0,300\n30,200\n90,0\n").unwrap();
        std::fs::write(
            folder.join("scene.toml"),
            "format = \"isolux-scene/1\"\n[luminaire]\ndistribution = \"lamp.csv\"\nler_lm_per_w = 300.0\n\
             [sensor]\nsize_mm = [20.0, 20.0]\npixels = [4, 4]\ndistance_mm = 500.0\n",
        )
        .unwrap();
        let file = folder.join("sweep.toml");
        std::fs::write(
            &file,
            "format = \"isolux-sweep/1\"\nscene = \"scene.toml\"\nmethod = \"direct\"\nrays = 1e6\n[vary]\n\
             \"sensor.distance_mm\" = [250.0, 500.0, 1000.0]\n\"luminaire.ler_lm_per_w\" = [255.1, 310.0]\n",
        )
        .unwrap();
        file
    }

    #[test]
    fn four_shards_merge_to_the_bytes_of_one_run() {
        let folder = tempfile::tempdir().unwrap();
        let folder = Utf8Path::from_path(folder.path()).unwrap();
        let file = sweep(folder);
        assert_eq!(
            run(&file, &folder.join("whole"), None, Overwrite::Never, &Silent).unwrap(),
            6
        );
        let shards: Vec<Utf8PathBuf> = (1..=4)
            .map(|number| {
                let out = folder.join(format!("shard{number}"));
                run(&file, &out, Some(Shard { number, of: 4 }), Overwrite::Never, &Silent).unwrap();
                out
            })
            .collect();
        assert_eq!(merge(&shards, &folder.join("merged"), Overwrite::Never).unwrap(), 6);
        for name in [
            "sweep.json",
            "sweep.csv",
            "sensor_distance_mm.svg",
            "luminaire_ler_lm_per_w.svg",
        ] {
            let read = |part: &str| std::fs::read(folder.join(part).join(name)).unwrap();
            assert_eq!(read("whole"), read("merged"), "{name}");
        }
        let missing = merge(&shards[..3], &folder.join("torn"), Overwrite::Never).unwrap_err();
        assert!(missing.message.contains("is in no shard"), "{}", missing.message);
    }

    #[test]
    fn shards_of_other_light_are_not_joined() {
        let folder = tempfile::tempdir().unwrap();
        let folder = Utf8Path::from_path(folder.path()).unwrap();
        let file = sweep(folder);
        let shard = |number: usize| {
            let out = folder.join(format!("shard{number}"));
            run(&file, &out, Some(Shard { number, of: 2 }), Overwrite::Never, &Silent).unwrap();
            out
        };
        let first = shard(1);
        std::fs::write(folder.join("lamp.csv"), "gamma_deg,intensity_cd\n0,30\n30,20\n90,0\n").unwrap();
        let shards = [first, shard(2)];
        let refused = merge(&shards, &folder.join("merged"), Overwrite::Never).unwrap_err();
        assert!(refused.message.contains("another sweep"), "{refused}");
        assert!(!folder.join("merged").exists());
    }

    #[test]
    fn what_cannot_be_lit_or_drawn_stops_before_the_first_point() {
        let folder = tempfile::tempdir().unwrap();
        let folder = Utf8Path::from_path(folder.path()).unwrap();
        let file = sweep(folder);
        let text = std::fs::read_to_string(&file).unwrap();
        let late = text.replace(
            "\"sensor.distance_mm\" = [250.0, 500.0, 1000.0]",
            "\"sensor.tilt_x_deg\" = [0.0, 100.0]",
        );
        let rays = text.replace("method = \"direct\"\n", "");
        let all = (0..400).map(|k| k.to_string()).collect::<Vec<_>>().join(", ");
        let many = text.replace(
            "[vary]\n",
            &format!("[vary]\n\"sensor.rot_z_deg\" = [{all}]\n\"sensor.tilt_y_deg\" = [{all}]\n"),
        );
        let absurd = text.replace("250.0", "1e308");
        let no_list = text.replace("[250.0, 500.0, 1000.0]", "250.0");
        for (text, words) in [
            (late, "looks away"),
            (rays, "rays"),
            (many, "sweep.toml:5:2: vary: 960000 combinations"),
            (absurd, "sensor.distance_mm"),
            (no_list, "sweep.toml:5:2: vary.sensor.distance_mm: a list"),
        ] {
            std::fs::write(&file, &text).unwrap();
            let begun = Cell::new(false);
            let refused = run(&file, &folder.join("out"), None, Overwrite::Never, &Begun(&begun)).unwrap_err();
            assert_eq!(refused.kind, crate::FailureKind::BadInput);
            assert!(refused.message.contains(words), "{refused}");
            assert!(!begun.get(), "a point was computed before {refused}");
        }
    }

    struct Begun<'a>(&'a Cell<bool>);

    impl Progress for Begun<'_> {
        fn event(&self, _: Event<'_>) {
            self.0.set(true);
        }
    }

    #[test]
    fn a_value_with_a_comma_stays_one_field() {
        let folder = tempfile::tempdir().unwrap();
        let folder = Utf8Path::from_path(folder.path()).unwrap();
        let file = sweep(folder);
        let text = std::fs::read_to_string(&file).unwrap().replace(
            "\"luminaire.ler_lm_per_w\" = [255.1, 310.0]",
            "\"luminaire.emitter\" = [{ shape = \"disc\", diameter_mm = 10.0 }, { shape = \"point\" }]",
        );
        std::fs::write(&file, text).unwrap();
        run(&file, &folder.join("out"), None, Overwrite::Never, &Silent).unwrap();
        // The reader refuses rows of unequal length.
        let mut reader = csv::Reader::from_path(folder.join("out/sweep.csv")).unwrap();
        assert_eq!(reader.records().map(Result::unwrap).count(), 6);
    }

    #[test]
    fn distance_and_efficacy_act_as_they_must() {
        let folder = tempfile::tempdir().unwrap();
        let folder = Utf8Path::from_path(folder.path()).unwrap();
        let file = sweep(folder);
        run(&file, &folder.join("out"), None, Overwrite::Never, &Silent).unwrap();
        let table: Results = serde_json::from_slice(&std::fs::read(folder.join("out/sweep.json")).unwrap()).unwrap();
        let mean = |index: usize| table.results[index].result.mean;
        assert_eq!(table.keys, ["luminaire.ler_lm_per_w", "sensor.distance_mm"]);
        // Point 0: 255.1 lm/W at 250 mm; point 3: 310 lm/W there. The same rays, another efficacy.
        assert!((mean(0) / mean(3) - 310.0 / 255.1).abs() < 1e-12);
        assert!((mean(0) / mean(2) - 16.0).abs() < 4.0);
    }
}
