//! What a line of a known form says: `"{value} lx"`, `"POS {steps}"`.

use std::collections::BTreeMap;

/// A form of lines: text that is there literally, and named fields in braces between it.
///
/// A field takes what lies between its neighbours and is never empty. Blanks at the two ends of a line do not count.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Pattern {
    parts: Vec<Part>,
}

#[derive(Debug, Clone, PartialEq, Eq)]
enum Part {
    Literal(String),
    Field(String),
}

/// The fields of one line by name.
pub type Fields = BTreeMap<String, String>;

/// Why a text is no pattern.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum NotAPattern {
    /// A brace without its other half.
    #[error("a brace without its other half")]
    Brace,
    /// Not a name in lower case.
    #[error("{{{0}}}: a field is named in lower case, as in {{value}}")]
    Name(String),
    /// A name that comes twice.
    #[error("{{{0}}} is there twice: which one counts?")]
    Twice(String),
    /// Two fields with nothing between them.
    #[error("{{{0}}} directly after another field: nothing says where one ends and the other begins")]
    Adjacent(String),
    /// Text that no line of this language can hold.
    #[error("only printable ASCII characters can be in a reply")]
    Character,
}

impl Pattern {
    /// Reads a pattern.
    ///
    /// # Errors
    /// [`NotAPattern`] for one that could have two meanings.
    pub fn parse(text: &str) -> Result<Self, NotAPattern> {
        if text.bytes().any(|byte| !matches!(byte, b' '..=b'~')) {
            return Err(NotAPattern::Character);
        }
        let mut parts = Vec::new();
        let mut names = Vec::new();
        let mut rest = text.trim();
        while !rest.is_empty() {
            let literal = rest.find('{').unwrap_or(rest.len());
            if rest[..literal].contains('}') {
                return Err(NotAPattern::Brace);
            }
            if literal > 0 {
                parts.push(Part::Literal(rest[..literal].to_owned()));
                rest = &rest[literal..];
                continue;
            }
            let end = rest.find('}').ok_or(NotAPattern::Brace)?;
            let name = rest[1..end].to_owned();
            if name.is_empty() || !name.bytes().all(|byte| byte.is_ascii_lowercase() || byte == b'_') {
                return Err(NotAPattern::Name(name));
            }
            if names.contains(&name) {
                return Err(NotAPattern::Twice(name));
            }
            if matches!(parts.last(), Some(Part::Field(_))) {
                return Err(NotAPattern::Adjacent(name));
            }
            names.push(name.clone());
            parts.push(Part::Field(name));
            rest = &rest[end + 1..];
        }
        Ok(Self { parts })
    }

    /// The names of its fields, in order.
    pub fn names(&self) -> impl Iterator<Item = &str> {
        self.parts.iter().filter_map(|part| match part {
            Part::Field(name) => Some(name.as_str()),
            Part::Literal(_) => None,
        })
    }

    /// The same with `text` in the place of a field.
    #[must_use]
    pub fn with(&self, field: &str, text: &str) -> Self {
        let put = |part: &Part| match part {
            Part::Field(name) if name == field => Part::Literal(text.to_owned()),
            other => other.clone(),
        };
        let parts = self.parts.iter().map(put).collect();
        Self { parts }
    }

    /// The fields of `line`, if it has this form in one way only.
    pub fn read(&self, line: &str) -> Option<Fields> {
        let mut fields = Fields::new();
        let mut rest = line.trim();
        let mut parts = self.parts.iter().peekable();
        while let Some(part) = parts.next() {
            match part {
                Part::Literal(text) => rest = rest.strip_prefix(text.as_str())?,
                Part::Field(name) => {
                    let end = match parts.peek() {
                        // The last field takes the rest.
                        None => rest.len(),
                        // Before the last text: up to where it stands at the end of the line.
                        Some(Part::Literal(text)) => {
                            let last = self.parts.last() == Some(&Part::Literal(text.clone()));
                            let end = rest.find(text.as_str())?;
                            let unique = rest[end + 1..].find(text.as_str()).is_none();
                            if last && !unique {
                                return None;
                            }
                            end
                        }
                        Some(Part::Field(_)) => return None,
                    };
                    if end == 0 {
                        return None;
                    }
                    fields.insert(name.clone(), rest[..end].to_owned());
                    rest = &rest[end..];
                }
            }
        }
        rest.is_empty().then_some(fields)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn read(pattern: &str, line: &str) -> Option<Vec<String>> {
        let pattern = Pattern::parse(pattern).unwrap();
        let fields = pattern.read(line)?;
        Some(pattern.names().map(|name| fields[name].clone()).collect())
    }

    #[test]
    fn reads_what_has_the_form_and_nothing_else() {
        assert_eq!(read("{value} lx", "12.5 lx"), Some(vec!["12.5".to_owned()]));
        assert_eq!(read("{value} lx", " 12.5 lx "), Some(vec!["12.5".to_owned()]));
        assert_eq!(
            read("EV={value},R={range}", "EV=1.5,R=3"),
            Some(vec!["1.5".to_owned(), "3".to_owned()])
        );
        assert_eq!(read("OK", "OK"), Some(vec![]));
        let one = Pattern::parse("1 STATE {state}").unwrap().with("state", "READY");
        assert!(one.read("1 STATE READY").is_some() && one.read("1 STATE RAEDY").is_none());
        for (pattern, line) in [
            ("{value} lx", "12.5 fc"),
            ("{value} lx", " lx"),
            ("{value} lx", "1 lx lx"),
            ("{value} lx", "12.5 lxx"),
            ("POS {steps}", "POSITION 3"),
            ("OK", "OK OK"),
            ("OK", ""),
        ] {
            assert_eq!(read(pattern, line), None, "{pattern} {line}");
        }
    }

    #[test]
    fn refuses_what_has_two_meanings() {
        for (pattern, reason) in [
            ("{value}{range}", "directly after"),
            ("{value} {value}", "twice"),
            ("{Value}", "lower case"),
            ("{}", "lower case"),
            ("{value", "other half"),
            ("value}", "other half"),
            ("{value} lüx", "ASCII"),
        ] {
            let error = Pattern::parse(pattern).unwrap_err().to_string();
            assert!(error.contains(reason), "{pattern}: {error}");
        }
    }

    proptest! {
        #[test]
        fn noise_never_panics(pattern in "[a-z{} =]{0,12}", line in "\\PC{0,20}") {
            if let Ok(pattern) = Pattern::parse(&pattern) {
                let _ = pattern.read(&line);
            }
        }
    }
}
