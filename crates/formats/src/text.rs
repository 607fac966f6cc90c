//! Bytes of a text file, whatever its age: encoding, line ends, lines.

use std::borrow::Cow;

use crate::finding::{Finding, Findings};

/// A text file as lines. Line numbers are one-based and count CRLF, LF, CR and `\r\r\n` as one end each.
#[derive(Debug)]
pub struct Text<'a> {
    content: Cow<'a, str>,
    /// Byte range of every line, without its end.
    spans: Vec<(usize, usize)>,
    /// `ascii`, `utf-8`, `utf-8-bom`, `utf-16le`, `utf-16be`, `windows-1252` or `shift_jis`.
    pub encoding: &'static str,
    /// `crlf`, `lf`, `cr` or `mixed`; none where the file has no line end.
    pub line_ending: Option<&'static str>,
    /// Whether the last line has its end.
    pub ends_with_newline: bool,
}

impl<'a> Text<'a> {
    /// Decodes `bytes`: a byte-order mark decides, else UTF-8, else Shift-JIS where it fits better, else CP1252.
    pub fn decode(bytes: &'a [u8], findings: &mut Findings) -> Self {
        let (content, encoding) = decode(bytes, findings);
        let (spans, line_ending, doubled_return) = split_lines(&content);
        if let Some(line) = doubled_return {
            findings.push(
                Finding::note(
                    "text-cr-cr-lf",
                    "lines end in CR CR LF, as after a transfer in text mode; each is taken as one end",
                )
                .at(line, 1)
                .assumed("one line end"),
            );
        }
        let ends_with_newline = content.ends_with(['\n', '\r']);
        Self {
            content,
            spans,
            encoding,
            line_ending,
            ends_with_newline,
        }
    }

    /// Number of lines.
    pub fn len(&self) -> usize {
        self.spans.len()
    }

    /// Whether the file holds no line at all.
    pub fn is_empty(&self) -> bool {
        self.spans.is_empty()
    }

    /// The line with zero-based `index`, without its end; empty past the end of the file.
    pub fn line(&self, index: usize) -> &str {
        self.spans
            .get(index)
            .map_or("", |&(start, end)| &self.content[start..end])
    }

    /// All lines.
    pub fn lines(&self) -> impl DoubleEndedIterator<Item = &str> + ExactSizeIterator {
        self.spans.iter().map(|&(start, end)| &self.content[start..end])
    }

    /// The whole decoded text.
    pub fn content(&self) -> &str {
        &self.content
    }
}

/// One-based column of a slice of `line`, in characters.
pub(crate) fn column_of(line: &str, part: &str) -> usize {
    let offset = (part.as_ptr() as usize).saturating_sub(line.as_ptr() as usize);
    line.get(..offset).map_or(1, |before| before.chars().count() + 1)
}

fn decode<'a>(bytes: &'a [u8], findings: &mut Findings) -> (Cow<'a, str>, &'static str) {
    if let Some(rest) = bytes.strip_prefix(b"\xEF\xBB\xBF") {
        findings.push(Finding::note("text-bom", "the file begins with a UTF-8 byte-order mark").at(1, 1));
        return match std::str::from_utf8(rest) {
            Ok(text) => (Cow::Borrowed(text), "utf-8-bom"),
            Err(_) => (
                encoding_rs::WINDOWS_1252.decode_without_bom_handling(rest).0,
                "windows-1252",
            ),
        };
    }
    let utf16 = match bytes {
        [0xFF, 0xFE, ..] => Some((encoding_rs::UTF_16LE, &bytes[2..], "utf-16le")),
        [0xFE, 0xFF, ..] => Some((encoding_rs::UTF_16BE, &bytes[2..], "utf-16be")),
        _ => without_mark(bytes),
    };
    if let Some((encoding, rest, name)) = utf16 {
        let (text, damaged) = encoding.decode_without_bom_handling(rest);
        findings.push(
            Finding::note("text-utf16", "the file is written in UTF-16")
                .at(1, 1)
                .assumed(name),
        );
        if damaged {
            findings
                .push(Finding::warning("text-encoding", "some bytes are no UTF-16; they read as \u{FFFD}").at(1, 1));
        }
        return (text, name);
    }
    if let Ok(text) = std::str::from_utf8(bytes) {
        let encoding = if text.is_ascii() { "ascii" } else { "utf-8" };
        return (Cow::Borrowed(text), encoding);
    }
    if let Some(text) = shift_jis(bytes) {
        findings.push(
            Finding::note("text-shift-jis", "the text is Shift-JIS")
                .at(1, 1)
                .assumed("shift_jis"),
        );
        return (text, "shift_jis");
    }
    (
        encoding_rs::WINDOWS_1252.decode_without_bom_handling(bytes).0,
        "windows-1252",
    )
}

/// UTF-16 that lost its mark: in ASCII text every second byte is zero.
fn without_mark(bytes: &[u8]) -> Option<(&'static encoding_rs::Encoding, &[u8], &'static str)> {
    let head = &bytes[..bytes.len().min(256)];
    if head.len() < 8 {
        return None;
    }
    let zeros = |from: usize| head.iter().skip(from).step_by(2).filter(|&&byte| byte == 0).count() * 2;
    if zeros(1) * 10 > head.len() * 9 {
        Some((encoding_rs::UTF_16LE, bytes, "utf-16le"))
    } else if zeros(0) * 10 > head.len() * 9 {
        Some((encoding_rs::UTF_16BE, bytes, "utf-16be"))
    } else {
        None
    }
}

/// The text as Shift-JIS if it decodes without damage and reads as Japanese: at least two kana or ideographs side by
/// side. CP1252 text almost never decodes so.
fn shift_jis(bytes: &[u8]) -> Option<Cow<'_, str>> {
    let text = encoding_rs::SHIFT_JIS.decode_without_bom_handling_and_without_replacement(bytes)?;
    let mut run = 0;
    for character in text.chars() {
        let japanese = matches!(character, '\u{3040}'..='\u{30FF}' | '\u{4E00}'..='\u{9FFF}');
        run = if japanese { run + 1 } else { 0 };
        if run == 2 {
            return Some(text);
        }
    }
    None
}

type Spans = Vec<(usize, usize)>;

/// Line spans, the kind of line end, and the one-based line of the first `\r\r\n`.
fn split_lines(content: &str) -> (Spans, Option<&'static str>, Option<usize>) {
    let bytes = content.as_bytes();
    let mut spans = Vec::with_capacity(bytes.len() / 8 + 1);
    let (mut crlf, mut lf, mut cr) = (false, false, false);
    let mut doubled = None;
    let (mut start, mut at) = (0, 0);
    let end = |byte: &u8| matches!(byte, b'\n' | b'\r');
    while let Some(ahead) = bytes[at..].iter().position(end) {
        at += ahead;
        let width = match bytes[at] {
            b'\n' => {
                lf = true;
                1
            }
            b'\r' if bytes[at..].starts_with(b"\r\r\n") => {
                crlf = true;
                doubled.get_or_insert(spans.len() + 1);
                3
            }
            b'\r' if bytes.get(at + 1) == Some(&b'\n') => {
                crlf = true;
                2
            }
            _ => {
                cr = true;
                1
            }
        };
        spans.push((start, at));
        at += width;
        start = at;
    }
    if start < bytes.len() {
        spans.push((start, bytes.len()));
    }
    let ending = match (crlf, lf, cr) {
        (false, false, false) => None,
        (true, false, false) => Some("crlf"),
        (false, true, false) => Some("lf"),
        (false, false, true) => Some("cr"),
        _ => Some("mixed"),
    };
    (spans, ending, doubled)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn read(bytes: &[u8]) -> (Vec<String>, &'static str, Option<&'static str>) {
        let mut findings = Findings::new();
        let text = Text::decode(bytes, &mut findings);
        (
            text.lines().map(str::to_owned).collect(),
            text.encoding,
            text.line_ending,
        )
    }

    #[test]
    fn every_line_end_counts_once() {
        assert_eq!(read(b"a\r\nb\r\n").0, ["a", "b"]);
        assert_eq!(read(b"a\rb\r").0, ["a", "b"]);
        assert_eq!(read(b"a\r\r\nb\r\r\nc").0, ["a", "b", "c"]);
        assert_eq!(read(b"a\n\nb").0, ["a", "", "b"]);
        assert_eq!(read(b"a\nb\r\n").2, Some("mixed"));
        assert!(read(b"").0.is_empty());
    }

    #[test]
    fn encodings_of_the_wild() {
        assert_eq!(read(b"\xEF\xBB\xBFa").1, "utf-8-bom");
        assert_eq!(
            read(b"\xFF\xFEa\0\n\0b\0"),
            (vec!["a".into(), "b".into()], "utf-16le", Some("lf"))
        );
        assert_eq!(read(b"L\xE4nge\n"), (vec!["Länge".into()], "windows-1252", Some("lf")));
        assert_eq!(read("Länge".as_bytes()).1, "utf-8");
        let japanese = encoding_rs::SHIFT_JIS.encode("照明器具").0;
        assert_eq!(read(&japanese), (vec!["照明器具".into()], "shift_jis", None));
        let plain: Vec<u8> = "1234567890".encode_utf16().flat_map(u16::to_le_bytes).collect();
        assert_eq!(read(&plain), (vec!["1234567890".into()], "utf-16le", None));
    }
}
