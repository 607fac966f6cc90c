//! What the client asks.

/// What is asked of a unit. Addresses count from 0, as they are sent.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Ask {
    /// Function 01.
    ReadCoils {
        /// First coil.
        from: u16,
        /// 1 to 2000.
        count: u16,
    },
    /// Function 02.
    ReadDiscreteInputs {
        /// First input.
        from: u16,
        /// 1 to 2000.
        count: u16,
    },
    /// Function 03.
    ReadHoldingRegisters {
        /// First register.
        from: u16,
        /// 1 to 125.
        count: u16,
    },
    /// Function 04.
    ReadInputRegisters {
        /// First register.
        from: u16,
        /// 1 to 125.
        count: u16,
    },
    /// Function 05. Its answer is its echo: a line that echoes looks like a device that obeys.
    WriteCoil {
        /// Which coil.
        at: u16,
        /// On or off.
        on: bool,
    },
    /// Function 06. Its answer is its echo: a line that echoes looks like a device that obeys.
    WriteRegister {
        /// Which register.
        at: u16,
        /// Its new value.
        value: u16,
    },
    /// Function 0Fh.
    WriteCoils {
        /// First coil.
        from: u16,
        /// 1 to 1968 states.
        on: Vec<bool>,
    },
    /// Function 10h.
    WriteRegisters {
        /// First register.
        from: u16,
        /// 1 to 123 values.
        values: Vec<u16>,
    },
}

/// A request that the specification allows.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Request {
    unit: u8,
    ask: Ask,
}

/// Why something may not be asked.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
pub enum NotARequest {
    /// None, or more than fit into one frame.
    #[error("{count} coils or registers: function {function:02X}h takes 1 to {most}")]
    Count {
        /// As asked.
        count: usize,
        /// Function code.
        function: u8,
        /// The specification's limit.
        most: usize,
    },
    /// Past address FFFFh.
    #[error("{count} from address {from:04X}h on run past the last address, FFFFh")]
    Address {
        /// First.
        from: u16,
        /// How many.
        count: usize,
    },
}

impl Request {
    /// `ask` of `unit`: 1 to 247 on a serial line (SL 2.2), any number on TCP, where 0 and 255 mean the device itself.
    ///
    /// # Errors
    /// [`NotARequest`] for counts beyond those of AP 6.1 to 6.12, and addresses past FFFFh.
    pub fn new(unit: u8, ask: Ask) -> Result<Self, NotARequest> {
        let function = ask.function();
        let (from, count, most) = match &ask {
            Ask::ReadCoils { from, count } | Ask::ReadDiscreteInputs { from, count } => {
                (*from, usize::from(*count), 2000)
            }
            Ask::ReadHoldingRegisters { from, count } | Ask::ReadInputRegisters { from, count } => {
                (*from, usize::from(*count), 125)
            }
            Ask::WriteCoil { at, .. } | Ask::WriteRegister { at, .. } => (*at, 1, 1),
            Ask::WriteCoils { from, on } => (*from, on.len(), 1968),
            Ask::WriteRegisters { from, values } => (*from, values.len(), 123),
        };
        if count == 0 || count > most {
            return Err(NotARequest::Count { count, function, most });
        }
        if usize::from(from) + count > 0x1_0000 {
            return Err(NotARequest::Address { from, count });
        }
        Ok(Self { unit, ask })
    }

    /// Who is asked.
    pub const fn unit(&self) -> u8 {
        self.unit
    }

    /// What is asked.
    pub const fn ask(&self) -> &Ask {
        &self.ask
    }

    /// Function code and data (AP 4.1).
    pub(crate) fn pdu(&self) -> Vec<u8> {
        let mut pdu = vec![self.ask.function()];
        let mut word = |word: u16| pdu.extend(word.to_be_bytes());
        match &self.ask {
            Ask::ReadCoils { from, count }
            | Ask::ReadDiscreteInputs { from, count }
            | Ask::ReadHoldingRegisters { from, count }
            | Ask::ReadInputRegisters { from, count } => {
                word(*from);
                word(*count);
            }
            Ask::WriteCoil { at, on } => {
                word(*at);
                word(if *on { 0xFF00 } else { 0 });
            }
            Ask::WriteRegister { at, value } => {
                word(*at);
                word(*value);
            }
            Ask::WriteCoils { from, on } => {
                word(*from);
                word(on.len() as u16);
                let packed: Vec<u8> = on
                    .chunks(8)
                    .map(|eight| eight.iter().rev().fold(0, |byte, on| byte << 1 | u8::from(*on)))
                    .collect();
                pdu.push(packed.len() as u8);
                pdu.extend(packed);
            }
            Ask::WriteRegisters { from, values } => {
                word(*from);
                word(values.len() as u16);
                pdu.push(values.len() as u8 * 2);
                pdu.extend(values.iter().flat_map(|value| value.to_be_bytes()));
            }
        }
        pdu
    }
}

impl Ask {
    /// The function code.
    pub const fn function(&self) -> u8 {
        match self {
            Self::ReadCoils { .. } => 0x01,
            Self::ReadDiscreteInputs { .. } => 0x02,
            Self::ReadHoldingRegisters { .. } => 0x03,
            Self::ReadInputRegisters { .. } => 0x04,
            Self::WriteCoil { .. } => 0x05,
            Self::WriteRegister { .. } => 0x06,
            Self::WriteCoils { .. } => 0x0F,
            Self::WriteRegisters { .. } => 0x10,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_the_specification_forbids_is_refused() {
        let read = |from, count| Request::new(1, Ask::ReadHoldingRegisters { from, count });
        assert!(read(0, 125).is_ok() && read(0xFFFF, 1).is_ok() && read(0xFF83, 125).is_ok());
        let error = read(0, 126).unwrap_err();
        assert_eq!(error.to_string(), "126 coils or registers: function 03h takes 1 to 125");
        assert!(matches!(read(0, 0), Err(NotARequest::Count { count: 0, .. })));
        assert!(matches!(read(0xFFFF, 2), Err(NotARequest::Address { .. })));
        let coils = |count| Request::new(1, Ask::ReadCoils { from: 0, count });
        assert!(coils(2000).is_ok() && coils(2001).is_err());
        let write = |count| {
            Request::new(
                1,
                Ask::WriteRegisters {
                    from: 0,
                    values: vec![0; count],
                },
            )
        };
        assert!(write(123).is_ok() && write(124).is_err() && write(0).is_err());
        let bits = |count| {
            Request::new(
                1,
                Ask::WriteCoils {
                    from: 0,
                    on: vec![true; count],
                },
            )
        };
        assert!(bits(1968).is_ok() && bits(1969).is_err());
    }
}
