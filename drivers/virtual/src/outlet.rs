//! The room's instruments for other programs: over TCP, and on a pty where the system has them.

use isolux_darkroom::Instrument;
use tokio::task::JoinSet;

use crate::server::{Serving, VirtualRoom};

/// Where an instrument can be reached.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Outlet {
    /// The instrument.
    pub instrument: Instrument,
    /// The driver that speaks to it.
    pub driver: &'static str,
    /// Address as a station's `open` takes it after the driver: `tcp://127.0.0.1:4001`, `/dev/pts/3`.
    pub address: String,
}

/// How instruments are offered.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Offer {
    /// On the loopback address; port 0 takes a free one.
    Tcp {
        /// The port.
        port: u16,
    },
    /// On a pseudo-terminal.
    Pty,
}

/// Offers `instruments` of `room` to other programs. With a fixed TCP port the second instrument gets the next port.
///
/// # Errors
/// The system refuses the port or the pty, or has no ptys.
pub async fn offer(
    room: &VirtualRoom,
    instruments: &[Instrument],
    offer: Offer,
) -> std::io::Result<(Vec<Outlet>, Serving)> {
    let mut tasks = JoinSet::new();
    let mut outlets = Vec::new();
    for (place, &instrument) in instruments.iter().enumerate() {
        let Some(twin) = room.twin(instrument) else { continue };
        let address = match offer {
            Offer::Tcp { port } => {
                let port = if port == 0 {
                    0
                } else {
                    port.saturating_add(place as u16)
                };
                tcp(room, instrument, port, &mut tasks).await?
            }
            Offer::Pty => pty(room, instrument, &mut tasks)?,
        };
        outlets.push(Outlet {
            instrument,
            driver: twin.driver,
            address,
        });
    }
    Ok((outlets, Serving::of(tasks)))
}

async fn tcp(
    room: &VirtualRoom,
    instrument: Instrument,
    port: u16,
    tasks: &mut JoinSet<()>,
) -> std::io::Result<String> {
    let listener = tokio::net::TcpListener::bind(("127.0.0.1", port)).await?;
    let address = format!("tcp://{}", listener.local_addr()?);
    let room = room.clone();
    tasks.spawn(async move {
        let mut open = JoinSet::new();
        // A connection that fails to be accepted is the client's loss; the listener stays.
        loop {
            if let Ok((stream, _)) = listener.accept().await {
                let _ = stream.set_nodelay(true);
                let room = room.clone();
                open.spawn(async move { room.serve(instrument, stream).await });
            }
        }
    });
    Ok(address)
}

#[cfg(unix)]
fn pty(room: &VirtualRoom, instrument: Instrument, tasks: &mut JoinSet<()>) -> std::io::Result<String> {
    use tokio_serial::SerialPort;

    // The host's end stays without a lock, so that another program can open it by its name and take one.
    let (twin, host) = tokio_serial::SerialStream::pair().map_err(std::io::Error::from)?;
    let address = host
        .name()
        .ok_or_else(|| std::io::Error::other("the pty has no name"))?;
    let room = room.clone();
    tasks.spawn(async move {
        // While this end is held, a client that closes and opens again finds the same line.
        let _held = host;
        room.serve(instrument, twin).await;
    });
    Ok(address)
}

#[cfg(not(unix))]
fn pty(_: &VirtualRoom, _: Instrument, _: &mut JoinSet<()>) -> std::io::Result<String> {
    Err(std::io::Error::new(
        std::io::ErrorKind::Unsupported,
        "this system has no ptys; offer the twin over TCP",
    ))
}
