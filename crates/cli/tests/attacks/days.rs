//! The whole day from the command line, on a coarse grid: what it writes, what its numbers are, and the same
//! numbers twice. Nothing disturbs it; it computes at low priority while the attacks wait for their instruments.

use crate::folder::Folder;
use serde_json::Value;

const PLAN: &str = r#"format = "isolux-plan/1"
[[block]]
name = "distribution"
kind = "lit"
c_range = [0, 360, 45]
gamma_range = [0, 180, 5]
reference_every = 37
[[block]]
name = "baffled"
kind = "baffled"
c_deg = 0
gamma_range = [0, 180, 30]
repeats = 3
[[block]]
name = "spectrum"
kind = "lit"
instrument = "spectroradiometer"
c_deg = 0
gamma_deg = 0
repeats = 10
[[block]]
name = "lamp off"
kind = "lamp_off"
c_deg = 0
gamma_deg = 0
repeats = 10
"#;

const RESULTS: [&str; 14] = [
    "budget.json",
    "comparison.json",
    "irradiance.npy",
    "irradiance.png",
    "luminaire.directions.csv",
    "luminaire.ies",
    "luminaire.ldt",
    "luminaire.model.toml",
    "luminaire.spd",
    "luminaire.spdx",
    "luminaire.xml",
    "provenance.json",
    "report.html",
    "result.json",
];

/// A job with the coarse plan and a small sensor, `bench/job.toml`.
fn job() -> Folder {
    let folder = Folder::new().at_low_priority();
    folder.isolux(
        &[
            "init",
            "bench",
            "--luminaire",
            "maker=ACME",
            "--luminaire",
            "name=Spot 12",
            "--report",
            "number=R-7",
        ],
        0,
    );
    folder.write("bench/plan.toml", PLAN);
    let scene = folder.read("bench/scene.toml");
    folder.write("bench/scene.toml", &scene.replace("[2048, 2048]", "[64, 64]"));
    folder
}

/// The calibration of the spectroradiometer is off by a quarter: no emitter of that diameter makes the gap, and what
/// could is said.
pub fn a_gap_on_the_axis_is_told_with_what_could_make_it() {
    let folder = job();
    let calibration = folder.read("bench/spectroradiometer.csv");
    let scaled = calibration.lines().map(|line| match line.split_once(',') {
        Some((nm, factor)) => match factor.parse::<f64>() {
            Ok(factor) => format!("{nm},{}\n", 1.25 * factor),
            Err(_) => format!("{line}\n"),
        },
        None => format!("{line}\n"),
    });
    folder.write("bench/spectroradiometer.csv", &scaled.collect::<String>());
    let last = folder.isolux(&["run", "bench/job.toml", "--out", "day"], 0);
    let comparison = folder.json("day/results/comparison.json");
    let number = |key: &str| comparison[key].as_f64().unwrap();
    assert!((number("gap_rel") + 0.2).abs() < 0.01, "{comparison}");
    assert!(
        number("as_given_sigma") < 3.0 * number("gap_sigma") && number("gap_sigma") < -5.0,
        "{comparison}"
    );
    let finding = &comparison["finding"];
    assert!(finding["p_global"].as_f64().unwrap() < 0.01, "{comparison}");
    assert_eq!(finding["verdict"], "ambiguous", "{comparison}");
    assert!(
        last.contains("All light differs from the model by one factor, of the lamp or of a meter's calibration"),
        "{last}"
    );
    let page = folder.read("day/results/report.html");
    assert!(page.contains("Simulation and measurement disagree on the axis at 500 mm"));
}

pub fn the_day_ends_with_files_that_agree_with_what_was_read() {
    let folder = job();
    let day = folder.path("day");
    let run = ["run", "bench/job.toml", "--out", "day"];
    let last = folder.isolux(&run, 0);
    for word in [
        "luminous flux",
        "CCT",
        "mean on the sensor",
        "test, axis at 500 mm",
        "gap",
        "σ",
        "report.html",
    ] {
        assert!(last.contains(word), "{word} is not in\n{last}");
    }
    // The day's own readings made the model: that they agree is no evidence, and no p-value makes it look like some.
    assert!(
        last.contains("self-check  consistency check of the record") && last.contains("no test of the model"),
        "{last}"
    );
    assert!(!last.contains("p = ") && !last.contains("p=1"), "{last}");
    let answer = folder.json("day/results/diagnosis.json");
    assert_eq!(answer["independence"], "same_run");
    assert!(answer["noise"]["p_global"].is_null(), "{answer}");
    // 8 half-planes × 37 γ made the distribution; what checks it is the closing half-plane, the visits and the dark
    // and baffled readings.
    let notes = answer["notes"].as_array().unwrap();
    assert!(
        notes
            .iter()
            .any(|note| note.as_str().unwrap().starts_with("296 of ")
                && note.as_str().unwrap().contains("were left out")),
        "{answer}"
    );
    let page = folder.read("day/results/report.html");
    for words in [
        "The test: simulated against measured, on the axis at 500 mm",
        "Consistency check of the record",
        "The test of this day is the comparison on the axis, above.",
        "Photometric report: ACME Spot 12",
        "Report R-7",
        "CIE flux code",
        "beam angle (50 %)",
        "expanded uncertainty U, k = 2",
        "not measured",
        "End of the report.",
    ] {
        assert!(page.contains(words), "{words}");
    }
    assert!(!page.contains("p = 1.000") && !page.contains("simulated scans disagree"));
    // One ± means one thing, and the station's name is no luminaire.
    assert!(!last.contains("k = 1") && last.contains("(k = 2)"), "{last}");
    assert!(!page.contains("virtual darkroom"));
    let ldt = folder.read("day/results/luminaire.ldt");
    assert!(
        ldt.starts_with("ACME\r\n") && ldt.lines().nth(8) == Some("Spot 12"),
        "{ldt}"
    );
    let header = folder.read("day/run.toml");
    assert!(
        header.contains("[luminaire]\nmaker = \"ACME\"") && header.contains("number = \"R-7\""),
        "{header}"
    );
    // By hand it is the same; against readings of another day it is a test.
    let one_step = [
        "diagnose",
        "day/results/luminaire.model.toml",
        "day",
        "--out",
        "by-hand",
    ];
    let stated = folder.isolux(&one_step, 0);
    assert!(
        stated.contains("consistency   the model was made from these readings") && !stated.contains("p = "),
        "{stated}"
    );
    assert!(
        folder
            .read("by-hand/report.html")
            .contains("Consistency check of the record")
    );
    let plan = folder.read("bench/plan.toml");
    folder.write("bench/other.toml", &plan.replace("[0, 180, 5]", "[0, 180, 10]"));
    folder.isolux(&["scan", "bench/station.toml", "bench/other.toml", "--out", "other"], 0);
    let stated = folder.isolux(
        &["diagnose", "day/results/luminaire.model.toml", "other", "--out", "test"],
        0,
    );
    assert!(!stated.contains("consistency") && stated.contains("p = "), "{stated}");
    assert!(folder.json("test/diagnosis.json")["noise"]["p_global"].is_number());
    for file in RESULTS {
        let length = std::fs::metadata(day.join("results").join(file)).map_or(0, |about| about.len());
        assert!(length > 0, "{file} is missing or empty");
    }

    // The lamp of this room has 337 lm.
    let budget = folder.json("day/results/budget.json");
    let (flux, u) = (
        budget["flux"]["value"].as_f64().unwrap(),
        budget["flux"]["u"].as_f64().unwrap(),
    );
    assert!((flux - 337.0).abs() < 2.0 * u && u < 0.03 * flux, "{flux} ± {u} lm");
    let inspect = ["inspect", "--json", "day/results/luminaire.ldt"];
    let stated: Value = serde_json::from_slice(&folder.command(&inspect).output().unwrap().stdout).unwrap();
    let in_file = stated["quantities"]["flux_lm"].as_f64().unwrap();
    assert!((in_file - flux).abs() < u, "{in_file} lm in the file, {flux} ± {u} lm");

    // LED rings in place of an even disc of their diameter: 0.1 % on the axis, of 3 % that is not known of it, of its
    // level and of its drift.
    let comparison = folder.json("day/results/comparison.json");
    let gap = |key: &str| {
        comparison[key]
            .as_f64()
            .unwrap_or_else(|| panic!("{key} in {comparison}"))
    };
    assert!(gap("gap_rel").abs() < 0.006, "{comparison}");
    let simulated = &comparison["simulated_lx"];
    let u_rel = simulated["u"].as_f64().unwrap() / simulated["value"].as_f64().unwrap();
    assert!((u_rel - 0.0309).abs() < 0.001, "{comparison}");
    assert_eq!(comparison["finding"]["verdict"], "consistent", "{comparison}");

    // What the model predicts is what was read, kind by kind.
    let model = "day/results/luminaire.model.toml";
    folder.isolux(&["predict", model, "day", "--out", "predicted.csv"], 0);
    let table = folder.read("predicted.csv");
    let mut lines = table.lines();
    let head: Vec<&str> = lines.next().unwrap().split(',').collect();
    let column = |name: &str| head.iter().position(|it| *it == name).unwrap();
    let (kind, read, u, stated) = (
        column("kind"),
        column("illuminance_lx"),
        column("u_lx"),
        column("predicted_illuminance_lx"),
    );
    let rows: Vec<Vec<&str>> = lines.map(|line| line.split(',').collect()).collect();
    for wanted in ["lit", "baffled", "lamp_off"] {
        let z2: Vec<f64> = rows
            .iter()
            .filter(|row| row[kind] == wanted)
            .map(|row| {
                let number = |at: usize| row[at].parse::<f64>().unwrap();
                ((number(read) - number(stated)) / number(u)).powi(2)
            })
            .collect();
        let rms = (z2.iter().sum::<f64>() / z2.len() as f64).sqrt();
        assert!(
            !z2.is_empty() && rms < 1.5,
            "{wanted}: {} readings, rms {rms} u",
            z2.len()
        );
    }

    // The same folder again is refused, and nothing in it is touched.
    let before = std::fs::read(day.join("readings.csv")).unwrap();
    folder.isolux(&run, 2);
    assert_eq!(std::fs::read(day.join("readings.csv")).unwrap(), before);

    // A diagnosis that cannot be written costs nothing but itself.
    std::fs::remove_dir_all(day.join("results/diagnosis")).unwrap();
    folder.write("day/results/diagnosis", "a file where its folder should be");
    std::fs::remove_file(day.join("results/report.html")).unwrap();
    let stated = folder.isolux(&["run", "--resume", "day"], 0);
    assert!(
        stated.contains("the diagnosis failed, and the report is made without it"),
        "{stated}"
    );
    let page = folder.read("day/results/report.html");
    assert!(
        page.contains("The diagnosis failed, and the report is made without it") && page.contains("End of the report.")
    );
    assert!(!day.join("results/diagnosis.json").exists());
}

pub fn one_seed_gives_one_day() {
    let folder = job();
    let days = ["first", "second"];
    for day in days {
        folder.isolux(&["run", "bench/job.toml", "--out", day], 0);
    }
    // The record and every number of the results; run.toml, events and provenance hold the time of day.
    for file in RESULTS
        .map(|file| format!("results/{file}"))
        .iter()
        .map(String::as_str)
        .chain(["readings.csv"])
    {
        if ["results/provenance.json", "results/report.html"].contains(&file) {
            continue;
        }
        let [a, b] = days.map(|day| std::fs::read(folder.path(day).join(file)).unwrap());
        assert!(a == b, "{file} differs");
    }
    let said = folder.isolux(&["compare", "first", "second"], 0);
    assert!(
        said.contains("100.0 % of the directions within U: agrees") && !said.contains("DIFFERS"),
        "{said}"
    );
}

/// The flux that `reduce` said, as it stands in the report.
fn flux(stated: &str) -> String {
    let line = stated.lines().find_map(|line| line.strip_prefix("flux "));
    line.unwrap_or_else(|| panic!("no flux in {stated}")).to_owned()
}

pub fn a_day_is_taken_up_and_reported_as_it_was_asked_and_reduced() {
    let folder = job();
    let scene = folder.read("bench/scene.toml");
    let requested = scene.replace("distance_mm = 500.0", "distance_mm = 1000.0");
    assert_ne!(scene, requested);
    let text = folder.read("bench/job.toml");
    folder.write("bench/job.toml", &text.replace("# sample = \"\"", "sample = \"S1\""));
    folder.write("bench/scene.toml", &requested);
    folder.isolux(&["run", "bench/job.toml", "--out", "day"], 0);
    let result = folder.read("day/results/result.json");

    // The day is in the diary of its bench, once.
    let diary = folder.read("bench/history.jsonl");
    for of_lamp in ["luminous flux", "CCT", "reference reading"] {
        let quantity = format!("Spot 12 S1: {of_lamp}\"");
        assert_eq!(diary.matches(&quantity).count(), 1, "{diary}");
    }
    let page = folder.read("day/results/report.html");
    assert!(page.contains("no calibration and no check was in it"));

    // The day knows its job, whatever becomes of the files that it came from.
    folder.write("bench/scene.toml", &scene);
    folder.isolux(&["run", "--resume", "day"], 0);
    assert_eq!(folder.read("bench/history.jsonl"), diary);
    assert_eq!(folder.read("day/results/result.json"), result);
    folder.isolux(&["report", "day", "--out", "a.html"], 0);
    let page = folder.read("a.html");
    assert!(page.contains("Consistency check of the record") && !page.contains("not shown:"));
    let result = folder.json("day/results/result.json");
    let uniformity = result["uniformity_min_over_mean"].as_f64().unwrap();
    assert!(page.contains(&format!("{uniformity:.5}")), "{uniformity}");
    // The same on paper: the same bytes from the same record; without a name beside the page, where it is not replaced.
    folder.isolux(&["report", "day", "--pdf", "--out", "a.pdf"], 0);
    let stated = folder.isolux(&["report", "day", "--pdf"], 0);
    assert!(stated.contains("day/results/report.pdf"), "{stated}");
    let refused = folder.isolux(&["report", "day", "--pdf"], 2);
    assert!(refused.contains("--force"), "{refused}");
    let [paper, again] = ["a.pdf", "day/results/report.pdf"].map(|name| std::fs::read(folder.path(name)).unwrap());
    assert!(
        paper.starts_with(b"%PDF-") && paper == again && paper.len() > 50_000,
        "{} bytes",
        paper.len()
    );

    // Whoever makes the page anew makes the paper beside it anew.
    let paper = || std::fs::read(folder.path("day/results/report.pdf")).unwrap();
    folder.write("day/results/report.pdf", "of other results");
    folder.isolux(&["run", "--resume", "day"], 0);
    assert!(paper().starts_with(b"%PDF-"));
    folder.write("day/results/report.pdf", "of other results");
    std::fs::remove_file(folder.path("day/results/report.html")).unwrap();
    let stated = folder.isolux(&["report", "day"], 0);
    assert!(stated.contains("report.pdf is not of these results"), "{stated}");
    assert_eq!(paper(), b"of other results");
    folder.isolux(&["report", "day", "--force"], 0);
    assert!(paper() == again);

    // The page is of the reduction that lies in the folder; the diagnosis beside it is of the one before.
    let model = folder.read("day/results/luminaire.model.toml");
    let offset = "\n[[effect]]\nname = \"distance_offset\"\noffset_mm = 300.0\n";
    folder.write("day/results/with.model.toml", &(model + offset));
    let first = flux(&folder.isolux(&["reduce", "day", "--out", "again"], 0));
    assert!(page.contains(&first), "{first}");
    let changes: [&[&str]; 2] = [
        &["--without", "ambient", "stray"],
        &["--with", "day/results/with.model.toml"],
    ];
    for (k, change) in changes.into_iter().enumerate() {
        let stated = folder.isolux(&[&["reduce", "day", "--force"], change].concat(), 0);
        let reduced = flux(&stated);
        assert_ne!(reduced, first);
        assert!(
            stated.contains("report.html and report.pdf beside these results: of earlier ones"),
            "{stated}"
        );
        let out = format!("b{k}.html");
        folder.isolux(&["report", "day", "--out", &out], 0);
        let page = folder.read(&out);
        assert!(page.contains(&reduced) && !page.contains(&first), "{reduced}");
        assert!(!page.contains("Consistency check of the record"));
        assert!(page.contains("result.json, comparison.json, conformity.json, diagnosis.json"));
    }

    // Without its job, what the day was asked is not guessed.
    std::fs::remove_dir_all(folder.path("day/job")).unwrap();
    let before = folder.read("day/results/result.json");
    let refused = folder.isolux(&["run", "--resume", "day"], 2);
    assert!(refused.contains("give the job"), "{refused}");
    folder.isolux(&["report", "day", "--out", "c.html"], 2);
    assert_eq!(folder.read("day/results/result.json"), before);
    assert!(!folder.path("c.html").exists());
    folder.isolux(&["report", "day", "--job", "bench/job.toml", "--out", "c.html"], 0);

    // Nor is a reduction that nobody can make again.
    let budget = folder.read("day/results/budget.json");
    let other = budget.replacen("\"value\": ", "\"value\": 1", 1);
    assert_ne!(budget, other);
    folder.write("day/results/budget.json", &other);
    let report = ["report", "day", "--job", "bench/job.toml", "--out", "d.html"];
    let refused = folder.isolux(&report, 2);
    assert!(refused.contains("budget.json"), "{refused}");
}

pub fn a_day_in_motion_agrees_with_its_model_and_with_the_lamp() {
    let folder = Folder::in_memory().at_low_priority();
    folder.isolux(&["init", ".", "--sweep"], 0);
    let scene = folder.read("scene.toml");
    folder.write("scene.toml", &scene.replace("[2048, 2048]", "[64, 64]"));
    let last = folder.isolux(&["run", "job.toml", "--out", "day"], 0);
    // The lamp of the built-in room has 337 lm.
    let flux = last.lines().find(|line| line.starts_with("luminous flux")).unwrap();
    let lumen: f64 = flux.split_whitespace().nth(2).unwrap().parse().unwrap();
    assert!((lumen - 337.0).abs() < 4.0, "{flux}");
    assert!(last.contains("its readings agree with the model"), "{last}");
    // The floor's light is known by the readings behind the baffle, and is in the model.
    let model = folder.read("day/results/luminaire.model.toml");
    assert!(model.contains("name = \"floor_reflection\""), "{model}");
}
