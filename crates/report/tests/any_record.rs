//! Reports of records of any shape: a report or a clear error, in which nothing is no number, and the order of the rows
//! changes nothing.

use camino::Utf8Path;
use isolux_any_record::{CHANGES, Random, run_as_is, shuffled};
use isolux_model::{Model, Scene};
use isolux_record::Reading;
use isolux_reduce::{Options, file_name, files, reduce};
use isolux_report::day::{DayResults, document};
use isolux_report::document::Document;
use isolux_sim::simulation::{Method, simulate};
use rayon::prelude::*;

const SENSOR: &str =
    "format = \"isolux-scene/1\"\n[sensor]\nsize_mm = [24.576, 24.576]\npixels = [5, 5]\ndistance_mm = 500.0\n";

/// The report of these rows, whose files lie in `folder`, or what is wrong with them.
fn report(folder: &Utf8Path, rows: Vec<Reading>) -> Result<Document, String> {
    let run = run_as_is(rows);
    let options = Options {
        accept_drift: Some("any".to_owned()),
        ..Options::default()
    };
    let reduction = reduce(&run, &options, None).map_err(|error| error.to_string())?;
    for file in files(&reduction, &run, &[], "test").map_err(|error| error.to_string())? {
        std::fs::write(folder.join(&file.name), &file.bytes).unwrap();
    }
    let model = folder.join(file_name(&reduction, "luminaire.model.toml"));
    let model = Model::load(&model).map_err(|error| error.to_string())?;
    let scene = Scene::parse_with(Utf8Path::new("scene.toml"), SENSOR, &model).map_err(|error| error.to_string())?;
    let mut simulation = simulate(&scene, Method::Inverse, &|| 0.0).map_err(|error| error.to_string())?;
    simulation.facts.elapsed_s = None;
    document(&DayResults {
        run,
        reduction,
        folder: folder.to_owned(),
        scene,
        simulation,
        colour: None,
        comparison: None,
        layout: isolux_report::day::DayLayout::default(),
        conformity: isolux_conformity::Conformity::default(),
        diagnosis: None,
        undiagnosed: None,
        light_modulation: None,
        stale: Vec::new(),
    })
    .map_err(|error| error.to_string())
}

#[test]
fn any_record_has_a_report_and_its_order_changes_nothing() {
    let has_report = |round: u64| {
        let keep = tempfile::tempdir().unwrap();
        let folder = Utf8Path::from_path(keep.path()).unwrap();
        let mut random = Random(round);
        let (changes, rows) = isolux_any_record::rows(round, &mut random);
        let first = report(folder, rows.clone());
        let again = report(folder, shuffled(rows, &mut random));
        let [page, other] = [&first, &again].map(|report| report.as_ref().map(Document::html));
        assert!(page == other, "{changes:?}");
        match (&first, page) {
            (Ok(document), Ok(page)) => {
                assert!(page.contains("End of the report."), "{changes:?}");
                assert_eq!(no_number(&page), None, "{changes:?}");
                let paper = document.pdf().unwrap();
                assert!(paper.bytes.starts_with(b"%PDF-"), "{changes:?}");
            }
            (error, _) => assert!(
                error.as_ref().is_err_and(|error| error.len() > 20),
                "{changes:?}: {:?}",
                error.as_ref().err()
            ),
        }
        first.is_ok()
    };
    let made = (0..2 * CHANGES)
        .into_par_iter()
        .filter(|round| has_report(*round))
        .count();
    assert!(made > 15, "{made} records have a report");
}

/// What a reader would see of a value that is no number, outside the scripts and pictures in base 64.
fn no_number(page: &str) -> Option<&str> {
    let shown = page
        .split("<script")
        .map(|part| part.split_once("</script>").map_or(part, |(_, after)| after));
    let mut words =
        shown.flat_map(|part| part.split(|letter: char| !letter.is_ascii_alphanumeric() && !"+/=".contains(letter)));
    words.find(|word| ["NaN", "inf"].contains(word))
}
