//! The real links: serial ports, ptys, TCP.

use std::io;
use std::time::Duration;

use async_trait::async_trait;
use tokio::net::TcpStream;
use tokio_serial::{SerialPortBuilderExt, SerialPortType};

use crate::{LineSettings, Link, LinkError, Links, MemoryLinks, Parity};

/// Opens serial lines, TCP connections and, by `memory:name`, the pipes of this process.
#[derive(Debug, Clone, Default)]
pub struct SystemLinks {
    /// The pipes that `memory:` reaches.
    pub memory: MemoryLinks,
}

/// How long a TCP connection may take: an instrument stands in the same building.
const CONNECT: Duration = Duration::from_secs(5);

#[async_trait]
impl Links for SystemLinks {
    async fn open(&self, address: &str, line: LineSettings) -> Result<Box<dyn Link>, LinkError> {
        if address.starts_with("memory:") {
            return self.memory.open(address, line).await;
        }
        if let Some(peer) = address.strip_prefix("tcp://") {
            return connect(address, peer).await;
        }
        if address.starts_with("usb:") {
            return Err(LinkError {
                address: address.to_owned(),
                reason: "USB links are not built yet".to_owned(),
                advice: Some("use a serial port, a pty or tcp://host:port".to_owned()),
            });
        }
        open_serial(address, line)
    }
}

async fn connect(address: &str, peer: &str) -> Result<Box<dyn Link>, LinkError> {
    let failed = |reason: String, advice: &str| LinkError {
        address: address.to_owned(),
        reason,
        advice: Some(advice.to_owned()),
    };
    let connected = tokio::time::timeout(CONNECT, TcpStream::connect(peer)).await;
    let stream = match connected {
        Ok(Ok(stream)) => stream,
        Ok(Err(error)) => {
            return Err(failed(
                error.to_string(),
                "check host and port, and that the device is on",
            ));
        }
        Err(_) => {
            return Err(failed(
                format!("no connection within {CONNECT:?}"),
                "check host, port and network",
            ));
        }
    };
    // Short requests must not wait for company (Nagle).
    stream
        .set_nodelay(true)
        .map_err(|error| failed(error.to_string(), "reconnect"))?;
    Ok(Box::new(stream))
}

fn open_serial(path: &str, line: LineSettings) -> Result<Box<dyn Link>, LinkError> {
    // A pseudo-terminal carries whole bytes and nothing else: asked for parity, it refuses or ignores it.
    let line = if is_pty(path) {
        LineSettings {
            data_bits: 8,
            parity: Parity::None,
            stop_bits: 1,
            ..line
        }
    } else {
        line
    };
    let failed = |reason: String, advice: Option<String>| LinkError {
        address: path.to_owned(),
        reason,
        advice,
    };
    let data_bits = match line.data_bits {
        7 => tokio_serial::DataBits::Seven,
        8 => tokio_serial::DataBits::Eight,
        other => return Err(failed(format!("{other} data bits are not supported"), None)),
    };
    let stop_bits = match line.stop_bits {
        1 => tokio_serial::StopBits::One,
        2 => tokio_serial::StopBits::Two,
        other => return Err(failed(format!("{other} stop bits are not supported"), None)),
    };
    let parity = match line.parity {
        Parity::None => tokio_serial::Parity::None,
        Parity::Even => tokio_serial::Parity::Even,
        Parity::Odd => tokio_serial::Parity::Odd,
    };
    let builder = tokio_serial::new(path, line.baud)
        .data_bits(data_bits)
        .stop_bits(stop_bits)
        .parity(parity);
    match builder.open_native_async() {
        Ok(port) => Ok(Box::new(port)),
        Err(error) => {
            let advice = match error.kind {
                tokio_serial::ErrorKind::Io(kind) => advice(kind),
                tokio_serial::ErrorKind::NoDevice => advice(io::ErrorKind::NotFound),
                _ => None,
            };
            Err(failed(error.to_string(), advice))
        }
    }
}

fn is_pty(path: &str) -> bool {
    std::fs::canonicalize(path).is_ok_and(|real| real.starts_with("/dev/pts") || real.starts_with("/dev/ttys"))
}

/// What to do about a port that does not open.
fn advice(kind: io::ErrorKind) -> Option<String> {
    let advice = match kind {
        io::ErrorKind::PermissionDenied => {
            "this account may not use the port: join its group (Debian: sudo usermod -aG dialout $USER), then log in again"
        }
        io::ErrorKind::NotFound => "no such port: `isolux devices` lists those found; check cable and power",
        io::ErrorKind::ResourceBusy => "another program holds the port: close it",
        _ => return None,
    };
    Some(advice.to_owned())
}

/// Whether a port that was found can be used.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum PortState {
    /// It can be opened for reading and writing.
    Usable,
    /// It cannot, and why.
    Unusable {
        /// What the system said.
        reason: String,
        /// What to do about it.
        advice: Option<String>,
    },
}

/// A serial port of this computer.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct FoundPort {
    /// Its path: the target of an `open` key.
    pub path: String,
    /// What it says of itself: USB maker and product, `serial port`, …
    pub description: String,
    /// USB vendor and product id.
    pub usb: Option<(u16, u16)>,
    /// Serial number of the adapter.
    pub serial: Option<String>,
    /// Whether it can be used.
    pub state: PortState,
}

/// The serial ports of this computer, sorted by path. Nothing is sent to any of them.
///
/// # Errors
/// [`LinkError`] when the system does not list its ports.
pub fn found_ports() -> Result<Vec<FoundPort>, LinkError> {
    let ports = tokio_serial::available_ports().map_err(|error| LinkError {
        address: "serial ports".to_owned(),
        reason: error.to_string(),
        advice: None,
    })?;
    let mut found: Vec<FoundPort> = ports
        .into_iter()
        .map(|port| {
            let (description, usb, serial) = match port.port_type {
                SerialPortType::UsbPort(usb) => {
                    let words = [usb.manufacturer, usb.product];
                    let words = words.into_iter().flatten().collect::<Vec<_>>().join(" ");
                    let description = if words.is_empty() {
                        "USB serial port".to_owned()
                    } else {
                        words
                    };
                    (description, Some((usb.vid, usb.pid)), usb.serial_number)
                }
                SerialPortType::PciPort => ("PCI serial port".to_owned(), None, None),
                SerialPortType::BluetoothPort => ("Bluetooth serial port".to_owned(), None, None),
                SerialPortType::Unknown => ("serial port".to_owned(), None, None),
            };
            let state = state_of(&port.port_name);
            FoundPort {
                path: port.port_name,
                description,
                usb,
                serial,
                state,
            }
        })
        .collect();
    found.sort_by(|a, b| a.path.cmp(&b.path));
    Ok(found)
}

/// Opens the file and closes it again; no line setting is touched.
fn state_of(path: &str) -> PortState {
    #[cfg(unix)]
    {
        use std::os::unix::fs::OpenOptionsExt;
        // O_NONBLOCK (Linux 0o4000, macOS 0x4): without it the open waits for a modem's carrier.
        let nonblocking = if cfg!(target_os = "macos") { 0x4 } else { 0o4000 };
        match std::fs::OpenOptions::new()
            .read(true)
            .write(true)
            .custom_flags(nonblocking)
            .open(path)
        {
            Ok(_) => PortState::Usable,
            Err(error) => PortState::Unusable {
                reason: error.to_string(),
                advice: advice(error.kind()),
            },
        }
    }
    #[cfg(not(unix))]
    {
        let _ = path;
        PortState::Usable
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use tokio::io::{AsyncReadExt, AsyncWriteExt};

    const LINE: LineSettings = LineSettings {
        baud: 9600,
        data_bits: 7,
        parity: Parity::Even,
        stop_bits: 1,
    };

    #[tokio::test]
    async fn tcp_carries_bytes_both_ways() {
        let listener = tokio::net::TcpListener::bind("127.0.0.1:0").await.unwrap();
        let address = format!("tcp://{}", listener.local_addr().unwrap());
        let (opened, accepted) = tokio::join!(
            async {
                SystemLinks::default()
                    .open(&address, LINE)
                    .await
                    .map_err(|error| error.to_string())
            },
            listener.accept()
        );
        let (mut host, (mut twin, _)) = (opened.unwrap(), accepted.unwrap());
        host.write_all(b"ask").await.unwrap();
        let mut read = [0; 3];
        twin.read_exact(&mut read).await.unwrap();
        twin.write_all(b"say").await.unwrap();
        host.read_exact(&mut read).await.unwrap();
        assert_eq!(&read, b"say");
    }

    #[tokio::test]
    async fn what_is_not_there_says_so_with_advice() {
        let error = SystemLinks::default()
            .open("/dev/no-such-port", LINE)
            .await
            .err()
            .unwrap();
        assert!(error.advice.unwrap().contains("isolux devices"));
        let error = SystemLinks::default()
            .open("tcp://127.0.0.1:1", LINE)
            .await
            .err()
            .unwrap();
        assert!(error.reason.contains("refused"), "{error}");
        assert!(SystemLinks::default().open("usb:serial=X", LINE).await.is_err());
    }

    #[cfg(target_os = "linux")]
    #[tokio::test]
    async fn a_pty_is_a_serial_port() {
        use serialport::SerialPort;
        use std::io::{Read, Write};
        let (mut master, slave) = serialport::TTYPort::pair().unwrap();
        let path = slave.name().unwrap();
        // The pair holds its slave exclusively; a twin does not hold it at all.
        drop(slave);
        let mut host = SystemLinks::default()
            .open(&path, LINE)
            .await
            .map_err(|error| error.to_string())
            .unwrap();
        host.write_all(b"ask\r\n").await.unwrap();
        let mut read = [0; 5];
        master.set_timeout(Duration::from_secs(5)).unwrap();
        master.read_exact(&mut read).unwrap();
        assert_eq!(&read, b"ask\r\n", "the line is raw");
        master.write_all(b"say\n").unwrap();
        let mut read = [0; 4];
        host.read_exact(&mut read).await.unwrap();
        assert_eq!(&read, b"say\n");
    }
}
