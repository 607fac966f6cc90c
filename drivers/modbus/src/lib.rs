//! A Modbus unit on a port.
//!
//! The link in the address chooses the frame: `modbus-tcp://host:port` speaks MBAP; everything else, also `tcp://`,
//! carries the bytes of RTU. `unit=N` is the unit's number.

use std::time::Duration;

use isolux_device::{DeviceError, OpenError, Target};
pub use isolux_protocol_modbus::{Ask, Data, Encoding, Modbus, NumberType, Reply, Request, WordOrder};
use isolux_protocol_modbus::{Mbap, Rtu, crc, silent_interval};
use isolux_transport::{Bus, LineSettings, Place, Ports};
use tokio::time::Instant;

/// No answer is ever complete later than this after its request: a time-out of a second is what masters use (SL 2.4.1),
/// and gateways give their devices as long.
const SLOWEST_ANSWER: Duration = Duration::from_secs(1);

/// Answers come within 10 to 50 ms at 9600 baud; a gateway may add as much.
pub const ANSWER: Duration = Duration::from_millis(500);

/// How long a request waits for its turn and for a line that is drained.
const PATIENCE: Duration = Duration::from_secs(30);

/// Drives of Oriental Motor want 5 ms between frames up to 9600 baud and 3 ms above, more than SL 2.5.1.1 asks for.
const fn least_silence(baud: u32) -> Duration {
    Duration::from_millis(if baud <= 9600 { 5 } else { 3 })
}

/// Scheme of links that carry MBAP.
const MBAP: &str = "modbus-tcp://";

/// One unit on a port.
#[derive(Clone)]
pub struct Unit {
    bus: Bus<Modbus>,
    unit: u8,
    name: String,
}

/// Registers that were read, and the frame that says so.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Registers {
    /// The registers.
    pub words: Vec<u16>,
    /// The answer as it came.
    pub frame: Vec<u8>,
}

/// Which registers.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Table {
    /// Function 03.
    Holding,
    /// Function 04.
    Input,
}

/// What `target` uses on its port, by its option `unit`; opens nothing.
///
/// # Errors
/// [`OpenError::Address`] for a number that no unit has.
pub fn place(target: &Target, line: LineSettings) -> Result<Place, OpenError> {
    let channel = format!("unit {}", unit_number(target)?);
    Ok(Place { channel, line })
}

/// Which unit has answered a question for two holding registers over RTU, with registers or with a refusal: for
/// [`Probe::read`](isolux_transport::Probe).
pub fn unit_of(bytes: &[u8]) -> Option<String> {
    let whole = |length: usize| {
        let frame = bytes.get(..length)?;
        let (body, sum) = frame.split_at(length - 2);
        (crc(body).to_le_bytes() == *sum).then_some(frame[0])
    };
    let (unit, refused) = match bytes.get(1..3)? {
        [3, 4] => (whole(9)?, ""),
        [0x83, _] => (whole(5)?, ", which has no such register"),
        _ => return None,
    };
    Some(format!("a Modbus RTU unit, number {unit}{refused}"))
}

/// The unit that `target` names.
///
/// # Errors
/// As [`place`].
pub fn unit_number(target: &Target) -> Result<u8, OpenError> {
    // On TCP 0 and 255 mean the device itself; on a line 0 is for all, and nobody answers (SL 2.2).
    let (least, most) = if is_network(target) { (0, 255) } else { (1, 247) };
    match target.number("unit", 1_u16)? {
        unit if (least..=most).contains(&unit) => Ok(unit as u8),
        unit => Err(target.wrong(format!("unit={unit} is not {least} to {most}"))),
    }
}

/// The conversation that the link of `target` carries.
pub fn conversation(target: &Target, line: LineSettings) -> Modbus {
    if is_network(target) {
        Modbus::Tcp(Mbap::new(SLOWEST_ANSWER))
    } else {
        let silence = silent_interval(line.baud).max(least_silence(line.baud));
        Modbus::Rtu(Rtu::new(silence, SLOWEST_ANSWER))
    }
}

fn is_network(target: &Target) -> bool {
    target.link().starts_with(MBAP)
}

impl Table {
    /// The request to read `count` registers.
    pub const fn ask(self, from: u16, count: u16) -> Ask {
        match self {
            Self::Holding => Ask::ReadHoldingRegisters { from, count },
            Self::Input => Ask::ReadInputRegisters { from, count },
        }
    }
}

impl Unit {
    /// The unit that `target` names, on its port in `ports`. Sends nothing. `line` is that of a serial port.
    ///
    /// # Errors
    /// [`OpenError::Address`] for a `unit` out of range; [`OpenError::Link`].
    pub async fn open(ports: &Ports, target: &Target, line: LineSettings) -> Result<Self, OpenError> {
        let unit = unit_number(target)?;
        Ok(Self {
            bus: ports.bus(target, line, || conversation(target, line)).await?,
            unit,
            name: target.to_string(),
        })
    }

    /// Its handle on the port, for exchanges that this type has no word for.
    pub const fn bus(&self) -> &Bus<Modbus> {
        &self.bus
    }

    /// Driver and target.
    pub fn name(&self) -> &str {
        &self.name
    }

    /// How often bytes have come that nothing had asked for. RTU numbers nothing: a change between two looks puts what
    /// was read between them in doubt.
    pub fn unsolicited(&self) -> u64 {
        self.bus.unsolicited()
    }

    /// Reads registers, again if the line lost or damaged the answer.
    ///
    /// # Errors
    /// [`DeviceError`] of `action`; [`Refused`](DeviceError::Refused) names the exception.
    pub async fn read(&self, table: Table, from: u16, count: u16, action: &str) -> Result<Registers, DeviceError> {
        let request = self.request(table.ask(from, count), action)?;
        let deadline = Instant::now() + PATIENCE;
        let reply = self.bus.ask_again(request, None, ANSWER, deadline).await;
        self.registers(reply.map_err(|error| error.during(&self.name, action))?, action)
    }

    /// Writes registers (function 10h, whose answer an echo cannot imitate), again if the line lost or damaged the
    /// answer: for values that may be written twice.
    ///
    /// # Errors
    /// As [`read`](Self::read).
    pub async fn write(&self, from: u16, values: Vec<u16>, action: &str) -> Result<(), DeviceError> {
        let request = self.request(Ask::WriteRegisters { from, values }, action)?;
        let reply = self
            .bus
            .ask_again(request, None, ANSWER, Instant::now() + PATIENCE)
            .await;
        self.data(reply.map_err(|error| error.during(&self.name, action))?, action)
            .map(|_| ())
    }

    /// A request to this unit.
    ///
    /// # Errors
    /// [`Unsupported`](DeviceError::Unsupported) for what no frame can ask.
    pub fn request(&self, ask: Ask, action: &str) -> Result<Request, DeviceError> {
        Request::new(self.unit, ask).map_err(|error| DeviceError::unsupported(&self.name, action, error.to_string()))
    }

    /// The registers of an answer.
    ///
    /// # Errors
    /// [`Refused`](DeviceError::Refused) names the exception.
    pub fn registers(&self, reply: Reply, action: &str) -> Result<Registers, DeviceError> {
        match self.data(reply, action)? {
            (Data::Registers(words), frame) => Ok(Registers { words, frame }),
            (_, frame) => Err(self.malformed(action, "no registers", frame)),
        }
    }

    fn data(&self, reply: Reply, action: &str) -> Result<(Data, Vec<u8>), DeviceError> {
        let Reply { outcome, frame } = reply;
        match outcome {
            Ok(data) => Ok((data, frame)),
            Err(exception) => Err(DeviceError::refused(&self.name, action, exception.to_string(), frame)),
        }
    }

    /// A [`DeviceError::Malformed`] of this unit.
    pub fn malformed(&self, action: &str, reason: &str, frame: Vec<u8>) -> DeviceError {
        DeviceError::malformed(&self.name, action, reason, frame)
    }

    /// A [`DeviceError::Fault`] of this unit.
    pub fn fault(&self, action: &str, reason: impl Into<String>, evidence: Vec<u8>) -> DeviceError {
        DeviceError::fault(&self.name, action, reason, evidence)
    }
}
