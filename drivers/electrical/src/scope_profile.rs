//! What an oscilloscope in SCPI is like, as a TOML file says it.

use isolux_device::{OpenError, Target};
use isolux_profile::{Line, Shipped, Spanned, Wrong, ascii, format, of, wrong};
use serde::Deserialize;

use crate::profile::{Manners, MannersDocument, query};

/// Oscilloscopes that come with the program.
const SCOPES: Shipped = &[("ds1000z", include_str!("../profiles/ds1000z.toml"))];

/// An oscilloscope. In its messages `{channel}` stands for the input and `{value}` for a number.
#[derive(Debug, Clone)]
pub(crate) struct Scope {
    pub manners: Manners,
    pub channels: u8,
    pub coupling: String,
    pub dc: String,
    pub before: Vec<String>,
    pub time_base: String,
    pub divisions: u32,
    pub depth: String,
    /// Rising.
    pub depths: Vec<u64>,
    pub start: Vec<String>,
    pub state: String,
    pub stopped: String,
    pub preamble: String,
    pub origin: Origin,
    pub from: String,
    pub to: String,
    pub data: String,
    pub points_a_read: u64,
    /// Codes at the ends of the range.
    pub codes: [u8; 2],
}

/// What the y origin of a preamble counts.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "lowercase")]
pub(crate) enum Origin {
    /// Volts = (code − y origin − y reference) · y increment.
    Codes,
    /// Volts = (code − y reference) · y increment + y origin.
    Volts,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct ScopeDocument {
    format: Spanned<String>,
    line: Line,
    instrument: MannersDocument,
    record: RecordDocument,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct RecordDocument {
    channels: Spanned<u8>,
    coupling: Spanned<String>,
    dc: Spanned<String>,
    before: Vec<Spanned<String>>,
    time_base: Spanned<String>,
    divisions: Spanned<u32>,
    depth: Spanned<String>,
    depths: Spanned<Vec<u64>>,
    start: Vec<Spanned<String>>,
    state: Spanned<String>,
    stopped: Spanned<String>,
    preamble: Spanned<String>,
    origin: Origin,
    from: Spanned<String>,
    to: Spanned<String>,
    data: Spanned<String>,
    points_a_read: Spanned<u64>,
    codes: Spanned<[u8; 2]>,
}

impl Scope {
    /// The profile that `target` names.
    pub fn of(target: &Target) -> Result<Self, OpenError> {
        of(target, SCOPES, |document: ScopeDocument| document.check())
    }
}

impl ScopeDocument {
    fn check(self) -> Result<Scope, Wrong> {
        format(&self.format, "isolux-scpi-oscilloscope/1")?;
        let record = &self.record;
        let within = |key: &str, value: u64, at: std::ops::Range<usize>, most: u64| {
            if (1..=most).contains(&value) {
                Ok(())
            } else {
                Err(wrong(at, format!("{key} must be 1 to {most}")))
            }
        };
        within(
            "channels",
            u64::from(*record.channels.get_ref()),
            record.channels.span(),
            9,
        )?;
        within(
            "divisions",
            u64::from(*record.divisions.get_ref()),
            record.divisions.span(),
            100,
        )?;
        within(
            "points_a_read",
            *record.points_a_read.get_ref(),
            record.points_a_read.span(),
            1_000_000,
        )?;
        let depths = record.depths.get_ref();
        if depths.first().is_none_or(|first| *first == 0) || !depths.is_sorted_by(|a, b| a < b) {
            return Err(wrong(
                record.depths.span(),
                "depths must be numbers above zero that rise",
            ));
        }
        let [low, high] = *record.codes.get_ref();
        if low >= high {
            return Err(wrong(record.codes.span(), "codes are the lowest and the highest one"));
        }
        let level = |key: &str, text: &Spanned<String>| {
            let message = ascii(key, text)?;
            if message.contains("{value}") && !message.contains('?') {
                Ok(message)
            } else {
                Err(wrong(text.span(), format!("{key} must be a command with {{value}}")))
            }
        };
        let commands = |key: &str, texts: &[Spanned<String>]| {
            texts.iter().map(|text| ascii(key, text)).collect::<Result<Vec<_>, _>>()
        };
        let mut manners = self.instrument.check(&self.line)?;
        manners.longest_block = *record.points_a_read.get_ref() as usize;
        Ok(Scope {
            manners,
            channels: *record.channels.get_ref(),
            coupling: query("coupling", &record.coupling)?,
            dc: ascii("dc", &record.dc)?,
            before: commands("before", &record.before)?,
            time_base: level("time_base", &record.time_base)?,
            divisions: *record.divisions.get_ref(),
            depth: level("depth", &record.depth)?,
            depths: depths.clone(),
            start: commands("start", &record.start)?,
            state: query("state", &record.state)?,
            stopped: ascii("stopped", &record.stopped)?,
            preamble: query("preamble", &record.preamble)?,
            origin: record.origin,
            from: level("from", &record.from)?,
            to: level("to", &record.to)?,
            data: query("data", &record.data)?,
            points_a_read: *record.points_a_read.get_ref(),
            codes: [low, high],
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use isolux_profile::parse;

    #[test]
    fn the_shipped_profiles_are_valid_and_a_bad_one_is_one_message_with_its_line() {
        for (name, _) in SCOPES {
            Scope::of(&Target::parse(&format!("scpi-scope:x?profile={name}")).unwrap()).unwrap();
        }
        let good = SCOPES[0].1;
        let at = |needle: &str| 1 + good[..good.find(needle).unwrap()].matches('\n').count();
        for (from, to, reason) in [
            ("depths = [12000, 120000", "depths = [120000, 12000", "that rise"),
            ("codes = [0, 255]", "codes = [9, 9]", "the lowest and the highest"),
            ("channels = 4", "channels = 0", "channels must be 1 to 9"),
            ("data = \":WAV:DATA?\"", "data = \":WAV:DATA\"", "must be a query"),
            (
                "time_base = \":TIM:MAIN:SCAL {value}\"",
                "time_base = \":TIM:MAIN:SCAL\"",
                "with {value}",
            ),
            ("origin = \"codes\"", "origin = \"volt\"", "unknown variant"),
        ] {
            let text = good.replacen(from, to, 1);
            assert_ne!(text, good, "{from}");
            let error = parse("x.toml", &text, |document: ScopeDocument| document.check()).unwrap_err();
            let error = error.to_string();
            assert!(
                error.starts_with(&format!("x.toml:{}: ", at(from))) && error.contains(reason),
                "{error}"
            );
        }
    }
}
