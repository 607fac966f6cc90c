//! Questions that change nothing, by which a port that a person names can be asked who is there.

use crate::LineSettings;

/// One question and what answers it. No codec takes part and nothing is set: what is there goes on as it was.
#[derive(Debug, Clone, Copy)]
pub struct Probe {
    /// The line as an instrument of this language has it when it leaves the maker.
    pub line: LineSettings,
    /// The request.
    pub request: &'static [u8],
    /// What the instrument said of itself, by all bytes that came back; none while they are no answer of this language.
    pub read: fn(&[u8]) -> Option<String>,
}

/// The text among `bytes`, with every byte that is no printable ASCII left out.
pub fn printable(bytes: &[u8]) -> String {
    let text = bytes.iter().filter(|byte| (0x20..0x7F).contains(*byte));
    text.map(|byte| char::from(*byte)).collect()
}
