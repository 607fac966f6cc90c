//! What a day may claim: conditions and requirements judged on the user's own path, each input left out in turn, and a
//! report that was issued amended.

use std::collections::BTreeMap;

use camino::{Utf8Path, Utf8PathBuf};
use isolux_app::day::{self, Options};
use isolux_app::files::Overwrite;
use isolux_app::front_end::control::Control;
use isolux_app::front_end::progress::{Event, Progress, Silent};
use isolux_app::init::subject::Subject;
use isolux_app::init::{self, DayPlan, Instruments};
use isolux_app::verify::{self, State, VerifyRequest};
use isolux_conformity::{Conformity, Outcome, Standing};
use isolux_record::Run;
use isolux_reduce::Budget;

struct Bench {
    _keep: tempfile::TempDir,
    folder: Utf8PathBuf,
}

const REQUIREMENTS: &str = "[requirements]\nrule = \"guarded\"\n\
    [[requirements.limit]]\nquantity = \"flux_lm\"\nrated = 337.0\ntolerance_rel = 0.1\n\
    [[requirements.limit]]\nquantity = \"i_max_cd\"\nlargest = 300.0\n\
    [[requirements.limit]]\nquantity = \"cct_k\"\nrated = 5700.0\ntolerance = 400.0\nrule = \"simple\"\n\
    [[requirements.limit]]\nquantity = \"efficacy_lm_w\"\nsmallest = 50.0\n";

const STATED: &str = "air_movement_m_s = { largest = 0.25, measured = [0.05, 0.1], u = 0.02 }\n\
    orientation_rel = { largest = 0.005, measured = [0.001, 0.002], u = 0.0005 }\n";

impl Bench {
    /// The bench that `init` writes, its job and station changed line by line.
    fn new(change: impl Fn(&str) -> String) -> Self {
        let keep = tempfile::tempdir().unwrap();
        let folder = Utf8Path::from_path(keep.path()).unwrap().to_owned();
        init::run(
            &folder,
            DayPlan::default(),
            &Instruments::default(),
            &Subject::default(),
            Overwrite::Never,
        )
        .unwrap();
        let edit = |name: &str, text: &dyn Fn(String) -> String| {
            let file = folder.join(name);
            let before = std::fs::read_to_string(&file).unwrap();
            std::fs::write(&file, text(before)).unwrap();
        };
        // A coarse grid: what is judged does not depend on it.
        edit("plan.toml", &|text| {
            text.replace("[0, 360, 15]", "[0, 360, 45]")
                .replace("[0, 180, 2]", "[0, 180, 10]")
        });
        edit("scene.toml", &|text| text.replace("2048", "64"));
        edit("job.toml", &|text| {
            let stated = text.replace("air_movement_m_s = { largest = 0.25, clause = \"4.2\" }\n", STATED);
            assert!(stated != text);
            change(&stated.replace("[luminaire]", &format!("{REQUIREMENTS}\n[luminaire]")))
        });
        edit("station.toml", &|text| change(&text));
        Self { _keep: keep, folder }
    }

    fn run(&self, progress: &dyn Progress) -> Utf8PathBuf {
        let day = self.folder.join("day");
        let options = Options {
            job: Some(self.folder.join("job.toml")),
            out: Some(day.clone()),
            ..Options::default()
        };
        day::run(&options, None, &Control::default(), progress).unwrap();
        day
    }
}

fn judged(day: &Utf8Path) -> Conformity {
    serde_json::from_slice(&std::fs::read(day.join("results/conformity.json")).unwrap()).unwrap()
}

fn standings(conformity: &Conformity) -> BTreeMap<String, Standing> {
    conformity
        .conditions
        .iter()
        .map(|one| (one.key.clone(), one.standing))
        .collect()
}

fn outcomes(conformity: &Conformity) -> BTreeMap<String, Outcome> {
    conformity
        .requirements
        .iter()
        .map(|one| (one.quantity.clone(), one.outcome))
        .collect()
}

/// What is said before anything moves.
#[derive(Default)]
struct Notes(std::sync::Mutex<Vec<String>>);

impl Progress for Notes {
    fn event(&self, event: Event<'_>) {
        if let Event::Note(note) = event {
            self.0.lock().unwrap().push(note.to_owned());
        }
    }
}

#[test]
fn a_day_is_judged_by_its_own_record_and_reports_it() {
    let bench = Bench::new(str::to_owned);
    let notes = Notes::default();
    let day = bench.run(&notes);
    let conformity = judged(&day);
    let run = Run::read(&day).unwrap();

    // The temperatures of the record, by 2 · 0.1 °C.
    let ambient: Vec<f64> = run.readings.rows.iter().filter_map(|row| row.ambient_c).collect();
    let kept = ambient.iter().all(|c| (c - 25.0).abs() + 0.2 <= 1.2);
    let standings = standings(&conformity);
    assert_eq!(standings["ambient_c"] == Standing::Met, kept, "{ambient:?}");
    let expected = [
        ("air_movement_m_s", Standing::Met),
        ("orientation_rel", Standing::Met),
        ("supply_voltage_v", Standing::NotKnown),
        ("operating_time_min", Standing::Met),
        ("stabilisation_rel", Standing::Met),
        ("power_stabilisation_rel", Standing::NotKnown),
        ("distance_ratio", Standing::Met),
    ];
    for (key, standing) in expected {
        assert_eq!(standings[key], standing, "{key}: {:#?}", conformity.conditions);
    }
    assert!(
        !standings.contains_key("supply_thd_rel"),
        "direct current has no harmonics"
    );

    // The numbers of budget.json, by the rule in its plain words.
    let budget: Budget = serde_json::from_slice(&std::fs::read(day.join("results/budget.json")).unwrap()).unwrap();
    let (flux, u) = (budget.flux.value, 2.0 * budget.flux.u.unwrap());
    assert!(flux - u >= 303.3 && flux + u <= 370.7, "{flux} {u}");
    let outcomes = outcomes(&conformity);
    assert_eq!(outcomes["flux_lm"], Outcome::Pass);
    assert!(budget.i_max.value - 2.0 * budget.i_max.u.unwrap() > 300.0);
    assert_eq!(outcomes["i_max_cd"], Outcome::Fail);
    assert_eq!(outcomes["cct_k"], Outcome::Pass);
    assert_eq!(outcomes["efficacy_lm_w"], Outcome::NotDecided);

    let notes = notes.0.into_inner().unwrap().join("\n");
    for word in [
        "supply_voltage_v",
        "power_stabilisation_rel",
        "requirement on efficacy_lm_w",
    ] {
        assert!(notes.contains(word), "{word} is not in\n{notes}");
    }
    let page = std::fs::read_to_string(day.join("results/report.html")).unwrap();
    for word in [
        "2 of 4 pass",
        "guarded by U",
        "Conditions against their limits",
        "What this report has to state",
    ] {
        assert!(page.contains(word), "{word}");
    }
}

/// Each input left out alone: what hangs on it is not known, and nothing else changes.
#[test]
fn what_is_left_out_is_not_known() {
    let whole = judged(&Bench::new(str::to_owned).run(&Silent));
    let table: [(&str, &str, &[&str], &[&str]); 7] = [
        ("u = 0.1, ", "", &["ambient_c"], &[]),
        ("nominal = 25.0, tolerance = 1.2, ", "", &["ambient_c"], &[]),
        (", u = 0.02 }", " }", &["air_movement_m_s"], &[]),
        ("measured = [0.001, 0.002], ", "", &["orientation_rel"], &[]),
        (
            "stabilisation_rel = { largest = 0.005, clause = \"4.4\" }\n",
            "",
            &["stabilisation_rel"],
            &[],
        ),
        (
            "diameter_mm = 73.0\n",
            "\n",
            &["distance_ratio"],
            &["flux_lm", "i_max_cd"],
        ),
        (
            "u_distance_mm = 2.0",
            "# none",
            &["distance_ratio"],
            &["flux_lm", "i_max_cd"],
        ),
    ];
    for (from, to, not_known, may_change) in table {
        let met = std::cell::Cell::new(false);
        let bench = Bench::new(|text| {
            met.set(met.get() || text.contains(from));
            text.replacen(from, to, 1)
        });
        assert!(met.get(), "nothing has {from}");
        let conformity = judged(&bench.run(&Silent));
        for (key, standing) in standings(&conformity) {
            if not_known.contains(&key.as_str()) {
                assert_eq!(standing, Standing::NotKnown, "{key} without {from}");
            } else {
                assert_eq!(standing, standings(&whole)[&key], "{key} without {from}");
            }
        }
        for (key, outcome) in outcomes(&conformity) {
            let allowed = may_change.contains(&key.as_str()) && outcome == Outcome::NotDecided;
            assert!(
                allowed || outcome == outcomes(&whole)[&key],
                "{key} without {from}: {outcome:?}"
            );
        }
    }
}

#[test]
fn an_issued_report_is_kept_when_it_is_amended() {
    let issued = |text: &str| {
        text.replace("# issued = \"\"", "issued = \"2026-11-28\"")
            .replace("# customer = \"\"", "customer = \"Smith\"")
    };
    let bench = Bench::new(issued);
    let day = bench.run(&Silent);
    let results = day.join("results");
    let report = |amend: Option<&str>| day::report(&day, None, None, false, amend, Overwrite::Force, &Silent);
    let job = bench.folder.join("job.toml");
    let again = |amend: Option<&str>| {
        let options = Options {
            job: Some(job.clone()),
            out: Some(day.clone()),
            resume: true,
            amend: amend.map(str::to_owned),
            ..Options::default()
        };
        day::run(&options, None, &Control::default(), &Silent).unwrap();
    };
    // The same again is no amendment.
    report(None).unwrap();
    assert!(!results.join("amendments.json").exists());
    let first = std::fs::read(results.join("report.html")).unwrap();
    assert!(
        report(Some("why"))
            .unwrap_err()
            .message
            .contains("nothing in the report would change")
    );

    let text = std::fs::read_to_string(&job).unwrap();
    std::fs::write(&job, text.replace("\"Smith\"", "\"Smythe\"")).unwrap();
    again(Some("name of the customer"));
    assert!(std::fs::read(results.join("amendments/0/report.html")).unwrap() == first);
    let page = std::fs::read_to_string(results.join("report.html")).unwrap();
    for word in [
        "Amendment 1",
        "name of the customer",
        "<td>Smith</td><td>Smythe</td>",
        "· amendment 1",
    ] {
        assert!(page.contains(word), "{word}");
    }
    // Without a reason too: an issued report is not lost.
    std::fs::write(&job, text.replace("\"Smith\"", "\"Smithson\"")).unwrap();
    again(None);
    let page = std::fs::read_to_string(results.join("report.html")).unwrap();
    assert!(
        page.contains("Amendment 2")
            && page.contains("Amendment 1")
            && page.contains("<td>Smythe</td><td>Smithson</td>")
    );
    assert!(results.join("amendments/1/report.html").is_file());
    // Every file of the day, the reports that were replaced among them, is as it was written.
    let differing = || -> Vec<String> {
        let request = VerifyRequest {
            run: &day,
            public_key: None,
            station: None,
        };
        let found = verify::run(&request, &Silent).unwrap();
        found.of(State::Differs).map(|file| file.name.clone()).collect()
    };
    assert_eq!(differing(), Vec::<String>::new());
    std::fs::write(results.join("amendments/0/report.html"), "another").unwrap();
    assert_eq!(differing(), ["results/amendments/0/report.html"]);
}
