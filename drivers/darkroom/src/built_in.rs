//! The built-in room, and room files that leave keys out: those are taken from it, and named.

use std::collections::BTreeMap;
use std::fmt;

use toml::{Table, Value};

use crate::parts::RING_KEYS;

/// The room that `isolux run` opens without a job, every key of it: the lamp as it is, a room as rooms are.
pub const BUILT_IN: &str = include_str!("built_in.toml");

/// Keys of the built-in room that a file left out. It reads as one line; a file that has every key gives none.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct Completed {
    /// Dotted keys, in the order of the alphabet.
    keys: Vec<String>,
    /// Tables that the file has nothing of, and single keys above all tables.
    tables: Vec<String>,
    /// Of tables that the file has a part of: the keys that it gives itself.
    parts: BTreeMap<String, Vec<String>>,
    /// Injected effects that are on in the built-in room, and that the file does not name.
    injected_effects: Vec<String>,
}

impl Completed {
    /// Whether the file has every key.
    pub fn is_empty(&self) -> bool {
        self.keys.is_empty()
    }

    /// The dotted keys that were completed, but for injected effects that are off.
    pub fn keys(&self) -> &[String] {
        &self.keys
    }
}

impl fmt::Display for Completed {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let mut words = self.tables.clone();
        words.extend(self.parts.iter().map(|(table, given)| {
            let given = given.join(", ");
            format!("[{table}] but for {given}")
        }));
        if !self.injected_effects.is_empty() {
            words.push(format!("the injected effects {}", self.injected_effects.join(", ")));
        }
        write!(f, "completed from the built-in room: {}", words.join("; "))
    }
}

/// A key of `[lamp]` in `given` that describes rings of LEDs although the lamp has a table of intensities.
pub(crate) fn ring_key_beside_table(given: &Table) -> Option<&'static str> {
    let lamp = given
        .get("lamp")
        .and_then(Value::as_table)
        .filter(|lamp| lamp.contains_key("table"))?;
    RING_KEYS.into_iter().find(|key| lamp.contains_key(*key))
}

/// The table of the whole room: what `given` says, and the built-in room where it is silent.
pub(crate) fn complete(given: &Table) -> Result<(Table, Completed), toml::de::Error> {
    let mut whole: Table = BUILT_IN.parse()?;
    let own_injected_effects = given.get("injected_effects").and_then(Value::as_table);
    if own_injected_effects.and_then(|injected_effects| injected_effects.get("only")?.as_bool()) == Some(true) {
        // What is left out is at its null, as the types have it.
        whole.insert("injected_effects".to_owned(), Table::new().into());
    }
    let lamp = given.get("lamp").and_then(Value::as_table);
    if lamp.is_some_and(|lamp| lamp.contains_key("table"))
        && let Some(Value::Table(lamp)) = whole.get_mut("lamp")
    {
        // A lamp by its table has no LEDs to complete.
        for key in RING_KEYS {
            lamp.remove(key);
        }
    }
    let mut completed = Completed::default();
    lay_over(&mut whole, given, "", &mut completed);
    Ok((whole, completed))
}

/// Puts the keys of `given` into `whole`, and notes those that it leaves as they are.
fn lay_over(whole: &mut Table, given: &Table, path: &str, completed: &mut Completed) {
    let dotted = |key: &str| {
        if path.is_empty() {
            key.to_owned()
        } else {
            format!("{path}.{key}")
        }
    };
    let left_out: Vec<String> = whole
        .iter()
        .filter(|(key, value)| {
            !value.is_table() && !given.contains_key(*key) && !["format", "only"].contains(&key.as_str())
        })
        .map(|(key, _)| key.clone())
        .collect();
    completed.keys.extend(left_out.iter().map(|key| dotted(key)));
    let gives: Vec<String> = given
        .iter()
        .filter(|(key, value)| !value.is_table() && whole.contains_key(*key))
        .map(|(key, _)| key.clone())
        .collect();
    if !left_out.is_empty() {
        if path.is_empty() {
            completed.tables.extend(left_out);
        } else if gives.is_empty() {
            completed.tables.push(format!("[{path}]"));
        } else {
            completed.parts.insert(path.to_owned(), gives);
        }
    }
    for (key, value) in given {
        match (whole.get_mut(key), value) {
            (Some(Value::Table(_)), Value::Table(_)) => {}
            _ => {
                whole.insert(key.clone(), value.clone());
            }
        }
    }
    let nothing = Table::new();
    for (key, value) in whole.iter_mut() {
        let Value::Table(inner) = value else { continue };
        match given.get(key) {
            Some(Value::Table(own)) => lay_over(inner, own, &dotted(key), completed),
            _ if path == "injected_effects" => {
                if !is_off(key, inner) {
                    completed
                        .keys
                        .extend(inner.keys().map(|inner| format!("{path}.{key}.{inner}")));
                    completed.injected_effects.push(key.clone());
                }
            }
            _ => lay_over(inner, &nothing, &dotted(key), completed),
        }
    }
}

/// Whether an injected effect has the values at which it changes nothing.
fn is_off(name: &str, values: &Table) -> bool {
    let null = crate::InjectedEffects::default();
    null.values()
        .iter()
        .filter(|(effect, ..)| *effect == name)
        .all(|(_, key, null)| values.get(*key).and_then(Value::as_float) == Some(*null))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::document::Darkroom;

    fn keys(table: &Table, path: &str, into: &mut Vec<String>) {
        for (key, value) in table {
            match value {
                Value::Table(inner) => keys(inner, &format!("{path}{key}."), into),
                _ => into.push(format!("{path}{key}")),
            }
        }
    }

    fn complete(text: &str) -> (Darkroom, Completed) {
        let file = "darkroom.toml".into();
        let no_file = |_: &str| Err("no file".to_owned());
        Darkroom::complete(isolux_document::SourceText { file, text }, &no_file).unwrap()
    }

    #[test]
    fn the_built_in_file_has_every_key_of_a_room() {
        let (_, completed) = complete(BUILT_IN);
        assert!(completed.is_empty(), "{completed}");
        // Every key that a room serialises stands in the file, and no other.
        let (mut of_file, mut of_type) = (Vec::new(), Vec::new());
        keys(&BUILT_IN.parse().unwrap(), "", &mut of_file);
        keys(&Table::try_from(Darkroom::default()).unwrap(), "", &mut of_type);
        of_type.retain(|key| key != "fault");
        assert_eq!(of_file, of_type);
    }

    #[test]
    fn one_effect_alone_changes_that_effect_alone() {
        let built_in = Darkroom::built_in().unwrap();
        let (room, completed) = complete("[injected_effects]\nfloor_reflection = { albedo = 0.2 }\n");
        let mut expected = built_in.clone();
        expected.injected_effects.floor_reflection.albedo = 0.2;
        assert_eq!(room, expected);
        assert_eq!(room.injected_effects.lamp_warmup.amplitude_rel, 0.045);
        let line = completed.to_string();
        assert_eq!(
            line,
            "completed from the built-in room: seed; [axis.c]; [axis.gamma]; [bench]; [camera]; [lamp]; [luxmeter]; [powermeter]; [room]; \
             [spectroradiometer]; [injected_effects.floor_reflection] but for albedo; \
             the injected effects ambient_stray, dark_offset, distance_offset, \
             lamp_drift, lamp_warmup"
        );
        assert!(
            completed
                .keys()
                .contains(&"injected_effects.lamp_warmup.time_constant_s".to_owned())
        );
    }

    #[test]
    fn an_effect_is_switched_off_by_its_null_and_all_others_by_only() {
        let off = Darkroom::parse("[injected_effects]\nlamp_warmup = { amplitude_rel = 0.0 }\n").unwrap();
        assert_eq!(off.injected_effects.lamp_warmup.amplitude_rel, 0.0);
        assert_eq!(off.injected_effects.dark_offset.offset_lx, 0.006);
        let (only, completed) = complete("[injected_effects]\nonly = true\ngamma_zero = { offset_deg = 0.1 }\n");
        let mut expected = crate::InjectedEffects::default();
        expected.gamma_zero.offset_deg = 0.1;
        assert_eq!(only.injected_effects, expected);
        assert!(!completed.to_string().contains("injected_effects"), "{completed}");
        // Not even a further key of an injected effect that is named.
        let only = Darkroom::parse("[injected_effects]\nonly = true\ndark_offset = { offset_lx = 0.3 }\n").unwrap();
        assert_eq!(
            (
                only.injected_effects.dark_offset.offset_lx,
                only.injected_effects.dark_offset.offset_rel
            ),
            (0.3, 0.0)
        );
        assert_eq!(
            Darkroom::parse("[injected_effects]\nonly = true\n")
                .unwrap()
                .injected_effects,
            crate::InjectedEffects::default()
        );
    }
}
