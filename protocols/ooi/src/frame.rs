//! USB transfers on a byte link.

/// A USB endpoint.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Endpoint {
    /// 0x01, host to device.
    Command,
    /// 0x81, short answers.
    Control,
    /// 0x82, spectra.
    Spectrum,
}

impl Endpoint {
    const fn address(self) -> u8 {
        match self {
            Self::Command => 0x01,
            Self::Control => 0x81,
            Self::Spectrum => 0x82,
        }
    }

    const fn from_address(address: u8) -> Option<Self> {
        match address {
            0x01 => Some(Self::Command),
            0x81 => Some(Self::Control),
            0x82 => Some(Self::Spectrum),
            _ => None,
        }
    }
}

/// One USB transfer.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Frame {
    /// Its endpoint.
    pub endpoint: Endpoint,
    /// Its bytes, at most 65535.
    pub payload: Vec<u8>,
}

impl Frame {
    /// `endpoint u8, length u16 little-endian, payload`. Payloads of this language are 4097 bytes at most.
    pub fn encode(&self) -> Vec<u8> {
        let length = u16::try_from(self.payload.len()).unwrap_or(u16::MAX);
        let mut bytes = vec![self.endpoint.address()];
        bytes.extend_from_slice(&length.to_le_bytes());
        bytes.extend_from_slice(&self.payload[..usize::from(length)]);
        bytes
    }
}

/// Bytes that cannot begin or continue a frame.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum NotAFrame {
    /// The first byte is no endpoint.
    #[error("0x{0:02X} is no endpoint")]
    Endpoint(u8),
    /// Longer than any transfer of this language.
    #[error("a transfer of {0} bytes: the longest of this language has 4097")]
    Length(u16),
}

/// Collects bytes into frames, whatever the pieces they arrive in.
#[derive(Debug, Default)]
pub struct Framer {
    bytes: Vec<u8>,
}

impl Framer {
    /// Longest payload: a spectrum and its end mark.
    const LONGEST: u16 = 4097;

    /// Adds bytes.
    pub fn push(&mut self, bytes: &[u8]) {
        self.bytes.extend_from_slice(bytes);
    }

    /// The next whole frame; call again until `None`.
    ///
    /// # Errors
    /// [`NotAFrame`]: where the next frame begins is unknown then, [`clear`](Self::clear) and start afresh.
    pub fn next_frame(&mut self) -> Result<Option<Frame>, NotAFrame> {
        let Some(first) = self.bytes.first() else {
            return Ok(None);
        };
        let endpoint = Endpoint::from_address(*first).ok_or(NotAFrame::Endpoint(*first))?;
        let &[_, low, high, ..] = &self.bytes[..] else {
            return Ok(None);
        };
        let length = u16::from_le_bytes([low, high]);
        if length > Self::LONGEST {
            return Err(NotAFrame::Length(length));
        }
        let end = 3 + usize::from(length);
        if self.bytes.len() < end {
            return Ok(None);
        }
        let payload = self.bytes[3..end].to_vec();
        self.bytes.drain(..end);
        Ok(Some(Frame { endpoint, payload }))
    }

    /// What is collected of an unfinished frame.
    pub fn pending(&self) -> &[u8] {
        &self.bytes
    }

    /// Forgets it.
    pub fn clear(&mut self) {
        self.bytes.clear();
    }
}
