//! A run directory is written, read and resumed, and damage is found.

use super::*;
use crate::plan::Plan;
use crate::readings::tests::reading;
use crate::spectra::tests::{calibration, spectrum};
use crate::station::Station;

fn header() -> RunHeader {
    let device = DeviceRecord {
        role: "luxmeter".to_owned(),
        open: "t10a:x".to_owned(),
        model: "T-10A".to_owned(),
        serial: Some("1".to_owned()),
        firmware: None,
    };
    RunHeader::new(
        "isolux test".to_owned(),
        "2026-01-01T00:00:00Z".to_owned(),
        vec![device],
        Some(calibration()),
        Station::parse(Utf8Path::new("s.toml"), crate::station::tests::STATION).unwrap(),
        Plan::parse(Utf8Path::new("p.toml"), crate::plan::tests::PLAN).unwrap(),
    )
}

fn stopped() -> Stopped {
    Stopped::new(
        "2026-01-01T01:00:00Z".to_owned(),
        StopHow::Completed,
        "every point of the plan was read".to_owned(),
        true,
    )
}

fn homed() -> Logged {
    Logged {
        time_utc: "2026-01-01T00:00:01Z".to_owned(),
        event: Event::Homed {},
    }
}

/// A completed run of five readings and two spectra.
fn completed(path: &Utf8Path) {
    let mut dir = RunDir::create(path, header()).unwrap();
    for second in 0..5_u32 {
        let mut reading = reading(0);
        reading.time_s = Some(2000.0 + f64::from(second));
        dir.append(reading).unwrap();
    }
    for _ in 0..2 {
        dir.spectrum(spectrum(), &calibration()).unwrap();
    }
    dir.event(&homed()).unwrap();
    dir.stop(stopped()).unwrap();
}

fn rows(path: &Utf8Path) -> Vec<String> {
    let text = std::fs::read_to_string(path.join("readings.csv")).unwrap();
    text.split_inclusive('\n').map(str::to_owned).collect()
}

fn damage(path: &Utf8Path) -> String {
    match Run::read(path) {
        Err(error @ (RunError::Damaged { .. } | RunError::HeaderChanged { .. })) => error.to_string(),
        other => panic!("{other:?}"),
    }
}

fn scratch() -> (tempfile::TempDir, Utf8PathBuf) {
    let folder = tempfile::tempdir().unwrap();
    let path = Utf8PathBuf::try_from(folder.path().join("run")).unwrap();
    (folder, path)
}

#[test]
fn what_was_written_is_read() {
    let (_keep, path) = scratch();
    let mut dir = RunDir::create(&path, header()).unwrap();
    for _ in 0..3 {
        dir.append(reading(99)).unwrap();
    }
    dir.spectrum(spectrum(), &calibration()).unwrap();
    dir.event(&homed()).unwrap();
    dir.lamp_on("2026-01-01T00:00:02Z".to_owned()).unwrap();
    dir.stop(stopped()).unwrap();
    let run = Run::read(&path).unwrap();
    assert_eq!(
        run.readings.rows.iter().map(|row| row.index).collect::<Vec<_>>(),
        [0, 1, 2]
    );
    assert_eq!(run.spectra, [spectrum()]);
    assert_eq!(run.notices, [""; 0]);
    let stopped = run.header.stopped.unwrap();
    assert_eq!((stopped.readings, stopped.events), (3, Some(1)));
    let bytes = std::fs::read(path.join("readings.csv")).unwrap();
    assert_eq!(stopped.readings_sha256, Some(sha256(&bytes)), "as sha256sum says it");
    assert_eq!(run.header.station, header().station);
    assert!(matches!(
        RunDir::create(&path, header()),
        Err(RunError::Occupied { .. })
    ));
    assert!(matches!(Run::read(&path.join("spectra")), Err(RunError::NoRun { .. })));
}

#[test]
fn resume_cuts_the_torn_tail_and_refuses_another_bench() {
    let (_keep, path) = scratch();
    let mut dir = RunDir::create(&path, header()).unwrap();
    dir.append(reading(0)).unwrap();
    dir.append(reading(1)).unwrap();
    drop(dir);
    let file = path.join("readings.csv");
    let bytes = std::fs::read(&file).unwrap();
    std::fs::write(&file, &bytes[..bytes.len() - 9]).unwrap();
    let (mut dir, run) = RunDir::resume(&path, &header()).unwrap();
    assert_eq!((run.readings.rows.len(), dir.len()), (1, 1));
    dir.append(reading(0)).unwrap();
    drop(dir);
    let run = Run::read(&path).unwrap();
    assert_eq!(
        run.readings
            .rows
            .iter()
            .map(|row| (row.index, row.session))
            .collect::<Vec<_>>(),
        [(0, 0), (1, 1)]
    );
    let mut other = header();
    other.device[0].serial = Some("2".to_owned());
    let error = RunDir::resume(&path, &other).unwrap_err().to_string();
    assert!(error.contains("luxmeter (T-10A 2, the run had T-10A 1)"), "{error}");
    let mut other = header();
    let text = crate::plan::tests::PLAN.replace("repeats = 20", "repeats = 21");
    other.plan = Plan::parse(Utf8Path::new("p.toml"), &text).unwrap();
    assert!(matches!(RunDir::resume(&path, &other), Err(RunError::Changed { .. })));
}

#[test]
fn rows_that_are_lost_from_a_completed_run_are_missed() {
    for (lost, words) in [
        (4..6, "holds 3 readings, 5 were recorded"),
        (2..3, "a row is missing"),
        (1..6, "holds 0 readings, 5 were recorded"),
    ] {
        let (_keep, path) = scratch();
        completed(&path);
        let mut left = rows(&path);
        left.drain(lost);
        std::fs::write(path.join("readings.csv"), left.concat()).unwrap();
        let stated = damage(&path);
        assert!(stated.contains(words) && stated.contains("readings.csv"), "{stated}");
        assert!(matches!(
            RunDir::resume(&path, &header()),
            Err(RunError::Damaged { .. })
        ));
    }
}

/// No checksum of a row and no number of a row tells: the rows are whole and of the same plan.
#[test]
fn rows_and_spectra_of_another_run_are_not_this_one() {
    let (_keep, path) = scratch();
    completed(&path);
    let (_keep, other) = scratch();
    let mut dir = RunDir::create(&other, header()).unwrap();
    for second in 0..5_u32 {
        let mut reading = reading(0);
        reading.time_s = Some(2000.5 + f64::from(second));
        dir.append(reading).unwrap();
    }
    std::fs::copy(other.join("readings.csv"), path.join("readings.csv")).unwrap();
    assert!(damage(&path).contains("readings.csv: its rows are of another run"));
    // Nor where the program was killed.
    let theirs = std::fs::read(other.join("readings.csv")).unwrap();
    let (_keep, killed) = scratch();
    let mut dir = RunDir::create(&killed, header()).unwrap();
    dir.append(reading(0)).unwrap();
    std::fs::write(killed.join("readings.csv"), &theirs).unwrap();
    assert!(damage(&killed).contains("of another run"));
    // Nor beside a run.toml in which no row was written yet.
    let (_keep, begun) = scratch();
    drop(RunDir::create(&begun, header()).unwrap());
    std::fs::write(begun.join("readings.csv"), &theirs).unwrap();
    assert!(damage(&begun).contains("of another run"));

    let (_keep, path) = scratch();
    completed(&path);
    std::fs::copy(path.join("spectra/000.csv"), path.join("spectra/001.csv")).unwrap();
    assert!(damage(&path).contains("spectra/001.csv: is not the file that was recorded"));
    std::fs::remove_file(path.join("spectra/001.csv")).unwrap();
    assert!(damage(&path).contains("spectra/001.csv: is missing"));
}

#[test]
fn any_change_of_run_toml_is_refused() {
    let (_keep, path) = scratch();
    completed(&path);
    let file = path.join("run.toml");
    let text = std::fs::read_to_string(&file).unwrap();
    for changed in [
        text.replacen("saturation_counts = 32768.0", "saturation_counts = 32769.0", 1),
        text.replacen("readings = 5", "readings = 4", 1),
        text.replacen("isolux-run/4", "isolux-run/3", 1),
        text[..text.rfind("[check]").unwrap()].to_owned(),
        text[..text.len() - 3].to_owned(),
    ] {
        assert_ne!(changed, text);
        std::fs::write(&file, &changed).unwrap();
        let stated = Run::read(&path).unwrap_err().to_string();
        assert!(stated.contains("run.toml"), "{stated}");
    }
}

#[test]
fn a_run_of_another_format_is_refused_with_what_to_do() {
    let (_keep, path) = scratch();
    completed(&path);
    let file = path.join("run.toml");
    let text = std::fs::read_to_string(&file).unwrap();
    for format in ["isolux-run/1", "isolux-run/2", "isolux-run/5"] {
        std::fs::write(&file, text.replacen("isolux-run/4", format, 1)).unwrap();
        let stated = Run::read(&path).unwrap_err().to_string();
        let expected = format!("{file}:1: the run has the format {format}; this program reads isolux-run/4");
        assert!(
            stated.starts_with(&expected) && stated.contains("Reduce it with"),
            "{stated}"
        );
        assert!(matches!(
            RunDir::resume(&path, &header()),
            Err(RunError::OtherFormat { .. })
        ));
    }
}

#[test]
fn a_damaged_record_is_read_again_from_its_whole_rows_on_and_nothing_is_thrown_away() {
    let (_keep, path) = scratch();
    completed(&path);
    let file = path.join("readings.csv");
    let whole = rows(&path);
    let mut changed = whole.clone();
    changed[3] = changed[3].replacen("3.37", "3.38", 1);
    std::fs::write(&file, changed.concat()).unwrap();
    std::fs::remove_file(path.join("spectra/000.csv")).unwrap();
    let (mut dir, run) = RunDir::reread(&path, &header()).unwrap();
    assert_eq!((dir.len(), run.readings.rows.len(), run.spectra.len()), (2, 2, 1));
    assert_eq!(
        std::fs::read_to_string(path.join("damaged-1/readings.csv")).unwrap(),
        changed.concat()
    );
    assert_eq!(dir.append(reading(0)).unwrap().index, 2);
    assert_eq!(dir.spectrum(spectrum(), &calibration()).unwrap(), 2);
    dir.stop(stopped()).unwrap();
    let run = Run::read(&path).unwrap();
    assert_eq!(rows(&path)[..3], whole[..3]);
    assert_eq!(run.readings.rows[2].session, 1);
    assert_eq!(
        run.spectra.iter().map(|spectrum| spectrum.index).collect::<Vec<_>>(),
        [1, 2]
    );
    let stated = run.notices.concat();
    assert!(
        stated.contains("damaged-1 holds") && stated.contains("row 2 is damaged"),
        "{stated}"
    );
    assert!(stated.contains("000.csv: is missing"), "{stated}");
}

#[test]
fn a_row_that_the_disk_did_not_confirm_is_no_reading() {
    let (_keep, path) = scratch();
    let mut dir = RunDir::create(&path, header()).unwrap();
    dir.append(reading(0)).unwrap();
    dir.readings.fail_to_sync();
    assert!(matches!(dir.append(reading(0)), Err(RunError::Disk(_))));
    assert!(dir.append(reading(0)).is_err());
    let mut failed = stopped();
    failed.how = StopHow::Failed;
    dir.stop(failed).unwrap();
    // A disk that fails may not have cut the row off either.
    let (row, _) = dir.chain.row(&Reading { index: 1, ..reading(1) });
    let file = path.join("readings.csv");
    std::fs::write(&file, rows(&path).concat() + &row).unwrap();
    let run = Run::read(&path).unwrap();
    assert_eq!(run.readings.rows.len(), 1);
    assert!(run.notices.concat().contains("rows from 1 on were never confirmed"));
    let (mut dir, _) = RunDir::resume(&path, &header()).unwrap();
    assert_eq!(dir.append(reading(0)).unwrap().index, 1);
    dir.stop(stopped()).unwrap();
    let run = Run::read(&path).unwrap();
    assert_eq!((run.readings.rows.len(), run.readings.rows[1].session), (2, 1));
}

fn at_lamp(time_s: f64, lamp_s: Option<f64>) -> Reading {
    Reading {
        time_s: Some(time_s),
        lamp_s,
        ..reading(0)
    }
}

#[test]
fn a_run_of_format_3_is_placed_on_one_axis_by_the_clocks_of_its_sessions() {
    let (_keep, path) = scratch();
    let mut old = header();
    FORMAT_3.clone_into(&mut old.format);
    let mut dir = RunDir::create(&path, old).unwrap();
    dir.append(at_lamp(0.0, None)).unwrap();
    dir.lamp_on("2026-01-01T00:00:10Z".to_owned()).unwrap();
    for lamp_s in [1800.0, 1802.0] {
        dir.append(at_lamp(0.0, Some(lamp_s))).unwrap();
    }
    drop(dir);
    let later = |utc: &str| RunHeader {
        started_utc: utc.to_owned(),
        ..header()
    };
    // The lamp went on burning: its clock and that of the run go on.
    let (mut dir, run) = RunDir::resume(&path, &later("2026-01-01T00:40:00Z")).unwrap();
    let times = |run: &Run| -> Vec<f64> { run.readings.rows.iter().filter_map(|row| row.time_s).collect() };
    assert_eq!(
        times(&run),
        [0.0, 1810.0, 1812.0],
        "the last switching on is known by its UTC"
    );
    assert_eq!(dir.start_s(), 2400.0);
    dir.append(at_lamp(0.0, Some(2500.0))).unwrap();
    drop(dir);
    // Then it was switched on again, an hour later.
    let (mut dir, run) = RunDir::resume(&path, &later("2026-01-01T01:40:00Z")).unwrap();
    assert_eq!(times(&run)[3], 2510.0);
    dir.lamp_on("2026-01-01T01:40:30Z".to_owned()).unwrap();
    dir.append(at_lamp(0.0, Some(1800.0))).unwrap();
    drop(dir);
    let run = Run::read(&path).unwrap();
    // Of the first burning no UTC is left: it counts as soon as it can have been.
    assert_eq!(times(&run), [0.0, 1800.0, 1802.0, 2500.0, 7830.0]);
    let lamp: Vec<_> = run.readings.rows.iter().map(|row| row.lamp_s).collect();
    assert_eq!(lamp, [None, Some(1800.0), Some(1802.0), Some(2500.0), Some(1800.0)]);
    // So it is where its readings are observations.
    let Ok(crate::observation::Observations::Readings(readings)) =
        crate::observation::open(&path, crate::observation::Need::Values)
    else {
        panic!("readings");
    };
    let at = readings.rows()[4].at;
    assert_eq!((at.time_s, at.lamp_age_s()), (Some(7830.0), Some(1800.0)));
}

#[test]
fn a_session_begins_after_what_is_recorded_whatever_became_of_the_clock() {
    let (_keep, path) = scratch();
    let mut dir = RunDir::create(&path, header()).unwrap();
    assert_eq!(dir.start_s(), 0.0);
    dir.append(at_lamp(1812.5, Some(1800.0))).unwrap();
    drop(dir);
    for (utc, start_s) in [
        ("2026-01-01T01:00:00Z", 3600.0),
        // Set back by more than an hour.
        ("2025-12-31T23:59:00Z", 3600.0),
        ("no time", 3600.0),
    ] {
        let now = RunHeader {
            started_utc: utc.to_owned(),
            ..header()
        };
        let (dir, _) = RunDir::resume(&path, &now).unwrap();
        assert_eq!(dir.start_s(), start_s, "{utc}");
        assert_eq!(dir.header().resumed.last().unwrap().start_s, Some(start_s));
    }
}

#[test]
fn what_a_kill_before_the_first_run_toml_leaves_is_no_obstacle() {
    let (_keep, path) = scratch();
    drop(RunDir::create(&path, header()).unwrap());
    std::fs::remove_file(path.join("run.toml")).unwrap();
    let stated = Run::read(&path).unwrap_err().to_string();
    assert!(stated.contains("begin the run anew with --out"), "{stated}");
    completed(&path);
    assert_eq!(Run::read(&path).unwrap().readings.rows.len(), 5);
    // A file of somebody else is not ours to write over.
    let (_keep, path) = scratch();
    drop(RunDir::create(&path, header()).unwrap());
    std::fs::remove_file(path.join("run.toml")).unwrap();
    std::fs::write(path.join("readings.csv"), "c_deg,gamma_deg\n").unwrap();
    assert!(matches!(
        RunDir::create(&path, header()),
        Err(RunError::Occupied { .. })
    ));
}
