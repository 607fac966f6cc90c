//! One owner an instrument: whoever opens a link holds the lock of what is behind it, and says who they are.
//!
//! The lock belongs to the device, not to the words that name it: links to a serial port are followed, and a host is
//! resolved, so that two station files that mean one instrument meet. Pipes in memory need none.

use std::collections::{BTreeMap, BTreeSet};
use std::io;
use std::net::{IpAddr, SocketAddr, UdpSocket};
use std::path::PathBuf;
use std::pin::Pin;
use std::sync::{Arc, Mutex, PoisonError};
use std::task::{Context, Poll};

use isolux_lock::{Held, Lock, LockError, file_name, shared_folder};
use tokio::io::{AsyncRead, AsyncWrite, ReadBuf};

use crate::serial::one_name;
use crate::{Link, LinkError, UsbAddress, usb_devices};

/// The lock files of what is behind `address`, none for a pipe in memory. A host with several addresses has as many.
///
/// # Errors
/// What the system says to the name of the host.
pub async fn lock_files(address: &str) -> io::Result<Vec<PathBuf>> {
    if address.starts_with("memory:") {
        return Ok(Vec::new());
    }
    let folder = shared_folder();
    let things = things(address).await?;
    Ok(things.iter().map(|thing| folder.join(file_name(thing))).collect())
}

/// What is behind `address`, by all its names: two addresses with a name in common lead to one device. A host with
/// several addresses has as many names.
///
/// # Errors
/// What the system says to the name of the host.
pub async fn things(address: &str) -> io::Result<BTreeSet<String>> {
    Ok(match network_peer(address) {
        _ if address.starts_with("memory:") => [address.to_owned()].into(),
        _ if address.starts_with("usb:") => [usb_name(address)].into(),
        Some(peer) => tokio::net::lookup_host(peer).await?.map(tcp_name).collect(),
        None => [serial_name(address)].into(),
    })
}

/// Host and port of an address on the network: `tcp://` for the bytes of a serial line, `modbus-tcp://` for Modbus
/// frames with a header of their own.
pub(crate) fn network_peer(address: &str) -> Option<&str> {
    ["tcp://", "modbus-tcp://"]
        .iter()
        .find_map(|scheme| address.strip_prefix(scheme))
}

/// Who holds the serial port at `path` through this program; none where nobody does.
pub fn port_holder(path: &str) -> Option<Held> {
    Lock::held(&shared_folder().join(file_name(&serial_name(path))))
}

fn serial_name(path: &str) -> String {
    format!("serial:{}", one_name(path))
}

/// The socket that a USB device is plugged into, which has one name whatever the address says. What no device or more
/// than one fits keeps its address: opening it says what is wrong, or takes the name of the one that the driver means.
fn usb_name(address: &str) -> String {
    let Ok(Some(wanted)) = UsbAddress::parse(address) else {
        return address.to_owned();
    };
    if let Some(port) = wanted.port {
        return format!("usb:{port}");
    }
    let fitting = usb_devices().into_iter().filter(|device| {
        wanted.id.is_none_or(|id| device.id == id)
            && (wanted.serial.is_none() || device.serial == wanted.serial)
            && (wanted.id.is_some() || wanted.serial.is_some())
    });
    match &fitting.collect::<Vec<_>>()[..] {
        [only] => format!("usb:{}", only.port),
        _ => address.to_owned(),
    }
}

/// Every address of this computer is the same name: a bridge here can be called localhost, 127.0.0.1, ::1 or as the
/// network knows it.
fn tcp_name(address: SocketAddr) -> String {
    let ip = address.ip().to_canonical();
    // Only an address of this computer can be bound to; nothing is sent.
    let here = ip.is_loopback() || ip.is_unspecified() || UdpSocket::bind(SocketAddr::new(ip, 0)).is_ok();
    match ip {
        _ if here => format!("tcp:localhost:{}", address.port()),
        IpAddr::V4(ip) => format!("tcp:{ip}:{}", address.port()),
        IpAddr::V6(ip) => format!("tcp:[{ip}]:{}", address.port()),
    }
}

/// The locks of one session, by file. They are held until the session ends, also while a lost link is opened again.
#[derive(Debug, Default)]
pub(crate) struct Locks(Mutex<BTreeMap<PathBuf, Arc<Lock>>>);

impl Locks {
    /// That another process has taken over what this session owned, and which.
    pub fn lost(&self) -> Option<String> {
        let held = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        held.values().find(|lock| !lock.is_ours()).map(|one| lost(one))
    }

    /// The locks of what is behind `address`, taken now where this session does not have them yet; and who they were
    /// taken over from, which only `force` does.
    pub async fn of(&self, address: &str, force: bool) -> Result<(Vec<Arc<Lock>>, Option<Held>), LinkError> {
        let files = lock_files(address).await.map_err(|error| LinkError {
            address: address.to_owned(),
            reason: error.to_string(),
            advice: Some("check host and port, and that the device is on".to_owned()),
        })?;
        let (mut locks, mut taken_from) = (Vec::new(), None);
        for file in files {
            let (lock, from) = self.one(address, file, force)?;
            locks.push(lock);
            taken_from = taken_from.or(from);
        }
        Ok((locks, taken_from))
    }

    fn one(&self, address: &str, file: PathBuf, force: bool) -> Result<(Arc<Lock>, Option<Held>), LinkError> {
        let refused = |reason: String, advice: Option<&str>| LinkError {
            address: address.to_owned(),
            reason,
            advice: advice.map(str::to_owned),
        };
        let mut held = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some(lock) = held.get(&file) {
            return if lock.is_ours() {
                Ok((Arc::clone(lock), None))
            } else {
                Err(refused(lost(lock), None))
            };
        }
        let taken = if force {
            Lock::take_over(&file)
        } else {
            Lock::take(&file).map(|lock| (lock, None))
        };
        let (lock, from) = taken.map_err(|error| {
            let advice = match &error {
                LockError::Held(held) if held.works() => {
                    "wait until it ends, or end it (Ctrl-C there); `isolux stop STATION` stops the axes under it"
                }
                LockError::Held(_) => {
                    "end that process, or take the instruments over with --force \"REASON\"; the reason is recorded"
                }
                LockError::NotALock { .. } | LockError::Io { .. } => {
                    "without the lock two programs could drive the instruments at once, so nothing was opened"
                }
            };
            refused(error.to_string(), Some(advice))
        })?;
        let lock = Arc::new(lock);
        held.insert(file, Arc::clone(&lock));
        Ok((lock, from))
    }
}

fn lost(lock: &Lock) -> String {
    match lock.taken_by() {
        Some(holder) => format!("the instrument was taken over by {holder}"),
        None => "the instrument was taken over by another process".to_owned(),
    }
}

/// Why nothing is sent to an instrument any more: another process has taken it over, and which.
#[derive(Debug, thiserror::Error)]
#[error("{0}")]
pub(crate) struct TakenOver(String);

/// A link that says nothing more to its instrument once somebody else owns it.
pub(crate) struct Owned {
    pub link: Box<dyn Link>,
    pub locks: Vec<Arc<Lock>>,
}

impl AsyncRead for Owned {
    fn poll_read(self: Pin<&mut Self>, cx: &mut Context<'_>, buf: &mut ReadBuf<'_>) -> Poll<io::Result<()>> {
        Pin::new(&mut self.get_mut().link).poll_read(cx, buf)
    }
}

impl AsyncWrite for Owned {
    fn poll_write(self: Pin<&mut Self>, cx: &mut Context<'_>, bytes: &[u8]) -> Poll<io::Result<usize>> {
        let this = self.get_mut();
        if let Some(lock) = this.locks.iter().find(|lock| !lock.is_ours()) {
            return Poll::Ready(Err(io::Error::other(TakenOver(lost(lock)))));
        }
        Pin::new(&mut this.link).poll_write(cx, bytes)
    }

    fn poll_flush(self: Pin<&mut Self>, cx: &mut Context<'_>) -> Poll<io::Result<()>> {
        Pin::new(&mut self.get_mut().link).poll_flush(cx)
    }

    fn poll_shutdown(self: Pin<&mut Self>, cx: &mut Context<'_>) -> Poll<io::Result<()>> {
        Pin::new(&mut self.get_mut().link).poll_shutdown(cx)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[tokio::test]
    async fn names_of_one_device_have_one_lock_and_those_of_two_have_two() {
        let one = lock_files("tcp://localhost:4001").await.unwrap();
        assert_eq!(one.len(), 1, "{one:?}");
        for other in [
            "127.0.0.1:4001",
            "[::1]:4001",
            "[::ffff:127.0.0.1]:4001",
            "0.0.0.0:4001",
        ] {
            assert_eq!(lock_files(&format!("tcp://{other}")).await.unwrap(), one, "{other}");
        }
        assert_ne!(lock_files("tcp://127.0.0.1:4002").await.unwrap(), one);
        assert_ne!(lock_files("tcp://192.0.2.7:4001").await.unwrap(), one);
        assert!(lock_files("memory:axes").await.unwrap().is_empty());
    }

    #[cfg(unix)]
    #[tokio::test]
    async fn links_to_a_port_are_followed() {
        let folder = tempfile::tempdir().unwrap();
        let link = folder.path().join("by-id");
        std::os::unix::fs::symlink("/dev/null", &link).unwrap();
        let by_id = lock_files(link.to_str().unwrap()).await.unwrap();
        assert_eq!(by_id, lock_files("/dev/null").await.unwrap());
        assert_ne!(by_id, lock_files("/dev/zero").await.unwrap());
    }
}
