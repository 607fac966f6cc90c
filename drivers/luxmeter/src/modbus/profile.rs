//! What a Modbus lux meter is like, as a TOML file says it.

use std::collections::BTreeMap;
use std::time::Duration;

use isolux_device::{OpenError, Target};
use isolux_modbus::{Encoding, NumberType, Table, WordOrder};
use isolux_profile::{Line, Shipped, Spanned, Wrong, format, of};
use isolux_transport::LineSettings;
use serde::Deserialize;

use crate::language::Meaning;
use crate::unit::{Timing, Unit, range};

/// First key of every profile.
const FORMAT: &str = "isolux-modbus-lux/1";

/// The profiles that come with the program, by name.
const SHIPPED: Shipped = &[
    ("rs485-u32", include_str!("../../profiles/rs485-u32.toml")),
    ("u32-thousandths", include_str!("../../profiles/u32-thousandths.toml")),
];

/// A meter's registers and manners. Always valid.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Profile {
    pub model: String,
    pub line: LineSettings,
    pub table: Table,
    pub register: u16,
    pub encoding: Encoding,
    /// Illuminance of one unit of the raw number, lx.
    pub scale_lx: f64,
    /// Lowest and highest illuminance that the meter gives, lx.
    pub range_lx: (f64, f64),
    /// One step of the reading, lx.
    pub resolution_lx: f64,
    pub update_interval: Duration,
    pub integration: Duration,
    codes: Vec<(f64, Meaning)>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Document {
    format: Spanned<String>,
    model: Spanned<String>,
    line: Line,
    reading: Reading,
    timing: Timing,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Reading {
    function: Spanned<u8>,
    register: Spanned<u16>,
    r#type: Type,
    word_order: Option<Spanned<Order>>,
    scale: Spanned<f64>,
    unit: Unit,
    range: Spanned<[f64; 2]>,
    resolution: Option<Spanned<f64>>,
    #[serde(default)]
    over_range: Vec<Spanned<f64>>,
    #[serde(default)]
    under_range: Vec<Spanned<f64>>,
    #[serde(default)]
    errors: BTreeMap<String, Spanned<f64>>,
}

#[derive(Clone, Copy, Deserialize)]
#[serde(rename_all = "lowercase")]
enum Type {
    U16,
    I16,
    U32,
    I32,
    F32,
}

#[derive(Clone, Copy, Deserialize)]
#[serde(rename_all = "snake_case")]
enum Order {
    HighFirst,
    LowFirst,
}

impl Profile {
    /// The profile that `target` names.
    pub fn of(target: &Target) -> Result<Self, OpenError> {
        of(target, SHIPPED, |document: Document| document.check())
    }

    /// What the registers say.
    pub fn meaning(&self, words: &[u16]) -> Option<Meaning> {
        let raw = self.encoding.decode(words)?;
        if let Some((_, meaning)) = self.codes.iter().find(|(code, _)| *code == raw) {
            return Some(meaning.clone());
        }
        let lux = raw * self.scale_lx;
        Some(if lux.is_nan() {
            Meaning::Error("the meter says that this is no number".to_owned())
        } else {
            Meaning::of(lux, self.range_lx)
        })
    }
}

impl Document {
    fn check(self) -> Result<Profile, Wrong> {
        let at = |span: std::ops::Range<usize>, reason: &str| (span.start, reason.to_owned());
        format(&self.format, FORMAT)?;
        if self.model.get_ref().trim().is_empty() {
            return Err(at(self.model.span(), "model must name the meter"));
        }
        // RTU sends bytes: seven data bits are for Modbus ASCII (SL 2.5.1).
        if *self.line.data_bits.get_ref() != 8 {
            return Err(at(
                self.line.data_bits.span(),
                "data_bits must be 8: RTU sends whole bytes",
            ));
        }
        let line = self.line.check()?;
        let reading = &self.reading;
        let table = match reading.function.get_ref() {
            3 => Table::Holding,
            4 => Table::Input,
            _ => {
                return Err(at(
                    reading.function.span(),
                    "function must be 3 (holding) or 4 (input registers)",
                ));
            }
        };
        let encoding = reading.encoding()?;
        if u32::from(*reading.register.get_ref()) + u32::from(encoding.number.registers()) > 0x1_0000 {
            return Err(at(reading.register.span(), "the reading runs past register FFFFh"));
        }
        let scale = *reading.scale.get_ref();
        if !(scale.is_finite() && scale > 0.0) {
            return Err(at(reading.scale.span(), "scale must be above zero"));
        }
        let unit_lx = reading.unit.lx();
        let [low, high] = range(&reading.range)?;
        let resolution = match (&reading.resolution, encoding.number) {
            (Some(step), _) if *step.get_ref() > 0.0 && *step.get_ref() < high => *step.get_ref(),
            (Some(step), _) => {
                return Err(at(
                    step.span(),
                    "resolution must be above zero and below the range's end",
                ));
            }
            (None, NumberType::F32) => {
                return Err(at(
                    reading.range.span(),
                    "a float needs `resolution`, one step of the meter's reading",
                ));
            }
            (None, _) => scale,
        };
        Ok(Profile {
            line,
            table,
            register: *reading.register.get_ref(),
            encoding,
            scale_lx: scale * unit_lx,
            range_lx: (low * unit_lx, high * unit_lx),
            resolution_lx: resolution * unit_lx,
            update_interval: self.timing.update_interval()?,
            integration: self.timing.integration()?,
            codes: reading.codes(encoding, scale, (low, high))?,
            model: self.model.into_inner(),
        })
    }
}

impl Reading {
    fn encoding(&self) -> Result<Encoding, Wrong> {
        let number = match self.r#type {
            Type::U16 => NumberType::U16,
            Type::I16 => NumberType::I16,
            Type::U32 => NumberType::U32,
            Type::I32 => NumberType::I32,
            Type::F32 => NumberType::F32,
        };
        let order = match (&self.word_order, number.registers()) {
            (Some(order), 2) => match order.get_ref() {
                Order::HighFirst => WordOrder::HighFirst,
                Order::LowFirst => WordOrder::LowFirst,
            },
            (Some(order), _) => {
                return Err((
                    order.span().start,
                    format!("{number} has one word: leave word_order out"),
                ));
            }
            (None, 2) => {
                let reason = format!("{number} needs word_order = \"high_first\" or \"low_first\"");
                return Err((self.register.span().start, reason));
            }
            (None, _) => WordOrder::HighFirst,
        };
        Ok(Encoding { number, order })
    }

    /// The raw numbers that are no illuminance. Each has one meaning, and none is one that the range has as a reading.
    fn codes(&self, encoding: Encoding, scale: f64, (low, high): (f64, f64)) -> Result<Vec<(f64, Meaning)>, Wrong> {
        let over = self.over_range.iter().map(|code| (code, Meaning::OverRange));
        let under = self.under_range.iter().map(|code| (code, Meaning::UnderRange));
        let errors = self
            .errors
            .iter()
            .map(|(name, code)| (code, Meaning::Error(name.clone())));
        let (least, most) = match encoding.number {
            NumberType::U16 => (0.0, f64::from(u16::MAX)),
            NumberType::I16 => (f64::from(i16::MIN), f64::from(i16::MAX)),
            NumberType::U32 => (0.0, f64::from(u32::MAX)),
            NumberType::I32 => (f64::from(i32::MIN), f64::from(i32::MAX)),
            NumberType::F32 => (f64::from(f32::MIN), f64::from(f32::MAX)),
        };
        let mut codes: Vec<(f64, Meaning)> = Vec::new();
        for (code, meaning) in over.chain(under).chain(errors) {
            let (raw, at) = (*code.get_ref(), code.span().start);
            let whole = encoding.number == NumberType::F32 || raw.fract() == 0.0;
            if !whole || !(least..=most).contains(&raw) {
                return Err((at, format!("no {} can be {raw}", encoding.number)));
            }
            if (low..=high).contains(&(raw * scale)) {
                let reason = format!("{raw} has two meanings: this code, and a reading inside range [{low}, {high}]");
                return Err((at, reason));
            }
            if codes.iter().any(|(known, _)| *known == raw) {
                return Err((
                    at,
                    format!("{raw} has two meanings: it stands in two lists, or twice in one"),
                ));
            }
            codes.push((raw, meaning));
        }
        Ok(codes)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use isolux_profile::parse;

    const FULL: &str = r#"format = "isolux-modbus-lux/1"
model = "a meter"
[line]
baud = 19200
data_bits = 8
parity = "even"
stop_bits = 1
[reading]
function = 4
register = 12
type = "i32"
word_order = "low_first"
scale = 0.01
unit = "klx"
range = [-1.0, 150.0]
resolution = 0.02
over_range = [2147483647]
under_range = [-2147483648]
[reading.errors]
"head missing" = -99999
[timing]
update_interval_s = 0.5
integration_s = 0.25
"#;

    fn parsed(text: &str) -> Result<Profile, String> {
        parse("m.toml", text, |document: Document| document.check()).map_err(|error| error.to_string())
    }

    fn shipped(name: &str) -> Result<Profile, OpenError> {
        Profile::of(&Target::parse(&format!("modbus-lux:x?profile={name}")).unwrap())
    }

    #[test]
    fn every_key_means_what_it_says() {
        let profile = parsed(FULL).unwrap();
        assert_eq!(profile.line.to_string(), "19200 8E1");
        assert_eq!((profile.table, profile.register), (Table::Input, 12));
        assert_eq!((profile.range_lx, profile.resolution_lx), ((-1000.0, 150_000.0), 20.0));
        assert_eq!(
            (profile.update_interval, profile.integration),
            (Duration::from_millis(500), Duration::from_millis(250))
        );
        let says = |raw: i32| profile.meaning(&[raw as u16, (raw >> 16) as u16]).unwrap();
        assert_eq!(says(1234), Meaning::Lux(12_340.0));
        assert_eq!(says(-50), Meaning::Lux(-500.0));
        assert_eq!(says(i32::MAX), Meaning::OverRange);
        assert_eq!(says(i32::MIN), Meaning::UnderRange);
        assert_eq!(says(-99_999), Meaning::Error("head missing".into()));
        assert_eq!(says(15_001), Meaning::OverRange);
        assert_eq!(says(-101), Meaning::UnderRange);
        assert_eq!(profile.meaning(&[1]), None);
        let feet = FULL.replace("klx", "fc").replace("range = [-1.0", "range = [0.5");
        let profile = parsed(&feet).unwrap();
        // 1 fc = 10.763910 lx.
        let Some(Meaning::Lux(lux)) = profile.meaning(&[100, 0]) else {
            panic!()
        };
        assert!((lux - 10.763_910).abs() < 1e-6, "{lux}");
    }

    #[test]
    fn a_float_that_is_no_number_is_none() {
        let float = FULL
            .replace("\"i32\"", "\"f32\"")
            .replace("over_range = [2147483647]\nunder_range = [-2147483648]\n", "")
            .replace("-99999", "-9999.0");
        let profile = parsed(&float).unwrap();
        let says = |value: f32| {
            profile
                .meaning(&[value.to_bits() as u16, (value.to_bits() >> 16) as u16])
                .unwrap()
        };
        assert!(matches!(says(f32::NAN), Meaning::Error(_)));
        assert_eq!(says(f32::INFINITY), Meaning::OverRange);
        assert_eq!(says(-9999.0), Meaning::Error("head missing".into()));
        assert_eq!(says(2.5), Meaning::Lux(25.0));
    }

    #[test]
    fn the_shipped_ones_are_right_and_the_golden_answer_is_132854_lx() {
        for (name, _) in SHIPPED {
            shipped(name).unwrap();
        }
        let profile = shipped("rs485-u32").unwrap();
        assert_eq!(profile.meaning(&[0x0002, 0x06F6]), Some(Meaning::Lux(132_854.0)));
        let profile = shipped("u32-thousandths").unwrap();
        assert_eq!(profile.meaning(&[0x0002, 0x06F6]), Some(Meaning::Lux(132.854)));
    }

    #[test]
    fn each_bad_profile_is_one_message_with_file_and_line() {
        for (from, to, line, part) in [
            ("baud = 19200", "baud = 19200\nspeed = 1", 5, "unknown field `speed`"),
            ("scale = 0.01", "scale = 0.01\nscale = 0.1", 14, "duplicate key"),
            ("register = 12", "register = \"12\"", 10, "invalid type"),
            ("register = 12", "register = 70000", 10, "u16"),
            ("register = 12", "register = 65535", 10, "past register FFFFh"),
            ("function = 4", "function = 6", 9, "3 (holding) or 4"),
            ("\"i32\"", "\"i64\"", 11, "unknown variant `i64`"),
            ("\"i32\"", "\"i16\"", 12, "leave word_order out"),
            ("word_order = \"low_first\"\n", "", 10, "needs word_order"),
            ("\"low_first\"", "\"middle\"", 12, "unknown variant `middle`"),
            ("scale = 0.01", "scale = 0.0", 13, "above zero"),
            ("scale = 0.01", "scale = nan", 13, "above zero"),
            ("\"klx\"", "\"lux\"", 14, "unknown variant `lux`"),
            ("[-1.0, 150.0]", "[150.0, -1.0]", 15, "[lowest, highest]"),
            ("resolution = 0.02", "resolution = -1", 16, "above zero"),
            ("[2147483647]", "[2147483648]", 17, "no i32 can be 2147483648"),
            ("[2147483647]", "[1.5]", 17, "no i32 can be 1.5"),
            (
                "[2147483647]",
                "[100]",
                17,
                "100 has two meanings: this code, and a reading inside range",
            ),
            (
                "[-2147483648]",
                "[2147483647]",
                18,
                "2147483647 has two meanings: it stands in two lists",
            ),
            ("-99999", "2147483647", 20, "two lists"),
            ("data_bits = 8", "data_bits = 7", 5, "RTU sends whole bytes"),
            ("stop_bits = 1", "stop_bits = 3", 7, "1 or 2"),
            ("baud = 19200", "baud = 1", 4, "300 to 4000000"),
            ("update_interval_s = 0.5", "update_interval_s = 0", 22, "0.001 to 60"),
            ("update_interval_s = 0.5", "update_interval_s = 0.5 lx", 22, ""),
            ("lux/1", "lux/2", 1, "format must be"),
            ("\"a meter\"", "\" \"", 2, "name the meter"),
            ("integration_s = 0.25\n", "", 21, "missing field `integration_s`"),
        ] {
            assert!(FULL.contains(from), "{from}");
            let error = parsed(&FULL.replacen(from, to, 1)).unwrap_err();
            assert!(
                error.starts_with(&format!("m.toml:{line}: ")) && error.contains(part),
                "{to}: {error}"
            );
            assert_eq!(error.lines().count(), 1, "{error}");
        }
        let error = shipped("nowhere.toml").unwrap_err().to_string();
        assert!(
            error.contains("nowhere.toml") && error.contains("rs485-u32, u32-thousandths"),
            "{error}"
        );
        assert!(shipped("rs485").unwrap_err().to_string().contains("no such profile"));
    }
}
