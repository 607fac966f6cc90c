//! XML as a small tree with line numbers; enough for photometric documents, bounded in depth.
//!
//! On quick-xml and not roxmltree, which refuses what files have: prefixes that nobody declared, entities of HTML, a
//! DTD, bytes behind the end.

use quick_xml::Reader;
use quick_xml::events::{BytesStart, Event};

/// Deeper nesting than this is no photometric document.
const DEEPEST: usize = 64;

/// One element.
#[derive(Debug, Clone, Default)]
pub(crate) struct Element {
    /// Local name, without prefix.
    pub name: String,
    pub attributes: Vec<(String, String)>,
    /// Text directly inside, trimmed.
    pub text: String,
    pub children: Vec<Element>,
    /// One-based line and column, in characters, of its start tag.
    pub line: usize,
    pub column: usize,
}

impl Element {
    pub(crate) fn child(&self, name: &str) -> Option<&Self> {
        self.children.iter().find(|child| child.name == name)
    }

    /// Text of the first child with one of the names; empty is none.
    pub(crate) fn words(&self, names: &[&str]) -> Option<&str> {
        let found = self
            .children
            .iter()
            .find(|child| names.contains(&child.name.as_str()))?;
        (!found.text.is_empty()).then_some(found.text.as_str())
    }

    pub(crate) fn attribute(&self, names: &[&str]) -> Option<&str> {
        self.attributes
            .iter()
            .find(|(name, _)| names.contains(&name.as_str()))
            .map(|(_, value)| value.as_str())
    }
}

/// Why a text is no XML document: one-based line and reason.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error("line {line}: {reason}")]
pub(crate) struct Malformed {
    pub line: usize,
    pub reason: String,
}

/// The root element of a document.
pub(crate) fn parse(text: &str) -> Result<Element, Malformed> {
    let mut reader = Reader::from_str(text);
    let mut lines = Lines {
        text: text.as_bytes(),
        passed: 0,
        line: 1,
        column: 1,
    };
    let mut open: Vec<Element> = Vec::new();
    let mut root = None;
    loop {
        let at = lines.at(reader.buffer_position() as usize);
        let malformed = |line: usize, reason: String| Malformed { line, reason };
        let event = match reader.read_event() {
            Ok(event) => event,
            Err(error) => {
                let (line, _) = lines.at(reader.error_position() as usize);
                return Err(malformed(line, error.to_string()));
            }
        };
        match event {
            Event::Start(start) => {
                if open.len() >= DEEPEST || root.is_some() {
                    return Err(malformed(at.0, "too deep or more than one root element".into()));
                }
                let at = lines.at((reader.buffer_position() as usize).saturating_sub(start.len() + 2));
                open.push(element(&start, at).map_err(|reason| malformed(at.0, reason))?);
            }
            Event::Empty(start) => {
                let made = element(&start, at).map_err(|reason| malformed(at.0, reason))?;
                match open.last_mut() {
                    Some(parent) => parent.children.push(made),
                    None => root = Some(made),
                }
            }
            Event::End(_) => {
                let Some(mut done) = open.pop() else {
                    return Err(malformed(at.0, "an end tag too many".into()));
                };
                done.text = done.text.trim().into();
                match open.last_mut() {
                    Some(parent) => parent.children.push(done),
                    None => root = Some(done),
                }
            }
            Event::Text(words) => {
                if let Some(parent) = open.last_mut() {
                    parent.text.push_str(words.as_ref());
                } else if !words
                    .trim_matches(|c: char| c.is_whitespace() || matches!(c, '\0' | '\u{1a}'))
                    .is_empty()
                {
                    return Err(malformed(at.0, "text stands outside the root element".into()));
                }
            }
            Event::CData(words) => {
                if let Some(parent) = open.last_mut() {
                    parent.text.push_str(words.as_ref());
                }
            }
            Event::GeneralRef(reference) => {
                if let Some(parent) = open.last_mut() {
                    let name = reference.as_ref().to_owned();
                    let text = match name.as_str() {
                        "amp" => "&".to_owned(),
                        "lt" => "<".to_owned(),
                        "gt" => ">".to_owned(),
                        "quot" => "\"".to_owned(),
                        "apos" => "'".to_owned(),
                        _ => reference
                            .resolve_char_ref()
                            .ok()
                            .flatten()
                            .map_or(format!("&{name};"), String::from),
                    };
                    parent.text.push_str(&text);
                }
            }
            Event::Eof => break,
            _ => {}
        }
    }
    if let Some(unclosed) = open.last() {
        let line = text.trim_end().matches('\n').count() + 1;
        return Err(Malformed {
            line,
            reason: format!("the document ends inside <{}>", unclosed.name),
        });
    }
    root.ok_or(Malformed {
        line: 1,
        reason: "no element".into(),
    })
}

fn element(start: &BytesStart<'_>, (line, column): (usize, usize)) -> Result<Element, String> {
    let name = start.local_name().as_ref().to_owned();
    let mut attributes = Vec::new();
    for attribute in start.attributes() {
        let attribute = attribute.map_err(|error| error.to_string())?;
        let key = attribute.key.local_name().as_ref().to_owned();
        attributes.push((key, attribute.value.into_owned()));
    }
    Ok(Element {
        name,
        attributes,
        text: String::new(),
        children: Vec::new(),
        line,
        column,
    })
}

/// Counts lines forwards only, so that the whole document is walked once.
struct Lines<'t> {
    text: &'t [u8],
    passed: usize,
    line: usize,
    column: usize,
}

impl Lines<'_> {
    /// One-based line and column, in characters, of a byte.
    fn at(&mut self, position: usize) -> (usize, usize) {
        let position = position.min(self.text.len());
        for &byte in self.text.get(self.passed..position).unwrap_or_default() {
            if byte == b'\n' {
                (self.line, self.column) = (self.line + 1, 1);
            } else {
                // Bytes of UTF-8 that continue a character begin with 10.
                self.column += usize::from(byte & 0xC0 != 0x80);
            }
        }
        self.passed = self.passed.max(position);
        (self.line, self.column)
    }
}

/// Text made safe for an element or attribute.
pub(crate) fn escaped(text: &str) -> String {
    let mut safe = String::with_capacity(text.len());
    for character in text.chars() {
        match character {
            '&' => safe.push_str("&amp;"),
            '<' => safe.push_str("&lt;"),
            '>' => safe.push_str("&gt;"),
            '"' => safe.push_str("&quot;"),
            c if c.is_control() => safe.push(' '),
            c => safe.push(c),
        }
    }
    safe
}
