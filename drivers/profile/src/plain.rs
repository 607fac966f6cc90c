//! Instruments in plain ASCII: what every profile of one says. `[messages]`, `[errors]`, `[identity]`, and commands
//! with the replies to them.

use std::cell::Cell;
use std::collections::BTreeMap;
use std::ops::Range;
use std::time::Duration;

use isolux_device::Target;
use isolux_protocol_ascii::{End, Fields, Form, Message, Number, Pattern};
use serde::Deserialize;

use crate::{Spanned, Wrong, ascii, seconds, wrong};

/// What stands for the address of an instrument in commands and replies.
const ADDRESS: &str = "{address}";

/// Fields of the reply of `[identity]`.
const NAMES: [&str; 4] = ["maker", "model", "serial", "firmware"];

/// What the station says in `address=`, and whether the profile has a place for it.
#[derive(Debug)]
pub struct Address<'a> {
    given: Option<&'a str>,
    used: Cell<bool>,
}

impl<'a> Address<'a> {
    /// That of `target`.
    pub fn of(target: &'a Target) -> Self {
        Self {
            given: target.option("address"),
            used: Cell::new(false),
        }
    }

    /// `text` with the address in its place.
    fn put(&self, text: &str, span: Range<usize>) -> Result<String, Wrong> {
        if !text.contains(ADDRESS) {
            return Ok(text.to_owned());
        }
        self.used.set(true);
        match self.given {
            None => Err(wrong(span, "{address} stands here: add address=… to `open`")),
            Some(given) if (1..=8).contains(&given.len()) && given.bytes().all(|byte| byte.is_ascii_alphanumeric()) => {
                Ok(text.replace(ADDRESS, given))
            }
            Some(given) => Err(wrong(
                span,
                format!("address={given}: an address is one to eight letters and digits"),
            )),
        }
    }

    /// Refuses an address that nothing uses; for the end of a check. `span` is where the profile begins.
    ///
    /// # Errors
    /// [`Wrong`].
    pub fn is_used(&self, span: Range<usize>) -> Result<(), Wrong> {
        match self.given {
            Some(given) if !self.used.get() => Err(wrong(
                span,
                format!("address={given} is given, and no command of this profile holds {{address}}"),
            )),
            _ => Ok(()),
        }
    }
}

/// `[messages]`.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Messages {
    terminator: Terminator,
    reply_terminator: Option<Terminator>,
    #[serde(default)]
    echo: bool,
    answer_s: Spanned<f64>,
}

#[derive(Debug, Clone, Copy, Deserialize)]
#[serde(rename_all = "lowercase")]
enum Terminator {
    Cr,
    Lf,
    CrLf,
}

impl From<Terminator> for End {
    fn from(terminator: Terminator) -> Self {
        match terminator {
            Terminator::Cr => Self::Cr,
            Terminator::Lf => Self::Lf,
            Terminator::CrLf => Self::CrLf,
        }
    }
}

/// How the instrument converses. Always valid.
#[derive(Debug, Clone, PartialEq)]
pub struct Manners {
    end: End,
    answer_end: End,
    echo: bool,
    /// The slowest answer has come within this.
    pub answer: Duration,
    /// Replies that mean an error, each with its meaning.
    errors: Vec<(String, Pattern)>,
}

impl Messages {
    /// The manners, with the errors of `[errors]`: meaning and reply.
    ///
    /// # Errors
    /// [`Wrong`].
    pub fn check(&self, errors: &BTreeMap<String, Spanned<String>>, address: &Address<'_>) -> Result<Manners, Wrong> {
        let mut known: Vec<(String, Pattern)> = Vec::new();
        for (meaning, reply) in errors {
            let form = pattern("an error", reply, address)?;
            if let Some((other, _)) = known.iter().find(|(_, other)| *other == form) {
                let reason = format!(
                    "\"{}\" has two meanings: \"{other}\" and \"{meaning}\"",
                    reply.get_ref()
                );
                return Err(wrong(reply.span(), reason));
            }
            known.push((meaning.clone(), form));
        }
        Ok(Manners {
            end: self.terminator.into(),
            answer_end: self.reply_terminator.unwrap_or(self.terminator).into(),
            echo: self.echo,
            answer: seconds("answer_s", &self.answer_s)?,
            errors: known,
        })
    }
}

impl Manners {
    /// Its replies that mean an error, to see whether something else reads as one.
    pub fn errors(&self) -> impl Iterator<Item = &Pattern> {
        self.errors.iter().map(|(_, form)| form)
    }

    /// The message of `exchange` with `value` in its place. Its answer has one of the forms of the replies or means an
    /// error, and has none of the forms `unlike`.
    pub fn message(&self, exchange: &Exchange, value: &str, unlike: &[Form]) -> Message {
        let error = |(_, pattern): &(String, Pattern)| Form {
            pattern: pattern.clone(),
            number: None,
        };
        let replies = exchange.replies.iter().cloned();
        Message {
            text: exchange.text(value),
            end: self.end,
            answer_end: self.answer_end,
            echo: self.echo,
            forms: if exchange.replies.is_empty() {
                // Nothing answers, an error neither.
                Vec::new()
            } else {
                replies.chain(self.errors.iter().map(error)).collect()
            },
            unlike: unlike.to_vec(),
            // A line in doubt rests for longer than the slowest answer takes.
            quiet: 2 * self.answer,
        }
    }

    /// The meaning of an answer to `exchange` with this form, if it is an error.
    pub fn error(&self, exchange: &Exchange, form: usize) -> Option<&str> {
        // What nothing answers is no error.
        let replies = Some(exchange.replies.len()).filter(|count| *count > 0)?;
        let (meaning, _) = self.errors.get(form.checked_sub(replies)?)?;
        Some(meaning)
    }
}

/// A command and the reply to it.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Ask {
    /// What is sent.
    pub command: Spanned<String>,
    /// What it is answered with; left out, the instrument answers nothing.
    pub reply: Option<Spanned<String>>,
}

/// A command and the reply to it, valid.
#[derive(Debug, Clone, PartialEq)]
pub struct Exchange {
    command: String,
    /// The forms that the reply may have; none: nothing answers.
    pub replies: Vec<Form>,
}

impl Ask {
    /// The exchange that `[key]` describes. The command holds the places `input` and no others, the reply the field
    /// `output` and no other; `number` says that a number stands there. Where there is an output there must be a reply.
    ///
    /// # Errors
    /// [`Wrong`].
    pub fn check(
        &self,
        key: &str,
        address: &Address<'_>,
        input: Option<&str>,
        output: Option<(&'static str, bool)>,
    ) -> Result<Exchange, Wrong> {
        let span = || self.command.span();
        let command = address.put(&ascii("command", &self.command)?, span())?;
        let places = Pattern::parse(&command).map_err(|error| wrong(span(), format!("command of [{key}]: {error}")))?;
        let found: Vec<&str> = places.names().collect();
        if found != input.into_iter().collect::<Vec<_>>() {
            let reason = match input {
                Some(input) => {
                    format!("the command of [{key}] holds {{{input}}} once, and no other place but {{address}}")
                }
                None => format!(
                    "the command of [{key}] has no place but {{address}}, and {{{}}} stands there",
                    found[0]
                ),
            };
            return Err(wrong(span(), reason));
        }
        let replies = match (&self.reply, output) {
            (None, Some((field, _))) => {
                return Err(wrong(span(), format!("[{key}] needs a reply, with {{{field}}} in it")));
            }
            (None, None) => Vec::new(),
            (Some(reply), _) => vec![form(key, reply, address, output)?],
        };
        Ok(Exchange { command, replies })
    }

    /// The exchange of `[identity]`, whose reply has the fields `maker`, `model`, `serial`, `firmware`, or fewer.
    ///
    /// # Errors
    /// [`Wrong`].
    pub fn check_identity(&self, address: &Address<'_>) -> Result<Exchange, Wrong> {
        let Some(reply) = &self.reply else {
            return Err(wrong(self.command.span(), "[identity] needs a reply"));
        };
        let command = Self {
            command: self.command.clone(),
            reply: None,
        };
        let pattern = pattern("the reply of [identity]", reply, address)?;
        if let Some(other) = pattern.names().find(|name| !NAMES.contains(name)) {
            let reason = format!(
                "{{{other}}}: the reply of [identity] has the fields {}",
                NAMES.join(", ")
            );
            return Err(wrong(reply.span(), reason));
        }
        Ok(Exchange {
            replies: vec![Form { pattern, number: None }],
            ..command.check("identity", address, None, None)?
        })
    }
}

fn pattern(what: &str, text: &Spanned<String>, address: &Address<'_>) -> Result<Pattern, Wrong> {
    let whole = address.put(&ascii("reply", text)?, text.span())?;
    Pattern::parse(&whole).map_err(|error| wrong(text.span(), format!("{what}: {error}")))
}

fn form(
    key: &str,
    text: &Spanned<String>,
    address: &Address<'_>,
    output: Option<(&'static str, bool)>,
) -> Result<Form, Wrong> {
    let pattern = pattern(&format!("the reply of [{key}]"), text, address)?;
    let found: Vec<&str> = pattern.names().collect();
    if found != output.iter().map(|(field, _)| *field).collect::<Vec<_>>() {
        let reason = match output {
            Some((field, _)) => format!("the reply of [{key}] holds {{{field}}} once, and no other field"),
            None => format!("the reply of [{key}] is a text without fields"),
        };
        return Err(wrong(text.span(), reason));
    }
    let number = output.filter(|(_, number)| *number).map(|(field, _)| field);
    Ok(Form { pattern, number })
}

impl Exchange {
    /// The command, with `value` in its place.
    pub fn text(&self, value: &str) -> String {
        let (Some(from), Some(to)) = (self.command.find('{'), self.command.find('}')) else {
            return self.command.clone();
        };
        format!("{}{value}{}", &self.command[..from], &self.command[to + 1..])
    }

    /// Whether `line` would be taken for its reply.
    pub fn reads(&self, line: &str) -> bool {
        self.replies.iter().any(|form| form.read(line).is_some())
    }

    /// The same where `field` of the reply is one of `words`: one form a word, in their order.
    #[must_use]
    pub fn of_words<'a>(self, field: &str, words: impl IntoIterator<Item = &'a str>) -> Self {
        let form = |word: &str| self.replies.first().map(|form| form.pattern.with(field, word));
        let patterns = words.into_iter().filter_map(form);
        let replies = patterns.map(|pattern| Form { pattern, number: None }).collect();
        Self {
            command: self.command,
            replies,
        }
    }
}

/// What `fields` of the reply of `[identity]` say: maker and model in one, serial number, firmware.
pub fn identity(fields: &Fields) -> (String, Option<String>, Option<String>) {
    let field = |name: &str| fields.get(name).map(|text| text.trim().to_owned());
    let model = [field("maker"), field("model")].into_iter().flatten();
    (model.collect::<Vec<_>>().join(" "), field("serial"), field("firmware"))
}

/// A number with at most `decimals` digits after its point, as a whole count of the last of them.
pub fn counts(text: &str, decimals: u8) -> Option<i64> {
    Number::parse(text)?;
    let (sign, digits) = match text.strip_prefix('-') {
        Some(rest) => (-1, rest),
        None => (1, text.strip_prefix('+').unwrap_or(text)),
    };
    let (whole, fraction) = digits.split_once('.').unwrap_or((digits, ""));
    let places = usize::from(decimals);
    let (kept, beyond) = fraction.split_at_checked(places).unwrap_or((fraction, ""));
    if beyond.bytes().any(|digit| digit != b'0') {
        return None;
    }
    let count: i64 = format!("{whole}{kept:0<places$}").parse().ok()?;
    Some(sign * count)
}

/// `count` as [`counts`] reads it.
pub fn decimal(count: i64, decimals: u8) -> String {
    let places = usize::from(decimals);
    let digits = format!("{:0>width$}", count.unsigned_abs(), width = places + 1);
    let (whole, fraction) = digits.split_at(digits.len() - places);
    let sign = if count < 0 { "-" } else { "" };
    let point = if places == 0 { "" } else { "." };
    format!("{sign}{whole}{point}{fraction}")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn positions_are_counts_without_rounding() {
        for (text, decimals, count) in [
            ("-12345", 0, Some(-12_345)),
            ("+12.5", 3, Some(12_500)),
            ("-0.005", 3, Some(-5)),
            (".5", 1, Some(5)),
            ("7.000", 1, Some(70)),
            ("7.001", 1, None),
            ("1E3", 0, None),
            ("12,5", 3, None),
            ("", 3, None),
            ("99999999999999999999", 0, None),
        ] {
            assert_eq!(counts(text, decimals), count, "{text}");
        }
        for (count, decimals, text) in [(-5, 3, "-0.005"), (12_500, 3, "12.500"), (-7, 0, "-7"), (0, 2, "0.00")] {
            assert_eq!(decimal(count, decimals), text);
            assert_eq!(counts(text, decimals), Some(count));
        }
    }
}
