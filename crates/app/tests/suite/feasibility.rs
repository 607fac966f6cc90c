//! A scan rehearsed with the photometric file of the luminaire: `init --lamp`, then the twins, the record and the
//! reduction, against the light of the file.

use std::f64::consts::TAU;

use camino::{Utf8Path, Utf8PathBuf};
use isolux_app::files::Overwrite;
use isolux_app::front_end::control::{Control, Pace};
use isolux_app::front_end::progress::Silent;
use isolux_app::init::{self, Instruments};
use isolux_app::scan::{self, Place, ScanJob, Target};
use isolux_darkroom::{Darkroom, Room};
use isolux_record::document::SourceText;
use isolux_record::{Plan, Run, Station, Subject};
use isolux_reduce::Options;

/// A batwing that leans to C 40°, as an absolute LM-63 file of 10° × 5° with a round opening of 80 mm; without
/// light along γ = 0° if asked.
fn batwing(on_axis: bool) -> String {
    let light = |c: f64, gamma: f64| {
        let beam = (-((gamma - 35.0) / 18.0).powi(2)).exp() + 0.8 * (-(gamma / 25.0).powi(2)).exp();
        let lean = 1.0 + 0.3 * gamma.to_radians().sin() * ((c - 40.0) / 360.0 * TAU).cos();
        if gamma >= 90.0 || (gamma == 0.0 && !on_axis) {
            0.0
        } else {
            900.0 * beam * lean
        }
    };
    let list = |count: usize, step: f64| (0..count).map(|k| k as f64 * step).collect::<Vec<_>>();
    let (gammas, planes) = (list(37, 5.0), list(37, 10.0));
    let words = |values: &[f64]| {
        values
            .iter()
            .map(|value| format!("{value:.3}"))
            .collect::<Vec<_>>()
            .join(" ")
            + "\n"
    };
    let mut text = "IESNA:LM-63-2002\n[TEST] 1\n[MANUFAC] ACME\n[LUMINAIRE] Wing\nTILT=NONE\n\
                    1 -1 1 37 37 1 2 -0.08 -0.08 0\n1 1 12\n"
        .to_owned();
    text += &(words(&gammas) + &words(&planes));
    for c in planes {
        text += &words(&gammas.iter().map(|gamma| light(c, *gamma)).collect::<Vec<_>>());
    }
    text
}

fn written(text: &str) -> (tempfile::TempDir, Utf8PathBuf) {
    let keep = tempfile::tempdir().unwrap();
    let folder = Utf8PathBuf::try_from(keep.path().to_owned()).unwrap();
    std::fs::write(folder.join("wing.ies"), text).unwrap();
    (keep, folder)
}

fn init(folder: &Utf8Path) -> Result<Vec<Utf8PathBuf>, isolux_app::Failure> {
    let (file, stated) = (folder.join("wing.ies"), Subject::default());
    init::for_lamp(
        &folder.join("bench"),
        &file,
        &Instruments::default(),
        &stated,
        Overwrite::Never,
        &Silent,
    )
}

#[test]
fn what_a_rehearsed_scan_measures_is_the_light_of_the_file() {
    let (_keep, folder) = written(&batwing(true));
    init(&folder).unwrap();
    let bench = folder.join("bench");
    let (station, plan) = (bench.join("station.toml"), bench.join("plan.toml"));
    let job = std::fs::read_to_string(bench.join("job.toml")).unwrap();
    assert!(job.contains("ACME") && job.contains("Wing"), "{job}");
    let room = std::fs::read_to_string(bench.join("room.toml")).unwrap();
    let table = std::fs::read_to_string(bench.join("lamp.csv")).unwrap();
    let (room, completed) = Darkroom::complete(
        SourceText {
            file: "darkroom.toml".into(),
            text: &room,
        },
        &|_| Ok(table.clone()),
    )
    .unwrap();
    assert!(completed.is_empty(), "{completed}");
    assert_eq!(Station::load(&station).unwrap().lamp().unwrap().diameter_mm, Some(80.0));
    let block = &Plan::load(&plan).unwrap().blocks()[0].clone();
    assert_eq!((block.c_deg[0], block.c_deg[block.c_deg.len() - 1]), (0.0, 360.0));

    let dir = bench.join("run");
    let control = &Control {
        pace: Pace::Free,
        ..Control::default()
    };
    let (source, plan, _) = scan::checked(&station, &plan, false).unwrap();
    let job = ScanJob {
        source: &source,
        plan: &plan,
        place: Place::take(Target::New(&dir), false).unwrap(),
        force: None,
        operator: None,
        control,
        progress: &Silent,
    };
    job.execute().unwrap();
    let reduction = isolux_reduce::reduce(&Run::read(&dir).unwrap(), &Options::default(), None).unwrap();
    let room = Room::new(room);
    let read = &reduction.grid.distribution;
    let peak_cd = read.peak().intensity_cd;
    for (plane, c_deg) in read.c_deg().iter().enumerate() {
        for (gamma_deg, got) in read.gamma_deg().iter().zip(read.row(plane)) {
            let truth = room.intensity_cd(*c_deg, *gamma_deg);
            assert!(
                (got - truth).abs() < 0.01 * peak_cd,
                "C {c_deg}° γ {gamma_deg}°: {got} against {truth} cd"
            );
        }
    }
    let truth_lm = room.document().lamp.flux_lm;
    let flux = &reduction.flux;
    let expanded_lm = 2.0 * flux.u.unwrap();
    assert!(
        (flux.value - truth_lm).abs() < expanded_lm,
        "{} against {truth_lm} lm, U = {expanded_lm} lm",
        flux.value
    );
}

#[test]
fn a_file_without_light_along_the_axis_is_refused_before_anything_is_written() {
    let (_keep, folder) = written(&batwing(false));
    let failure = init(&folder).unwrap_err();
    assert!(failure.message.contains("along γ = 0°"), "{failure}");
    assert!(!folder.join("bench").exists());
    std::fs::write(folder.join("wing.ies"), "no photometric file").unwrap();
    assert!(init(&folder).is_err());
}
