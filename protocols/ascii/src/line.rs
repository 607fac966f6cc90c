//! One line of text out of bytes.

/// What bytes are, read as one line.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Line<'a> {
    /// No line end yet.
    More,
    /// The line without its end.
    Whole(&'a str),
    /// Not one line of printable ASCII, for this reason.
    Damaged(String),
}

/// Reads all of `received` as one line that ends in LF or CR LF.
pub fn line(received: &[u8]) -> Line<'_> {
    let end = received.iter().position(|byte| *byte == b'\n');
    let whole = &received[..end.unwrap_or(received.len())];
    let text = match whole.strip_suffix(b"\r") {
        Some(text) => text,
        None => whole,
    };
    if let Some(byte) = text.iter().find(|byte| !matches!(byte, b' '..=b'~' | b'\t')) {
        return Line::Damaged(format!("byte {byte:02X} is no character of this language"));
    }
    match end {
        None => Line::More,
        Some(end) if end + 1 < received.len() => Line::Damaged("bytes after the end of the answer".to_owned()),
        // All bytes are ASCII.
        Some(_) => std::str::from_utf8(text).map_or_else(|error| Line::Damaged(error.to_string()), Line::Whole),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_line_ends_in_lf_with_or_without_cr_and_nothing_follows() {
        assert_eq!(line(b"*1"), Line::More);
        assert_eq!(line(b"*1\r"), Line::More);
        assert_eq!(line(b"*1\r\n"), Line::Whole("*1"));
        assert_eq!(line(b"*1\n"), Line::Whole("*1"));
        assert_eq!(line(b"\n"), Line::Whole(""));
        for damaged in [&b"*1\n*2\n"[..], b"*\x07", b"*\xff\n", b"a\rb\n"] {
            assert!(matches!(line(damaged), Line::Damaged(_)), "{}", damaged.escape_ascii());
        }
    }
}
