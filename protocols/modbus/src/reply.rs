//! What a unit answers.

use std::fmt;

use crate::{Ask, Request};

/// A whole answer to the request in flight.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Reply {
    /// What was asked for, or why not.
    pub outcome: Result<Data, Exception>,
    /// The frame, as it came.
    pub frame: Vec<u8>,
}

/// What was asked for.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Data {
    /// Coils or inputs, as many as were asked for.
    Bits(Vec<bool>),
    /// Registers, as many as were asked for.
    Registers(Vec<u16>),
    /// The write was acknowledged. Whether the device obeys is another question: read it back.
    Written,
}

/// An exception code (AP 7).
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Exception(pub u8);

impl Exception {
    /// Name of the code in AP 7, or what it is otherwise.
    pub const fn name(self) -> &'static str {
        match self.0 {
            0x01 => "illegal function",
            0x02 => "illegal data address",
            0x03 => "illegal data value",
            0x04 => "server device failure",
            0x05 => "acknowledge",
            0x06 => "server device busy",
            0x08 => "memory parity error",
            0x0A => "gateway path unavailable",
            0x0B => "gateway target device failed to respond",
            _ => "code of the device's own",
        }
    }
}

impl fmt::Display for Exception {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "exception {:02X}h ({})", self.0, self.name())
    }
}

/// How far a reply's PDU has come.
#[derive(Debug, PartialEq, Eq)]
pub(crate) enum Progress {
    /// So many bytes of it make it whole; those that are there fit the request.
    Whole(usize),
    /// More bytes are needed.
    Part,
    /// It is none to this request.
    Wrong(String),
}

/// How far `pdu`, which may be cut anywhere or go on past its end, is an answer to `request`.
pub(crate) fn progress(request: &Request, pdu: &[u8]) -> Progress {
    let function = request.ask().function();
    let Some(first) = pdu.first() else {
        return Progress::Part;
    };
    if *first == function | 0x80 {
        return if pdu.len() < 2 {
            Progress::Part
        } else {
            Progress::Whole(2)
        };
    }
    if *first != function {
        return Progress::Wrong(format!("function {first:02X}h answers, {function:02X}h was asked"));
    }
    // Everything but the data itself is known beforehand.
    let requested = request.pdu();
    let (known, length) = match bytes_to_read(request.ask()) {
        Some(bytes) => (vec![function, bytes], 2 + usize::from(bytes)),
        None => (requested[..5].to_vec(), 5),
    };
    let there = pdu.len().min(known.len());
    if pdu[..there] != known[..there] {
        let wrong = pdu[..there].escape_ascii();
        return Progress::Wrong(format!(
            "\"{wrong}\" where the answer to this request begins with \"{}\"",
            known.escape_ascii()
        ));
    }
    if pdu.len() < length {
        Progress::Part
    } else {
        Progress::Whole(length)
    }
}

/// What a whole PDU, of the length that [`progress`] gave, says.
pub(crate) fn outcome(request: &Request, pdu: &[u8]) -> Result<Data, Exception> {
    if let [function, code] = pdu
        && function & 0x80 != 0
    {
        return Err(Exception(*code));
    }
    Ok(match request.ask() {
        Ask::ReadCoils { count, .. } | Ask::ReadDiscreteInputs { count, .. } => {
            let bit = |n: usize| pdu[2 + n / 8] >> (n % 8) & 1 == 1;
            Data::Bits((0..usize::from(*count)).map(bit).collect())
        }
        Ask::ReadHoldingRegisters { .. } | Ask::ReadInputRegisters { .. } => {
            let words = pdu[2..]
                .chunks_exact(2)
                .map(|word| u16::from_be_bytes([word[0], word[1]]));
            Data::Registers(words.collect())
        }
        Ask::WriteCoil { .. } | Ask::WriteRegister { .. } | Ask::WriteCoils { .. } | Ask::WriteRegisters { .. } => {
            Data::Written
        }
    })
}

/// Byte count of the answer to a read; none for a write.
fn bytes_to_read(ask: &Ask) -> Option<u8> {
    match ask {
        Ask::ReadCoils { count, .. } | Ask::ReadDiscreteInputs { count, .. } => Some(count.div_ceil(8) as u8),
        Ask::ReadHoldingRegisters { count, .. } | Ask::ReadInputRegisters { count, .. } => Some(*count as u8 * 2),
        Ask::WriteCoil { .. } | Ask::WriteRegister { .. } | Ask::WriteCoils { .. } | Ask::WriteRegisters { .. } => None,
    }
}
