//! Bytes → lines.

use crate::Message;

/// Longest line that can be one: a reply holds at most 80 characters, several axes in one a few hundred.
pub const MAX_LINE: usize = 512;

/// A line that is no message.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Damaged {
    /// What is wrong with it.
    pub reason: String,
    /// The bytes.
    pub line: Vec<u8>,
}

/// Collects bytes into messages, whatever the pieces they arrive in.
#[derive(Debug, Default)]
pub struct Framer {
    line: Vec<u8>,
    overlong: bool,
}

impl Framer {
    /// Takes the next byte; answers when it ends a line.
    pub fn push(&mut self, byte: u8) -> Option<Result<Message, Damaged>> {
        match byte {
            b'\r' | b'\n' => self.end(),
            // A frame begins here whatever was left of the one before: its end was lost.
            b'@' | b'!' | b'#' if !self.line.is_empty() => {
                let damaged = self.damaged("cut short by the next frame");
                self.line.push(byte);
                Some(Err(damaged))
            }
            _ => {
                if self.line.len() < MAX_LINE {
                    self.line.push(byte);
                } else {
                    self.overlong = true;
                }
                None
            }
        }
    }

    /// What is collected of an unfinished line: evidence for a timeout.
    pub fn pending(&self) -> &[u8] {
        &self.line
    }

    /// Forgets an unfinished line.
    pub fn clear(&mut self) {
        self.line.clear();
        self.overlong = false;
    }

    fn end(&mut self) -> Option<Result<Message, Damaged>> {
        if self.line.is_empty() {
            return None;
        }
        if self.overlong {
            return Some(Err(self.damaged("longer than any message")));
        }
        let result = match Message::parse(&self.line) {
            Ok(message) => Ok(message),
            Err(error) => return Some(Err(self.damaged(&error.reason))),
        };
        self.clear();
        Some(result)
    }

    fn damaged(&mut self, reason: &str) -> Damaged {
        self.overlong = false;
        Damaged {
            reason: reason.to_owned(),
            line: std::mem::take(&mut self.line),
        }
    }
}
