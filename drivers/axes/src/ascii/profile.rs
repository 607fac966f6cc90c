//! What an axis in plain ASCII is like, as a TOML file says it.

use std::collections::BTreeMap;

use isolux_device::{OpenError, Target};
use isolux_profile::{
    Address, Ask, Exchange, Line, Manners, Messages, Shipped, Spanned, Wrong, ascii, counts, format, of, wrong,
};
use isolux_transport::LineSettings;
use serde::Deserialize;

/// The profiles that come with the program.
const SHIPPED: Shipped = &[("template", include_str!("../../profiles/template.toml"))];

/// More digits than any controller has.
const MOST_DECIMALS: u8 = 6;

/// An axis' commands and manners. Always valid.
#[derive(Debug, Clone)]
pub(crate) struct Profile {
    pub model: String,
    pub line: LineSettings,
    pub manners: Manners,
    pub identity: Option<Exchange>,
    /// Sent on opening.
    pub setup: Vec<Exchange>,
    pub speed: Option<Setting>,
    pub acceleration: Option<Setting>,
    pub position: Exchange,
    /// Digits after the point of a position: a count is one of the last.
    pub decimals: u8,
    pub tolerance_steps: u64,
    pub go: Exchange,
    pub stop: Exchange,
    pub kill: Option<Exchange>,
    pub home: Exchange,
    /// Where the axis rests after it, in counts.
    pub home_steps: i64,
    /// One reply a word.
    pub state: Words<State>,
    pub reference: Option<Words<bool>>,
}

/// A question that is answered by one of a few words.
#[derive(Debug, Clone)]
pub(crate) struct Words<M> {
    /// One reply a word.
    pub exchange: Exchange,
    meanings: Vec<M>,
}

impl<M: Clone> Words<M> {
    fn new(exchange: Exchange, field: &str, words: Vec<(String, M)>) -> Self {
        Self {
            exchange: exchange.of_words(field, words.iter().map(|(word, _)| word.as_str())),
            meanings: words.into_iter().map(|(_, meaning)| meaning).collect(),
        }
    }

    /// What the answer with this form says.
    pub fn meaning(&self, form: usize) -> Option<M> {
        self.meanings.get(form).cloned()
    }
}

/// A speed or an acceleration: how it is set, and how it is read back.
#[derive(Debug, Clone)]
pub(crate) struct Setting {
    pub set: Exchange,
    pub query: Exchange,
    pub decimals: u8,
    /// In the unit of the position per s or s².
    pub range: [f64; 2],
}

/// What a word for the state says.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) enum State {
    Moving,
    Resting,
    /// In the words of the profile.
    Fault(String),
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
    speed: Option<SettingDocument>,
    acceleration: Option<SettingDocument>,
    position: PositionDocument,
    #[serde(rename = "move")]
    go: Ask,
    stop: Ask,
    kill: Option<Ask>,
    home: HomeDocument,
    state: StateDocument,
    reference: Option<ReferenceDocument>,
    #[serde(default)]
    errors: BTreeMap<String, Spanned<String>>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct SettingDocument {
    command: Spanned<String>,
    reply: Option<Spanned<String>>,
    query: Spanned<String>,
    query_reply: Spanned<String>,
    decimals: Spanned<u8>,
    range: Spanned<[f64; 2]>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct PositionDocument {
    command: Spanned<String>,
    reply: Spanned<String>,
    decimals: Spanned<u8>,
    #[serde(default)]
    tolerance: u32,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct HomeDocument {
    command: Spanned<String>,
    reply: Option<Spanned<String>>,
    position: Spanned<f64>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct StateDocument {
    command: Spanned<String>,
    reply: Spanned<String>,
    moving: Spanned<Vec<Spanned<String>>>,
    resting: Spanned<Vec<Spanned<String>>>,
    #[serde(default)]
    faults: BTreeMap<String, Spanned<String>>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct ReferenceDocument {
    command: Spanned<String>,
    reply: Spanned<String>,
    found: Spanned<Vec<Spanned<String>>>,
    missing: Spanned<Vec<Spanned<String>>>,
}

impl Profile {
    /// The profile that `target` names, with its address.
    pub fn of(target: &Target) -> Result<Self, OpenError> {
        let address = Address::of(target);
        of(target, SHIPPED, |document: Document| document.check(&address))
    }
}

fn ask(command: &Spanned<String>, reply: Option<&Spanned<String>>) -> Ask {
    Ask {
        command: command.clone(),
        reply: reply.cloned(),
    }
}

fn decimals(value: &Spanned<u8>) -> Result<u8, Wrong> {
    match *value.get_ref() {
        digits @ 0..=MOST_DECIMALS => Ok(digits),
        _ => Err(wrong(value.span(), format!("decimals must be 0 to {MOST_DECIMALS}"))),
    }
}

/// Adds words with their meaning; each has one.
fn words<'a, M: Clone>(
    into: &mut Vec<(String, M)>,
    list: impl IntoIterator<Item = (&'a Spanned<String>, M)>,
) -> Result<(), Wrong> {
    for (word, meaning) in list {
        let text = ascii("a word", word)?.trim().to_owned();
        if into.iter().any(|(known, _)| *known == text) {
            let reason = format!("\"{text}\" has two meanings: it stands in two lists, or twice in one");
            return Err(wrong(word.span(), reason));
        }
        into.push((text, meaning));
    }
    Ok(())
}

fn needed(key: &str, list: &Spanned<Vec<Spanned<String>>>) -> Result<(), Wrong> {
    if list.get_ref().is_empty() {
        return Err(wrong(list.span(), format!("{key} names at least one word")));
    }
    Ok(())
}

impl Document {
    fn check(self, address: &Address<'_>) -> Result<Profile, Wrong> {
        format(&self.format, "isolux-ascii-axis/1")?;
        if self.model.get_ref().trim().is_empty() {
            return Err(wrong(self.model.span(), "model must name the drive"));
        }
        let manners = self.messages.check(&self.errors, address)?;
        let plain = |key: &str, ask: &Ask| ask.check(key, address, None, None);
        let place = &self.position;
        let position =
            ask(&place.command, Some(&place.reply)).check("position", address, None, Some(("position", true)))?;
        let digits = decimals(&place.decimals)?;
        let state = &self.state;
        let field = "state";
        let requested = ask(&state.command, Some(&state.reply)).check(field, address, None, Some((field, false)))?;
        let profile = Profile {
            model: self.model.get_ref().clone(),
            line: self.line.check()?,
            identity: self.identity.map(|ask| ask.check_identity(address)).transpose()?,
            setup: self
                .setup
                .iter()
                .map(|ask| plain("setup", ask))
                .collect::<Result<_, _>>()?,
            speed: (self.speed.as_ref().map(|speed| speed.check("speed", address))).transpose()?,
            acceleration: (self
                .acceleration
                .as_ref()
                .map(|speed| speed.check("acceleration", address)))
            .transpose()?,
            position,
            decimals: digits,
            tolerance_steps: place.tolerance.into(),
            go: self.go.check("move", address, Some("target"), None)?,
            stop: plain("stop", &self.stop)?,
            kill: self.kill.as_ref().map(|ask| plain("kill", ask)).transpose()?,
            home: plain("home", &ask(&self.home.command, self.home.reply.as_ref()))?,
            home_steps: self.home.steps(digits)?,
            state: Words::new(requested, field, state.words()?),
            reference: (self.reference.as_ref().map(|reference| reference.check(address))).transpose()?,
            manners,
        };
        address.is_used(self.format.span())?;
        Ok(profile)
    }
}

impl ReferenceDocument {
    fn check(&self, address: &Address<'_>) -> Result<Words<bool>, Wrong> {
        let field = "reference";
        let requested = ask(&self.command, Some(&self.reply)).check(field, address, None, Some((field, false)))?;
        let mut references = Vec::new();
        for (key, list, found) in [("found", &self.found, true), ("missing", &self.missing, false)] {
            needed(key, list)?;
            words(&mut references, list.get_ref().iter().map(|word| (word, found)))?;
        }
        Ok(Words::new(requested, field, references))
    }
}

impl StateDocument {
    fn words(&self) -> Result<Vec<(String, State)>, Wrong> {
        let mut states = Vec::new();
        for (key, list, state) in [
            ("moving", &self.moving, State::Moving),
            ("resting", &self.resting, State::Resting),
        ] {
            needed(key, list)?;
            words(&mut states, list.get_ref().iter().map(|word| (word, state.clone())))?;
        }
        let faults = self
            .faults
            .iter()
            .map(|(meaning, word)| (word, State::Fault(meaning.clone())));
        words(&mut states, faults)?;
        Ok(states)
    }
}

impl HomeDocument {
    /// Its position as a count.
    fn steps(&self, decimals: u8) -> Result<i64, Wrong> {
        // Written as it was read: 0.1 is a digit here, not a binary number.
        let text = self.position.get_ref().to_string();
        counts(&text, decimals).ok_or_else(|| {
            let reason = format!("position {text} is no position with {decimals} digits after the point");
            wrong(self.position.span(), reason)
        })
    }
}

impl SettingDocument {
    fn check(&self, key: &str, address: &Address<'_>) -> Result<Setting, Wrong> {
        let [least, most] = *self.range.get_ref();
        if !(least.is_finite() && most.is_finite() && least > 0.0 && least < most) {
            return Err(wrong(self.range.span(), "range must be [least, most], both above zero"));
        }
        let read_back = ask(&self.query, Some(&self.query_reply));
        Ok(Setting {
            set: ask(&self.command, self.reply.as_ref()).check(key, address, Some("value"), None)?,
            query: read_back.check(key, address, None, Some(("value", true)))?,
            decimals: decimals(&self.decimals)?,
            range: [least, most],
        })
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
        parse("t.toml", text, |document: Document| document.check(&address)).map_err(|error| error.to_string())
    }

    #[test]
    fn the_template_is_valid_and_needs_an_address() {
        let profile = checked(TEMPLATE, "ascii-axis:x?address=2").unwrap();
        assert_eq!(
            (profile.line.to_string().as_str(), profile.go.text("-17")),
            ("19200 8N1", "2 GO -17".to_owned())
        );
        let says = |line: &str| {
            let forms = &profile.state.exchange.replies;
            profile
                .state
                .meaning(forms.iter().position(|form| form.read(line).is_some())?)
        };
        assert_eq!(says("2 STATE HOMING"), Some(State::Moving));
        assert_eq!(says("2 STATE STALL"), Some(State::Fault("stalled".to_owned())));
        assert_eq!((says("2 STATE RAEDY"), says("1 STATE READY")), (None, None));
        let error = checked(TEMPLATE, "ascii-axis:x").unwrap_err();
        assert!(error.contains("add address="), "{error}");
    }

    #[test]
    fn each_bad_profile_is_one_message_with_file_line_and_remedy() {
        let at = |needle: &str| 1 + TEMPLATE[..TEMPLATE.find(needle).unwrap()].matches('\n').count();
        for (from, to, part) in [
            ("GO {target}\"", "GO\"", "the command of [move] holds {target} once"),
            (
                "GO {target}\"",
                "GO {position}\"",
                "the command of [move] holds {target} once",
            ),
            (
                "POS {position}\"",
                "POS\"",
                "the reply of [position] holds {position} once",
            ),
            ("STATE {state}\"", "STATE {state} {more}\"", "no other field"),
            (
                "moving = [\"MOVING\", \"HOMING\"]",
                "moving = []",
                "moving names at least one word",
            ),
            (
                "resting = [\"READY\"]",
                "resting = [\"MOVING\"]",
                "\"MOVING\" has two meanings",
            ),
            (
                "\"stalled\" = \"STALL\"",
                "\"stalled\" = \"READY\"",
                "\"READY\" has two meanings",
            ),
            ("missing = [\"NO\"]", "missing = [\"YES\"]", "\"YES\" has two meanings"),
            ("position = 0.0", "position = 0.5", "no position with 0 digits"),
            ("range = [1.0, 1000000.0]", "range = [0.0, 1.0]", "both above zero"),
            (
                "command = \"{address} STOP\"",
                "command = \"{address} STOP {now}\"",
                "no place but {address}",
            ),
            ("ERR 1\"", "ERR 2\"", "has two meanings"),
            ("baud = 19200", "baud = 19200\nspeed = 3", "unknown field `speed`"),
        ] {
            let error = checked(&TEMPLATE.replacen(from, to, 1), "ascii-axis:x?address=1").unwrap_err();
            let line = at(from) + usize::from(to.contains('\n'));
            assert!(error.contains(part), "{to}: {error}");
            // Of two replies with one meaning either may be named.
            assert!(
                part == "has two meanings" || error.starts_with(&format!("t.toml:{line}: ")),
                "{to}: {error}"
            );
            assert_eq!(error.lines().count(), 1, "{error}");
        }
        for section in ["[stop] ", "[state] ", "[home] "] {
            let begin = TEMPLATE.find(section).unwrap();
            let end = begin + TEMPLATE[begin..].find("\n\n").unwrap();
            let without = format!("{}{}", &TEMPLATE[..begin], &TEMPLATE[end..]);
            let error = checked(&without, "ascii-axis:x?address=1").unwrap_err();
            assert!(error.contains("missing field"), "{section}: {error}");
        }
    }
}
