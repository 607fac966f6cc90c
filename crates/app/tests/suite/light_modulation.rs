//! A day whose job names a record of the light over time.

use camino::{Utf8Path, Utf8PathBuf};
use isolux_app::day::{self, Options};
use isolux_app::files::Overwrite;
use isolux_app::front_end::control::Control;
use isolux_app::front_end::progress::Silent;
use isolux_app::modulation::Evaluated;
use isolux_app::{FailureKind, init, verify};
use isolux_virtual::twins::Choice;

const PLAN: &str = "format = \"isolux-plan/1\"
[[block]]
name = \"lit\"
kind = \"lit\"
c_deg = [0, 90]
gamma_deg = [-60, -30, 0, 30, 60]
distance_mm = 2000.0
[[block]]
name = \"baffled\"
kind = \"baffled\"
c_deg = 0
gamma_deg = [0, 60]
distance_mm = 2000.0
[[block]]
name = \"spectrum\"
kind = \"lit\"
instrument = \"spectroradiometer\"
c_deg = 0
gamma_deg = 0
repeats = 2
[[block]]
name = \"capped\"
kind = \"capped\"
c_deg = 0
gamma_deg = 0
repeats = 2
";

/// A job in `folder` with a second of light modulated by 20 %.
fn job(folder: &Utf8Path) -> Utf8PathBuf {
    let (station, calibration) = init::virtual_station(&Choice::default()).unwrap();
    let write = |name: &str, text: &str| std::fs::write(folder.join(name), text).unwrap();
    write("station.toml", &station);
    if let Some(calibration) = calibration {
        write("spectroradiometer.csv", &calibration);
    }
    write("plan.toml", PLAN);
    let scene = include_str!("../../src/init/scene.toml");
    write("scene.toml", &scene.replace("[2048, 2048]", "[64, 64]"));
    let value = |k: i32| 1.0 + 0.2 * (std::f64::consts::TAU * 100.0 * f64::from(k) / 20e3).sin();
    let lines: Vec<String> = (0..20_000).map(|k| value(k).to_string()).collect();
    write(
        "light.csv",
        &("# sample_rate_hz = 20000\nvoltage_V\n".to_owned() + &lines.join("\n")),
    );
    let job = folder.join("job.toml");
    let text = "format = \"isolux-job/1\"\nstation = \"station.toml\"\nplan = \"plan.toml\"\nscene = \"scene.toml\"\n\
                [light_modulation]\nwaveform = \"light.csv\"\ndark = 0.0\nexposures_ms = [2]\n";
    std::fs::write(&job, text).unwrap();
    job
}

#[test]
fn the_report_has_a_section_and_is_made_again_of_what_the_day_keeps() {
    let keep = tempfile::tempdir().unwrap();
    let folder = Utf8Path::from_path(keep.path()).unwrap();
    let out = folder.join("day");
    let options = Options {
        job: Some(job(folder)),
        out: Some(out.clone()),
        ..Options::default()
    };
    let day = day::run(&options, None, &Control::default(), &Silent).unwrap();
    let sentences = day.sentences.join("\n");
    assert!(sentences.contains("modulation depth      20.0"), "{sentences}");
    let report = std::fs::read_to_string(&day.report).unwrap();
    for words in [
        "Temporal light modulation",
        "SVM (IEC TR 63158)",
        "not given: a record of 1 s",
        "exposures of 2 ms",
    ] {
        assert!(report.contains(words), "{words}");
    }
    let text = std::fs::read_to_string(out.join("results/modulation.json")).unwrap();
    let found: Evaluated = serde_json::from_str(&text).unwrap();
    assert!((found.modulation.modulation_depth.value - 20.0).abs() < 0.01);
    assert!((found.modulation.svm.quantity.unwrap().value - 0.2 * 3.902).abs() < 1e-3);
    // The file that the job named is not needed any more.
    std::fs::remove_file(folder.join("light.csv")).unwrap();
    let again = folder.join("again.html");
    day::report(&out, None, Some(&again), false, None, Overwrite::Never, &Silent).unwrap();
    let again = std::fs::read_to_string(again).unwrap();
    assert!(again.contains("Temporal light modulation") && again.contains("exposures of 2 ms"));
    let request = verify::VerifyRequest {
        run: &out,
        public_key: None,
        station: None,
    };
    let verification = verify::run(&request, &Silent).unwrap();
    assert!(
        verification.agrees,
        "{:?}",
        verification.of(verify::State::Differs).collect::<Vec<_>>()
    );
    for name in [
        "results/modulation.json",
        "results/modulation-spectrum.svg",
        "results/report.html",
    ] {
        let file = verification.files.iter().find(|file| file.name == name).unwrap();
        assert_eq!(file.state, verify::State::Agrees, "{file:?}");
    }
}

#[test]
fn a_record_that_is_none_is_refused_before_anything_moves() {
    let keep = tempfile::tempdir().unwrap();
    let folder = Utf8Path::from_path(keep.path()).unwrap();
    let out = folder.join("day");
    let options = Options {
        job: Some(job(folder)),
        out: Some(out.clone()),
        ..Options::default()
    };
    std::fs::write(folder.join("light.csv"), "voltage_V\n1\n2\n").unwrap();
    let failure = day::run(&options, None, &Control::default(), &Silent).err().unwrap();
    assert_eq!(failure.kind, FailureKind::BadInput);
    assert!(
        failure.message.contains("light.csv") && failure.message.contains("--rate"),
        "{failure}"
    );
    assert!(!out.join("run.toml").exists());
}
