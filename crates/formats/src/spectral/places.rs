//! Line and column of a byte, at a cost that does not grow with the length of the line.

use crate::text::Text;

/// Bytes between two counts that are kept.
const BLOCK: usize = 1024;

/// How many characters begin before a byte of a text.
#[derive(Debug)]
pub(super) struct Characters<'t> {
    content: &'t [u8],
    /// Before every [`BLOCK`]-th byte: a document on one line has as many lookups as points.
    counted: Vec<usize>,
}

impl<'t> Characters<'t> {
    pub fn of(content: &'t str) -> Self {
        let content = content.as_bytes();
        let mut counted = Vec::with_capacity(content.len() / BLOCK + 1);
        let mut passed = 0;
        for block in content.chunks(BLOCK) {
            counted.push(passed);
            passed += begun(block);
        }
        Self { content, counted }
    }

    pub fn before(&self, byte: usize) -> usize {
        let byte = byte.min(self.content.len());
        let block = (byte / BLOCK).min(self.counted.len().saturating_sub(1));
        let counted = self.counted.get(block).copied().unwrap_or(0);
        counted + begun(&self.content[(block * BLOCK).min(byte)..byte])
    }
}

/// Places in a text by byte.
pub(super) struct Places<'t> {
    characters: Characters<'t>,
    /// First byte of every line.
    starts: Vec<usize>,
}

impl<'t> Places<'t> {
    pub fn of(text: &'t Text<'_>) -> Self {
        let base = text.content().as_ptr() as usize;
        Self {
            characters: Characters::of(text.content()),
            starts: text.lines().map(|line| line.as_ptr() as usize - base).collect(),
        }
    }

    /// One-based line of a byte.
    pub fn line(&self, byte: usize) -> usize {
        self.starts.partition_point(|start| *start <= byte).max(1)
    }

    /// One-based line and column of a byte, the column in characters.
    pub fn at(&self, byte: usize) -> (usize, usize) {
        let line = self.line(byte);
        let start = self.starts.get(line - 1).copied().unwrap_or(0);
        let before = |byte| self.characters.before(byte);
        (line, before(byte).saturating_sub(before(start)) + 1)
    }
}

/// Characters that begin in a part of UTF-8 text.
fn begun(bytes: &[u8]) -> usize {
    bytes.iter().map(|byte| usize::from(byte & 0xC0 != 0x80)).sum()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::finding::Findings;

    #[test]
    fn places_are_those_of_counting_from_the_start_of_the_line() {
        let long = "aé漢b".repeat(1500);
        let content = format!("x\n{long}\n\nÄ{long}");
        let text = Text::decode(content.as_bytes(), &mut Findings::new());
        let places = Places::of(&text);
        for (byte, _) in content.char_indices().step_by(7) {
            let start = content[..byte].rfind('\n').map_or(0, |end| end + 1);
            let expected = (
                content[..byte].matches('\n').count() + 1,
                content[start..byte].chars().count() + 1,
            );
            assert_eq!(places.at(byte), expected, "byte {byte}");
        }
        assert_eq!(places.at(content.len() + 5).0, 4);
    }
}
