//! The column of a byte, at a cost that does not grow with the length of the line.

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

/// Characters that begin in a part of UTF-8 text.
fn begun(bytes: &[u8]) -> usize {
    bytes.iter().map(|byte| usize::from(byte & 0xC0 != 0x80)).sum()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn characters_are_those_of_counting_from_the_start() {
        let long = "aé漢b".repeat(1500);
        let characters = Characters::of(&long);
        for (byte, _) in long.char_indices().step_by(7) {
            assert_eq!(characters.before(byte), long[..byte].chars().count(), "byte {byte}");
        }
    }
}
