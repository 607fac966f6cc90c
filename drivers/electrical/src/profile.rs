//! What an SCPI instrument is like, as a TOML file says it.

use std::time::Duration;

use isolux_device::{OpenError, Target};
use isolux_profile::{Line, Shipped, Spanned, Wrong, ascii, format, of, seconds, wrong};
use isolux_protocol_scpi::{Expect, Terminator};
use isolux_transport::LineSettings;
use serde::Deserialize;

/// Power meters that come with the program.
const METERS: Shipped = &[
    ("gpm-8213", include_str!("../profiles/gpm-8213.toml")),
    ("pw3336", include_str!("../profiles/pw3336.toml")),
];

/// Supplies that come with the program.
const SUPPLIES: Shipped = &[("dp800", include_str!("../profiles/dp800.toml"))];

/// Most bytes of the block of a reading.
const LONGEST_BLOCK: usize = 4096;

/// What all instruments have.
#[derive(Debug, Clone)]
pub(crate) struct Manners {
    pub line: LineSettings,
    /// What the answer to `*IDN?` must contain, whatever the case.
    pub identity: String,
    pub terminator: Terminator,
    pub answer: Duration,
    /// Sent when the instrument is opened.
    pub setup: Vec<String>,
    /// Queries and what they must be answered with.
    pub check: Vec<(String, String)>,
    /// The query of the error queue, where there is one.
    pub errors: Option<String>,
    /// Most bytes of a block.
    pub longest_block: usize,
}

/// A quantity of a reading.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize)]
pub(crate) enum Field {
    #[serde(rename = "voltage_v")]
    Voltage,
    #[serde(rename = "current_a")]
    Current,
    #[serde(rename = "power_w")]
    Power,
    #[serde(rename = "power_factor")]
    PowerFactor,
    /// There, and not used.
    #[serde(rename = "-")]
    Unused,
}

/// A power meter.
#[derive(Debug, Clone)]
pub(crate) struct Meter {
    pub manners: Manners,
    pub query: String,
    pub form: Expect,
    pub separator: char,
    pub fields: Vec<Field>,
    pub update: Duration,
}

/// A supply. In its messages `{channel}` stands for the output and `{value}` for a level.
#[derive(Debug, Clone)]
pub(crate) struct Supply {
    pub manners: Manners,
    pub channels: u8,
    pub voltage: Level,
    pub current: Level,
    pub on: String,
    pub off: String,
    pub state: String,
    pub is_on: String,
    pub is_off: String,
    /// Queries that are answered with `tripped` where a protection has switched the output off.
    pub trips: Vec<String>,
    pub tripped: String,
}

/// How a level is set and read back.
#[derive(Debug, Clone)]
pub(crate) struct Level {
    pub set: String,
    pub query: String,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct MannersDocument {
    identity: Spanned<String>,
    terminator: End,
    answer_s: Spanned<f64>,
    errors: Option<Spanned<String>>,
    #[serde(default)]
    setup: Vec<Spanned<String>>,
    #[serde(default)]
    check: Vec<[Spanned<String>; 2]>,
}

#[derive(Clone, Copy, Deserialize)]
#[serde(rename_all = "lowercase")]
enum End {
    Lf,
    CrLf,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct MeterDocument {
    format: Spanned<String>,
    line: Line,
    instrument: MannersDocument,
    reading: ReadingDocument,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct ReadingDocument {
    query: Spanned<String>,
    form: Form,
    separator: Option<Spanned<String>>,
    fields: Spanned<Vec<Field>>,
    update_interval_s: Spanned<f64>,
}

#[derive(Clone, Copy, PartialEq, Deserialize)]
#[serde(rename_all = "lowercase")]
enum Form {
    Text,
    /// A block of single-precision numbers, high byte first.
    Float,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct SupplyDocument {
    format: Spanned<String>,
    line: Line,
    instrument: MannersDocument,
    output: OutputDocument,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct OutputDocument {
    channels: Spanned<u8>,
    set_voltage: Spanned<String>,
    get_voltage: Spanned<String>,
    set_current: Spanned<String>,
    get_current: Spanned<String>,
    on: Spanned<String>,
    off: Spanned<String>,
    state: Spanned<String>,
    is_on: Spanned<String>,
    is_off: Spanned<String>,
    #[serde(default)]
    trips: Vec<Spanned<String>>,
    tripped: Option<Spanned<String>>,
}

impl Meter {
    /// The profile that `target` names.
    pub fn of(target: &Target) -> Result<Self, OpenError> {
        of(target, METERS, |document: MeterDocument| document.check())
    }
}

impl Supply {
    /// The profile that `target` names.
    pub fn of(target: &Target) -> Result<Self, OpenError> {
        of(target, SUPPLIES, |document: SupplyDocument| document.check())
    }
}

impl MannersDocument {
    pub(crate) fn check(&self, line: &Line) -> Result<Manners, Wrong> {
        let pair = |pair: &[Spanned<String>; 2]| Ok((query("check", &pair[0])?, ascii("check", &pair[1])?));
        let setup = |message: &Spanned<String>| {
            let text = ascii("setup", message)?;
            if text.contains('?') {
                return Err(wrong(
                    message.span(),
                    "setup sends commands; a query belongs into check, with its answer",
                ));
            }
            Ok(text)
        };
        Ok(Manners {
            line: line.check()?,
            identity: ascii("identity", &self.identity)?,
            terminator: match self.terminator {
                End::Lf => Terminator::Lf,
                End::CrLf => Terminator::CrLf,
            },
            answer: seconds("answer_s", &self.answer_s)?,
            setup: self.setup.iter().map(setup).collect::<Result<_, _>>()?,
            check: self.check.iter().map(pair).collect::<Result<_, _>>()?,
            errors: self.errors.as_ref().map(|text| query("errors", text)).transpose()?,
            longest_block: LONGEST_BLOCK,
        })
    }
}

pub(crate) fn query(key: &str, value: &Spanned<String>) -> Result<String, Wrong> {
    let text = ascii(key, value)?;
    if text.contains('?') {
        Ok(text)
    } else {
        Err(wrong(
            value.span(),
            format!("{key} must be a query, with a question mark"),
        ))
    }
}

impl MeterDocument {
    fn check(self) -> Result<Meter, Wrong> {
        format(&self.format, "isolux-scpi-meter/1")?;
        let reading = &self.reading;
        let fields = reading.fields.get_ref();
        for field in [Field::Voltage, Field::Current, Field::Power, Field::PowerFactor] {
            if fields.iter().filter(|known| **known == field).count() > 1 {
                return Err(wrong(
                    reading.fields.span(),
                    format!("{field:?} is there twice: which one counts?"),
                ));
            }
        }
        if !fields.contains(&Field::Power) {
            return Err(wrong(reading.fields.span(), "a power meter gives power_w"));
        }
        let separator = match (&reading.separator, reading.form) {
            (None, _) => ',',
            (Some(text), Form::Text) if matches!(text.get_ref().as_str(), "," | ";") => {
                if text.get_ref() == ";" {
                    ';'
                } else {
                    ','
                }
            }
            (Some(text), _) => return Err(wrong(text.span(), "separator is \",\" or \";\", of a reading in text")),
        };
        Ok(Meter {
            manners: self.instrument.check(&self.line)?,
            query: query("query", &reading.query)?,
            form: if reading.form == Form::Text {
                Expect::Text
            } else {
                Expect::Block
            },
            separator,
            fields: fields.clone(),
            update: seconds("update_interval_s", &reading.update_interval_s)?,
        })
    }
}

impl SupplyDocument {
    fn check(self) -> Result<Supply, Wrong> {
        format(&self.format, "isolux-scpi-supply/1")?;
        let output = &self.output;
        let channels = *output.channels.get_ref();
        if !(1..=9).contains(&channels) {
            return Err(wrong(output.channels.span(), "channels must be 1 to 9"));
        }
        let level = |set: &Spanned<String>, get: &Spanned<String>| {
            let text = ascii("a level", set)?;
            if !text.contains("{value}") || text.contains('?') {
                return Err(wrong(set.span(), "a level is set by a command with {value}"));
            }
            let query = query("the reading back of a level", get)?;
            Ok(Level { set: text, query })
        };
        if output.is_on.get_ref() == output.is_off.get_ref() {
            return Err(wrong(
                output.is_off.span(),
                "is_on and is_off are the same: which one counts?",
            ));
        }
        let tripped = match (&output.tripped, output.trips.first()) {
            (Some(text), _) => ascii("tripped", text)?,
            (None, None) => String::new(),
            (None, Some(first)) => return Err(wrong(first.span(), "trips need `tripped`, the answer that means yes")),
        };
        Ok(Supply {
            manners: self.instrument.check(&self.line)?,
            channels,
            voltage: level(&output.set_voltage, &output.get_voltage)?,
            current: level(&output.set_current, &output.get_current)?,
            on: ascii("on", &output.on)?,
            off: ascii("off", &output.off)?,
            state: query("state", &output.state)?,
            is_on: ascii("is_on", &output.is_on)?,
            is_off: ascii("is_off", &output.is_off)?,
            trips: output
                .trips
                .iter()
                .map(|text| query("trips", text))
                .collect::<Result<_, _>>()?,
            tripped,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use isolux_profile::parse;

    fn target(profile: &str) -> Target {
        Target::parse(&format!("scpi:x?profile={profile}")).unwrap()
    }

    #[test]
    fn the_shipped_profiles_are_valid() {
        for (name, _) in METERS {
            let meter = Meter::of(&target(name)).unwrap();
            assert!(
                meter.fields.contains(&Field::Voltage) && meter.fields.contains(&Field::Current),
                "{name}"
            );
        }
        for (name, _) in SUPPLIES {
            assert!(Supply::of(&target(name)).unwrap().on.contains("{channel}"), "{name}");
        }
    }

    #[test]
    fn a_bad_profile_is_one_message_with_file_and_line() {
        let good = METERS[0].1;
        let at = |needle: &str| 1 + good[..good.find(needle).unwrap()].matches('\n').count();
        for (from, to, reason) in [
            (
                "fields = [\"voltage_v\", \"current_a\"",
                "fields = [\"voltage_v\", \"voltage_v\"",
                "Voltage is there twice",
            ),
            (
                "format = \"isolux-scpi-meter/1\"",
                "format = \"isolux-scpi-meter/2\"",
                "format must be",
            ),
            (
                "query = \":NUM:NORM:VAL?\"",
                "query = \":NUM:NORM:VAL\"",
                "must be a query",
            ),
            ("form = \"text\"", "form = \"words\"", "unknown variant"),
            ("baud = 9600", "baud = 9", "baud must be"),
        ] {
            let text = good.replacen(from, to, 1);
            assert_ne!(text, good, "{from}");
            let error = parse("x.toml", &text, |document: MeterDocument| document.check())
                .unwrap_err()
                .to_string();
            assert!(
                error.starts_with(&format!("x.toml:{}: ", at(from))) && error.contains(reason),
                "{error}"
            );
        }
        let error = Meter::of(&target("wt9999")).unwrap_err().to_string();
        assert!(error.contains("gpm-8213, pw3336"), "{error}");
    }
}
