//! A day whose job has `[ratings]` and `[eu_label]`: they reach the record, the report and `eu_label.csv`; left out
//! they reach nothing.

use crate::folder::Folder;

const PLAN: &str = r#"format = "isolux-plan/1"
[[block]]
name = "distribution"
kind = "lit"
c_range = [0, 360, 90]
gamma_range = [0, 180, 5]
reference_every = 37
[[block]]
name = "spectrum"
kind = "lit"
instrument = "spectroradiometer"
c_deg = 0
gamma_deg = 0
repeats = 3
"#;

const LAMP: &str = "[lamp]\nvoltage_v = 230.0\npower_w = 5.0\npower_factor = 0.8\n[injected_effects]\nonly = true\n\
lamp_warmup = { amplitude_rel = 0.02, time_constant_s = 300.0, second_share = 0.0 }\n";

const RATED: &str = "\n[ratings]\nstreet_side_c_deg = 90\nrated_xy = [0.3221, 0.3318]\n[eu_label]\nmains = true\n\
[eu_label.stated]\ncap_type = \"E27, or none\"\nlifetime_h = \"25000\"\n";

fn bench() -> Folder {
    let folder = Folder::in_memory();
    folder.isolux(&["init", "bench"], 0);
    folder.write("bench/room.toml", LAMP);
    folder.isolux(
        &[
            "virtual",
            "darkroom",
            "bench/room.toml",
            "--in-memory",
            "--station-out",
            "bench/station.toml",
            "--force",
            "--powermeter",
            "scpi-meter",
        ],
        0,
    );
    folder.write("bench/plan.toml", PLAN);
    let scene = folder.read("bench/scene.toml");
    folder.write("bench/scene.toml", &scene.replace("[2048, 2048]", "[32, 32]"));
    folder
}

#[test]
fn what_the_job_states_is_rated_and_nothing_else() {
    let folder = bench();
    let job = folder.read("bench/job.toml");
    folder.isolux(&["run", "bench/job.toml", "--out", "plain"], 0);
    assert!(!folder.path("plain/results/eu_label.csv").exists());
    let page = folder.read("plain/results/report.html");
    for words in ["EU energy label", "TM-15", "steps of 0.0011 in u′v′ (CIE TN 001)"] {
        assert!(!page.contains(words), "{words}");
    }
    for words in ["K_B,v", "PPF", "Mean luminance"] {
        assert!(page.contains(words), "{words}");
    }

    folder.write("bench/job.toml", &format!("{job}{RATED}"));
    folder.isolux(&["run", "bench/job.toml", "--out", "day"], 0);
    let header = folder.read("day/run.toml");
    assert!(header.contains("[ratings]") && header.contains("[eu_label"), "{header}");
    let page = folder.read("day/results/report.html");
    for words in [
        "EU energy label",
        "TM-15",
        "street",
        "Class G",
        "displacement factor",
        "steps of 0.0011",
    ] {
        assert!(page.to_lowercase().contains(&words.to_lowercase()), "{words}");
    }
    let table = folder.read("day/results/eu_label.csv");
    let line = |name: &str| {
        let found = table.lines().find(|line| line.split(',').next() == Some(name));
        found.unwrap_or_else(|| panic!("{name}: {table}"))
    };
    // The room's own lamp: a narrow beam, some 300 lm in the cone of 90°, of 5 W, times 1.176.
    assert!(line("energy_class").starts_with("energy_class,G,,7"), "{table}");
    assert!(line("directional").starts_with("directional,DLS,,9"), "{table}");
    assert!(line("useful_flux_in").contains("narrow cone"), "{table}");
    assert!(
        line("energy_consumption").starts_with("energy_consumption,6,kWh/1000 h,5.0"),
        "{table}"
    );
    assert!(line("cct").starts_with("cct,5900,K,"), "{table}");
    assert_eq!(line("cap_type"), "cap_type,\"E27, or none\",,,,,stated");
    assert!(line("displacement_factor").contains("not known"), "{table}");
    assert!(line("colour_consistency").ends_with(",measured"), "{table}");

    folder.isolux(&["verify", "day"], 0);

    // The same tables from the day's own folder: a report that is made again has them.
    folder.isolux(&["report", "day", "--force"], 0);
    assert!(folder.read("day/results/report.html").contains("EU energy label"));

    // A key that is not known is refused before anything moves, with its line.
    folder.write(
        "bench/job.toml",
        &format!("{job}{}", RATED.replace("lifetime_h", "life_h")),
    );
    let refused = folder.isolux(&["run", "bench/job.toml", "--out", "none"], 2);
    assert!(
        refused.contains("life_h") && refused.contains("lifetime_h"),
        "{refused}"
    );
    assert!(!folder.path("none").exists());
}
