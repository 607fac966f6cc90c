//! What the page shows of records of any shape: each of its views answers or says why not.

use camino::Utf8Path;
use isolux_any_record::{CHANGES, Random, run};
use isolux_app::run::replay::Replay;
use isolux_app::simulation::sensor_so_far::sensor_so_far;
use isolux_app::study::in_motion::in_motion;
use isolux_app::study::{card, results};
use isolux_record::run::{RunDir, StopHow, Stopped};
use isolux_record::{Event, Reading};

/// A run directory with these rows.
fn record(folder: &Utf8Path, rows: Vec<Reading>) {
    let mut writer = RunDir::create(folder, run(Vec::new()).header).unwrap();
    for row in rows {
        writer.append(row).unwrap();
    }
    let utc = "2026-01-01T03:00:00Z".to_owned();
    let stopped = Stopped::new(utc, StopHow::Completed, "every point was read".to_owned(), true);
    writer.stop(stopped).unwrap();
}

#[test]
fn any_record_is_shown() {
    let keep = tempfile::tempdir().unwrap();
    let folder = Utf8Path::from_path(keep.path()).unwrap();
    let (mut drawn, mut reduced, mut illuminated) = (0, 0, 0);
    for round in 0..CHANGES + 12 {
        let mut random = Random(round);
        let (changes, rows) = isolux_any_record::rows(round, &mut random);
        let path = folder.join(round.to_string());
        let count = rows.len();
        record(&path, rows);
        let (_, events) = Replay::of(&path).further().unwrap();
        let shown = events
            .iter()
            .filter(|event| matches!(event.logged.event, Event::Reading(_)));
        assert_eq!(shown.count(), count, "{changes:?}");
        let card = card::card(&path).unwrap();
        drawn += u32::from(card.picture.is_some_and(|picture| !picture.contains("NaN")));
        match results::results(&path, None) {
            Ok(found) => {
                reduced += 1;
                for figure in found.figures {
                    assert!(!figure.svg.contains("NaN"), "{changes:?}: {}", figure.title);
                }
            }
            Err(failure) => assert!(failure.message.contains(path.as_str()), "{changes:?}: {failure}"),
        }
        assert_eq!(in_motion(&path).unwrap(), None, "nothing was swept");
        illuminated += u32::from(sensor_so_far(&path).is_ok_and(|sensor| sensor.is_some()));
    }
    assert!(drawn > 15 && reduced > 10, "{drawn} {reduced} {illuminated}");
}
