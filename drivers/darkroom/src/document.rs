//! `darkroom.toml`: the room, its instruments, their faults and their injected effects, in one file.
//!
//! A key that a file leaves out is that of the built-in room. An unknown key, or a value that no room can have, is an
//! error with its line. [`Darkroom::default`] is not the built-in room but one without injected effects.

use std::sync::Arc;

use camino::Utf8Path;
use isolux_document::{self as document, DocumentError, SourceText};
use serde::{Deserialize, Serialize};

use crate::built_in::{self, BUILT_IN, Completed};
use crate::fault::Fault;
use crate::injected_effects::InjectedEffects;
use crate::parts::{Axes, Bench, Camera, Climate, Lamp, LuxMeter, PowerMeter, Spectroradiometer};
use crate::table::LampTable;

/// The format line of the file.
pub const FORMAT: &str = "isolux-darkroom/1";

/// A virtual darkroom as its file describes it; checked by [`Darkroom::parse`].
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Darkroom {
    /// `isolux-darkroom/1`.
    pub format: String,
    /// Seed of every random number in the room.
    pub seed: u64,
    /// The lamp under test.
    pub lamp: Lamp,
    /// The air of the room.
    pub room: Climate,
    /// The goniophotometer.
    pub bench: Bench,
    /// Its axes.
    pub axis: Axes,
    /// The lux meter.
    pub luxmeter: LuxMeter,
    /// The spectroradiometer.
    pub spectroradiometer: Spectroradiometer,
    /// The power meter.
    pub powermeter: PowerMeter,
    /// The camera.
    pub camera: Camera,
    /// What is wrong with the room and its instruments, and is to be found.
    // Rooms of earlier versions write `[flaws]`.
    #[serde(alias = "flaws")]
    pub injected_effects: InjectedEffects,
    /// What goes wrong on the links.
    pub fault: Vec<Fault>,
}

impl Default for Darkroom {
    fn default() -> Self {
        Self {
            format: FORMAT.to_owned(),
            seed: 1,
            lamp: Lamp::default(),
            room: Climate::default(),
            bench: Bench::default(),
            axis: Axes::default(),
            luxmeter: LuxMeter::default(),
            spectroradiometer: Spectroradiometer::default(),
            powermeter: PowerMeter::default(),
            camera: Camera::default(),
            injected_effects: InjectedEffects::default(),
            fault: Vec::new(),
        }
    }
}

impl Darkroom {
    /// The built-in room.
    ///
    /// # Errors
    /// Never for the room as it is shipped.
    pub fn built_in() -> Result<Self, DocumentError> {
        Self::parse(BUILT_IN)
    }

    /// Reads a `darkroom.toml` that names no other file; keys that it leaves out are those of the built-in room.
    ///
    /// # Errors
    /// Not TOML, an unknown key, a wrong type, or a value that no room can have.
    pub fn parse(text: &str) -> Result<Self, DocumentError> {
        let file = Utf8Path::new("darkroom.toml");
        let no_file = |_: &str| Err("a room without a folder cannot name a file".to_owned());
        Self::complete(SourceText { file, text }, &no_file).map(|(room, _)| room)
    }

    /// Reads a file, and says which keys were completed. `beside` gives the text of a file that the room names,
    /// relative to its own.
    ///
    /// # Errors
    /// As [`parse`](Self::parse), and where a file that it names cannot be read or used.
    pub fn complete(
        source: SourceText<'_>,
        beside: &dyn Fn(&str) -> Result<String, String>,
    ) -> Result<(Self, Completed), DocumentError> {
        let in_text = |error: toml::de::Error| source.toml_error(&error);
        // What the file itself says is judged with its lines, before it is completed.
        let _: Self = toml::from_str(source.text).map_err(in_text)?;
        let mut given: toml::Table = source.text.parse().map_err(in_text)?;
        if let Some(effects) = given.remove("flaws") {
            given.insert("injected_effects".to_owned(), effects);
        }
        if let Some(key) = built_in::ring_key_beside_table(&given) {
            let message = "describes rings of LEDs; leave it out beside `table`";
            return Err(source.locate(&document::Fault::new(format!("lamp.{key}"), message)));
        }
        let (whole, completed) =
            built_in::complete(&given).map_err(|error| source.whole(format!("the built-in room: {error}")))?;
        // As text: a second way to read every type of a room would be built for this alone. Its lines are not those of
        // the file.
        let in_whole = |error: toml::de::Error| source.whole(error.message().to_owned());
        let mut room: Self = toml::from_str(&whole.to_string()).map_err(in_whole)?;
        room.injected_effects.only = false;
        if let Some(file) = &room.lamp.table {
            let wrong =
                |why: String| source.locate(&document::Fault::new("lamp.table", format!("names {file}: {why}")));
            let table = LampTable::parse(&beside(file).map_err(wrong)?).map_err(|error| wrong(error.to_string()))?;
            room.lamp.flux_lm = table.flux_lm();
            room.lamp.intensities = Some(Arc::new(table));
        }
        room.check().map_err(|fault| source.locate(&fault))?;
        Ok((room, completed))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::fault::FaultKind;

    #[test]
    fn an_empty_file_is_the_built_in_room() {
        assert_eq!(Darkroom::parse("").unwrap(), Darkroom::built_in().unwrap());
    }

    #[test]
    fn an_unknown_key_is_named_with_its_line() {
        let error = Darkroom::parse("seed = 2\n[lamp]\nflux = 3\n").unwrap_err();
        assert_eq!(error.line, Some(3));
        assert!(error.message.contains("flux"), "{}", error.message);
        let error = Darkroom::parse("[injected_effects.gamma_zero]\noffset = 0.2\n").unwrap_err();
        assert_eq!(error.line, Some(2));
    }

    #[test]
    fn an_impossible_value_is_named_with_its_line() {
        let error = Darkroom::parse("seed = 2\n[lamp]\n\nflux_lm = -3.0\n").unwrap_err();
        assert_eq!(error.line, Some(4));
        assert!(error.to_string().contains("lamp.flux_lm"), "{error}");
        let error = Darkroom::parse("[injected_effects]\n\ngamma_zero = { offset_deg = nan }\n").unwrap_err();
        assert_eq!(error.line, Some(3));
        assert!(Darkroom::parse("[axis.c]\ncounts_per_deg = \"12800/0\"\n").is_err());
    }

    #[test]
    fn no_number_passes_that_no_room_can_have() {
        let lines: Vec<&str> = crate::BUILT_IN.lines().collect();
        let mut tried = 0;
        for (index, line) in lines.iter().enumerate() {
            let Some((key, value)) = line.split_once('=') else {
                continue;
            };
            let value = value.split('#').next().unwrap_or("").trim();
            let number = value
                .trim_start_matches('[')
                .starts_with(|c: char| c.is_ascii_digit() || c == '-');
            if line.starts_with('#') || !number || key.trim() == "seed" {
                continue;
            }
            let parts: Vec<&str> = value.trim_matches(['[', ']']).split(", ").collect();
            for place in 0..parts.len() {
                for absurd in ["nan", "inf", "1e308", "-1e308"] {
                    let mut parts = parts.clone();
                    parts[place] = absurd;
                    let parts = parts.join(", ");
                    let changed = if value.starts_with('[') {
                        format!("[{parts}]")
                    } else {
                        parts
                    };
                    let mut text = lines.clone();
                    let changed = format!("{key} = {changed}");
                    text[index] = &changed;
                    let error = Darkroom::parse(&text.join("\n")).expect_err(&format!("line {}: {changed}", index + 1));
                    assert_eq!(error.line, Some(index + 1), "{changed}: {error}");
                    tried += 1;
                }
            }
        }
        assert!(tried > 4 * 120, "{tried}");
    }

    #[test]
    fn a_lamp_by_its_table_has_the_light_of_the_file_and_no_rings() {
        let table = "c_deg,gamma_deg,intensity_cd\n0,0,100\n0,90,100\n0,180,100\n";
        let read = |text: &str, file: &str| {
            let beside = |name: &str| match name {
                "lamp.csv" => Ok(file.to_owned()),
                _ => Err("no such file".to_owned()),
            };
            let file = Utf8Path::new("darkroom.toml");
            Darkroom::complete(SourceText { file, text }, &beside)
        };
        let lamp = "[lamp]\ntable = \"lamp.csv\"\nluminous_diameter_mm = 120.0\n";
        let (room, completed) = read(lamp, table).unwrap();
        assert!(
            (room.lamp.flux_lm - 400.0 * std::f64::consts::PI).abs() < 1e-3,
            "{}",
            room.lamp.flux_lm
        );
        assert_eq!(room.lamp.diameter_mm(), 120.0);
        assert!(
            !completed.keys().contains(&"lamp.exponent".to_owned())
                && completed.keys().contains(&"lamp.power_w".to_owned())
        );
        let refused = |text: &str, file: &str, line: usize, word: &str| {
            let error = read(text, file).unwrap_err();
            assert!(
                error.line == Some(line) && error.message.contains(word),
                "{text}: {error}"
            );
        };
        refused(&format!("{lamp}exponent = 5.0\n"), table, 4, "rings");
        refused(&lamp.replace("lamp.csv", "other.csv"), table, 2, "no such file");
        refused(lamp, "c_deg,gamma_deg,intensity_cd\n0,0,x\n", 2, "lamp.csv: line 2");
        refused("[lamp]\nluminous_diameter_mm = 120.0\n", table, 2, "table");
        refused("[lamp]\ntable = \"lamp.csv\"\n", table, 2, "luminous_diameter_mm");
        assert!(Darkroom::parse(lamp).is_err());
    }

    #[test]
    fn injected_effects_and_faults_are_read() {
        let room = Darkroom::parse(
            "[injected_effects]\ndark_offset = { offset_lx = 0.02 }\n[[fault]]\ninstrument = \"luxmeter\"\nkind = \"late\"\nat_s = 3.0\n\
             delay_s = 1.5\n",
        )
        .unwrap();
        assert_eq!(room.injected_effects.dark_offset.offset_lx, 0.02);
        let former = Darkroom::parse("[flaws]\ndark_offset = { offset_lx = 0.03 }\n").unwrap();
        assert_eq!(former.injected_effects.dark_offset.offset_lx, 0.03);
        assert!(Darkroom::parse("[flaws]\nonly = true\n[injected_effects]\nonly = true\n").is_err());
        assert_eq!(room.fault[0].kind, FaultKind::Late);
        assert_eq!(room.fault[0].probability, 1.0);
    }
}
