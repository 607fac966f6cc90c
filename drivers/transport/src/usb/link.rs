//! A byte link over bulk endpoints: one thread an endpoint, because libusb's calls block.

use std::io;
use std::pin::Pin;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::task::{Context, Poll};
use std::time::Duration;

use rusb::{DeviceHandle, Error};
use tokio::io::{AsyncRead, AsyncWrite, ReadBuf};
use tokio::sync::mpsc::{UnboundedReceiver, UnboundedSender, unbounded_channel};

use super::profile::UsbFraming;

/// How long one call waits for data; after each the thread looks whether the link is still wanted.
const WAIT: Duration = Duration::from_millis(100);

/// How long the instrument may refuse a command before it is given up.
const SEND: Duration = Duration::from_secs(1);

/// Stalls, overflows and errors of the bus in a row after which the link is lost.
const MOST_FAILURES: u32 = 5;

/// Bytes asked for at once where a short packet ends a transfer; a multiple of every packet size.
const AT_ONCE: usize = 16_384;

/// Longest transfer that a frame can carry.
const LONGEST: usize = u16::MAX as usize;

/// An opened interface.
pub(super) struct Interface {
    pub handle: DeviceHandle<rusb::Context>,
    pub number: u8,
}

impl Drop for Interface {
    fn drop(&mut self) {
        // An unplugged device has nothing left to release.
        let _ = self.handle.release_interface(self.number);
    }
}

/// An endpoint and its packet size.
#[derive(Debug, Clone, Copy)]
pub(super) struct Endpoint {
    pub address: u8,
    pub packet: usize,
}

/// A byte link over the bulk endpoints of a USB device.
pub(super) struct UsbLink {
    framing: UsbFraming,
    command: u8,
    incoming: UnboundedReceiver<io::Result<Vec<u8>>>,
    /// Read from the device, not yet by the caller.
    unread: Vec<u8>,
    outgoing: UnboundedSender<Vec<u8>>,
    /// A frame of which a part was written.
    unsent: Vec<u8>,
    wanted: Arc<AtomicBool>,
}

impl UsbLink {
    /// Starts the threads.
    pub fn new(interface: Interface, command: Endpoint, answers: &[Endpoint], framing: UsbFraming) -> io::Result<Self> {
        let interface = Arc::new(interface);
        let wanted = Arc::new(AtomicBool::new(true));
        let (arrived, incoming) = unbounded_channel();
        let (outgoing, mut commands) = unbounded_channel::<Vec<u8>>();
        // A link that could not start all its threads must not leave some running.
        let link = Self {
            framing,
            command: command.address,
            incoming,
            unread: Vec::new(),
            outgoing,
            unsent: Vec::new(),
            wanted: Arc::clone(&wanted),
        };
        for &endpoint in answers {
            let reader = Reader {
                interface: Arc::clone(&interface),
                endpoint,
                framing,
                arrived: arrived.clone(),
            };
            let wanted = Arc::clone(&wanted);
            let name = format!("usb {:02x}", endpoint.address);
            std::thread::Builder::new()
                .name(name)
                .spawn(move || reader.run(&wanted))?;
        }
        let name = format!("usb {:02x}", command.address);
        std::thread::Builder::new().name(name).spawn(move || {
            while let Some(bytes) = commands.blocking_recv() {
                if let Err(error) = send(&interface.handle, command.address, &bytes) {
                    let _ = arrived.send(Err(error));
                    return;
                }
            }
        })?;
        Ok(link)
    }
}

impl Drop for UsbLink {
    fn drop(&mut self) {
        self.wanted.store(false, Ordering::Relaxed);
    }
}

/// Sends one transfer. A command that the instrument refuses is lost; the request then ends by its own deadline.
fn send(handle: &DeviceHandle<rusb::Context>, endpoint: u8, bytes: &[u8]) -> io::Result<()> {
    tracing::trace!(endpoint, bytes = %bytes.escape_ascii(), "sent");
    match handle.write_bulk(endpoint, bytes, SEND) {
        Ok(count) if count == bytes.len() => Ok(()),
        Ok(count) => Err(io::Error::new(
            io::ErrorKind::TimedOut,
            format!("the instrument took {count} of {} bytes within {SEND:?}", bytes.len()),
        )),
        Err(Error::Timeout) => {
            tracing::warn!(endpoint, "the instrument takes no command");
            Ok(())
        }
        Err(Error::Pipe) => {
            tracing::warn!(endpoint, "the instrument refused a command (stall)");
            handle.clear_halt(endpoint).map_err(|error| lost(error, endpoint))
        }
        Err(error) => Err(lost(error, endpoint)),
    }
}

/// What an error means for the link.
fn lost(error: Error, endpoint: u8) -> io::Error {
    match error {
        Error::NoDevice => io::Error::new(io::ErrorKind::NotConnected, "the USB device was unplugged"),
        other => io::Error::other(format!("USB endpoint 0x{endpoint:02x}: {other}")),
    }
}

struct Reader {
    interface: Arc<Interface>,
    endpoint: Endpoint,
    framing: UsbFraming,
    arrived: UnboundedSender<io::Result<Vec<u8>>>,
}

impl Reader {
    fn run(self, wanted: &AtomicBool) {
        let Endpoint { address, packet } = self.endpoint;
        // Without transfers to end it, a larger buffer would wait for a packet that nobody sends.
        let size = match self.framing {
            UsbFraming::Transfers => AT_ONCE / packet * packet,
            UsbFraming::Bytes => packet,
        };
        let mut buffer = vec![0; size];
        let mut transfer = Vec::new();
        let mut failures = 0;
        while wanted.load(Ordering::Relaxed) {
            let handle = &self.interface.handle;
            match handle.read_bulk(address, &mut buffer, WAIT) {
                Ok(count) => {
                    failures = 0;
                    transfer.extend_from_slice(&buffer[..count]);
                    // Whole packets are no end: the call ended full, or by its time with a part of a transfer.
                    let ended = count % packet != 0 || count == 0;
                    let bytes = match self.framing {
                        UsbFraming::Bytes => std::mem::take(&mut transfer),
                        UsbFraming::Transfers if ended => frame(address, &std::mem::take(&mut transfer)),
                        UsbFraming::Transfers => Vec::new(),
                    };
                    if !bytes.is_empty() && self.arrived.send(Ok(bytes)).is_err() {
                        return;
                    }
                    if transfer.len() > LONGEST {
                        let error = format!("USB endpoint 0x{address:02x} sends without an end");
                        let _ = self.arrived.send(Err(io::Error::other(error)));
                        return;
                    }
                }
                Err(Error::Timeout | Error::Interrupted) => {}
                Err(Error::NoDevice) => {
                    let _ = self.arrived.send(Err(lost(Error::NoDevice, address)));
                    return;
                }
                Err(error) => {
                    // A stall, an overflow, an error of the bus: what was collected is worth nothing.
                    tracing::warn!(endpoint = address, %error, discarded = transfer.len(), "USB");
                    transfer.clear();
                    failures += 1;
                    let cleared = match error {
                        Error::Pipe => handle.clear_halt(address),
                        _ => Ok(()),
                    };
                    if failures >= MOST_FAILURES || cleared.is_err() {
                        let _ = self.arrived.send(Err(lost(cleared.err().unwrap_or(error), address)));
                        return;
                    }
                }
            }
        }
    }
}

/// A transfer of at most 65535 bytes as a frame.
fn frame(endpoint: u8, payload: &[u8]) -> Vec<u8> {
    let payload = &payload[..payload.len().min(LONGEST)];
    let mut frame = vec![endpoint];
    frame.extend_from_slice(&(payload.len() as u16).to_le_bytes());
    frame.extend_from_slice(payload);
    frame
}

/// Takes whole frames for `endpoint` off the front of `unsent`; their payloads.
fn payloads(unsent: &mut Vec<u8>, endpoint: u8) -> io::Result<Vec<Vec<u8>>> {
    let mut found = Vec::new();
    while let &[address, low, high, ..] = &unsent[..] {
        if address != endpoint {
            let reason = format!("a frame for endpoint 0x{address:02x}: commands go to 0x{endpoint:02x}");
            return Err(io::Error::new(io::ErrorKind::InvalidInput, reason));
        }
        let end = 3 + usize::from(u16::from_le_bytes([low, high]));
        if unsent.len() < end {
            break;
        }
        found.push(unsent[3..end].to_vec());
        unsent.drain(..end);
    }
    Ok(found)
}

impl AsyncRead for UsbLink {
    fn poll_read(self: Pin<&mut Self>, cx: &mut Context<'_>, buf: &mut ReadBuf<'_>) -> Poll<io::Result<()>> {
        let this = self.get_mut();
        if this.unread.is_empty() {
            match std::task::ready!(this.incoming.poll_recv(cx)) {
                Some(Ok(bytes)) => this.unread = bytes,
                Some(Err(error)) => return Poll::Ready(Err(error)),
                None => return Poll::Ready(Ok(())),
            }
        }
        let count = this.unread.len().min(buf.remaining());
        buf.put_slice(&this.unread[..count]);
        this.unread.drain(..count);
        Poll::Ready(Ok(()))
    }
}

impl AsyncWrite for UsbLink {
    fn poll_write(self: Pin<&mut Self>, _: &mut Context<'_>, bytes: &[u8]) -> Poll<io::Result<usize>> {
        let this = self.get_mut();
        let transfers = match this.framing {
            UsbFraming::Bytes => vec![bytes.to_vec()],
            UsbFraming::Transfers => {
                this.unsent.extend_from_slice(bytes);
                match payloads(&mut this.unsent, this.command) {
                    Ok(transfers) => transfers,
                    Err(error) => return Poll::Ready(Err(error)),
                }
            }
        };
        for transfer in transfers {
            if this.outgoing.send(transfer).is_err() {
                let error = io::Error::new(io::ErrorKind::BrokenPipe, "the USB device is gone");
                return Poll::Ready(Err(error));
            }
        }
        Poll::Ready(Ok(bytes.len()))
    }

    fn poll_flush(self: Pin<&mut Self>, _: &mut Context<'_>) -> Poll<io::Result<()>> {
        Poll::Ready(Ok(()))
    }

    fn poll_shutdown(self: Pin<&mut Self>, _: &mut Context<'_>) -> Poll<io::Result<()>> {
        self.wanted.store(false, Ordering::Relaxed);
        Poll::Ready(Ok(()))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn frames_are_cut_into_transfers_wherever_they_were_written() {
        let mut unsent = Vec::new();
        let mut found = Vec::new();
        let written = [frame(1, &[0xFE]), frame(1, &[2, 0xA0, 0x86, 1, 0])].concat();
        for byte in written {
            unsent.push(byte);
            found.extend(payloads(&mut unsent, 1).unwrap());
        }
        assert_eq!(found, [vec![0xFE], vec![2, 0xA0, 0x86, 1, 0]]);
        assert!(unsent.is_empty());
        assert!(payloads(&mut vec![0x82, 1, 0, 9], 1).is_err());
    }
}
