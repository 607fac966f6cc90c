//! What the host says.

use crate::verified;

/// One command.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Command {
    device: u8,
    axis: u8,
    id: Option<u8>,
    text: String,
}

/// Why a command cannot be sent.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum InvalidCommand {
    /// Not an address: 1 to 99, or 0 for all devices.
    #[error("device address {0} is above 99")]
    Device(u8),
    /// Not an axis: 1 to 9, or 0 for the device as a whole.
    #[error("axis number {0} is above 9")]
    Axis(u8),
    /// Text that would end the frame early, start another, or be too long.
    #[error("\"{0}\" is not printable ASCII of at most 60 characters without / @ : and line ends")]
    Text(String),
}

/// Why bytes are not a command.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error("not a command: {reason}")]
pub struct NotACommand {
    /// What is wrong.
    pub reason: String,
}

impl Command {
    /// A command to `axis` of `device` (0: all). `text` is empty for "say your status".
    ///
    /// # Errors
    /// [`InvalidCommand`] for an address out of range or text that would break the frame.
    pub fn new(device: u8, axis: u8, text: impl Into<String>) -> Result<Self, InvalidCommand> {
        let text = text.into();
        if device > 99 {
            return Err(InvalidCommand::Device(device));
        }
        if axis > 9 {
            return Err(InvalidCommand::Axis(axis));
        }
        let allowed = |c: char| (c.is_ascii_graphic() || c == ' ') && !matches!(c, '/' | '@' | ':' | '#' | '!');
        if text.len() > 60 || !text.chars().all(allowed) {
            return Err(InvalidCommand::Text(text));
        }
        Ok(Self {
            device,
            axis,
            id: None,
            text,
        })
    }

    /// The same command under message id `id` (0 to 99).
    #[must_use]
    pub fn with_id(mut self, id: u8) -> Self {
        self.id = Some(id % 100);
        self
    }

    /// Address of the device, 0 for all.
    pub const fn device(&self) -> u8 {
        self.device
    }

    /// Axis number, 0 for the device as a whole.
    pub const fn axis(&self) -> u8 {
        self.axis
    }

    /// Message id.
    pub const fn id(&self) -> Option<u8> {
        self.id
    }

    /// The words.
    pub fn text(&self) -> &str {
        &self.text
    }

    /// The frame: with checksum, ended by LF.
    pub fn encode(&self) -> Vec<u8> {
        let mut body = format!("{} {}", self.device, self.axis);
        if let Some(id) = self.id {
            body.push_str(&format!(" {id}"));
        }
        if !self.text.is_empty() {
            body.push(' ');
            body.push_str(&self.text);
        }
        format!("/{body}:{:02X}\n", crate::checksum(body.as_bytes())).into_bytes()
    }

    /// Reads one line (with or without its end) as a device does: leading numbers are device, axis and id, in this
    /// order, each of which may be left out; the check is verified when it is there.
    ///
    /// # Errors
    /// [`NotACommand`] without the `/`, with a wrong check or with numbers out of range.
    pub fn parse(line: &[u8]) -> Result<Self, NotACommand> {
        let wrong = |reason: String| NotACommand { reason };
        let text = std::str::from_utf8(line)
            .map_err(|_| wrong("not ASCII".into()))?
            .trim_end_matches(['\r', '\n']);
        let body = text
            .strip_prefix('/')
            .ok_or_else(|| wrong("does not begin with /".into()))?;
        let (body, _) = verified(body).map_err(|failed| wrong(failed.to_string()))?;
        let mut numbers = [None, None, None];
        let mut words = body.split(' ').filter(|word| !word.is_empty()).peekable();
        for (number, largest) in numbers.iter_mut().zip([99_u8, 9, 99]) {
            let Some(value) = words.peek().and_then(|word| word.parse::<u8>().ok()) else {
                break;
            };
            if value > largest {
                return Err(wrong(format!("{value} is above {largest}")));
            }
            *number = Some(value);
            words.next();
        }
        let text = words.collect::<Vec<_>>().join(" ");
        let command = Self::new(numbers[0].unwrap_or(0), numbers[1].unwrap_or(0), text);
        let command = command.map_err(|error| wrong(error.to_string()))?;
        Ok(Self {
            id: numbers[2],
            ..command
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn frames_mean_what_was_asked() {
        for (device, axis, id, text) in [
            (1, 1, 7, "get pos"),
            (1, 2, 99, "move abs -51200"),
            (2, 0, 0, "io set do 1 1"),
            (1, 1, 42, ""),
        ] {
            let ours = Command::new(device, axis, text).unwrap().with_id(id).encode();
            let parsed = Command::parse(&ours).unwrap();
            assert_eq!(
                (parsed.device(), parsed.axis(), parsed.id(), parsed.text()),
                (device, axis, Some(id), text)
            );
        }
        let get = Command::new(1, 1, "get pos").unwrap().with_id(7).encode();
        assert_eq!(get, b"/1 1 7 get pos:55\n");
    }

    #[test]
    fn reads_what_devices_read_and_refuses_the_rest() {
        let home = Command::parse(b"/home\r\n").unwrap();
        assert_eq!(
            (home.device(), home.axis(), home.id(), home.text()),
            (0, 0, None, "home")
        );
        assert!(Command::parse(b"/1 1 7 get pos:56\n").is_err());
        assert!(Command::parse(b"1 get pos\n").is_err());
        assert!(Command::new(100, 0, "").is_err());
        assert!(Command::new(1, 10, "").is_err());
        for text in ["a\nb", "a:00", "/1 home", &"x".repeat(61), "°"] {
            assert!(Command::new(1, 1, text).is_err(), "{text}");
        }
    }
}
