//! A lamp that drifts beyond the limits of the plan, seen by nothing but the closing half-plane: no result from the
//! command line, unless a person accepts it.

use crate::folder::Folder;

/// A lamp that falls by 1.5 % an hour, read at a metre where the display shows it.
const ROOM: &str =
    "format = \"isolux-darkroom/1\"\n[injected_effects]\nonly = true\nlamp_drift = { rate_per_h = -0.015 }\n";

const PLAN: &str = r#"format = "isolux-plan/1"
[limits]
closing_rel = 0.001
[[block]]
name = "distribution"
kind = "lit"
c_range = [0, 360, 45]
gamma_range = [0, 180, 15]
distance_mm = 1100.0
[[block]]
name = "lamp off"
kind = "lamp_off"
c_deg = 0
gamma_deg = 0
distance_mm = 1100.0
"#;

#[test]
fn a_drifting_lamp_gives_no_result_unless_it_is_accepted() {
    let folder = Folder::in_memory();
    folder.isolux(&["init", "bench"], 0);
    folder.write("bench/plan.toml", PLAN);
    folder.write("bench/room.toml", ROOM);
    let station = folder.read("bench/station.toml");
    let named = station.replacen("name = ", "darkroom = \"room.toml\"\nname = ", 1);
    folder.write("bench/station.toml", &named);
    folder.isolux(&["scan", "bench/station.toml", "bench/plan.toml", "--out", "run"], 0);

    let stated = folder.command(&["reduce", "run"]).output().unwrap();
    assert_eq!(stated.status.code(), Some(1));
    let words = String::from_utf8_lossy(&stated.stderr).into_owned();
    for part in ["limits.closing_rel 0.10 %", "row 104 at 2", "lx", "--accept-drift"] {
        assert!(words.contains(part), "{part}: {words}");
    }
    assert!(!folder.path("run/results").exists());

    let stated = folder.isolux(&["reduce", "--accept-drift=the lamp is old", "run"], 0);
    assert!(
        stated.contains("accepted (the lamp is old)") && !stated.contains('±'),
        "{stated}"
    );
    for file in [
        "budget.json",
        "provenance.json",
        "luminaire.model.toml",
        "luminaire.ldt",
        "luminaire.ies",
    ] {
        let text = folder.read(&format!("run/results/{file}"));
        assert!(text.contains("drift beyond the limits was accepted"), "{file}");
    }
    // What is computed from it has no ± either, and says why; the report is of the reduction that was accepted.
    folder.isolux(&["report", "run", "--out", "report.html"], 0);
    assert!(folder.read("report.html").contains("accepted (the lamp is old)"));
    let map = folder.isolux(&["simulate", "run", "--pixels", "16", "--out", "map"], 0);
    assert!(map.contains("no uncertainty") && map.contains("by quadrature"), "{map}");
    let result = folder.json("map/result.json");
    assert!(result["u_mean"].is_null(), "{result}");
    assert!(result["u_mean_missing"].to_string().contains("accepted"), "{result}");
}
