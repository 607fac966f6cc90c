//! A day with every section that a day can have: its results are read back, its report is translated.

use camino::Utf8Path;
use isolux_app::day::{self, Options};
use isolux_app::files::Overwrite;
use isolux_app::front_end::control::Control;
use isolux_app::front_end::progress::Silent;
use isolux_app::init::subject::Subject;
use isolux_app::init::{self, DayPlan, Instruments};

use crate::{languages, results_are_types};

/// A job with every section that a day can have without instruments of its own.
const MORE: &str = "[requirements]\nrule = \"guarded\"\n\
    [[requirements.limit]]\nquantity = \"flux_lm\"\nsmallest = 300.0\n\
    [[requirements.limit]]\nquantity = \"ra\"\nsmallest = 95.0\nrule = \"simple\"\n\
    [[requirements.limit]]\nquantity = \"svm\"\nlargest = 0.4\n\
    [[requirements.limit]]\nquantity = \"efficacy_lm_w\"\nsmallest = 50.0\n\
    [light_modulation]\nwaveform = \"waveform.csv\"\nexposures_ms = [3.0]\nline_time_us = 20.0\n\
    [ratings]\nstreet_side_c_deg = 90.0\n\
    [eu_label]\nmains = true\n";

#[test]
fn a_day_with_every_section_is_read_back_and_translated() {
    let keep = tempfile::tempdir().unwrap();
    let bench = Utf8Path::from_path(keep.path()).unwrap();
    let subject = Subject::default();
    init::run(
        bench,
        DayPlan::default(),
        &Instruments::default(),
        &subject,
        Overwrite::Never,
    )
    .unwrap();
    let job = bench.join("job.toml");
    let text = std::fs::read_to_string(&job).unwrap();
    std::fs::write(&job, format!("{text}{MORE}")).unwrap();
    let scene = bench.join("scene.toml");
    let text = std::fs::read_to_string(&scene).unwrap();
    std::fs::write(&scene, text.replace("2048", "256")).unwrap();
    let light = (0..20_000).map(|k| {
        format!(
            "{:.6}\n",
            1.0 + 0.1 * (std::f64::consts::TAU * f64::from(k) / 100.0).sin()
        )
    });
    std::fs::write(
        bench.join("waveform.csv"),
        format!("# sample_rate_hz = 10000\nlight\n{}", light.collect::<String>()),
    )
    .unwrap();
    let folder = bench.join("day");
    let options = Options {
        job: Some(job),
        out: Some(folder.clone()),
        ..Options::default()
    };
    day::run(&options, None, &Control::default(), &Silent).unwrap();
    results_are_types::results_are_read_back(&folder);
    languages::every_text_is_translated(&folder);
}
