//! A power meter and a supply on the bench: what they give reaches the record, the files and the report.

use crate::folder::Folder;

const PLAN: &str = r#"format = "isolux-plan/1"
[[block]]
name = "distribution"
kind = "lit"
c_range = [0, 360, 90]
gamma_range = [0, 180, 5]
reference_every = 37
[[block]]
name = "lamp off"
kind = "lamp_off"
c_deg = 0
gamma_deg = 0
repeats = 2
"#;

/// A mains lamp with a power factor, so that no quantity can pass for another.
const LAMP: &str = "[lamp]\nvoltage_v = 230.0\npower_w = 5.0\npower_factor = 0.8\n[injected_effects]\nonly = true\n\
lamp_warmup = { amplitude_rel = 0.02, time_constant_s = 300.0, second_share = 0.0 }\n";

fn bench(room: &str, options: &[&str]) -> Folder {
    let folder = Folder::in_memory();
    folder.isolux(&["init", "bench"], 0);
    folder.write("bench/room.toml", room);
    let station = [
        "virtual",
        "darkroom",
        "bench/room.toml",
        "--in-memory",
        "--station-out",
        "bench/station.toml",
        "--force",
    ];
    folder.isolux(&[&station[..], options].concat(), 0);
    folder.write("bench/plan.toml", PLAN);
    let scene = folder.read("bench/scene.toml");
    folder.write("bench/scene.toml", &scene.replace("[2048, 2048]", "[32, 32]"));
    folder
}

/// The rows of readings.csv without its header, each as its cells, and a column by name.
fn rows(folder: &Folder, run: &str) -> (Vec<Vec<String>>, impl Fn(&[String], &str) -> String) {
    let text = folder.read(&format!("{run}/readings.csv"));
    let cells = |line: &str| line.split(',').map(str::to_owned).collect::<Vec<_>>();
    let mut lines = text.lines().map(cells);
    let header = lines.next().unwrap();
    let column = move |row: &[String], name: &str| row[header.iter().position(|known| known == name).unwrap()].clone();
    (lines.collect(), column)
}

#[test]
fn a_day_with_a_power_meter_ends_with_watts_and_lumens_per_watt() {
    let folder = bench(LAMP, &["--powermeter", "scpi-meter"]);
    let last = folder.isolux(&["run", "bench/job.toml", "--out", "day"], 0);
    let (rows, column) = rows(&folder, "day");
    let number = |row: &[String], name: &str| column(row, name).parse::<f64>().unwrap();
    let mut watts = Vec::new();
    for row in &rows {
        assert!((number(row, "voltage_v") / 230.0 - 1.0).abs() < 2e-3, "{row:?}");
        if column(row, "kind") == "lamp_off" {
            // A meter has nothing to divide by then, and says NAN.
            assert_eq!(number(row, "current_a"), 0.0);
            assert_eq!(column(row, "power_factor"), "");
            continue;
        }
        assert!((number(row, "power_factor") - 0.8).abs() < 2e-3, "{row:?}");
        let product = number(row, "voltage_v") * number(row, "current_a") * number(row, "power_factor");
        assert!((number(row, "power_w") / product - 1.0).abs() < 1e-3, "{row:?}");
        if column(row, "role") == "point" {
            watts.push(number(row, "power_w"));
        }
    }
    let mean = watts.iter().sum::<f64>() / watts.len() as f64;
    // The calibration of the twin is 0.08 % wrong.
    assert!((mean / 5.004 - 1.0).abs() < 1e-3, "{mean} W");
    let budget = folder.json("day/results/budget.json");
    let of = |pointer: &str| budget.pointer(pointer).unwrap().as_f64().unwrap();
    assert!((of("/electrical/power_w/mean") - mean).abs() < 1e-9);
    let (flux, efficacy) = (of("/flux/value"), of("/electrical/luminous_efficacy/value"));
    assert!(
        (efficacy / (flux / mean) - 1.0).abs() < 1e-12,
        "{flux} lm, {mean} W, {efficacy} lm/W"
    );
    assert!(
        (337.0 / 5.0 / efficacy - 1.0).abs() < 0.02,
        "{efficacy} lm/W of the lamp's own 67.4"
    );
    let written = format!("{mean:.4e}").parse::<f64>().unwrap().to_string();
    // EULUMDAT: the sixth line of the first lamp set, behind 26 lines. LM-63: behind ballast and photometric factor.
    let ldt = folder.read("day/results/luminaire.ldt");
    assert_eq!(ldt.lines().nth(31), Some(written.as_str()));
    let ies = folder.read("day/results/luminaire.ies");
    assert!(ies.lines().any(|line| line == format!("1 1 {written}")), "{ies}");
    let page = folder.read("day/results/report.html");
    for words in ["Electrical", "luminous efficacy", "power factor", "active power"] {
        assert!(page.contains(words), "{words}");
    }
    // Stated with its uncertainty, or without where that is not known, to the digits that it leaves; the page says the
    // same.
    let line = last
        .lines()
        .find_map(|line| line.strip_prefix("luminous efficacy"))
        .unwrap()
        .trim();
    let shown: f64 = line.split(' ').next().unwrap().parse().unwrap();
    assert!((shown / efficacy - 1.0).abs() < 0.02, "{line}: {efficacy} lm/W");
    assert!(page.contains(line), "{line}");
    // What is asked for by hand is the same line.
    let read = folder.isolux(&["read", "bench/station.toml"], 0);
    assert!(read.contains(" V, ") && read.contains("0.00000 A"), "{read}");
    let check = folder.isolux(&["check", "bench/station.toml"], 0);
    assert!(check.contains("GPM-8213") && check.contains(" W"), "{check}");
}

#[test]
fn a_power_meter_that_falls_silent_leaves_a_run_that_goes_on() {
    let fault = "[[fault]]\ninstrument = \"powermeter\"\nkind = \"silent\"\nat_s = 2000.0\nfor_s = 60.0\n";
    let folder = bench(&format!("{LAMP}{fault}"), &["--powermeter", "scpi-meter"]);
    let scan = ["scan", "bench/station.toml", "bench/plan.toml"];
    let stated = folder.isolux(&[&scan[..], &["--out", "run"]].concat(), 3);
    assert!(stated.contains("powermeter") && stated.contains("--resume"), "{stated}");
    let read = rows(&folder, "run").0.len();
    assert!((1..150).contains(&read), "{read} rows");
    folder.write("bench/room.toml", LAMP);
    folder.isolux(&[&scan[..], &["--resume", "run"]].concat(), 0);
    folder.isolux(&["reduce", "run"], 0);
}

#[test]
fn a_supply_feeds_the_lamp_and_switches_it() {
    let options = ["--powermeter", "scpi-meter", "--supply", "scpi-supply"];
    let folder = bench("", &options);
    let switched = folder.isolux(&["switch", "bench/station.toml", "--supply", "on"], 0);
    assert!(switched.contains("supply on"), "{switched}");
    let scan = ["scan", "bench/station.toml", "bench/plan.toml", "--out", "run"];
    folder.isolux(&scan, 0);
    let (rows, column) = rows(&folder, "run");
    let volts = |row: &[String]| column(row, "voltage_v").parse::<f64>().unwrap();
    for row in &rows {
        let expected = if column(row, "kind") == "lamp_off" { 0.0 } else { 24.0 };
        assert!((volts(row) - expected).abs() < 0.1, "{row:?}");
    }
    // A lamp with a supply has no switch of its own.
    let station = folder.read("bench/station.toml");
    folder.write(
        "bench/station.toml",
        &station.replace("[lamp]\n", "[lamp]\nprompt = \"switch it\"\n"),
    );
    let refused = folder.isolux(&["check", "bench/station.toml"], 2);
    assert!(
        refused.contains("lamp.prompt") && refused.contains("[supply]"),
        "{refused}"
    );
}

/// Without a power meter the record has its columns, empty, and the results none of it.
#[test]
fn without_a_power_meter_the_cells_are_empty_and_nothing_is_said_of_watts() {
    let folder = bench("", &[]);
    let scan = ["scan", "bench/station.toml", "bench/plan.toml", "--out", "run"];
    folder.isolux(&scan, 0);
    let (rows, column) = rows(&folder, "run");
    for name in ["voltage_v", "current_a", "power_w", "power_factor"] {
        assert!(rows.iter().all(|row| column(row, name).is_empty()), "{name}");
    }
    let stated = folder.isolux(&["reduce", "run"], 0);
    assert!(!stated.contains("luminous efficacy"), "{stated}");
    assert!(folder.json("run/results/budget.json").get("electrical").is_none());
    assert!(!folder.read("run/events.jsonl").contains("power"));
}
