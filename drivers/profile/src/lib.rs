//! Profiles: what an instrument is like, as a TOML file says it. One message for a bad one, with file and line.

mod plain;

use std::ops::Range;
use std::path::Path;
use std::time::Duration;

use camino::Utf8Path;
use isolux_device::{OpenError, Target};
use isolux_document::{DocumentError, SourceText};
use isolux_transport::{LineSettings, Parity};
use serde::Deserialize;
use serde::de::DeserializeOwned;
pub use toml::Spanned;

pub use plain::{Address, Ask, Exchange, Manners, Messages, counts, decimal, identity};

/// The profiles that come with the program: name and text.
pub type Shipped = &'static [(&'static str, &'static str)];

/// Offset in the text and what is wrong there.
pub type Wrong = (usize, String);

/// What is wrong with the value at `span`.
pub fn wrong(span: Range<usize>, reason: impl Into<String>) -> Wrong {
    (span.start, reason.into())
}

/// The profile that `target` names: one among `shipped`, or a file (its name ends in `.toml`) in the folder of the
/// station.
///
/// # Errors
/// [`OpenError::Address`] without the option `profile`, and for a profile that is refused.
pub fn of<D: DeserializeOwned, P>(
    target: &Target,
    shipped: Shipped,
    check: impl FnOnce(D) -> Result<P, Wrong>,
) -> Result<P, OpenError> {
    let Some(name) = target.option("profile") else {
        let known = names(shipped);
        return Err(target.wrong(format!("this driver needs profile=NAME ({known}) or profile=FILE.toml")));
    };
    load(name, &target.path(name), shipped, check).map_err(|error| target.wrong(error.to_string()))
}

fn names(shipped: Shipped) -> String {
    shipped.iter().map(|(name, _)| *name).collect::<Vec<_>>().join(", ")
}

/// The profile of this name among `shipped`, or in the file of this name (one that ends in `.toml`), which is at
/// `path`.
///
/// # Errors
/// [`DocumentError`].
pub fn load<D: DeserializeOwned, P>(
    name: &str,
    path: &Path,
    shipped: Shipped,
    check: impl FnOnce(D) -> Result<P, Wrong>,
) -> Result<P, DocumentError> {
    if let Some((name, text)) = shipped.iter().find(|(known, _)| *known == name) {
        return parse(name, text, check);
    }
    let file = path.display().to_string();
    let unreadable = |reason: String| DocumentError {
        file: file.clone().into(),
        line: None,
        column: None,
        message: format!("{reason}; profiles that come with the program: {}", names(shipped)),
    };
    if Path::new(name).extension().is_none_or(|extension| extension != "toml") {
        return Err(unreadable(
            "no such profile, and a file's name ends in .toml".to_owned(),
        ));
    }
    let text = std::fs::read_to_string(path).map_err(|error| unreadable(error.to_string()))?;
    parse(&file, &text, check)
}

/// Reads the text of a profile; `file` is its name for messages.
///
/// # Errors
/// [`DocumentError`] with the line.
pub fn parse<D: DeserializeOwned, P>(
    file: &str,
    text: &str,
    check: impl FnOnce(D) -> Result<P, Wrong>,
) -> Result<P, DocumentError> {
    let file = Utf8Path::new(file);
    let source = SourceText { file, text };
    let document: Result<D, Wrong> = toml::from_str(text).map_err(|error| {
        let at = error.span().map_or(0, |span| span.start);
        (at, error.message().replace('\n', ", "))
    });
    document.and_then(check).map_err(|(at, reason)| DocumentError {
        // The message names the key.
        column: None,
        ..source.at(at, reason)
    })
}

/// `[line]`: how a serial line is set.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Line {
    baud: Spanned<u32>,
    /// Not checked yet.
    pub data_bits: Spanned<u8>,
    parity: LineParity,
    stop_bits: Spanned<u8>,
}

#[derive(Debug, Clone, Copy, Deserialize)]
#[serde(rename_all = "lowercase")]
enum LineParity {
    None,
    Even,
    Odd,
}

impl Line {
    /// The settings.
    ///
    /// # Errors
    /// [`Wrong`] for settings that no port has.
    pub fn check(&self) -> Result<LineSettings, Wrong> {
        if !(300..=4_000_000).contains(self.baud.get_ref()) {
            return Err(wrong(self.baud.span(), "baud must be 300 to 4000000"));
        }
        if !(7..=8).contains(self.data_bits.get_ref()) {
            return Err(wrong(self.data_bits.span(), "data_bits must be 7 or 8"));
        }
        if !(1..=2).contains(self.stop_bits.get_ref()) {
            return Err(wrong(self.stop_bits.span(), "stop_bits must be 1 or 2"));
        }
        Ok(LineSettings {
            baud: *self.baud.get_ref(),
            data_bits: *self.data_bits.get_ref(),
            parity: match self.parity {
                LineParity::None => Parity::None,
                LineParity::Even => Parity::Even,
                LineParity::Odd => Parity::Odd,
            },
            stop_bits: *self.stop_bits.get_ref(),
        })
    }
}

/// A duration in seconds, from a millisecond to a minute.
///
/// # Errors
/// [`Wrong`] names the key.
pub fn seconds(key: &str, value: &Spanned<f64>) -> Result<Duration, Wrong> {
    if (0.001..=60.0).contains(value.get_ref()) {
        Ok(Duration::from_secs_f64(*value.get_ref()))
    } else {
        Err(wrong(value.span(), format!("{key} must be 0.001 to 60")))
    }
}

/// Whether the first key of a profile is the one that it must be.
///
/// # Errors
/// [`Wrong`] says what it must be.
pub fn format(found: &Spanned<String>, expected: &str) -> Result<(), Wrong> {
    if found.get_ref() == expected {
        Ok(())
    } else {
        Err(wrong(found.span(), format!("format must be \"{expected}\"")))
    }
}

/// A text that goes over a wire: printable ASCII, not empty.
///
/// # Errors
/// [`Wrong`] names the key.
pub fn ascii(key: &str, value: &Spanned<String>) -> Result<String, Wrong> {
    let text = value.get_ref();
    if !text.is_empty() && text.bytes().all(|byte| matches!(byte, b' '..=b'~')) {
        Ok(text.clone())
    } else {
        Err(wrong(
            value.span(),
            format!("{key} must be printable ASCII, and not empty"),
        ))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[derive(Deserialize)]
    #[serde(deny_unknown_fields)]
    struct Small {
        line: Line,
        wait_s: Spanned<f64>,
    }

    fn small(text: &str) -> Result<(LineSettings, Duration), DocumentError> {
        parse("x.toml", text, |small: Small| {
            Ok((small.line.check()?, seconds("wait_s", &small.wait_s)?))
        })
    }

    #[test]
    fn a_bad_profile_is_one_message_with_file_and_line() {
        let good = "wait_s = 0.5\n[line]\nbaud = 9600\ndata_bits = 7\nparity = \"even\"\nstop_bits = 2\n";
        let (line, wait) = small(good).unwrap();
        assert_eq!(
            (line.to_string().as_str(), wait),
            ("9600 7E2", Duration::from_millis(500))
        );
        for (from, to, message) in [
            ("wait_s = 0.5", "wait_s = 0.0", "x.toml:1: wait_s must be 0.001 to 60"),
            ("data_bits = 7", "data_bits = 9", "x.toml:4: data_bits must be 7 or 8"),
            (
                "parity = \"even\"",
                "parity = \"mark\"",
                "x.toml:5: unknown variant `mark`",
            ),
            (
                "stop_bits = 2",
                "stop_bits = 2\nbits = 1",
                "x.toml:7: unknown field `bits`",
            ),
            ("stop_bits = 2", "stop_bits = 2\nbaud = 1", "x.toml:7: duplicate key"),
        ] {
            let error = small(&good.replace(from, to)).unwrap_err().to_string();
            assert!(error.starts_with(message), "{error}");
        }
        let missing = load("none", Path::new("none"), &[("one", "")], |small: Small| {
            Ok(small.line.check().is_ok())
        });
        assert!(
            missing
                .unwrap_err()
                .to_string()
                .ends_with("profiles that come with the program: one")
        );
    }
}
