//! `plan --for`: a scan of what one sensor sees, in minutes, and the sensor by it beside that of the light itself.

use crate::folder::Folder;
use serde_json::Value;

/// Seconds from the stable lamp to the end of the scan, by its events.
fn from_stable_s(folder: &Folder, run: &str) -> f64 {
    let events: Vec<Value> = folder
        .read(&format!("{run}/events.jsonl"))
        .lines()
        .map(|line| serde_json::from_str(line).unwrap())
        .collect();
    // 2026-01-01T12:34:56.789Z, in seconds of its day.
    let at = |name: &str| -> f64 {
        let event = events.iter().find(|event| event["event"] == name).unwrap();
        let clock = event["time_utc"].as_str().unwrap().split_once('T').unwrap().1;
        let parts = clock.trim_end_matches('Z').split(':');
        parts.fold(0.0, |sum, part| 60.0 * sum + part.parse::<f64>().unwrap())
    };
    (at("stopped") - at("stable")).rem_euclid(86_400.0)
}

#[test]
fn the_sensor_of_the_day_is_known_in_minutes_as_well_as_by_the_whole_scan() {
    let folder = Folder::in_memory();
    folder.isolux(&["init", "."], 0);
    let plan = ["plan", "station.toml", "plan.toml", "--for", "scene.toml"];
    let stated = folder.isolux(&[&plan[..], &["--u", "0.005", "--out", "near.toml"]].concat(), 0);
    // Rays from the rim of a disc of 73 mm to the corners of 24.576 mm: atan((36.5 + 17.38)/500) = 6.15°.
    assert!(
        stated.contains("from γ 0° to 6.2°") && !stated.contains("out of reach"),
        "{stated}"
    );
    folder.isolux(&["scan", "station.toml", "near.toml", "--out", "run"], 0);
    let seconds = from_stable_s(&folder, "run");
    assert!(seconds < 300.0, "{seconds} s");
    folder.isolux(&["reduce", "run"], 0);
    folder.isolux(&["simulate", "scene.toml", "--pixels", "64,64", "--out", "light"], 0);
    let result = folder.json("light/result.json");
    let (mean, u) = (result["mean"].as_f64().unwrap(), result["u_mean"].as_f64());
    // By the whole scan of the same room 4.29 ± 0.25 W/m² (k = 2), most of it from where in the luminous area the light
    // leaves.
    let u = u.unwrap_or_else(|| panic!("{}", result["u_mean_missing"]));
    assert!((mean - 4.29).abs() < 0.02 && (u - 0.126).abs() < 0.01, "{mean} ± {u}");

    // A sensor that sees more than was measured has no uncertainty.
    let wider = folder.read("scene.toml").replace("[24.576, 24.576]", "[80.0, 80.0]");
    folder.write("wider.toml", &wider);
    folder.isolux(&["simulate", "wider.toml", "--pixels", "64,64", "--out", "wide"], 0);
    let missing = folder.json("wide/result.json")["u_mean_missing"].to_string();
    assert!(
        missing.contains("alone was measured") && missing.contains("reaches the sensor"),
        "{missing}"
    );
}

#[test]
fn what_no_reading_can_reach_is_said() {
    let folder = Folder::new();
    folder.isolux(&["init", "."], 0);
    let plan = ["plan", "station.toml", "plan.toml", "--for", "scene.toml", "--u"];
    let stated = folder.isolux(&[&plan[..], &["0.001"]].concat(), 0);
    assert!(
        stated.contains("0.10 % is out of reach: calibration and distance alone are 0.4"),
        "{stated}"
    );
    assert!(stated.contains("[[block]]"), "{stated}");
    let stated = folder.isolux(&[&plan[..], &["5"]].concat(), 2);
    assert!(stated.contains("as 0.005"), "{stated}");
    folder.write(
        "silent.toml",
        &folder.read("station.toml").replace("noise_lx", "# noise_lx"),
    );
    let stated = folder.isolux(&["plan", "silent.toml", "plan.toml", "--for", "scene.toml"], 0);
    assert!(
        stated.contains("not known, and no part of that: [luxmeter] noise_rel and noise_lx"),
        "{stated}"
    );
    folder.write(
        "dark.toml",
        &folder.read("station.toml").replace("peak_cd", "# peak_cd"),
    );
    let stated = folder.isolux(&["plan", "dark.toml", "plan.toml", "--for", "scene.toml"], 2);
    assert!(stated.contains("give flux_lm and peak_cd"), "{stated}");
}
