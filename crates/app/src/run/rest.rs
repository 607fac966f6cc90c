//! In what state a run left the bench.

use camino::Utf8Path;
use isolux_record::{BenchState, Event, event};

/// How lamp, shutter, baffle and axes were left by the run directory `run`, and how the lamp is switched off; none
/// while it is written, and for a record that does not say so.
pub fn left_behind(run: &Utf8Path) -> Option<String> {
    match event::read(run).pop()?.event {
        Event::Stopped { left, .. } => Some(sentence(&left?, Some(Utf8Path::new("STATION.toml")))),
        _ => None,
    }
}

/// The same as a sentence; `station` is the file of a bench that goes on existing after the scan.
pub(crate) fn sentence(left: &BenchState, station: Option<&Utf8Path>) -> String {
    let lamp = match (left.lamp_is_on, station) {
        (Some(true), Some(station)) => format!(". To switch the lamp off: isolux switch {station} --lamp off"),
        (None, Some(_)) => ". The lamp is not switched by the station: look at it".to_owned(),
        _ => String::new(),
    };
    format!("The bench is left as it is: {left}{lamp}")
}
