//! In what state a run left the bench.

use camino::Utf8Path;
use isolux_scan::BenchState;
use serde_json::Value;

/// How lamp, shutter, baffle and axes were left by the run directory `run`, and how the lamp is switched off; none
/// while it is written, and for a record that does not say so.
pub fn left_behind(run: &Utf8Path) -> Option<String> {
    let events = std::fs::read_to_string(run.join("events.jsonl")).ok()?;
    let last: Value = serde_json::from_str(events.lines().last()?).ok()?;
    if last["event"] != "stopped" {
        return None;
    }
    let left = last["left"].as_object()?;
    let (number, flag) = (
        |key: &str| left.get(key)?.as_f64(),
        |key: &str| left.get(key)?.as_bool(),
    );
    let left = BenchState {
        c_deg: number("c_deg"),
        gamma_deg: number("gamma_deg"),
        axes_at_rest: flag("axes_at_rest")?,
        lamp_is_on: flag("lamp_is_on"),
        shutter_is_open: flag("shutter_is_open"),
        baffle_is_in: flag("baffle_is_in"),
    };
    let off = match left.lamp_is_on {
        Some(true) => ". To switch the lamp off: isolux switch STATION.toml --lamp off",
        Some(false) => "",
        None => ". The lamp is not switched by the station: look at it",
    };
    Some(format!("The bench is left as it is: {left}{off}"))
}
