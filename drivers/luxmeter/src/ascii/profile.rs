//! What a lux meter in plain ASCII is like, as a TOML file says it.

use std::collections::BTreeMap;
use std::time::Duration;

use isolux_device::{OpenError, Target};
use isolux_profile::wrong;
use isolux_profile::{Address, Ask, Exchange, Line, Manners, Messages, Shipped, Spanned, Wrong, ascii, format, of};
use isolux_protocol_ascii::{Form, Number, Pattern};
use isolux_transport::LineSettings;
use serde::Deserialize;

use crate::language::{Converts, Meaning};
use crate::unit::{Timing, Unit, range};

/// The profiles that come with the program.
const SHIPPED: Shipped = &[
    ("template", include_str!("../../profiles/template.toml")),
    (
        "template-on-request",
        include_str!("../../profiles/template-on-request.toml"),
    ),
];

/// A meter's commands and manners. Always valid.
#[derive(Debug, Clone)]
pub(crate) struct Profile {
    pub model: String,
    pub line: LineSettings,
    pub manners: Manners,
    pub identity: Option<Exchange>,
    /// Sent on opening.
    pub setup: Vec<Exchange>,
    pub reading: Exchange,
    /// What its replies after the first mean: no number, but this.
    codes: Vec<Code>,
    /// Illuminance of one unit of the number, lx.
    scale_lx: f64,
    /// Lowest and highest illuminance that the meter gives, lx.
    pub range_lx: (f64, f64),
    /// One step of the reading, lx; none where it is the last digit that is written.
    pub resolution_lx: Option<f64>,
    pub update_interval: Duration,
    pub integration: Duration,
    pub converts: Converts,
}

/// Which end of the range a reading is beyond.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Code {
    Over,
    Under,
}

/// When the meter converts, as a profile says it.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "snake_case")]
enum Converting {
    /// The command begins a conversion of its own.
    OnRequest,
    /// All the time.
    #[default]
    Always,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Document {
    format: Spanned<String>,
    model: Spanned<String>,
    line: Line,
    messages: Messages,
    identity: Option<Ask>,
    #[serde(default)]
    setup: Vec<Ask>,
    reading: Reading,
    #[serde(default)]
    errors: BTreeMap<String, Spanned<String>>,
    timing: Timing,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Reading {
    command: Spanned<String>,
    reply: Spanned<String>,
    scale: Spanned<f64>,
    unit: Unit,
    range: Spanned<[f64; 2]>,
    resolution: Option<Spanned<f64>>,
    #[serde(default)]
    converts: Converting,
    #[serde(default)]
    over_range: Vec<Spanned<String>>,
    #[serde(default)]
    under_range: Vec<Spanned<String>>,
}

impl Profile {
    /// The profile that `target` names, with its address.
    pub fn of(target: &Target) -> Result<Self, OpenError> {
        let address = Address::of(target);
        of(target, SHIPPED, |document: Document| document.check(&address))
    }

    /// What an answer to the reading says, and one step of it in lx: by its form, and by what stands in the place of
    /// the number.
    pub fn meaning(&self, form: usize, value: Option<&String>) -> Option<(Meaning, f64)> {
        let step_lx = self.resolution_lx;
        let code = match form.checked_sub(1) {
            None => {
                let number = Number::parse(value?.trim())?.scaled(self.scale_lx);
                let meaning = Meaning::of(number.value, self.range_lx);
                return Some((meaning, step_lx.unwrap_or(number.step)));
            }
            Some(code) => self.codes.get(code),
        };
        let meaning = match code {
            Some(Code::Over) => Meaning::OverRange,
            Some(Code::Under) => Meaning::UnderRange,
            None => Meaning::Error(self.manners.error(&self.reading, form)?.to_owned()),
        };
        Some((meaning, step_lx.unwrap_or(1.0)))
    }
}

impl Document {
    fn check(self, address: &Address<'_>) -> Result<Profile, Wrong> {
        format(&self.format, "isolux-ascii-lux/1")?;
        if self.model.get_ref().trim().is_empty() {
            return Err(wrong(self.model.span(), "model must name the meter"));
        }
        let manners = self.messages.check(&self.errors, address)?;
        let reading = &self.reading;
        let ask = Ask {
            command: reading.command.clone(),
            reply: Some(reading.reply.clone()),
        };
        let mut exchange = ask.check("reading", address, None, Some(("value", true)))?;
        for reply in self.errors.values() {
            if exchange.reads(reply.get_ref()) {
                let reason = format!("\"{}\" has two meanings: an error, and a reading", reply.get_ref());
                return Err(wrong(reply.span(), reason));
            }
        }
        let scale = *reading.scale.get_ref();
        if !(scale.is_finite() && scale > 0.0) {
            return Err(wrong(reading.scale.span(), "scale must be above zero"));
        }
        let unit_lx = reading.unit.lx();
        let [low, high] = range(&reading.range)?;
        if let Some(step) = &reading.resolution
            && !(*step.get_ref() > 0.0 && *step.get_ref() < high)
        {
            return Err(wrong(
                step.span(),
                "resolution must be above zero and below the range's end",
            ));
        }
        if reading.converts == Converting::OnRequest && self.identity.is_none() {
            return Err(wrong(
                reading.command.span(),
                "a meter that converts on request needs [identity]: its reply proves that no reading is on its way",
            ));
        }
        let codes = reading.codes(&exchange, &manners)?;
        exchange.replies.extend(codes.iter().map(|(pattern, _)| Form {
            pattern: pattern.clone(),
            number: None,
        }));
        let profile = Profile {
            model: self.model.get_ref().clone(),
            line: self.line.check()?,
            identity: self.identity.map(|ask| ask.check_identity(address)).transpose()?,
            setup: self
                .setup
                .iter()
                .map(|ask| ask.check("setup", address, None, None))
                .collect::<Result<_, _>>()?,
            codes: codes.into_iter().map(|(_, code)| code).collect(),
            reading: exchange,
            manners,
            scale_lx: scale * unit_lx,
            range_lx: (low * unit_lx, high * unit_lx),
            resolution_lx: reading.resolution.as_ref().map(|step| step.get_ref() * unit_lx),
            update_interval: self.timing.update_interval()?,
            integration: self.timing.integration()?,
            converts: match self.reading.converts {
                Converting::OnRequest => Converts::OnRequest,
                Converting::Always => Converts::Always,
            },
        };
        address.is_used(self.format.span())?;
        Ok(profile)
    }
}

impl Reading {
    /// The answers that are no number. Each has one meaning, and none reads as a number.
    fn codes(&self, exchange: &Exchange, manners: &Manners) -> Result<Vec<(Pattern, Code)>, Wrong> {
        let over = self.over_range.iter().map(|text| (text, Code::Over));
        let under = self.under_range.iter().map(|text| (text, Code::Under));
        let mut codes: Vec<(Pattern, Code)> = Vec::new();
        for (text, code) in over.chain(under) {
            let refuse = |reason: String| Err(wrong(text.span(), reason));
            let whole = ascii("over_range and under_range", text)?;
            let pattern = match Pattern::parse(&whole) {
                Ok(pattern) if pattern.names().next().is_none() => pattern,
                Ok(_) => return refuse("over_range and under_range are texts without fields".to_owned()),
                Err(error) => return refuse(error.to_string()),
            };
            if exchange.reads(&whole) {
                return refuse(format!("\"{whole}\" has two meanings: this code, and a reading"));
            }
            if codes.iter().any(|(known, _)| *known == pattern) {
                return refuse(format!(
                    "\"{whole}\" has two meanings: it stands in two lists, or twice in one"
                ));
            }
            if manners.errors().any(|error| error.read(&whole).is_some()) {
                return refuse(format!("\"{whole}\" has two meanings: this code, and one of [errors]"));
            }
            codes.push((pattern, code));
        }
        Ok(codes)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use isolux_profile::parse;

    const TEMPLATE: &str = SHIPPED[0].1;

    fn checked(text: &str, open: &str) -> Result<Profile, String> {
        let target = Target::parse(open).unwrap();
        let address = Address::of(&target);
        parse("m.toml", text, |document: Document| document.check(&address)).map_err(|error| error.to_string())
    }

    #[test]
    fn the_template_is_valid_and_its_keys_mean_what_they_say() {
        let profile = checked(TEMPLATE, "ascii-lux:x").unwrap();
        assert_eq!(profile.line.to_string(), "9600 8N1");
        assert_eq!((profile.codes.len(), profile.range_lx), (2, (-100.0, 200_000.0)));
        let value = "123.45".to_owned();
        assert_eq!(profile.meaning(0, Some(&value)), Some((Meaning::Lux(123.45), 0.01)));
        assert_eq!(
            profile.meaning(0, Some(&"200001".to_owned())),
            Some((Meaning::OverRange, 1.0))
        );
        assert_eq!(profile.meaning(1, None), Some((Meaning::OverRange, 1.0)));
        assert_eq!(profile.meaning(2, None), Some((Meaning::UnderRange, 1.0)));
        assert!(matches!(profile.meaning(3, None), Some((Meaning::Error(_), _))));
        let feet = TEMPLATE.replace("unit = \"lx\"", "unit = \"fc\"");
        let profile = checked(&feet, "ascii-lux:x").unwrap();
        // 1 fc = 10.763910 lx.
        let Some((Meaning::Lux(lux), step)) = profile.meaning(0, Some(&"1.0".to_owned())) else {
            panic!()
        };
        assert!((lux - 10.763_910).abs() < 1e-6 && (step - 1.076_391).abs() < 1e-6);
    }

    #[test]
    fn a_meter_that_converts_on_request_says_so_and_has_a_proof() {
        assert_eq!(checked(TEMPLATE, "ascii-lux:x").unwrap().converts, Converts::Always);
        let text = SHIPPED[1].1;
        assert_eq!(checked(text, "ascii-lux:x").unwrap().converts, Converts::OnRequest);
        let (from, to) = (text.find("[identity]").unwrap(), text.find("[[setup]]").unwrap());
        let without = format!("{}{}", &text[..from], &text[to..]);
        let error = checked(&without, "ascii-lux:x").unwrap_err();
        assert!(error.contains("needs [identity]"), "{error}");
    }

    #[test]
    fn each_bad_profile_is_one_message_with_file_line_and_remedy() {
        let at = |needle: &str| 1 + TEMPLATE[..TEMPLATE.find(needle).unwrap()].matches('\n').count();
        for (from, to, after, part) in [
            ("scale = 1.0", "scale = 1.0\nspeed = 1", 1, "unknown field `speed`"),
            ("scale = 1.0", "scale = 1.0\nscale = 0.1", 1, "duplicate key"),
            ("scale = 1.0", "scale = 0.0", 0, "above zero"),
            (
                "scale = 1.0",
                "converts = \"sometimes\"\nscale = 1.0",
                0,
                "unknown variant `sometimes`",
            ),
            ("unit = \"lx\"", "unit = \"lux\"", 0, "unknown variant `lux`"),
            (
                "terminator = \"crlf\"",
                "terminator = \"nul\"",
                0,
                "unknown variant `nul`",
            ),
            ("terminator = \"crlf\"", "", -1, "missing field `terminator`"),
            ("reply = \"E {value} lx\"", "reply = \"E lx\"", 0, "holds {value} once"),
            (
                "reply = \"E {value} lx\"",
                "reply = \"E {value}{unit}\"",
                0,
                "directly after another field",
            ),
            (
                "reply = \"E {value} lx\"",
                "reply = \"E {value} {unit}\"",
                0,
                "no other field",
            ),
            ("reply = \"E {value} lx\"", "reply = \"E {value\"", 0, "other half"),
            (
                "reply = \"E {value} lx\"",
                "reply = \"{address} {value} lx\"",
                0,
                "add address=",
            ),
            (
                "command = \"E?\"",
                "command = \"E{channel}?\"",
                0,
                "no place but {address}",
            ),
            ("command = \"E?\"", "command = \"\"", 0, "not empty"),
            (
                "over_range = [\"E OVER\"]",
                "over_range = [\"E 9999 lx\"]",
                0,
                "two meanings: this code, and a reading",
            ),
            (
                "over_range = [\"E OVER\"]",
                "over_range = [\"E UNDER\"]",
                1,
                "it stands in two lists",
            ),
            (
                "over_range = [\"E OVER\"]",
                "over_range = [\"ERR 1\"]",
                0,
                "one of [errors]",
            ),
            (
                "= \"ERR {code}\"",
                "= \"E 1 lx\"",
                0,
                "two meanings: an error, and a reading",
            ),
            (
                "range = [-100.0, 200000.0]",
                "range = [1.0, 0.0]",
                0,
                "[lowest, highest]",
            ),
            ("answer_s = 1.0", "answer_s = 0", 0, "answer_s must be 0.001 to 60"),
            ("baud = 9600", "baud = 96", 0, "baud must be"),
            ("ascii-lux/1", "ascii-lux/2", 0, "format must be"),
            (
                "{model},{serial}",
                "{model},{number}",
                0,
                "{number}: the reply of [identity] has the fields maker",
            ),
        ] {
            let line = (at(from) as i64 + after).max(1);
            let error = checked(&TEMPLATE.replacen(from, to, 1), "ascii-lux:x").unwrap_err();
            assert!(error.contains(part), "{to}: {error}");
            let exact = after >= 0;
            assert!(
                !exact || error.starts_with(&format!("m.toml:{line}: ")),
                "{to}: {line}: {error}"
            );
            assert_eq!(error.lines().count(), 1, "{error}");
        }
        let error = checked(TEMPLATE, "ascii-lux:x?address=3").unwrap_err();
        assert!(error.contains("address=3 is given, and no command"), "{error}");
        let addressed = TEMPLATE.replace("\"E?\"", "\"{address}E?\"");
        assert!(checked(&addressed, "ascii-lux:x?address=3").is_ok());
        assert!(
            checked(&addressed, "ascii-lux:x?address=3+")
                .unwrap_err()
                .contains("letters and digits")
        );
    }
}
