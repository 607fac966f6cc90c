//! USB/IP on the wire (kernel, Documentation/usb/usbip_protocol.rst): all numbers high byte first.

use std::io;

use tokio::io::{AsyncRead, AsyncReadExt};

use crate::model::Model;

/// Version 1.1.1.
const VERSION: u16 = 0x0111;
const REQUEST_LIST: u16 = 0x8005;
const REPLY_LIST: u16 = 0x0005;
const REQUEST_IMPORT: u16 = 0x8003;
const REPLY_IMPORT: u16 = 0x0003;

const SUBMIT: u32 = 1;
const UNLINK: u32 = 2;
const SUBMITTED: u32 = 3;
const UNLINKED: u32 = 4;

/// The longest transfer that is taken: more than any of these instruments sends.
const LONGEST: u32 = 1 << 20;

/// What a connection begins with.
#[derive(Debug, PartialEq, Eq)]
pub enum Opening {
    /// Which devices are there?
    List,
    /// This one, please.
    Import(String),
}

/// Reads the first request of a connection.
pub async fn opening(stream: &mut (impl AsyncRead + Unpin)) -> io::Result<Opening> {
    let version = stream.read_u16().await?;
    let code = stream.read_u16().await?;
    let _status = stream.read_u32().await?;
    match code {
        _ if version != VERSION => Err(invalid(format!("version {version:#06x}, not {VERSION:#06x}"))),
        REQUEST_LIST => Ok(Opening::List),
        REQUEST_IMPORT => {
            let mut name = [0; 32];
            stream.read_exact(&mut name).await?;
            let text = String::from_utf8_lossy(&name);
            Ok(Opening::Import(text.trim_end_matches('\0').to_owned()))
        }
        other => Err(invalid(format!("operation {other:#06x}"))),
    }
}

/// The devices of the bench.
pub fn list(devices: &[(String, &Model)]) -> Vec<u8> {
    let mut bytes = head(REPLY_LIST, 0);
    bytes.extend((devices.len() as u32).to_be_bytes());
    for (place, (name, model)) in devices.iter().enumerate() {
        bytes.extend(description(name, place, model));
        // Class, subclass and protocol of its one interface, and a byte to fill.
        bytes.extend([0xFF, 0, 0, 0]);
    }
    bytes
}

/// The device that was asked for, or that there is none.
pub fn import(device: Option<(&str, usize, &Model)>) -> Vec<u8> {
    match device {
        Some((name, place, model)) => [head(REPLY_IMPORT, 0), description(name, place, model)].concat(),
        None => head(REPLY_IMPORT, 1),
    }
}

fn head(code: u16, status: u32) -> Vec<u8> {
    let mut bytes = VERSION.to_be_bytes().to_vec();
    bytes.extend(code.to_be_bytes());
    bytes.extend(status.to_be_bytes());
    bytes
}

fn description(name: &str, place: usize, model: &Model) -> Vec<u8> {
    let fixed = |text: &str, length: usize| {
        let mut bytes = text.as_bytes().to_vec();
        bytes.resize(length, 0);
        bytes
    };
    let mut bytes = fixed(&format!("/sys/devices/isolux/{name}"), 256);
    bytes.extend(fixed(name, 32));
    for number in [1, place as u32 + 2, model.speed.number()] {
        bytes.extend(number.to_be_bytes());
    }
    for number in [model.id.0, model.id.1, model.release] {
        bytes.extend(number.to_be_bytes());
    }
    // Class of the vendor; configuration 1 of 1, one interface.
    bytes.extend([0xFF, 0, 0, 1, 1, 1]);
    bytes
}

/// A transfer that the host wants.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Urb {
    /// Its number.
    pub number: u32,
    /// Address of the endpoint, with 0x80 for data to the host.
    pub endpoint: u8,
    /// A short answer is an error (`URB_SHORT_NOT_OK`).
    pub whole: bool,
    /// Bytes that the host takes.
    pub length: usize,
    /// Setup packet of a control transfer.
    pub setup: [u8; 8],
    /// Bytes from the host.
    pub data: Vec<u8>,
}

/// What the host says once a device is imported.
#[derive(Debug, PartialEq, Eq)]
pub enum Command {
    /// Do this.
    Submit(Urb),
    /// Forget that.
    Unlink {
        /// Number of this command.
        number: u32,
        /// Number of the transfer.
        forget: u32,
    },
}

/// Reads one command.
pub async fn command(stream: &mut (impl AsyncRead + Unpin)) -> io::Result<Command> {
    let mut head = [0; 48];
    stream.read_exact(&mut head).await?;
    let word = |at: usize| u32::from_be_bytes([head[at], head[at + 1], head[at + 2], head[at + 3]]);
    let number = word(4);
    match word(0) {
        SUBMIT => {
            let to_host = word(12) == 1;
            let length = word(24);
            if length > LONGEST || word(16) > 15 {
                return Err(invalid(format!(
                    "a transfer of {length} bytes on endpoint {}",
                    word(16)
                )));
            }
            let mut data = vec![0; if to_host { 0 } else { length as usize }];
            stream.read_exact(&mut data).await?;
            let mut setup = [0; 8];
            setup.copy_from_slice(&head[40..48]);
            Ok(Command::Submit(Urb {
                number,
                endpoint: word(16) as u8 | if to_host { 0x80 } else { 0 },
                whole: word(20) & 1 != 0,
                length: length as usize,
                setup,
                data,
            }))
        }
        UNLINK => Ok(Command::Unlink {
            number,
            forget: word(20),
        }),
        other => Err(invalid(format!("command {other}"))),
    }
}

/// What the device answers.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Answer {
    /// A transfer has ended.
    Done {
        /// Its number.
        number: u32,
        /// 0, or the kernel's error with a minus.
        status: i32,
        /// Bytes that were taken from the host.
        taken: usize,
        /// Bytes to the host.
        data: Vec<u8>,
    },
    /// An [`Command::Unlink`] has ended.
    Forgotten {
        /// Its number.
        number: u32,
        /// −104 where the transfer was still waiting, 0 where it had ended.
        status: i32,
    },
}

impl Answer {
    /// Its bytes.
    pub fn encode(&self) -> Vec<u8> {
        let (command, number, status, length, data) = match self {
            Self::Done {
                number,
                status,
                taken,
                data,
            } => (SUBMITTED, *number, *status, taken + data.len(), &data[..]),
            Self::Forgotten { number, status } => (UNLINKED, *number, *status, 0, &[][..]),
        };
        let mut bytes = Vec::with_capacity(48 + data.len());
        for word in [command, number, 0, 0, 0, status as u32, length as u32] {
            bytes.extend(word.to_be_bytes());
        }
        bytes.resize(48, 0);
        bytes.extend_from_slice(data);
        bytes
    }
}

fn invalid(reason: String) -> io::Error {
    io::Error::new(io::ErrorKind::InvalidData, format!("USB/IP: {reason}"))
}
