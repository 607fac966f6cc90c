//! Quantities for a person to read: six digits, and the glare table as a table. Programs take `--json`, which has every digit.

use serde_json::{Map, Value};

use crate::screen;

/// Six significant digits are more than any photometer has.
const DIGITS: usize = 6;
/// Values of a list on one line: the half-planes at 15°, the zones at 10°.
const AT_ONCE: usize = 24;

/// A line a quantity; what could not be computed is left out.
pub fn print<'a>(quantities: impl Iterator<Item = (&'a String, &'a Value)>) {
    for (key, value) in quantities {
        match value {
            Value::Null => {}
            Value::Object(table) => glare(key, table),
            Value::Array(list) => {
                let first: Vec<String> = list.iter().take(AT_ONCE).map(word).collect();
                let rest = if list.len() > AT_ONCE {
                    format!(" … ({} values)", list.len())
                } else {
                    String::new()
                };
                screen::say(format_args!("  {key:20} {}{rest}", first.join(" ")));
            }
            other => screen::say(format_args!("  {key:20} {}", word(other))),
        }
    }
}

fn word(value: &Value) -> String {
    match value {
        Value::Number(number) if number.is_f64() => number.as_f64().map_or_else(
            || number.to_string(),
            |value| isolux_app::formats::significant(value, DIGITS),
        ),
        Value::String(text) => text.clone(),
        other => other.to_string(),
    }
}

/// The table of CIE 117: rooms of x·H by y·H, five sets of reflectances, seen crosswise and endwise.
fn glare(key: &str, table: &Map<String, Value>) {
    let rows = |name: &str| table.get(name).and_then(Value::as_array).map_or(&[][..], Vec::as_slice);
    let line = |of: &Value| -> Vec<String> {
        let cells = of.as_array().map_or(&[][..], Vec::as_slice);
        cells
            .iter()
            .map(|cell| {
                cell.as_f64()
                    .map_or_else(|| cell.to_string(), |value| format!("{value:.1}"))
            })
            .collect()
    };
    let reflectances: Vec<String> = rows("reflectance_percent")
        .iter()
        .map(|set| {
            let parts = set.as_array().map_or(&[][..], Vec::as_slice);
            let parts: Vec<String> = parts.iter().map(word).collect();
            parts.join("/")
        })
        .collect();
    let columns = |cells: &[String]| {
        let cells: Vec<String> = cells.iter().map(|cell| format!("{cell:>9}")).collect();
        cells.concat()
    };
    let head = columns(&reflectances);
    screen::say(format_args!(
        "  {key}, crosswise | endwise, by reflectance of ceiling/walls/floor in %"
    ));
    screen::say(format_args!("   x·H y·H{head}  |{head}"));
    for ((room, crosswise), endwise) in rows("room_h").iter().zip(rows("crosswise")).zip(rows("endwise")) {
        let room: Vec<String> = room
            .as_array()
            .map_or(&[][..], Vec::as_slice)
            .iter()
            .map(word)
            .collect();
        screen::say(format_args!(
            "  {:>8}{}  |{}",
            room.join("  "),
            columns(&line(crosswise)),
            columns(&line(endwise))
        ));
    }
}
