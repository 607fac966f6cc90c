//! The real links: serial ports, TCP, USB.

use std::io;
use std::sync::Arc;
use std::time::Duration;

use async_trait::async_trait;
use isolux_lock::Held;
use tokio::net::TcpStream;
use tokio_serial::SerialPortType;

use crate::owner::{Locks, Owned, network_peer, port_holder};
use crate::usb::find_usb;
use crate::users::users_of;
use crate::{LineSettings, Link, LinkError, Links, MemoryLinks, UsbAddress, UsbProfile, serial};

/// Opens serial lines, TCP connections and, by `memory:name`, the pipes of this process. What is behind the first two
/// belongs to this process from then on until this is dropped; another that tries is told who has it.
#[derive(Debug, Clone)]
pub struct SystemLinks {
    /// The pipes that `memory:` reaches.
    pub memory: MemoryLinks,
    /// None: opens what others own too.
    locks: Option<Arc<Locks>>,
}

impl Default for SystemLinks {
    fn default() -> Self {
        Self {
            memory: MemoryLinks::default(),
            locks: Some(Arc::default()),
        }
    }
}

impl SystemLinks {
    /// Links that are opened whoever owns them: for stopping what moves, and for nothing else.
    pub fn beside_their_owner() -> Self {
        Self {
            locks: None,
            ..Self::default()
        }
    }

    /// That another process has taken over what this one owned, and which; nothing is sent there any more.
    pub fn lost(&self) -> Option<String> {
        self.locks.as_ref().and_then(|locks| locks.lost())
    }

    /// Becomes the owner of what is behind `address` before it is opened. With `force` also where its owner gave no
    /// sign of life for a while; that owner, if there was one.
    ///
    /// # Errors
    /// [`LinkError`] says who else owns it.
    pub async fn claim(&self, address: &str, force: bool) -> Result<Option<Held>, LinkError> {
        match &self.locks {
            Some(locks) => locks.of(address, force).await.map(|(_, from)| from),
            None => Ok(None),
        }
    }
}

/// How long a TCP connection may take: an instrument stands in the same building.
const CONNECT: Duration = Duration::from_secs(5);

#[async_trait]
impl Links for SystemLinks {
    async fn open(&self, address: &str, line: LineSettings) -> Result<Box<dyn Link>, LinkError> {
        if address.starts_with("memory:") {
            return self.memory.open(address, line).await;
        }
        if address.starts_with("usb:") {
            return Err(LinkError {
                address: address.to_owned(),
                reason: "this driver's instruments are not reached over USB".to_owned(),
                advice: Some("a serial adapter has a port: `isolux devices` lists them".to_owned()),
            });
        }
        let locks = match &self.locks {
            Some(locks) => locks.of(address, false).await?.0,
            None => Vec::new(),
        };
        let link = match network_peer(address) {
            Some(peer) => connect(address, peer).await?,
            None => Box::new(serial::open(address, line, self.locks.is_some()).await?),
        };
        Ok(Box::new(Owned { link, locks }))
    }

    async fn open_usb(
        &self,
        address: &str,
        _line: LineSettings,
        profile: &'static UsbProfile,
    ) -> Result<Box<dyn Link>, LinkError> {
        let failed = |reason: String| LinkError {
            address: address.to_owned(),
            reason,
            advice: None,
        };
        let device = UsbAddress::parse(address)?.ok_or_else(|| failed("no USB address".to_owned()))?;
        // libusb's calls block, some for seconds.
        let finding = tokio::task::spawn_blocking(move || find_usb(&device, profile));
        let found = finding.await.map_err(|error| failed(error.to_string()))??;
        let locks = match &self.locks {
            Some(locks) => locks.of(&found.place(), false).await?.0,
            None => Vec::new(),
        };
        let opening = tokio::task::spawn_blocking(move || found.open());
        let link = opening.await.map_err(|error| failed(error.to_string()))??;
        Ok(Box::new(Owned { link, locks }))
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

/// Whether a port can be used; one that is in use is left alone.
fn state_of(path: &str) -> PortState {
    if let Some(held) = port_holder(path) {
        return PortState::Unusable {
            reason: format!("in use by {held}"),
            advice: Some("wait until it ends, or end it".to_owned()),
        };
    }
    if !users_of(path).is_empty() {
        return PortState::Unusable {
            reason: serial::busy(path),
            advice: serial::advice(io::ErrorKind::ResourceBusy).map(str::to_owned),
        };
    }
    match serial::probe(path) {
        Ok(()) => PortState::Usable,
        Err(error) => PortState::Unusable {
            reason: match error.kind() {
                io::ErrorKind::ResourceBusy => serial::busy(path),
                _ => error.to_string(),
            },
            advice: serial::advice(error.kind()).map(str::to_owned),
        },
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{BusError, Parity};
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

    #[cfg(target_os = "linux")]
    #[tokio::test]
    async fn a_busy_port_says_so_and_who_has_it() {
        let (_master, mut slave) = serialport::TTYPort::pair().unwrap();
        // As another program would hold it.
        slave.set_exclusive(true).unwrap();
        let path = serialport::SerialPort::name(&slave).unwrap();
        let error = SystemLinks::default().open(&path, LINE).await.err().unwrap();
        assert!(error.reason.contains("busy"), "{error:?}");
        assert!(
            error.reason.contains(&format!("(pid {})", std::process::id())),
            "{error:?}"
        );
        assert!(!error.advice.unwrap().contains("no such port"));
    }

    #[cfg(target_os = "linux")]
    #[tokio::test]
    async fn a_port_has_one_owner_and_a_stop_passes_him() {
        let (_master, slave) = serialport::TTYPort::pair().unwrap();
        let path = serialport::SerialPort::name(&slave).unwrap();
        drop(slave);
        let folder = tempfile::tempdir().unwrap();
        let by_id = folder.path().join("by-id");
        std::os::unix::fs::symlink(&path, &by_id).unwrap();
        let owner = SystemLinks::default();
        let _port = owner
            .open(&path, LINE)
            .await
            .map_err(|error| error.to_string())
            .unwrap();
        let error = SystemLinks::default()
            .open(by_id.to_str().unwrap(), LINE)
            .await
            .err()
            .unwrap();
        assert!(error.reason.contains(&format!("pid {}", std::process::id())), "{error}");
        let error = SystemLinks::default().claim(&path, true).await.unwrap_err();
        assert!(error.reason.contains("in use by"), "its owner works: {error}");
        SystemLinks::beside_their_owner()
            .open(&path, LINE)
            .await
            .map_err(|error| error.to_string())
            .unwrap();
        drop(owner);
        SystemLinks::default().claim(&path, false).await.unwrap_err();
    }

    #[tokio::test]
    async fn who_was_taken_over_from_says_nothing_more_to_the_instrument() {
        let listener = tokio::net::TcpListener::bind("127.0.0.1:0").await.unwrap();
        let port = listener.local_addr().unwrap().port();
        let owner = SystemLinks::default();
        let opened = owner.open(&format!("tcp://127.0.0.1:{port}"), LINE).await;
        let mut link = opened.map_err(|error| error.to_string()).unwrap();
        link.write_all(b"ask").await.unwrap();
        let files = crate::lock_files(&format!("tcp://localhost:{port}")).await.unwrap();
        let taken = isolux_lock::Lock::seize(&files[0]).unwrap();
        let error = link.write_all(b"move").await.unwrap_err();
        let BusError::TakenOver { reason } = BusError::of_link(&error) else {
            panic!("{error}");
        };
        assert!(reason.contains("taken over"), "{reason}");
        let again = owner.open(&format!("tcp://127.0.0.1:{port}"), LINE).await;
        assert!(again.err().unwrap().reason.contains("taken over"));
        assert!(owner.lost().unwrap().contains(&format!("pid {}", std::process::id())));
        drop(taken);
        assert!(link.write_all(b"move").await.is_err(), "what is lost stays lost");
        let (mut twin, _) = listener.accept().await.unwrap();
        drop(link);
        let mut read = Vec::new();
        twin.read_to_end(&mut read).await.unwrap();
        assert_eq!(read, b"ask");
    }
}
